//! What is under way beside the interface.

use super::identity::Identity;
use defocus::gpu::PassTime;

/// A picture that is being drawn beside.
pub(super) struct Errand {
    pub(super) ticket: u64,
    /// What it will be, the lens points aside.
    pub(super) identity: Identity,
    /// Lens points that it has and will have, of one that converges.
    pub progress: Option<(u32, u32)>,
}

/// Times of a method's passes.
pub struct PassTimes {
    pub(super) ticket: u64,
    /// What was drawn.
    pub of: Identity,
    /// Medians over several runs, on a software adapter of the processor's time; `None`
    /// while they are taken.
    pub times: Option<Result<Vec<PassTime>, String>>,
}
