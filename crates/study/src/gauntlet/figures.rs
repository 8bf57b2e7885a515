//! How far one image of a scene is from the truth.

use crate::metrics::{self, MetricsError};
use defocus::display::Display;
use defocus::image::{ColorImage, Image};
use glam::{UVec2, Vec3};

/// Greatest range of display values around a pixel, in [0, 1], that counts as smooth: two
/// steps of 8 bits a pixel over the neighbourhood.
pub const SMOOTH_RANGE: f32 = 8.0 / 255.0;

/// Half the side of that neighbourhood, px.
const SMOOTH_RADIUS_PX: i64 = 2;

/// What images of a scene are judged by.
pub struct Rules<'a> {
    /// The truth, linear.
    pub truth: &'a ColorImage,
    /// Where it is the pinhole image: in focus, and nothing blurred reaches there.
    pub sharp: Image<bool>,
    /// Where its display values hardly change.
    pub smooth: Image<bool>,
    /// Sum over all pixels of what the scene's lights add to the truth; `None` without
    /// lights, or where they add too little to be judged by.
    pub light: Option<f64>,
}

/// Least share of a picture's light that comes from its lights if their energy is judged:
/// with less, errors elsewhere would count as theirs.
const LEAST_LIGHT_SHARE: f64 = 0.2;

/// The differences of one image from the truth.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Figures {
    /// PSNR, dB, of display values; `None` where these are equal.
    pub psnr_db: Option<f64>,
    /// The same of the worst block of 8x8 px.
    pub worst_block_db: Option<f64>,
    /// That block's first pixel.
    pub worst_block_px: Option<[u32; 2]>,
    /// Light of the scene's lights over what it should be: 1 plus the difference of both
    /// images' sums over what the lights add.
    pub light_kept: Option<f64>,
    /// Greatest difference of display values, in [0, 1], where the truth is sharp.
    pub sharp_error: Option<f64>,
    /// The same where the truth is smooth.
    pub smooth_error: Option<f64>,
}

impl<'a> Rules<'a> {
    /// The rules of a scene with this truth and this pinhole image with its signed CoC, px.
    /// `dark_sum` is the sum of linear light over the truth of the scene without lights.
    ///
    /// # Errors
    ///
    /// Sizes that differ, and pixels that are not numbers.
    pub fn new(
        truth: &'a ColorImage,
        pinhole: &ColorImage,
        coc_px: &Image<f32>,
        dark_sum: Option<f64>,
    ) -> Result<Self, MetricsError> {
        let sharp = metrics::defocused_mask(coc_px, pinhole, truth)?.map(|defocused| !defocused);
        let shown = Display::default().encoded_image(truth);
        let smooth = Image::from_fn(truth.size, |x, y| range_around(&shown, x, y) <= SMOOTH_RANGE);
        let sum = light_sum(truth);
        let light = dark_sum.map(|dark| sum - dark).filter(|light| *light >= LEAST_LIGHT_SHARE * sum && *light > 0.0);
        Ok(Self { truth, sharp, smooth, light })
    }
}

/// The figures of `image`.
///
/// # Errors
///
/// A pixel that is no number.
pub fn figures(image: &ColorImage, rules: &Rules<'_>) -> Result<Figures, MetricsError> {
    let display = Display::default();
    let psnr = metrics::psnr(image, rules.truth, display)?;
    let errors = metrics::abs_error_map(image, rules.truth, display)?;
    let greatest = |mask: &Image<bool>| {
        let inside = errors.pixels.iter().zip(&mask.pixels).filter(|(_, inside)| **inside);
        inside.map(|(error, _)| f64::from(error.max_element())).reduce(f64::max)
    };
    let kept = |light: f64| 1.0 + (light_sum(image) - light_sum(rules.truth)) / light;
    Ok(Figures {
        psnr_db: psnr.psnr_db,
        worst_block_db: psnr.worst_block.map(|(_, db)| db),
        worst_block_px: psnr.worst_block.map(|(at, _): (UVec2, f64)| at.to_array()),
        light_kept: rules.light.map(kept),
        sharp_error: greatest(&rules.sharp),
        smooth_error: greatest(&rules.smooth),
    })
}

/// Sum of all linear values.
pub(super) fn light_sum(image: &ColorImage) -> f64 {
    image.pixels.iter().map(|p| p.as_dvec3().element_sum()).sum()
}

/// Greatest range of a channel around a pixel; the frame ends at its border.
fn range_around(image: &ColorImage, x: u32, y: u32) -> f32 {
    let around = -SMOOTH_RADIUS_PX..=SMOOTH_RADIUS_PX;
    let values = around.clone().flat_map(|dy| around.clone().map(move |dx| (dx, dy)));
    let values = values.map(|(dx, dy)| image.at_clamped(i64::from(x) + dx, i64::from(y) + dy));
    let ends = values.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    (ends.1 - ends.0).max_element()
}
