//! Depth inside a JPEG, as phones store it: GDepth (base64 in XMP), Dynamic Depth (an image behind the
//! picture, named by a directory in XMP) and Apple's (an image behind the picture, named by the
//! Multi-Picture Format, that says in its own XMP what it is).
//!
//! Sources: Google, "Depth Map Metadata" (2014) and "Dynamic Depth v1.0" (2019); CIPA DC-007, "Multi-
//! Picture Format"; Adobe, "XMP Specification Part 3" for XMP over several segments.

mod jpeg;
mod xmp;

use super::error::MAX_PIXELS;
use crate::image::Image;
use base64::Engine;
use glam::UVec2;
use image::{DynamicImage, ImageReader};
use jpeg::Segments;
use std::io::Cursor;
use xmp::Properties;

/// A depth map found in a picture's file.
pub struct Embedded {
    /// Its numbers as they are stored, in the orientation in which the picture is stored.
    pub values: Image<f32>,
    /// The number that stands for 1: 255 or 65535.
    pub full_scale: f64,
    /// What the numbers mean, where the file says so.
    pub range: Option<Range>,
}

/// What the numbers of an embedded depth map mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Distance at number 0, or its inverse where `unit` says so.
    pub near: f64,
    /// Distance at the number for 1, or its inverse.
    pub far: f64,
    /// Whether numbers are spaced evenly in the inverse of the unit.
    pub is_inverse: bool,
    /// Whether `near` and `far` are metres or their inverse.
    pub unit: Unit,
    /// Whether distances are along each pixel's ray instead of along the axis.
    pub along_ray: bool,
}

/// What a number counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Metres, or a unit that the file does not name.
    Metres,
    /// Inverse metres.
    Dioptres,
}

impl Range {
    /// Metres at a share in [0, 1] of the full scale; infinite at 0 dioptres.
    pub fn metres_at(&self, share: f64) -> f64 {
        let (near, far) = (self.near, self.far);
        let value = if self.is_inverse {
            // GDepth, RangeInverse: 0 is near and 1 far.
            far * near / (far - share * (far - near))
        } else {
            near + share * (far - near)
        };
        match self.unit {
            Unit::Metres => value,
            Unit::Dioptres => 1.0 / value.max(0.0),
        }
    }

    fn is_usable(&self) -> bool {
        let both = [self.near, self.far];
        both.iter().all(|at| at.is_finite() && *at >= 0.0) && both.iter().any(|at| *at > 0.0)
    }
}

/// The depth map in the bytes of a JPEG; `None` where there is none.
///
/// # Errors
///
/// What is wrong with a depth map that is there.
pub fn find(bytes: &[u8]) -> Result<Option<Embedded>, String> {
    let Some(segments) = Segments::of(bytes) else { return Ok(None) };
    let properties = Properties::of(&segments.xmp());
    if let Some(data) = properties.get("GDepth:Data") {
        return gdepth(&properties, data).map(Some);
    }
    if let Some(depth) = dynamic_depth(bytes, &segments, &properties)? {
        return Ok(Some(depth));
    }
    apple(bytes, &segments)
}

fn gdepth(properties: &Properties, data: &str) -> Result<Embedded, String> {
    let encoded: Vec<u8> = data.bytes().filter(|byte| !byte.is_ascii_whitespace() && *byte != b'=').collect();
    let bytes = base64::engine::general_purpose::STANDARD_NO_PAD
        .decode(encoded)
        .map_err(|e| format!("the base64 of its GDepth data is damaged: {e}"))?;
    let (values, full_scale) = decode(&bytes)?;
    let range = range(properties, "GDepth");
    Ok(Embedded { values, full_scale, range })
}

/// The range by attributes of GDepth or of a DepthMap of Dynamic Depth, which are called alike.
fn range(properties: &Properties, prefix: &str) -> Option<Range> {
    let text = |name: &str| properties.get(&format!("{prefix}:{name}"));
    let number = |name: &str| text(name)?.trim().parse::<f64>().ok();
    let unit = match text("Units").map(|unit| unit.trim().to_lowercase()) {
        Some(unit) if ["d", "diopters", "dioptres", "diopter"].contains(&unit.as_str()) => Unit::Dioptres,
        _ => Unit::Metres,
    };
    let range = Range {
        near: number("Near")?,
        far: number("Far")?,
        is_inverse: text("Format").is_some_and(|format| format.trim().eq_ignore_ascii_case("RangeInverse")),
        unit,
        along_ray: text("MeasureType").is_some_and(|kind| kind.trim().eq_ignore_ascii_case("OpticRay")),
    };
    range.is_usable().then_some(range)
}

