//! `multiview`: slabs, N-buffers and rays against closed forms and against accumulation.

#[path = "../../../tests/common/mod.rs"]
mod common;

use common::{front_camera, gpu, lens, quad, scene, sphere, textured, unlit};
use defocus::aperture::Aperture;
use defocus::eye::{Eye, Refraction};
use defocus::gpu::{Frame, FrameStats, Texture, download, download_depth};
use defocus::image::{ColorImage, DepthImage, Image};
use defocus::lens::Lens;
use defocus::methods::multiview::{INTERSECTIONS, JITTERS, slab_ranges};
use defocus::methods::{self, Accumulation, Method, Multiview};
use defocus::scene::{Environment, Material, Scene};
use defocus::view::{GpuScene, LayerQuery, SurfaceOptions, View};
use defocus_study::metrics::{CompareOptions, compare};
use glam::{UVec2, Vec3, Vec4, uvec2, vec2, vec3};
use std::sync::{Mutex, MutexGuard, PoisonError};

const SIZE: UVec2 = uvec2(128, 96);

/// One test at a time: frames that are recorded at once on one device may hand each other
/// pooled textures before they are submitted.
fn alone() -> MutexGuard<'static, ()> {
    static TURN: Mutex<()> = Mutex::new(());
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}

fn view_of(scene: &Scene, overscan_px: u32) -> View {
    let scene = GpuScene::new(gpu(), scene, SurfaceOptions::default());
    View::of_scene(scene, front_camera(), SIZE, overscan_px).unwrap()
}

fn render_with_stats(method: &dyn Method, view: &mut View, lens: &Lens) -> (ColorImage, FrameStats) {
    let mut frame: Frame<'_> = gpu().frame();
    let texture = methods::record(method, &mut frame, view, lens).unwrap();
    let stats = frame.finish().stats;
    (download(gpu(), &texture), stats)
}

fn render(method: &dyn Method, view: &mut View, lens: &Lens) -> ColorImage {
    render_with_stats(method, view, lens).0
}

fn psnr(test: &ColorImage, reference: &ColorImage) -> f64 {
    compare(test, reference, &CompareOptions::default()).unwrap().psnr_db.unwrap_or(f64::INFINITY)
}

/// A textured wall, a ball in the middle and a near bar in front of both.
fn three_depths() -> Scene {
    let mut ball = sphere(0.4, 12, 1);
    for vertex in &mut ball.vertices {
        vertex.position += vec3(0.2, 0.1, -2.0);
    }
    scene(
        vec![quad(5.0, vec2(-6.0, -5.0), vec2(6.0, 5.0), 0), ball, quad(0.9, vec2(-0.35, -0.6), vec2(-0.15, 0.3), 2)],
        vec![textured(), unlit(vec3(0.9, 0.3, 0.1)), unlit(vec3(0.1, 0.2, 0.9))],
    )
}

#[test]
fn slabs_put_together_are_the_pinhole_image() {
    let _turn = alone();
    let mut view = view_of(&three_depths(), 0);
    let mut frame = gpu().frame();
    let [z_min, z_max] = view.z_bounds(&mut frame);
    let pinhole = view.pinhole(&mut frame);
    let ranges = slab_ranges(z_max, z_min, 7, 0.1);
    assert_eq!(ranges.len(), 7);
    let layers: Vec<_> = ranges
        .iter()
        .map(|r| view.layer(&mut frame, "slab", LayerQuery { z_near: r.z_near, z_far: r.z_far, below: None }).unwrap())
        .collect();
    frame.finish();
    let (color, depth) = (download(gpu(), &pinhole.color), download_depth(gpu(), &pinhole.depth));
    let layers: Vec<_> = layers.iter().map(|l| (download(gpu(), &l.color), download_depth(gpu(), &l.depth))).collect();
    for i in 0..color.pixels.len() {
        let nearest = layers.iter().max_by(|a, b| a.1.pixels[i].total_cmp(&b.1.pixels[i])).unwrap();
        assert_eq!(nearest.1.pixels[i], depth.pixels[i], "depth of pixel {i}");
        assert_eq!(nearest.0.pixels[i], color.pixels[i], "colour of pixel {i}");
    }
}

