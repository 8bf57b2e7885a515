//! How far an image is from the truth.
//!
//! Images are linear HDR. PSNR, SSIM and FLIP judge what a display shows of them
//! ([`Display`]: exposure, tone map, clamped to [0, 1], not quantised); relative MSE
//! and HDR-FLIP judge the linear values. JOD judges what an eye sees of it on a display of
//! known size and luminance ([`Viewing`]), and [`Visibility`] says that in words. A value that does not exist is `None`, never 0
//! or infinity.

mod flip;
mod hdr_flip;
mod jod;
mod psnr;
mod ssim;
mod visibility;

pub use flip::{DEFAULT_PIXELS_PER_DEGREE, flip_map};
pub use hdr_flip::hdr_flip_map;
pub use jod::{JodMap, PERFECT_JOD, jod, jod_map};
pub use psnr::BLOCK_SIDE_PX;
pub use visibility::{Visibility, share_who_see};

use defocus::display::Display;
use defocus::image::{ColorImage, Image};
use defocus::viewing::{PX_PER_DEGREE, ScreenError, Viewing};
use glam::{UVec2, Vec3};
use rayon::prelude::*;

/// Added to the squared reference in the relative MSE: pixels darker than a tenth of
/// white then count by their absolute difference, so that noise in the dark does not
/// outweigh the picture. The form is that of Rousselle, Knaus and Zwicker,
/// "Adaptive Sampling and Reconstruction using Greedy Error Minimization"
/// (SIGGRAPH Asia 2011).
pub const REL_MSE_EPSILON: f64 = 1e-2;

/// What to compare, and how.
#[derive(Clone, Copy, Debug)]
pub struct CompareOptions<'a> {
    /// How both images are shown.
    pub display: Display,
    /// Pixels that count for [`Metrics::psnr_defocused_db`]; see [`defocused_mask`].
    pub defocused: Option<&'a Image<bool>>,
    /// Under what angle and in what light both are looked at: that of FLIP and of JOD.
    pub viewing: Viewing,
    /// Whether to compute the JOD, which takes about as long as all other metrics together.
    pub jod: bool,
    /// Whether to compute HDR-FLIP, which costs as much as FLIP for every stop of the
    /// reference's exposure range.
    pub hdr_flip: bool,
}

impl Default for CompareOptions<'_> {
    fn default() -> Self {
        Self { display: Display::default(), defocused: None, viewing: Viewing::default(), jod: true, hdr_flip: false }
    }
}

/// The differences between two images.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Metrics {
    /// Whether all linear pixels are equal.
    pub identical: bool,
    /// Peak signal-to-noise ratio, dB, over R, G and B of the encoded display values;
    /// `None` where these are all equal.
    pub psnr_db: Option<f64>,
    /// The same over the pixels of the mask only; `None` also without such pixels.
    pub psnr_defocused_db: Option<f64>,
    /// Mean structural similarity of the luma, 1 for equal images; `None` for an image
    /// smaller than its window of 11 px.
    pub ssim: Option<f64>,
    /// Mean of the FLIP map, in [0, 1], 0 for equal images.
    pub flip: f64,
    /// Pixels per degree at which FLIP and JOD looked at the images.
    pub px_per_degree: f64,
    /// Quality by ColorVideoVDP, JOD, 10 for equal images; `None` where it was not asked for
    /// and for an image smaller than 4 px.
    pub jod: Option<f64>,
    /// Mean of the HDR-FLIP map, if asked for; `None` also for a black reference, which
    /// has no exposure range.
    pub hdr_flip: Option<f64>,
    /// Relative mean squared error, see [`rel_mse`].
    pub rel_mse: f64,
    /// PSNR, dB, of the worst block of [`BLOCK_SIDE_PX`] squared; `None` as `psnr_db`.
    pub worst_block_psnr_db: Option<f64>,
    /// That block's first pixel (x, y).
    pub worst_block: Option<UVec2>,
}

