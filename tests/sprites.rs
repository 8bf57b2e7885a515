//! Sprites: their light sums to one at every size and shape, on the CPU and as drawn.

mod common;

use common::{apertures, gpu};
use defocus::aperture::Aperture;
use defocus::gpu::{Precision, download};
use defocus::image::{ColorImage, Image};
use defocus::lens::Lens;
use defocus::methods::sprites::SpriteTable;
use defocus::methods::{self, Splat};
use defocus::view::View;
use glam::{DVec2, UVec2, Vec3, dvec2, uvec2};

/// Sum, mean and variance per axis of what a sprite gives to the pixels around it.
struct Moments {
    sum: f64,
    mean: DVec2,
    variance: f64,
}

fn moments(shares: impl Iterator<Item = (DVec2, f64)>) -> Moments {
    let (mut sum, mut first, mut second) = (0.0, DVec2::ZERO, 0.0);
    for (offset, share) in shares {
        sum += share;
        first += share * offset;
        second += share * offset.length_squared();
    }
    let mean = first / sum;
    Moments { sum, mean, variance: 0.5 * (second / sum - mean.length_squared()) }
}

fn offsets(reach_px: f64) -> impl Iterator<Item = DVec2> {
    let reach = reach_px.ceil() as i32;
    (-reach..=reach).flat_map(move |y| (-reach..=reach).map(move |x| dvec2(f64::from(x), f64::from(y))))
}

/// Parts of a pixel on each side for [`integrated`].
const PARTS: i32 = 32;

/// What of a spot's light falls on each pixel within `reach` of it, in rows: the aperture's intensity at the
/// middles of many parts of each pixel, summed. It knows nothing of the table.
fn integrated(aperture: &Aperture, reach: i32, c_px: f64) -> Vec<f64> {
    let part = |i: i32| (f64::from(i) + 0.5) / f64::from(PARTS) - 0.5;
    let on_pixel = |x: i32, y: i32| -> f64 {
        let parts = (0..PARTS * PARTS).map(|i| dvec2(part(i % PARTS), part(i / PARTS)));
        parts.map(|p| aperture.intensity((dvec2(f64::from(x), f64::from(y)) + p) * (2.0 / c_px))).sum()
    };
    let sums: Vec<f64> =
        (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| (x, y))).map(|(x, y)| on_pixel(x, y)).collect();
    let total: f64 = sums.iter().sum();
    sums.into_iter().map(|sum| sum / total).collect()
}

#[test]
fn the_table_holds_the_integral_of_the_aperture() {
    for aperture in apertures() {
        let table = SpriteTable::of(&aperture);
        for c in [-17.3f64, -4.0, 2.6, 9.1] {
            let reach = table.reach_px(c).ceil() as i32;
            let expected = integrated(&aperture, reach, c);
            let brightest = expected.iter().copied().fold(0.0, f64::max);
            // An edge along the rows lies between two of 512 samples across the spot, and of the parts of a
            // pixel: half of each, as a share of a pixel, may be on the other side. Light is shared out twice,
            // and the sums of all pixels differ as much at most.
            let spacing_px = aperture.radius() * c.abs() / 512.0;
            let limit = 2.0 * brightest * 0.5 * (spacing_px + 1.0 / f64::from(PARTS));
            for (offset, expected) in offsets(f64::from(reach)).zip(expected) {
                let share = table.share(offset, c);
                assert!((share - expected).abs() < limit, "{aperture:?} at c = {c}, {offset}: {share} of {expected}");
            }
        }
    }
}

#[test]
fn a_sprite_sums_to_one_at_every_size_and_for_every_shape() {
    for aperture in apertures() {
        let table = SpriteTable::of(&aperture);
        // Steps that meet no whole number twice in the same way.
        for i in 0..=128 {
            let c = f64::from(i) * 0.5 + 0.137 * f64::from(i % 3);
            for c in [c, -c] {
                let spot = moments(offsets(table.reach_px(c)).map(|o| (o, table.share(o, c))));
                // The table holds f32 below 1/2. Neighbours share its roundings, but where the
                // aperture is dark they leave up to 3e-8, of which negative ones are cut off:
                // half of some thousand pixels.
                assert!((spot.sum - 1.0).abs() < 2e-5, "{aperture:?} at c = {c}: sum {}", spot.sum);
            }
        }
    }
}

