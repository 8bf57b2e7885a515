//! Depth of another size than its picture, with edges kept.
//!
//! A mean over an edge would be a depth at which nothing is. Samples that may belong to one
//! surface are interpolated in 1/depth, in which planes are linear; of samples that do not,
//! one is taken: the one whose place in the picture has the pixel's colour, so that the
//! edges of depth come to lie on those of the picture.

use super::encoding::Measured;
use crate::image::{ColorImage, Image};
use glam::{DVec2, UVec2, Vec3, dvec2};

/// Most that 1/depth may change between neighbouring samples of a surface, over the greater
/// of the two. A plane changes it by this much a sample only where it is seen at a glance:
/// at 1000 samples over 50 degrees, closer than half a degree to edge-on.
const SURFACE_STEP: f64 = 0.1;

/// Weight of a sample's distance (samples) against its difference in colour (linear, over
/// the mean of both): it decides where colours do not differ.
const DISTANCE_WEIGHT: f32 = 0.01;

/// Most by which the aspect ratios of depth and picture may differ beyond what rounding to
/// whole pixels explains.
const ASPECT_SLACK: f64 = 0.01;

/// Whether a depth map of `depth` px shows the same frame as a picture of `color` px.
pub(super) fn same_frame(color: UVec2, depth: UVec2) -> bool {
    let ratio = depth.as_dvec2() / color.as_dvec2();
    // Each side may have been rounded by a pixel of the smaller image.
    let rounding = 1.0 / f64::from(color.min(depth).min_element());
    (ratio.x / ratio.y).ln().abs() <= rounding + ASPECT_SLACK
}

/// The depths at the picture's pixels.
pub(super) fn to_size(measured: &[Measured], size: UVec2, color: &ColorImage) -> Vec<Measured> {
    let samples = Samples { measured, size, color: seen_by(color, size) };
    let scale = size.as_dvec2() / color.size.as_dvec2();
    let all = Image::from_fn(color.size, |x, y| {
        let at = (dvec2(f64::from(x), f64::from(y)) + 0.5) * scale - 0.5;
        if scale.min_element() >= 1.0 { samples.nearest(at) } else { samples.between(at, color.at(x, y)) }
    });
    all.pixels
}

/// The picture's colour at every sample of the depth: of the pixel at its centre.
fn seen_by(color: &ColorImage, size: UVec2) -> Image<Vec3> {
    let scale = color.size.as_dvec2() / size.as_dvec2();
    Image::from_fn(size, |x, y| {
        let at = (dvec2(f64::from(x), f64::from(y)) + 0.5) * scale;
        color.at_clamped(at.x as i64, at.y as i64)
    })
}

struct Samples<'a> {
    measured: &'a [Measured],
    size: UVec2,
    color: Image<Vec3>,
}

impl Samples<'_> {
    fn index(&self, x: i64, y: i64) -> usize {
        let (x, y) = (x.clamp(0, i64::from(self.size.x) - 1), y.clamp(0, i64::from(self.size.y) - 1));
        (y * i64::from(self.size.x) + x) as usize
    }

    fn nearest(&self, at: DVec2) -> Measured {
        self.measured[self.index(at.x.round() as i64, at.y.round() as i64)]
    }

    /// The depth at a place among four samples, given the colour that is seen there.
    fn between(&self, at: DVec2, color: Vec3) -> Measured {
        let corner = at.floor();
        let part = at - corner;
        let four = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| {
            let index = self.index(corner.x as i64 + dx, corner.y as i64 + dy);
            let near = dvec2(dx as f64, dy as f64);
            (index, (near - part).abs())
        });
        let inverse = four.map(|(index, _)| match self.measured[index] {
            Measured::Depth(depth_m) => f64::from(depth_m).recip(),
            Measured::Unknown | Measured::Damaged => f64::NAN,
        });
        let (least, greatest) = inverse.iter().fold((f64::INFINITY, 0.0_f64), |(lo, hi), &v| (lo.min(v), hi.max(v)));
        // NaN compares as false: what is unknown is no surface.
        let is_surface = inverse.iter().all(|v| v.is_finite()) && greatest - least <= SURFACE_STEP * greatest;
        if is_surface {
            let weighted = |(v, (_, away)): (&f64, &(usize, DVec2))| v * (1.0 - away.x) * (1.0 - away.y);
            let mean: f64 = inverse.iter().zip(&four).map(weighted).sum();
            return Measured::Depth(mean.recip() as f32);
        }
        let difference = |&(index, away): &(usize, DVec2)| {
            let own = self.color.pixels[index];
            let scale = (color.abs() + own.abs()).element_sum() / 6.0 + 1e-3;
            (color - own).length() / scale + DISTANCE_WEIGHT * away.length() as f32
        };
        let best = four.iter().min_by(|a, b| difference(a).total_cmp(&difference(b)));
        best.map_or(Measured::Damaged, |(index, _)| self.measured[*index])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A near square on a far slope, in a picture of 4 px a sample whose edges lie between
    /// the samples.
    #[test]
    fn edges_follow_the_picture_and_surfaces_are_smooth() {
        let inside = |x: u32, y: u32| (13..34).contains(&x) && (9..26).contains(&y);
        let slope = |x: f64| 1.0 / (0.2 + 0.001 * x);
        let color = Image::from_fn(UVec2::new(48, 36), |x, y| if inside(x, y) { Vec3::X } else { Vec3::splat(0.2) });
        let small = UVec2::new(12, 9);
        let measured = Image::from_fn(small, |x, y| {
            let centre = |i: u32| f64::from(i) * 4.0 + 2.0;
            let depth_m = if inside(4 * x + 2, 4 * y + 2) { 1.0 } else { slope(centre(x) - 0.5) };
            Measured::Depth(depth_m as f32)
        });
        let large = to_size(&measured.pixels, small, &color);
        for (i, found) in large.iter().enumerate() {
            let (x, y) = (i as u32 % 48, i as u32 / 48);
            let Measured::Depth(found) = found else { panic!("{found:?}") };
            // At the margin there is no second sample to interpolate with, and beside an
            // edge one sample stands for up to a sample's width.
            let expected = if inside(x, y) { 1.0 } else { slope(f64::from(x)) };
            let off = (f64::from(*found) / expected - 1.0).abs();
            assert!(off < 0.02, "{found} for {expected} at {x}, {y}");
        }
        assert_eq!(to_size(&measured.pixels, small, &Image::filled(UVec2::new(6, 5), Vec3::ONE)).len(), 30);
    }

    #[test]
    fn frames_are_told_apart() {
        let size = UVec2::new;
        assert!(same_frame(size(640, 480), size(320, 240)) && same_frame(size(1023, 767), size(512, 384)));
        assert!(!same_frame(size(640, 480), size(640, 360)) && !same_frame(size(8, 6), size(6, 8)));
    }
}
