//! Where the rays of a tile meet nothing: the nearest surface around places in a grid over all that they
//! pass, which each workgroup takes from [`Peeled::nearest`](crate::view::Peeled::nearest) into its memory.

use super::tiles::TILE_PX;
use crate::aperture::Aperture;
use crate::lens::Lens;
use crate::view::{NEAREST_REACH_PX, SAMPLE_SLACK_PX};

/// Places of the grid on each side: `GRID_SIDE` in `shaders/lib/nearest_grid.wgsl`. With a place every two
/// pixels that is enough for rays of 28 px, and takes 4.6 of the 16 kB that every adapter has.
const GRID_SIDE: u32 = 34;

/// The grid over what the rays of a tile pass.
pub(super) struct NearestGrid {
    /// Layer of the view's nearest depths.
    pub layer: u32,
    /// Distance of places, px: even.
    pub spacing_px: u32,
    /// How far from the tile the first place lies to the left and above, px.
    pub margin_px: u32,
    /// How far around a place, px, all is known that a ray may meet there; 0 if nothing is.
    pub reach_px: f64,
}

impl NearestGrid {
    /// For surfaces of CoC radii in `radii_px`, px, seen by rays that lie up to `bend_px` beside a straight
    /// line.
    pub fn new(lens: &Lens, radii_px: [f64; 2], bend_px: f64) -> Self {
        let greatest_px = radii_px.map(f64::abs).into_iter().fold(0.0, f64::max);
        let longest_px = (greatest_px + 0.5 * lens.greatest_astigmatism_px()) * lens.aperture.radius();
        // Rays ask ahead of where they are, but never farther than they go and the reach.
        let passed_px = |reach_px: f64| (longest_px + reach_px + 1.0).ceil() as u32;
        let grid = |layer: usize, spacing_px: u32| {
            // A place is half the spacing away at most, and knows the pixels so far around its own.
            let known_px = f64::from(NEAREST_REACH_PX[layer]) - SAMPLE_SLACK_PX - f64::from(spacing_px / 2);
            let reach_px = (known_px - bend_px).max(0.0);
            Self { layer: layer as u32, spacing_px, margin_px: passed_px(reach_px), reach_px }
        };
        let fits = |grid: &Self| GRID_SIDE * grid.spacing_px >= TILE_PX + 2 * grid.margin_px;
        let finest = grid(0, 2);
        if fits(&finest) {
            return finest;
        }
        let mut coarser = (4..=2 * NEAREST_REACH_PX[1]).step_by(2).map(|spacing_px| grid(1, spacing_px));
        coarser.find(fits).unwrap_or(Self { reach_px: 0.0, ..finest })
    }
}

/// How far, px, a ray whose hits are filtered lies at most beside the straight line that it would be,
/// for filters from `sharp_s` and wider ones from `narrow_s` on: `place_on_ray` in
/// `shaders/lib/lens_rays.wgsl`.
pub(super) fn bend_px(aperture: &Aperture, sharp_s: f32, narrow_s: f32) -> f64 {
    let lens_variance = (aperture.sigma_per_coc() / 0.25).powi(2);
    // Four times the variances of the two filters, px^2: NARROW_BLUR and WIDE_BLUR in the shader.
    let of_filter = |blur: f64, from_s: f32| {
        let blur = blur / lens_variance;
        // At most nine tenths of the blur are taken off, up to this s; from there on ever less.
        let s = f64::from(from_s).max((blur / 0.9).sqrt());
        s * (1.0 - (1.0 - (blur / (s * s)).min(0.9)).sqrt())
    };
    aperture.radius() * of_filter(2.0, sharp_s).max(of_filter(6.0, narrow_s))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_lens_has_a_grid_that_holds_its_rays() {
        for radius_px in [0.1, 4.0, 13.0, 28.0, 60.0, 108.0, 160.0] {
            for aperture in [Aperture::Disc, Aperture::Polygon { blades: 4, rotation_deg: 0.0, roundness: 0.0 }] {
                let lens = Lens { aperture, ..Lens::PINHOLE };
                let grid = NearestGrid::new(&lens, [-0.5 * radius_px, radius_px], 0.64);
                let held_px = GRID_SIDE * grid.spacing_px;
                assert!(grid.reach_px > 0.0, "{radius_px} px: rays step through all");
                assert!(f64::from(held_px) >= 8.0 + 2.0 * radius_px * lens.aperture.radius(), "{radius_px} px");
            }
        }
    }

    #[test]
    fn rays_are_bent_by_less_than_their_filters_are_wide() {
        // The filters of 16 points: [1 2 1] / 4 from 3 px and [1 2 2 2 1] / 8 from 12 px on.
        let disc = bend_px(&Aperture::Disc, 3.0, 12.0);
        assert!((0.2..0.7).contains(&disc), "{disc}");
        assert_eq!(bend_px(&Aperture::Disc, f32::MAX, f32::MAX), 0.0);
    }
}
