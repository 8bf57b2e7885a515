//! Two eyes: asymmetric frusta in both references and in the methods, and how two pictures
//! become one.

#[path = "../../../tests/common/mod.rs"]
mod common;

use common::{front_camera, gpu, lens, quad, scene, textured};
use defocus::camera::Camera;
use defocus::combine::{self, Channel};
use defocus::gpu::{download, download_rgba8, upload};
use defocus::image::{ColorImage, Image};
use defocus::image_io::srgb::{linear_from_srgb_f32, srgb_from_linear_f32};
use defocus::lens::Lens;
use defocus::methods::{self, Accumulation, Method};
use defocus::present;
use defocus::raytrace::{RayOptions, RayRender, RayScene, Shading};
use defocus::scene::Scene;
use defocus::stereo::{Layout, Stereo, refresh_met};
use defocus::view::{GpuScene, SurfaceOptions, View};
use defocus_study::builtin::builtin;
use defocus_study::metrics::{self, CompareOptions};
use glam::{DVec2, DVec3, UVec2, Vec2, Vec3, dvec2, uvec2, vec3};
use std::ops::ControlFlow;
use std::sync::Arc;

/// An eye 0.2 m beside the middle of a window 1 m away, and looking up through it: far more
/// asymmetric than any headset.
fn oblique(camera: Camera) -> Camera {
    Camera { frame_centre_slope: dvec2(0.2, -0.1), ..camera.beside(0.05, 0.5) }
}

fn pixel_of(camera: &Camera, size: UVec2, lens: &Lens, v: DVec2, point: DVec3) -> DVec2 {
    let projection = camera.projection(size, 8);
    let view = camera.view_from_world().transform_point3(point);
    let clip = projection.clip_from_view(lens, v).as_dmat4() * view.extend(1.0);
    dvec2(0.5 + 0.5 * clip.x / clip.w, 0.5 - 0.5 * clip.y / clip.w) * projection.outer_size().as_dvec2() - 8.0
}

#[test]
fn eyes_see_the_window_in_one_place_and_the_rest_with_disparity() {
    let camera = front_camera();
    let size = uvec2(320, 240);
    for window_m in [0.7, 2.0, f64::INFINITY] {
        let stereo = Stereo { ipd_mm: 64.0, window_m, ..Stereo::default() };
        let [left, right] = stereo.eyes(&camera);
        assert!((left.position.distance(right.position) - 0.064).abs() < 1e-12);
        assert!(left.position.x < right.position.x, "the left eye is on the left");
        for depth_m in [0.7, 1.3, 2.0, 50.0] {
            let point = DVec3::new(0.1, -0.2, -depth_m);
            let [l, r] = [left, right].map(|eye| pixel_of(&eye, size, &Lens::PINHOLE, DVec2::ZERO, point));
            let expected = stereo.disparity_px(camera.projection(size, 0).focal_px, depth_m);
            // The matrix is f32: 6e-8 of some 500 px.
            assert!((l - r - dvec2(expected, 0.0)).length() < 1e-4, "{} not {expected} at {depth_m} m", l - r);
            if depth_m == window_m {
                assert!(expected.abs() < 1e-9);
            }
        }
    }
}

#[test]
fn an_oblique_eye_blurs_by_the_same_coc() {
    let camera = oblique(front_camera());
    let lens = lens(20.0, 2.0);
    let projection = camera.projection(uvec2(320, 240), 8);
    for v in [DVec2::ZERO, DVec2::X, dvec2(-0.3, 0.8)] {
        for depth_m in [0.6, 2.0, 9.0] {
            let at = dvec2(100.5, 31.5);
            let point = camera.position + camera.orientation * (projection.view_direction(at) * depth_m);
            let seen = pixel_of(&camera, uvec2(320, 240), &lens, v, point);
            let expected = at + v * lens.coc_diameter_px(depth_m) / 2.0;
            assert!((seen - expected).length() < 1e-4, "{seen} not {expected}");
        }
    }
    let [left, right] = [dvec2(0.0, 120.0), dvec2(320.0, 120.0)].map(|p| projection.view_direction(p));
    let angle = right.x.atan() - left.x.atan();
    assert!((projection.fov_x() - angle).abs() < 1e-12, "the angle between the frame's sides");
}

/// An image of the methods and the one that rays give, of an oblique view of a scene.
fn both(scene: Scene, camera: Camera, size: UVec2, method: &dyn Method, lens: &Lens, points: u32) -> [ColorImage; 2] {
    let surfaces = GpuScene::new(gpu(), &scene, SurfaceOptions { unlit: true, mipmaps: false });
    let mut view = View::of_scene(surfaces, camera, size, 16).unwrap();
    let mut frame = gpu().frame();
    let texture = methods::record(method, &mut frame, &mut view, lens).unwrap();
    frame.finish();
    let rays = Arc::new(RayScene::new(Arc::new(scene), &camera).unwrap());
    let options = RayOptions { lens_points: 0..points, shading: Shading::Unlit, view_dependent: false };
    let traced = RayRender::new(rays, view.projection(), lens, &options).unwrap();
    [download(gpu(), &texture), traced.run(|_, _| ControlFlow::Continue(())).color]
}

fn psnr_db(a: &ColorImage, b: &ColorImage) -> f64 {
    metrics::compare(b, a, &CompareOptions::default()).unwrap().psnr_db.unwrap_or(f64::INFINITY)
}

