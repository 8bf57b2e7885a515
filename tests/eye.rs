//! The eye behind the lens, against published figures and closed forms.

mod common;

use defocus::aperture::Aperture;
use defocus::camera::Camera;
use defocus::eye::{
    BLUR_DETECTION_D, Comfort, ComfortZone, DAYLIGHT_NM, Eye, Pupil, Refraction, amplitude_d, chromatic_defocus_d,
    conflict_d, depth_of_focus_d, eye_presets, pupil_diameter_mm,
};
use defocus::gpu::{FrameStats, download};
use defocus::image::ColorImage;
use defocus::lens::Lens;
use defocus::methods::{self, Method};
use defocus::raytrace::{RayOptions, RayRender, RayScene, Shading};
use defocus::scene::{Material, Scene};
use defocus::view::{GpuScene, SurfaceOptions, View};
use glam::{DVec2, UVec2, Vec2, Vec3, dvec2, uvec2, vec2};
use std::ops::ControlFlow;
use std::sync::Arc;

fn close(found: f64, wanted: f64, tolerance: f64) {
    assert!((found - wanted).abs() <= tolerance, "{found}, and not {wanted}");
}

fn eye_lens(eye: Eye) -> Lens {
    Lens {
        aperture_diameter_mm: 4.0,
        screen_distance_mm: 1000.0,
        density_px_per_mm: 1.432_394,
        focus_distance_m: 1.0,
        eye,
        ..Lens::PINHOLE
    }
}

#[test]
fn the_pupil_is_that_of_watson_and_yellott() {
    // 60 degrees, both eyes, 30 years.
    for (luminance_cd_m2, mm) in [(1.0, 5.120), (10.0, 3.828), (100.0, 2.887), (1000.0, 2.383)] {
        close(Pupil { luminance_cd_m2, ..Pupil::default() }.diameter_mm(), mm, 0.001);
    }
    // One eye sees a tenth of the light.
    let one = Pupil { luminance_cd_m2: 100.0, both_eyes: false, ..Pupil::default() };
    close(one.diameter_mm(), Pupil { luminance_cd_m2: 10.0, ..Pupil::default() }.diameter_mm(), 1e-12);
    // At the age of reference it is Stanley and Davies' formula: halfway at x = 2.
    close(pupil_diameter_mm(846.0 * 2_f64.powf(1.0 / 0.41), 28.58), 7.75 - 5.75 / 2.0, 1e-9);
    // In the dark the old have narrower pupils.
    assert!(pupil_diameter_mm(1.0, 80.0) < pupil_diameter_mm(1.0, 20.0) - 1.0);
    let absurd = [
        Pupil { luminance_cd_m2: -1.0, ..Pupil::default() },
        Pupil { luminance_cd_m2: f64::NAN, ..Pupil::default() },
        Pupil { age_years: 5.0, ..Pupil::default() },
        Pupil { field_deg: 0.0, ..Pupil::default() },
    ];
    for pupil in absurd {
        assert!(pupil.check().is_err() && pupil.repaired() == Pupil::default(), "{pupil:?}");
    }
}

