//! What the engine is doing, for whoever must not disturb it or be disturbed.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// A view of the engine's work from any thread; clones see the same.
#[derive(Clone, Debug, Default)]
pub struct Activity(Arc<Inner>);

#[derive(Debug, Default)]
struct Inner {
    is_busy: AtomicBool,
    frames: AtomicU64,
}

impl Activity {
    /// Whether pictures are being drawn or measured.
    pub fn is_busy(&self) -> bool {
        self.0.is_busy.load(Ordering::Acquire)
    }

    /// Frames drawn and pictures taken from beside since the start.
    pub fn frames(&self) -> u64 {
        self.0.frames.load(Ordering::Acquire)
    }

    pub(super) fn set_busy(&self, is_busy: bool) {
        self.0.is_busy.store(is_busy, Ordering::Release);
    }

    pub(super) fn count(&self) {
        self.0.frames.fetch_add(1, Ordering::AcqRel);
    }
}