/// With a mask and with light, so that all kinds of surfaces are drawn.
fn masked_and_lit() -> Scene {
    let mut scene = three_depths();
    scene.materials[0] = Material { unlit: false, roughness: 0.4, ..scene.materials[0].clone() };
    scene.materials[2] = Material { alpha_cutoff: Some(0.5), ..textured() };
    scene.environment = Environment::Studio {
        zenith: vec3(0.5, 0.6, 0.9),
        horizon: Vec3::ONE,
        ground: vec3(0.2, 0.2, 0.1),
        softbox: 4.0,
    };
    scene
}

#[test]
fn slabs_drawn_together_are_those_drawn_one_by_one() {
    let _turn = alone();
    let lens = lens(40.0, 2.0);
    for (scene, overlap) in [(three_depths(), 0.1), (masked_and_lit(), 1.0)] {
        for view_dependent in [false, true] {
            let drawn = |drawing: &str| {
                let mut method = Multiview { samples: 16, overlap, view_dependent, ..Multiview::default() };
                methods::set_param(&mut method, "drawing", drawing).unwrap();
                render_with_stats(&method, &mut view_of(&scene, 5), &lens)
            };
            let (together, few) = drawn("together");
            let (one_by_one, many) = drawn("one by one");
            assert!(few.views <= 3 && many.views > few.views, "{} draws, {} one by one", few.views, many.views);
            let differences =
                together.pixels.iter().zip(&one_by_one.pixels).map(|(a, b)| (*a - *b).abs() / (1.0 + b.abs()));
            // Colours are rounded to f16 once, by a store or by a target, which may round
            // differently: half of 2^-10 of a value.
            let greatest = differences.map(Vec3::max_element).fold(0.0, f32::max);
            eprintln!("shaded by rays: {view_dependent}, overlap {overlap}: {greatest:.1e}");
            assert!(greatest < 1e-3, "shaded by rays: {view_dependent}, overlap {overlap}: {greatest}");
        }
    }
}

#[test]
fn slabs_are_equally_thick_in_coc_and_overlap_by_a_tenth() {
    let (near_m, lens) = (0.1, lens(24.0, 2.0));
    let ranges = slab_ranges(0.2, 0.01, 5, 0.1);
    let c = |z: f32| lens.coc().at_stored(f64::from(z), near_m);
    let thickness = (c(0.01) - c(0.2)) / 5.0;
    for (i, pair) in ranges.windows(2).enumerate() {
        let bound = c(0.2) + (i + 1) as f64 * thickness;
        // f32 holds z to 6e-8 of 1; the slope of c is 24 * 2 / 0.1 px.
        assert!((c(pair[0].z_far) - bound - 0.1 * thickness).abs() < 1e-3);
        assert!((c(pair[1].z_near) - bound + 0.1 * thickness).abs() < 1e-3);
    }
    assert!(ranges[0].z_near >= 0.2);
    assert_eq!(ranges[4].z_far, 0.0, "the last slab reaches infinity");
}

fn exposed(method: &Multiview, view: &mut View, lens: &Lens) -> Vec<(String, Texture)> {
    let mut frame = gpu().frame();
    frame.keep_intermediates();
    methods::record(method, &mut frame, view, lens).unwrap();
    frame.finish().exposed
}

