//! What must hold whatever the input: each check names the first pixel that breaks it.

use super::specimen::{STEP_PX, Specimen, as_stored, mirrored, render, width_per_coc};
use defocus::gpu::{Gpu, Precision};
use defocus::image::{ColorImage, Image};
use defocus::methods::{IN_FOCUS_COC_PX, LinearFilter, Method, MethodError};
use glam::{DVec2, UVec2, Vec3};

/// A few roundings or truncations of f16, 2^-11 to 2^-10 each, relative to the values
/// that enter a pixel.
pub const F16_ROUNDINGS: f32 = 2e-3;

/// The same for numbers below f16's normal ones, which are 2^-24 apart.
pub const F16_SMALLEST_ROUNDINGS: f32 = 4.0 / 16_777_216.0;

/// How much of the contrast in view a pixel may change by while blur spots widen by a pixel.
///
/// The steepest edges change by the whole contrast a pixel, and a spot's area by as much;
/// several times that, over [`STEP_PX`], is a tenth of the contrast: more is popping.
const CHANGE_PER_PX: f64 = 4.0;

/// A method on a specimen, with what it made of it.
pub struct Subject<'a> {
    /// The GPU.
    pub gpu: &'a Gpu,
    /// The method.
    pub method: &'a dyn Method,
    /// What it was tried on.
    pub specimen: &'a mut Specimen,
    /// What it made of it.
    pub image: ColorImage,
}

/// The first pixel that breaks a check.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct BadPixel {
    /// Where; `None` for what concerns the whole image.
    pub at: Option<UVec2>,
    /// What is there and what should be.
    pub found: String,
}

/// What a check finds: `None` where it does not apply.
pub type Finding = Result<Option<Result<(), BadPixel>>, MethodError>;

/// A check.
#[derive(Clone, Copy)]
pub struct Check {
    /// One or two words.
    pub name: &'static str,
    /// What must hold, and of which methods.
    pub what: &'static str,
    /// Looks.
    pub run: fn(&mut Subject<'_>) -> Finding,
}

/// All checks, in the order in which they are made.
pub const CHECKS: &[Check] = &[
    Check { name: "finite", what: "no pixel is NaN or infinite", run: finite },
    Check {
        name: "range",
        what: "where a method averages, each channel stays between the least and the greatest of the input",
        run: range,
    },
    Check { name: "constancy", what: "where a method averages, one colour stays that colour", run: constancy },
    Check { name: "sign", what: "light that is not negative does not become so", run: sign },
    Check {
        name: "energy",
        what: "where a method spreads light, a lone point's light adds up to what it was, and no method that sums adds any",
        run: energy,
    },
    Check { name: "focus", what: "an image in focus everywhere comes out as it went in", run: focus },
    Check {
        name: "mirror",
        what: "the mirrored input gives the mirrored output, on average where a method samples the lens",
        run: mirror,
    },
    Check {
        name: "repetition",
        what: "a second run gives the same bits; where atomics reorder sums, the same within roundings of f16",
        run: repetition,
    },
    Check { name: "continuity", what: "a small step of the focus changes little: nothing pops", run: continuity },
    Check { name: "f64", what: "the program in f64 on the CPU, where there is one, agrees", run: f64_program },
    Check {
        name: "invariance",
        what: "a scene far from the origin, or of another scale, looks the same",
        run: invariance,
    },
];

/// First pixel of `image` for which `bad` has something to say.
pub fn first_bad_pixel<T: Copy>(image: &Image<T>, bad: impl Fn(UVec2, T) -> Option<String>) -> Result<(), BadPixel> {
    for (index, value) in image.pixels.iter().enumerate() {
        let at = UVec2::new(index as u32 % image.size.x, index as u32 / image.size.x);
        if let Some(found) = bad(at, *value) {
            return Err(BadPixel { at: Some(at), found });
        }
    }
    Ok(())
}

/// First pixel that is NaN or infinite.
pub fn first_not_finite(image: &ColorImage) -> Result<(), BadPixel> {
    first_bad_pixel(image, |_, p| (!p.is_finite()).then(|| format!("is {p}")))
}

/// First pixel that differs from the other image's by more than `limit` in any channel.
pub fn first_difference(image: &ColorImage, other: &ColorImage, limit: f32) -> Result<(), BadPixel> {
    first_bad_pixel(image, |at, p| {
        let wanted = other.at(at.x, at.y);
        let error = (p - wanted).abs().max_element();
        // The greatest of several numbers passes over a NaN among them.
        (!p.is_finite() || error > limit).then(|| format!("is {p}, should be {wanted} within {limit:.2e}"))
    })
}

/// The greatest magnitude of any channel.
fn greatest(image: &ColorImage) -> f32 {
    image.pixels.iter().map(|p| p.abs().max_element()).fold(0.0, f32::max)
}

/// What roundings to f16 may cost where values up to `greatest` are added up.
fn rounding(greatest: f32) -> f32 {
    F16_ROUNDINGS * greatest + F16_SMALLEST_ROUNDINGS
}

/// Roundings of a value that goes through a pyramid of the image: each level may truncate once;
/// three more for the input, what is read between levels, and the result.
fn pyramid_rounding(size: UVec2) -> f32 {
    const TRUNCATION: f32 = 1.0 / 2048.0;
    let levels = (size.max_element() as f32).log2().ceil();
    F16_ROUNDINGS.max((levels + 3.0) * TRUNCATION)
}

impl Subject<'_> {
    fn again(&mut self) -> Result<ColorImage, MethodError> {
        render(self.gpu, self.method, &mut self.specimen.view, &self.specimen.lens, Precision::Half)
    }

