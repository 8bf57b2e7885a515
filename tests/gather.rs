//! `preblur` and `separable` against f64 mirrors of their formulas, and what they promise.

mod common;
mod views;

use common::{gpu, lens};
use defocus::gpu::Precision;
use defocus::image::{ColorImage, Image};
use defocus::lens::Lens;
use defocus::methods::{self, Linear, Method, Preblur, Ramp, Separable};
use defocus::view::{Layer, View};
use glam::{DVec2, DVec3, UVec2, Vec3, dvec2, uvec2};
use views::{blurred, depths_of, mirrored, noise, point, variance_px2};

const SIZE: UVec2 = uvec2(70, 45);

/// A lens that blurs infinity by 40 px.
fn wide_lens() -> Lens {
    lens(40.0, 2.0)
}

/// A near square and a far slope, with a strip in focus.
fn coc() -> Image<f32> {
    Image::from_fn(SIZE, |x, y| match (x, y) {
        (10..=25, 12..=30) => -7.3,
        (40..=44, _) => 0.0,
        _ => 1.0 + 0.17 * x as f32,
    })
}

/// What the GPU is given: f16 colours, stored f32 depth.
struct Input {
    color: Image<DVec3>,
    z: Image<f64>,
    coc_px: Image<f64>,
}

fn input(color: &ColorImage, coc: &Image<f32>, lens: &Lens) -> Input {
    let depth = depths_of(lens, coc);
    let near_m = f64::from(depth.pixels.iter().copied().fold(f32::INFINITY, f32::min));
    let half = |v: f32| f64::from(half::f16::from_f32(v).to_f32());
    let z = depth.map(|d| f64::from((near_m / f64::from(d)) as f32));
    Input {
        color: color.map(|p| DVec3::from_array(p.to_array().map(half))),
        coc_px: z.map(|z| lens.coc().at_stored(z, near_m)),
        z,
    }
}

// ---- separable ----

/// Zhou, Chen and Pullen's filter along one axis, in f64.
fn filter_axis(method: &Separable, color: &Image<DVec3>, input: &Input, step: (i64, i64)) -> Image<DVec3> {
    let radius_of = |x: i64, y: i64| f64::from(method.radius_per_coc) * input.coc_px.at_clamped(x, y).abs();
    let ramp = |v: f64| v.clamp(0.0, 1.0);
    let thinning =
        |r: f64| if method.thinning == 1 { (2.0 * r).max(1.0) } else { (std::f64::consts::PI * r * r).max(1.0) };
    Image::from_fn(SIZE, |x, y| {
        let (x, y) = (i64::from(x), i64::from(y));
        let own = radius_of(x, y);
        let (mut sum, mut weights) = (color.at_clamped(x, y) / thinning(own), 1.0 / thinning(own));
        for distance in (-80..=80).filter(|d| *d != 0) {
            let (qx, qy) = (x + distance * step.0, y + distance * step.1);
            if qx < 0 || qy < 0 || qx >= i64::from(SIZE.x) || qy >= i64::from(SIZE.y) {
                continue;
            }
            let radius = radius_of(qx, qy);
            let from = distance.abs() as f64 - 0.5;
            let reach = if method.reach == 0 { radius.min(own) } else { radius };
            let mut weight = ramp(reach - from) / thinning(radius);
            if input.z.at_clamped(qx, qy) > input.z.at_clamped(x, y) {
                weight *= ramp(input.coc_px.at_clamped(qx, qy).abs() - f64::from(method.sharp_coc_px));
            }
            sum += weight * color.at_clamped(qx, qy);
            weights += weight;
        }
        sum / weights
    })
}