#[test]
fn an_n_buffer_holds_the_nearest_depth_of_each_window() {
    let _turn = alone();
    let mut view = view_of(&three_depths(), 0);
    let method = Multiview { slabs: 1, cones: false, ..Multiview::default() };
    let exposed = exposed(&method, &mut view, &lens(24.0, 2.0));
    let depth = exposed.iter().find(|(name, _)| name == "slab depth").expect("the slabs' depth is exposed");
    let depth = download_depth(gpu(), &depth.1);
    let levels: Vec<_> = exposed.iter().filter_map(|(name, t)| Some((name.strip_prefix("N-buffer ")?, t))).collect();
    // Blocks of 8 px: 16 x 12 of them, and four windows of 8 x 8 make any square up to all.
    assert_eq!(levels.iter().map(|(side, _)| *side).collect::<Vec<_>>(), ["1", "2", "4", "8", "16"]);
    const BLOCK: i64 = 8;
    for (side, texture) in levels {
        let side: i64 = side.parse().unwrap();
        let nearest = download_depth(gpu(), texture);
        assert_eq!(nearest.size, SIZE / BLOCK as u32);
        for at in [(0, 0), (4, 3), (3, 6), (0, 11), (15, 11), (13, 1), (8, 6), (10, 4)] {
            let side_px = side * BLOCK;
            let texels = (0..side_px * side_px).map(|i| (at.0 * BLOCK + i % side_px, at.1 * BLOCK + i / side_px));
            let wanted = texels.map(|(x, y)| depth.at_clamped(x, y)).fold(f32::NEG_INFINITY, f32::max);
            assert_eq!(nearest.at(at.0 as u32, at.1 as u32), wanted, "side {side} at {at:?}");
        }
    }
}

#[test]
fn culling_changes_nothing() {
    let _turn = alone();
    let mut view = view_of(&three_depths(), 4);
    for aperture in [Aperture::Disc, Aperture::Gaussian { sigma_per_coc: 0.5 }] {
        let lens = Lens { aperture, ..lens(16.0, 2.0) };
        for (intersection, name) in INTERSECTIONS.iter().enumerate() {
            let method = Multiview { samples: 16, intersection, ..Multiview::default() };
            let culled = render(&method, &mut view, &lens);
            let whole = render(&Multiview { culling: false, ..method }, &mut view, &lens);
            assert_eq!(culled, whole, "{name} {:?}", lens.aperture);
        }
    }
}

#[test]
fn culling_changes_nothing_for_any_set_of_lens_points_and_any_lens() {
    let _turn = alone();
    // With a sheet in front of the ball: where rays look for sheets does not depend on slabs either.
    let Scene { mut meshes, mut materials, .. } = three_depths();
    meshes.push(quad(1.4, vec2(-0.5, -0.7), vec2(0.6, 0.4), 3));
    materials.push(Material { base_color: Vec4::new(0.9, 0.2, 0.2, 0.4), blended: true, ..unlit(Vec3::ONE) });
    let with_sheet = scene(meshes, materials);
    let refraction = Refraction { sphere_d: 0.4, cylinder_d: -0.8, axis_deg: 30.0 };
    let eye = Eye { refraction, ..Eye::default() };
    let round = lens(30.0, 1.6);
    let elliptic = Lens { eye, ..lens(12.0, 3.0) };
    for (what, scene, overscan_px) in [("solid", three_depths(), 0), ("with a sheet", with_sheet, 9)] {
        let mut view = view_of(&scene, overscan_px);
        for (lens, of) in [(&round, "round"), (&elliptic, "elliptic")] {
            // More points than are looked up at a time, and few, which are no power of two.
            for (samples, jitter) in [(96, 0), (16, 1), (5, 2)] {
                let method = Multiview { samples, jitter, ..Multiview::default() };
                let culled = render(&method, &mut view, lens);
                let whole = render(&Multiview { culling: false, ..method }, &mut view, lens);
                assert_eq!(culled, whole, "{what}, {of} blur, {samples} points, {}", JITTERS[jitter]);
            }
        }
    }
}