    /// Greatest signed CoC diameters in view, px.
    fn coc_bounds_px(&mut self) -> [f64; 2] {
        let mut frame = self.gpu.frame();
        let bounds = self.specimen.view.coc_bounds_px(&mut frame, &self.specimen.lens);
        frame.finish();
        bounds
    }

    /// Greatest less least value in and out; of a scene, of which only what is seen is known,
    /// the greatest.
    fn contrast(&self) -> f32 {
        if self.specimen.pixels.is_none() {
            return greatest(&self.image);
        }
        let own = Vec3::splat(f32::NEG_INFINITY);
        let (low, high) = self.image.pixels.iter().fold((-own, own), |(l, h), p| (l.min(*p), h.max(*p)));
        let [in_low, in_high] = self.specimen.pixels.as_ref().map_or([low, high], |p| p.range());
        (in_high.max(high) - in_low.min(low)).max_element()
    }
}

fn finite(subject: &mut Subject<'_>) -> Finding {
    Ok(Some(first_not_finite(&subject.image)))
}

fn range(subject: &mut Subject<'_>) -> Finding {
    let Some(pixels) = &subject.specimen.pixels else { return Ok(None) };
    if !subject.method.about().averages || subject.specimen.only_color.is_some() {
        return Ok(None);
    }
    let [low, high] = pixels.range();
    let slack = rounding(low.abs().max(high.abs()).max_element());
    let outside = |p: Vec3| !(p.cmpge(low - slack).all() && p.cmple(high + slack).all());
    Ok(Some(first_bad_pixel(&subject.image, |_, p| {
        outside(p).then(|| format!("is {p}, outside the input's {low} to {high}"))
    })))
}

fn constancy(subject: &mut Subject<'_>) -> Finding {
    let (Some(color), true) = (subject.specimen.only_color, subject.method.about().averages) else { return Ok(None) };
    let slack = pyramid_rounding(subject.image.size) * color.abs() + F16_SMALLEST_ROUNDINGS;
    Ok(Some(first_bad_pixel(&subject.image, |_, p| {
        (!(p - color).abs().cmple(slack).all()).then(|| format!("is {p} where all is {color}"))
    })))
}

fn sign(subject: &mut Subject<'_>) -> Finding {
    let negative = |image: &ColorImage| image.pixels.iter().any(|p| p.min_element() < 0.0);
    if subject.specimen.pixels.as_ref().is_some_and(|p| negative(&p.color)) {
        return Ok(None);
    }
    Ok(Some(first_bad_pixel(&subject.image, |_, p| {
        (p.min_element() < 0.0).then(|| format!("is {p}, and no input is negative"))
    })))
}

fn energy(subject: &mut Subject<'_>) -> Finding {
    let about = subject.method.about();
    let Some(pixels) = &subject.specimen.pixels else { return Ok(None) };
    if !about.conserves_energy || pixels.range()[0].min_element() < 0.0 {
        return Ok(None);
    }
    let sum = |image: &ColorImage| image.pixels.iter().map(|p| f64::from(p.y)).sum::<f64>();
    let (before, after) = (sum(&pixels.color), sum(&subject.image));
    // Each pixel of the result is rounded on its own.
    let slack =
        f64::from(F16_ROUNDINGS) * before + f64::from(F16_SMALLEST_ROUNDINGS) * subject.image.pixels.len() as f64;
    let judged = if spot_lies_inside(subject) {
        (after - before).abs() <= slack
    } else if about.averages {
        return Ok(None);
    } else {
        after <= before + slack
    };
    let bad = || BadPixel { at: None, found: format!("the light adds up to {after}, of {before} in the input") };
    Ok(Some(if judged { Ok(()) } else { Err(bad()) }))
}

