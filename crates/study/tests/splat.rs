//! Point splatting: layers, composition, the hidden image, apertures, acceleration.

#[path = "../../../tests/common/mod.rs"]
mod common;

use common::{front_camera, gpu, quad, textured, unlit};
use defocus::aperture::Aperture;
use defocus::gpu::{FrameStats, Gpu, Texture, download, download_depth};
use defocus::image::{ColorImage, DepthImage, Image};
use defocus::image_io::srgb::{linear_from_srgb_f32, srgb_from_linear_f32};
use defocus::lens::Lens;
use defocus::methods::sprites::SpriteTable;
use defocus::methods::{self, Accumulation, Method, Splat};
use defocus::scene::Scene;
use defocus::view::{GpuScene, SurfaceOptions, View};
use defocus_study::metrics::{CompareOptions, compare};
use glam::{DVec2, UVec2, Vec3, dvec2, uvec2, vec2, vec3};
use std::sync::Arc;

struct Splatted {
    image: ColorImage,
    stats: FrameStats,
    exposed: Vec<(String, Texture)>,
}

impl Splatted {
    fn layer(&self, name: &str) -> ColorImage {
        let found = self.exposed.iter().find(|(n, _)| n.split(':').next() == Some(name));
        download(gpu(), &found.unwrap_or_else(|| panic!("no {name} was exposed")).1)
    }
}

fn render(method: &dyn Method, view: &mut View, lens: &Lens) -> Splatted {
    let mut frame = gpu().frame();
    frame.keep_intermediates();
    let texture = methods::record(method, &mut frame, view, lens).unwrap();
    let submitted = frame.finish();
    Splatted { image: download(gpu(), &texture), stats: submitted.stats, exposed: submitted.exposed }
}

fn render_image(splat: &Splat, color: &ColorImage, depth: &DepthImage, lens: &Lens) -> Splatted {
    render(splat, &mut View::of_image(gpu(), color, depth, 0.8).unwrap(), lens)
}

fn view_of(scene: &Scene, size: UVec2) -> View {
    let options = SurfaceOptions { mipmaps: false, ..SurfaceOptions::default() };
    View::of_scene(GpuScene::new(gpu(), scene, options), front_camera(), size, 16).unwrap()
}

fn psnr_db(image: &ColorImage, reference: &ColorImage) -> f64 {
    compare(image, reference, &CompareOptions::default()).unwrap().psnr_db.unwrap_or(f64::INFINITY)
}

// ---- layers ----

#[test]
fn fragments_go_to_the_layer_of_equation_6() {
    let lens = common::lens(60.0, 2.0);
    let size = uvec2(31, 31);
    let centre = size / 2;
    for c_v in [-6.0, -2.0, 0.0, 3.0, 10.0] {
        for delta in [0.3f64, 0.5] {
            let edge = delta * f64::abs(c_v);
            for (c_p, expected) in
                [(c_v - edge - 0.2, 0), (c_v - 0.9 * edge, 1), (c_v + 0.9 * edge, 1), (c_v + edge + 0.2, 2)]
            {
                if c_p == 0.0 && c_v == 0.0 {
                    // In focus as a whole: nothing is splatted.
                    continue;
                }
                let depth_of = |c: f64| lens.coc().depth_at(c) as f32;
                let at_source = |x, y| uvec2(x, y) == centre;
                let color = Image::from_fn(size, |x, y| if at_source(x, y) { Vec3::ONE } else { Vec3::ZERO });
                let depth = Image::from_fn(size, |x, y| depth_of(if at_source(x, y) { c_p } else { c_v }));
                let splat = Splat { delta: delta as f32, ..Splat::default() };
                let rendered = render_image(&splat, &color, &depth, &lens);
                // The source's own pixel is at its own depth, and gets one pixel's share.
                let own = SpriteTable::of(&lens.aperture).share(DVec2::ZERO, c_p);
                for (layer, name) in ["L0", "L1", "L2"].into_iter().enumerate() {
                    let image = rendered.layer(name);
                    let light: f64 = image.pixels.iter().map(|p| f64::from(p.y)).sum();
                    let wanted = f64::from(layer == 1) * own + f64::from(layer == expected) * (1.0 - own);
                    let what = format!("c_v {c_v}, delta {delta}, c_p {c_p}: {light} of {wanted} on {name}");
                    assert!((light - wanted).abs() < 1e-4, "{what}");
                }
            }
        }
    }
}

