//! `linear`: energy, moire, and the GPU against the paper's CPU program.

mod common;
mod views;

use common::{gpu, lens};
use defocus::gpu::Precision;
use defocus::image::{ColorImage, Image};
use defocus::methods::{CircleSampling, Circles, Coverage, Linear, LinearFilter, linear_cpu};
use glam::{UVec2, Vec3, uvec2};
use views::{blurred, depths_of, energy, greatest_difference, mirrored, noise, point, render, variance_px2, view_of};

/// f16 as software Vulkan stores it, truncated: 2^-10 of the value, and 2^-24 near zero.
fn f16_step(value: f32) -> f32 {
    value.abs() / 1024.0 + 6e-8
}

fn circles(coverage: Coverage) -> Circles {
    Circles::new(CircleSampling { coverage, sub_pixels: 10 })
}

/// A CoC that runs through foreground and background, with leaps.
fn varied_coc(size: UVec2) -> Image<f32> {
    Image::from_fn(size, |x, y| {
        let slope = -6.3 + 17.1 * x as f32 / size.x as f32;
        if (x / 7 + y / 5) % 3 == 0 { 0.6 * slope - 1.01 } else { slope }
    })
}

#[test]
fn every_circle_sums_to_one_on_the_cpu() {
    let size = uvec2(133, 133);
    for coverage in [Coverage::Uniform, Coverage::Jittered] {
        let sampling = CircleSampling { coverage, sub_pixels: 10 };
        let filter = LinearFilter { sampling, ..LinearFilter::default() };
        for step in 0..=24 {
            let radius = 64.0 * step as f32 / 24.0;
            let mut coc = Image::filled(size, 0.0);
            coc.pixels[(66 * size.x + 66) as usize] = -2.0 * radius;
            let total = energy(&filter.apply(&point(size, 1.0), &coc));
            // Pixels are rounded to f32, whose half step is 6e-8 of each.
            assert!((total - 1.0).abs() < 1e-6, "{coverage:?} radius {radius}: {total}");
        }
    }
}

/// Area of the part of the pixel at (x, y) that a circle about the origin covers, px^2: its height over the columns of
/// the pixel, whose ends are known exactly, summed at the middles of narrow columns.
fn covered_area(radius: f64, x: f64, y: f64) -> f64 {
    const COLUMNS: u32 = 1024;
    let width = 1.0 / f64::from(COLUMNS);
    let height = |i: u32| {
        let at = x - 0.5 + (f64::from(i) + 0.5) * width;
        let half = (radius * radius - at * at).max(0.0).sqrt();
        (half.min(y + 0.5) - (-half).max(y - 0.5)).max(0.0)
    };
    (0..COLUMNS).map(height).sum::<f64>() * width
}

#[test]
fn circles_cover_what_their_area_covers() {
    // Both sides of the comparison with the paper's program draw circles by one piece of code: here it is
    // held to the area. A circle's edge crosses at most 20 of a pixel's 10x10 cells, of which a regular
    // grid mistakes half a cell each at most, in the same direction; jittered points vary by a standard
    // deviation of half a cell each, independently: 0.5 * sqrt(20) / 100, of which four and a half.
    // The mean error of all pixels is nearly none for a grid. Of one jittered set for all pixels it is how
    // far its 100 points lie to one side: 0.1 px / sqrt(12 * 100), of which three and a half.
    for (coverage, limit, bias) in [(Coverage::Uniform, 0.1, 2e-3), (Coverage::Jittered, 0.1, 1e-2)] {
        let circles = circles(coverage);
        let (mut sum, mut count) = (0.0, 0.0);
        for step in 1..=40 {
            let radius = 0.5 + 0.31 * f64::from(step);
            for (x, y) in (0..14).flat_map(|y| (0..14).map(move |x| (x, y))) {
                let expected = covered_area(radius, f64::from(x), f64::from(y));
                let error = circles.coverage(radius, x, y) - expected;
                assert!(error.abs() < limit, "{coverage:?} radius {radius}, {x}, {y}: off by {error}");
                if expected > 0.0 && expected < 1.0 {
                    (sum, count) = (sum + error, count + 1.0);
                }
            }
        }
        assert!(count > 500.0 && (sum / count).abs() < bias, "{coverage:?}: {} over {count} pixels", sum / count);
    }
    let naive = circles(Coverage::Naive);
    let far = |x: u32, y: u32| f64::from(x * x + y * y);
    for (x, y) in (0..14).flat_map(|y| (0..14).map(move |x| (x, y))) {
        assert_eq!(naive.coverage(7.3, x, y) == 1.0, far(x, y) < 7.3 * 7.3, "{x}, {y}");
    }
}

