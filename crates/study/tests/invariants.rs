//! What every registered method must satisfy, iterated over the registry: one that is
//! added later cannot escape them.

#[path = "../../../tests/common/mod.rs"]
mod common;

use common::gpu;
use defocus::gpu::{Frame, FrameStats, download};
use defocus::image::{ColorImage, DepthImage, Image};
use defocus::lens::Lens;
use defocus::methods::{self, Method, MethodError};
use defocus::view::View;
use defocus_study::stress::{as_stored, first_not_finite, mirrored, without_jitter};
use glam::{UVec2, Vec3, uvec2, vec3};

/// Even, so that centred pyramids are symmetric; not square, not a power of two.
const SIZE: UVec2 = uvec2(96, 64);

/// Where the lens is focused, metres.
const FOCUS_M: f32 = 2.0;

/// A lens whose CoC at infinity is `k_px`.
fn lens(k_px: f64) -> Lens {
    common::lens(k_px, f64::from(FOCUS_M))
}

/// Depth, metres, at which `lens` has the signed CoC `c_px`.
fn depth_of(lens: &Lens, c_px: f64) -> f32 {
    lens.coc().depth_at(c_px) as f32
}

/// Methods that can render an image with a depth map: all that need no scene.
fn image_methods() -> Vec<Box<dyn Method>> {
    let methods: Vec<_> = methods::all().into_iter().filter(|m| !m.about().needs_scene).collect();
    assert!(methods.len() >= 2);
    methods
}

fn try_render(
    method: &dyn Method,
    color: &ColorImage,
    depth: &DepthImage,
    lens: &Lens,
) -> Result<(ColorImage, FrameStats), MethodError> {
    let mut view = View::of_image(gpu(), color, depth, 0.8)?;
    let mut frame: Frame<'_> = gpu().frame();
    let texture = methods::record(method, &mut frame, &mut view, lens)?;
    let stats = frame.finish().stats;
    Ok((download(gpu(), &texture), stats))
}

fn render(method: &dyn Method, color: &ColorImage, depth: &DepthImage, lens: &Lens) -> ColorImage {
    try_render(method, color, depth, lens).unwrap_or_else(|e| panic!("{}: {e}", method.about().id)).0
}

/// A deterministic image with hard edges and fine detail, in [0.05, 1].
fn busy_image() -> ColorImage {
    Image::from_fn(SIZE, |x, y| {
        let bar = if (x / 7 + y / 5) % 2 == 0 { 0.9 } else { 0.1 };
        let hash = (x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663)).wrapping_mul(2_654_435_761) >> 24;
        vec3(bar, 0.05 + hash as f32 / 270.0, (x as f32 / SIZE.x as f32).max(0.05))
    })
}

/// A depth map with a near object, a slope and a far wall.
fn busy_depth() -> DepthImage {
    Image::from_fn(SIZE, |x, y| match (x, y) {
        (20..=40, 15..=45) => 0.8,
        (60..=80, _) => 1.0 + y as f32 * 0.1,
        _ => 8.0,
    })
}

fn greatest_difference(a: &ColorImage, b: &ColorImage) -> (f32, UVec2) {
    let differences = a.pixels.iter().zip(&b.pixels).map(|(a, b)| (*a - *b).abs().max_element());
    let (index, greatest) = differences.enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
    (greatest, uvec2(index as u32 % a.size.x, index as u32 / a.size.x))
}

fn assert_all_finite(image: &ColorImage, what: &str) {
    if let Err(bad) = first_not_finite(image) {
        panic!("{what}: pixel {:?} {}", bad.at, bad.found);
    }
}

#[test]
fn a_closed_aperture_gives_the_pinhole_image_and_no_pass() {
    let (color, depth) = (busy_image(), busy_depth());
    let closed = Lens { aperture_diameter_mm: 0.0, ..lens(8.0) };
    for method in image_methods() {
        let (image, stats) = try_render(&*method, &color, &depth, &closed).unwrap();
        assert_eq!(image, color.map(as_stored), "{}", method.about().id);
        assert_eq!(stats.passes, 0, "{}: a closed aperture needs no pass", method.about().id);
    }
}

