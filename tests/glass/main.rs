//! Sheets: surfaces that cover a part of what lies behind them.

#[path = "../common/mod.rs"]
mod common;

use common::{front_camera, gpu, lens, quad, scene, unlit, uv_grid_texture};
use defocus::gpu::download;
use defocus::image::ColorImage;
use defocus::lens::Lens;
use defocus::methods;
use defocus::raytrace::{RayOptions, RayRender, RayScene};
use defocus::scene::{Environment, Light, LightKind, Material, Mesh, Scene, TextureImage, TextureUse, Wrap};
use defocus::view::{GpuScene, SurfaceOptions, View};
use glam::{DVec3, UVec2, Vec2, Vec3, Vec4, uvec2, vec2, vec3};
use std::ops::ControlFlow;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

const SIZE: UVec2 = uvec2(96, 72);

/// Methods that know more than one surface a pixel, and the reference.
const LAYERED: [&str; 4] = ["accumulation", "adaptive", "multiview", "splat"];

/// One test at a time: frames that are recorded at once on one device may hand each other
/// pooled textures before they are submitted.
fn alone() -> MutexGuard<'static, ()> {
    static TURN: Mutex<()> = Mutex::new(());
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}

fn glass(color: Vec3, alpha: f32) -> Material {
    Material { base_color: color.extend(alpha), blended: true, double_sided: true, ..unlit(Vec3::ONE) }
}

fn view_of(scene: &Scene) -> View {
    // As the ray tracer reads textures.
    let options = SurfaceOptions { mipmaps: false, ..SurfaceOptions::default() };
    View::of_scene(GpuScene::new(gpu(), scene, options), front_camera(), SIZE, 24).expect("a small view")
}

/// `method` with `samples` lens points where it has that many to choose.
fn render(id: &str, samples: u32, view: &mut View, lens: &Lens) -> ColorImage {
    let mut method = methods::by_id(id).expect("a method");
    if ["accumulation", "multiview"].contains(&id) {
        methods::set_param(&mut *method, "samples", &samples.to_string()).expect("a number of samples");
    }
    let mut frame = gpu().frame();
    let texture = methods::record(&*method, &mut frame, view, lens).expect("the lens is good");
    frame.finish();
    download(gpu(), &texture)
}

fn trace(scene: &Scene, lens: &Lens, points: u32) -> ColorImage {
    let rays = RayScene::new(Arc::new(scene.clone()), &front_camera()).expect("a scene that can be traced");
    let options = RayOptions { lens_points: 0..points, ..RayOptions::default() };
    let projection = front_camera().projection(SIZE, 0);
    let render = RayRender::new(Arc::new(rays), &projection, lens, &options).expect("a lens that forms an image");
    render.run(|_, _| ControlFlow::Continue(())).color
}

fn psnr_db(a: &ColorImage, b: &ColorImage) -> f64 {
    let error = |(a, b): (&Vec3, &Vec3)| {
        f64::from((a.clamp(Vec3::ZERO, Vec3::ONE) - b.clamp(Vec3::ZERO, Vec3::ONE)).length_squared())
    };
    let mean = a.pixels.iter().zip(&b.pixels).map(error).sum::<f64>() / (3 * a.pixels.len()) as f64;
    -10.0 * mean.log10()
}

/// Mean over a square of 21 px around the middle.
fn middle(image: &ColorImage) -> Vec3 {
    let first = SIZE / 2 - 10;
    let pixels = (0..441).map(|i| image.at(first.x + i % 21, first.y + i / 21));
    pixels.sum::<Vec3>() / 441.0
}

/// Panes of these depths and coverages, all wide, before a blue wall at 4 m.
fn panes(panes: &[(f32, f32)]) -> Scene {
    let mut meshes = vec![quad(4.0, Vec2::splat(-9.0), Vec2::splat(9.0), 0)];
    let mut materials = vec![unlit(vec3(0.0, 0.0, 1.0))];
    for (i, (depth_m, alpha)) in panes.iter().enumerate() {
        meshes.push(quad(*depth_m, Vec2::splat(-1.2 * depth_m), Vec2::splat(1.2 * depth_m), i + 1));
        materials.push(glass(vec3(1.0, 0.0, 0.0), *alpha));
    }
    scene(meshes, materials)
}