/// Both intersections on a plane slanted in depth such that c is linear over the image:
/// a ray p - v c / 2 meets c = c0 + g x at x = (p - v c0 / 2) / (1 + v g / 2).
#[test]
fn rays_meet_a_slanted_plane_where_they_should() {
    let _turn = alone();
    let lens = lens(24.0, 2.0);
    let (c0, gradient) = (-14.0, 0.25);
    let c = |x: f64| c0 + gradient * x;
    let depth: DepthImage = Image::from_fn(SIZE, |x, _| lens.coc().depth_at(c(f64::from(x) + 0.5)) as f32);
    let color = Image::from_fn(SIZE, |x, _| Vec3::splat((x as f32 + 0.5) / SIZE.x as f32));
    let mut view = View::of_image(gpu(), &color, &depth, 0.8).unwrap();
    for (intersection, name) in INTERSECTIONS.iter().enumerate() {
        let samples = 32;
        let jitter = JITTERS.iter().position(|j| *j == "off").unwrap();
        let method = Multiview { samples, intersection, jitter, ..Multiview::default() };
        let image = render(&method, &mut view, &lens);
        for x in 24..104 {
            let p = f64::from(x) + 0.5;
            let hit = |v: f64| (p - 0.5 * v * c0) / (1.0 + 0.5 * v * gradient);
            let mean = lens.aperture.lens_points(samples).iter().map(|v| hit(v.x)).sum::<f64>() / f64::from(samples);
            let found = f64::from(image.at(x, 48).x) * f64::from(SIZE.x);
            // Heights are those of whole texels, half a pixel to either side: c is off by up
            // to gradient / 2 and the ray by half of that, 0.06 px. Two roundings (or
            // truncations) to f16 of values up to 1 add 0.06 px each.
            assert!((found - mean).abs() < 0.19, "{name} at x = {x}: {found} px, should be {mean}");
        }
    }
}

#[test]
fn two_planes_look_as_accumulated() {
    let _turn = alone();
    let mut view = view_of(&three_depths(), 16);
    let lens = lens(12.0, 2.0);
    let reference = render(&Accumulation { samples: 64, view_dependent: false }, &mut view, &lens);
    let pinhole = render(&methods::Pinhole, &mut view, &lens);
    for (intersection, name) in INTERSECTIONS.iter().enumerate() {
        let method = Multiview { intersection, ..Multiview::default() };
        let db = psnr(&render(&method, &mut view, &lens), &reference);
        eprintln!("{name}: {db:.2} dB, the pinhole image has {:.2} dB", psnr(&pinhole, &reference));
        assert!(db > 36.0, "{name}: {db:.2} dB");
    }
}

#[test]
fn a_triangular_aperture_is_the_right_way_round() {
    let _turn = alone();
    // A small light behind the focus and one in front, beside each other on black.
    let light = unlit(Vec3::ONE);
    let quads = vec![
        quad(8.0, vec2(-20.0, -20.0), vec2(20.0, 20.0), 1),
        quad(7.9, vec2(-2.2, -0.3), vec2(-1.6, 0.3), 0),
        quad(1.0, vec2(0.25, -0.04), vec2(0.33, 0.04), 0),
    ];
    let mut view = view_of(&scene(quads, vec![light, unlit(Vec3::ZERO)]), 16);
    let lens = Lens { aperture: Aperture::polygon(3), ..lens(20.0, 2.0) };
    let reference = render(&Accumulation { samples: 64, view_dependent: false }, &mut view, &lens);
    let upside_down = Aperture::Polygon { blades: 3, rotation_deg: 180.0, roundness: 0.0 };
    let turned = Lens { aperture: upside_down, ..lens.clone() };
    let method = Multiview::default();
    let right = psnr(&render(&method, &mut view, &lens), &reference);
    let wrong = psnr(&render(&method, &mut view, &turned), &reference);
    assert!(right > wrong + 8.0, "{right:.1} dB, turned {wrong:.1} dB");
}