#[test]
fn naive_circles_leap_where_antialiased_ones_do_not() {
    let worst = |coverage, from: f64, to: f64| {
        let circles = circles(coverage);
        let radii = (0..=400).map(|i| from + (to - from) * f64::from(i) / 400.0);
        radii.map(|r| (circles.total_energy_as_printed(r) - 1.0).abs()).fold(0.0, f64::max)
    };
    // Just above r = 1/2 one pixel has 1/(pi/4) = 1.27 of the energy; just above 1 five
    // have 5/pi = 1.59.
    assert!(worst(Coverage::Naive, 0.5, 2.0) > 0.55);
    assert!(worst(Coverage::Naive, 3.0, 64.0) > 0.05);
    // 100 points a pixel count a circle's area to about the root of the number of cells on
    // its edge, sqrt(2 pi 10 r) / (100 pi r^2): 2.5 % at 1 px and 0.5 % at 3 px, of which a
    // maximum over radii is up to twice that.
    for coverage in [Coverage::Uniform, Coverage::Jittered] {
        assert!(worst(coverage, 1.0, 3.0) < 0.05, "{coverage:?}");
        assert!(worst(coverage, 3.0, 64.0) < 0.01, "{coverage:?}");
    }
}

/// Root mean square of the second difference along the middle row: what moire is made of,
/// and what slow changes of brightness have little of.
fn roughness(image: &ColorImage) -> f64 {
    let (y, width) = (image.size.y / 2, image.size.x);
    let value = |x| f64::from(image.at(x, y).x);
    let inner = 16..width - 16;
    let count = inner.len() as f64;
    let squares = inner.map(|x| (value(x - 1) - 2.0 * value(x) + value(x + 1)).powi(2));
    (squares.sum::<f64>() / count).sqrt()
}

#[test]
fn naive_circles_make_moire_on_a_slanted_grey_wall() {
    let size = uvec2(160, 40);
    let grey = ColorImage::filled(size, Vec3::splat(0.5));
    let coc = Image::from_fn(size, |x, _| 2.0 + 0.05 * x as f32);
    let of = |coverage| {
        let sampling = CircleSampling { coverage, sub_pixels: 10 };
        roughness(&LinearFilter { sampling, ..LinearFilter::default() }.apply(&grey, &coc))
    };
    let (naive, uniform) = (of(Coverage::Naive), of(Coverage::Uniform));
    eprintln!("roughness: naive {naive:.5}, supersampled {uniform:.5}");
    assert!(naive > 0.01, "naive circles show moire: {naive}");
    assert!(uniform < 0.2 * naive, "antialiased circles show a fifth at most: {uniform} against {naive}");
}

#[test]
fn a_point_spreads_with_the_standard_deviation_of_a_disc() {
    let size = uvec2(97, 97);
    // At 1.5 px the lattice of pixels itself is coarse against the disc.
    for (radius, tolerance) in [(1.5f32, 0.1), (2.7, 0.02), (5.3, 0.01), (11.9, 0.005), (30.2, 0.005)] {
        let blob = linear_cpu(&point(size, 1.0), &Image::filled(size, 2.0 * radius));
        // A disc has r^2/4 = (C/4)^2; its coverage of square pixels adds their 1/12.
        let wanted = f64::from(radius * radius) / 4.0 + 1.0 / 12.0;
        for variance in variance_px2(&blob) {
            assert!((variance / wanted - 1.0).abs() < tolerance, "radius {radius}: {variance} against {wanted}");
        }
    }
}

#[test]
fn the_gpu_keeps_the_energy_of_a_point() {
    let _turn = views::turn();
    let size = uvec2(133, 133);
    let lens = lens(200.0, 2.0);
    // Bright, so that a wide circle's pixels stay clear of f16's denormals.
    let color = point(size, 4096.0);
    for radius in [0.0f32, 0.3, 0.49, 0.51, 0.8, 1.0, 1.37, 2.0, 3.3, 7.9, 16.2, 31.7, 63.9] {
        let mut coc = Image::filled(size, 0.0);
        coc.pixels[(66 * size.x + 66) as usize] = 2.0 * radius;
        let mut view = view_of(&color, &depths_of(&lens, &coc));
        for (precision, tolerance) in [(Precision::Half, 1e-3), (Precision::Full, 1e-5)] {
            let total = energy(&render(&Linear::default(), &mut view, &lens, precision)) / 4096.0;
            // f16 truncates by up to 2^-10 of a pixel; f32 sums a circle to some 1e-7.
            assert!((total - 1.0).abs() < tolerance, "radius {radius} {precision:?}: {total}");
        }
    }
}

