//! How the engine shares time with the interface.

use super::pace::BUDGET_MS;
use std::time::Duration;

/// What all panes together may take in a frame before those not under the pointer are
/// rendered less often, ms: the refresh interval of a display of 60 Hz.
pub const DISPLAY_INTERVAL_MS: f64 = 1000.0 / 60.0;

/// GPU time that a step of a progressive reference may take, ms: at 60 Hz two refreshes,
/// so that the interface stays smooth beside it.
pub(super) const STEP_BUDGET_MS: f64 = 30.0;

/// How long pictures must rest before they are measured, which takes all cores.
const REST: Duration = Duration::from_millis(250);

/// How the engine shares time with the interface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tempo {
    /// What a frame may take for pictures, ms: what takes longer is drawn smaller at first,
    /// and in full beside the interface.
    pub budget_ms: f64,
    /// How long pictures must rest before they are measured, which takes all cores.
    pub rest: Duration,
}

impl Default for Tempo {
    fn default() -> Self {
        Self { budget_ms: BUDGET_MS, rest: REST }
    }
}
