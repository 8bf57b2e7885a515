//! Point spread functions against closed forms.

#[path = "../../../tests/common/mod.rs"]
mod common;

use defocus::aperture::Aperture;
use defocus::lens::Lens;
use defocus::methods::{self, Method};
use defocus_study::psf::report::{PsfPage, csv, html, picture, sheet};
use defocus_study::psf::{Psf, Side, bessel_j1, lens_mtf, measure};
use std::ops::ControlFlow;

fn measured(lens: &Lens, methods: &[Box<dyn Method>], cocs_px: &[f64], side: Side) -> Vec<Psf> {
    measure(common::gpu(), lens, methods, (cocs_px, side), &mut |_| ControlFlow::Continue(())).expect("they render")
}

fn accumulation() -> Vec<Box<dyn Method>> {
    vec![Box::new(methods::Accumulation { samples: 1024, view_dependent: false })]
}

#[test]
fn bessel_and_discs_are_those_of_tables() {
    // Abramowitz and Stegun, tables 9.1 and 9.5.
    for (x, j1) in [(0.0, 0.0), (1.0, 0.440_050_585_7), (5.0, -0.327_579_137_6), (10.0, 0.043_472_746_2)] {
        assert!((bessel_j1(x) - j1).abs() < 1e-9, "{x}: {}", bessel_j1(x));
    }
    assert!(bessel_j1(3.831_705_97).abs() < 1e-8 && bessel_j1(40.0).is_finite());
    // The first zero of a disc lies at 1.22 / C.
    let at = |f| lens_mtf(&Aperture::Disc, 10.0, f);
    assert!((at(0.0) - 1.0).abs() < 1e-12 && at(0.121_967) < 1e-5 && at(0.16) > 0.1);
    // Lens points agree with both closed forms and with each other.
    let round = Aperture::Polygon { blades: 6, rotation_deg: 0.0, roundness: 1.0 };
    for f in [0.02, 0.05, 0.1, 0.2] {
        assert!((lens_mtf(&round, 10.0, f) - at(f)).abs() < 2e-3, "{f}");
    }
    let sigma_per_coc = 0.25;
    let gaussian = lens_mtf(&Aperture::Gaussian { sigma_per_coc }, 8.0, 0.1);
    assert!((gaussian - (-2.0 * (std::f64::consts::PI * 2.0 * 0.1).powi(2)).exp()).abs() < 1e-12);
}

#[test]
fn the_reference_has_the_lens_own_function_to_a_hundredth() {
    for side in [Side::Front, Side::Behind] {
        for psf in measured(&Lens::PINHOLE, &accumulation(), &[4.0, 8.0, 16.0], side) {
            let coc_px = psf.coc_px;
            assert!(psf.mtf_error < 0.01, "{coc_px} px, {side:?}: MTF off by {}", psf.mtf_error);
            assert!((psf.energy - 1.0).abs() < 0.005, "{coc_px} px: energy {}", psf.energy);
            assert!((psf.sigma_px / psf.lens_sigma_px - 1.0).abs() < 0.01, "{coc_px} px: {}", psf.sigma_px);
            assert!(psf.centroid_px.iter().all(|c| c.abs() < 0.02 * coc_px), "{:?}", psf.centroid_px);
            // A pixel at the rim has a light of whole lens points: the wider the disc, the fewer.
            assert!(psf.symmetry > 0.85, "{coc_px} px: symmetry {}", psf.symmetry);
        }
    }
}

#[test]
fn other_apertures_have_their_own() {
    for aperture in [Aperture::Gaussian { sigma_per_coc: 0.25 }, Aperture::polygon(5)] {
        let lens = Lens { aperture: aperture.clone(), ..Lens::PINHOLE };
        for psf in measured(&lens, &accumulation(), &[10.0], Side::Behind) {
            // So many lens points know a disc better than the tails of a Gaussian.
            assert!(psf.mtf_error < 0.02, "{aperture}: MTF off by {}", psf.mtf_error);
        }
    }
}

#[test]
fn every_method_has_a_function_as_wide_as_it_promises() {
    let methods: Vec<Box<dyn Method>> = methods::all().into_iter().filter(|m| m.about().id != "accumulation").collect();
    let found = measured(&Lens::PINHOLE, &methods, &[8.0], Side::Behind);
    assert_eq!(found.len(), methods.len());
    for psf in &found {
        assert!(psf.mtf.iter().all(|m| m.is_finite()) && psf.energy.is_finite(), "{}", psf.method);
        assert!((psf.mtf[0] - 1.0).abs() < 1e-9 && psf.mtf.len() == psf.frequencies.len());
        if psf.method == "pinhole" {
            assert!(psf.sigma_px < 0.05 && (psf.energy - 1.0).abs() < 1e-3 && psf.symmetry > 0.999);
        }
    }
    let lines = String::from_utf8(csv(&found).expect("CSV")).expect("text");
    assert_eq!(lines.lines().count(), found.len() + 1);
    let sheet = sheet(&found);
    assert_eq!(picture(&found).size, sheet.size);
    let light: f32 = sheet.pixels.iter().map(|p| p.y).sum();
    assert!((light - found.len() as f32).abs() < 0.05, "each has the light 1: {light}");
    let page = PsfPage { found: &found, adapter: "an adapter", aperture: &Aperture::Disc, command: "defocus psf" };
    let page = html(&page).expect("a page");
    assert!(page.contains("<svg") && page.contains("mipmap") && page.contains("C = 8 px"));
}