#[test]
fn the_gpu_equals_the_papers_program() {
    let _turn = views::turn();
    let size = uvec2(75, 53);
    let lens = lens(40.0, 2.0);
    let (color, coc) = (noise(size), varied_coc(size));
    let depth = depths_of(&lens, &coc);
    for (coverage, pattern, normalise) in [(1, 0, false), (1, 1, false), (0, 0, false), (1, 0, true)] {
        let gpu = Linear { coverage, pattern, normalise, ..Linear::default() };
        let cpu = Linear { backend: 1, ..gpu.clone() };
        let mut view = view_of(&color, &depth);
        let by_gpu = render(&gpu, &mut view, &lens, Precision::Full);
        let by_cpu = render(&cpu, &mut view, &lens, Precision::Half);
        // The CPU's result is stored in f16 (rounded); a sub-pixel that lies on a circle's
        // edge may fall on either side in f32: 1/100 of a pixel of 1/(pi r^2), below 1e-3
        // where r > 2 and taken as such for all.
        for (g, c) in by_gpu.pixels.iter().zip(&by_cpu.pixels) {
            let tolerance = f16_step(c.max_element()) + if normalise { 0.0 } else { 1e-3 };
            assert!((*g - *c).abs().max_element() <= tolerance, "{coverage} {pattern}: {g} against {c}");
        }
        let mean = by_gpu.pixels.iter().zip(&by_cpu.pixels).map(|(g, c)| (*g - *c).abs().max_element());
        let mean = mean.sum::<f32>() / by_gpu.pixels.len() as f32;
        assert!(mean < f16_step(1.0) / 2.0, "such sub-pixels are rare: mean difference {mean}");
    }
}

#[test]
fn f16_results_are_those_of_f32_truncated() {
    let _turn = views::turn();
    let size = uvec2(75, 53);
    let lens = lens(40.0, 2.0);
    let mut view = view_of(&noise(size), &depths_of(&lens, &varied_coc(size)));
    let half = render(&Linear::default(), &mut view, &lens, Precision::Half);
    let full = render(&Linear::default(), &mut view, &lens, Precision::Full);
    for (h, f) in half.pixels.iter().zip(&full.pixels) {
        assert!((*h - *f).abs().max_element() <= f16_step(f.max_element()), "{h} against {f}");
    }
}

#[test]
fn circles_within_their_pixel_leave_the_image_alone() {
    let _turn = views::turn();
    let size = uvec2(40, 30);
    let lens = lens(40.0, 2.0);
    let color = noise(size);
    let sharp = Image::from_fn(size, |x, _| if x < 20 { 0.9 } else { -0.9 });
    assert_eq!(linear_cpu(&color, &sharp), color);
    let mut frame = gpu().frame();
    let mut view = view_of(&color, &depths_of(&lens, &sharp));
    let texture = defocus::methods::record(&Linear::default(), &mut frame, &mut view, &lens).expect("a good lens");
    let stats = frame.finish().stats;
    assert!(stats.skipped.contains_key("all circles within their pixel"), "{stats:?}");
    // The input was rounded to f16 when it was uploaded.
    assert!(greatest_difference(&defocus::gpu::download(gpu(), &texture), &color) < f16_step(1.0));
    // One blurred pixel far away changes nothing here, and the rest is not skipped.
    let mut coc = sharp.clone();
    coc.pixels[0] = 6.0;
    let far = |image: ColorImage| image.crop(uvec2(8, 8), size - 8);
    let with = blurred(&Linear::default(), &color, &lens, &coc);
    assert_eq!(far(with), far(defocus::gpu::download(gpu(), &texture)));
}