#[test]
fn everything_at_the_focus_distance_gives_the_pinhole_image() {
    let color = busy_image();
    let depth = Image::filled(SIZE, FOCUS_M);
    for method in image_methods() {
        let (image, stats) = try_render(&*method, &color, &depth, &lens(12.0)).unwrap();
        assert_eq!(image, color.map(as_stored), "{}", method.about().id);
        // The one pass finds the depth bounds; none blurs.
        assert_eq!(stats.passes, 1, "{}", method.about().id);
        assert_eq!(stats.skipped.get("everything in focus"), Some(&1), "{}", method.about().id);
    }
}

#[test]
fn a_constant_colour_stays_for_any_depth_and_at_the_border() {
    let constant = vec3(0.25, 0.5, 2.0);
    let color = Image::filled(SIZE, constant);
    for method in image_methods().iter().filter(|m| m.about().averages) {
        for (name, depth) in [("busy", busy_depth()), ("slope", Image::from_fn(SIZE, |x, _| 0.5 + x as f32 * 0.05))] {
            let image = render(&**method, &color, &depth, &lens(12.0));
            for (index, pixel) in image.pixels.iter().enumerate() {
                // A few roundings or truncations of f16: 2^-11 to 2^-10 each.
                let error = ((*pixel - constant) / constant).abs().max_element();
                assert!(
                    error <= 2e-3,
                    "{} on {name} depth: pixel ({}, {}) is {pixel}",
                    method.about().id,
                    index as u32 % SIZE.x,
                    index as u32 / SIZE.x
                );
            }
        }
    }
}

#[test]
fn mirrored_input_gives_the_mirrored_output() {
    let (color, depth) = (busy_image(), busy_depth());
    for method in image_methods() {
        let method = without_jitter(&*method);
        let straight = render(&*method, &color, &depth, &lens(10.0));
        let mirror = mirrored(&render(&*method, &mirrored(&color), &mirrored(&depth), &lens(10.0)));
        let (difference, at) = greatest_difference(&straight, &mirror);
        // Sums in another order differ by a few roundings of f16 (2^-11 of values up to 1).
        // A set of lens points is not its own mirror image: a few of them hit the other side
        // of an edge.
        let limit = if method.about().samples_lens { 5.0 / 16.0 } else { 4e-3 };
        assert!(difference <= limit, "{}: differs by {difference} at {at}", method.about().id);
    }
}

#[test]
fn no_finite_input_gives_nan_or_infinity() {
    let extremes = [0.0, 1e-7, 1.0, 65504.0];
    let color = Image::from_fn(SIZE, |x, y| Vec3::splat(extremes[((x / 3 + y / 3) % 4) as usize]));
    let depths = [f32::INFINITY, 1e-3, FOCUS_M, 1e6, 0.5];
    let depth = Image::from_fn(SIZE, |x, y| depths[((x / 5 + y / 4) % 5) as usize]);
    for method in image_methods() {
        for k_px in [0.5, 8.0, 40.0] {
            let image = render(&*method, &color, &depth, &lens(k_px));
            assert_all_finite(&image, &format!("{} at K = {k_px} px", method.about().id));
        }
    }
}

#[test]
fn a_pixel_that_is_not_a_number_is_reported_and_does_not_spread() {
    let (mut color, mut depth) = (busy_image(), busy_depth());
    for (i, bad) in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY].into_iter().enumerate() {
        color.pixels[1000 + 7 * i] = vec3(0.5, bad, 0.5);
        depth.pixels[3000 + 7 * i] = [f32::NAN, -1.0, 0.0][i];
    }
    assert_eq!(View::of_image(gpu(), &color, &depth, 0.8).unwrap().repaired_pixels(gpu()), 6);
    for method in image_methods() {
        assert_all_finite(&render(&*method, &color, &depth, &lens(12.0)), method.about().id);
    }
}

#[test]
fn a_white_point_keeps_its_energy_where_light_is_spread() {
    let lens = lens(24.0);
    let centre = SIZE / 2;
    let color = Image::from_fn(SIZE, |x, y| if uvec2(x, y) == centre { Vec3::splat(64.0) } else { Vec3::ZERO });
    for method in image_methods().iter().filter(|m| m.about().conserves_energy) {
        for c_px in [-10.0, -3.3, 2.0, 7.7, 15.0] {
            let depth = Image::filled(SIZE, depth_of(&lens, c_px));
            let image = render(&**method, &color, &depth, &lens);
            let sum: f64 = image.pixels.iter().map(|p| f64::from(p.y)).sum();
            assert!((sum / 64.0 - 1.0).abs() < 2e-3, "{} at c = {c_px}: energy {}", method.about().id, sum / 64.0);
        }
    }
}

