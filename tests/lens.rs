//! The lens against worked numbers, closed forms, and the projection that shares it.

use defocus::aperture::{Aperture, ApertureError};
use defocus::camera::Projection;
use defocus::lens::{Lens, LensError, MM_PER_M};
use defocus::presets::{preset, presets};
use glam::{DVec2, DVec3, UVec2, Vec4, dvec2, uvec2};
use proptest::prelude::*;

/// Lee, Kim and Choi (TVCG 2009), section 8: an adult's eye before a projection screen.
fn eye() -> Lens {
    Lens {
        aperture_diameter_mm: 4.0,
        focal_length_mm: 17.0,
        image_distance_mm: 24.0,
        screen_distance_mm: 3000.0,
        density_px_per_mm: 0.32,
        focus_distance_m: 3.0,
        aperture: Aperture::Disc,
        eye: Default::default(),
    }
}

fn close(found: f64, expected: f64, relative: f64) {
    assert!((found - expected).abs() <= relative * expected.abs().max(1e-300), "{found}, not {expected}");
}

/// Equations (3) and (4) of the paper with the sign kept, straight from its symbols.
fn direct_coc_px(lens: &Lens, d_m: f64) -> f64 {
    let (df, d) = (lens.focus_distance_m * MM_PER_M, d_m * MM_PER_M);
    let on_retina_mm = lens.aperture_diameter_mm * lens.focal_length_mm * (d - df) / (d * (df - lens.focal_length_mm));
    lens.density_px_per_mm * lens.screen_distance_mm / lens.image_distance_mm * on_retina_mm
}

fn any_lens() -> impl Strategy<Value = Lens> {
    let ranges = (0.1_f64..50.0, 5.0_f64..200.0, 5.0_f64..300.0, 100.0_f64..5000.0, 0.05_f64..40.0, 1.1_f64..2000.0);
    ranges.prop_map(|(e, f, dr, ds, dpi, focus_per_f)| Lens {
        aperture_diameter_mm: e,
        focal_length_mm: f,
        image_distance_mm: dr,
        screen_distance_mm: ds,
        density_px_per_mm: dpi,
        focus_distance_m: f * focus_per_f / MM_PER_M,
        aperture: Aperture::Disc,
        eye: Default::default(),
    })
}

#[test]
fn the_papers_worked_example() {
    // K = 0.32 * 125 * 4 * 17 / 2983; c(300 mm) = -9 K. Five digits are given.
    close(eye().k_px(), 0.91183, 1e-5);
    close(eye().coc_diameter_px(0.3), -8.2065, 1e-5);
    assert_eq!(eye().coc_diameter_px(3.0), 0.0);
    close(eye().coc_diameter_px(f64::INFINITY), eye().k_px(), 1e-15);
}

#[test]
fn focus_at_infinity_is_the_limit() {
    let far = |focus_distance_m| Lens { focus_distance_m, ..eye() };
    let infinite = far(f64::INFINITY);
    infinite.check().unwrap();
    assert_eq!(infinite.k_px(), 0.0);
    assert_eq!(infinite.coc_diameter_px(f64::INFINITY), 0.0);
    // c -> -DPI ds/dr E F / d: what is neglected is of the order of F/df and d/df.
    for d_m in [0.1, 1.0, 10.0] {
        close(infinite.coc_diameter_px(d_m), -0.32 * 125.0 * 4.0 * 17.0 / (d_m * MM_PER_M), 1e-12);
        close(far(1e9).coc_diameter_px(d_m), infinite.coc_diameter_px(d_m), 2e-8);
    }
    // The multi-view aperture stays finite too: K df / focal = 2.72 px m / 500 px.
    close(infinite.aperture_diameter_m(500.0), 0.32 * 125.0 * 4.0 * 17.0 / MM_PER_M / 500.0, 1e-12);
}

#[test]
fn hyperfocal_distance_just_holds_infinity() {
    let hyperfocal_m = eye().hyperfocal_m(0.5);
    let lens = Lens { focus_distance_m: hyperfocal_m, ..eye() };
    close(lens.k_px(), 0.5, 1e-12);
    // There the far limit is infinite; the near one is half the distance, up to rounding.
    let (near_m, far_m) = Lens { focus_distance_m: hyperfocal_m * (1.0 + 1e-12), ..eye() }.depth_of_field_m(0.5);
    close(near_m, 0.5 * hyperfocal_m, 1e-9);
    assert_eq!(far_m, f64::INFINITY);
    assert!(Lens { focus_distance_m: 0.99 * hyperfocal_m, ..eye() }.depth_of_field_m(0.5).1.is_finite());
}

