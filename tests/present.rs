//! The present shader against `display` on the CPU, and the overlays against the lens.

mod common;

use defocus::display::{Display, LUMINANCE, ToneMap};
use defocus::gpu::{Gpu, download_rgba8, upload, upload_scalar};
use defocus::image::{ColorImage, DepthImage, Image};
use defocus::present::{self, DIFFERENCE_FULL_SCALE, DifferenceOf, Map, Numbers, Overlay, Place, Slice};
use defocus::view::View;
use glam::{UVec2, Vec3, dvec2, uvec2, vec3};
use half::f16;
use std::sync::OnceLock;

fn gpu() -> &'static Gpu {
    static GPU: OnceLock<Gpu> = OnceLock::new();
    GPU.get_or_init(|| Gpu::open(None).expect("tests need a graphics adapter; a software one will do"))
}

/// Ten stops in both directions, saturated and negative colours, exactly as f16 holds them.
fn chart() -> ColorImage {
    let tint = [Vec3::ONE, vec3(1.0, 0.1, 0.0), vec3(0.2, 1.0, 0.3), vec3(0.0, 0.3, 1.0), vec3(1.0, -0.02, 0.5)];
    let stored = |v: f32| f16::from_f32(v).to_f32();
    Image::from_fn(uvec2(37, 5), |x, y| {
        let color = tint[y as usize] * ((x as f32 - 22.0) * 0.55).exp2();
        vec3(stored(color.x), stored(color.y), stored(color.z))
    })
}

/// Greatest difference from the quantised values, in steps of 1/255.
fn worst_steps(shown: &Image<[u8; 4]>, expected: impl Fn(u32, u32) -> Vec3) -> f32 {
    assert!(shown.pixels.iter().all(|p| p[3] == 255), "alpha is 1 everywhere");
    let size = shown.size;
    let at = |i: u32| (i % size.x, i / size.x);
    let error = |i: u32| {
        let (x, y) = at(i);
        let [r, g, b, _] = shown.at(x, y).map(f32::from);
        (vec3(r, g, b) - expected(x, y) * 255.0).abs().max_element()
    };
    (0..size.x * size.y).map(error).fold(0.0, f32::max)
}

#[test]
fn shows_what_the_cpu_shows() {
    let chart = chart();
    let color = upload(gpu(), "chart", &chart);
    for tone_map in ToneMap::ALL {
        for exposure_ev in [-2.0, 0.0, 1.5] {
            let display = Display { exposure_ev, tone_map };
            let mut frame = gpu().frame();
            let picture = present::picture(&mut frame, &color, &display);
            frame.finish();
            let shown = download_rgba8(gpu(), &picture);
            // Half a step of quantisation; the other half is for the GPU's pow and log2.
            let worst = worst_steps(&shown, |x, y| display.encoded(chart.at(x, y)));
            assert!(worst <= 1.0, "{tone_map} at {exposure_ev} EV is {worst} steps of 1/255 off");
        }
    }
}

/// Depth rises from left to right: 1 m to 8 m, the last column is at infinity.
fn ramp(size: UVec2) -> DepthImage {
    Image::from_fn(size, |x, _| if x + 1 == size.x { f32::INFINITY } else { 1.0 + 7.0 * x as f32 / size.x as f32 })
}

fn grey_view(size: UVec2) -> (View, defocus::gpu::Texture) {
    let grey = ColorImage::filled(size, Vec3::splat(0.25));
    let view = View::of_image(gpu(), &grey, &ramp(size), 1.0).expect("a small image can be drawn");
    (view, upload(gpu(), "grey", &grey))
}

fn overlaid(overlay: Overlay) -> (Image<[u8; 4]>, Vec3) {
    let (mut view, color) = grey_view(uvec2(64, 4));
    let display = Display::default();
    let mut frame = gpu().frame();
    let shown = present::overlay(&mut frame, &mut view, &color, &common::lens(10.0, 3.0), &display, overlay);
    frame.finish();
    (download_rgba8(gpu(), &shown), display.encoded(Vec3::splat(0.25)))
}

fn colour(map: Map, t: f32) -> Vec3 {
    Vec3::from(map.srgb8(t).map(|v| f32::from(v) / 255.0))
}

/// The map has 256 steps: a value between two of them may fall to either, and the
/// steepest map changes by 2.6 steps of 1/255 from one to the next.
const MAP_STEPS: f32 = 3.0;

#[test]
fn coc_overlay_shows_the_signed_coc() {
    let opacity = 0.75;
    let (shown, grey) = overlaid(Overlay::Coc { full_scale_px: 20.0, opacity });
    let lens = common::lens(10.0, 3.0);
    let depths = ramp(shown.size);
    let expected = |x, y| {
        let c = lens.coc_diameter_px(f64::from(depths.at(x, y))) as f32;
        grey.lerp(colour(Map::Diverging, 0.5 + 0.5 * c / 20.0), opacity)
    };
    assert!(worst_steps(&shown, expected) <= MAP_STEPS);
}

