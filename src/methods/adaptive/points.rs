//! Lens points that differ from pixel to pixel, and by pixel only: noise that stays where
//! it is.

use crate::aperture::Aperture;
use glam::{DVec2, dvec2};
use std::f64::consts::{FRAC_PI_4, TAU};

/// The golden angle, radians.
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;

/// Lens points of all 8x8 pixels of a tile, row by row: the first of each pixel, then the second of each,
/// up to `count` by which a pixel's picture is made, and then those that noisy tiles add, `count` at a
/// time and `most` in all.
///
/// Each of the sets is a Vogel spiral turned by interleaved gradient noise (Jimenez,
/// "Next Generation Post Processing in Call of Duty: Advanced Warfare", 2014), taken from
/// the disc to the aperture. Without `rotate` all pixels share them. Every set, and every
/// `frame`, has other angles and radii, as far from those before as can be: steps of Roberts's R2 sequence ("The
/// Unreasonable Effectiveness of Quasirandom Sequences", 2018).
pub fn lens_points(aperture: &Aperture, count: u32, most: u32, rotate: bool, frame: u32) -> Vec<[f32; 2]> {
    let pixel_points = |pixel: u32| {
        let noise = if rotate { gradient_noise(pixel % 8, pixel / 8) } else { 0.0 };
        let sets = most.div_ceil(count.max(1));
        (0..sets).flat_map(move |set| {
            let sequence = f64::from(frame * sets + set);
            let turn = noise + (sequence * 0.569_840_290_998_053_3).fract();
            let ring = (0.5 + sequence * 0.754_877_666_246_692_7).fract();
            (0..count.min(most - set * count)).map(move |i| {
                let radius = ((f64::from(i) + ring) / f64::from(count)).sqrt();
                let angle = GOLDEN_ANGLE * f64::from(i) + TAU * turn;
                radius * dvec2(angle.cos(), angle.sin())
            })
        })
    };
    let on_aperture = |disc: DVec2| {
        let v = if *aperture == Aperture::Disc { disc } else { aperture.map_square(square_from_disc(disc)) };
        v.as_vec2().to_array()
    };
    let of_pixels: Vec<Vec<[f32; 2]>> = (0..64).map(|pixel| pixel_points(pixel).map(on_aperture).collect()).collect();
    (0..most.max(count) as usize)
        .flat_map(|i| of_pixels.iter().filter_map(move |points| points.get(i).copied()))
        .collect()
}

fn gradient_noise(x: u32, y: u32) -> f64 {
    (52.982_918_9 * (0.067_110_56 * f64::from(x) + 0.005_837_15 * f64::from(y)).fract()).fract()
}

/// The inverse of Shirley and Chiu's concentric map, which `Aperture::map_square` begins
/// with.
fn square_from_disc(disc: DVec2) -> DVec2 {
    let radius = disc.length();
    let p = if radius == 0.0 {
        DVec2::ZERO
    } else if disc.x.abs() > disc.y.abs() {
        let x = radius.copysign(disc.x);
        dvec2(x, x / FRAC_PI_4 * (disc.y / disc.x).atan())
    } else {
        let y = radius.copysign(disc.y);
        dvec2(y / FRAC_PI_4 * (disc.x / disc.y).atan(), y)
    };
    0.5 * (p + DVec2::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_square_map_is_inverted() {
        for i in 0..200 {
            let angle = f64::from(i);
            let disc = (f64::from(i) / 200.0) * dvec2(angle.cos(), angle.sin());
            let back = Aperture::Disc.map_square(square_from_disc(disc));
            assert!((back - disc).length() < 1e-12, "{disc} becomes {back}");
        }
    }
}
