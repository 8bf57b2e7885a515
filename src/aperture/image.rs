//! An aperture given as an image.

use super::ApertureError;
use glam::{DVec2, UVec2, dvec2};
use std::path::Path;

/// Longer side of an aperture image, px. Larger images are reduced when read: a finer
/// aperture cannot be seen, and saved states hold the pixels.
pub const MAX_SIDE_PX: u32 = 256;

/// The pixels of an aperture, ready for sampling.
///
/// The image's longer side spans the diameter of the unit circle; pixels are square and
/// each has one intensity. All positions are relative to the image's centroid.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "Stored", into = "Stored")]
pub struct ApertureImage {
    name: String,
    size: UVec2,
    pixels: Vec<f32>,
    /// Running sums of the rows' totals, one more than there are rows.
    row_sums: Vec<f64>,
    /// Running sums within each row, `size.x + 1` a row.
    column_sums: Vec<f64>,
    centroid_px: DVec2,
    sigma: f64,
    radius: f64,
}

/// What a saved state holds; the rest follows from it.
#[derive(serde::Serialize, serde::Deserialize)]
struct Stored {
    name: String,
    size: UVec2,
    pixels: Vec<f32>,
}

impl TryFrom<Stored> for ApertureImage {
    type Error = ApertureError;
    fn try_from(stored: Stored) -> Result<Self, ApertureError> {
        Self::new(stored.name, stored.size, stored.pixels)
    }
}

impl From<ApertureImage> for Stored {
    fn from(image: ApertureImage) -> Self {
        Self { name: image.name, size: image.size, pixels: image.pixels }
    }
}

/// Serialises an [`ApertureImage`] behind an `Arc`.
pub(super) mod shared {
    use super::ApertureImage;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};
    use std::sync::Arc;

    pub fn serialize<S: Serializer>(image: &Arc<ApertureImage>, serializer: S) -> Result<S::Ok, S::Error> {
        image.as_ref().serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Arc<ApertureImage>, D::Error> {
        ApertureImage::deserialize(deserializer).map(Arc::new)
    }
}

impl ApertureImage {
    /// An aperture from `size.x * size.y` intensities (rows from top to bottom, any scale).
    ///
    /// Errors if their number is not that, a side is 0 or above [`MAX_SIDE_PX`], one is
    /// negative or not finite, or all are 0.
    pub fn new(name: impl Into<String>, size: UVec2, pixels: Vec<f32>) -> Result<Self, ApertureError> {
        let name = name.into();
        let bad = |name: &str, cause: String| Err(ApertureError::BadImage { name: name.into(), cause });
        if size.min_element() == 0 || size.max_element() > MAX_SIDE_PX {
            return bad(&name, format!("is {} x {} px: sides must be 1 to {MAX_SIDE_PX} px", size.x, size.y));
        }
        if pixels.len() != (size.x * size.y) as usize {
            return bad(&name, format!("has {} pixels for a size of {} x {}", pixels.len(), size.x, size.y));
        }
        if pixels.iter().any(|p| !(p.is_finite() && *p >= 0.0)) {
            return bad(&name, "has negative or non-finite pixels: intensities must be 0 or more".into());
        }
        if pixels.iter().all(|p| *p == 0.0) {
            return bad(&name, "is black, so no light passes: paint the opening in white".into());
        }
        Ok(Self::with_sums(name, size, pixels))
    }

    fn with_sums(name: String, size: UVec2, pixels: Vec<f32>) -> Self {
        let width = size.x as usize;
        let column_sums: Vec<f64> = pixels.chunks_exact(width).flat_map(running_sums).collect();
        let mut row_sums = vec![0.0];
        for row in column_sums.chunks_exact(width + 1) {
            row_sums.push(row_sums[row_sums.len() - 1] + row[width]);
        }
        let mut image =
            Self { name, size, pixels, row_sums, column_sums, centroid_px: DVec2::ZERO, sigma: 0.0, radius: 0.0 };
        image.centroid_px = image.mean_of(|p| p);
        // A pixel's own extent adds its variance, 1/12 px^2 per axis.
        let variance_px = image.mean_of(|p| (p - image.centroid_px).powf(2.0)) + DVec2::splat(1.0 / 12.0);
        image.sigma = (0.5 * variance_px.element_sum()).sqrt() * image.unit_per_px();
        image.radius = image.farthest_px() * image.unit_per_px();
        image
    }