#[test]
fn a_pinhole_has_everything_in_focus() {
    let pinhole = Lens { aperture_diameter_mm: 0.0, ..eye() };
    pinhole.check().unwrap();
    assert_eq!(pinhole.coc_diameter_px(0.01), 0.0);
    assert_eq!(pinhole.depth_of_field_m(1.0), (0.0, f64::INFINITY));
    assert_eq!(pinhole.f_number(), f64::INFINITY);
}

#[test]
fn impossible_lenses_are_named() {
    let check = |change: &dyn Fn(&mut Lens)| {
        let mut lens = eye();
        change(&mut lens);
        lens.check().unwrap_err()
    };
    let symbol_of = |error: LensError| match error {
        LensError::NotFinite { symbol, .. } | LensError::OutOfBounds { symbol, .. } => symbol,
        LensError::FocusInsideFocalLength { .. } => "df <= F",
        LensError::Aperture(_) => "aperture",
        LensError::Eye(_) => "eye",
        other => panic!("{other}: which symbol it names is not said here"),
    };
    type Set = fn(&mut Lens, f64);
    let setters: [(&str, Set); 5] = [
        ("E", |lens, value| lens.aperture_diameter_mm = value),
        ("F", |lens, value| lens.focal_length_mm = value),
        ("dr", |lens, value| lens.image_distance_mm = value),
        ("ds", |lens, value| lens.screen_distance_mm = value),
        ("DPI", |lens, value| lens.density_px_per_mm = value),
    ];
    for (symbol, set) in setters {
        for value in [f64::NAN, f64::INFINITY, -1.0] {
            let error = check(&|lens| set(lens, value));
            assert!(error.to_string().starts_with(symbol), "{error}");
            assert_eq!(symbol_of(error), symbol, "{value}");
        }
        if symbol != "E" {
            assert_eq!(symbol_of(check(&|lens| set(lens, 0.0))), symbol);
        }
    }
    assert_eq!(symbol_of(check(&|lens| lens.focus_distance_m = f64::NAN)), "df");
    for focus_distance_m in [0.017, 0.01, 0.0, -3.0] {
        let error = check(&|lens| lens.focus_distance_m = focus_distance_m);
        assert!(error.to_string().contains("does not exceed the focal length F = 17 mm"), "{error}");
    }
    // Finite values with an infinite product.
    let error = check(&|lens| (lens.aperture_diameter_mm, lens.density_px_per_mm) = (1e200, 1e200));
    assert_eq!(symbol_of(error), "K");
    let error = check(&|lens| lens.aperture = Aperture::polygon(2));
    assert!(matches!(error, LensError::Aperture(ApertureError::OutOfRange { .. })), "{error}");
}

#[test]
fn mean_coc_scales_the_aperture() {
    let depths = || (1..=100).map(|i| 0.1 * i as f32).chain([f32::INFINITY]);
    for mean_px in [0.0, 0.5, 16.0, 128.0] {
        let lens = eye().with_mean_coc(mean_px, depths()).unwrap();
        let statistics = lens.coc_statistics(depths()).unwrap();
        close(statistics.mean_px, mean_px, 1e-12);
        assert!(statistics.min_signed_px <= statistics.max_signed_px);
    }
    // Everything in focus: no aperture blurs it. 3.0 is exact in f32.
    assert_eq!(eye().with_mean_coc(8.0, [3.0, 3.0]), None);
    assert_eq!(eye().with_mean_coc(8.0, []), None);
}

#[test]
fn coc_statistics_of_known_depths() {
    // |c| / K = |1 - 3/d| at 101 depths with 3/d = 1 + i/100: 0, 0.01, ... 1.
    let depths = (0..=100).map(|i| (3.0 / (1.0 + f64::from(i) / 100.0)) as f32);
    let statistics = eye().coc_statistics(depths).unwrap();
    let k = eye().k_px();
    // The depths were rounded to f32: 6e-8 of 3/d, which is up to 2.
    for (found, expected) in
        [(statistics.mean_px, 0.5 * k), (statistics.p95_px, 0.95 * k), (statistics.min_signed_px, -k)]
    {
        close(found, expected, 1e-6);
    }
    assert_eq!(statistics.max_signed_px, 0.0);
}

