//! A state as a command, and what the command line makes of it: the same state.

use super::args::{Cli, Command};
use super::options::{DisplayOptions, EyeOptions, LensOptions};
use clap::Parser;
use defocus::aperture::Aperture;
use defocus::camera::Camera;
use defocus::eye::{Eye, Pupil, Refraction, amplitude_d};
use defocus::lens::Lens;
use defocus::viewing::Screen;
use defocus_app::window::{Document, MethodChoice, command_line, read_state, write_state};
use defocus_study::random::Random;
use glam::{DVec3, uvec2};

/// What the section "Eye and display" sets, and the lens.
fn random_document(random: &mut Random) -> Document {
    let mut is = |share: f64| random.unit() < share;
    let (has_pupil, has_age, is_limited, is_chromatic) = (is(0.5), is(0.5), is(0.3), is(0.4));
    let (has_refraction, has_screen, has_ppd, compares, hdr) = (is(0.6), is(0.5), is(0.4), is(0.5), is(0.3));
    let (both_eyes, by_field) = (is(0.7), is(0.3));
    let mut lens = Lens {
        aperture_diameter_mm: random.between(0.0, 10.0),
        focal_length_mm: random.between(10.0, 60.0),
        image_distance_mm: random.between(10.0, 30.0),
        screen_distance_mm: random.log_between(300.0, 4000.0),
        density_px_per_mm: random.log_between(0.2, 12.0),
        focus_distance_m: random.log_between(0.1, 20.0),
        aperture: [Aperture::Disc, Aperture::polygon(6), Aperture::Gaussian { sigma_per_coc: 0.3 }][random.index(3)]
            .clone(),
        eye: Eye::default(),
    };
    let age_years = has_age.then(|| random.between(8.0, 83.0));
    let pupil = has_pupil.then(|| Pupil {
        luminance_cd_m2: random.log_between(0.01, 10_000.0),
        field_deg: if by_field { random.between(1.0, 180.0) } else { 60.0 },
        both_eyes,
        // As the panel sets it.
        age_years: age_years.unwrap_or(30.0).clamp(20.0, 83.0),
    });
    if let Some(pupil) = pupil {
        lens.aperture_diameter_mm = pupil.diameter_mm();
    }
    if has_refraction {
        lens.eye.refraction = Refraction {
            sphere_d: random.between(-30.0, 30.0),
            cylinder_d: random.between(-10.0, 10.0),
            axis_deg: random.between(0.0, 180.0),
        };
    }
    lens.eye.accommodation_d = age_years.map(amplitude_d).or(is_limited.then(|| random.between(0.0, 20.0)));
    lens.eye.chromatic = is_chromatic
        .then(|| [random.between(600.0, 700.0), random.between(500.0, 560.0), random.between(420.0, 480.0)]);
    let mut screen = Screen::default();
    if has_screen {
        screen.peak_cd_m2 = random.log_between(1.0, 10_000.0);
        screen.black_cd_m2 = random.between(0.0, 0.01) * screen.peak_cd_m2;
        screen.ambient_lux = random.between(0.0, 1000.0);
        screen.hdr = hdr;
    }
    let methods: &[&str] = if compares { &["mipmap", "splat", "accumulation"] } else { &["mipmap"] };
    Document {
        lens,
        pupil,
        age_years,
        screen,
        ppd: has_ppd.then(|| random.between(5.0, 120.0)),
        camera: Some(Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, 1.0, 0.1)),
        ..Document::of_methods(methods.iter().map(|id| MethodChoice::new(id)))
    }
}

fn options(cli: &Cli) -> (&LensOptions, &DisplayOptions) {
    match &cli.command {
        Some(Command::Render(args)) => (&args.lens, &args.display),
        Some(Command::Compare(args)) => (&args.lens, &args.display),
        other => panic!("{other:?}"),
    }
}

/// The pupil that the options say, without those for the lens.
fn pupil_of(options: &EyeOptions, screen: &Screen) -> Option<f64> {
    options.pupil_mm(screen).expect("a pupil that is known")
}

#[test]
fn a_copied_command_has_all_of_the_eye_and_the_display() {
    let mut random = Random::new(22);
    for case in 0..300 {
        let document = random_document(&mut random);
        let line = command_line(&document, uvec2(64, 48));
        let cli = Cli::try_parse_from(shlex::split(&line).expect("whole quotes"))
            .unwrap_or_else(|e| panic!("case {case}: {line}: {e}"));
        let (lens, display) = options(&cli);
        let screen = display.screen(None).expect("a screen");
        let told = format!("case {case}: {line}");
        assert_eq!(screen, document.screen, "{told}");
        assert_eq!(display.ppd, document.ppd, "{told}");
        assert_eq!(lens.eye.overridden(Eye::default(), &screen), document.lens.eye, "{told}");
        let pupil_mm = pupil_of(&lens.eye, &screen);
        assert_eq!(pupil_mm.is_some(), document.pupil.is_some(), "the pupil still follows the light: {told}");
        let wanted = &document.lens;
        let found = [
            (pupil_mm.or(lens.aperture_diameter_mm), wanted.aperture_diameter_mm),
            (lens.focal_length_mm, wanted.focal_length_mm),
            (lens.image_distance_mm, wanted.image_distance_mm),
            (lens.screen_distance_mm, wanted.screen_distance_mm),
            (lens.density_px_per_mm, wanted.density_px_per_mm),
            (lens.focus, wanted.focus_distance_m),
        ];
        assert!(found.iter().all(|(found, wanted)| *found == Some(*wanted)), "{found:?}: {told}");
        assert_eq!(lens.aperture.as_ref(), Some(&wanted.aperture), "{told}");
        if let Some(pupil) = document.pupil {
            assert_eq!(lens.eye.age, Some(pupil.age_years), "{told}");
            assert_eq!((lens.eye.pupil_field, lens.eye.one_eye), (pupil.field_deg, !pupil.both_eyes), "{told}");
        } else if let Some(age) = document.age_years {
            assert_eq!(lens.eye.age, Some(age), "{told}");
        }
    }
}

#[test]
fn a_state_file_has_all_of_the_eye_and_the_display() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("state.ron");
    let mut random = Random::new(2011);
    for case in 0..50 {
        let document = random_document(&mut random);
        write_state(&file, &document).expect("it is written");
        let read = read_state(&file).expect("it is read");
        assert_eq!(read, document.repaired(), "case {case}");
    }
}