#[test]
fn colours_are_focused_as_thibos_measured() {
    close(chromatic_defocus_d(700.0) - chromatic_defocus_d(400.0), 2.10, 0.01);
    let [f, c] = DAYLIGHT_NM;
    close(chromatic_defocus_d(c) - chromatic_defocus_d(f), 0.90, 0.01);
    close(chromatic_defocus_d(589.0), 0.0, 0.01);

    let lens = eye_lens(Eye::default().chromatic());
    let [red, green, blue] = lens.primaries().expect("it has three");
    close(green.focus_d(), 1.0, 1e-12);
    // Green at 1 m: red farther, blue nearer, by the differences of the formula.
    close(red.focus_d(), 1.0 - (chromatic_defocus_d(617.0) - chromatic_defocus_d(520.0)), 1e-12);
    close(blue.focus_d(), 1.0 + (chromatic_defocus_d(520.0) - chromatic_defocus_d(449.0)), 1e-12);
    assert!(red.focus_d() < 0.6 && blue.focus_d() > 1.6);
    // A dioptre is as wide for all of them.
    for primary in [&red, &green, &blue] {
        close(primary.px_per_dioptre(), lens.px_per_dioptre(), 1e-9);
        for depth_m in [0.3, 1.0, 5.0] {
            let wanted = lens.px_per_dioptre() * (primary.focus_d() - 1.0 / depth_m);
            close(primary.coc_diameter_px(depth_m), wanted, 1e-9);
        }
        assert_eq!(primary.primaries(), None, "a primary has one colour");
    }
    // Focused far away, red is sharp nowhere: in front of its focus everything is.
    let far = Lens { focus_distance_m: 10.0, ..lens };
    let [red, ..] = far.primaries().expect("it has three");
    assert!(red.focus_d() < 0.0 && red.sharpest_m().is_infinite());
    assert!(red.coc_diameter_px(1e9) < 0.0 && red.check().is_ok());
}

#[test]
fn prescriptions_follow_closed_forms() {
    let refraction = Refraction { sphere_d: -2.0, cylinder_d: -1.5, axis_deg: 90.0 };
    close(refraction.power_d(90.0), -2.0, 1e-12);
    close(refraction.power_d(0.0), -3.5, 1e-12);
    close(refraction.spherical_equivalent_d(), -2.75, 1e-12);
    // The matrix has the meridians' differences from the mean on its diagonal, turned about.
    for axis_deg in [0.0, 30.0, 90.0, 135.0] {
        let refraction = Refraction { axis_deg, ..refraction };
        for meridian_deg in [0.0, 45.0, 77.0, 160.0_f64] {
            let direction = DVec2::from_angle(meridian_deg.to_radians());
            let along = direction.dot(refraction.astigmatism_d() * direction);
            close(along, refraction.spherical_equivalent_d() - refraction.power_d(meridian_deg), 1e-12);
        }
    }
    for broken in [
        Refraction { sphere_d: 99.0, ..refraction },
        Refraction { cylinder_d: f64::NAN, ..refraction },
        Refraction { axis_deg: -5.0, ..refraction },
    ] {
        let eye = Eye { refraction: broken, ..Eye::default() };
        assert!(eye_lens(eye).check().is_err() && eye.repaired() == Eye::default());
    }
}

#[test]
fn what_an_eye_cannot_reach_is_said() {
    // Hofstetter: 18.5 - 0.3 age.
    for (age, d) in [(10.0, 15.5), (25.0, 11.0), (55.0, 2.0), (70.0, 0.0)] {
        close(amplitude_d(age), d, 1e-12);
    }
    let weak = Eye { accommodation_d: Some(1.0), ..Eye::default() };
    let lens = Lens { focus_distance_m: 0.4, ..eye_lens(weak) };
    close(lens.focus_d(), 1.0, 1e-12);
    close(lens.sharpest_m(), 1.0, 1e-12);
    close(lens.coc_diameter_px(1.0), 0.0, 1e-9);
    assert_eq!(
        weak.out_of_reach(2.5).expect("it is out of reach"),
        "focused at 0.4 m needs 2.5 D of accommodation; this eye has 1 D: sharpest at 1 m"
    );
    assert_eq!(weak.out_of_reach(0.7), None);
    // A myope of -3 D sees no farther than a third of a metre.
    let myope = Eye { refraction: Refraction { sphere_d: -3.0, ..Refraction::default() }, ..Eye::default() };
    let lens = eye_lens(myope);
    close(lens.sharpest_m(), 1.0 / 3.0, 1e-12);
    close(lens.coc_diameter_px(1.0), 2.0 * lens.px_per_dioptre(), 1e-9);
    assert!(myope.out_of_reach(1.0).is_some_and(|why| why.contains("far point of this eye is 0.33 m")));
    // A hyperope at rest sees sharply nowhere, and accommodates to do so.
    let far_sighted = Refraction { sphere_d: 2.0, ..Refraction::default() };
    let old = Eye { refraction: far_sighted, accommodation_d: Some(1.0), ..Eye::default() };
    close(eye_lens(old).focus_d(), -1.0, 1e-12);
    close(eye_lens(Eye { accommodation_d: Some(4.0), ..old }).focus_d(), 1.0, 1e-12);
    let [emmetrope, presbyope, ..] = eye_presets();
    assert!(amplitude_d(emmetrope.age_years) > 10.0 && amplitude_d(presbyope.age_years) < 3.0);
}

