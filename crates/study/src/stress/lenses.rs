//! Lenses at the edges of what [`Lens::check`] lets through.

use crate::random::Random;
use defocus::aperture::{Aperture, ApertureImage};
use defocus::lens::Lens;
use glam::UVec2;
use std::sync::Arc;

/// A lens with what it is a case of.
#[derive(Clone, Copy)]
pub struct LensCondition {
    /// In words.
    pub name: &'static str,
    /// Makes it.
    pub make: fn() -> Lens,
}

/// The eye before the projection screen of Lee, Kim and Choi (TVCG 2009), section 8,
/// focused at 2 m.
const EYE: Lens = Lens { aperture_diameter_mm: 4.0, focus_distance_m: 2.0, ..Lens::PINHOLE };

/// A disc lens focused at 2 m that blurs infinity by `k_px`.
pub fn blurring(k_px: f64) -> Lens {
    let unit = Lens { aperture_diameter_mm: 1.0, ..EYE };
    Lens { aperture_diameter_mm: k_px / unit.k_px(), ..unit }
}

fn shaped(k_px: f64, aperture: Aperture) -> Lens {
    Lens { aperture, ..blurring(k_px) }
}

/// A crescent: neither round, nor symmetric, nor around its middle.
fn crescent() -> Aperture {
    let size = UVec2::new(16, 12);
    let inside = |i: u32| {
        let (x, y) = (f64::from(i % size.x) - 7.5, f64::from(i / size.x) - 5.5);
        let (outer, cut) = (x * x + y * y < 33.0, (x - 3.0).powi(2) + (y + 1.0).powi(2) < 20.0);
        f32::from(u8::from(outer && !cut))
    };
    let pixels = (0..size.x * size.y).map(inside).collect();
    let image = ApertureImage::new("crescent", size, pixels).expect("the crescent has light");
    Aperture::Image(Arc::new(image))
}

/// The lenses.
pub const LENSES: &[LensCondition] = &[
    LensCondition { name: "moderate blur", make: || blurring(8.0) },
    LensCondition { name: "slight blur", make: || blurring(0.3) },
    LensCondition { name: "strong blur", make: || blurring(24.0) },
    LensCondition { name: "CoC wider than the image", make: || blurring(400.0) },
    LensCondition { name: "CoC of a million px", make: || blurring(1e6) },
    LensCondition { name: "E = 0", make: || Lens { aperture_diameter_mm: 0.0, ..EYE } },
    LensCondition { name: "E = 1e-30 mm", make: || Lens { aperture_diameter_mm: 1e-30, ..EYE } },
    LensCondition { name: "E = 1 km", make: || Lens { aperture_diameter_mm: 1e6, ..EYE } },
    LensCondition { name: "E = 1e30 mm", make: || Lens { aperture_diameter_mm: 1e30, ..EYE } },
    LensCondition { name: "df a millionth above F", make: || Lens { focus_distance_m: 0.017 * (1.0 + 1e-6), ..EYE } },
    LensCondition { name: "df 1 % above F", make: || Lens { focus_distance_m: 0.017 * 1.01, ..EYE } },
    LensCondition { name: "df = 1e9 m", make: || Lens { focus_distance_m: 1e9, ..EYE } },
    LensCondition { name: "df infinite", make: || Lens { focus_distance_m: f64::INFINITY, ..EYE } },
    LensCondition {
        name: "df infinite, E = 400 mm",
        make: || Lens { aperture_diameter_mm: 400.0, focus_distance_m: f64::INFINITY, ..EYE },
    },
    LensCondition { name: "DPI = 1e-6 px/mm", make: || Lens { density_px_per_mm: 1e-6, ..EYE } },
    LensCondition { name: "DPI = 1e6 px/mm", make: || Lens { density_px_per_mm: 1e6, ..EYE } },
    LensCondition { name: "ds = 0.01 mm", make: || Lens { screen_distance_mm: 0.01, ..EYE } },
    LensCondition { name: "ds = 1000 km", make: || Lens { screen_distance_mm: 1e9, ..EYE } },
    LensCondition { name: "triangle", make: || shaped(10.0, Aperture::polygon(3)) },
    LensCondition {
        name: "rounded pentagon",
        make: || shaped(10.0, Aperture::Polygon { blades: 5, rotation_deg: 17.0, roundness: 0.5 }),
    },
    LensCondition { name: "Gaussian", make: || shaped(6.0, Aperture::Gaussian { sigma_per_coc: 0.5 }) },
    LensCondition { name: "widest Gaussian", make: || shaped(6.0, Aperture::Gaussian { sigma_per_coc: 2.0 }) },
    LensCondition { name: "narrow Gaussian", make: || shaped(30.0, Aperture::Gaussian { sigma_per_coc: 0.01 }) },
    LensCondition { name: "crescent", make: || shaped(10.0, crescent()) },
];

/// A lens of random values, anywhere that [`Lens::check`] lets through and the CoC is
/// below 1e9 px.
pub fn random_lens(random: &mut Random) -> Lens {
    let aperture = match random.index(5) {
        0 | 1 => Aperture::Disc,
        2 => Aperture::Polygon {
            blades: 3 + random.index(14) as u32,
            rotation_deg: random.between(-180.0, 180.0),
            roundness: random.unit(),
        },
        3 => Aperture::Gaussian { sigma_per_coc: random.log_between(0.01, 2.0) },
        _ => crescent(),
    };
    let focal_length_mm = random.log_between(1.0, 1000.0);
    let lens = Lens {
        aperture_diameter_mm: 1.0,
        focal_length_mm,
        image_distance_mm: random.log_between(1.0, 1000.0),
        screen_distance_mm: random.log_between(1.0, 1e5),
        density_px_per_mm: random.log_between(0.01, 100.0),
        focus_distance_m: focal_length_mm * 1e-3 * (1.0 + random.log_between(1e-4, 1e6)),
        aperture,
        eye: Default::default(),
    };
    Lens { aperture_diameter_mm: random.log_between(1e-3, 1e4) / lens.k_px(), ..lens }
}