// ---- composition ----

const FRONT: Vec3 = vec3(0.9, 0.2, 0.1);
const BACK: Vec3 = vec3(0.1, 0.3, 0.8);

/// Share of a disc of diameter `c` that reaches `x` px beyond its centre: its segment.
fn disc_segment(x: f64, c: f64) -> f64 {
    let t = (2.0 * x / c).clamp(-1.0, 1.0);
    (t.acos() - t * (1.0 - t * t).sqrt()) / std::f64::consts::PI
}

#[test]
fn blurred_foreground_is_as_transparent_as_the_disc_segment() {
    let lens = common::lens(20.0, 2.0);
    let size = uvec2(64, 40);
    let color = Image::from_fn(size, |x, _| if x < 32 { FRONT } else { BACK });
    let c = -13.0;
    let depth = Image::from_fn(size, |x, _| if x < 32 { lens.coc().depth_at(c) as f32 } else { 2.0 });
    for hidden in [false, true] {
        let image = render_image(&Splat { hidden, ..Splat::default() }, &color, &depth, &lens).image;
        for x in 8..56 {
            let beyond_edge = f64::from(x) + 0.5 - 32.0;
            // Beyond the edge the background is seen and known; before it, it is guessed or missing.
            let is_known = hidden || beyond_edge > 0.0;
            let alpha = if is_known { disc_segment(beyond_edge, c.abs()) } else { 1.0 };
            let wanted = FRONT * alpha as f32 + BACK * (1.0 - alpha) as f32;
            let error = (image.at(x, 20) - wanted).abs().max_element();
            // The segment at the pixel's centre for its mean over the pixel (curvature / 24,
            // greatest at the rim: 2e-3), and f16.
            assert!(error < 4e-3, "hidden {hidden}, x = {x}: {} of {wanted}", image.at(x, 20));
        }
    }
}

#[test]
fn sharp_pixels_do_not_leak_into_a_blurred_background() {
    let lens = common::lens(16.0, 2.0);
    let size = uvec2(48, 32);
    let color = Image::from_fn(size, |x, _| if x < 24 { FRONT } else { BACK });
    let depth = Image::from_fn(size, |x, _| if x < 24 { 2.0 } else { f32::INFINITY });
    let image = render_image(&Splat::default(), &color, &depth, &lens).image;
    for (i, p) in image.pixels.iter().enumerate() {
        let wanted = if i % 48 < 24 { FRONT } else { BACK };
        // f16 colours in and out.
        assert!((*p - wanted).abs().max_element() < 2e-3, "pixel {i}: {p} of {wanted}");
    }
}

#[test]
fn highlights_follow_equation_8() {
    let lens = common::lens(8.0, 2.0);
    let size = uvec2(24, 8);
    // Sharp pixels, but for one that keeps the image from being in focus as a whole: each the
    // linear value of what an image of 8 bits stores.
    let grey = |x: u32| x as f32 / 20.0;
    let color = Image::from_fn(size, |x, _| Vec3::splat(linear_from_srgb_f32(grey(x))));
    let depth = Image::from_fn(size, |x, y| if (x, y) == (0, 0) { f32::INFINITY } else { 2.0 });
    let splat = Splat { highlights: true, ..Splat::default() };
    let image = render_image(&splat, &color, &depth, &lens).image;
    for x in 8..24 {
        let above = f64::from((grey(x) - 0.8) / 0.2).clamp(0.0, 1.0);
        let wanted = f64::from(grey(x)) * (1.0 - above.powi(3) + above.powi(3) * 2.0);
        let got = f64::from(srgb_from_linear_f32(image.at(x, 6).x));
        assert!((got / wanted - 1.0).abs() < 4e-3, "{} becomes {got}, not {wanted}", grey(x));
    }
    // In numbers: stored 0.90 and 0.95 are multiplied by 1.125 and 1.42.
    for (x, factor) in [(18, 1.125), (19, 1.421_875)] {
        let got = srgb_from_linear_f32(image.at(x, 6).x) / grey(x);
        assert!((got / factor - 1.0).abs() < 4e-3, "{} is multiplied by {got}, not {factor}", grey(x));
    }
}

// ---- the hidden image ----

const NEAR_M: f32 = 1.0;
const WALL_M: f32 = 4.0;

