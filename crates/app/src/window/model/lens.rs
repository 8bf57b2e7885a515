//! Lenses as they are told apart.

use defocus::lens::Lens;

/// Whether two lenses differ at most in focus, to the digits that fields show.
pub fn same_but_focus(a: &Lens, b: &Lens) -> bool {
    let close = |x: f64, y: f64| (x - y).abs() <= 1e-6 * x.abs().max(y.abs());
    close(a.aperture_diameter_mm, b.aperture_diameter_mm)
        && close(a.focal_length_mm, b.focal_length_mm)
        && close(a.image_distance_mm, b.image_distance_mm)
        && close(a.screen_distance_mm, b.screen_distance_mm)
        && close(a.density_px_per_mm, b.density_px_per_mm)
        && a.aperture == b.aperture
}
