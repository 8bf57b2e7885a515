//! What the instrument does with its parts: opens something to look at, renders it with
//! every method, and measures how far each is from the truth and what it costs.

pub mod source;

pub use source::{DepthArgs, GpuSource, Source, SourceError};