#[test]
fn separable_computes_its_formula() {
    let _turn = views::turn();
    let lens = wide_lens();
    let color = noise(SIZE);
    let input = input(&color, &coc(), &lens);
    for (reach, thinning) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let method = Separable { reach, thinning, ..Separable::default() };
        let rows = filter_axis(&method, &input.color, &input, (1, 0));
        let wanted = filter_axis(&method, &rows, &input, (0, 1));
        let got = blurred(&method, &color, &lens, &coc());
        for (i, (g, w)) in got.pixels.iter().zip(&wanted.pixels).enumerate() {
            // Two images truncated to f16, 2^-11 each where values stay below 1.
            let error = (g.as_dvec3() - *w).abs().max_element();
            assert!(error < 2.0 / 2048.0 + 2e-5, "reach {reach} pixel {i}: {g} against {w}");
        }
    }
}

#[test]
fn separable_refuses_a_sharp_nearer_tap() {
    let _turn = views::turn();
    let lens = wide_lens();
    // A sharp white strip before a blurred black wall.
    let strip = |x| (30..36).contains(&x);
    let color = ColorImage::from_fn(SIZE, |x, _| if strip(x) { Vec3::ONE } else { Vec3::ZERO });
    let coc = Image::from_fn(SIZE, |x, _| if strip(x) { 0.0 } else { 12.0 });
    let out = blurred(&Separable::default(), &color, &lens, &coc);
    assert_eq!(out.at(29, 20), Vec3::ZERO, "nothing leaks out of the strip");
    assert_eq!(out.at(30, 20), Vec3::ONE, "and nothing into it");
}

#[test]
fn neighbours_reach_where_own_does_not() {
    let _turn = views::turn();
    let lens = wide_lens();
    let near = |x| x < 30;
    let color = ColorImage::from_fn(SIZE, |x, _| if near(x) { Vec3::ONE } else { Vec3::ZERO });
    let coc = Image::from_fn(SIZE, |x, _| if near(x) { -12.0 } else { 0.0 });
    let at =
        |reach| blurred(&Separable { reach, thinning: 1, ..Separable::default() }, &color, &lens, &coc).at(32, 20).x;
    assert_eq!(at(0), 0.0, "a blurred foreground ends at its edge");
    assert!(at(1) > 0.1, "it spreads over what is in focus: {}", at(1));
}

#[test]
fn separable_blurs_in_squares() {
    let _turn = views::turn();
    let lens = wide_lens();
    for c in [4.0f32, 9.0, 17.0] {
        let out = blurred(&Separable::default(), &point(uvec2(61, 61), 512.0), &lens, &Image::filled(uvec2(61, 61), c));
        for variance in variance_px2(&out) {
            // A box of width C with its ends ramped over a pixel each, sampled at pixels:
            // C^2/12 plus at most 1/6. f16 truncation is of no account.
            let wanted = f64::from(c * c) / 12.0;
            assert!(variance > wanted * 0.97 && variance < wanted + 0.25, "C = {c}: {variance} against {wanted}");
        }
    }
}

// ---- preblur ----

/// The blurred copy, in f64, with the pixels by which it begins outside the image.
fn blurred_copy(color: &Image<DVec3>) -> (Image<DVec3>, DVec2) {
    let size = (color.size + 3) / 4;
    let margin = 0.5 * (4.0 * size.as_dvec2() - color.size.as_dvec2());
    let reduced = Image::from_fn(size, |tx, ty| {
        let (low, high) = (4.0 * dvec2(f64::from(tx), f64::from(ty)) - margin, 4.0);
        let (mut sum, mut area) = (DVec3::ZERO, 0.0);
        for y in 0..color.size.y {
            for x in 0..color.size.x {
                let p = dvec2(f64::from(x), f64::from(y));
                let overlap = ((low + high).min(p + 1.0) - low.max(p)).max(DVec2::ZERO);
                sum += overlap.x * overlap.y * color.at(x, y);
                area += overlap.x * overlap.y;
            }
        }
        sum / area
    });
    let filtered = Image::from_fn(size, |x, y| {
        let mut sum = DVec3::ZERO;
        for (dx, dy) in (-1..=1).flat_map(|dy: i64| (-1..=1).map(move |dx: i64| (dx, dy))) {
            let weight = f64::from(((2 - dx.abs()) * (2 - dy.abs())) as i32) / 16.0;
            sum += weight * reduced.at_clamped(i64::from(x) + dx, i64::from(y) + dy);
        }
        sum
    });
    (filtered, margin)
}