/// [`Metrics::psnr_db`] and [`Metrics::worst_block_psnr_db`] alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Psnr {
    /// Over all pixels, dB; `None` where all display values are equal.
    pub psnr_db: Option<f64>,
    /// First pixel and PSNR, dB, of the worst block; `None` as `psnr_db`.
    pub worst_block: Option<(UVec2, f64)>,
}

/// Why two images cannot be compared.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MetricsError {
    /// Two sizes.
    #[error("the {what} is {} x {} px and the reference {} x {} px: metrics need images of one size",
        size.x, size.y, reference.x, reference.y)]
    SizesDiffer {
        /// Which image is not of the reference's size.
        what: &'static str,
        /// Its size.
        size: UVec2,
        /// The reference's size.
        reference: UVec2,
    },
    /// No pixels.
    #[error("the images have no pixels: there is nothing to compare")]
    Empty,
    /// NaN or infinity.
    #[error("the {what} has {count} pixels with NaN or infinity, the first at ({}, {}): \
        metrics need finite images", first.x, first.y)]
    NotFinite {
        /// Which image.
        what: &'static str,
        /// How many pixels.
        count: usize,
        /// The first of them.
        first: UVec2,
    },
    /// An angular resolution that FLIP's filters are not built for.
    #[error("{0} pixels per degree: FLIP and JOD are computed for 1 to 500; give another with --ppd")]
    PixelsPerDegree(f32),
    /// A display that cannot be.
    #[error(transparent)]
    Screen(#[from] ScreenError),
    /// ColorVideoVDP has no answer.
    #[error("ColorVideoVDP: {0}; choose other luminances of the display")]
    Jod(String),
}

/// Compares `test` with `reference`, both linear HDR.
///
/// Errors if the sizes differ or are 0, if a pixel is not finite, or if the angular
/// resolution lies outside [`PX_PER_DEGREE`].
pub fn compare(test: &ColorImage, reference: &ColorImage, options: &CompareOptions) -> Result<Metrics, MetricsError> {
    check_pair("test image", test, reference)?;
    check_pixels_per_degree(options.viewing.px_per_degree as f32)?;
    if let Some(mask) = options.defocused.filter(|mask| mask.size != reference.size) {
        return Err(MetricsError::SizesDiffer { what: "mask", size: mask.size, reference: reference.size });
    }
    let display = options.display;
    let (shown, shown_reference) = (display.encoded_image(test), display.encoded_image(reference));
    let errors = psnr::squared_errors(&shown, &shown_reference);
    let worst = psnr::worst_block(&errors);
    let pixels_per_degree = options.viewing.px_per_degree as f32;
    let flip = flip_map(test, reference, display, pixels_per_degree)?;
    let hdr_flip = if options.hdr_flip { hdr_flip_map(test, reference, pixels_per_degree)? } else { None };
    let jod = if options.jod { jod(test, reference, display, &options.viewing)? } else { None };
    Ok(Metrics {
        identical: test.pixels == reference.pixels,
        psnr_db: psnr::psnr_db(errors.pixels.iter().copied()),
        psnr_defocused_db: options.defocused.and_then(|mask| psnr::masked_psnr_db(&errors, mask)),
        ssim: ssim::mean_ssim(&shown, &shown_reference),
        flip: mean(&flip),
        px_per_degree: options.viewing.px_per_degree,
        jod,
        hdr_flip: hdr_flip.map(|map| mean(&map)),
        rel_mse: rel_mse(test, reference)?,
        worst_block_psnr_db: worst.map(|(_, psnr_db)| psnr_db),
        worst_block: worst.map(|(origin, _)| origin),
    })
}

/// The PSNR of `test` against `reference`, both linear HDR, as `display` shows them: what
/// [`compare`] says of it, for a small part of the time.
///
/// Errors if the sizes differ or are 0, or if a pixel is not finite.
pub fn psnr(test: &ColorImage, reference: &ColorImage, display: Display) -> Result<Psnr, MetricsError> {
    check_pair("test image", test, reference)?;
    let errors = psnr::squared_errors(&display.encoded_image(test), &display.encoded_image(reference));
    let psnr_db = psnr::psnr_db(errors.pixels.iter().copied());
    Ok(Psnr { psnr_db, worst_block: psnr::worst_block(&errors) })
}

