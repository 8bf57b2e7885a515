//! HDR-FLIP: Andersson, Nilsson, Shirley and Akenine-Moller, "Visualizing Errors in
//! Rendered High Dynamic Range Images" (Eurographics Short Papers 2021): the greatest
//! LDR-FLIP over the exposures at which the reference may be looked at.

use super::flip::flip_of_linear;
use super::{MetricsError, check_pair, check_pixels_per_degree};
use defocus::display::LUMINANCE;
use defocus::image::{ColorImage, Image};
use glam::{Vec3, vec3};

/// The tone map between exposures and FLIP, a quotient of quadratics (numerator,
/// denominator; squares first): Narkowicz's fit of ACES with its exposure of 0.6 taken
/// out again, the paper's default.
const ACES: (Vec3, Vec3) = (vec3(0.36 * 2.51, 0.6 * 0.03, 0.0), vec3(0.36 * 2.43, 0.6 * 0.59, 0.14));

/// Tone-mapped luminance that the brightest pixel has at the first exposure and the median
/// at the last.
const TARGET: f32 = 0.85;

/// HDR-FLIP error of every pixel, in [0, 1], of two linear HDR images; `None` for a
/// reference without any light. Negative values count as 0.
///
/// The exposures are the reference's, a stop apart or less. Errors as
/// [`flip_map`](super::flip_map).
pub fn hdr_flip_map(
    test: &ColorImage,
    reference: &ColorImage,
    pixels_per_degree: f32,
) -> Result<Option<Image<f32>>, MetricsError> {
    check_pair("test image", test, reference)?;
    check_pixels_per_degree(pixels_per_degree)?;
    let Some(exposures) = exposures_ev(reference) else { return Ok(None) };
    let mut worst = Image::filled(reference.size, 0.0_f32);
    for ev in exposures {
        let shown = |image: &ColorImage| image.map(|p| aces(p.max(Vec3::ZERO) * ev.exp2()));
        let map = flip_of_linear(&shown(test), &shown(reference), pixels_per_degree);
        worst.pixels.iter_mut().zip(&map.pixels).for_each(|(worst, error)| *worst = worst.max(*error));
    }
    Ok(Some(worst))
}

fn aces(color: Vec3) -> Vec3 {
    let quadratic = |k: Vec3| color * color * k.x + color * k.y + k.z;
    (quadratic(ACES.0) / quadratic(ACES.1)).clamp(Vec3::ZERO, Vec3::ONE)
}

/// From where the brightest luminance is shown as [`TARGET`] to where the median is.
fn exposures_ev(reference: &ColorImage) -> Option<Vec<f32>> {
    let mut luminances: Vec<f32> = reference.pixels.iter().map(|p| p.max(Vec3::ZERO).dot(LUMINANCE)).collect();
    luminances.sort_unstable_by(f32::total_cmp);
    let brightest = luminances[luminances.len() - 1];
    if brightest <= 0.0 {
        return None;
    }
    // The mean of the two middle ones as the authors' program takes them; it bounds a
    // black median by the spacing of floats at 1, and so the number of exposures.
    let middle = (luminances.len() / 2).max(1);
    let median = 0.5 * (luminances[middle - 1] + luminances[middle.min(luminances.len() - 1)]);
    let shown_as_target = aces_inverse(TARGET);
    let start = (shown_as_target / brightest).log2();
    let stop = (shown_as_target / median.max(f32::EPSILON)).log2().max(start);
    let count = (stop - start).ceil().max(2.0);
    Some((0..count as u32).map(|i| start + i as f32 * (stop - start) / (count - 1.0)).collect())
}

/// The positive value that [`aces`] takes to `shown`.
fn aces_inverse(shown: f32) -> f32 {
    let k = ACES.0 - shown * ACES.1;
    let half = -0.5 * k.y / k.x;
    half + (half * half - k.z / k.x).sqrt()
}
