//! The small scenes and lenses of the library's tests, and the window.

#![allow(dead_code, unused_imports, reason = "every test binary compiles this module and uses its own part of it")]

#[path = "../../../../tests/common/mod.rs"]
mod library;
#[cfg(feature = "window")]
pub mod window;

pub use library::*;
