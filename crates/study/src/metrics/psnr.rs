//! Peak signal-to-noise ratio of display values, whose peak is 1.

use defocus::image::{ColorImage, Image};
use glam::UVec2;

/// Side of the blocks among which the worst is sought, px. Those at the right and bottom
/// border may be cut.
pub const BLOCK_SIDE_PX: u32 = 8;

/// Squared error of every pixel, the mean over its three channels.
pub(super) fn squared_errors(test: &ColorImage, reference: &ColorImage) -> Image<f64> {
    let pairs = test.pixels.iter().zip(&reference.pixels);
    let pixels = pairs.map(|(a, b)| (a.as_dvec3() - b.as_dvec3()).length_squared() / 3.0).collect();
    Image { size: test.size, pixels }
}

/// `10 log10(1 / mean)`; `None` where all errors are 0 or there are none.
pub(super) fn psnr_db(squared_errors: impl Iterator<Item = f64>) -> Option<f64> {
    let (count, sum) = squared_errors.fold((0_u64, 0.0), |(count, sum), error| (count + 1, sum + error));
    (sum > 0.0).then(|| -10.0 * (sum / count as f64).log10())
}

pub(super) fn masked_psnr_db(squared_errors: &Image<f64>, mask: &Image<bool>) -> Option<f64> {
    let pairs = squared_errors.pixels.iter().zip(&mask.pixels);
    psnr_db(pairs.filter(|(_, inside)| **inside).map(|(error, _)| *error))
}

/// First pixel and PSNR of the block with the lowest, the first of them where several are.
pub(super) fn worst_block(squared_errors: &Image<f64>) -> Option<(UVec2, f64)> {
    let size = squared_errors.size;
    let starts = |extent: u32| (0..extent).step_by(BLOCK_SIDE_PX as usize);
    let origins = starts(size.y).flat_map(|y| starts(size.x).map(move |x| UVec2::new(x, y)));
    let blocks = origins.filter_map(|origin| {
        let end = (origin + BLOCK_SIDE_PX).min(size);
        let pixels = (origin.y..end.y).flat_map(|y| (origin.x..end.x).map(move |x| (x, y)));
        Some((origin, psnr_db(pixels.map(|(x, y)| squared_errors.at(x, y)))?))
    });
    blocks.min_by(|a, b| a.1.total_cmp(&b.1))
}
