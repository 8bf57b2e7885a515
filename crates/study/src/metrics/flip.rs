//! LDR-FLIP: Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom and Fairchild, "FLIP: A
//! Difference Evaluator for Alternating Images" (HPG 2020), with the separable form of its
//! filters from the authors' `separatedConvolutions.pdf`.

use super::{MetricsError, check_pair, check_pixels_per_degree};
use defocus::display::Display;
use defocus::image::{ColorImage, Image};
use glam::{DVec4, Mat3, Vec2, Vec3, Vec4, vec2, vec3, vec4};
use rayon::prelude::*;
use std::f64::consts::PI;

/// The paper's viewer: 0.7 m before a display of 3840 px on 0.7 m, 3840 pi / 180 px per degree.
pub const DEFAULT_PIXELS_PER_DEGREE: f32 = defocus::viewing::FLIP_PX_PER_DEGREE as f32;

/// Exponent of the colour difference.
const QC: f32 = 0.7;
/// Share of the greatest colour difference up to which differences are stretched ...
const PC: f32 = 0.4;
/// ... and the error it is stretched to.
const PT: f32 = 0.95;
/// Exponent of the feature difference.
const QF: f32 = 0.5;
/// Width of the edge and point detectors, degrees.
const FEATURE_WIDTH_DEG: f64 = 0.082;
/// Contrast sensitivity as sums of Gaussians (a, b) with the visual angle in degrees:
/// achromatic, red-green, and the two of blue-yellow.
const CSF_Y: (f64, f64) = (1.0, 0.0047);
const CSF_CX: (f64, f64) = (1.0, 0.0053);
const CSF_CZ: [(f64, f64); 2] = [(34.1, 0.04), (13.5, 0.025)];

/// XYZ of linear sRGB, as in the authors' program (columns).
const XYZ_FROM_RGB: Mat3 = Mat3::from_cols(
    vec3(0.412_386_57, 0.212_636_82, 0.019_330_62),
    vec3(0.357_591_5, 0.715_183, 0.119_197_17),
    vec3(0.180_450_5, 0.072_180_2, 0.950_372_6),
);

/// FLIP error of every pixel, in [0, 1], of two linear HDR images as `display` shows
/// them, seen at `pixels_per_degree`.
///
/// Errors if the sizes differ, a pixel is not finite or the resolution is out of range.
pub fn flip_map(
    test: &ColorImage,
    reference: &ColorImage,
    display: Display,
    pixels_per_degree: f32,
) -> Result<Image<f32>, MetricsError> {
    check_pair("test image", test, reference)?;
    check_pixels_per_degree(pixels_per_degree)?;
    Ok(flip_of_linear(&display.linear_image(test), &display.linear_image(reference), pixels_per_degree))
}

/// FLIP of linear display values in [0, 1].
pub(super) fn flip_of_linear(test: &ColorImage, reference: &ColorImage, pixels_per_degree: f32) -> Image<f32> {
    let (test, reference) = (opponent(test), opponent(reference));
    let spatial = spatial_filter(f64::from(pixels_per_degree));
    let feature = FeatureFilters::new(f64::from(pixels_per_degree));
    let color = (perceived_lab(&test, &spatial), perceived_lab(&reference, &spatial));
    let features = (feature.strengths(&test), feature.strengths(&reference));
    let remap = ColorDifference::new();
    let error = |i: usize| {
        let color = remap.of(color.0[i], color.1[i]);
        // The stronger of edge and point difference.
        let difference = (features.0[i] - features.1[i]).abs().max_element();
        let feature = (difference * std::f32::consts::FRAC_1_SQRT_2).powf(QF);
        // Features raise the colour difference.
        color.powf(1.0 - feature)
    };
    Image { size: test.size, pixels: (0..color.0.len()).into_par_iter().map(error).collect() }
}