/// Whether there is one point of light at one depth whose spot fits into the image.
fn spot_lies_inside(subject: &Subject<'_>) -> bool {
    let Some(pixels) = &subject.specimen.pixels else { return false };
    let (Some(light), Some(depth_m)) = (pixels.only_light(), pixels.only_depth_m()) else { return false };
    let lens = &subject.specimen.lens;
    // Round methods draw the disc of the same standard deviation, whose radius is 2 sigma.
    let extent = lens.aperture.radius().max(4.0 * lens.aperture.sigma_per_coc());
    // A method that divides by what arrives divides by less where the spots of pixels beyond the
    // border are missing: the light must not reach there either.
    let spots = if subject.method.about().averages { 2.0 } else { 1.0 };
    let reach_px = spots * (0.5 * lens.coc_diameter_px(depth_m).abs() * extent + 1.0);
    let size = pixels.color.size.as_dvec2();
    let centre = light.as_dvec2() + 0.5;
    centre.min(size - centre).cmpgt(DVec2::splat(reach_px)).all()
}

fn focus(subject: &mut Subject<'_>) -> Finding {
    let [low, high] = subject.coc_bounds_px();
    let Some(pixels) = &subject.specimen.pixels else { return Ok(None) };
    if low.abs().max(high.abs()) >= IN_FOCUS_COC_PX {
        return Ok(None);
    }
    Ok(Some(first_difference(&subject.image, &pixels.color, 0.0)))
}

/// How much of the contrast the mirror image may differ by on average where a method
/// samples the lens: the mirror image of a set of lens points is another set. Where each of
/// 16 points meets either end of the contrast by chance, two means of them differ by
/// 0.5 sqrt(2/16) of it in standard deviation, and by 0.8 times that on average.
const SAMPLED_DIFFERENCE: f64 = 0.141;

fn mirror(subject: &mut Subject<'_>) -> Finding {
    if subject.specimen.mirrored.is_none() || !is_symmetric(&subject.specimen.lens.aperture) {
        return Ok(None);
    }
    let [nearest_px, farthest_px] = subject.coc_bounds_px();
    let Some(view) = &mut subject.specimen.mirrored else { return Ok(None) };
    let lens = &subject.specimen.lens;
    let widest_px = width_per_coc(lens) * nearest_px.abs().max(farthest_px);
    if subject.method.about().samples_lens && widest_px > 0.5 * f64::from(view.size().min_element()) {
        // Most rays leave the image: what the few others meet is chance.
        return Ok(None);
    }
    if !subject.method.about().samples_lens {
        let other = mirrored(&render(subject.gpu, subject.method, view, lens, Precision::Half)?);
        let limit = 2.0 * rounding(greatest(&other).max(greatest(&subject.image)));
        return Ok(Some(first_difference(&subject.image, &other, limit)));
    }
    let method = without_jitter(subject.method);
    let other = mirrored(&render(subject.gpu, &*method, view, lens, Precision::Half)?);
    let straight = render(subject.gpu, &*method, &mut subject.specimen.view, lens, Precision::Half)?;
    let difference = |(a, b): (&Vec3, &Vec3)| f64::from((*a - *b).abs().max_element());
    let sum: f64 = straight.pixels.iter().zip(&other.pixels).map(difference).sum();
    let (mean, contrast) = (sum / other.pixels.len() as f64, subject.contrast());
    let found = || format!("differs from the mirrored output by {mean:.3} on average, at a contrast of {contrast}");
    let limit = SAMPLED_DIFFERENCE * f64::from(contrast) + f64::from(rounding(greatest(&other)));
    Ok(Some(if mean <= limit { Ok(()) } else { Err(BadPixel { at: None, found: found() }) }))
}

fn is_symmetric(aperture: &defocus::aperture::Aperture) -> bool {
    use defocus::aperture::Aperture;
    match aperture {
        Aperture::Disc | Aperture::Gaussian { .. } => true,
        // A corner points up.
        Aperture::Polygon { rotation_deg, .. } => *rotation_deg == 0.0,
        Aperture::Image(_) => false,
    }
}

/// Methods that append to lists by atomics, whose order changes from run to run, and then
/// add up what is listed: there the order of a sum changes its last digits.
const REORDERING: &[&str] = &["adaptive"];

