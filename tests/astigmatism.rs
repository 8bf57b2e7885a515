//! The elliptical blur of an astigmatic eye, in the methods that render it, against accumulation.

mod common;

use defocus::aperture::Aperture;
use defocus::camera::Camera;
use defocus::eye::{Eye, Refraction};
use defocus::gpu::download;
use defocus::image::{ColorImage, DepthImage, Image};
use defocus::lens::Lens;
use defocus::methods::{self, Accumulation, Apertures, Method};
use defocus::raytrace::{RayOptions, RayRender, RayScene, Shading};
use defocus::scene::{Scene, Vertex};
use defocus::view::{GpuScene, SurfaceOptions, View};
use glam::{DMat2, DVec2, UVec2, Vec2, Vec3, dvec2, uvec2, vec2};
use std::ops::ControlFlow;
use std::sync::Arc;

/// Lens points of the pictures that others are held against: two such agree to 45 dB and more.
const LENS_POINTS: u32 = 256;

fn astigmatic(lens: &Lens, sphere_d: f64, cylinder_d: f64, axis_deg: f64) -> Lens {
    let refraction = Refraction { sphere_d, cylinder_d, axis_deg };
    Lens { eye: Eye { refraction, ..Eye::default() }, ..lens.clone() }
}

fn view_of(scene: &Scene, camera: Camera, size: UVec2, overscan_px: u32) -> View {
    let uploaded = GpuScene::new(common::gpu(), scene, SurfaceOptions::default());
    View::of_scene(uploaded, camera, size, overscan_px).expect("a view")
}

fn picture(method: &dyn Method, view: &mut View, lens: &Lens) -> ColorImage {
    let mut frame = common::gpu().frame();
    let texture = methods::record(method, &mut frame, view, lens).expect("a picture");
    frame.finish();
    download(common::gpu(), &texture)
}

fn truth(view: &mut View, lens: &Lens) -> ColorImage {
    picture(&Accumulation { samples: LENS_POINTS, view_dependent: false }, view, lens)
}

fn psnr_db(a: &ColorImage, b: &ColorImage) -> f64 {
    let squares = a.pixels.iter().zip(&b.pixels).map(|(a, b)| f64::from((*a - *b).length_squared()));
    let mse = squares.sum::<f64>() / (3.0 * a.pixels.len() as f64);
    -10.0 * mse.log10()
}

/// Those that say that they can, references apart.
fn able() -> Vec<Box<dyn Method>> {
    methods::all().into_iter().filter(|m| m.about().astigmatism && m.about().id != "accumulation").collect()
}

fn by_id(id: &str) -> Box<dyn Method> {
    methods::by_id(id).expect("it is there")
}

/// A textured wall, two bars and a square at three depths.
fn bars() -> (Scene, Camera) {
    let meshes = vec![
        common::quad(4.0, vec2(-9.0, -9.0), vec2(9.0, 9.0), 0),
        common::quad(1.0, vec2(-0.5, -0.03), vec2(0.5, 0.05), 1),
        common::quad(1.6, vec2(0.15, -0.9), vec2(0.22, 0.9), 2),
        common::quad(0.7, vec2(-0.35, 0.1), vec2(-0.12, 0.3), 3),
    ];
    let colors = [vec3(0.9, 0.8, 0.2), vec3(0.15, 0.5, 0.8), vec3(0.8, 0.2, 0.3)].map(common::unlit);
    let materials = [vec![common::textured()], colors.to_vec()].concat();
    (common::scene(meshes, materials), common::front_camera())
}

fn vec3(r: f32, g: f32, b: f32) -> Vec3 {
    Vec3::new(r, g, b)
}

