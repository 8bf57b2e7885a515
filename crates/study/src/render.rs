//! One image by one method, with what it cost.

use super::StudyError;
use defocus::gpu::{FrameStats, Gpu, PassTime, download};
use defocus::image::ColorImage;
use defocus::lens::Lens;
use defocus::methods::{self, Method};
use defocus::view::View;

/// An image with the passes that made it.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// Linear, of the view's inner size.
    pub color: ColorImage,
    /// GPU times of its passes in order, those of the view included where it had to be drawn.
    pub passes: Vec<PassTime>,
    /// What was drawn and what was not needed.
    pub stats: FrameStats,
}

impl Rendered {
    /// Sum of the passes' GPU times, ms.
    pub fn gpu_ms(&self) -> Option<f64> {
        gpu_ms(&self.passes, &self.stats)
    }
}

/// Renders `view` through `lens` with `method` and waits for it.
///
/// # Errors
///
/// What the method says.
pub fn render(gpu: &Gpu, view: &mut View, lens: &Lens, method: &dyn Method) -> Result<Rendered, StudyError> {
    let mut frame = gpu.timed_frame();
    let texture = methods::record(method, &mut frame, view, lens)
        .map_err(|source| StudyError::Method { method: method.about().id, source })?;
    let submitted = frame.finish();
    let passes = submitted.timings.wait();
    Ok(Rendered { color: download(gpu, &texture), passes, stats: submitted.stats })
}

/// Sum of the passes' GPU times, ms, 0 where nothing had to be done; `None` without
/// timestamps, and where there were more passes than could be timed: the sum would be too
/// small.
pub(super) fn gpu_ms(passes: &[PassTime], stats: &FrameStats) -> Option<f64> {
    let all_timed = passes.len() as u64 == stats.passes;
    all_timed.then(|| passes.iter().map(|pass| pass.ms).sum())
}
