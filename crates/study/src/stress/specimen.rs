//! What methods are tried on: a view, a lens, and what is known of the result beforehand.

use defocus::gpu::{Frame, Gpu, Precision, download};
use defocus::image::{ColorImage, DepthImage, Image};
use defocus::lens::Lens;
use defocus::methods::{self, Method, MethodError};
use defocus::view::{View, ViewError};
use glam::{UVec2, Vec3};
use half::f16;

/// Vertical field of view of images, radians.
const FOV_Y: f64 = 0.8;

/// Largest change of a blur spot's width, px, that a small step of the focus makes.
pub const STEP_PX: f64 = 0.025;

/// An image with a depth map, the lens to see it through, and a name that says what is
/// hard about them.
#[derive(Clone, Debug)]
pub struct ImageCase {
    /// What is hard about it.
    pub name: String,
    /// Linear colour; anything at all.
    pub color: ColorImage,
    /// Depth, metres; anything at all.
    pub depth_m: DepthImage,
    /// A lens that [`Lens::check`] lets through.
    pub lens: Lens,
}

/// The pixels of an input image as a view holds them.
#[derive(Clone, Debug)]
pub struct Pixels {
    /// Finite, rounded to f16.
    pub color: ColorImage,
    /// Positive, metres.
    pub depth_m: DepthImage,
}

impl Pixels {
    /// Least and greatest value of each channel.
    pub fn range(&self) -> [Vec3; 2] {
        let first = self.color.pixels[0];
        self.color.pixels.iter().fold([first; 2], |[low, high], p| [low.min(*p), high.max(*p)])
    }

    /// The only pixel that is not black, if there is one such.
    pub fn only_light(&self) -> Option<UVec2> {
        let mut lit = (0..self.color.pixels.len()).filter(|i| self.color.pixels[*i] != Vec3::ZERO);
        let index = lit.next().filter(|_| lit.next().is_none())? as u32;
        Some(UVec2::new(index % self.color.size.x, index / self.color.size.x))
    }

    /// The one depth of all pixels, metres, if there is one such.
    pub fn only_depth_m(&self) -> Option<f64> {
        let first = self.depth_m.pixels[0];
        self.depth_m.pixels.iter().all(|d| *d == first).then_some(f64::from(first))
    }
}

/// The same picture in another place or at another scale.
pub struct Twin {
    /// Its view.
    pub view: View,
    /// The lens that blurs it alike.
    pub lens: Lens,
}

/// A lens focused a little farther, or for a focus at infinity opened a little more.
pub struct Step {
    /// The lens.
    pub lens: Lens,
    /// By how much the width of a pixel's blur spot changes at most, px.
    pub change_px: f64,
}

/// A view with a lens, on which every method is tried.
pub struct Specimen {
    /// What is hard about it.
    pub name: String,
    /// The lens.
    pub lens: Lens,
    /// What is seen.
    pub view: View,
    /// The input image; `None` for a scene.
    pub pixels: Option<Pixels>,
    /// The one colour of everything in view, if there is one.
    pub only_color: Option<Vec3>,
    /// The same seen in a mirror; `None` for a scene.
    pub mirrored: Option<View>,
    /// `None` where the same picture cannot be made in another way.
    pub twin: Option<Twin>,
    /// `None` where arithmetic in f32 leaves more of a difference than the step would.
    pub step: Option<Step>,
}

impl Specimen {
    /// An image with depth as a specimen.
    ///
    /// # Errors
    ///
    /// A size that the adapter cannot draw.
    pub fn of_image(gpu: &Gpu, case: &ImageCase) -> Result<Self, ViewError> {
        let ImageCase { name, color, depth_m, lens } = case;
        let mut view = View::of_image(gpu, color, depth_m, FOV_Y)?;
        let pixels =
            Pixels { color: color.map(as_stored), depth_m: depth_m.map(|d| if d > 0.0 { d } else { f32::INFINITY }) };
        let [low, high] = pixels.range();
        let mirrored = View::of_image(gpu, &mirrored(color), &mirrored(depth_m), FOV_Y)?;
        Ok(Self {
            name: name.clone(),
            lens: lens.clone(),
            step: step(gpu, &mut view, lens),
            view,
            only_color: (low == high).then_some(low),
            pixels: Some(pixels),
            mirrored: Some(mirrored),
            twin: None,
        })
    }
}

