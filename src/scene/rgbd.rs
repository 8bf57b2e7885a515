//! An image with a depth map, from files.

mod encoding;
mod fill;
mod resample;
mod sentinel;

pub use encoding::{DepthEncoding, DepthKind, EncodingError};

use crate::image::{ColorImage, DepthImage, Image};
use crate::image_io::embedded::{self, Unit};
use crate::image_io::exr_planes::{ExrPlanes, Window};
use crate::image_io::orientation::{Orientation, is_sideways, upright};
use crate::image_io::{self, ImageError, Scalars};
use crate::scene::MadeFor;
use encoding::Measured;
use glam::{IVec2, UVec2, Vec3};
use std::path::{Path, PathBuf};

/// A picture taken through a pinhole, with the depth of every pixel.
#[derive(Clone, Debug)]
pub struct RgbdScene {
    /// The colour file's stem.
    pub name: String,
    /// Linear Rec. 709; finite.
    pub color: ColorImage,
    /// Depth along the optical axis, metres; positive, infinite where nothing is.
    pub depth: DepthImage,
    /// Full vertical field of view, radians.
    pub fov_y: f64,
    /// Share of the pixels, in [0, 1), whose depth was not measured and is filled in from
    /// the surroundings.
    pub unknown_share: f64,
    /// Pixels whose colour was NaN or infinite, or whose depth was NaN, zero or negative;
    /// replaced from the surroundings.
    pub nonfinite_pixels: usize,
    /// What was filled in or approximated, one sentence each.
    pub notes: Vec<String>,
    /// The lens and the frame that it is made for, of an image that is made for one.
    pub made_for: Option<MadeFor>,
}

/// Why an image with depth cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RgbdError {
    /// One of the files cannot be read.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The numbers do not fit the encoding that was named for them.
    #[error("{}: {source}", file.display())]
    Encoding {
        /// The depth file.
        file: PathBuf,
        /// Which value or parameter, and the remedy.
        source: EncodingError,
    },
    /// A depth map that shows another frame than the picture.
    #[error("{}: the depth has {depth_size} pixels but the colour {color_size}, which is another frame; give a depth map of the image's own aspect ratio", file.display())]
    SizeMismatch {
        /// The depth file.
        file: PathBuf,
        /// Size of the colour, px.
        color_size: UVec2,
        /// Size of the depth, px.
        depth_size: UVec2,
    },
    /// A colour file without depth, and no depth file beside it.
    #[error("{}: has no depth of its own; give a depth map with --depth FILE", file.display())]
    NoDepth {
        /// The colour file.
        file: PathBuf,
    },
    /// Depth in a picture's file whose numbers it does not explain.
    #[error("{}: its own depth has no units; say what its numbers mean with --depth-kind (such as relative) and --depth-range NEAR,FAR", file.display())]
    Uncalibrated {
        /// The file.
        file: PathBuf,
    },
    /// Not one usable pixel.
    #[error("{}: not one pixel has a usable {what}; check the file, --depth-kind and --depth-unknown", file.display())]
    NothingKnown {
        /// The file.
        file: PathBuf,
        /// "depth" or "colour".
        what: &'static str,
    },
    /// A field of view outside (0, 180) degrees.
    #[error("the vertical field of view is {degrees} degrees; it must be more than 0 and less than 180 (--fov)")]
    FieldOfView {
        /// The value given, degrees.
        degrees: f64,
    },
}

/// Which files and layers to read, and what their numbers mean.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// The picture.
    pub color: &'a Path,
    /// The depth file; without one, depth comes from the picture's own EXR or JPEG.
    pub depth: Option<&'a Path>,
    /// What the depth's numbers mean.
    pub encoding: &'a DepthEncoding,
    /// Full vertical field of view, radians. Without one, that of the depth's calibration,
    /// or else `default_fov_y`.
    pub fov_y: Option<f64>,
    /// The field of view of an image that does not say, radians.
    pub default_fov_y: f64,
    /// The EXR layer that is the picture; `None` for the one that is by its name.
    pub layer: Option<&'a str>,
    /// The EXR layer or channel that is depth.
    pub depth_layer: Option<&'a str>,
}

/// Loads colour from `color_path`, depth from `depth_path` or, without one, from the colour's
/// own EXR. `fov_y` is the full vertical field of view, radians.
///
/// # Errors
///
/// The file, the cause and the remedy.
pub fn load(
    color_path: &Path,
    depth_path: Option<&Path>,
    encoding: &DepthEncoding,
    fov_y: f64,
) -> Result<RgbdScene, RgbdError> {
    let (color, depth, default_fov_y) = (color_path, depth_path, fov_y);
    let (layer, depth_layer) = (None, None);
    load_request(&Request { color, depth, encoding, fov_y: Some(fov_y), default_fov_y, layer, depth_layer })
}

