//! One number a pixel, from any file that holds one: depths and disparities.

use super::error::{ImageError, check_size_to_read};
use super::exr_planes::ExrPlanes;
use super::orientation::{Orientation, upright};
use super::pfm::{self, Pfm};
use super::{npy, read_start};
use crate::image::Image;
use glam::UVec2;
use image::DynamicImage;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use tiff::decoder::{Decoder, DecodingResult, Limits};

/// Numbers as they stand in a file.
#[derive(Clone, Debug)]
pub struct Scalars {
    /// Integers as such, floats as such.
    pub values: Image<f32>,
    /// The number that stands for 1: 255, 65535 ... of integers, or 1 of floats.
    pub full_scale: f64,
    /// Whether the file says how the camera was held; the values are upright then.
    pub has_orientation: bool,
}

impl Scalars {
    /// Floats, whose unit is their own.
    pub(crate) fn floats(values: Image<f32>) -> Self {
        Self { values, full_scale: 1.0, has_orientation: false }
    }

    /// Whether the numbers are floats.
    pub fn is_float(&self) -> bool {
        self.full_scale == 1.0
    }
}

/// Reads one number a pixel: an EXR's depth (or its layer called `layer`), a PFM, a NumPy
/// array, a TIFF of 8, 16, 32 or 64 bits, or the first channel of any other image, of 8 or
/// 16 bits. f32 holds all up to 24 bits exactly.
///
/// # Errors
///
/// The file, the cause and the remedy.
pub fn read_scalars(path: &Path, layer: Option<&str>) -> Result<Scalars, ImageError> {
    let start = read_start(path)?;
    if super::is_exr_start(&start) {
        return Ok(Scalars::floats(ExrPlanes::read(path)?.depth_alone(layer)?.0));
    }
    let undecodable = |detail: String| ImageError::Undecodable { file: path.to_owned(), detail };
    let whole = || std::fs::read(path).map_err(|source| ImageError::Unreadable { file: path.to_owned(), source });
    if npy::is_npy(&start) {
        let array = npy::parse(&whole()?).map_err(undecodable)?;
        return Ok(Scalars { values: array.values, full_scale: array.full_scale, has_orientation: false });
    }
    if pfm::is_pfm(&start) {
        return match pfm::parse(&whole()?).map_err(undecodable)? {
            Pfm::Grey(values) => Ok(Scalars::floats(values)),
            Pfm::Color(rgb) => Ok(Scalars::floats(rgb.map(|[first, ..]| first))),
        };
    }
    if matches!(start[..], [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..]) {
        return read_tiff(path);
    }
    let (image, orientation) = super::decode_with_orientation(path)?;
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
    let has_orientation = orientation != Orientation::NoTransforms;
    Ok(Scalars { values: Image { size, pixels }, full_scale, has_orientation })
}

/// The first of every `channels` samples.
fn every<T: Copy + Into<f32>>(samples: &[T], channels: usize) -> Vec<f32> {
    samples.iter().step_by(channels).map(|&sample| sample.into()).collect()
}

/// The image crate reads no TIFF of 32-bit grey: the decoder beneath it does.
fn read_tiff(path: &Path) -> Result<Scalars, ImageError> {
    let undecodable = |detail: String| ImageError::Undecodable { file: path.to_owned(), detail };
    let file = File::open(path).map_err(|source| ImageError::Unreadable { file: path.to_owned(), source })?;
    let mut decoder =
        Decoder::new(BufReader::new(file)).map_err(|e| undecodable(e.to_string()))?.with_limits(Limits::default());
    let (width, height) = decoder.dimensions().map_err(|e| undecodable(e.to_string()))?;
    check_size_to_read(path, u64::from(width), u64::from(height))?;
    let orientation = decoder.find_tag_unsigned::<u8>(tiff::tags::Tag::Orientation).ok().flatten();
    let orientation = orientation.and_then(Orientation::from_exif).unwrap_or(Orientation::NoTransforms);
    let decoded = decoder.read_image().map_err(|e| undecodable(e.to_string()))?;
    let pixels = width as usize * height as usize;
    // Samples of a pixel stand together: the first of each is taken.
    fn first<T: Copy>(samples: &[T], pixels: usize, value: impl Fn(T) -> f64) -> Vec<f32> {
        let channels = (samples.len() / pixels).max(1);
        samples.iter().step_by(channels).take(pixels).map(|&sample| value(sample) as f32).collect()
    }
    let (values, full_scale) = match &decoded {
        DecodingResult::U8(v) => (first(v, pixels, f64::from), f64::from(u8::MAX)),
        DecodingResult::U16(v) => (first(v, pixels, f64::from), f64::from(u16::MAX)),
        DecodingResult::U32(v) => (first(v, pixels, f64::from), f64::from(u32::MAX)),
        DecodingResult::U64(v) => (first(v, pixels, |v| v as f64), u64::MAX as f64),
        DecodingResult::I8(v) => (first(v, pixels, f64::from), f64::from(i8::MAX)),
        DecodingResult::I16(v) => (first(v, pixels, f64::from), f64::from(i16::MAX)),
        DecodingResult::I32(v) => (first(v, pixels, f64::from), f64::from(i32::MAX)),
        DecodingResult::I64(v) => (first(v, pixels, |v| v as f64), i64::MAX as f64),
        DecodingResult::F16(v) => (first(v, pixels, |v| v.to_f64()), 1.0),
        DecodingResult::F32(v) => (first(v, pixels, f64::from), 1.0),
        DecodingResult::F64(v) => (first(v, pixels, |v| v), 1.0),
    };
    if values.len() != pixels {
        return Err(undecodable(format!("{} of {pixels} samples", values.len())));
    }
    let stored = Image { size: UVec2::new(width, height), pixels: values };
    let has_orientation = orientation != Orientation::NoTransforms;
    Ok(Scalars { values: upright(&stored, orientation), full_scale, has_orientation })
}