#[test]
fn a_sprite_is_as_wide_as_the_lens_and_centred() {
    for aperture in apertures() {
        let table = SpriteTable::of(&aperture);
        for c in [-40.0f64, -9.3, 7.7, 24.0, 63.2] {
            let spot = moments(offsets(table.reach_px(c)).map(|o| (o, table.share(o, c))));
            // A pixel gathers over its own square: 1/12 px^2 per axis.
            let wanted = (aperture.sigma_per_coc() * c).powi(2) + 1.0 / 12.0;
            let error = (spot.variance / wanted).sqrt() - 1.0;
            // 512 samples across the aperture, and a square sampled at few pixels.
            assert!(error.abs() < 0.01, "{aperture:?} at c = {c}: {} px^2 of {wanted}", spot.variance);
            // The centroid of every shape lies at v = 0.
            assert!(spot.mean.length() < 0.01 * c.abs().max(1.0), "{aperture:?} at c = {c}: centred at {}", spot.mean);
        }
    }
}

#[test]
fn without_blur_a_sprite_is_its_pixel() {
    for aperture in apertures() {
        let table = SpriteTable::of(&aperture);
        let smallest = 1.0 / aperture.radius();
        for c in [0.0, 1e-9, -1e-4, 0.5 * smallest, -0.99 * smallest] {
            assert!((table.share(DVec2::ZERO, c) - 1.0).abs() < 1e-6, "{aperture:?} at c = {c}");
        }
    }
}

/// A point of light alone in an image that is in focus elsewhere, splatted as a single
/// sum, in 32 bits.
fn drawn_point(lens: &Lens, c_px: f64, size: UVec2) -> ColorImage {
    let centre = size / 2;
    let color = Image::from_fn(size, |x, y| if uvec2(x, y) == centre { Vec3::ONE } else { Vec3::ZERO });
    let depth = Image::from_fn(size, |x, y| {
        if uvec2(x, y) == centre { lens.coc().depth_at(c_px) as f32 } else { lens.focus_distance_m as f32 }
    });
    let mut view = View::of_image(gpu(), &color, &depth, 0.8).unwrap();
    let splat = Splat { layers: false, normalise: false, ..Splat::default() };
    let mut frame = gpu().frame();
    frame.precision = Precision::Full;
    let texture = methods::record(&splat, &mut frame, &mut view, lens).unwrap();
    frame.finish();
    download(gpu(), &texture)
}

#[test]
fn a_drawn_sprite_is_what_the_cpu_says() {
    for aperture in apertures() {
        let lens = Lens { aperture: aperture.clone(), ..common::lens(100.0, 2.0) };
        let table = SpriteTable::of(&aperture);
        for c in [-63.9f64, -21.37, -3.0, -1.0, 0.4, 0.97, 1.5, 2.0, 5.01, 12.9, 33.3, 64.0] {
            let size = UVec2::splat(2 * table.reach_px(c).ceil() as u32 + 3);
            let drawn = drawn_point(&lens, c, size);
            let offset = |i: usize| {
                let at = uvec2(i as u32 % size.x, i as u32 / size.x);
                (at.as_ivec2() - (size / 2).as_ivec2()).as_dvec2()
            };
            let spot = moments(drawn.pixels.iter().enumerate().map(|(i, p)| (offset(i), f64::from(p.y))));
            assert!((spot.sum - 1.0).abs() < 1e-3, "{aperture:?} at c = {c}: sum {}", spot.sum);
            let wanted = ((aperture.sigma_per_coc() * c).powi(2) + 1.0 / 12.0).sqrt();
            // Below that, a square that is sampled at few pixels has no 1/12 px^2.
            if c.abs() >= 12.0 {
                assert!((spot.variance.sqrt() / wanted - 1.0).abs() < 0.01, "{aperture:?} at c = {c}");
            }
            for (i, p) in drawn.pixels.iter().enumerate() {
                let expected = table.share(offset(i), c);
                // Differences of f32 sums below 1/2 and an f32 CoC: 1e-6 of the whole, and
                // of the pixel's share what 1e-4 px of CoC change at an edge.
                let limit = 2e-6 + 2e-4 * expected;
                assert!(
                    (f64::from(p.y) - expected).abs() < limit,
                    "{aperture:?} at c = {c}, {}: {} of {expected}",
                    offset(i),
                    p.y
                );
            }
        }
    }
}
