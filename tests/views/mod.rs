//! Views of small images whose CoC is given, for tests of methods.

#![allow(dead_code, reason = "every test binary compiles this module and uses its own part of it")]

use crate::common::gpu;
use defocus::gpu::Precision;
use defocus::image::{ColorImage, DepthImage, Image};
use defocus::lens::Lens;
use defocus::methods::{self, Method};
use defocus::view::View;
use glam::{UVec2, Vec3};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Held by a test for as long as it uses the GPU. A texture that a method has dropped can
/// be handed out again before the frame that uses it is submitted, so threads that share
/// the device's pool of textures must take turns.
pub fn turn() -> MutexGuard<'static, ()> {
    static TURN: Mutex<()> = Mutex::new(());
    // A test that failed holding it says nothing about the others.
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Depths at which `lens` blurs by the signed diameters, px; all must lie below K.
pub fn depths_of(lens: &Lens, coc_px: &Image<f32>) -> DepthImage {
    coc_px.map(|c| lens.coc().depth_at(f64::from(c)) as f32)
}

pub fn view_of(color: &ColorImage, depth_m: &DepthImage) -> View {
    View::of_image(gpu(), color, depth_m, 1.0).expect("a small image fits")
}

/// What `method` makes of `view`, with intermediates of the given precision.
pub fn render(method: &dyn Method, view: &mut View, lens: &Lens, precision: Precision) -> ColorImage {
    let mut frame = gpu().frame();
    frame.precision = precision;
    let texture = methods::record(method, &mut frame, view, lens).expect("the lens is good");
    frame.finish();
    defocus::gpu::download(gpu(), &texture)
}

/// The result for an image with the given CoC, in f16.
pub fn blurred(method: &dyn Method, color: &ColorImage, lens: &Lens, coc_px: &Image<f32>) -> ColorImage {
    render(method, &mut view_of(color, &depths_of(lens, coc_px)), lens, Precision::Half)
}

/// A white point of `brightness` on black, in the middle.
pub fn point(size: UVec2, brightness: f32) -> ColorImage {
    let middle = size / 2;
    ColorImage::from_fn(size, |x, y| if UVec2::new(x, y) == middle { Vec3::splat(brightness) } else { Vec3::ZERO })
}

/// Colours that differ from pixel to pixel, in [0, 1).
pub fn noise(size: UVec2) -> ColorImage {
    let hash = |i: u32| (i.wrapping_mul(2_654_435_761) >> 8 & 0xffff) as f32 / 65536.0;
    ColorImage::from_fn(size, |x, y| {
        let i = 3 * (y * size.x + x);
        Vec3::new(hash(i), hash(i + 1), hash(i + 2))
    })
}

pub fn mirrored<T: Copy>(image: &Image<T>) -> Image<T> {
    Image::from_fn(image.size, |x, y| image.at(image.size.x - 1 - x, y))
}

/// Sum of the red channel.
pub fn energy(image: &ColorImage) -> f64 {
    image.pixels.iter().map(|p| f64::from(p.x)).sum()
}

/// Variance per axis, px^2, of the red channel's distribution.
pub fn variance_px2(image: &ColorImage) -> [f64; 2] {
    let mut sums = [[0.0; 2]; 2];
    let total = energy(image);
    for (i, p) in image.pixels.iter().enumerate() {
        let at = [i as u32 % image.size.x, i as u32 / image.size.x].map(f64::from);
        for axis in 0..2 {
            sums[0][axis] += f64::from(p.x) * at[axis] / total;
            sums[1][axis] += f64::from(p.x) * at[axis] * at[axis] / total;
        }
    }
    [0, 1].map(|axis| sums[1][axis] - sums[0][axis] * sums[0][axis])
}

/// Greatest difference between two images over all channels.
pub fn greatest_difference(a: &ColorImage, b: &ColorImage) -> f32 {
    a.pixels.iter().zip(&b.pixels).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max)
}
