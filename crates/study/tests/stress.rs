//! The stress study: its checks find what they are for, and the methods pass them.

#[path = "../../../tests/common/mod.rs"]
mod common;

use common::gpu;
use defocus::aperture::Aperture;
use defocus::gpu::{Frame, Texture, download, upload};
use defocus::image::{ColorImage, Image};
use defocus::lens::Lens;
use defocus::methods::{self, About, Apertures, Method, MethodError, Param};
use defocus::view::View;
use defocus_study::Step;
use defocus_study::stress::precision::{ACCEPTABLE_LOSS_DB, measure};
use defocus_study::stress::soak::soak;
use defocus_study::stress::{
    CHECKS, COLORS, Combination, DEPTHS, Failure, ImageCase, KNOWN_LIMITS, LENSES, Outcome, SCENES, SIZES, Specimen,
    examine, image_cases, prepared, try_all, try_witnesses,
};
use glam::{UVec2, Vec3, uvec2};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use std::collections::HashSet;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU32, Ordering};

/// Averages nothing and is wrong in the way of its name.
struct Broken {
    id: &'static str,
    spoil: fn(&mut ColorImage, &Lens),
}

/// The pixel that is spoiled.
const BAD: UVec2 = uvec2(3, 2);

impl Method for Broken {
    fn about(&self) -> About {
        About {
            id: self.id,
            title: "Broken",
            paper: "",
            summary: "",
            limits: "",
            apertures: Apertures::Any,
            astigmatism: false,
            needs_scene: false,
            conserves_energy: true,
            averages: true,
            samples_lens: false,
        }
    }

    fn params(&mut self) -> Vec<Param<'_>> {
        Vec::new()
    }

    fn record(&self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Result<Texture, MethodError> {
        let color = view.pinhole(frame).color;
        frame.flush();
        let mut image = download(frame.gpu(), &color);
        (self.spoil)(&mut image, lens);
        Ok(upload(frame.gpu(), "spoiled", &image))
    }

    fn boxed(&self) -> Box<dyn Method> {
        Box::new(Self { id: self.id, spoil: self.spoil })
    }
}

fn at(image: &mut ColorImage) -> &mut Vec3 {
    let index = (BAD.y * image.size.x + BAD.x) as usize;
    &mut image.pixels[index]
}

fn specimen(depth: &str, color: &str) -> Specimen {
    let case = Combination::named("moderate blur", depth, color, uvec2(24, 16)).case();
    Specimen::of_image(gpu(), &case).unwrap()
}

fn failures(spoil: fn(&mut ColorImage, &Lens), specimen: &mut Specimen) -> Vec<Failure> {
    examine(gpu(), &Broken { id: "broken", spoil }, specimen).1
}

fn expect_failure(check: &str, at: Option<UVec2>, failures: &[Failure]) {
    let found = failures.iter().find(|f| f.check == check);
    let failure = found.unwrap_or_else(|| panic!("{check} does not see it: {failures:?}"));
    assert_eq!(failure.bad.at, at, "{failure}");
    assert_eq!(failure.known, None);
}

#[test]
fn a_method_that_does_nothing_wrong_passes() {
    for (depth, color) in [("all behind", "detail"), ("ramp through the focus", "one colour")] {
        let found = failures(|_, _| {}, &mut specimen(depth, color));
        assert!(found.is_empty(), "{found:?}");
    }
}

#[test]
fn every_check_names_the_first_bad_pixel() {
    let detail = || specimen("all behind", "detail");
    let nan = failures(|image, _| *at(image) = Vec3::splat(f32::NAN), &mut detail());
    expect_failure("finite", Some(BAD), &nan);
    let over = failures(|image, _| *at(image) = Vec3::splat(1.1), &mut detail());
    expect_failure("range", Some(BAD), &over);
    // The other one is seen first, from the left.
    expect_failure("mirror", Some(BAD), &over);
    let shade = failures(|image, _| at(image).y += 0.01, &mut specimen("all behind", "one colour"));
    expect_failure("constancy", Some(BAD), &shade);
    let dark = failures(|image, _| *at(image) = Vec3::splat(-1e-3), &mut specimen("all behind", "black"));
    expect_failure("sign", Some(BAD), &dark);
    let point = Combination::named("slight blur", "all behind", "a bright point", uvec2(48, 40)).case();
    let mut point = Specimen::of_image(gpu(), &point).unwrap();
    let light = failures(|image, _| *at(image) = Vec3::splat(1.0), &mut point);
    expect_failure("energy", None, &light);
    let popping = failures(
        |image, lens| {
            if lens.focus_distance_m > 2.0 {
                *at(image) = Vec3::ZERO;
            }
        },
        &mut detail(),
    );
    expect_failure("continuity", Some(BAD), &popping);
    static RUNS: AtomicU32 = AtomicU32::new(0);
    let random = failures(|image, _| at(image).x = 0.01 * RUNS.fetch_add(1, Ordering::Relaxed) as f32, &mut detail());
    expect_failure("repetition", Some(BAD), &random);
}