/// A plain near square before a sharp, textured wall that fills the view.
fn near_before_wall() -> Scene {
    let near = quad(NEAR_M, vec2(-0.22, -0.25), vec2(0.25, 0.2), 0);
    let wall = quad(WALL_M, vec2(-5.0, -4.0), vec2(5.0, 4.0), 1);
    let mut scene = common::scene(vec![near, wall], vec![unlit(vec3(0.9, 0.5, 0.1)), textured()]);
    scene.textures = vec![Arc::new(common::uv_grid_texture(uvec2(64, 64)))];
    scene
}

/// Focused on the wall; the near square has a CoC of -24 px.
fn wall_lens() -> Lens {
    common::lens(8.0, f64::from(WALL_M))
}

#[test]
fn the_hidden_image_shows_what_is_behind_the_foreground() {
    let (scene, lens) = (near_before_wall(), wall_lens());
    let mut view = view_of(&scene, uvec2(256, 192));
    let reference = render(&Accumulation { samples: 128, view_dependent: false }, &mut view, &lens).image;
    let with = psnr_db(&render(&Splat::default(), &mut view, &lens).image, &reference);
    let without = psnr_db(&render(&Splat { hidden: false, ..Splat::default() }, &mut view, &lens).image, &reference);
    eprintln!("PSNR with the hidden image {with:.2} dB, without {without:.2} dB");
    // The paper has 36.33 against 32.84 dB for a scene of its own.
    assert!(with >= without + 4.0, "with the hidden image {with:.2} dB, without {without:.2} dB");
    assert!(with >= 36.0, "{with:.2} dB");
}

/// As above at the size and the mean CoC of 8 px that figures are given for.
#[test]
#[ignore = "1024 views of 512x384 px take a minute in software"]
fn the_hidden_image_is_worth_four_db_at_full_size() {
    let scene = near_before_wall();
    let mut view = view_of(&scene, uvec2(512, 384));
    let mut frame = gpu().frame();
    let z = view.pinhole(&mut frame).depth;
    frame.finish();
    let near_m = front_camera().near_m as f32;
    let depths_m = download_depth(gpu(), &z).pixels.into_iter().map(|z| near_m / z);
    let lens = wall_lens().with_mean_coc(8.0, depths_m).unwrap();
    let reference = render(&Accumulation { samples: 1024, view_dependent: false }, &mut view, &lens).image;
    let with = psnr_db(&render(&Splat::default(), &mut view, &lens).image, &reference);
    let without = psnr_db(&render(&Splat { hidden: false, ..Splat::default() }, &mut view, &lens).image, &reference);
    println!("512x384, mean CoC 8 px, 1024 points: with the hidden image {with:.2} dB, without {without:.2} dB");
    assert!(with >= without + 4.0);
}

#[test]
fn hidden_surfaces_pass_the_three_tests_only() {
    let (scene, lens) = (near_before_wall(), wall_lens());
    let mut view = view_of(&scene, uvec2(128, 96));
    let hidden = |splat: &Splat, view: &mut View, lens: &Lens| {
        let rendered = render(splat, view, lens);
        let colours = rendered.layer("hidden");
        colours.map(|p| p.max_element() > 0.0)
    };
    let accepted = |mask: &Image<bool>| mask.pixels.iter().filter(|a| **a).count();
    let mask = hidden(&Splat::default(), &mut view, &lens);
    let outer = mask.size;
    // Third test: the middle of the square is completely hidden, its rim is not.
    let centre = outer / 2;
    assert!(!mask.at(centre.x, centre.y), "the middle of the near square hides what is behind it");
    assert!(accepted(&mask) > 100, "the rim of the near square hides nothing");
    // Second test: nothing is behind the wall, which is not in front of focus.
    assert!(!mask.at(2, 2) && !mask.at(outer.x - 3, outer.y - 3));
    // First test: with a separation beyond the wall nothing is left.
    let apart = Splat { separation: 1.0, ..Splat::default() };
    assert_eq!(accepted(&hidden(&apart, &mut view, &lens)), 0);
    // Without the third test, all behind the square.
    let all = Splat { occlusion: 0.0, ..Splat::default() };
    assert!(hidden(&all, &mut view, &lens).at(centre.x, centre.y));
}