fn bilinear(image: &Image<DVec3>, at: DVec2) -> DVec3 {
    let corner = (at - 0.5).floor();
    let w = at - 0.5 - corner;
    let texel = |dx: i64, dy: i64| image.at_clamped(corner.x as i64 + dx, corner.y as i64 + dy);
    texel(0, 0).lerp(texel(1, 0), w.x).lerp(texel(0, 1).lerp(texel(1, 1), w.x), w.y)
}

fn taps() -> impl Iterator<Item = DVec2> {
    let quadrant = [(0.2282895, 0.3384532), (0.6685826, 0.2302114), (0.5008804, 0.7631855)];
    quadrant.into_iter().flat_map(|(x, y)| [dvec2(x, y), dvec2(-x, y), dvec2(x, -y), dvec2(-x, -y)])
}

#[test]
fn the_taps_have_the_discs_second_moments_and_keep_apart() {
    let taps: Vec<_> = taps().collect();
    let mean: DVec2 = taps.iter().map(|t| *t * *t).sum::<DVec2>() / 12.0;
    assert!((mean - 0.25).abs().max_element() < 1e-6, "{mean}");
    for (i, a) in taps.iter().enumerate() {
        assert!(a.length() < 1.0);
        assert!(taps[..i].iter().all(|b| a.distance(*b) > 0.45));
    }
}

/// Scheuermann's gather in f64, for the CoC or ramp `blur_px` of each pixel.
fn preblurred(method: &Preblur, input: &Input, blur_px: &Image<f64>, full_px: f64) -> Image<DVec3> {
    let (copy, margin) = blurred_copy(&input.color);
    Image::from_fn(SIZE, |x, y| {
        let at = dvec2(f64::from(x), f64::from(y)) + 0.5;
        let radius = 0.5 * blur_px.at(x, y).abs();
        let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
        for tap in taps() {
            let sharp_at = at + radius * tap;
            let blurred_at = at + 4.0 * f64::from(method.radius_scale) * radius * tap;
            let p = sharp_at.floor().as_i64vec2();
            let blurriness = (blur_px.at_clamped(p.x, p.y).abs() / full_px).min(1.0);
            let nearer = input.z.at_clamped(p.x, p.y) > input.z.at(x, y);
            let weight = if method.leak_test && nearer { blurriness } else { 1.0 };
            let mixed = bilinear(&input.color, sharp_at).lerp(bilinear(&copy, (blurred_at + margin) / 4.0), blurriness);
            sum += weight * mixed;
            weights += weight;
        }
        if weights > 0.0 { sum / weights } else { input.color.at(x, y) }
    })
}

