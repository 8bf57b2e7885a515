//! Focus by area, object and eye; the lens in the units of photographers and opticians.

mod common;

use common::{front_camera, lens};
use defocus::camera::Camera;
use defocus::focus::{ACCOMMODATION_SECONDS, Accommodation, area_depth_m, depth_of_m, dioptres, metres, world_point};
use defocus::histogram::Histogram;
use defocus::image::{DepthImage, Image};
use defocus::lens::Lens;
use defocus::presets::{preset, presets};
use glam::{DQuat, DVec2, DVec3, dvec2, uvec2};
use proptest::prelude::*;

fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance * b.abs().max(1.0), "{a} is not {b}");
}

#[test]
fn an_eye_goes_63_percent_of_the_way_in_its_time_constant() {
    let mut eye = Accommodation::at(4.0);
    assert!(!eye.advance(0.5, ACCOMMODATION_SECONDS, ACCOMMODATION_SECONDS));
    // From 0.25 to 2 dioptres.
    close(dioptres(eye.distance_m()), 2.0 - 1.75 * (-1.0_f64).exp(), 1e-12);
    // 10 % to 90 % of the step take ln 9 time constants: the 0.64 s that were measured.
    close(9.0_f64.ln() * ACCOMMODATION_SECONDS, 0.66, 0.01);
}

#[test]
fn an_eye_arrives_and_needs_no_time_without_lag() {
    let mut eye = Accommodation::at(f64::INFINITY);
    let mut steps = 0;
    while !eye.advance(0.25, 0.3, 1.0 / 60.0) {
        steps += 1;
        assert!(steps < 1000, "it never arrives");
    }
    assert_eq!(eye.distance_m(), 0.25, "the target itself, not nearly");
    assert!(eye.advance(f64::INFINITY, 0.0, 0.0));
    assert_eq!(eye.distance_m(), f64::INFINITY);
}

proptest! {
    #[test]
    fn an_eye_does_not_depend_on_the_frame_rate(
        from_m in 0.05_f64..100.0, to_m in 0.05_f64..100.0, time_s in 0.05_f64..1.0, dt_s in 0.001_f64..0.3,
    ) {
        let (mut whole, mut halves) = (Accommodation::at(from_m), Accommodation::at(from_m));
        let arrived = whole.advance(to_m, time_s, dt_s);
        let early = halves.advance(to_m, time_s, 0.5 * dt_s);
        halves.advance(to_m, time_s, 0.5 * dt_s);
        // Unless one of them came within the distance that counts as arrived.
        if !arrived && !early {
            prop_assert!((dioptres(whole.distance_m()) - dioptres(halves.distance_m())).abs() < 1e-9);
        }
        let (low, high) = (from_m.min(to_m), from_m.max(to_m));
        prop_assert!(whole.distance_m() >= low * (1.0 - 1e-12) && whole.distance_m() <= high * (1.0 + 1e-12));
    }
}

#[test]
fn an_area_is_not_decided_by_a_leaf_or_a_border() {
    let mut depth = DepthImage::filled(uvec2(20, 10), 5.0);
    depth.pixels[5 * 20 + 10] = 0.3;
    let middle = dvec2(10.5 / 20.0, 5.5 / 10.0);
    assert_eq!(area_depth_m(&depth, middle, 0), Some(f64::from(0.3_f32)));
    assert_eq!(area_depth_m(&depth, middle, 1), Some(5.0));
    // Half of the area is sky: one of the two depths, nothing between.
    let edge: DepthImage = Image::from_fn(uvec2(20, 10), |x, _| if x < 10 { 2.0 } else { f32::INFINITY });
    assert_eq!(area_depth_m(&edge, dvec2(0.45, 0.5), 3), Some(2.0));
    assert_eq!(area_depth_m(&edge, dvec2(0.7, 0.5), 3), Some(f64::INFINITY));
    for at in [DVec2::ZERO, DVec2::ONE, dvec2(-3.0, 7.0), DVec2::NAN] {
        assert!(area_depth_m(&edge, at, 200).is_some(), "at {at}");
    }
    assert_eq!(area_depth_m(&DepthImage::filled(uvec2(0, 4), 1.0), middle, 2), None);
}