#[test]
fn panes_let_through_what_they_do_not_cover() {
    let _turn = alone();
    let cases: [&[(f32, f32)]; 5] =
        [&[(1.5, 0.3)], &[(1.5, 0.7)], &[(1.5, 0.3), (2.5, 0.4)], &[(1.0, 0.5), (1.2, 0.5), (2.0, 0.2)], &[(3.9, 0.3)]];
    for panes_of in cases {
        let through: f32 = panes_of.iter().map(|(_, alpha)| 1.0 - alpha).product();
        let scene = panes(panes_of);
        // The wall in focus, the first pane in focus, and neither.
        for (k_px, focus_m) in [(12.0, 4.0), (12.0, f64::from(panes_of[0].0)), (6.0, 0.7)] {
            let lens = lens(k_px, focus_m);
            let mut view = view_of(&scene);
            let mut seen: Vec<(&str, Vec3)> =
                LAYERED.iter().map(|id| (*id, middle(&render(id, 64, &mut view, &lens)))).collect();
            seen.push(("raytrace", middle(&trace(&scene, &lens, 16))));
            for (id, color) in seen {
                let wrong = (color.z - through).abs().max((color.x - (1.0 - through)).abs());
                assert!(
                    wrong < 0.01,
                    "{id}, panes {panes_of:?}, focus {focus_m} m: {color}, not {through} of the wall"
                );
            }
        }
    }
}

/// A card with a soft round hole of alpha from 0 to 1, as smoke and the edges of leaves have it.
fn soft_card(depth_m: f32, half_m: f32, material: usize) -> Mesh {
    quad(depth_m, Vec2::splat(-half_m), Vec2::splat(half_m), material)
}

fn soft_texture() -> TextureImage {
    let texel = |i: u32| {
        let at = vec2((i % 32) as f32 + 0.5, (i / 32) as f32 + 0.5) / 16.0 - 1.0;
        let alpha = (1.6 - 1.6 * at.length()).clamp(0.0, 1.0);
        [40, 200, 60, (alpha * 255.0) as u8]
    };
    let rgba8 = (0..1024).map(texel).collect();
    TextureImage { name: "soft".into(), size: uvec2(32, 32), rgba8, srgb: true, wrap: [Wrap::Clamp; 2] }
}

/// Soft leaves at several depths, a tilted pane and lit glass before a textured wall.
fn soft_scene() -> Scene {
    let wall = common::textured();
    let soft = TextureUse { texture: 1, second_uv: false, u_row: Vec3::X, v_row: Vec3::Y };
    let leaf = Material { base_color_texture: Some(soft), ..glass(Vec3::ONE, 1.0) };
    let clear = Material {
        unlit: false,
        transmission: 0.9,
        metallic: 0.0,
        roughness: 0.2,
        base_color: Vec4::new(0.8, 0.9, 0.85, 1.0),
        ..Material::default()
    };
    let moved = |mut mesh: Mesh, by: Vec3| {
        mesh.vertices.iter_mut().for_each(|v| v.position += by);
        mesh
    };
    let mut tilted = quad(2.2, vec2(-0.9, -0.6), vec2(0.1, 0.9), 2);
    tilted.vertices.iter_mut().for_each(|v| v.position.z += 0.3 * v.position.x);
    let mut made = scene(
        vec![
            quad(5.0, vec2(-6.0, -5.0), vec2(6.0, 5.0), 0),
            soft_card(3.0, 0.8, 1),
            moved(soft_card(1.6, 0.3, 1), vec3(0.45, 0.2, 0.0)),
            moved(soft_card(1.0, 0.2, 1), vec3(-0.3, -0.2, 0.0)),
            tilted,
            moved(common::sphere(0.35, 12, 3), vec3(0.4, -0.5, -2.5)),
        ],
        vec![wall, leaf, glass(vec3(0.9, 0.2, 0.1), 0.4), clear],
    );
    made.textures = vec![Arc::new(uv_grid_texture(uvec2(8, 8))), Arc::new(soft_texture())];
    made.lights = vec![Light {
        intensity: Vec3::splat(1.5),
        kind: LightKind::Directional { direction: DVec3::new(0.4, -1.0, -0.6).normalize() },
    }];
    made.environment = Environment::Studio {
        zenith: vec3(0.4, 0.5, 0.7),
        horizon: Vec3::splat(0.6),
        ground: vec3(0.2, 0.18, 0.15),
        softbox: 1.0,
    };
    made
}