/// Where `clip_from_view` puts a view-space point, px of the outer frame from its top left.
fn pixel_of(projection: &Projection, lens: &Lens, v: DVec2, point: DVec3) -> (DVec2, f64) {
    let clip = projection.clip_from_view(lens, v).as_dmat4() * point.extend(1.0);
    let outer = projection.outer_size().as_dvec2();
    (dvec2(0.5 + 0.5 * clip.x / clip.w, 0.5 - 0.5 * clip.y / clip.w) * outer, clip.z / clip.w)
}

#[test]
fn the_sheared_projection_moves_points_by_the_coc() {
    let lens = Lens { aperture_diameter_mm: 40.0, ..eye() };
    let axis_px = dvec2(37.0, -120.5);
    let projection = Projection { size: uvec2(640, 480), overscan_px: 16, focal_px: 500.0, axis_px, near_m: 0.1 };
    let points = lens.aperture.lens_points(32);
    for v in points {
        for d_m in [0.5, 1.0, 2.9, 3.0, 5.0, 40.0, 1000.0] {
            for direction in [dvec2(0.0, 0.0), dvec2(0.4, -0.3)] {
                let point = DVec3::new(direction.x, direction.y, -1.0) * d_m;
                let (pinhole, depth) = pixel_of(&projection, &lens, DVec2::ZERO, point);
                let (moved, moved_depth) = pixel_of(&projection, &lens, v, point);
                let expected = v * lens.coc_diameter_px(d_m) / 2.0;
                // The matrix is f32: 6e-8 of up to 700 px.
                assert!((moved - pinhole - expected).length() < 1e-4, "d = {d_m}, v = {v}: {}", moved - pinhole);
                close(depth, 0.1 / d_m, 1e-6);
                assert_eq!(depth, moved_depth);
            }
        }
    }
}

#[test]
fn the_sheared_projection_has_its_limits() {
    let projection =
        Projection { size: uvec2(64, 64), overscan_px: 0, focal_px: 60.0, axis_px: DVec2::ZERO, near_m: 0.1 };
    // At infinity (w = 0 in view space) a point still moves by v K / 2.
    let v = dvec2(0.6, -0.8);
    let lens = Lens { aperture_diameter_mm: 40.0, ..eye() };
    let at_infinity = |v| {
        let clip = projection.clip_from_view(&lens, v) * Vec4::new(0.0, 0.0, -1.0, 0.0);
        dvec2(f64::from(clip.x / clip.w), -f64::from(clip.y / clip.w)) * 32.0
    };
    assert!((at_infinity(v) - at_infinity(DVec2::ZERO) - v * lens.k_px() / 2.0).length() < 1e-4);
    // Focused at infinity there is no shear, and what is near moves the more.
    let lens = Lens { focus_distance_m: f64::INFINITY, ..lens };
    let shift =
        pixel_of(&projection, &lens, v, DVec3::NEG_Z).0 - pixel_of(&projection, &lens, DVec2::ZERO, DVec3::NEG_Z).0;
    assert!((shift - v * lens.coc_diameter_px(1.0) / 2.0).length() < 1e-4, "{shift}");
}