/// Loads what a request names. Depth of another size is resampled to the picture's with
/// edges kept; pictures and depth are turned upright as their Exif data say.
///
/// # Errors
///
/// The file, the cause and the remedy.
pub fn load_request(request: &Request<'_>) -> Result<RgbdScene, RgbdError> {
    let depth_file = request.depth.unwrap_or(request.color);
    let encoding_error = |source| RgbdError::Encoding { file: depth_file.to_owned(), source };
    request.encoding.check().map_err(encoding_error)?;
    let mut notes = Vec::new();
    let ((color, raw), encoding) = match request.depth {
        Some(depth) => (read_two(request, depth, &mut notes)?, *request.encoding),
        None if image_io::is_exr(request.color)? => (read_both(request)?, *request.encoding),
        None => read_embedded(request, &mut notes)?,
    };
    let depth_size = raw.values.size;
    let of_calibration = || encoding.kind.fov_y(depth_size.y);
    let fov_y = request.fov_y.or_else(of_calibration).unwrap_or(request.default_fov_y);
    if !(fov_y > 0.0 && fov_y < std::f64::consts::PI) {
        return Err(RgbdError::FieldOfView { degrees: fov_y.to_degrees() });
    }
    if !resample::same_frame(color.size, depth_size) {
        let color_size = color.size;
        return Err(RgbdError::SizeMismatch { file: depth_file.to_owned(), color_size, depth_size });
    }

    let (numbers, kind) = (&raw.values.pixels, &encoding.kind);
    let mut measured = encoding.measure_all(numbers, raw.full_scale).map_err(encoding_error)?;
    let endless = sentinel::to_infinity(numbers, raw.is_float(), kind, &mut measured);
    if endless > 0 {
        notes.push(format!("{endless} depths that stand for the background (0, 65504 or 1e8 m and more) are infinite"));
    }
    if let DepthKind::Distance { .. } = kind {
        along_axis(&mut measured, depth_size, fov_y);
        notes.push(format!(
            "distances along rays become depths by a vertical field of view of {:.2} degrees (--fov)",
            fov_y.to_degrees()
        ));
    }
    if depth_size != color.size {
        let factor = color.size.as_dvec2() / depth_size.as_dvec2();
        notes.push(format!(
            "the depth of {}x{} px is resampled to the picture's {}x{} px, a factor of {:.3}, with edges kept",
            depth_size.x, depth_size.y, color.size.x, color.size.y, factor.y
        ));
        measured = resample::to_size(&measured, depth_size, &color);
    }
    let stem = request.color.file_stem();
    let name = stem.map_or_else(|| "image".to_owned(), |stem| stem.to_string_lossy().into_owned());
    let mut scene = complete(name, color, &measured, fov_y).map_err(|what| RgbdError::NothingKnown {
        file: if what == "depth" { depth_file } else { request.color }.to_owned(),
        what,
    })?;
    scene.notes.extend(notes);
    Ok(scene)
}

/// A picture with a depth file of its own. Depth that says nothing about how the camera was
/// held, and has the picture's size as it is stored, is turned with the picture.
fn read_two(request: &Request<'_>, depth: &Path, notes: &mut Vec<String>) -> Result<(ColorImage, Scalars), RgbdError> {
    let (color, orientation) = image_io::read_picture(request.color, request.layer)?;
    let mut raw = image_io::read_scalars(depth, request.depth_layer)?;
    if orientation != Orientation::NoTransforms {
        notes.push("the picture is turned upright, as its Exif data say".to_owned());
        let lies_sideways = is_sideways(orientation)
            && !raw.has_orientation
            && !resample::same_frame(color.size, raw.values.size)
            && resample::same_frame(color.size, UVec2::new(raw.values.size.y, raw.values.size.x));
        if lies_sideways {
            raw.values = upright(&raw.values, orientation);
            notes.push("the depth lies as the picture is stored, and is turned with it".to_owned());
        }
    }
    Ok((color, raw))
}

/// Colour and depth of a JPEG that holds both. Where the file says what its numbers mean, and nothing
/// else is asked for, they become metres; otherwise they are what the request says.
fn read_embedded(
    request: &Request<'_>,
    notes: &mut Vec<String>,
) -> Result<((ColorImage, Scalars), DepthEncoding), RgbdError> {
    let path = request.color;
    let unreadable = |source| ImageError::Unreadable { file: path.to_owned(), source };
    let undecodable =
        |detail: String| ImageError::Undecodable { file: path.to_owned(), detail: image_io::one_line(&detail) };
    // A picture that cannot be read is the first thing to say.
    let (color, orientation) = image_io::read_picture(path, request.layer)?;
    let bytes = std::fs::read(path).map_err(unreadable)?;
    let found = embedded::find(&bytes).map_err(undecodable)?;
    let found = found.ok_or_else(|| RgbdError::NoDepth { file: path.to_owned() })?;
    let values = upright(&found.values, orientation);
    if orientation != Orientation::NoTransforms {
        notes.push("the picture and its depth are turned upright, as its Exif data say".to_owned());
    }
    let is_default = *request.encoding == DepthEncoding::METRES;
    let Some(range) = found.range.filter(|_| is_default) else {
        if is_default {
            return Err(RgbdError::Uncalibrated { file: path.to_owned() });
        }
        let scalars = Scalars { values, full_scale: found.full_scale, has_orientation: true };
        return Ok(((color, scalars), *request.encoding));
    };
    let metres = values.map(|number| range.metres_at(f64::from(number) / found.full_scale) as f32);
    let unit = if range.unit == Unit::Dioptres { "dioptres" } else { "metres" };
    notes.push(format!(
        "the depth in the picture's own file lies between {} and {} {unit}, as it says",
        range.near, range.far
    ));
    let kind =
        if range.along_ray { DepthKind::Distance { per_unit: 1.0 } } else { DepthKind::Metres { per_unit: 1.0 } };
    let encoding = DepthEncoding { kind, ..DepthEncoding::METRES };
    Ok(((color, Scalars::floats(metres)), encoding))
}

