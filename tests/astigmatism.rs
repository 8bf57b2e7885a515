//! The elliptical blur of an astigmatic eye, in the methods that render it, against accumulation.

mod common;

use defocus::aperture::Aperture;
use defocus::camera::Camera;
use defocus::eye::{Eye, Refraction};
use defocus::gpu::download;
use defocus::image::{ColorImage, DepthImage, Image};
use defocus::lens::Lens;
use defocus::methods::{self, Accumulation, Apertures, Method};
use defocus::scene::{Scene, Vertex};
use defocus::view::{GpuScene, SurfaceOptions, View};
use glam::{DMat2, DVec2, UVec2, Vec2, Vec3, dvec2, uvec2, vec2};

/// Lens points of the pictures that others are held against: two such agree to 45 dB and more.
const LENS_POINTS: u32 = 512;

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
/// at 1 m or one of the two foci there.
const PRESCRIPTIONS: [[f64; 3]; 6] = [
    [0.4, -0.8, 0.0],
    [0.4, -0.8, 45.0],
    [0.4, -0.8, 90.0],
    [-0.4, 0.8, 20.0],
    // The meridian at 45 or at 135 degrees is in focus at 1 m: a line.
    [0.0, 0.8, 45.0],
    [0.0, -0.8, 135.0],
];

/// By how much a picture may be worse with a cylinder than the same method's without one, dB. Between
/// its two foci an astigmatic eye sees nothing sharp, where others see what needs no blur: the fairest
/// comparison is with a round blur as wide as the longer axis, and the rest is noise.
const WORSE_DB: f64 = 2.0;

#[test]
fn pictures_are_as_good_as_without_a_cylinder() {
    let size = uvec2(96, 72);
    let mut worst = vec![f64::INFINITY; able().len()];
    for (name, (scene, camera)) in [("bars", bars()), ("floor", floor())] {
        let mut view = view_of(&scene, camera, size, 24);
        let base = common::lens(10.0, 1.0);
        let round_truth = truth(&mut view, &base);
        let round: Vec<f64> =
            able().iter().map(|m| psnr_db(&picture(m.as_ref(), &mut view, &base), &round_truth)).collect();
        for [sphere, cylinder, axis] in PRESCRIPTIONS {
            let lens = astigmatic(&base, sphere, cylinder, axis);
            let wanted = truth(&mut view, &lens);
            assert!(psnr_db(&wanted, &round_truth) < 32.0, "{name}, {cylinder} x {axis}: it is seen");
            for (i, method) in able().iter().enumerate() {
                let id = method.about().id;
                let db = psnr_db(&picture(method.as_ref(), &mut view, &lens), &wanted);
                eprintln!("{name} {sphere:+} {cylinder:+} x {axis}: {id} {db:.2} dB, round {:.2} dB", round[i]);
                worst[i] = worst[i].min(db - round[i]);
            }
        }
    }
    eprintln!("least difference: {worst:.2?}");
    assert!(worst.iter().all(|d| *d > -WORSE_DB), "{worst:.2?}");
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

/// One lit pixel in a black image at `depth_m`.
fn lone_pixel(size: UVec2, depth_m: f32) -> View {
    let mut color = ColorImage { size, pixels: vec![Vec3::ZERO; size.element_product() as usize] };
    let middle = (size.y / 2 * size.x + size.x / 2) as usize;
    color.pixels[middle] = Vec3::ONE;
    let depth: DepthImage = Image { size, pixels: vec![depth_m; color.pixels.len()] };
    View::of_image(common::gpu(), &color, &depth, 60f64.to_radians()).expect("a view")
}

#[test]
fn a_point_becomes_the_ellipse_of_the_prescription_and_keeps_its_light() {
    let size = uvec2(81, 81);
    for id in ["splat", "scatter", "adaptive"] {
        let method = by_id(id);
        for aperture in [Aperture::Disc, Aperture::polygon(3), Aperture::Gaussian { sigma_per_coc: 0.25 }] {
            let base = Lens { aperture, ..common::lens(12.0, 1.0) };
            // At 1 m a circle of least confusion or a line, beyond it ellipses.
            for (depth_m, [sphere, cylinder, axis]) in [
                (1.0, [0.5, -1.0, 30.0]),
                (2.0, [0.0, -1.0, 10.0]),
                (2.0, [0.5, -1.0, 45.0]),
                (1.0, [0.0, 1.2, 45.0]),
                (0.6, [-0.5, 1.0, 90.0]),
                (1.0, [0.0, -1.2, 0.0]),
            ] {
                let lens = astigmatic(&base, sphere, cylinder, axis);
                let mut view = lone_pixel(size, depth_m);
                let image = picture(method.as_ref(), &mut view, &lens);
                let (sum, centre, spread) = moments(&image);
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
                assert!((centre - 40.0).length() < 0.1, "{told}: centre {centre}");
                let scale = wanted[0] + wanted[2];
                for (found, wanted) in spread.iter().zip(wanted) {
                    assert!((found - wanted).abs() < 0.05 * scale + 0.1, "{told}");
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
        let side = 0.012 * depth_m;
        let meshes = vec![common::quad(depth_m, vec2(-side, -side), vec2(side, side), 0)];
        let scene = common::scene(meshes, vec![common::unlit(Vec3::splat(20.0))]);
        let mut view = view_of(&scene, common::front_camera(), size, 24);
        let wanted = truth(&mut view, &lens);
        let peak = f64::from(wanted.pixels.iter().map(|p| p.y).fold(0.0, f32::max));
        for method in able() {
            let id = method.about().id;
            let image = picture(method.as_ref(), &mut view, &lens);
            let db = psnr_db(&image, &wanted) + 20.0 * peak.log10();
            eprintln!("{id} at {depth_m} m: {db:.2} dB");
            let mirrored = Image { size, pixels: image.pixels.iter().rev().copied().collect() };
            assert!(db > psnr_db(&mirrored, &wanted) + 20.0 * peak.log10() + 3.0, "{id} at {depth_m} m: {db} dB");
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
    let right = half * 64.0 / 48.0;
    let at = right * 1.02;
    let meshes = vec![common::quad(depth_m, vec2(at, -0.4), vec2(at + 0.3, 0.4), 0)];
    let scene = common::scene(meshes, vec![common::unlit(Vec3::ONE)]);
    for (sphere, cylinder, focus_m) in [(1.0, -2.0, 3.0), (-2.0, 0.0, 3.0), (-3.0, 0.0, f64::INFINITY)] {
        let lens = astigmatic(&common::lens(20.0, focus_m), sphere, cylinder, 90.0);
        let mut view = view_of(&scene, common::front_camera(), size, 0);
        let image = truth(&mut view, &lens);
        let bright = image.at(63, 24).y;
        assert!(bright > 0.1, "{sphere} {cylinder} focused at {focus_m} m: {bright}");
    }
}