#[test]
fn preblur_computes_its_formula() {
    let _turn = views::turn();
    let lens = wide_lens();
    let color = noise(SIZE);
    let input = input(&color, &coc(), &lens);
    let bounds = input.coc_px.pixels.iter().fold([0.0f64, 0.0], |[a, b], c| [a.min(*c), b.max(*c)]);
    let depth = depths_of(&lens, &coc());
    for (blurriness, leak_test) in [(0, true), (1, true), (1, false)] {
        let method = Preblur { blurriness, leak_test, ..Preblur::default() };
        let ramp = Ramp::through(&lens, bounds, f64::from(method.ramp_share));
        let (blur, full) = match blurriness {
            0 => (depth.map(|d| ramp.coc_diameter_px(f64::from(d))), bounds[1].max(-bounds[0]).max(10.0)),
            _ => (input.coc_px.clone(), 10.0),
        };
        let wanted = preblurred(&method, &input, &blur, full);
        let got = blurred(&method, &color, &lens, &coc());
        let error = |(g, w): (&Vec3, &DVec3)| (g.as_dvec3() - *w).abs().max_element();
        let errors: Vec<f64> = got.pixels.iter().zip(&wanted.pixels).map(error).collect();
        // Samplers weigh texels in 1/256ths, and a mean of 12 such reads is off by at most
        // 1/256 of the contrast; f16 truncates three times by 2^-11. Where a tap lies on
        // the edge of a pixel its depth may be either one's: 1/12 of the contrast, rarely.
        let off = errors.iter().filter(|e| **e > 1.0 / 256.0 + 3.0 / 2048.0).count();
        assert!(off <= SIZE.element_product() as usize / 200, "blurriness {blurriness}: {off} pixels are off");
        assert!(errors.iter().all(|e| *e < 0.2));
    }
}

#[test]
fn the_ramp_is_linear_in_depth_and_meets_the_lens() {
    let lens = lens(12.0, 2.0);
    let ramp = Ramp::through(&lens, [-20.0, 11.0], 0.75);
    assert_eq!(ramp.coc_diameter_px(2.0), 0.0);
    for c in [-15.0, 8.25] {
        let d = lens.coc().depth_at(c);
        assert!((ramp.coc_diameter_px(d) - c).abs() < 1e-9);
        // Half of it half-way: linear in depth, which the lens is not.
        assert!((ramp.coc_diameter_px(0.5 * (d + 2.0)) - 0.5 * c).abs() < 1e-9);
    }
    assert_eq!(ramp.coc_diameter_px(f64::INFINITY), 11.0);
    // Before the near end the line goes on, to the CoC in view at most.
    assert!((ramp.coc_diameter_px(0.0) - (-15.0 * 2.0 / (2.0 - lens.coc().depth_at(-15.0))).max(-20.0)).abs() < 1e-9);
}

#[test]
fn a_ramp_with_the_focus_at_infinity_is_finite() {
    let lens = Lens { focus_distance_m: f64::INFINITY, ..lens(12.0, 2.0) };
    let ramp = Ramp::through(&lens, [-6.0, 0.0], 0.75);
    assert!(ramp.focus_m.is_finite());
    assert_eq!(ramp.coc_diameter_px(f64::INFINITY), 0.0);
    assert!(ramp.coc_diameter_px(lens.coc().depth_at(-4.5)) < -4.49);
}

// ---- all ----

fn all() -> Vec<Box<dyn Method>> {
    vec![
        Box::new(Preblur::default()),
        Box::new(Preblur { blurriness: 1, ..Preblur::default() }),
        Box::new(Separable::default()),
        Box::new(Separable { reach: 1, thinning: 1, ..Separable::default() }),
        Box::new(Linear { normalise: true, ..Linear::default() }),
    ]
}

#[test]
fn every_option_keeps_a_constant_colour_and_mirrors() {
    let _turn = views::turn();
    let lens = wide_lens();
    let constant = ColorImage::filled(SIZE, Vec3::new(0.3, 1.1, 7.0));
    for method in all() {
        let id = method.about().id;
        for p in &blurred(&*method, &constant, &lens, &coc()).pixels {
            // The input in f16, and one truncation.
            assert!(((*p - Vec3::new(0.3, 1.1, 7.0)) / *p).abs().max_element() < 1.5 / 1024.0, "{id}: {p}");
        }
        let there = mirrored(&blurred(&*method, &noise(SIZE), &lens, &coc()));
        let here = blurred(&*method, &mirrored(&noise(SIZE)), &lens, &mirrored(&coc()));
        // Steps of f16 twice, and of 1/256 in the sampler's weights.
        let difference = views::greatest_difference(&here, &there);
        assert!(difference < 2.0 / 1024.0 + 2.0 / 256.0, "{id}: {difference}");
    }
}