#[test]
fn a_scene_that_depends_on_its_place_is_seen() {
    let far = SCENES.iter().find(|s| s.name == "1000 km from the origin").unwrap();
    let mut specimen = far.specimen(gpu()).unwrap();
    // As if the camera's position had lost its last digits.
    let camera = specimen.view.camera().copied().unwrap();
    let position = camera.position.as_vec3().as_dvec3() + glam::DVec3::splat(0.05);
    specimen.view.set_camera(defocus::camera::Camera { position, ..camera });
    let method = methods::by_id("pinhole").unwrap();
    let (_, found) = examine(gpu(), &*method, &mut specimen);
    assert!(found.iter().any(|f| f.check == "invariance"), "{found:?}");
}

#[test]
fn names_are_unique_and_lenses_form_images() {
    fn unique<'a>(names: impl Iterator<Item = &'a str>) {
        let mut seen = HashSet::new();
        names.for_each(|name| assert!(seen.insert(name), "'{name}' twice"));
    }
    unique(LENSES.iter().map(|l| l.name));
    unique(DEPTHS.iter().map(|d| d.name));
    unique(COLORS.iter().map(|c| c.name));
    unique(SCENES.iter().map(|s| s.name));
    unique(CHECKS.iter().map(|c| c.name));
    for lens in LENSES {
        (lens.make)().check().unwrap_or_else(|e| panic!("{}: {e}", lens.name));
    }
}

#[test]
fn a_quick_run_has_five_thousand_cases() {
    let image_methods = methods::all().iter().filter(|m| !m.about().needs_scene).count();
    let cases = image_cases(true, 1).len() * image_methods + SCENES.len() * methods::all().len();
    assert!(cases >= 5000, "{cases}");
    // Pairs: every lens with every depth, every colour at every size.
    assert!(image_cases(true, 1).len() >= LENSES.len() * DEPTHS.len() + COLORS.len() * SIZES.len());
}

fn judged() -> Vec<Box<dyn Method>> {
    prepared(&methods::all())
}

fn assert_good(outcome: &Outcome) {
    let unexpected: Vec<_> = outcome.unexpected().map(Failure::to_string).collect();
    assert!(unexpected.is_empty(), "{} failures:\n{}", unexpected.len(), unexpected.join("\n"));
    assert!(outcome.total().checks > 4 * outcome.total().cases);
}

/// Every so many cases of a quick run are part of the tests.
const TESTED_ONE_IN: usize = 53;

#[test]
fn all_methods_pass_on_images() {
    let methods = judged();
    let mut outcome = Outcome::default();
    for case in image_cases(true, 1).iter().step_by(TESTED_ONE_IN) {
        try_all(gpu(), &methods, &mut Specimen::of_image(gpu(), &case()).unwrap(), &mut outcome);
    }
    assert_good(&outcome);
}

#[test]
fn all_methods_pass_on_scenes() {
    let methods = judged();
    let mut outcome = Outcome::default();
    for scene in SCENES {
        try_all(gpu(), &methods, &mut scene.specimen(gpu()).unwrap(), &mut outcome);
    }
    assert_good(&outcome);
}

#[test]
fn known_limits_still_are() {
    let methods = judged();
    let mut outcome = Outcome::default();
    for limit in KNOWN_LIMITS {
        try_witnesses(gpu(), &methods, limit, &mut outcome).unwrap();
    }
    assert!(outcome.unexpected_passes.is_empty(), "{}", outcome.unexpected_passes.join("\n"));
}

