//! Run time against error: every method, with every value of the parameters by which it
//! trades one for the other, on many scenes, sizes and amounts of blur.
//!
//! A [`Plan`] has *cells* (scene, size, blur). In a cell all *variants* (methods with
//! parameters) are measured together by [`compare`](super::compare::compare()): in turn,
//! round after round, with a copy of the same image before each, so that a machine that
//! slows down meanwhile slows all of them. Times are given in ms, which belong to one
//! adapter, and as multiples of the copy's time, which can be compared more widely.

pub mod lead;
pub mod plan;
pub mod plot;
pub mod report;
pub mod results;
mod run;
mod store;
pub mod tables;

pub use plan::{Blur, Cell, Plan, Shard, Variant};
pub use results::{BenchResults, CellResult, VariantResult};
pub use run::{BenchError, BenchOutcome, BenchRun};
pub use store::{Store, StoreError};
pub use tables::PaperTable;
