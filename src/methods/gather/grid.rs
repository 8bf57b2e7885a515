//! Where the gathered image's texels lie, and what is known of the picture beforehand.

use super::super::tile_lists::TILE_PX;
use glam::{UVec2, Vec2};

/// The gathered image: whole tiles, centred on the picture, so that a mirrored picture has
/// the mirrored one.
pub(super) struct Grid {
    /// px on each side of a texel.
    pub(super) step: u32,
    /// Texels.
    pub(super) size: UVec2,
    /// Pixels by which it begins left of and above the picture; halves where the picture's
    /// side is odd.
    pub(super) margin_px: Vec2,
    /// Pixels on each side that a texel covers all or part of.
    pub(super) footprint: u32,
}

impl Grid {
    pub(super) fn new(image: UVec2, step: u32) -> Self {
        let size = image.map(|side| side.div_ceil(step).next_multiple_of(TILE_PX));
        let margin_px = 0.5 * (step * size - image).as_vec2();
        let is_split = margin_px.fract() != Vec2::ZERO;
        // At full resolution texels are pixels: half a pixel off the centre is better than all
        // pixels means of two.
        let margin_px = if step == 1 { margin_px.floor() } else { margin_px };
        Self { step, size, margin_px, footprint: step + u32::from(step > 1 && is_split) }
    }

    pub(super) fn tiles(&self) -> UVec2 {
        self.size / TILE_PX
    }

    /// Tiles on every side from which a blur of that radius reaches a tile.
    pub(super) fn reach_tiles(&self, radius_px: f64) -> u32 {
        let tile_px = f64::from(self.step * TILE_PX);
        ((radius_px / tile_px).ceil() as u32 + 1).min(self.tiles().max_element())
    }
}

/// What is known of the picture beforehand.
pub(super) struct Scope {
    pub(super) overscan_px: u32,
    /// Of the widest blur.
    pub(super) greatest_radius_px: f64,
    /// Whether anything in front of the focus is blurred.
    pub(super) has_foreground: bool,
    /// Whether anything is bright enough for a sprite.
    pub(super) has_sprites: bool,
}
