//! `opaque` and `pyramid`: their weights, an f64 mirror, silhouettes, and how wide they blur.

mod common;
mod opaque_mirror;

use common::gpu;
use defocus::gpu::{Precision, download};
use defocus::image::{ColorImage, DepthImage, Image};
use defocus::lens::Lens;
use defocus::methods::{self, Method, Opaque, Pyramid, Spacing, SpacingCalibration, pyramid_variance_px2};
use defocus::view::View;
use glam::{UVec2, Vec3, uvec2, vec3};
use opaque_mirror::{Kind, Mirror};
use std::collections::BTreeMap;

const SIZE: UVec2 = uvec2(52, 38);

/// f32 on the GPU: 2^-24 a rounding of values up to 1, fewer than a hundred in sequence, and
/// a little for the power that undoes the glow.
const ROUNDINGS: f64 = 1e-5;

fn render(method: &dyn Method, color: &ColorImage, depth: &DepthImage, lens: &Lens) -> ColorImage {
    let mut view = View::of_image(gpu(), color, depth, 0.8).unwrap();
    let mut frame = gpu().frame();
    frame.precision = Precision::Full;
    let texture = methods::record(method, &mut frame, &mut view, lens).unwrap();
    frame.finish();
    download(gpu(), &texture)
}

fn spacings() -> [Spacing; 2] {
    let paper = Spacing { calibration: SpacingCalibration::Paper as usize, ..Spacing::default() };
    [Spacing::default(), paper]
}

fn method_of(kind: Kind, spacing: &Spacing) -> Box<dyn Method> {
    let spacing = spacing.clone();
    match kind {
        Kind::Opaque { transparent_border } => Box::new(Opaque { spacing, transparent_border }),
        Kind::Pyramid { repeated_inclusion } => {
            Box::new(Pyramid { spacing, repeated_inclusion: repeated_inclusion as f32 })
        }
    }
}

const OPAQUE: Kind = Kind::Opaque { transparent_border: true };
const PYRAMID: Kind = Kind::Pyramid { repeated_inclusion: 0.0 };

/// Colours that f16 holds exactly.
fn busy_image() -> ColorImage {
    Image::from_fn(SIZE, |x, y| {
        let bar = if (x / 5 + y / 7) % 2 == 0 { 0.875 } else { 0.125 };
        vec3(bar, x as f32 / 64.0, (x * 7 + y * 13) as f32 % 16.0 / 16.0)
    })
}

/// A near object, a step, a slope and a far wall.
fn busy_depth() -> DepthImage {
    Image::from_fn(SIZE, |x, y| match (x, y) {
        (8..=20, 6..=25) => 0.9,
        (14..=34, 18..=30) => 1.5,
        (36.., _) => 1.0 + y as f32 * 0.125,
        _ => 8.0,
    })
}

#[test]
fn the_shaders_compute_what_the_mirror_computes() {
    let (color, depth) = (busy_image(), busy_depth());
    let lens = common::lens(14.0, 2.0);
    let kinds =
        [OPAQUE, Kind::Opaque { transparent_border: false }, PYRAMID, Kind::Pyramid { repeated_inclusion: 0.25 }];
    for kind in kinds {
        for spacing in spacings() {
            let image = render(&*method_of(kind, &spacing), &color, &depth, &lens);
            let mirror = Mirror::new(&color, &depth, &lens, &spacing, kind);
            let differences =
                image.pixels.iter().zip(mirror.render()).map(|(pixel, expected)| {
                    (0..3).map(|c| (f64::from(pixel[c]) - expected[c]).abs()).fold(0.0, f64::max)
                });
            let worst = differences.fold(0.0, f64::max);
            println!("{kind:?} {spacing:?}: differs by at most {worst:.2e}");
            assert!(worst < ROUNDINGS, "{kind:?} {spacing:?}: differs by {worst}");
        }
    }
}