#[test]
fn an_eye_that_adds_nothing_changes_nothing() {
    for focus_distance_m in [0.1, 1.0 / 3.0, 0.7, 1.7, 30.0, f64::INFINITY] {
        let lens = Lens { focus_distance_m, ..eye_lens(Eye::default()) };
        assert_eq!(lens.sharpest_m(), focus_distance_m);
        assert_eq!(lens.stored_focus(0.1), 0.1 / focus_distance_m);
        let able = Lens { eye: Eye { accommodation_d: Some(12.0), ..Eye::default() }, ..lens.clone() };
        assert_eq!(able.coc(), lens.coc());
        let text = ron::to_string(&lens).expect("it is written");
        assert!(!text.contains("eye"), "{text}");
        assert_eq!(ron::from_str::<Lens>(&text).expect("it is read"), lens);
        let chromatic = Lens { eye: Eye::default().chromatic(), ..lens.clone() };
        let text = ron::to_string(&chromatic).expect("it is written");
        assert_eq!(ron::from_str::<Lens>(&text).expect("it is read"), chromatic);
    }
}

#[test]
fn conflict_and_comfort_are_those_of_the_papers() {
    close(conflict_d(0.5, 2.0), 1.5, 1e-12);
    close(conflict_d(f64::INFINITY, 2.0), -0.5, 1e-12);
    let zone = ComfortZone::default();
    // The paper's lines, focal by vergence distance: what lies on them is the border.
    for display_d in [0.3, 1.0, 2.0, 3.0] {
        let [near, far] = zone.at(display_d);
        close(1.035 * near - 0.626, display_d, 1e-9);
        close(1.129 * far + 0.442, display_d, 1e-9);
        assert!(near > display_d && far < display_d);
    }
    assert_eq!(zone.judge(1.0, 1.0), Comfort::Comfortable);
    assert_eq!(zone.judge(0.3, 1.3), Comfort::TooNear);
    assert_eq!(zone.judge(f64::INFINITY, 0.4), Comfort::TooFar);
    assert_eq!(zone.judge(f64::INFINITY, 3.0), Comfort::Comfortable, "a far screen suits the sky");
    let [narrow, wide] = depth_of_focus_d(1.0);
    close(narrow[0] - 1.0, *BLUR_DETECTION_D.start(), 1e-12);
    close(1.0 - wide[1], *BLUR_DETECTION_D.end(), 1e-12);
}

/// White and black halves at `depth_m`, wider than the view.
fn edge(depth_m: f32) -> (Scene, Camera) {
    let width = 2.0 * depth_m;
    let quad = |from: Vec2, to: Vec2, material| common::quad(depth_m, from, to, material);
    let meshes = vec![quad(vec2(-width, -width), vec2(0.0, width), 0), quad(vec2(0.0, -width), vec2(width, width), 1)];
    let materials: Vec<Material> = vec![common::unlit(Vec3::ONE), common::unlit(Vec3::ZERO)];
    (common::scene(meshes, materials), common::front_camera())
}