/// The directory of Dynamic Depth lists what lies behind the picture, one behind the other.
fn dynamic_depth(bytes: &[u8], segments: &Segments, properties: &Properties) -> Result<Option<Embedded>, String> {
    let items = properties.items();
    let is_depth = |item: &Properties| {
        let semantic = item.get("Item:Semantic").unwrap_or_default().to_lowercase();
        let uri = item.get("Item:DataURI").unwrap_or_default().to_lowercase();
        semantic == "depth" || semantic == "depthmap" || uri.ends_with("depthmap")
    };
    let Some(index) = items.iter().position(is_depth) else { return Ok(None) };
    let length_of = |item: &Properties, name: &str| {
        let text = item.get(name).unwrap_or("0").trim();
        text.parse::<usize>().map_err(|_| format!("its directory has the length {}", text.escape_debug()))
    };
    let length = length_of(&items[index], "Item:Length")?;
    let mut behind = length;
    for item in &items[index + 1..] {
        behind = behind
            .checked_add(length_of(item, "Item:Length")?)
            .and_then(|sum| sum.checked_add(length_of(item, "Item:Padding").unwrap_or(0)))
            .ok_or("its directory has lengths beyond all files")?;
    }
    // Counted from the end: the length of the picture itself is left out of the directory.
    let by_directory = bytes.len().checked_sub(behind).and_then(|start| bytes.get(start..start.checked_add(length)?));
    let by_format = || segments.pictures(bytes).into_iter().find(|picture| picture.len() == length);
    let found = by_directory.filter(|bytes| begins_like_an_image(bytes)).or_else(by_format);
    let found = found.ok_or("its directory names a depth map that is not in the file; copy the file again")?;
    let (values, full_scale) = decode(found)?;
    Ok(Some(Embedded { values, full_scale, range: range(properties, "DepthMap") }))
}

/// An image behind the picture that says of itself that it is disparity or depth.
fn apple(bytes: &[u8], segments: &Segments) -> Result<Option<Embedded>, String> {
    for picture in segments.pictures(bytes) {
        let Some(own) = Segments::of(picture) else { continue };
        let properties = Properties::of(&own.xmp());
        let kind = properties.get("apdi:AuxiliaryImageType").unwrap_or_default().to_lowercase();
        if kind != "disparity" && kind != "depth" {
            continue;
        }
        let number = |name: &str| properties.get(name)?.trim().parse::<f64>().ok();
        let bounds = number("apdi:FloatMinValue").zip(number("apdi:FloatMaxValue"));
        let unit = if kind == "depth" { Unit::Metres } else { Unit::Dioptres };
        let range = bounds.map(|(near, far)| Range { near, far, is_inverse: false, unit, along_ray: false });
        let (values, full_scale) = decode(picture)?;
        return Ok(Some(Embedded { values, full_scale, range: range.filter(Range::is_usable) }));
    }
    Ok(None)
}

fn begins_like_an_image(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0xff, 0xd8]) || bytes.starts_with(b"\x89PNG") || bytes.starts_with(b"RIFF")
}

/// The first channel of an image, and the number that stands for 1.
fn decode(bytes: &[u8]) -> Result<(Image<f32>, f64), String> {
    let open = || ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| e.to_string());
    let broken = |e: image::ImageError| format!("its depth map does not decode: {e}");
    let (width, height) = open()?.into_dimensions().map_err(broken)?;
    if u64::from(width) * u64::from(height) > MAX_PIXELS || width == 0 || height == 0 {
        return Err(format!("its depth map has {width} x {height} pixels"));
    }
    let decoded = open()?.decode().map_err(broken)?;
    let size = UVec2::new(width, height);
    Ok(match decoded {
        DynamicImage::ImageLuma16(_) | DynamicImage::ImageRgb16(_) | DynamicImage::ImageRgba16(_) => {
            let first = decoded.into_rgb16();
            (Image { size, pixels: first.pixels().map(|pixel| f32::from(pixel[0])).collect() }, 65535.0)
        }
        _ => {
            let first = decoded.into_rgb8();
            (Image { size, pixels: first.pixels().map(|pixel| f32::from(pixel[0])).collect() }, 255.0)
        }
    })
}