/// A floor that goes through the focus, with blocks on it.
fn floor() -> (Scene, Camera) {
    let at = |x: f32, z: f32, u: f32, v: f32| Vertex {
        position: vec3(x, -0.35, -z),
        normal: Vec3::Y,
        uv: vec2(u, v),
        ..common::quad(1.0, Vec2::ZERO, Vec2::ONE, 0).vertices[0]
    };
    let vertices =
        vec![at(-3.0, 0.4, 0.0, 1.0), at(3.0, 0.4, 1.0, 1.0), at(3.0, 6.0, 1.0, 0.0), at(-3.0, 6.0, 0.0, 0.0)];
    let mut ground = common::quad(1.0, Vec2::ZERO, Vec2::ONE, 0);
    ground.vertices = vertices;
    let block = |depth_m: f32, x: f32, material| {
        common::quad(depth_m, vec2(x, -0.35), vec2(x + 0.12 * depth_m, -0.35 + 0.3 * depth_m), material)
    };
    let meshes = vec![ground, block(0.8, -0.3, 1), block(1.2, 0.05, 2), block(3.0, 0.5, 1)];
    let materials = vec![common::textured(), common::unlit(vec3(0.7, 0.7, 0.2)), common::unlit(vec3(0.1, 0.3, 0.6))];
    (common::scene(meshes, materials), common::front_camera())
}

/// Sphere, cylinder and axis: of both signs, upright, level and oblique, with the mean meridian in focus
/// at 1 m or one of the two foci there, which makes a line of a point.
const PRESCRIPTIONS: [[f64; 3]; 5] =
    [[0.4, -0.8, 0.0], [0.4, -0.8, 90.0], [-0.4, 0.8, 20.0], [0.0, 0.8, 45.0], [0.0, -0.8, 45.0]];

/// Spheres of the round blurs that are as wide as either meridian's, or as their mean's.
const SPHERES: [f64; 3] = [-0.4, 0.0, 0.4];

/// By how much a picture may be worse with a cylinder than the same method's worst with a round blur of
/// either meridian's width, dB: rays are noisier, as cones and filters may be no wider than the
/// ellipse is across, and spots that are narrow across are drawn in strips a quarter of a pixel wide. Measured here:
/// 0.5 to 5.3 dB.
const WORSE_DB: f64 = 6.0;

#[test]
fn pictures_are_as_good_as_without_a_cylinder() {
    let size = uvec2(64, 48);
    for (name, (scene, camera)) in [("bars", bars()), ("floor", floor())] {
        let mut view = view_of(&scene, camera, size, 24);
        let base = common::lens(10.0, 1.0);
        let mut error_db = |lens: &Lens| -> (Vec<f64>, ColorImage) {
            let wanted = truth(&mut view, lens);
            let db = able().iter().map(|m| psnr_db(&picture(m.as_ref(), &mut view, lens), &wanted)).collect();
            (db, wanted)
        };
        let round: Vec<(Vec<f64>, ColorImage)> =
            SPHERES.iter().map(|sphere| error_db(&astigmatic(&base, *sphere, 0.0, 0.0))).collect();
        let mut failed = Vec::new();
        for [sphere, cylinder, axis] in PRESCRIPTIONS {
            let (found, wanted) = error_db(&astigmatic(&base, sphere, cylinder, axis));
            assert!(round.iter().all(|(_, picture)| psnr_db(&wanted, picture) < 38.0), "{name}: it is seen");
            for (i, method) in able().iter().enumerate() {
                let id = method.about().id;
                let worst = round.iter().map(|(db, _)| db[i]).fold(f64::INFINITY, f64::min);
                let told = format!(
                    "{name}, {sphere:+} {cylinder:+} x {axis}: {id} {:.2} dB, with round blurs {worst:.2} dB",
                    found[i]
                );
                eprintln!("{told}");
                if found[i] < worst - WORSE_DB {
                    failed.push(told);
                }
            }
        }
        assert!(failed.is_empty(), "{failed:#?}");
    }
}

/// First and second moments of the light in an image: sum, centroid, xx, xy, yy.
fn moments(image: &ColorImage) -> (f64, DVec2, [f64; 3]) {
    let pixels = || {
        image.pixels.iter().enumerate().map(|(i, p)| {
            let at = dvec2((i as u32 % image.size.x).into(), (i as u32 / image.size.x).into());
            (at, f64::from(p.y))
        })
    };
    let sum: f64 = pixels().map(|(_, w)| w).sum();
    let centre = pixels().map(|(at, w)| at * w).sum::<DVec2>() / sum;
    let of = |f: fn(DVec2) -> f64| pixels().map(|(at, w)| f(at - centre) * w).sum::<f64>() / sum;
    (sum, centre, [of(|d| d.x * d.x), of(|d| d.x * d.y), of(|d| d.y * d.y)])
}