#[test]
fn accumulation_and_rays_agree_on_sheets() {
    let _turn = alone();
    let scene = soft_scene();
    for (k_px, focus_m) in [(10.0, 2.2), (6.0, 5.0)] {
        let lens = lens(k_px, focus_m);
        let rasterised = render("accumulation", 1024, &mut view_of(&scene), &lens);
        let db = psnr_db(&rasterised, &trace(&scene, &lens, 1024));
        println!("focus {focus_m} m: {db:.1} dB");
        assert!(db > 40.0, "focus {focus_m} m: {db} dB");
    }
}

#[test]
fn layered_methods_are_near_the_reference_on_sheets() {
    let _turn = alone();
    let scene = soft_scene();
    // What each reaches at the worse of the two, less 1 dB.
    let least = [("adaptive", 43.8), ("multiview", 44.1), ("splat", 38.8)];
    for (k_px, focus_m) in [(10.0, 2.2), (6.0, 5.0)] {
        let lens = lens(k_px, focus_m);
        let truth = trace(&scene, &lens, 1024);
        let mut view = view_of(&scene);
        for (id, least_db) in least {
            let db = psnr_db(&render(id, 64, &mut view, &lens), &truth);
            println!("{id}, focus {focus_m} m: {db:.1} dB");
            assert!(db > least_db, "{id}, focus {focus_m} m: {db} dB");
        }
    }
}

#[test]
fn one_depth_is_that_of_the_nearest_surface_over_half() {
    let _turn = alone();
    for (alpha, depth_m) in [(0.3, 4.0), (0.49, 4.0), (0.51, 1.5), (0.7, 1.5)] {
        let mut view = view_of(&panes(&[(1.5, alpha)]));
        let depth = view.depth_m(gpu());
        let found = depth.at(SIZE.x / 2, SIZE.y / 2);
        assert!((found - depth_m).abs() < 1e-3, "alpha {alpha}: {found} m");
        let color = middle(&render("pinhole", 1, &mut view, &lens(8.0, 1.5)));
        assert!((color - vec3(alpha, 0.0, 1.0 - alpha)).abs().max_element() < 2e-3, "alpha {alpha}: {color}");
    }
    // Two that cover 0.4 each hide the wall by 0.64, and none of them by half.
    let mut view = view_of(&panes(&[(1.5, 0.4), (2.0, 0.4)]));
    let found = view.depth_m(gpu()).at(SIZE.x / 2, SIZE.y / 2);
    assert!((found - 4.0).abs() < 1e-3, "{found} m");
}

#[test]
fn what_lies_behind_a_solid_surface_does_not_shine_through() {
    let _turn = alone();
    let scene = panes(&[(4.5, 0.9), (6.0, 0.5)]);
    let lens = lens(9.0, 2.0);
    let mut view = view_of(&scene);
    for id in ["pinhole"].into_iter().chain(LAYERED) {
        let color = middle(&render(id, 16, &mut view, &lens));
        assert!((color - vec3(0.0, 0.0, 1.0)).abs().max_element() < 2e-3, "{id}: {color}");
    }
}
