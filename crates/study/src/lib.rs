//! What the instrument does with its parts: opens something to look at, renders it with
//! every method, and measures how far each is from the truth and what it costs.

pub mod advise;
pub mod bench;
pub mod builtin;
pub mod cache;
pub mod compare;
pub mod curves;
pub mod devices;
pub mod flicker;
pub mod gauntlet;
pub mod inside;
pub mod meter;
pub mod metrics;
pub mod profile;
pub mod psf;
pub mod random;
pub mod reference;
pub mod render;
pub mod report;
pub mod results;
pub mod scale;
pub mod source;
pub mod steps;
pub mod stress;
pub mod table;
pub mod timing;

pub use compare::{CompareRequest, Comparison, MethodResult};
pub use inside::{InsideImage, look_inside};
pub use reference::{Reference, ReferenceRequest, Truth};
pub use render::{Rendered, render};
pub use source::{DepthArgs, GpuSource, Source, SourceError};

use std::ops::ControlFlow;

/// How far a long piece of work has come.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    /// What is being worked on, such as a method's id.
    pub what: &'a str,
    /// Units of work done.
    pub done: u32,
    /// Units of work in all.
    pub of: u32,
}

/// Told about every step, often enough to be stopped promptly; `Break` stops the work.
pub type Progress<'a> = dyn FnMut(Step<'_>) -> ControlFlow<()> + 'a;

/// Why a study has no result.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The progress callback asked to stop.
    #[error("stopped before it was done")]
    Stopped,
    /// A method cannot render the view.
    #[error("{method}: {source}")]
    Method {
        /// The method's id.
        method: &'static str,
        /// Cause and remedy.
        source: defocus::methods::MethodError,
    },
    /// The view cannot be drawn.
    #[error(transparent)]
    View(#[from] defocus::view::ViewError),
    /// What to look at cannot be opened.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// The scene cannot be traced.
    #[error(transparent)]
    Ray(#[from] defocus::raytrace::RayError),
    /// An image of a method that cannot be compared.
    #[error("{method}: {source}")]
    Metrics {
        /// The method's id.
        method: &'static str,
        /// Cause and remedy.
        source: metrics::MetricsError,
    },
    /// A reference that needs a scene was asked of an image.
    #[error(
        "an image with depth has no {reference} reference, since nothing is known of what its surfaces hide: leave out --reference to measure times only, or name a method that needs the image alone"
    )]
    ImageHasNoReference {
        /// The reference's id.
        reference: &'static str,
    },
}

/// Tells `progress`; an error if it asks to stop.
fn step(progress: &mut Progress<'_>, what: &str, done: u32, of: u32) -> Result<(), StudyError> {
    match progress(Step { what, done, of }) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(StudyError::Stopped),
    }
}
