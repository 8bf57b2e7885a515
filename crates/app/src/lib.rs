//! What the program `defocus` has beside its command line: the [`window`], with the feature of
//! that name.

#[cfg(feature = "window")]
pub mod window;
