//! The parameters of `gather`, and what its shader is told.

use super::super::{IN_FOCUS_COC_PX, Param};
use super::grid::{Grid, Scope};
use crate::aperture::Aperture;
use crate::lens::Lens;
use crate::uniform;
use crate::view::LensUniform;
use std::f64::consts::PI;

/// Sides of the image that is gathered from, over those of the picture.
pub const RESOLUTIONS: &[&str] = &["1", "1/2"];

/// What the gathered layers are filtered with.
pub const POST_FILTERS: &[&str] = &["off", "median", "mean"];

/// Ring gather with the sources' choices as parameters.
#[derive(Clone, Debug)]
pub struct Gather {
    /// Rings of taps, 2 to 5: 1 + 4n(n+1) taps with the one in the middle.
    pub rings: u32,
    /// Index among the choices of the parameter of this name.
    pub resolution: usize,
    /// Whether pixels of a texel count by how like the widest their CoC is.
    pub prefilter: bool,
    /// Whether tiles that need nothing, or no comparisons, are left out.
    pub tiles: bool,
    /// Whether foreground spreads over what is sharper behind it.
    pub near: bool,
    /// Whether what is behind fills what a blurred foreground leaves open.
    pub fill: bool,
    /// Whether slight blur is gathered at full resolution.
    pub slight: bool,
    /// Whether bright pixels are drawn as sprites.
    pub sprites: bool,
    /// Radiance above which a pixel can be one.
    pub sprite_threshold: f32,
    /// Index among the choices of the parameter of this name.
    pub post_filter: usize,
}

impl Default for Gather {
    fn default() -> Self {
        Self {
            rings: 3,
            resolution: 1,
            prefilter: true,
            tiles: true,
            near: true,
            fill: true,
            slight: true,
            sprites: true,
            sprite_threshold: 1.0,
            post_filter: 0,
        }
    }
}