#[test]
fn no_foreground_needs_no_hidden_image() {
    let mut view = view_of(&near_before_wall(), uvec2(64, 48));
    let near_focus = common::lens(8.0, f64::from(NEAR_M));
    let stats = render(&Splat::default(), &mut view, &near_focus).stats;
    assert_eq!(stats.skipped.get("no foreground: no hidden image"), Some(&1), "{:?}", stats.skipped);
}

#[test]
fn what_an_image_hides_is_guessed_once() {
    let method = Splat::default();
    let lens = wall_lens();
    let mut view = view_of(&near_before_wall(), uvec2(64, 48)).as_image(gpu()).unwrap();
    let first = render(&method, &mut view, &lens).stats;
    assert_eq!(first.skipped.get("hidden surfaces known"), None, "{:?}", first.skipped);
    let second = render(&method, &mut view, &lens).stats;
    assert_eq!(second.skipped.get("hidden surfaces known"), Some(&1), "{:?}", second.skipped);
}

// ---- apertures ----

/// The image turned by half a turn about the middle.
fn turned(image: &ColorImage) -> ColorImage {
    Image::from_fn(image.size, |x, y| image.at(image.size.x - 1 - x, image.size.y - 1 - y))
}

#[test]
fn an_asymmetric_aperture_is_the_right_way_round_on_both_sides_of_focus() {
    // 8 x 8 px, edge on edge: 96 px are 60 degrees, so 48 px are tan(30 degrees) at 1 m.
    let half = 4.0 / 48.0 * 30f32.to_radians().tan();
    let spot = quad(1.0, vec2(-half, -half), vec2(half, half), 0);
    let scene = common::scene(vec![spot], vec![unlit(Vec3::ONE)]);
    let mut view = view_of(&scene, uvec2(96, 96));
    let difference = |a: &ColorImage, b: &ColorImage| -> f32 {
        a.pixels.iter().zip(&b.pixels).map(|(a, b)| (*a - *b).abs().x).sum()
    };
    // Focused behind (c = -24 px) and in front of it (c = +24 px).
    for (k_px, focus_m) in [(24.0, 2.0), (48.0, 0.5)] {
        let lens = Lens { aperture: Aperture::polygon(3), ..common::lens(k_px, focus_m) };
        let reference = render(&Accumulation { samples: 128, view_dependent: false }, &mut view, &lens).image;
        let mut splatted = render(&Splat { layers: false, normalise: false, ..Splat::default() }, &mut view, &lens);
        let total: f32 = reference.pixels.iter().map(|p| p.x).sum();
        let right = difference(&splatted.image, &reference) / total;
        splatted.image = turned(&splatted.image);
        let wrong = difference(&splatted.image, &reference) / total;
        assert!(right < 0.15 && wrong > 3.0 * right, "focus at {focus_m} m: {right} as it is, {wrong} turned");
    }
}

// ---- energy ----

#[test]
fn a_white_point_keeps_its_energy_and_spreads_by_a_quarter_of_the_coc() {
    let lens = common::lens(48.0, 2.0);
    let size = uvec2(64, 64);
    let color = Image::from_fn(size, |x, y| if (x, y) == (32, 32) { Vec3::splat(100.0) } else { Vec3::ZERO });
    for c in [-20.0f64, 3.7, 14.1] {
        let depth = Image::filled(size, lens.coc().depth_at(c) as f32);
        let image = render_image(&Splat::default(), &color, &depth, &lens).image;
        let (mut sum, mut second) = (0.0, 0.0);
        for (i, p) in image.pixels.iter().enumerate() {
            let offset = dvec2((i % 64) as f64 - 32.0, (i / 64) as f64 - 32.0);
            sum += f64::from(p.y);
            second += 0.5 * f64::from(p.y) * offset.length_squared();
        }
        assert!((sum / 100.0 - 1.0).abs() < 1e-3, "c = {c}: energy {}", sum / 100.0);
        let wanted = (c * c / 16.0 + 1.0 / 12.0).sqrt();
        assert!(((second / sum).sqrt() / wanted - 1.0).abs() < 0.01, "c = {c}: {} of {wanted}", (second / sum).sqrt());
    }
}

// ---- acceleration ----

