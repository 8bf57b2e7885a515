//! Pictures that get better over many frames.

use defocus::gpu::Frame;
use defocus::lens::Lens;
use defocus::methods::{self, Converging, Method};
use defocus::view::View;

/// A run with its goal.
pub(super) struct Progressive {
    pub run: Box<dyn Converging>,
    pub samples: u32,
}

/// A run for the method that converges over many frames, where there is blur to converge.
pub(super) fn progressive(
    method: &dyn Method,
    frame: &mut Frame<'_>,
    view: &mut View,
    lens: &Lens,
) -> Option<Progressive> {
    let (run, samples) = methods::converging(method, lens)?;
    let lenses = lens.primaries().map_or_else(|| vec![lens.clone()], Vec::from);
    lenses.iter().any(|lens| methods::is_blurred(frame, view, lens)).then_some(Progressive { run, samples })
}

/// Whether a power of two lies between the lens points shown last and `count`.
pub(super) fn passed_power_of_two(last: Option<u32>, count: u32) -> bool {
    last.is_none_or(|before| before.ilog2() < count.ilog2())
}
