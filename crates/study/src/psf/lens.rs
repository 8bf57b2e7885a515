//! The lens's own modulation transfer function.

use super::Side;
use defocus::aperture::Aperture;
use defocus::image::ColorImage;
use defocus::methods::sprites::SpriteTable;
use glam::{DVec2, UVec2, Vec3};
use std::f64::consts::{PI, TAU};

/// Lens points by which the MTF of an aperture without a closed form is computed.
const POINTS: u32 = 1 << 14;

/// The Bessel function of the first kind and first order, to about 1e-14 for |x| up to 50:
/// its integral `1/pi int_0^pi cos(t - x sin t) dt` by the trapezium rule, which converges
/// exponentially for what is periodic.
pub fn bessel_j1(x: f64) -> f64 {
    const STEPS: u32 = 96;
    let at = |i: u32| {
        let t = PI * f64::from(i) / f64::from(STEPS);
        (t - x * t.sin()).cos()
    };
    let inner: f64 = (1..STEPS).map(at).sum();
    (inner + 0.5 * (at(0) + at(STEPS))) / f64::from(STEPS)
}

/// MTF of an aperture with a CoC diameter of `coc_px` at `frequency` cycles per px along x:
/// `2 J1(x) / x` with `x = pi f C` of a disc (Goodman, "Introduction to Fourier Optics",
/// section 6.4.2, for defocus well beyond a wavelength), `exp(-2 pi^2 sigma^2 f^2)` of a
/// Gaussian, and the mean over lens points of others.
pub fn lens_mtf(aperture: &Aperture, coc_px: f64, frequency: f64) -> f64 {
    match aperture {
        Aperture::Disc => {
            let x = PI * frequency * coc_px;
            if x < 1e-6 { 1.0 } else { (2.0 * bessel_j1(x) / x).abs() }
        }
        Aperture::Gaussian { .. } => {
            let sigma_px = aperture.sigma_per_coc() * coc_px;
            (-2.0 * (PI * sigma_px * frequency).powi(2)).exp()
        }
        Aperture::Polygon { .. } | Aperture::Image(_) => {
            let phases = (0..POINTS).map(|i| TAU * frequency * 0.5 * coc_px * aperture.lens_point(i).x);
            let (cos, sin) = phases.fold((0.0, 0.0), |(c, s), phase| (c + phase.cos(), s + phase.sin()));
            f64::hypot(cos, sin) / f64::from(POINTS)
        }
    }
}

/// The lens's own point spread function as pixels see it: the share of a point's light in each,
/// the point at the centre of the pixel right below and right of the picture's centre, as in
/// [`super::Psf::image`].
pub fn lens_kernel(aperture: &Aperture, (coc_px, side): (f64, Side), size: UVec2) -> ColorImage {
    let table = SpriteTable::of(aperture);
    let c_px = if side == Side::Front { -coc_px } else { coc_px };
    let point = (size / 2).as_dvec2();
    let share = |x: u32, y: u32| table.share(DVec2::new(x.into(), y.into()) - point, c_px) as f32;
    ColorImage::from_fn(size, |x, y| Vec3::splat(share(x, y)))
}
