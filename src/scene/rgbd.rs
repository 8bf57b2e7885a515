//! An image with a depth map, from files.

mod encoding;
mod fill;

pub use encoding::{DepthEncoding, DepthKind, EncodingError};

use crate::image::{ColorImage, DepthImage, Image};
use crate::image_io::exr_planes::{ExrPlanes, Window};
use crate::image_io::{self, ImageError};
use crate::scene::MadeFor;
use encoding::Measured;
use glam::{IVec2, UVec2, Vec3};
use image::DynamicImage;
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
    /// Colour and depth of different sizes.
    #[error("{}: the depth has {depth_size} pixels but the colour {color_size}; give a depth map of the image's own size", file.display())]
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

/// Loads colour from `color_path`, depth from `depth_path` or, without one, from the Z
/// channel of the colour's own EXR. `fov_y` is the full vertical field of view, radians.
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
    if !(fov_y > 0.0 && fov_y < std::f64::consts::PI) {
        return Err(RgbdError::FieldOfView { degrees: fov_y.to_degrees() });
    }
    let depth_file = depth_path.unwrap_or(color_path);
    let encoding_error = |source| RgbdError::Encoding { file: depth_file.to_owned(), source };
    encoding.check().map_err(encoding_error)?;
    let (color, raw) = match depth_path {
        Some(depth_path) => (image_io::read_color(color_path)?, read_depth(depth_path)?),
        None => read_both(color_path)?,
    };
    if color.size != raw.values.size {
        let (color_size, depth_size) = (color.size, raw.values.size);
        return Err(RgbdError::SizeMismatch { file: depth_file.to_owned(), color_size, depth_size });
    }
    let measured = encoding.measure_all(&raw.values.pixels, raw.full_scale).map_err(encoding_error)?;
    let name = color_path.file_stem().map_or_else(|| "image".to_owned(), |stem| stem.to_string_lossy().into_owned());
    complete(name, color, &measured, fov_y).map_err(|what| RgbdError::NothingKnown {
        file: if what == "depth" { depth_file } else { color_path }.to_owned(),
        what,
    })
}

/// Numbers as they stand in a depth file.
struct RawDepth {
    /// Integers as such, floats as such; NaN where the file has no pixel.
    values: Image<f32>,
    /// The value that stands for 1: 255, 65535, or 1 for floats.
    full_scale: f64,
}

/// Colour and Z of one EXR. A part of another data window is laid over the colour's;
/// what it does not cover is unknown.
fn read_both(path: &Path) -> Result<(ColorImage, RawDepth), RgbdError> {
    if !image_io::is_exr(path)? {
        return Err(RgbdError::NoDepth { file: path.to_owned() });
    }
    let planes = ExrPlanes::read(path)?;
    let (color, part) = planes.color()?;
    let (depth, window) = planes.depth_beside(&part)?;
    let values = if window == part.window { depth } else { moved(&depth, window, part.window) };
    Ok((color, RawDepth { values, full_scale: 1.0 }))
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

/// A depth file: EXR, or PNG of 8 or 16 bits (its first channel). f32 holds all of them
/// exactly.
fn read_depth(path: &Path) -> Result<RawDepth, RgbdError> {
    if image_io::is_exr(path)? {
        let (values, _) = ExrPlanes::read(path)?.depth_alone()?;
        return Ok(RawDepth { values, full_scale: 1.0 });
    }
    let image = image_io::decode(path)?;
    let size = UVec2::new(image.width(), image.height());
    let (pixels, full_scale) = match &image {
        DynamicImage::ImageLuma16(grey) => (every(grey.as_raw(), 1), 65535.0),
        DynamicImage::ImageLumaA16(grey) => (every(grey.as_raw(), 2), 65535.0),
        DynamicImage::ImageRgb16(rgb) => (every(rgb.as_raw(), 3), 65535.0),
        DynamicImage::ImageRgba16(rgba) => (every(rgba.as_raw(), 4), 65535.0),
        DynamicImage::ImageRgb32F(rgb) => (every(rgb.as_raw(), 3), 1.0),
        DynamicImage::ImageRgba32F(rgba) => (every(rgba.as_raw(), 4), 1.0),
        other => (every(other.to_rgb8().as_raw(), 3), 255.0),
    };
    Ok(RawDepth { values: Image { size, pixels }, full_scale })
}

/// The first of every `channels` samples.
fn every<T: Copy + Into<f32>>(samples: &[T], channels: usize) -> Vec<f32> {
    samples.iter().step_by(channels).map(|&sample| sample.into()).collect()
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