/// Greatest relative error of the blur's standard deviation for a lone white point at a CoC of 6 to 16 px.
/// What a method is allowed to miss follows from how it was published; all others are held to the lens.
fn width_tolerance(id: &str) -> f64 {
    match id {
        // Its blurred copy alone is as wide as a disc of 14 px, and its taps spread 1.6 times as far
        // as the CoC: at 6 px that is 2.3 times the lens.
        "preblur" => 1.5,
        // A point is hit by one ray of a hundred: its disc at 12 px is some sixteen pixels, whose
        // mean square distance has a standard error of 1 / sqrt(16).
        "lens-layers" => 0.25,
        // A square of side C has C / sqrt(12) where the disc has C / 4: 1.155 times as much, and 1/12 px^2
        // for each of its pixels.
        "separable" => 0.2,
        // Half resolution: at 6 px a texel of 2 px adds 4/12 px^2 to 2.25 px^2, 7 %, and so does its read.
        "gather" => 0.15,
        // Where a point lies on the pyramid's grid decides how wide its own image is: the mean over
        // all places is the lens's (`planes_are_blurred_as_wide_as_the_lens_blurs_them` in tests/opaque.rs).
        "opaque" | "pyramid" => 0.14,
        // 64 lens points stand for the lens: their own standard deviation is uncertain by 1 / sqrt(4 * 64).
        "multiview" => 0.08,
        // 1 % in the mean over all places of a point on the pyramid's grid (docs/results.md), more at one.
        "mipmap" => 0.05,
        // The spots of black neighbours that are drawn later cover the point's own, most in its middle.
        "scatter" => 0.05,
        // The pixels that the disc covers, as below, and 1 % for circles of 100 points a pixel.
        "linear" => 0.03,
        // The lens, and the pixel that each point of the disc covers: 1/12 px^2 of 2.25 px^2, half of
        // which is its share of the standard deviation: 1.9 %.
        _ => 0.025,
    }
}

#[test]
fn a_white_point_spreads_as_wide_as_the_lens() {
    let lens = lens(24.0);
    let centre = SIZE / 2;
    let color = Image::from_fn(SIZE, |x, y| if uvec2(x, y) == centre { Vec3::splat(64.0) } else { Vec3::ZERO });
    for method in image_methods().iter().filter(|m| m.about().apertures != methods::Apertures::None) {
        for c_px in [-12.0f64, 6.0, 12.0, 16.0] {
            let depth = Image::filled(SIZE, depth_of(&lens, c_px));
            let image = render(&**method, &color, &depth, &lens);
            let moment = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
                let at = |i: usize| (i as f64 % f64::from(SIZE.x), (i as f64 / f64::from(SIZE.x)).floor());
                image.pixels.iter().enumerate().map(|(i, p)| f(at(i).0, at(i).1) * f64::from(p.y)).sum()
            };
            let total = moment(&|_, _| 1.0);
            assert!(total > 0.0, "{} at c = {c_px}: the point is gone", method.about().id);
            let (mx, my) = (moment(&|x, _| x) / total, moment(&|_, y| y) / total);
            let variance = moment(&|x, y| (x - mx).powi(2) + (y - my).powi(2)) / total / 2.0;
            let wanted = lens.aperture.sigma_per_coc() * c_px.abs();
            let limit = width_tolerance(method.about().id);
            let error = variance.sqrt() / wanted - 1.0;
            assert!(error.abs() < limit, "{} at c = {c_px}: sigma {} of {wanted}", method.about().id, variance.sqrt());
        }
    }
}

#[test]
fn a_small_change_of_focus_changes_little() {
    let (color, depth) = (busy_image(), busy_depth());
    for method in image_methods() {
        let near = lens(10.0);
        for step in [1e-4, 1e-3] {
            let moved = Lens { focus_distance_m: near.focus_distance_m * (1.0 + step), ..near.clone() };
            let (difference, at) = greatest_difference(
                &render(&*method, &color, &depth, &near),
                &render(&*method, &color, &depth, &moved),
            );
            // 1e-3 of focus distance moves CoCs by up to 0.025 px; the images' steepest edges
            // change by 0.9 a pixel; a tenth of that is popping.
            assert!(difference <= 0.1, "{}: a step of {step} changes {at} by {difference}", method.about().id);
        }
    }
}