#[test]
fn depth_overlay_shows_reciprocal_depth() {
    for opacity in [0.3, 1.0] {
        let (shown, grey) = overlaid(Overlay::Depth { opacity });
        let depths = ramp(shown.size);
        // The nearest depth is 1 m.
        let expected = |x, y| grey.lerp(colour(Map::Sequential, 1.0 / depths.at(x, y)), opacity);
        let worst = worst_steps(&shown, expected);
        assert!(worst <= MAP_STEPS, "{worst} steps off at an opacity of {opacity}");
    }
}

#[test]
fn zone_keeps_what_is_sharp() {
    let (shown, grey) = overlaid(Overlay::Zone { acceptable_px: 2.0 });
    let lens = common::lens(10.0, 3.0);
    let depths = ramp(shown.size);
    let expected = |x, y| match lens.coc_diameter_px(f64::from(depths.at(x, y))) {
        c if c < -2.0 => grey.lerp(colour(Map::Diverging, 0.0), 0.45),
        c if c > 2.0 => grey.lerp(colour(Map::Diverging, 1.0), 0.45),
        _ => grey,
    };
    assert!(worst_steps(&shown, expected) <= 1.0);
    let sharp = shown.pixels.iter().filter(|p| p[0] == p[2]).count();
    assert!(sharp > 0 && sharp < shown.pixels.len(), "the ramp has sharp and blurred parts, {sharp} pixels are sharp");
}

#[test]
fn difference_is_absolute_and_on_the_fixed_scale() {
    let size = uvec2(32, 2);
    let a = ColorImage::from_fn(size, |x, _| Vec3::splat(x as f32 / 32.0));
    let b = ColorImage::filled(size, vec3(0.25, 0.25, 0.5));
    let display = Display { tone_map: ToneMap::Reinhard, ..Display::default() };
    let textures = [&a, &b].map(|image| upload(gpu(), "image", image));
    let mut frame = gpu().frame();
    let ab = present::difference(&mut frame, &textures[0], &textures[1], &display, DifferenceOf::Display, 1.0);
    let ba = present::difference(&mut frame, &textures[1], &textures[0], &display, DifferenceOf::Display, 1.0);
    frame.finish();
    let (ab, ba) = (download_rgba8(gpu(), &ab), download_rgba8(gpu(), &ba));
    assert_eq!(ab, ba, "an absolute difference has no direction");
    let expected = |x, y| {
        let d = (display.encoded(a.at(x, y)) - display.encoded(b.at(x, y))).abs().max_element();
        colour(Map::Error, d / DIFFERENCE_FULL_SCALE)
    };
    assert!(worst_steps(&ab, expected) <= MAP_STEPS);
}

/// A number of its own for every texel, but for two that are none.
fn numbers(size: UVec2) -> Image<f32> {
    Image::from_fn(size, |x, y| match x + y * size.x {
        3 => f32::NAN,
        4 => f32::INFINITY,
        i => i as f32,
    })
}

#[test]
fn numbers_of_any_texture_lie_over_the_pixels_that_they_are_about() {
    let (inner, margin_px) = (uvec2(30, 20), 4);
    let picture = ColorImage::from_fn(inner, |x, y| vec3(x as f32 / 30.0, 0.2, y as f32 / 20.0));
    let color = upload(gpu(), "picture", &picture);
    let display = Display::default();
    // The picture itself, with its margin, in tiles of 8 px, level 2 of its pyramid, and
    // level 1 of one so large that its size alone does not tell where it lies.
    let cases = [(inner, None), (uvec2(38, 28), None), (uvec2(4, 3), None), (uvec2(16, 8), None)];
    for (size, texel_px) in cases.into_iter().chain([(uvec2(64, 64), Some(2))]) {
        let numbers = numbers(size);
        let texture = upload_scalar(gpu(), "numbers", &numbers);
        let place = Place::of(size, inner, margin_px, texel_px);
        let slice = Slice { texture: &texture, level: 0, layer: 0 };
        let ends = [0.0, (size.x * size.y) as f32];
        let (map, opacity) = (Map::Sequential, 0.6);
        let mut frame = gpu().frame();
        let shown = Numbers { slice, channel: 0, map, ends }.over(&mut frame, &color, &display, place, opacity);
        frame.finish();
        let expected = |x, y| {
            let shade = Vec3::splat(display.encoded(picture.at(x, y)).dot(LUMINANCE));
            let centre = dvec2(f64::from(x) + 0.5, f64::from(y) + 0.5) / inner.as_dvec2();
            let value = place.texel(size, inner, centre).map(|texel| numbers.at(texel.x, texel.y));
            match value.filter(|v| v.is_finite()) {
                Some(v) => shade.lerp(colour(map, v / ends[1]), opacity),
                None => shade,
            }
        };
        let worst = worst_steps(&download_rgba8(gpu(), &shown), expected);
        assert!(worst <= MAP_STEPS, "{size}: {worst} steps off");
    }
}
