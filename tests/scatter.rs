//! Sorted scattering against an f64 mirror.

mod common;

use common::gpu;
use defocus::aperture::Aperture;
use defocus::gpu::download;
use defocus::image::{ColorImage, DepthImage, Image};
use defocus::lens::Lens;
use defocus::methods::sprites::SpriteTable;
use defocus::methods::{self, Scatter};
use defocus::view::View;
use glam::{UVec2, Vec3, uvec2, vec3};

const SIZE: UVec2 = uvec2(37, 26);

fn hash(i: u32) -> u32 {
    let x = (i ^ 61 ^ (i >> 16)).wrapping_mul(0x27D4_EB2D);
    x ^ (x >> 15)
}

/// Noise, and depths of which many are equal.
fn images() -> (ColorImage, DepthImage) {
    let unit = |i: u32| (hash(i) % 1000) as f32 / 1000.0;
    let color =
        Image::from_fn(SIZE, |x, y| vec3(unit(x * 64 + y), unit(7000 + x * 64 + y), unit(20_000 + x + 100 * y)));
    let depths = [0.8, 1.0, 2.0, 2.5, 6.0, f32::INFINITY];
    let depth = Image::from_fn(SIZE, |x, y| depths[(hash(x / 3 + 50 * (y / 2)) % 6) as usize]);
    (color, depth)
}

fn scattered(scatter: &Scatter, color: &ColorImage, depth: &DepthImage, lens: &Lens) -> ColorImage {
    let mut view = View::of_image(gpu(), color, depth, 0.8).unwrap();
    let mut frame = gpu().frame();
    let texture = methods::record(scatter, &mut frame, &mut view, lens).unwrap();
    frame.finish();
    download(gpu(), &texture)
}

/// Pixels from far to near, those of one depth row by row, then blended and divided.
fn mirror(color: &ColorImage, depth: &DepthImage, lens: &Lens) -> Vec<[f64; 3]> {
    let table = SpriteTable::of(&lens.aperture);
    let mut order: Vec<usize> = (0..depth.pixels.len()).collect();
    order.sort_by(|a, b| depth.pixels[*b].total_cmp(&depth.pixels[*a]));
    let at = |i: usize| uvec2(i as u32 % SIZE.x, i as u32 / SIZE.x).as_dvec2();
    let mut blended = vec![[0.0; 4]; order.len()];
    for p in order {
        let c = lens.coc_diameter_px(f64::from(depth.pixels[p]));
        let rgb = color.pixels[p].to_array().map(|v| half::f16::from_f32(v).to_f64());
        for (q, sum) in blended.iter_mut().enumerate() {
            let alpha = table.share(at(q) - at(p), c);
            for (sum, v) in sum.iter_mut().zip([rgb[0], rgb[1], rgb[2], 1.0]) {
                *sum = alpha * v + (1.0 - alpha) * *sum;
            }
        }
    }
    blended.iter().map(|b| [b[0] / b[3], b[1] / b[3], b[2] / b[3]]).collect()
}

#[test]
fn one_order_is_what_the_mirror_blends() {
    let (color, depth) = images();
    for aperture in [Aperture::Disc, Aperture::polygon(3)] {
        let lens = Lens { aperture, ..common::lens(9.0, 2.0) };
        let image = scattered(&Scatter { symmetric: false }, &color, &depth, &lens);
        let expected = mirror(&color, &depth, &lens);
        for (i, (p, e)) in image.pixels.iter().zip(&expected).enumerate() {
            // Some hundred f32 blends, and f32 shares of spots down to 1/40: 1e-5 each at most.
            let error = (0..3).map(|k| (f64::from(p[k]) - e[k]).abs()).fold(0.0, f64::max);
            assert!(error < 2e-4, "{:?}, pixel {i}: {p} of {e:?}", lens.aperture);
        }
    }
}

#[test]
fn nearer_sharp_pixels_take_nothing_from_behind() {
    let lens = common::lens(16.0, 2.0);
    let in_front = |x: u32| x < SIZE.x / 2;
    let color = Image::from_fn(SIZE, |x, _| if in_front(x) { vec3(0.0, 1.0, 0.0) } else { vec3(1.0, 0.0, 0.0) });
    let depth = Image::from_fn(SIZE, |x, _| if in_front(x) { 2.0 } else { f32::INFINITY });
    let image = scattered(&Scatter::default(), &color, &depth, &lens);
    for (i, p) in image.pixels.iter().enumerate() {
        if in_front(i as u32 % SIZE.x) {
            // The opaque sprite replaces what was there but for the rounding of its share.
            assert!((*p - Vec3::Y).abs().max_element() < 1e-6, "pixel {i} is {p}");
        }
    }
}

#[test]
fn the_mean_of_the_orders_prefers_no_side() {
    let lens = common::lens(24.0, 2.0);
    let size = uvec2(41, 41);
    let color = Image::from_fn(size, |x, y| if uvec2(x, y) == size / 2 { Vec3::ONE } else { Vec3::ZERO });
    let depth = Image::filled(size, lens.coc().depth_at(11.0) as f32);
    let centroid = |scatter: &Scatter| {
        let image = scattered(scatter, &color, &depth, &lens);
        let moment = |f: &dyn Fn(u32, u32) -> f64| -> f64 {
            let at = |i: usize| f(i as u32 % size.x, i as u32 / size.x);
            image.pixels.iter().enumerate().map(|(i, p)| at(i) * f64::from(p.y)).sum()
        };
        let total = moment(&|_, _| 1.0);
        [moment(&|x, _| f64::from(x)) / total - 20.0, moment(&|_, y| f64::from(y)) / total - 20.0]
    };
    let symmetric = centroid(&Scatter { symmetric: true });
    assert!(symmetric.iter().all(|v| v.abs() < 1e-3), "leans by {symmetric:?} px");
    let one_order = centroid(&Scatter { symmetric: false });
    // Of the rows above and below a pixel, those drawn later weigh up to e times as much.
    assert!(one_order[1].abs() > 0.3, "one order leans by {one_order:?} px only: then why draw four?");
}