/// Relative mean squared error of linear HDR values over pixels and channels:
/// `mean((a - b)^2 / (b^2 + eps))`, eps = [`REL_MSE_EPSILON`], b the reference.
pub fn rel_mse(test: &ColorImage, reference: &ColorImage) -> Result<f64, MetricsError> {
    check_pair("test image", test, reference)?;
    let of_pixel = |(a, b): (&Vec3, &Vec3)| {
        let (a, b) = (a.as_dvec3(), b.as_dvec3());
        ((a - b) * (a - b) / (b * b + REL_MSE_EPSILON)).element_sum()
    };
    let sum: f64 = test.pixels.iter().zip(&reference.pixels).map(of_pixel).sum();
    Ok(sum / (3.0 * test.pixels.len() as f64))
}

/// Absolute differences of the encoded display values, channel by channel, in [0, 1].
pub fn abs_error_map(test: &ColorImage, reference: &ColorImage, display: Display) -> Result<ColorImage, MetricsError> {
    check_pair("test image", test, reference)?;
    let pairs = test.pixels.par_iter().zip(&reference.pixels);
    let pixels = pairs.map(|(a, b)| (display.encoded(*a) - display.encoded(*b)).abs()).collect();
    Ok(ColorImage { size: test.size, pixels })
}

/// Pixels for [`Metrics::psnr_defocused_db`]: blurred in the pinhole image (|c| >= 1 px)
/// or changed by the blur of something else (the reference differs from the pinhole
/// image). Pixels in focus are equal in every method and inflate the whole-image figure.
///
/// `coc_diameter_px` is the signed CoC of the pinhole image's depth. Errors if the sizes
/// differ.
pub fn defocused_mask(
    coc_diameter_px: &Image<f32>,
    pinhole: &ColorImage,
    reference: &ColorImage,
) -> Result<Image<bool>, MetricsError> {
    check_pair("pinhole image", pinhole, reference)?;
    if coc_diameter_px.size != reference.size {
        let (size, reference) = (coc_diameter_px.size, reference.size);
        return Err(MetricsError::SizesDiffer { what: "CoC image", size, reference });
    }
    let differs = |a: Vec3, b: Vec3| {
        // The spacing of half floats, in which images may have been stored.
        (a - b).abs().cmpgt(b.abs() * (1.0 / 1024.0)).any()
    };
    let pixel = |i: usize| coc_diameter_px.pixels[i].abs() >= 1.0 || differs(pinhole.pixels[i], reference.pixels[i]);
    Ok(Image { size: reference.size, pixels: (0..reference.pixels.len()).map(pixel).collect() })
}

fn check_pair(what: &'static str, test: &ColorImage, reference: &ColorImage) -> Result<(), MetricsError> {
    if test.size != reference.size {
        return Err(MetricsError::SizesDiffer { what, size: test.size, reference: reference.size });
    }
    if reference.pixels.is_empty() {
        return Err(MetricsError::Empty);
    }
    check_finite(what, test)?;
    check_finite("reference", reference)
}

fn check_finite(what: &'static str, image: &ColorImage) -> Result<(), MetricsError> {
    let count = image.pixels.iter().filter(|p| !p.is_finite()).count();
    match image.pixels.iter().position(|p| !p.is_finite()) {
        None => Ok(()),
        Some(i) => {
            let first = UVec2::new(i as u32 % image.size.x, i as u32 / image.size.x);
            Err(MetricsError::NotFinite { what, count, first })
        }
    }
}

fn check_pixels_per_degree(pixels_per_degree: f32) -> Result<(), MetricsError> {
    if PX_PER_DEGREE.contains(&f64::from(pixels_per_degree)) {
        return Ok(());
    }
    Err(MetricsError::PixelsPerDegree(pixels_per_degree))
}

fn mean(map: &Image<f32>) -> f64 {
    map.pixels.iter().map(|p| f64::from(*p)).sum::<f64>() / map.pixels.len() as f64
}