#[test]
fn an_object_keeps_its_depth_while_the_camera_moves() {
    let camera = front_camera();
    let projection = camera.projection(uvec2(320, 240), 8);
    let at = dvec2(0.7, 0.2);
    let anchor = world_point(&camera, &projection, at, 3.0).expect("three metres are a place");
    close(depth_of_m(&camera, anchor).unwrap(), 3.0, 1e-12);
    let nearer = Camera { position: DVec3::new(0.4, 0.0, -1.0), ..camera };
    close(depth_of_m(&nearer, anchor).unwrap(), 2.0, 1e-12);
    let turned = Camera { orientation: DQuat::from_rotation_y(std::f64::consts::PI), ..camera };
    assert_eq!(depth_of_m(&turned, anchor), None, "it lies behind the camera");
    assert_eq!(world_point(&camera, &projection, at, f64::INFINITY), None, "the sky is no object");
}

#[test]
fn the_lens_has_the_units_of_photographers_and_opticians() {
    let camera = preset("camera-50mm").unwrap().lens;
    close(camera.with_f_number(8.0).aperture_diameter_mm, 6.25, 1e-12);
    close(camera.with_f_number(8.0).f_number(), 8.0, 1e-12);
    assert_eq!(camera.with_f_number(f64::INFINITY).aperture_diameter_mm, 0.0);
    let eye = lens(12.0, 2.0);
    for (width, fov_deg) in [(640, 30.0_f64), (1440, 110.0), (3840, 1.0)] {
        let wide = eye.with_display_fov_x(width, fov_deg.to_radians());
        close(wide.display_fov_x(width), fov_deg.to_radians(), 1e-12);
        assert_eq!(wide.screen_distance_mm, eye.screen_distance_mm);
    }
    // K on the image plane is E F / (df - F): equation (3) of TVCG 2009 without the display.
    let on_sensor = camera.on_image_plane_mm(camera.k_px());
    close(on_sensor, 50.0 / 1.8 * 50.0 / (2000.0 - 50.0), 1e-6);
    // A pixel at 60 pixels per degree is one arc minute, which a good eye just resolves.
    let density_px_per_mm = 60.0_f64.to_degrees() / eye.screen_distance_mm;
    let sharp = Lens { density_px_per_mm, ..eye };
    close(sharp.px_per_degree(), 60.0, 1e-12);
    close(sharp.arc_minutes(1.0), 1.0, 1e-6);
    close(metres(dioptres(0.4)), 0.4, 1e-12);
    assert_eq!((metres(0.0), metres(-1.0)), (f64::INFINITY, f64::INFINITY));
}

#[test]
fn a_display_and_a_camera_can_be_made_one() {
    let eye = lens(12.0, 2.0);
    let camera = Camera { aspect: Some(1.5), ..front_camera() };
    for size in [uvec2(640, 480), uvec2(300, 900)] {
        let fov_x = eye.display_fov_x(size.x);
        close(camera.with_fov_x(size, fov_x).projection(size, 16).fov_x(), fov_x, 1e-12);
    }
}

#[test]
fn headsets_are_presets_with_the_density_of_their_sources() {
    let all = presets();
    let headsets: Vec<_> = all.iter().filter(|p| p.headset.is_some()).collect();
    assert!(headsets.len() >= 3);
    for (name, per_degree) in [("hmd", 25.0), ("hmd-index", 15.0), ("hmd-xr4", 51.0)] {
        let headset = headsets.iter().find(|p| p.name == name).expect("it is a headset");
        // Given with 7 digits.
        close(headset.lens.px_per_degree(), per_degree, 1e-6);
    }
}

#[test]
fn a_histogram_counts_everything_once() {
    let values = [-1.0, 0.0, 0.1, 0.49, 0.5, 1.0, 2.0, f64::NAN, f64::INFINITY];
    let histogram = Histogram::of(values, 0.0..=1.0, 2);
    assert_eq!(histogram.counts(), [3, 2]);
    assert_eq!(histogram.outside(), [1, 2]);
    assert_eq!(histogram.total(), 8);
    assert_eq!(histogram.heights(), [1.0, 2.0 / 3.0]);
    let flat = Histogram::of([3.0; 5], 3.0..=3.0, 4);
    assert_eq!(flat.counts().iter().sum::<u64>(), 0, "a range without width has no inside");
    assert_eq!(Histogram::of([1.0], 0.0..=2.0, 0).total(), 0);
}