#[test]
fn f16_intermediates_cost_no_tenth_of_a_decibel() {
    let rows = measure(gpu(), &methods::all(), true, &mut |_: Step<'_>| ControlFlow::Continue(())).unwrap();
    assert_eq!(rows.len(), methods::all().len());
    for row in &rows {
        eprintln!("{row:?}");
        assert!(row.loss_db() < ACCEPTABLE_LOSS_DB, "{row:?}");
    }
    // Of a method that stores in f16 at all, not a bit of difference would mean that the
    // switch does nothing.
    assert!(rows.iter().any(|row| row.greatest_difference > 0.0));
}

#[test]
fn memory_stays_bounded_over_many_frames() {
    let methods = judged();
    let soak = soak(gpu(), &methods, 120, &mut |_: Step<'_>| ControlFlow::Continue(())).unwrap();
    assert!(soak.pool_bytes <= soak.pool_warm_bytes, "{soak:?}");
}

/// The light of each pixel is brought to others by the share of the lens that its square covers:
/// however small or wide the blur and whatever the lens, the shares add up to 1.
#[test]
fn an_image_of_one_bright_color_keeps_it_through_any_lens() {
    let apertures = [
        Aperture::Disc,
        Aperture::Polygon { blades: 5, rotation_deg: 10.0, roundness: 0.3 },
        Aperture::Gaussian { sigma_per_coc: 0.25 },
        Aperture::Gaussian { sigma_per_coc: 1.9 },
    ];
    let methods = vec![methods::by_id("adaptive").unwrap()];
    let mut outcome = Outcome::default();
    for aperture in apertures {
        for (coc_px, size) in [
            (0.3, uvec2(1, 1)),
            (1.0, uvec2(1, 1)),
            (2.5, uvec2(3, 2)),
            (7.0, uvec2(19, 9)),
            (40.0, uvec2(5, 8)),
            (300.0, uvec2(31, 7)),
        ] {
            let unit =
                Lens { aperture_diameter_mm: 1.0, focus_distance_m: 1.0, aperture: aperture.clone(), ..Lens::PINHOLE };
            let aperture_diameter_mm = coc_px / unit.coc_diameter_px(1e3).abs();
            let case = ImageCase {
                name: format!("{aperture:?}, {coc_px} px, {size}"),
                color: Image::from_fn(size, |_, _| Vec3::new(1.0, 0.0, 3e4)),
                depth_m: Image::from_fn(size, |_, _| 1e3),
                lens: Lens { aperture_diameter_mm, ..unit },
            };
            try_all(gpu(), &methods, &mut Specimen::of_image(gpu(), &case).unwrap(), &mut outcome);
        }
    }
    assert_good(&outcome);
}

/// A lens and an image from few numbers, so that a failure shrinks to something small.
fn random_case() -> impl Strategy<Value = ImageCase> {
    let aperture = prop_oneof![
        Just(Aperture::Disc),
        (3_u32..=16, 0.0..=1.0).prop_map(|(blades, roundness)| Aperture::Polygon {
            blades,
            rotation_deg: 0.0,
            roundness
        }),
        (0.01..2.0).prop_map(|sigma_per_coc| Aperture::Gaussian { sigma_per_coc }),
    ];
    let lens = (aperture, -3.0..5.0, 0.0..6.0, 1.0..200.0).prop_map(|(aperture, log_k, log_focus, focal_mm)| {
        let unit = Lens {
            aperture_diameter_mm: 1.0,
            focal_length_mm: focal_mm,
            focus_distance_m: focal_mm * 1e-3 * (1.0 + 10f64.powf(log_focus - 3.0)),
            aperture,
            ..Lens::PINHOLE
        };
        Lens { aperture_diameter_mm: 10f64.powf(log_k) / unit.k_px(), ..unit }
    });
    let pixels = prop::collection::vec((0.0_f32..1.0, 0.0_f32..1.0, -4.0_f32..4.0), 1..200);
    (lens, pixels, 1_u32..16).prop_map(|(lens, pixels, width)| {
        let size = uvec2(width.min(pixels.len() as u32), (pixels.len() as u32 / width).max(1));
        let at = |x: u32, y: u32| pixels[(y * size.x + x) as usize];
        let focus_m = lens.focus_distance_m as f32;
        ImageCase {
            name: "proptest".into(),
            // From black over mid-greys to the end of f16.
            color: Image::from_fn(size, |x, y| Vec3::new(at(x, y).0, at(x, y).1, at(x, y).0.powi(20) * 65504.0)),
            depth_m: Image::from_fn(size, |x, y| focus_m * 10f32.powf(at(x, y).2)),
            lens,
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, max_shrink_iters: 200, failure_persistence: None, rng_seed: RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn random_lenses_and_images_pass(case in random_case()) {
        let methods = judged();
        let mut outcome = Outcome::default();
        try_all(gpu(), &methods, &mut Specimen::of_image(gpu(), &case).unwrap(), &mut outcome);
        let first = outcome.unexpected().next();
        prop_assert!(first.is_none(), "{}", first.unwrap());
    }
}