#[test]
fn rasteriser_and_ray_tracer_agree_on_an_oblique_eye() {
    let scene = builtin("cans").unwrap().load().unwrap();
    let camera = oblique(scene.cameras[0].camera);
    let lens = Lens { aperture_diameter_mm: 8.0, focus_distance_m: 0.9, ..Lens::PINHOLE };
    let method = Accumulation { samples: 16, view_dependent: false };
    let [rasterised, traced] = both(scene.clone(), camera, uvec2(160, 120), &method, &lens, 16);
    let db = psnr_db(&rasterised, &traced);
    println!("oblique cans: {db:.2} dB");
    // The bound of the symmetric view, for the same reasons (tests/references.rs).
    assert!(db >= 40.0, "{db} dB");
    // And not with a symmetric frustum: the test would notice.
    let straight = Camera { frame_centre_slope: DVec2::ZERO, ..camera };
    let [symmetric, _] = both(scene, straight, uvec2(160, 120), &method, &lens, 1);
    assert!(psnr_db(&symmetric, &traced) < 25.0);
}

/// Every method of the registry blurs an oblique view as well as a straight one: a textured
/// wall behind the focus, whose blur is the same everywhere.
#[test]
fn every_method_takes_an_oblique_eye() {
    let wall = || scene(vec![quad(4.0, Vec2::splat(-16.0), Vec2::splat(16.0), 0)], vec![textured()]);
    let lens = lens(8.0, 2.0);
    for method in methods::all() {
        let about = method.about();
        let db = [front_camera(), oblique(front_camera())].map(|camera| {
            let [image, traced] = both(wall(), camera, uvec2(96, 72), method.as_ref(), &lens, 64);
            psnr_db(&image, &traced)
        });
        println!("{}: {:.1} dB straight, {:.1} dB oblique", about.id, db[0], db[1]);
        // Other texels lie under the pixels, hence the margin; a frustum mistaken for a
        // symmetric one shows the wall elsewhere, below 15 dB.
        assert!(db[1] > db[0] - 4.0 || db[1] > 40.0, "{}: {db:?}", about.id);
    }
}

#[test]
fn pictures_stand_side_by_side_or_become_an_anaglyph() {
    let color = |x: u32, y: u32| vec3(x as f32 / 15.0, y as f32 / 7.0, ((x + y) % 5) as f32 / 4.0);
    let left: ColorImage = Image::from_fn(uvec2(16, 8), color);
    let right: ColorImage = Image::from_fn(uvec2(16, 8), |x, y| color(15 - x, y));
    let mut frame = gpu().frame();
    let shown = [&left, &right].map(|image| {
        let linear = upload(gpu(), "eye", image);
        present::picture(&mut frame, &linear, &Default::default())
    });
    let combined = Layout::ALL.map(|(layout, _)| combine::stereo(&mut frame, &shown[0], &shown[1], layout));
    let green = combine::isolated(&mut frame, &shown[0], Channel::Green);
    let all = combine::isolated(&mut frame, &shown[0], Channel::All);
    frame.finish();
    assert!(all.same(&shown[0]), "all channels are the picture itself");
    let eyes = shown.map(|texture| download_rgba8(gpu(), &texture));
    let [parallel, crossed, dubois, grey] = combined.map(|texture| download_rgba8(gpu(), &texture));
    assert_eq!(parallel.size, uvec2(32, 8));
    assert_eq!(parallel.crop(UVec2::ZERO, uvec2(16, 8)), eyes[0]);
    assert_eq!(parallel.crop(uvec2(16, 0), uvec2(16, 8)), eyes[1]);
    assert_eq!(crossed.crop(UVec2::ZERO, uvec2(16, 8)), eyes[1]);
    let linear = |p: [u8; 4]| Vec3::from_array([0, 1, 2].map(|i| linear_from_srgb_f32(f32::from(p[i]) / 255.0)));
    let steps = |p: [u8; 4], expected: Vec3| {
        let encoded = expected.to_array().map(|v| 255.0 * srgb_from_linear_f32(v));
        (0..3).map(|i| (f32::from(p[i]) - encoded[i]).abs()).fold(0.0, f32::max)
    };
    for (layout, image) in [(Layout::Anaglyph, &dubois), (Layout::GreyAnaglyph, &grey)] {
        for (i, pixel) in image.pixels.iter().enumerate() {
            let expected = layout.anaglyph(linear(eyes[0].pixels[i]), linear(eyes[1].pixels[i]));
            // Half a step of quantisation and as much for the GPU's pow.
            assert!(steps(*pixel, expected) <= 1.0, "{layout:?} at {i}: {pixel:?}");
        }
    }
    for (pixel, picture) in download_rgba8(gpu(), &green).pixels.iter().zip(&eyes[0].pixels) {
        assert!(steps(*pixel, Vec3::splat(linear(*picture).y)) <= 1.0);
    }
}

#[test]
fn anaglyphs_keep_white_and_part_the_eyes() {
    for layout in [Layout::Anaglyph, Layout::GreyAnaglyph] {
        let white = layout.anaglyph(Vec3::ONE, Vec3::ONE);
        // Dubois gives six digits of 18 coefficients.
        assert!((white - Vec3::ONE).abs().max_element() < 2e-5, "{layout:?}: {white}");
        let left = layout.anaglyph(Vec3::ONE, Vec3::ZERO);
        assert!(left.x > 0.9 && left.y < 0.1 && left.z < 0.1, "the left eye has the red glass: {left}");
        let right = layout.anaglyph(Vec3::ZERO, Vec3::ONE);
        assert!(right.x < 0.1 && right.y > 0.9 && right.z > 0.9, "the right eye has the cyan glass: {right}");
    }
    assert_eq!(refresh_met(1000.0 / 90.0), [true, true, false, false, false]);
}