/// Light of a point: as much as makes rays bring it as a whole.
const POINT: f32 = 64.0;

/// One lit pixel in a black image at `depth_m`.
fn lone_pixel(size: UVec2, depth_m: f32) -> View {
    let mut color = ColorImage { size, pixels: vec![Vec3::ZERO; size.element_product() as usize] };
    let middle = (size.y / 2 * size.x + size.x / 2) as usize;
    color.pixels[middle] = Vec3::splat(POINT);
    let depth: DepthImage = Image { size, pixels: vec![depth_m; color.pixels.len()] };
    View::of_image(common::gpu(), &color, &depth, 60f64.to_radians()).expect("a view")
}

#[test]
fn a_point_becomes_the_ellipse_of_the_prescription_and_keeps_its_light() {
    let size = uvec2(61, 61);
    for id in ["splat", "scatter", "adaptive"] {
        let method = by_id(id);
        for (aperture, cases) in [(Aperture::Disc, 6), (Aperture::polygon(3), 2)] {
            let base = Lens { aperture, ..common::lens(12.0, 1.0) };
            // At 1 m a circle of least confusion or a line, beyond it ellipses.
            for (depth_m, [sphere, cylinder, axis]) in [
                (1.0, [0.5, -1.0, 30.0]),
                (2.0, [0.0, -1.0, 10.0]),
                (2.0, [0.5, -1.0, 45.0]),
                (1.0, [0.0, 1.2, 45.0]),
                (0.6, [-0.5, 1.0, 90.0]),
                (1.0, [0.0, -1.2, 0.0]),
            ]
            .into_iter()
            .take(cases)
            {
                let lens = astigmatic(&base, sphere, cylinder, axis);
                let mut view = lone_pixel(size, depth_m);
                let image = picture(method.as_ref(), &mut view, &lens);
                let (sum, centre, spread) = moments(&image);
                let sum = sum / f64::from(POINT);
                let matrix =
                    lens.astigmatism_px() + DMat2::from_diagonal(DVec2::splat(lens.coc_diameter_px(depth_m.into())));
                // Lens points have the variance (2 sigma_per_coc)^2 on each axis, the pixel 1/12.
                let lens_spread = matrix * matrix.transpose() * lens.aperture.sigma_per_coc().powi(2);
                let wanted =
                    [lens_spread.x_axis.x + 1.0 / 12.0, lens_spread.x_axis.y, lens_spread.y_axis.y + 1.0 / 12.0];
                let told = format!(
                    "{id} {:?} {sphere:+} {cylinder:+} x {axis} at {depth_m} m: sum {sum:.4}, {spread:.3?} for {wanted:.3?}",
                    lens.aperture
                );
                eprintln!("{told}");
                if id != "scatter" {
                    // scatter divides by what overlapping spots of black pixels sum to.
                    assert!((sum - 1.0).abs() < 0.02, "{told}");
                }
                // A pixel has all that falls on it: the tip of a narrow triangle counts as a pixel away.
                assert!((centre - 30.0).length() < 0.2, "{told}: centre {centre}");
                let scale = wanted[0] + wanted[2];
                for (found, wanted) in spread.iter().zip(wanted) {
                    assert!((found - wanted).abs() < 0.05 * scale + 0.12, "{told}");
                }
            }
        }
    }
}

