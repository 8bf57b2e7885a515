//! A batch: states that are compared with their references one after the other, beside the
//! interface.

mod run;
mod window;

pub use window::Batch;