fn view_of(scene: &Scene, camera: Camera, size: UVec2) -> View {
    let gpu = common::gpu();
    let uploaded = GpuScene::new(gpu, scene, SurfaceOptions::default());
    View::of_scene(uploaded, camera, size, 16).expect("a view")
}

fn picture(method: &dyn Method, view: &mut View, lens: &Lens) -> ColorImage {
    let gpu = common::gpu();
    let mut frame = gpu.frame();
    let texture = methods::record(method, &mut frame, view, lens).expect("a picture");
    frame.finish();
    download(gpu, &texture)
}

/// How wide the edge in the middle row is, px: the spread of its derivative in one channel.
fn edge_width_px(image: &ColorImage, channel: usize) -> f64 {
    let y = image.size.y / 2;
    let row: Vec<f64> = (0..image.size.x).map(|x| f64::from(image.at(x, y)[channel])).collect();
    let slopes: Vec<f64> = row.windows(2).map(|w| (w[0] - w[1]).max(0.0)).collect();
    let sum: f64 = slopes.iter().sum();
    let mean = slopes.iter().zip(0..).map(|(s, x)| s * f64::from(x)).sum::<f64>() / sum;
    let variance = slopes.iter().zip(0..).map(|(s, x)| s * (f64::from(x) - mean).powi(2)).sum::<f64>() / sum;
    variance.sqrt()
}

/// ChromaBlur, figure 2: behind the focus the fringe is blue outside, in front of it red.
#[test]
fn fringes_have_the_colours_of_the_eye_for_every_method() {
    let size = uvec2(64, 48);
    let gpu = common::gpu();
    for (depth_m, wider, narrower) in [(0.6_f32, 0, 2), (4.0, 2, 0)] {
        let (scene, camera) = edge(depth_m);
        let base = common::lens(10.0, 1.0);
        let lens = Lens { eye: Eye::default().chromatic(), ..base };
        let mut view = view_of(&scene, camera, size);
        for method in methods::all().iter().filter(|m| m.about().id != "pinhole") {
            let image = picture(method.as_ref(), &mut view, &lens);
            let (wide, narrow) = (edge_width_px(&image, wider), edge_width_px(&image, narrower));
            let id = method.about().id;
            assert!(wide > 1.15 * narrow, "{id} at {depth_m} m: {wide} px and {narrow} px");
            // Each channel is the method's own picture through that primary's lens.
            let primaries = lens.primaries().expect("it has three");
            for (channel, primary) in primaries.iter().enumerate() {
                let alone = picture(method.as_ref(), &mut view, primary);
                let worst = image.pixels.iter().zip(&alone.pixels).map(|(a, b)| (a[channel] - b[channel]).abs());
                assert!(worst.fold(0.0, f32::max) < 1e-3, "{id}, channel {channel}");
            }
        }
        let mut frame = gpu.frame();
        let accumulation = methods::by_id("accumulation").expect("it is there");
        let (mut run, samples) = methods::converging(accumulation.as_ref(), &lens).expect("it converges");
        run.advance(&mut frame, &mut view, &lens, samples).expect("views");
        let mean = run.mean(&mut frame);
        frame.finish();
        let at_once = picture(accumulation.as_ref(), &mut view, &lens);
        assert_eq!((run.count(), download(gpu, &mean).pixels), (samples, at_once.pixels));
    }
}

/// Counts of the first frame of a view, and of one in which nothing has changed.
fn counts(method: &dyn Method, scene: &Scene, camera: Camera, lens: &Lens) -> [FrameStats; 2] {
    let mut view = view_of(scene, camera, uvec2(32, 24));
    std::array::from_fn(|_| {
        let mut frame = common::gpu().frame();
        methods::record(method, &mut frame, &mut view, lens).expect("a picture");
        frame.finish().stats
    })
}

