//! ColorVideoVDP: Mantiuk, Hanji, Ashraf, Asano and Chapiro, "ColorVideoVDP: A Visual
//! Difference Predictor for Image, Video and Display Distortions" (SIGGRAPH 2024), by the
//! crate `colorvideovdp`, a port of the authors' model v0.5.7.

use super::MetricsError;
use colorvideovdp::{Color, Cvvdp, DisplayModel, Geometry, Options, Photometry};
use defocus::display::Display;
use defocus::image::{ColorImage, Image};
use defocus::viewing::{Screen, Viewing};
use glam::Vec3;
use rayon::prelude::*;

/// Quality of an image equal to its reference, JOD: the top of the scale.
pub const PERFECT_JOD: f64 = 10.0;

/// Least side of an image that the metric is computed for, px.
const LEAST_SIDE_PX: u32 = 4;

/// Darkest black, cd/m2, as a share of the peak: contrasts beyond are all alike to the model,
/// which takes a finite one.
const LEAST_BLACK_SHARE: f64 = 1e-7;

/// How different two pictures look, in just-objectionable differences.
#[derive(Clone, Debug, PartialEq)]
pub struct JodMap {
    /// Quality, JOD: 10 for equal pictures, less for visible differences, below 0 for
    /// pictures that have nothing in common.
    pub jod: f64,
    /// By pixel, the quality that is lost there as a share of the scale: 0 for none, 0.1 for
    /// 1 JOD.
    pub map: Image<f32>,
}

/// Quality of `test` against `reference`, both linear HDR, as `display` turns them into
/// display values and as they are looked at, JOD; `None` for an image smaller than 4 px.
///
/// # Errors
///
/// Two sizes, no pixels, a pixel that is not finite, a display that cannot be.
pub fn jod(
    test: &ColorImage,
    reference: &ColorImage,
    display: Display,
    viewing: &Viewing,
) -> Result<Option<f64>, MetricsError> {
    Ok(predicted(test, reference, display, viewing, false)?.map(|p| f64::from(p.jod)))
}

/// As [`jod`], with the difference at every pixel.
///
/// # Errors
///
/// As [`jod`].
pub fn jod_map(
    test: &ColorImage,
    reference: &ColorImage,
    display: Display,
    viewing: &Viewing,
) -> Result<Option<JodMap>, MetricsError> {
    let Some(predicted) = predicted(test, reference, display, viewing, true)? else { return Ok(None) };
    let jod = f64::from(predicted.jod);
    let pixels = predicted.distortion_map.map(|map| map.data).unwrap_or_default();
    Ok(Some(JodMap { jod, map: Image { size: reference.size, pixels } }))
}

fn predicted(
    test: &ColorImage,
    reference: &ColorImage,
    display: Display,
    viewing: &Viewing,
    with_map: bool,
) -> Result<Option<colorvideovdp::Prediction>, MetricsError> {
    super::check_pair("test image", test, reference)?;
    super::check_pixels_per_degree(viewing.px_per_degree as f32)?;
    viewing.screen.check()?;
    if reference.size.min_element() < LEAST_SIDE_PX {
        return Ok(None);
    }
    let failed = |error: colorvideovdp::Error| MetricsError::Jod(error.to_string());
    let (test, color) = shown(test, display, &viewing.screen);
    let (reference, _) = shown(reference, display, &viewing.screen);
    // The limit is there for servers: what the picture needs it needs.
    let options = Options::default().with_distortion_map(with_map).with_memory_limit_bytes(usize::MAX);
    let metric = Cvvdp::new(model(viewing).map_err(failed)?, options).map_err(failed)?;
    let image = |pixels: ColorImage| {
        let size = pixels.size.as_usizevec2();
        let samples: Vec<f32> =
            bytemuck::cast_vec::<[f32; 3], f32>(pixels.pixels.iter().map(|p| p.to_array()).collect());
        colorvideovdp::Image::new(size.x, size.y, 3, samples)
    };
    let (test, reference) = (image(test).map_err(failed)?, image(reference).map_err(failed)?);
    metric.predict_image(&test, &reference, color).map(Some).map_err(failed)
}

/// A picture as the metric takes it: encoded for a display of white at most, in cd/m2 for one
/// of high dynamic range.
fn shown(image: &ColorImage, display: Display, screen: &Screen) -> (ColorImage, Color) {
    if !screen.hdr {
        return (display.encoded_image(image), Color::Srgb);
    }
    let white = screen.white_cd_m2() as f32;
    let emitted = |c: &Vec3| display.unclamped(*c).max(Vec3::ZERO) * white;
    // Beyond f32 there is nothing brighter than the peak either.
    let pixels = image.pixels.par_iter().map(|c| emitted(c).min(Vec3::splat(screen.peak_cd_m2 as f32))).collect();
    (ColorImage { size: image.size, pixels }, Color::Linear)
}

fn model(viewing: &Viewing) -> colorvideovdp::Result<DisplayModel> {
    let screen = &viewing.screen;
    let contrast = screen.peak_cd_m2 / screen.black_cd_m2.max(LEAST_BLACK_SHARE * screen.peak_cd_m2);
    let photometry =
        Photometry::new(screen.peak_cd_m2, contrast.max(1.0), screen.ambient_lux, Screen::reflectivity(), 1.0)?;
    // The resolution of the whole display does not enter.
    let geometry = Geometry::from_ppd([1, 1], viewing.px_per_degree)?;
    DisplayModel::new("defocus", photometry, geometry, "sRGB")
}