#[test]
fn what_is_in_focus_stays_and_what_is_not_finite_does_not_spread() {
    let _turn = views::turn();
    let lens = wide_lens();
    let depth = depths_of(&lens, &coc());
    let mut color = noise(SIZE);
    color.pixels[(20 * SIZE.x + 60) as usize] = Vec3::splat(f32::INFINITY);
    color.pixels[(20 * SIZE.x + 20) as usize] = Vec3::splat(f32::NAN);
    let near_m = f64::from(depth.pixels.iter().copied().fold(f32::INFINITY, f32::min));
    // Not through `View::of_image`, which repairs such pixels: a scene can draw them.
    let half = |v: f32| if v.is_infinite() { f32::NAN } else { v };
    let layer = Layer {
        color: defocus::gpu::upload(gpu(), "broken", &color.map(|p| Vec3::from_array(p.to_array().map(half)))),
        depth: defocus::gpu::upload_scalar(gpu(), "depth", &depth.map(|d| (near_m / f64::from(d)) as f32)),
    };
    for method in all() {
        let mut view = View::of_layer(layer.clone(), near_m, 1.0);
        let out = views::render(&*method, &mut view, &lens, Precision::Half);
        let broken = out.pixels.iter().filter(|p| !p.is_finite()).count();
        assert_eq!(broken, 0, "{}", method.about().id);
    }
    let sharp = noise(SIZE);
    for method in all().into_iter().take(3) {
        let out = blurred(&*method, &sharp, &lens, &coc());
        let half = |v: f32| half::f16::from_f32(v).to_f32();
        // The strip in focus, away from its edges; these methods gather over their own CoC.
        assert_eq!(out.at(42, 20).to_array(), sharp.at(42, 20).to_array().map(half), "{}", method.about().id);
    }
}

#[test]
fn overscan_changes_the_border_only() {
    let _turn = views::turn();
    let wall = common::quad(4.0, glam::vec2(-20.0, -20.0), glam::vec2(20.0, 20.0), 0);
    let mut scene = common::scene(vec![wall], vec![common::textured()]);
    scene.textures = vec![std::sync::Arc::new(common::uv_grid_texture(uvec2(256, 256)))];
    let scene = defocus::view::GpuScene::new(gpu(), &scene, defocus::view::SurfaceOptions::default());
    let lens = lens(16.0, 2.0);
    for method in all().into_iter().filter(|m| m.about().id == "separable") {
        let at = |overscan_px| {
            let view = View::of_scene(scene.clone(), common::front_camera(), uvec2(48, 32), overscan_px);
            views::render(&*method, &mut view.expect("a small view"), &lens, Precision::Half)
        };
        let (without, with) = (at(0), at(8));
        // C = 8 px: filters end 4 px and a ramp from their centre, twice.
        let inner = |image: &ColorImage| image.crop(uvec2(6, 6), uvec2(36, 20));
        // Depth of the larger frame is interpolated from other triangle setups.
        assert!(views::greatest_difference(&inner(&without), &inner(&with)) < 4.0 / 1024.0);
        assert!(
            views::greatest_difference(&without, &with) > views::greatest_difference(&inner(&without), &inner(&with))
        );
    }
}

#[test]
fn nothing_to_filter_records_no_filter() {
    let _turn = views::turn();
    let lens = wide_lens();
    let mut view = views::view_of(&noise(SIZE), &depths_of(&lens, &Image::filled(SIZE, 0.8)));
    let mut frame = gpu().frame();
    methods::record(&Separable::default(), &mut frame, &mut view, &lens).expect("a good lens");
    let stats = frame.finish().stats;
    // One pass finds the bounds of the depth.
    assert_eq!(stats.passes, 1, "{stats:?}");
    assert!(stats.skipped.contains_key("no filter reaches another pixel"));
}
