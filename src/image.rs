//! Images on the CPU: row-major pixels with the origin at the top left.

use glam::{UVec2, Vec3};

/// A row-major image of any pixel type.
#[derive(Clone, Debug, PartialEq)]
pub struct Image<T> {
    /// Width and height in pixels.
    pub size: UVec2,
    /// `size.x * size.y` pixels, rows from top to bottom.
    pub pixels: Vec<T>,
}

/// Linear Rec. 709 colour, scene-referred: values above 1 are meant.
pub type ColorImage = Image<Vec3>;

/// Depth along the optical axis in metres; infinity where nothing is.
pub type DepthImage = Image<f32>;

impl<T: Copy> Image<T> {
    /// An image of one value.
    pub fn filled(size: UVec2, value: T) -> Self {
        Self { size, pixels: vec![value; size.x as usize * size.y as usize] }
    }

    /// An image computed pixel by pixel from integer coordinates `(x, y)`.
    pub fn from_fn(size: UVec2, mut f: impl FnMut(u32, u32) -> T) -> Self {
        let pixels = (0..size.y).flat_map(|y| (0..size.x).map(move |x| (x, y))).map(|(x, y)| f(x, y)).collect();
        Self { size, pixels }
    }

    /// The pixel at `(x, y)`. Panics outside the image.
    pub fn at(&self, x: u32, y: u32) -> T {
        assert!(x < self.size.x && y < self.size.y, "pixel ({x}, {y}) is outside an image of {}", self.size);
        self.pixels[(y * self.size.x + x) as usize]
    }

    /// The pixel at `(x, y)`, with coordinates outside clamped to the border.
    pub fn at_clamped(&self, x: i64, y: i64) -> T {
        let x = x.clamp(0, i64::from(self.size.x) - 1) as u32;
        let y = y.clamp(0, i64::from(self.size.y) - 1) as u32;
        self.at(x, y)
    }

    /// The same image with every pixel replaced.
    pub fn map<U: Copy>(&self, f: impl FnMut(T) -> U) -> Image<U> {
        Image { size: self.size, pixels: self.pixels.iter().copied().map(f).collect() }
    }

    /// The part of the image that starts at `origin`. Panics if it does not lie inside.
    pub fn crop(&self, origin: UVec2, size: UVec2) -> Self {
        Self::from_fn(size, |x, y| self.at(origin.x + x, origin.y + y))
    }
}