/// A colour as [`View::of_image`] stores it: f16 within its range, black for what is not
/// a number.
pub fn as_stored(color: Vec3) -> Vec3 {
    let max = f16::MAX.to_f32();
    if !color.is_finite() {
        return Vec3::ZERO;
    }
    Vec3::from_array(color.to_array().map(|v| f16::from_f32(v.clamp(-max, max)).to_f32()))
}

/// The image, right and left exchanged.
pub fn mirrored<T: Copy>(image: &Image<T>) -> Image<T> {
    Image::from_fn(image.size, |x, y| image.at(image.size.x - 1 - x, y))
}

/// What `method` makes of a view, with intermediates of the given precision.
///
/// # Errors
///
/// What the method says.
pub fn render(
    gpu: &Gpu,
    method: &dyn Method,
    view: &mut View,
    lens: &Lens,
    precision: Precision,
) -> Result<ColorImage, MethodError> {
    let mut frame: Frame<'_> = gpu.frame();
    frame.precision = precision;
    let texture = methods::record(method, &mut frame, view, lens)?;
    frame.finish();
    Ok(download(gpu, &texture))
}

/// Width of a lens's blur spots over their CoC: 1 of a disc, and of the rest that of the
/// disc of the same standard deviation. Eight of the widest Gaussian: what its CoC changes
/// by, its edges move by four times on either side.
pub(super) fn width_per_coc(lens: &Lens) -> f64 {
    (4.0 * lens.aperture.sigma_per_coc()).max(1.0)
}

/// The step of the focus that changes no blur spot in view by more than [`STEP_PX`].
pub(super) fn step(gpu: &Gpu, view: &mut View, lens: &Lens) -> Option<Step> {
    let mut frame = gpu.frame();
    let z_bounds = view.z_bounds(&mut frame).map(f64::from);
    frame.finish();
    let near_m = view.projection().near_m;
    // c = k - slope z: each of the two is rounded to f32.
    let greatest_px = z_bounds.map(|z| lens.k_px().abs().max(lens.coc().slope_px(near_m) * z));
    let rounding_px = width_per_coc(lens) * greatest_px[0].max(greatest_px[1]) * f64::from(f32::EPSILON);
    if rounding_px > 0.1 * STEP_PX {
        return None;
    }
    let change_px = |moved: &Lens| {
        let at = |z: f64| (moved.coc().at_stored(z, near_m) - lens.coc().at_stored(z, near_m)).abs();
        width_per_coc(lens) * at(z_bounds[0]).max(at(z_bounds[1]))
    };
    const TRIAL: f64 = 1e-3;
    let trial_px = change_px(&stepped(lens, TRIAL));
    if trial_px == 0.0 {
        return None;
    }
    let lens = stepped(lens, (TRIAL * STEP_PX / trial_px).min(0.01));
    let change_px = change_px(&lens);
    Some(Step { lens, change_px })
}

fn stepped(lens: &Lens, share: f64) -> Lens {
    if lens.focus_distance_m.is_infinite() {
        return Lens { aperture_diameter_mm: lens.aperture_diameter_mm * (1.0 + share), ..lens.clone() };
    }
    let beyond_focal_length_m = lens.focus_distance_m - lens.focal_length_mm / defocus::lens::MM_PER_M;
    Lens { focus_distance_m: lens.focus_distance_m + beyond_focal_length_m * share, ..lens.clone() }
}