#[test]
fn shapes_of_apertures_turn_with_depth() {
    // An L before, between and behind the foci: mirrored in one meridian between them.
    let size = uvec2(64, 64);
    let aperture = common::apertures().pop().expect("the L");
    let base = Lens { aperture, ..common::lens(16.0, 1.0) };
    let lens = astigmatic(&base, 0.5, -1.0, 30.0);
    for depth_m in [0.5_f32, 1.0, 4.0] {
        let side = 0.03 * depth_m;
        let meshes = vec![common::quad(depth_m, vec2(-side, -side), vec2(side, side), 0)];
        let scene = common::scene(meshes, vec![common::unlit(Vec3::ONE)]);
        let mut view = view_of(&scene, common::front_camera(), size, 24);
        let wanted = truth(&mut view, &lens);
        for method in able() {
            let id = method.about().id;
            let image = picture(method.as_ref(), &mut view, &lens);
            let apart = |other: &ColorImage| psnr_db(other, &wanted);
            let turned = Image { size, pixels: image.pixels.iter().rev().copied().collect() };
            let mirrored = Image::from_fn(size, |x, y| image.at(size.x - 1 - x, y));
            let told = format!(
                "{id} at {depth_m} m: {:.2} dB, turned {:.2}, mirrored {:.2}",
                apart(&image),
                apart(&turned),
                apart(&mirrored)
            );
            eprintln!("{told}");
            // `scatter` draws a coarse outline of an aperture.
            let margin_db = if id == "scatter" { 0.5 } else { 2.5 };
            assert!(apart(&image) > apart(&turned).max(apart(&mirrored)) + margin_db, "{told}");
        }
    }
}

#[test]
fn a_cylinder_of_zero_changes_nothing() {
    let (scene, camera) = bars();
    let mut view = view_of(&scene, camera, uvec2(64, 48), 16);
    let base = common::lens(10.0, 1.0);
    for method in methods::all() {
        let about = method.about();
        let plain = picture(method.as_ref(), &mut view, &base);
        let turned = picture(method.as_ref(), &mut view, &astigmatic(&base, 0.0, 0.0, 37.0));
        assert_eq!(plain.pixels, turned.pixels, "{}", about.id);
        if !about.astigmatism && about.apertures != Apertures::None {
            // Who cannot blurs as the mean meridian does.
            let mean = picture(method.as_ref(), &mut view, &astigmatic(&base, 0.3, 0.0, 0.0));
            let lens = astigmatic(&base, 0.7, -0.8, 20.0);
            assert_eq!(picture(method.as_ref(), &mut view, &lens).pixels, mean.pixels, "{}", about.id);
        }
    }
}

#[test]
fn what_only_the_moved_frame_shows_is_drawn() {
    // Just outside of the frame: the blur of an astigmatic or short-sighted eye brings it in.
    let size = uvec2(64, 48);
    let (depth_m, half) = (3.0_f32, 3.0_f32 * (30f32.to_radians()).tan());
    let at = 1.1 * half * 64.0 / 48.0;
    let meshes = vec![common::quad(depth_m, vec2(at, -0.2), vec2(at + 0.3, 0.2), 0)];
    let scene = common::scene(meshes, vec![common::unlit(Vec3::splat(100.0))]);
    let camera = common::front_camera();
    for (sphere, cylinder, focus_m) in [(1.0, -2.0, 3.0), (-1.0, 0.0, 3.0), (-2.0, 0.0, f64::INFINITY)] {
        let lens = astigmatic(&common::lens(20.0, focus_m), sphere, cylinder, 90.0);
        let mut view = view_of(&scene, camera, size, 0);
        let light = |image: &ColorImage| image.pixels.iter().map(|p| f64::from(p.y)).sum::<f64>();
        let drawn = light(&truth(&mut view, &lens));
        let rays = Arc::new(RayScene::new(Arc::new(scene.clone()), &camera).expect("rays"));
        let options = RayOptions { lens_points: 0..LENS_POINTS, shading: Shading::Scene, view_dependent: false };
        let render = RayRender::new(rays, &camera.projection(size, 0), &lens, &options).expect("a lens");
        let traced = light(&render.run(|_, _| ControlFlow::Continue(())).color);
        let told = format!("{sphere} {cylinder} focused at {focus_m} m: {drawn} and {traced}");
        eprintln!("{told}");
        assert!(traced > 1.0 && (drawn / traced - 1.0).abs() < 0.1, "{told}");
    }
}
