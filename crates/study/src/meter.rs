//! An exposure by what is seen, for files whose light is of another scale than the screen.
//!
//! glTF gives lights in lux and candela: in daylight a white wall has a radiance of
//! thousands, by moonlight of thousandths. Only a picture that would be white or black is
//! exposed anew, by the log average of its surfaces, so that whatever can be looked at
//! stays as it is.

use crate::StudyError;
use crate::builtin;
use crate::render::render;
use crate::source::Source;
use defocus::display::LUMINANCE;
use defocus::gpu::Gpu;
use defocus::image::{ColorImage, DepthImage};
use defocus::lens::Lens;
use defocus::methods::Pinhole;
use defocus::view::View;

/// Luminance that the log average of the surfaces is brought to: middle grey, the 18 % of
/// photographic metering.
const MIDDLE_GREY: f64 = 0.18;

/// A picture is white if more than half of its surfaces are at least this bright: a stop
/// beyond the screen's white, which no surface has that shows its base colour.
const WHITE: f32 = 2.0;

/// A picture is black if all but a twentieth of its surfaces are darker than this: a tenth
/// of the screen's white, which sRGB shows as a third of its signal.
const BLACK: f32 = 0.1;

/// Surfaces that do not count at either end of the log average, so that neither lamps nor
/// what no light reaches decides it.
const TAIL: f64 = 0.1;

/// Exposure in EV for an image and the depths at its pixels; `None` where it can be looked
/// at as it is, or where there is no light to expose for.
pub fn exposure_ev(color: &ColorImage, depth: &DepthImage) -> Option<f32> {
    let surfaces = color.pixels.iter().zip(&depth.pixels).filter(|(_, depth_m)| depth_m.is_finite());
    let mut luminances: Vec<f32> = surfaces.map(|(rgb, _)| rgb.dot(LUMINANCE)).filter(|l| l.is_finite()).collect();
    luminances.sort_unstable_by(f32::total_cmp);
    let at = |share: f64| luminances.get(((luminances.len() as f64) * share) as usize).copied();
    let (is_white, is_black) = (at(0.5)? >= WHITE, at(0.95)? < BLACK);
    if !(is_white || is_black) {
        return None;
    }
    let lit = &luminances[luminances.partition_point(|l| *l <= 0.0)..];
    let tail = (lit.len() as f64 * TAIL) as usize;
    let middle = lit.get(tail..lit.len() - tail).filter(|middle| !middle.is_empty())?;
    let mean_log = middle.iter().map(|l| f64::from(*l).ln()).sum::<f64>() / middle.len() as f64;
    let ev = (MIDDLE_GREY.ln() - mean_log) / std::f64::consts::LN_2;
    // Beyond 64 EV every finite colour is black or white; a tenth is no visible step.
    Some(((ev.clamp(-64.0, 64.0) * 10.0).round() / 10.0) as f32)
}

/// Whether a source is one whose exposure is chosen by what is seen: a scene of a file, lit. What
/// shows its base colours alone has no light to be too strong or too weak, and the built-in scenes are
/// made to be looked at as they are.
pub fn is_metered(spec: &str, source: &Source) -> bool {
    let is_lit = matches!(source, Source::Scene(scene) if scene.materials.iter().any(|material| !material.unlit));
    is_lit && builtin::builtin(spec).is_none()
}

/// [`exposure_ev`] of a view's pinhole image.
///
/// # Errors
///
/// A view that cannot be drawn.
pub fn view_exposure_ev(gpu: &Gpu, view: &mut View, lens: &Lens) -> Result<Option<f32>, StudyError> {
    let seen = render(gpu, view, lens, &Pinhole)?.color;
    Ok(exposure_ev(&seen, &view.depth_m(gpu)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use defocus::image::Image;
    use glam::{UVec2, Vec3};

    fn metered(luminance: impl Fn(u32) -> f32) -> Option<f32> {
        let size = UVec2::new(10, 10);
        let color = Image::from_fn(size, |x, y| Vec3::splat(luminance(10 * y + x)));
        exposure_ev(&color, &Image::filled(size, 2.0))
    }

    #[test]
    fn only_white_and_black_pictures_are_exposed_anew() {
        assert_eq!(metered(|_| 0.18), None);
        assert_eq!(metered(|i| if i < 45 { 50.0 } else { 0.3 }), None);
        assert_eq!(metered(|i| if i < 90 { 0.0 } else { 0.5 }), None);
        assert_eq!(metered(|_| 0.0), None);
        // 0.18 * 1024 is ten stops too bright; 0.18 / 32 five too dark.
        assert_eq!(metered(|_| 184.32), Some(-10.0));
        assert_eq!(metered(|_| 0.005_625), Some(5.0));
        // A lamp and a shadow do not count.
        assert_eq!(metered(|i| [184.32, 184.32, 184.32, 1e6][usize::from(i < 5) * 3]), Some(-10.0));
        let size = UVec2::new(4, 4);
        assert_eq!(exposure_ev(&Image::filled(size, Vec3::splat(9.0)), &Image::filled(size, f32::INFINITY)), None);
    }
}