#[test]
fn constant_depth_keeps_a_constant_colour_inside_and_normalise_keeps_it_everywhere() {
    let _turn = views::turn();
    let size = uvec2(64, 48);
    let lens = lens(40.0, 2.0);
    let grey = ColorImage::filled(size, Vec3::new(0.25, 0.5, 3.0));
    let flat = Image::filled(size, 9.3f32);
    let out = blurred(&Linear::default(), &grey, &lens, &flat);
    let inner = |image: &ColorImage| image.crop(uvec2(6, 6), size - 12);
    // A rounding of f32 just below the value is truncated by one step of f16.
    assert!(greatest_difference(&inner(&out), &inner(&grey)) <= f16_step(3.0));
    assert!(out.at(0, 24).y < 0.3, "without overscan the border loses light: {}", out.at(0, 24).y);
    let normalised = Linear { normalise: true, ..Linear::default() };
    let out = blurred(&normalised, &grey, &lens, &varied_coc(size));
    assert!(greatest_difference(&out, &grey) <= f16_step(3.0));
}

/// More pixels and sub-pixels than a software adapter takes in one pass: what a white image
/// shows in its middle is the light of all circles there.
#[test]
fn wide_circles_keep_all_their_light() {
    let (size, coc_px) = (uvec2(76, 76), 72.0);
    let jittered = Linear { pattern: 1, ..Linear::default() };
    let image = ColorImage::filled(size, Vec3::ONE);
    let result = blurred(&jittered, &image, &lens(300.0, 1.0), &Image::filled(size, coc_px));
    let middle = result.at(size.x / 2, size.y / 2);
    assert!((middle - Vec3::ONE).abs().max_element() <= 1e-3, "{middle}");
}

#[test]
fn overscan_gives_the_border_its_light() {
    let _turn = views::turn();
    let wall = common::quad(4.0, glam::vec2(-20.0, -20.0), glam::vec2(20.0, 20.0), 0);
    let scene = common::scene(vec![wall], vec![common::unlit(Vec3::splat(0.5))]);
    let scene = defocus::view::GpuScene::new(gpu(), &scene, defocus::view::SurfaceOptions::default());
    let lens = lens(16.0, 2.0);
    for backend in [0, 1] {
        let method = Linear { backend, ..Linear::default() };
        let border = |overscan_px| {
            let camera = common::front_camera();
            let view = defocus::view::View::of_scene(scene.clone(), camera, uvec2(40, 30), overscan_px);
            render(&method, &mut view.expect("a small view"), &lens, Precision::Half).at(0, 15).x
        };
        // C = 16 (1 - 2/4) = 8: half of the circles that would reach the border are missing.
        assert!(border(0) < 0.32, "{}", border(0));
        assert!((border(5) - 0.5).abs() <= f16_step(0.5), "{}", border(5));
    }
}

#[test]
fn a_mirrored_image_is_blurred_alike() {
    let _turn = views::turn();
    let size = uvec2(51, 40);
    let lens = lens(40.0, 2.0);
    let (color, coc) = (noise(size), varied_coc(size));
    for pattern in [0, 1] {
        let method = Linear { pattern, ..Linear::default() };
        let there = mirrored(&blurred(&method, &color, &lens, &coc));
        let here = blurred(&method, &mirrored(&color), &lens, &mirrored(&coc));
        // Sums in another order differ in their last bit, which truncation turns into a
        // step of f16.
        assert!(greatest_difference(&here, &there) <= f16_step(1.2), "{}", greatest_difference(&here, &there));
    }
}

#[test]
fn a_pixel_that_is_not_finite_does_not_spread() {
    let _turn = views::turn();
    let size = uvec2(40, 30);
    let lens = lens(40.0, 2.0);
    let mut color = ColorImage::filled(size, Vec3::splat(0.5));
    color.pixels[15 * 40 + 20] = Vec3::new(f32::NAN, 1.0, 0.0);
    let coc = Image::filled(size, 8.0);
    let cpu = linear_cpu(&color, &coc);
    let gpu = blurred(&Linear::default(), &color, &lens, &coc);
    for image in [&cpu, &gpu] {
        assert!(image.pixels.iter().all(|p| p.is_finite()));
        assert!(image.at(20, 15).x < 0.5 && image.at(20, 15).x > 0.48, "its own share is missing");
    }
}

#[test]
fn greater_circles_are_cut() {
    let _turn = views::turn();
    let size = uvec2(48, 48);
    let lens = lens(400.0, 2.0);
    let method = Linear { max_radius_px: 6.0, ..Linear::default() };
    let at = |c| blurred(&method, &point(size, 100.0), &lens, &Image::filled(size, c));
    assert_eq!(at(12.0), at(120.0));
}