#[test]
fn white_stays_white_at_any_depth() {
    // Each pixel at another depth, from 0.4 m on in steps of 0.2 %: wherever a depth lies between two
    // sub-images, the weights of those that it belongs to blend to one.
    let size = uvec2(64, 63);
    let depth = Image::from_fn(size, |x, y| 0.4 * 1.002f32.powi((y * size.x + x) as i32));
    let white = Image::filled(size, Vec3::ONE);
    let lens = common::lens(30.0, 2.0);
    for spacing in spacings() {
        for kind in [OPAQUE, PYRAMID] {
            let image = render(&*method_of(kind, &spacing), &white, &depth, &lens);
            let worst = image.pixels.iter().map(|p| (*p - Vec3::ONE).abs().max_element()).fold(0.0, f32::max);
            assert!(worst < ROUNDINGS as f32, "{kind:?} {spacing:?}: white is off by {worst}");
        }
    }
}

#[test]
fn an_opaque_object_of_any_shape_hides_what_is_behind_all_of_it() {
    // Green specks, lines and holes of a pixel before a red wall. The glow must not lower the opacity of
    // what is opaque, however little of it there is.
    let is_object = |x: u32, y: u32| match x {
        0..=15 => (x * 7 + y * 13).is_multiple_of(5),
        16..=31 => x.is_multiple_of(3) || y.is_multiple_of(7),
        _ => (x % 6, y % 6) != (2, 3),
    };
    let color = Image::from_fn(SIZE, |x, y| if is_object(x, y) { Vec3::Y } else { Vec3::X });
    let lens = common::lens(14.0, 2.0);
    for spacing in spacings() {
        for c_px in [-2.0, -5.0, -10.0] {
            let [near, wall] = [c_px, 0.0].map(|c| lens.coc().depth_at(c) as f32);
            let depth = Image::from_fn(SIZE, |x, y| if is_object(x, y) { near } else { wall });
            let image = render(&*method_of(OPAQUE, &spacing), &color, &depth, &lens);
            for (x, y) in (0..SIZE.y).flat_map(|y| (0..SIZE.x).map(move |x| (x, y))).filter(|(x, y)| is_object(*x, *y))
            {
                let red = image.at(x, y).x;
                assert!(red < ROUNDINGS as f32, "{spacing:?} c {c_px}: {red} of the wall shows at {x}, {y}");
            }
        }
    }
}

#[test]
fn flat_white_stays_white_unless_pixels_are_included_repeatedly() {
    let white = Image::filled(SIZE, Vec3::ONE);
    let lens = common::lens(14.0, 2.0);
    for spacing in spacings() {
        for kind in [OPAQUE, Kind::Opaque { transparent_border: false }, PYRAMID] {
            let image = render(&*method_of(kind, &spacing), &white, &busy_depth(), &lens);
            let worst = image.pixels.iter().map(|p| (*p - Vec3::ONE).abs().max_element()).fold(0.0, f32::max);
            assert!(worst < ROUNDINGS as f32, "{kind:?} {spacing:?}: white is off by {worst}");
        }
        let repeated = Kind::Pyramid { repeated_inclusion: 0.25 };
        let image = render(&*method_of(repeated, &spacing), &white, &busy_depth(), &lens);
        let mean = image.pixels.iter().map(|p| p.x).sum::<f32>() / image.pixels.len() as f32;
        println!("{spacing:?}: a quarter of what is covered included again makes white {mean}");
        assert!(mean > 1.05, "{mean}");
    }
}

/// Left half at one CoC and value, right half at another.
fn edge(lens: &Lens, c_px: [f64; 2], value: [f32; 2]) -> (ColorImage, DepthImage) {
    let size = uvec2(128, 32);
    let side = |x: u32| usize::from(x >= 64);
    let color = Image::from_fn(size, |x, _| Vec3::splat(value[side(x)]));
    let depth = Image::from_fn(size, |x, _| lens.coc().depth_at(c_px[side(x)]) as f32);
    (color, depth)
}