#[test]
fn hidden_surfaces_come_into_sight_through_a_blurred_bar() {
    let _turn = alone();
    // A near bar, 4 px wide and blurred over 30, hides a red stripe of the wall behind it.
    let bar = quad(0.5, vec2(-0.012, -1.0), vec2(0.012, 1.0), 0);
    let stripe = quad(2.0, vec2(-0.04, -3.0), vec2(0.04, 3.0), 1);
    let wall = quad(2.01, vec2(-4.0, -3.0), vec2(4.0, 3.0), 2);
    let materials = vec![unlit(Vec3::ZERO), unlit(vec3(1.0, 0.0, 0.0)), unlit(vec3(0.0, 0.0, 1.0))];
    let mut view = view_of(&scene(vec![bar, stripe, wall], materials), 16);
    let lens = lens(10.0, 2.0);
    let centre = |image: &ColorImage| image.at(SIZE.x / 2, SIZE.y / 2);
    assert_eq!(centre(&render(&methods::Pinhole, &mut view, &lens)), Vec3::ZERO, "the bar hides the stripe");
    let traced = centre(&render(&Multiview::default(), &mut view, &lens));
    let reference = centre(&render(&Accumulation { samples: 64, view_dependent: false }, &mut view, &lens));
    assert!(reference.x > 0.5 && reference.z < 0.2, "the lens looks past the bar: {reference}");
    // 64 of the lens's points see an edge's share to about 64^(-3/4) = 0.04.
    assert!((traced - reference).abs().max_element() < 0.08, "{traced} instead of {reference}");
}

#[test]
fn empty_slabs_are_not_drawn_and_unchanged_ones_are_kept() {
    let _turn = alone();
    let quads =
        vec![quad(0.5, vec2(-0.02, -0.02), vec2(0.02, 0.02), 0), quad(6.0, vec2(-0.2, -0.2), vec2(0.2, 0.2), 0)];
    let mut view = view_of(&scene(quads, vec![textured()]), 0);
    let method = Multiview { samples: 8, slabs: 10, delta_px: 0.5, ..Multiview::default() };
    let (_, first) = render_with_stats(&method, &mut view, &lens(12.0, 2.0));
    // The pinhole image, and the first and the last slab.
    assert_eq!((first.views, first.skipped.get("slab without surfaces")), (3, Some(&8)));
    let (_, refocused) = render_with_stats(&method, &mut view, &lens(12.0, 2.2));
    assert_eq!(refocused.views, 0, "refocusing moves no slab: {refocused:?}");
    assert_eq!(refocused.skipped.get("slabs unchanged"), Some(&1));
    let (_, finer) = render_with_stats(&Multiview { samples: 128, ..method }, &mut view, &lens(12.0, 2.2));
    assert_eq!(finer.views, 0, "more lens points ask for no other slabs: {finer:?}");
    assert_eq!(finer.skipped.get("slabs unchanged"), Some(&1));
}

#[test]
fn reflections_follow_the_lens_point() {
    let _turn = alone();
    // Behind the focus, a glossy ball under a studio: its highlight moves over it.
    let material =
        Material { base_color: Vec4::new(0.9, 0.7, 0.4, 1.0), metallic: 1.0, roughness: 0.08, ..Material::default() };
    let mut ball = sphere(0.6, 24, 0);
    for vertex in &mut ball.vertices {
        vertex.position += vec3(0.0, 0.0, -2.2);
    }
    let grey = Vec3::splat;
    let environment = Environment::Studio { zenith: grey(0.6), horizon: grey(0.4), ground: grey(0.1), softbox: 2.0 };
    let scene = Scene { environment, ..scene(vec![ball], vec![material]) };
    let mut view = view_of(&scene, 16);
    let lens = lens(24.0, 1.2);
    let reference = render(&Accumulation { samples: 128, view_dependent: true }, &mut view, &lens);
    let score = |view_dependent, view: &mut View| {
        psnr(&render(&Multiview { view_dependent, ..Multiview::default() }, view, &lens), &reference)
    };
    let (following, fixed) = (score(true, &mut view), score(false, &mut view));
    eprintln!("view-dependent {following:.2} dB, view-independent {fixed:.2} dB");
    assert!(following > 36.0 && following > fixed + 3.0, "{following:.2} dB, without {fixed:.2} dB");
}