#[test]
fn a_quarter_of_the_sprites_looks_nearly_the_same() {
    let scene = near_before_wall();
    for focus_m in [WALL_M, NEAR_M] {
        let lens = common::lens(if focus_m == WALL_M { 8.0 } else { 24.0 }, f64::from(focus_m));
        let mut view = view_of(&scene, uvec2(128, 96));
        let all = render(&Splat::default(), &mut view, &lens).image;
        let reduced = render(&Splat { accelerate: true, ..Splat::default() }, &mut view, &lens).image;
        let psnr = psnr_db(&reduced, &all);
        eprintln!("focus at {focus_m} m: {psnr:.2} dB");
        assert!(psnr > 38.0, "focus at {focus_m} m: {psnr:.2} dB");
        assert_ne!(all, reduced, "nothing was reduced");
    }
}

#[test]
fn the_reduced_array_leaves_no_holes_and_keeps_constant_colours() {
    let lens = common::lens(20.0, 2.0);
    // Odd sizes: the last row and column are no whole blocks.
    let size = uvec2(61, 43);
    let color = Image::filled(size, FRONT);
    let depth = Image::from_fn(size, |x, y| if (10..40).contains(&x) && y > 15 { 1.0 } else { 1.2 + y as f32 * 0.3 });
    let splat = Splat { accelerate: true, ..Splat::default() };
    for (i, p) in render_image(&splat, &color, &depth, &lens).image.pixels.iter().enumerate() {
        assert!((*p - FRONT).abs().max_element() < 2e-3, "pixel {i} is {p}");
    }
}

// ---- adapters without 32-bit blending ----

/// A device without any optional feature.
fn plain_gpu() -> Gpu {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default())).unwrap();
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor::default())).unwrap();
    Gpu::from_device(&adapter.get_info(), device, queue)
}

#[test]
fn sums_in_f16_are_close_where_32_bits_cannot_be_blended() {
    let plain = plain_gpu();
    let lens = common::lens(16.0, 2.0);
    let size = uvec2(48, 32);
    let color = Image::from_fn(size, |x, y| if (x / 6 + y / 5) % 2 == 0 { FRONT } else { BACK });
    let depth = Image::from_fn(size, |x, _| if x < 24 { 1.2 } else { 6.0 });
    for id in ["splat", "scatter"] {
        let mut method = methods::by_id(id).unwrap();
        if id == "splat" {
            methods::set_param(&mut *method, "by", "sprites").unwrap();
        }
        let on = |gpu: &Gpu| {
            let mut view = View::of_image(gpu, &color, &depth, 0.8).unwrap();
            let mut frame = gpu.frame();
            let texture = methods::record(&*method, &mut frame, &mut view, &lens).unwrap();
            frame.finish();
            download(gpu, &texture)
        };
        let (exact, biased) = (on(gpu()), on(&plain));
        let differences = exact.pixels.iter().zip(&biased.pixels).map(|(a, b)| (*a - *b).abs().max_element());
        let greatest = differences.fold(0.0, f32::max);
        // A hundred additions to sums below 1, each off by up to 2^-11, half of it if
        // rounded and on either side: 2 %.
        assert!(greatest < 0.02, "{id}: {greatest}");
        assert!(greatest > 0.0, "{id}: the plain device sums in 32 bits, too");
    }
}

#[test]
fn what_is_hidden_close_behind_fills_and_does_not_mix() {
    // Behind the near square (c = -24 px) a larger one at c = -20 px: within delta of it.
    let near = quad(NEAR_M, vec2(-0.22, -0.25), vec2(0.25, 0.2), 0);
    let next = quad(1.15, vec2(-0.45, -0.1), vec2(0.45, 0.3), 2);
    let wall = quad(WALL_M, vec2(-5.0, -4.0), vec2(5.0, 4.0), 1);
    let materials = vec![unlit(vec3(0.9, 0.5, 0.1)), textured(), unlit(vec3(0.1, 0.2, 0.6))];
    let scene = common::scene(vec![near, next, wall], materials);
    let mut view = view_of(&scene, uvec2(128, 96));
    let lens = wall_lens();
    let reference = render(&Accumulation { samples: 128, view_dependent: false }, &mut view, &lens).image;
    let mut psnr = |blend: &str| {
        let mut splat = Splat::default();
        methods::set_param(&mut splat, "hidden_blend", blend).unwrap();
        psnr_db(&render(&splat, &mut view, &lens).image, &reference)
    };
    let (filling, added) = (psnr("filling"), psnr("added"));
    eprintln!("PSNR filling {filling:.2} dB, added {added:.2} dB");
    assert!(filling > added + 1.0, "filling {filling:.2} dB, added {added:.2} dB");
}
