//! Frames on their way through the GPU.

use crate::window::model::PaneId;
use defocus::gpu::Timings;
use std::ops::Range;
use std::time::Instant;

/// A submitted frame whose times have not arrived.
pub(super) struct InFlight {
    pub parts: Vec<Part>,
    pub timings: Timings,
    pub cpu_ms: f64,
    pub since: Instant,
    /// Mean blur of the full pictures, px.
    pub blur_px: f64,
}

/// Which passes of a frame are a pane's.
pub(super) struct Part {
    pub pane: PaneId,
    /// How many times smaller than in full it is.
    pub divisor: u32,
    /// Lens points drawn, of a reference.
    pub views: u32,
    pub passes: Range<usize>,
}