/// Balls of polished metal, some only a few pixels wide: their reflections are finer than the
/// distance of rays, and what rays alone sample of them is noise.
fn polished() -> Scene {
    let metal = |roughness, color: Vec3| Material {
        base_color: color.extend(1.0),
        metallic: 1.0,
        roughness,
        ..Material::default()
    };
    let wall = quad(6.0, vec2(-5.0, -4.0), vec2(5.0, 4.0), 0);
    let balls = (0..28).map(|i| {
        let (column, row) = (i % 7, i / 7);
        let depth_m = 1.0 + 0.6 * ((3 * i) % 5) as f32;
        let mut ball = sphere(if row % 2 == 0 { 0.06 } else { 0.14 } * depth_m, 16, 1 + i % 2);
        let place = vec3(0.22 * (column as f32 - 3.0), 0.21 * (row as f32 - 1.5), -1.0) * depth_m;
        ball.vertices.iter_mut().for_each(|vertex| vertex.position += place);
        ball
    });
    let meshes = [wall].into_iter().chain(balls).collect();
    let materials = vec![textured(), metal(0.04, Vec3::splat(0.8)), metal(0.1, vec3(0.95, 0.7, 0.3))];
    let grey = Vec3::splat;
    let environment = Environment::Studio { zenith: grey(0.3), horizon: grey(0.5), ground: grey(0.05), softbox: 4.0 };
    Scene { environment, ..scene(meshes, materials) }
}

#[test]
fn shading_by_the_lens_point_is_nearer_the_truth_in_both_measures() {
    let _turn = alone();
    for (k_px, least_gain_db, least_gain_ssim) in GAINS {
        let lens = lens(k_px, 1.6);
        let mut view = view_of(&polished(), 16);
        let reference = render(&Accumulation { samples: 256, view_dependent: true }, &mut view, &lens);
        let [fixed, following] = [false, true].map(|view_dependent| {
            let picture = render(&Multiview { view_dependent, ..Multiview::default() }, &mut view, &lens);
            compare(&picture, &reference, &CompareOptions::default()).unwrap()
        });
        let gain_db = following.psnr_db.unwrap() - fixed.psnr_db.unwrap();
        let gain_ssim = following.ssim.unwrap() - fixed.ssim.unwrap();
        eprintln!(
            "K = {k_px} px: {:?} dB, SSIM {:?}; {gain_db:+.2} dB, {gain_ssim:+.4}",
            following.psnr_db, following.ssim
        );
        assert!(
            gain_db > least_gain_db && gain_ssim > least_gain_ssim,
            "K = {k_px} px: {gain_db:+.2} dB, {gain_ssim:+.4}"
        );
    }
}

/// For a K, px: by how much PSNR, dB, and SSIM are better at least.
const GAINS: [(f64, f64, f64); 2] = [(12.0, 0.5, 0.002), (36.0, 0.5, 0.005)];

#[test]
fn few_points_without_cones_leave_grain_that_cones_take_away() {
    let _turn = alone();
    let mut view = view_of(&three_depths(), 16);
    let lens = lens(24.0, 2.0);
    let reference = render(&Accumulation { samples: 64, view_dependent: false }, &mut view, &lens);
    let score = |cones, view: &mut View| {
        psnr(&render(&Multiview { samples: 8, cones, ..Multiview::default() }, view, &lens), &reference)
    };
    let (with, without) = (score(true, &mut view), score(false, &mut view));
    assert!(with > without + 1.0, "with cones {with:.2} dB, without {without:.2} dB");
}