fn repetition(subject: &mut Subject<'_>) -> Finding {
    let again = subject.again()?;
    let reorders = REORDERING.contains(&subject.method.about().id);
    let limit = if reorders { rounding(greatest(&again)) } else { 0.0 };
    Ok(Some(first_difference(&again, &subject.image, limit)))
}

/// Share of the contrast that two of 16 lens points make, when both step over an edge.
const SAMPLED_CHANGE: f64 = 2.0 / 16.0;

/// The same of the eight sub-pixels, of a hundred in each pixel, that lie equally far from
/// the centre of a circle: its edge steps over all at once, and the least circle that
/// `linear` draws has pi/4 of a pixel.
const SUB_PIXEL_CHANGE: f64 = 0.08 / std::f64::consts::FRAC_PI_4;

/// What of the contrast a method's samples may leap by.
fn leap(method: &dyn Method) -> f64 {
    let about = method.about();
    if about.id == "linear" {
        SUB_PIXEL_CHANGE
    } else if about.samples_lens {
        SAMPLED_CHANGE
    } else {
        0.0
    }
}

fn continuity(subject: &mut Subject<'_>) -> Finding {
    let Some(step) = &subject.specimen.step else { return Ok(None) };
    let view = &mut subject.specimen.view;
    let moved = render(subject.gpu, subject.method, view, &step.lens, Precision::Half)?;
    let change_px = step.change_px.max(0.1 * STEP_PX);
    let values = rounding(greatest(&subject.image).max(greatest(&moved)));
    let limit = (CHANGE_PER_PX * change_px + leap(subject.method)) as f32 * subject.contrast() + values;
    Ok(Some(first_difference(&moved, &subject.image, limit)))
}

fn f64_program(subject: &mut Subject<'_>) -> Finding {
    let Some(pixels) = &subject.specimen.pixels else { return Ok(None) };
    let wanted = match subject.method.about().id {
        "pinhole" => pixels.color.clone(),
        "linear" => {
            let lens = &subject.specimen.lens;
            // A disc of the lens's standard deviation: four of them are its diameter.
            let diameter_per_coc = 4.0 * lens.aperture.sigma_per_coc();
            let diameter_px = pixels.depth_m.map(|d| (diameter_per_coc * lens.coc_diameter_px(f64::from(d))) as f32);
            let max_radius_px = super::LINEAR_RADIUS.parse().expect("a number of pixels");
            LinearFilter { max_radius_px, ..Default::default() }.apply(&pixels.color, &diameter_px).map(as_stored)
        }
        _ => return Ok(None),
    };
    if subject.specimen.step.is_none() {
        // f32 does not hold such CoCs to a fraction of a pixel.
        return Ok(None);
    }
    // A sub-pixel on the edge of a circle falls to either side of it, of a hundred.
    let limit = greatest(&pixels.color) * (0.01 + F16_ROUNDINGS) + F16_SMALLEST_ROUNDINGS;
    Ok(Some(first_difference(&subject.image, &wanted, limit)))
}

/// Share of the pixels that may differ where the same scene is drawn from other numbers:
/// edges fall to either side of a pixel's centre.
const EDGE_SHARE: f64 = 0.02;

fn invariance(subject: &mut Subject<'_>) -> Finding {
    let contrast = subject.contrast();
    let Some(twin) = &mut subject.specimen.twin else { return Ok(None) };
    let wanted = render(subject.gpu, subject.method, &mut twin.view, &twin.lens, Precision::Half)?;
    let limit = 0.02 * contrast + rounding(greatest(&wanted));
    let error = |at: usize| (subject.image.pixels[at] - wanted.pixels[at]).abs().max_element();
    let differing = (0..wanted.pixels.len()).filter(|at| error(*at) > limit).count();
    if differing as f64 <= EDGE_SHARE * wanted.pixels.len() as f64 {
        return Ok(Some(Ok(())));
    }
    let first = first_difference(&subject.image, &wanted, limit);
    Ok(Some(first.map_err(|bad| BadPixel { found: format!("{}; {differing} pixels differ", bad.found), ..bad })))
}

/// A copy of the method for which the check `mirror` means something: noise that differs from
/// pixel to pixel is not mirrored with the image.
pub fn without_jitter(method: &dyn Method) -> Box<dyn Method> {
    let mut method = method.boxed();
    for param in method.params().iter_mut().filter(|p| p.key == "jitter") {
        // Both kinds that there are, a switch and a choice, have an "off".
        let _ = param.set("off");
    }
    method
}