    /// Reads a PNG, JPEG or HDR image: brightness times alpha, the stored values taken as
    /// linear intensities (white is open, black is closed, mid-grey passes half).
    pub fn load(path: &Path) -> Result<Self, ApertureError> {
        let name = path.display().to_string();
        let unreadable = |cause: String| ApertureError::Unreadable { path: name.clone(), cause };
        let reader = ::image::ImageReader::open(path).map_err(|e| unreadable(e.to_string()))?;
        let reader = reader.with_guessed_format().map_err(|e| unreadable(e.to_string()))?;
        let decoded = reader.decode().map_err(|e| unreadable(e.to_string()))?;
        let decoded = if decoded.width().max(decoded.height()) > MAX_SIDE_PX {
            decoded.resize(MAX_SIDE_PX, MAX_SIDE_PX, ::image::imageops::FilterType::Triangle)
        } else {
            decoded
        };
        let size = UVec2::new(decoded.width(), decoded.height());
        let rgba = decoded.into_rgba32f();
        // Rec. 709 luminance: for the usual grey image just its value.
        let brightness = |p: &::image::Rgba<f32>| (0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2]) * p[3];
        Self::new(name, size, rgba.pixels().map(brightness).collect())
    }

    /// The file or name it was made from.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Size, px.
    pub fn size(&self) -> UVec2 {
        self.size
    }

    /// Intensities, rows from top to bottom, not normalised.
    pub fn pixels(&self) -> &[f32] {
        &self.pixels
    }

    /// The centroid, px from the top left corner: where `v = 0` lies.
    pub fn centroid_px(&self) -> DVec2 {
        self.centroid_px
    }

    /// Length of a pixel's side in the coordinates of `v`.
    pub(crate) fn unit_per_px(&self) -> f64 {
        2.0 / f64::from(self.size.max_element())
    }

    fn total(&self) -> f64 {
        self.row_sums[self.row_sums.len() - 1]
    }

    fn lit_pixels(&self) -> impl Iterator<Item = (DVec2, f64)> {
        let width = self.size.x as usize;
        let lit = self.pixels.iter().enumerate().filter(|(_, weight)| **weight > 0.0);
        lit.map(move |(i, weight)| (dvec2((i % width) as f64 + 0.5, (i / width) as f64 + 0.5), f64::from(*weight)))
    }

    fn mean_of(&self, f: impl Fn(DVec2) -> DVec2) -> DVec2 {
        self.lit_pixels().map(|(p, weight)| f(p) * weight).sum::<DVec2>() / self.total()
    }

    /// Distance from the centroid to the farthest corner of a pixel that passes light, px.
    fn farthest_px(&self) -> f64 {
        let corner = |p: DVec2| ((p - self.centroid_px).abs() + 0.5).length();
        self.lit_pixels().map(|(p, _)| corner(p)).fold(0.0, f64::max)
    }

    pub(super) fn sigma(&self) -> f64 {
        self.sigma
    }

    pub(super) fn radius(&self) -> f64 {
        self.radius
    }

    pub(super) fn intensity(&self, v: DVec2) -> f64 {
        let p = (v / self.unit_per_px() + self.centroid_px).floor();
        if p.min_element() < 0.0 || p.x >= f64::from(self.size.x) || p.y >= f64::from(self.size.y) {
            return 0.0;
        }
        let weight = self.pixels[p.y as usize * self.size.x as usize + p.x as usize];
        f64::from(weight) / (self.total() * self.unit_per_px() * self.unit_per_px())
    }

    /// Inverse of the cumulative distribution: the row by `u.y`, the column within it by
    /// `u.x`; what is left of either places the point inside the pixel.
    pub(super) fn map_square(&self, u: DVec2) -> DVec2 {
        let (row, inside_y) = invert(&self.row_sums, u.y);
        let width = self.size.x as usize + 1;
        let (column, inside_x) = invert(&self.column_sums[row * width..(row + 1) * width], u.x);
        let p = dvec2(column as f64 + inside_x, row as f64 + inside_y);
        (p - self.centroid_px) * self.unit_per_px()
    }
}

/// Sums of the first 0, 1, 2, ... values.
fn running_sums(values: &[f32]) -> Vec<f64> {
    let mut sums = vec![0.0];
    sums.extend(values.iter().scan(0.0, |sum, value| {
        *sum += f64::from(*value);
        Some(*sum)
    }));
    sums
}

/// The interval of the running sums in which the share `u` of the whole lies, and where in
/// it, both in [0, 1). Intervals of no weight are never chosen.
fn invert(sums: &[f64], u: f64) -> (usize, f64) {
    let target = u * sums[sums.len() - 1];
    // u < 1 keeps the target below the last sum but for rounding, which would step past
    // the last interval with weight.
    let last = sums.partition_point(|sum| *sum < sums[sums.len() - 1]);
    let above = sums.partition_point(|sum| *sum <= target).clamp(1, last);
    let (low, high) = (sums[above - 1], sums[above]);
    (above - 1, ((target - low) / (high - low)).clamp(0.0, 1.0))
}