/// Pixels in the linear opponent space YCxCz, Cz twice: a filter of four
/// channels then serves both summands of its sensitivity.
fn opponent(linear: &ColorImage) -> Image<Vec4> {
    let white = XYZ_FROM_RGB * Vec3::ONE;
    let convert = |rgb: &Vec3| {
        let xyz = XYZ_FROM_RGB * *rgb / white;
        let cz = 200.0 * (xyz.y - xyz.z);
        vec4(116.0 * xyz.y - 16.0, 500.0 * (xyz.x - xyz.y), cz, cz)
    };
    Image { size: linear.size, pixels: linear.pixels.par_iter().map(convert).collect() }
}

/// Contrast sensitivity as a filter, the same along rows and columns.
fn spatial_filter(pixels_per_degree: f64) -> Vec<Vec4> {
    // Three standard deviations of the widest.
    let radius = (3.0 * (CSF_CZ[0].1 / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i32;
    let gaussian = |b: f64, factor: f64| -> Vec<f64> {
        let angle = |i: i32| f64::from(i) / pixels_per_degree;
        (-radius..=radius).map(|i| factor * (-PI * PI * angle(i).powi(2) / b).exp()).collect()
    };
    let sum = |weights: &[f64]| weights.iter().sum::<f64>();
    let (y, cx) = (gaussian(CSF_Y.1, 1.0), gaussian(CSF_CX.1, 1.0));
    // Either summand has the root of its factor in both directions; they sum to 1 together.
    let [cz1, cz2] = CSF_CZ.map(|(a, b)| gaussian(b, (a * (PI / b).sqrt()).sqrt()));
    let norms = [sum(&y), sum(&cx), sum(&cz1).hypot(sum(&cz2))];
    let weight = |i: usize| DVec4::new(y[i] / norms[0], cx[i] / norms[1], cz1[i] / norms[2], cz2[i] / norms[2]);
    (0..y.len()).map(|i| weight(i).as_vec4()).collect()
}

/// What is perceived of the colours: filtered, clamped to displayable ones, in L*a*b* with
/// the Hunt effect.
fn perceived_lab(image: &Image<Vec4>, filter: &[Vec4]) -> Vec<Vec3> {
    let rgb_from_xyz = XYZ_FROM_RGB.inverse();
    let white = XYZ_FROM_RGB * Vec3::ONE;
    let perceived = |filtered: &Vec4| {
        let y = (filtered.x + 16.0) / 116.0;
        let xyz = vec3(y + filtered.y / 500.0, y, y - (filtered.z + filtered.w) / 200.0) * white;
        hunt_lab((rgb_from_xyz * xyz).clamp(Vec3::ZERO, Vec3::ONE))
    };
    convolve(image, filter, filter).par_iter().map(perceived).collect()
}

/// L*a*b* of a linear sRGB colour with chroma scaled by lightness.
fn hunt_lab(rgb: Vec3) -> Vec3 {
    const DELTA: f32 = 6.0 / 29.0;
    let white = XYZ_FROM_RGB * Vec3::ONE;
    let root = |t: f32| if t > DELTA.powi(3) { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 };
    let xyz = XYZ_FROM_RGB * rgb / white;
    let (x, y, z) = (root(xyz.x), root(xyz.y), root(xyz.z));
    let lightness = 116.0 * y - 16.0;
    vec3(lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z))
}

/// The colour difference and its mapping to [0, 1].
struct ColorDifference {
    /// Greatest difference, that of green and blue.
    max: f32,
}

impl ColorDifference {
    fn new() -> Self {
        Self { max: hyab(hunt_lab(Vec3::Y), hunt_lab(Vec3::Z)).powf(QC) }
    }

    fn of(&self, a: Vec3, b: Vec3) -> f32 {
        let difference = hyab(a, b).powf(QC);
        let knee = PC * self.max;
        if difference < knee {
            difference * PT / knee
        } else {
            PT + (difference - knee) / (self.max - knee) * (1.0 - PT)
        }
    }
}

/// The HyAB distance: city block in lightness, Euclidean in chroma.
fn hyab(a: Vec3, b: Vec3) -> f32 {
    let d = a - b;
    d.x.abs() + d.y.hypot(d.z)
}

/// Edge and point detectors: derivatives of a Gaussian in x (channels 0
/// and 1) and in y (2 and 3), first and second.
struct FeatureFilters {
    along_rows: Vec<Vec4>,
    along_columns: Vec<Vec4>,
}

impl FeatureFilters {
    fn new(pixels_per_degree: f64) -> Self {
        let sigma = 0.5 * FEATURE_WIDTH_DEG * pixels_per_degree;
        let radius = (3.0 * sigma).ceil() as i32;
        let samples = |f: &dyn Fn(f64) -> f64| -> Vec<f64> { (-radius..=radius).map(|i| f(f64::from(i))).collect() };
        let gaussian = |x: f64| (-x * x / (2.0 * sigma * sigma)).exp();
        let smooth = unit_sums(&samples(&gaussian));
        let first = unit_sums(&samples(&|x| -x * gaussian(x)));
        let second = unit_sums(&samples(&|x| (x * x / (sigma * sigma) - 1.0) * gaussian(x)));
        let taps = 0..smooth.len();
        Self {
            along_rows: taps.clone().map(|i| vec4(first[i], second[i], smooth[i], smooth[i])).collect(),
            along_columns: taps.map(|i| vec4(smooth[i], smooth[i], first[i], second[i])).collect(),
        }
    }

    /// Strength of the edge (x) and of the point (y) at every pixel.
    fn strengths(&self, image: &Image<Vec4>) -> Vec<Vec2> {
        let luminance = image.map(|p| Vec4::splat((p.x + 16.0) / 116.0));
        let filtered = convolve(&luminance, &self.along_rows, &self.along_columns);
        filtered.par_iter().map(|d| vec2(d.x.hypot(d.z), d.y.hypot(d.w))).collect()
    }
}

/// Scales the positive weights to the sum 1 and the negative ones to -1.
fn unit_sums(weights: &[f64]) -> Vec<f32> {
    let positive: f64 = weights.iter().filter(|w| **w > 0.0).sum();
    let negative: f64 = -weights.iter().filter(|w| **w < 0.0).sum::<f64>();
    weights.iter().map(|w| if *w > 0.0 { w / positive } else { w / negative.max(f64::MIN_POSITIVE) } as f32).collect()
}

/// Separable correlation, channel by channel, with odd kernels; the border's pixels
/// continue outside.
fn convolve(image: &Image<Vec4>, along_rows: &[Vec4], along_columns: &[Vec4]) -> Vec<Vec4> {
    let (width, height) = (image.size.x as usize, image.size.y as usize);
    let mut rows = vec![Vec4::ZERO; image.pixels.len()];
    rows.par_chunks_exact_mut(width).zip(image.pixels.par_chunks_exact(width)).for_each(|(out, row)| {
        let radius = along_rows.len() / 2;
        let mut padded = vec![row[0]; radius];
        padded.extend_from_slice(row);
        padded.resize(width + 2 * radius, row[width - 1]);
        for (offset, weight) in along_rows.iter().enumerate() {
            accumulate(out, &padded[offset..offset + width], *weight);
        }
    });
    let mut columns = vec![Vec4::ZERO; image.pixels.len()];
    columns.par_chunks_exact_mut(width).enumerate().for_each(|(y, out)| {
        let radius = along_columns.len() / 2;
        for (offset, weight) in along_columns.iter().enumerate() {
            let from = (y + offset).saturating_sub(radius).min(height - 1);
            accumulate(out, &rows[from * width..(from + 1) * width], *weight);
        }
    });
    columns
}

fn accumulate(out: &mut [Vec4], values: &[Vec4], weight: Vec4) {
    for (sum, value) in out.iter_mut().zip(values) {
        *sum += weight * *value;
    }
}