#[test]
fn silhouettes_have_no_bright_or_dark_halo() {
    let lens = common::lens(20.0, 2.0);
    let tolerance = ROUNDINGS as f32;
    for spacing in spacings() {
        for kind in [OPAQUE, PYRAMID] {
            for c_px in [[-10.0, 0.0], [0.0, 10.0], [-10.0, 10.0], [-7.0, 13.0], [4.0, 15.0]] {
                for value in [[0.0, 1.0], [1.0, 0.0]] {
                    let (color, depth) = edge(&lens, c_px, value);
                    let image = render(&*method_of(kind, &spacing), &color, &depth, &lens);
                    let what = format!("{kind:?} {spacing:?} c {c_px:?} values {value:?}");
                    let row: Vec<f32> = (0..128).map(|x| image.at(x, 16).x).collect();
                    let (lowest, highest) = row.iter().fold((f32::MAX, f32::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
                    assert!(lowest >= -tolerance && highest <= 1.0 + tolerance, "{what}: {lowest} to {highest}");
                    // A halo is a value beyond which the other side's comes again.
                    let rises = value[1] > value[0];
                    let step = |pair: &[f32]| if rises { pair[0] - pair[1] } else { pair[1] - pair[0] };
                    let back = row.windows(2).map(step).fold(f32::MIN, f32::max);
                    assert!(back <= tolerance, "{what}: goes back by {back}: {row:?}");
                    assert!((row[0] - value[0]).abs() <= tolerance && (row[127] - value[1]).abs() <= tolerance);
                    if kind == OPAQUE && c_px[0] == -10.0 {
                        // An opaque object stays opaque up to its edge.
                        assert!((row[63] - value[0]).abs() <= tolerance, "{what}: shows through at its edge");
                    }
                }
            }
        }
    }
}

/// What a pyramid of `levels` makes of a white pixel at `x` on a line: (position, value).
fn response(levels: u32, x: i64) -> BTreeMap<i64, f64> {
    let mut texels = BTreeMap::from([(x, 1.0)]);
    for _ in 0..levels {
        let mut coarser = BTreeMap::new();
        for (q, value) in texels {
            for p in q.div_euclid(2) - 1..=q.div_euclid(2) + 1 {
                if (2 * p - 1..=2 * p + 2).contains(&q) {
                    *coarser.entry(p).or_insert(0.0) += value / 4.0;
                }
            }
        }
        texels = coarser;
    }
    for _ in 0..levels {
        let (first, last) = (*texels.keys().next().unwrap(), *texels.keys().last().unwrap());
        let read = |p: i64| texels.get(&p).copied().unwrap_or(0.0);
        let expand = |q: i64| 0.75 * read(q.div_euclid(2)) + 0.25 * read(q.div_euclid(2) + 2 * q.rem_euclid(2) - 1);
        texels = (2 * first - 2..=2 * last + 3).map(|q| (q, expand(q))).collect();
    }
    texels
}

/// Variance about the point itself, and about the centroid of what became of it.
fn variances(response: &BTreeMap<i64, f64>, x: i64) -> [f64; 2] {
    let sum = |f: &dyn Fn(f64) -> f64| response.iter().map(|(q, v)| v * f((q - x) as f64)).sum::<f64>();
    let total = sum(&|_| 1.0);
    let mean = sum(&|q| q) / total;
    let about_point = sum(&|q| q * q) / total;
    [about_point, about_point - mean * mean]
}

#[test]
fn a_level_blurs_as_wide_as_the_formula_says() {
    for levels in 1..=6 {
        let phases = 1i64 << levels;
        let total: f64 = (0..phases).map(|x| variances(&response(levels, x), x)[0]).sum();
        let (mean, formula) = (total / phases as f64, pyramid_variance_px2(levels));
        assert!((mean / formula - 1.0).abs() < 1e-12, "{levels} levels: {mean}, formula {formula}");
    }
}

/// The two sub-images that a flat plane with CoC c is blended from, with their shares.
fn blend_of_plane(kind: Kind, spacing: &Spacing, lens: &Lens, c_px: f64) -> [(i32, f64); 2] {
    let back = (-12..=12).find(|i| spacing.coc_px(lens, *i) >= c_px).unwrap();
    let [near, own, far] =
        [spacing.coc_px(lens, back - 1), c_px, spacing.coc_px(lens, back)].map(|c| lens.coc().depth_at(c));
    let measured = spacing.calibration == SpacingCalibration::Measured as usize;
    let variance = |i: i32| f64::from(i.signum()) * pyramid_variance_px2(i.unsigned_abs());
    let share = if measured {
        let sigma = lens.aperture.sigma_per_coc() * c_px;
        (sigma * sigma.abs() - variance(back - 1)) / (variance(back) - variance(back - 1))
    } else if far.is_infinite() {
        0.0
    } else {
        (own - near) / (far - near)
    };
    let in_front = match kind {
        // The glow multiplies |i| + 1 equal transparencies; "measured" undoes that.
        Kind::Opaque { .. } if !measured => 1.0 - share.powi((back - 1).abs() + 1),
        _ => 1.0 - share,
    };
    [(back - 1, in_front), (back, 1.0 - in_front)]
}

/// Variances of a plane's blur, as `variances`, in x, for a point at `x`.
fn plane_variances(blend: &[(i32, f64); 2], x: i64) -> [f64; 2] {
    let mut mixed = BTreeMap::new();
    for (i, share) in blend {
        for (q, value) in response(i.unsigned_abs(), x) {
            *mixed.entry(q).or_insert(0.0) += share * value;
        }
    }
    variances(&mixed, x)
}

#[test]
fn planes_are_blurred_as_wide_as_the_lens_blurs_them() {
    let lens = common::lens(200.0, 2.0);
    let [measured, paper] = spacings();
    println!("c px | lens sigma px | measured | at single points | opaque, paper | pyramid, paper");
    let mut extremes = [0.0f64, 0.0];
    for c in (1..=64).flat_map(|c| [-f64::from(c), f64::from(c)]) {
        let wanted = lens.aperture.sigma_per_coc() * c.abs();
        let mean_sigma = |kind, spacing| {
            let blend = blend_of_plane(kind, spacing, &lens, c);
            blend.iter().map(|(i, share)| share * pyramid_variance_px2(i.unsigned_abs())).sum::<f64>().sqrt()
        };
        let own = mean_sigma(OPAQUE, &measured);
        let blend = blend_of_plane(OPAQUE, &measured, &lens, c);
        let single = (0..64).map(|x| plane_variances(&blend, x)[1].sqrt() / wanted - 1.0);
        let [low, high] = single.fold([0.0f64, 0.0], |[l, h], e| [l.min(e), h.max(e)]);
        extremes = [extremes[0].min(low), extremes[1].max(high)];
        let percent = |sigma: f64| 100.0 * (sigma / wanted - 1.0);
        let [opaque, pyramid] = [OPAQUE, PYRAMID].map(|kind| percent(mean_sigma(kind, &paper)));
        println!(
            "{c:4} | {wanted:6.3} | {own:6.3} | {:+5.1} % to {:+5.1} % | {opaque:+5.1} % | {pyramid:+5.1} %",
            100.0 * low,
            100.0 * high
        );
        assert!((own / wanted - 1.0).abs() < 1e-12, "c = {c}: {own} of {wanted}");
    }
    println!("single points: {extremes:?}");
    // Where a point lies on the pyramid's grid decides how wide its own image is.
    assert!(extremes[0] > -0.14 && extremes[1] < 0.14, "{extremes:?}");
}

#[test]
fn a_white_point_spreads_as_the_mirror_says() {
    let lens = common::lens(200.0, 2.0);
    // Wider than any kernel: at the border the glow rescales what a transparent frame takes.
    let size = uvec2(320, 320);
    for c_px in [-40.0, -9.0, -2.0, 1.0, 4.0, 32.0] {
        let depth = Image::filled(size, lens.coc().depth_at(c_px) as f32);
        let point = size / 2 + uvec2(5, 0);
        let color = Image::from_fn(size, |x, y| if uvec2(x, y) == point { Vec3::splat(1024.0) } else { Vec3::ZERO });
        for (kind, spacing) in [OPAQUE, PYRAMID].into_iter().flat_map(|k| spacings().map(|s| (k, s))) {
            let image = render(&*method_of(kind, &spacing), &color, &depth, &lens);
            let column = |x: u32| (0..size.y).map(|y| f64::from(image.at(x, y).x)).sum::<f64>();
            let on_line = (0..size.x).map(|x| (i64::from(x) - 160, column(x))).collect();
            let found = variances(&on_line, 5)[0].sqrt();
            let expected = plane_variances(&blend_of_plane(kind, &spacing, &lens, c_px), 5)[0].sqrt();
            // f32 depth moves c by 1e-5 of it; tails of f32 weigh by the square of distance.
            assert!((found / expected - 1.0).abs() < 2e-3, "{kind:?} {spacing:?} c {c_px}: {found} of {expected}");
        }
    }
}