proptest! {
    #[test]
    fn affine_form_is_the_papers(lens in any_lens(), log_d in -3.0_f64..5.0, near_m in 1e-3_f64..1.0) {
        lens.check().unwrap();
        let d_m = 10_f64.powf(log_d);
        let direct = direct_coc_px(&lens, d_m);
        // Near the focus distance c is the difference of two nearly equal numbers: the
        // rounding is relative to their size.
        let scale = lens.k_px() * (1.0 + lens.focus_distance_m / d_m);
        prop_assert!((lens.coc_diameter_px(d_m) - direct).abs() <= 1e-12 * scale);
        prop_assert!((lens.coc().at_stored(near_m / d_m, near_m) - direct).abs() <= 1e-12 * scale);
        prop_assert_eq!(lens.coc().at_stored(0.0, near_m), lens.coc_diameter_px(f64::INFINITY));
        let c = lens.coc_diameter_px(d_m);
        prop_assert_eq!(c < 0.0, d_m < lens.focus_distance_m);
        // depth_at inverts at_depth, as well as K - c can be told.
        if lens.k_px() - c > 1e-6 * lens.k_px() {
            prop_assert!((lens.coc().depth_at(c) / d_m - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn blur_at_the_limits_is_the_acceptable(lens in any_lens(), acceptable_px in 0.01_f64..20.0) {
        let (near_m, far_m) = lens.depth_of_field_m(acceptable_px);
        prop_assert!(near_m < lens.focus_distance_m && lens.focus_distance_m < far_m);
        let scale = acceptable_px + lens.k_px();
        prop_assert!((lens.coc_diameter_px(near_m) + acceptable_px).abs() < 1e-12 * scale);
        if far_m.is_finite() {
            prop_assert!((lens.coc_diameter_px(far_m) - acceptable_px).abs() < 1e-12 * scale);
        } else {
            prop_assert!(lens.k_px() <= acceptable_px);
        }
        // The hyperfocal distance separates the two.
        let beyond = lens.focus_distance_m >= lens.hyperfocal_m(acceptable_px);
        prop_assert!(beyond == far_m.is_infinite() || (lens.k_px() / acceptable_px - 1.0).abs() < 1e-12);
    }

    #[test]
    fn any_projection_keeps_the_focus_plane(lens in any_lens(), vx in -1.0_f64..1.0, vy in -1.0_f64..1.0, x in -0.5_f64..0.5) {
        let projection = Projection { size: UVec2::splat(256), overscan_px: 0, focal_px: 200.0, axis_px: DVec2::ZERO, near_m: 0.01 };
        let point = DVec3::new(x, 0.2, -1.0) * lens.focus_distance_m;
        let v = dvec2(vx, vy);
        let still = pixel_of(&projection, &lens, DVec2::ZERO, point).0;
        let moved = pixel_of(&projection, &lens, v, point).0;
        // f32 rounding of the matrix relative to the aperture's K + K df/df, in px.
        let tolerance = 1e-4 + 4.0 * f64::from(f32::EPSILON) * lens.k_px();
        prop_assert!((moved - still).length() < tolerance, "{} by {v}", moved - still);
    }
}

#[test]
fn saved_lenses_use_the_papers_symbols() {
    let json = serde_json::to_value(eye()).unwrap();
    for (symbol, value) in [("E", 4.0), ("F", 17.0), ("dr", 24.0), ("ds", 3000.0), ("dpi", 0.32), ("focus_m", 3.0)] {
        assert_eq!(json[symbol], value, "{symbol}");
    }
    assert_eq!(serde_json::from_value::<Lens>(json).unwrap(), eye());
}

#[test]
fn presets_are_lenses_with_sources() {
    let all = presets();
    let names: Vec<_> = all.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["projection", "hmd", "hmd-index", "hmd-xr4", "monitor", "monitor-hdr", "camera-50mm"]);
    for preset in &all {
        preset.lens.check().unwrap();
        assert!(!preset.title.is_empty() && !preset.source.is_empty(), "{}", preset.name);
    }
    assert_eq!(preset("projection").unwrap().lens, eye());
    let error = preset("nosuch").unwrap_err().to_string();
    assert_eq!(
        error,
        "there is no lens preset 'nosuch': the presets are projection, hmd, hmd-index, hmd-xr4, monitor, monitor-hdr, camera-50mm"
    );
}

#[test]
fn presets_have_the_numbers_of_their_sources() {
    let lens = |name| preset(name).unwrap().lens;
    // The numbers are given with at least 5 digits.
    let hmd = lens("hmd");
    close(hmd.density_px_per_mm * hmd.screen_distance_mm, 25.0_f64.to_degrees(), 1e-6);
    close(lens("monitor").density_px_per_mm, 3840_f64.hypot(2160.0) / (27.0 * 25.4), 1e-5);
    let camera = lens("camera-50mm");
    close(camera.f_number(), 1.8, 1e-6);
    close(camera.display_fov_x(1024), 2.0 * (18.0_f64 / 50.0).atan(), 1e-6);
    // A thin lens of 50 mm, focused at 2 m, images infinity at f and 2 m at f df / (df - f):
    // similar triangles give the disc on a sensor there, 36 mm of which are 1024 px.
    let sensor_mm = 50.0 * 2000.0 / 1950.0;
    let disc_mm = 50.0 / 1.8 * (sensor_mm - 50.0) / 50.0;
    close(camera.coc_diameter_px(f64::INFINITY), disc_mm * 1024.0 / 36.0, 1e-6);
}

#[test]
fn the_unit_of_lens_points_is_that_of_the_eye() {
    // |v| = 1 is the aperture's radius in scene units: A / 2 = K df / focal / 2.
    let projection =
        Projection { size: uvec2(100, 100), overscan_px: 0, focal_px: 100.0, axis_px: DVec2::ZERO, near_m: 0.1 };
    let eye_m = projection.eye_on_lens_m(&eye(), dvec2(0.0, 1.0));
    close(eye_m.length(), 0.5 * eye().k_px() * 3.0 / 100.0, 1e-3);
    assert!(eye_m.y < 0.0, "y is down on the image and up in view space");
    assert_eq!(eye_m.x, 0.0);
}