#[test]
fn three_lenses_cost_three_times_one_and_draw_no_more() {
    // Near and far of the focus, so that what the foreground hides is asked for, and glass.
    let glass = Material { base_color: Vec3::ONE.extend(0.5), blended: true, ..common::unlit(Vec3::ONE) };
    let quad =
        |depth_m: f32, half: f32, material| common::quad(depth_m, -Vec2::splat(half), Vec2::splat(half), material);
    let meshes = vec![quad(0.5, 0.1, 0), quad(1.4, 0.4, 1), quad(4.0, 9.0, 1)];
    let materials = vec![common::unlit(Vec3::splat(4.0)), common::unlit(Vec3::splat(0.3))];
    let solid = common::scene(meshes.clone(), materials.clone());
    let with_glass = common::scene([meshes, vec![quad(0.8, 0.2, 2)]].concat(), [materials, vec![glass]].concat());
    let plain = common::lens(10.0, 1.0);
    let chromatic = Lens { eye: Eye::default().chromatic(), ..plain.clone() };
    for (name, scene) in [("solid", &solid), ("glass", &with_glass)] {
        for mut method in methods::all() {
            let id = method.about().id;
            if id == "accumulation" {
                method = Box::new(methods::Accumulation { samples: 4, view_dependent: false });
            }
            let one = counts(method.as_ref(), scene, common::front_camera(), &plain);
            let three = counts(method.as_ref(), scene, common::front_camera(), &chromatic);
            let lenses = chromatic.primaries().expect("it has three");
            let primaries = lenses.map(|lens| counts(method.as_ref(), scene, common::front_camera(), &lens));
            for (when, one, three) in [("first", &one[0], &three[0]), ("again", &one[1], &three[1])] {
                let told = format!("{id}, {name}, {when}: {one:?} and {three:?}");
                eprintln!(
                    "{id}, {name}, {when}: {} and {} passes, {} and {} views",
                    one.passes, three.passes, one.views, three.views
                );
                if id == "accumulation" {
                    // Views from the lens are what it is made of: each primary has its own.
                    assert!(three.views <= 3 * one.views, "{told}");
                } else {
                    assert!(three.views <= one.views, "{told}");
                }
                // Where the number of passes grows with blur, red has more of them than green: one lens is
                // that of the primary which takes most. One pass more brings the three together.
                let alone = |count: fn(&FrameStats) -> u64| {
                    let most = primaries.iter().map(|stats| count(&stats[usize::from(when == "again")])).max();
                    most.unwrap_or(0).max(count(one)) as f64
                };
                assert!(three.passes as f64 <= 3.2 * alone(|stats| stats.passes) + 1.0, "{told}");
                assert!(three.dispatches as f64 <= 3.2 * alone(|stats| stats.dispatches) + 1.0, "{told}");
            }
        }
    }
}

fn traced(scene: &Scene, camera: Camera, size: UVec2, lens: &Lens, points: u32) -> ColorImage {
    let rays = Arc::new(RayScene::new(Arc::new(scene.clone()), &camera).expect("rays"));
    let options = RayOptions { lens_points: 0..points, shading: Shading::Scene, view_dependent: false };
    let render = RayRender::new(rays, &camera.projection(size, 0), lens, &options).expect("a lens");
    render.run(|_, _| ControlFlow::Continue(())).color
}

fn psnr_db(a: &ColorImage, b: &ColorImage) -> f64 {
    let squares = a.pixels.iter().zip(&b.pixels).map(|(a, b)| f64::from((*a - *b).length_squared()));
    let mse = squares.sum::<f64>() / (3.0 * a.pixels.len() as f64);
    -10.0 * mse.log10()
}

/// A bright square at `depth_m` before a dark wall.
fn square(depth_m: f32) -> (Scene, Camera) {
    let side = 0.06 * depth_m;
    let meshes = vec![
        common::quad(depth_m, vec2(-side, -side), vec2(side, side), 0),
        common::quad(6.0, vec2(-9.0, -9.0), vec2(9.0, 9.0), 1),
    ];
    (common::scene(meshes, vec![common::unlit(Vec3::ONE), common::unlit(Vec3::splat(0.1))]), common::front_camera())
}