impl Gather {
    pub(super) fn list(&mut self) -> Vec<Param<'_>> {
        vec![
            Param::int(
                "rings",
                "Rings",
                "",
                &mut self.rings,
                (2, 5),
                "Rings of taps around the middle one: 25, 49, 81 or 121 taps in all.",
            )
            .trading(&["2", "3", "5"]),
            Param::choice(
                "resolution",
                "Resolution",
                &mut self.resolution,
                RESOLUTIONS,
                "Sides of the image that is gathered from: 1/2 is what engines ship, 1 takes about three times as long.",
            )
            .trading(RESOLUTIONS),
            Param::switch(
                "prefilter",
                "Prefilter by CoC",
                &mut self.prefilter,
                "Texels of the reduced image are means of pixels whose CoC is like the widest among them; off: of all of them.",
            ),
            Param::switch(
                "tiles",
                "Tile classes",
                &mut self.tiles,
                "Tiles in focus are left out, those of one blur are added up without comparisons; off: all are treated as mixed.",
            ),
            Param::switch(
                "near",
                "Near field",
                &mut self.near,
                "Foreground spreads over what is behind it, with an alpha; off: it ends at its outline.",
            ),
            Param::switch(
                "fill",
                "Fill",
                &mut self.fill,
                "What is behind fills what a blurred foreground leaves open inside of its outline; off: foreground is opaque there.",
            ),
            Param::switch(
                "slight",
                "Slight blur",
                &mut self.slight,
                "Blur of up to 3 px is gathered from 3x3 pixels of the full image; off: from the pixel alone, at half resolution.",
            ),
            Param::switch(
                "sprites",
                "Sprites",
                &mut self.sprites,
                "Pixels far brighter than their surroundings are drawn as blur spots instead of being met by some taps.",
            )
            .trading(&["off", "on"]),
            Param::float(
                "sprite_threshold",
                "Sprites from",
                "",
                &mut self.sprite_threshold,
                (0.0, 100.0),
                "Greatest component, linear, above which a pixel can become a sprite; 1 is white.",
            ),
            Param::choice(
                "post_filter",
                "Post filter",
                &mut self.post_filter,
                POST_FILTERS,
                "Over 3x3 texels of the gathered layers: a median removes single texels that taps have met or missed, a mean smooths steps between rings.",
            ),
        ]
    }

    /// Texels of the gathered image over pixels, reciprocal: 1 or 2.
    pub(super) fn step(&self) -> u32 {
        if RESOLUTIONS[self.resolution.min(1)] == "1" { 1 } else { 2 }
    }

    /// Taps: those of all rings and the one in the middle.
    pub(super) fn taps(&self) -> u32 {
        1 + 4 * self.rings * (self.rings + 1)
    }

    /// Where taps lie in the unit disc: each stands for the same area, and mirrored they are
    /// the same taps.
    pub(crate) fn ring_points(rings: u32) -> Vec<[f32; 2]> {
        let ring = |i: u32| {
            let radius = f64::from(i) / (f64::from(rings) + 0.5);
            (0..8 * i).map(move |k| {
                let angle = (f64::from(k) + 0.5) * PI / (4.0 * f64::from(i));
                [(radius * angle.cos()) as f32, (radius * angle.sin()) as f32]
            })
        };
        std::iter::once([0.0; 2]).chain((1..=rings).flat_map(ring)).collect()
    }

    /// What the shaders need.
    pub(super) fn uniform(&self, lens: &Lens, lens_uniform: LensUniform, grid: &Grid, scope: &Scope) -> Params {
        let step = f64::from(grid.step);
        // Box of the reduction less that of a pixel, and the mean over a texel of the bilinear
        // read's tent.
        let spread_px2 = (step * step - 1.0) / 12.0 + if grid.step == 1 { 0.0 } else { step * step / 6.0 };
        Params {
            lens: lens_uniform,
            grid: grid.size.to_array(),
            margin: grid.margin_px.to_array(),
            step: grid.step,
            footprint: grid.footprint,
            overscan: scope.overscan_px,
            taps: self.taps(),
            reach_tiles: grid.reach_tiles(scope.greatest_radius_px),
            aperture_radius: lens.aperture.radius() as f32,
            is_disc: (lens.aperture == Aperture::Disc).into(),
            spread: spread_px2 as f32,
            prefilter: self.prefilter.into(),
            tiles: self.tiles.into(),
            near: (self.near && scope.has_foreground).into(),
            fill: self.fill.into(),
            slight: self.slight.into(),
            sprite_threshold: if scope.has_sprites { self.sprite_threshold } else { f32::MAX },
            post_filter: self.post_filter as u32,
            in_focus_coc: IN_FOCUS_COC_PX as f32,
        }
    }
}

uniform! {
    /// `Params` in `shaders/lib/gather.wgsl`.
    pub(super) struct Params {
        lens: LensUniform,
        grid: [u32; 2],
        margin: [f32; 2],
        step: u32,
        footprint: u32,
        overscan: u32,
        taps: u32,
        reach_tiles: u32,
        aperture_radius: f32,
        is_disc: u32,
        spread: f32,
        prefilter: u32,
        tiles: u32,
        near: u32,
        fill: u32,
        slight: u32,
        sprite_threshold: f32,
        post_filter: u32,
        in_focus_coc: f32,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn taps_have_the_disc_s_second_moment() {
        for rings in 2..=5 {
            let points = Gather::ring_points(rings);
            let taps = Gather { rings, ..Gather::default() }.taps();
            assert_eq!(points.len() as u32, taps);
            let variance =
                |axis: usize| points.iter().map(|p| f64::from(p[axis]).powi(2)).sum::<f64>() / f64::from(taps);
            // Each stands for an area of pi / taps, whose own variance is that of a square: sectors of
            // few rings are longer than wide, and their variance is more.
            let of_area = PI / f64::from(taps) / 12.0;
            for axis in 0..2 {
                let error = (variance(axis) + of_area) / 0.25 - 1.0;
                assert!(error.abs() < 0.04, "{rings} rings: {error}");
            }
        }
    }
}