/// Colour and depth of one EXR. A part of another data window is laid over the colour's;
/// what it does not cover is unknown.
fn read_both(request: &Request<'_>) -> Result<(ColorImage, Scalars), RgbdError> {
    let path = request.color;
    let planes = ExrPlanes::read(path)?;
    let (color, part) = planes.color(request.layer)?;
    let (depth, window) = planes.depth_beside(&part, request.depth_layer)?;
    let values = if window == part.window { depth } else { moved(&depth, window, part.window) };
    Ok((color, Scalars::floats(values)))
}

/// Depths along the axis from distances along the rays of a pinhole camera, which looks
/// through the middle of the image.
fn along_axis(measured: &mut [Measured], size: UVec2, fov_y: f64) {
    let focal_px = 0.5 * f64::from(size.y) / (0.5 * fov_y).tan();
    let middle = size.as_dvec2() * 0.5;
    for (i, m) in measured.iter_mut().enumerate() {
        if let Measured::Depth(distance_m) = m {
            let (x, y) = (i as u32 % size.x, i as u32 / size.x);
            let slope = (UVec2::new(x, y).as_dvec2() + 0.5 - middle) / focal_px;
            *distance_m = (f64::from(*distance_m) / (1.0 + slope.length_squared()).sqrt()) as f32;
        }
    }
}

fn moved(plane: &Image<f32>, from: Window, to: Window) -> Image<f32> {
    // Windows come from files: their distance may not fit an i32.
    let offset = to.origin.as_i64vec2() - from.origin.as_i64vec2();
    let source = |x: u32, y: u32| {
        let p = offset + UVec2::new(x, y).as_i64vec2();
        let inside = p.cmpge(IVec2::ZERO.as_i64vec2()).all() && p.cmplt(from.size.as_i64vec2()).all();
        if inside { plane.at(p.x as u32, p.y as u32) } else { f32::NAN }
    };
    Image::from_fn(to.size, source)
}

/// Fills what is unknown or damaged; the error names what is nowhere known.
fn complete(name: String, mut color: ColorImage, measured: &[Measured], fov_y: f64) -> Result<RgbdScene, &'static str> {
    let size = color.size;
    let color_known: Vec<bool> = color.pixels.iter().map(|rgb| rgb.is_finite()).collect();
    let depth_known: Vec<bool> = measured.iter().map(|m| matches!(m, Measured::Depth(_))).collect();
    let unknown = measured.iter().filter(|m| matches!(m, Measured::Unknown)).count();
    let damaged = |(m, known): (&Measured, &bool)| matches!(m, Measured::Damaged) || !known;
    let nonfinite_pixels = measured.iter().zip(&color_known).filter(|&pixel| damaged(pixel)).count();

    let mut depth = Image { size, pixels: measured.iter().map(Measured::depth_or_zero).collect::<Vec<f32>>() };
    let mean = |near: &[Vec3]| near.iter().map(|&rgb| rgb / near.len() as f32).sum();
    // A hole beside an edge is most often the shadow that a sensor's offset source casts
    // on the farther surface: of the depths that border it, the farthest is continued.
    let farthest = |near: &[f32]| near.iter().copied().fold(0.0, f32::max);
    if !fill::from_surroundings(&mut color, &color_known, mean) {
        return Err("colour");
    }
    if !fill::from_surroundings(&mut depth, &depth_known, farthest) {
        return Err("depth");
    }

    let unknown_share = unknown as f64 / measured.len() as f64;
    let mut notes = Vec::new();
    if unknown > 0 {
        notes.push(format!(
            "{:.1} % of the depths were not measured and are filled in from their surroundings",
            unknown_share * 100.0
        ));
    }
    if nonfinite_pixels > 0 {
        notes.push(format!(
            "{nonfinite_pixels} pixels with a colour that is not finite or a depth that is not positive are replaced from their surroundings"
        ));
    }
    Ok(RgbdScene { name, color, depth, fov_y, unknown_share, nonfinite_pixels, notes, made_for: None })
}