#[test]
fn references_agree_on_astigmatism() {
    let size = uvec2(80, 60);
    for (depth_m, axis_deg) in [(0.7_f32, 30.0), (3.0, 120.0), (1.0, 90.0)] {
        let (scene, camera) = square(depth_m);
        let refraction = Refraction { sphere_d: 0.75, cylinder_d: -1.5, axis_deg };
        let lens = Lens { eye: Eye { refraction, ..Eye::default() }, ..common::lens(12.0, 1.0) };
        let accumulation = methods::Accumulation { samples: 512, view_dependent: false };
        let mut view = view_of(&scene, camera, size);
        let raster = picture(&accumulation, &mut view, &lens);
        let rays = traced(&scene, camera, size, &lens, 512);
        let db = psnr_db(&raster, &rays);
        assert!(db > 40.0, "{depth_m} m, axis {axis_deg}: {db} dB");
        let round = Lens { eye: Eye::default(), ..lens };
        assert!(psnr_db(&rays, &traced(&scene, camera, size, &round, 512)) < 40.0, "it is seen");
    }
}

/// Second moments of the light in an image about its centroid, px2: xx, xy, yy.
fn moments(image: &ColorImage, background: f32) -> [f64; 3] {
    let pixels = || {
        image.pixels.iter().enumerate().map(|(i, p)| {
            let at = dvec2((i as u32 % image.size.x).into(), (i as u32 / image.size.x).into());
            (at, f64::from(p.y - background))
        })
    };
    let sum: f64 = pixels().map(|(_, w)| w).sum();
    let centre = pixels().map(|(at, w)| at * w).sum::<DVec2>() / sum;
    let of = |f: fn(DVec2) -> f64| pixels().map(|(at, w)| f(at - centre) * w).sum::<f64>() / sum;
    [of(|d| d.x * d.x), of(|d| d.x * d.y), of(|d| d.y * d.y)]
}

#[test]
fn the_ellipse_has_the_axes_of_the_prescription() {
    let size = uvec2(96, 96);
    let (depth_m, side) = (2.0_f32, 0.02_f32);
    let meshes = vec![common::quad(depth_m, vec2(-side, -side), vec2(side, side), 0)];
    let scene = common::scene(meshes, vec![common::unlit(Vec3::splat(100.0))]);
    let camera = common::front_camera();
    let blur = |eye: Eye| {
        let lens = Lens { eye, aperture: Aperture::Disc, ..common::lens(14.0, 1.0) };
        let accumulation = methods::Accumulation { samples: 1024, view_dependent: false };
        let mut view = view_of(&scene, camera, size);
        (moments(&picture(&accumulation, &mut view, &lens), 0.0), lens)
    };
    let (round, _) = blur(Eye::default());
    for axis_deg in [0.0, 40.0, 90.0] {
        let refraction = Refraction { sphere_d: 0.5, cylinder_d: -1.0, axis_deg };
        let (found, lens) = blur(Eye { refraction, ..Eye::default() });
        // The offset of a lens point v is (c + A) v / 2; over the disc v has variance 1/4 on
        // each axis. The square's own moments are in both.
        let c = lens.coc_diameter_px(f64::from(depth_m));
        let m = lens.astigmatism_px() + glam::DMat2::from_diagonal(DVec2::splat(c));
        let spread = m * m.transpose() * (0.25 / 4.0);
        let own = round.map(|v| v - c * c / 16.0);
        let wanted = [spread.x_axis.x + own[0], spread.x_axis.y, spread.y_axis.y + own[2]];
        for (found, wanted) in found.iter().zip(wanted) {
            assert!((found - wanted).abs() < 0.04 * (round[0] + round[2]), "axis {axis_deg}: {found} and {wanted}");
        }
    }
}
