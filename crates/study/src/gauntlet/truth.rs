//! A reference that gets more lens points until it agrees with itself.

use crate::StudyError;
use crate::metrics;
use defocus::display::Display;
use defocus::gpu::{Gpu, download};
use defocus::image::ColorImage;
use defocus::lens::Lens;
use defocus::methods::{AccumulationRun, Converging};
use defocus::view::View;

/// Lens points that a reference begins with.
pub const LEAST_POINTS: u32 = 256;

/// Lens points at which it ends, whether it agrees or not.
pub const MOST_POINTS: u32 = 16384;

/// PSNR, dB, of the two halves of the lens points against each other from which on they
/// agree. The mean of both is then some 6 dB closer to the truth: what is counted up to 50
/// dB is measured with one that is right to 56.
pub const AGREEMENT_DB: f64 = 50.0;

/// Views submitted at once: enough that waiting for them costs little.
const VIEWS_AT_ONCE: u32 = 64;

/// A reference.
#[derive(Clone, Debug)]
pub struct Agreed {
    /// Linear, of the view's inner size.
    pub color: ColorImage,
    /// Lens points of it.
    pub points: u32,
    /// PSNR, dB, of its halves against each other; `None` where they are equal.
    pub halves_db: Option<f64>,
}

impl Agreed {
    /// Whether its halves agree.
    pub fn agrees(&self) -> bool {
        self.halves_db.is_none_or(|db| db >= AGREEMENT_DB)
    }
}

/// Accumulates `view` through `lens` until two halves of the lens points agree, with at
/// least and at most so many points; both are rounded up to powers of two.
///
/// # Errors
///
/// A lens that forms no image, a view of an image.
pub fn truth(gpu: &Gpu, view: &mut View, lens: &Lens, least: u32, most: u32) -> Result<Agreed, StudyError> {
    let failed = |source| StudyError::Method { method: "accumulation", source };
    lens.check().map_err(|e| failed(e.into()))?;
    let mut run = AccumulationRun::new(false);
    let mut wanted = least.max(2).next_power_of_two();
    loop {
        while run.count() < wanted {
            let mut frame = gpu.frame();
            run.advance(&mut frame, view, lens, VIEWS_AT_ONCE.min(wanted - run.count())).map_err(failed)?;
            frame.finish().timings.wait();
        }
        let halves_db = run.halves(gpu).map(|[a, b]| metrics::psnr(&a, &b, Display::default()));
        let halves_db =
            halves_db.transpose().map_err(|source| StudyError::Metrics { method: "accumulation", source })?;
        let halves_db = halves_db.and_then(|psnr| psnr.psnr_db);
        if wanted >= most || halves_db.is_none_or(|db| db >= AGREEMENT_DB) {
            let mut frame = gpu.frame();
            let mean = run.mean(&mut frame);
            frame.finish();
            return Ok(Agreed { color: download(gpu, &mean), points: run.count(), halves_db });
        }
        wanted *= 2;
    }
}
