//! Where textures from inside methods lie on the picture.

use glam::{DVec2, UVec2, Vec2};

/// The part of the picture that a texture covers, px; it may reach beyond it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Its upper left corner.
    pub min: Vec2,
    /// Its size.
    pub size: Vec2,
}

impl Place {
    /// Of a texture of `size`: methods have textures of the picture (`inner` px), of it
    /// with its margin, of either in tiles of a power of two, and padded around the middle.
    /// `texel_px` is the width of a texel where the method tells it; without, it is the
    /// narrowest that suits the size.
    pub fn of(size: UVec2, inner: UVec2, margin_px: u32, texel_px: Option<u32>) -> Self {
        const SCALES: u32 = 12;
        let outer = inner + 2 * margin_px;
        let scales = || (0..SCALES).map(|level| 1 << level).filter(|scale| texel_px.is_none_or(|told| told == *scale));
        let tile = |whole: UVec2| scales().find(|t| UVec2::new(whole.x.div_ceil(*t), whole.y.div_ceil(*t)) == size);
        if let Some(tile) = tile(inner) {
            return Self { min: Vec2::ZERO, size: (size * tile).as_vec2() };
        }
        if let Some(tile) = tile(outer) {
            return Self { min: Vec2::splat(-(margin_px as f32)), size: (size * tile).as_vec2() };
        }
        let covers = |texel: &u32| (size * *texel).cmpge(outer).all();
        let covered = size * scales().find(covers).or(texel_px).unwrap_or(1);
        // What is left over by halves is padded at the right and below.
        let padding = covered.saturating_sub(outer) / 2 + margin_px;
        Self { min: -padding.as_vec2(), size: covered.as_vec2() }
    }

    /// The texel of a texture of `size` that lies at a point of the picture, from (0, 0) to
    /// (1, 1); `None` outside.
    pub fn texel(&self, size: UVec2, inner: UVec2, at: DVec2) -> Option<UVec2> {
        let px = at * inner.as_dvec2();
        let texel = (px - self.min.as_dvec2()) / self.size.as_dvec2() * size.as_dvec2();
        let inside = texel.cmpge(DVec2::ZERO).all() && texel.cmplt(size.as_dvec2()).all();
        inside.then(|| texel.as_uvec2())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{dvec2, uvec2, vec2};

    const INNER: UVec2 = uvec2(300, 200);

    #[test]
    fn textures_inside_lie_on_what_they_are_about() {
        let place = |size: UVec2| Place::of(size, INNER, 16, None);
        let whole = |min: Vec2, size: Vec2| Place { min, size };
        assert_eq!(place(INNER), whole(Vec2::ZERO, vec2(300.0, 200.0)));
        assert_eq!(place(uvec2(332, 232)), whole(vec2(-16.0, -16.0), vec2(332.0, 232.0)));
        // Tiles of 8 px reach over the border.
        assert_eq!(place(uvec2(38, 25)), whole(Vec2::ZERO, vec2(304.0, 200.0)));
        // Level 1 of an image padded to 384 x 256 around its middle.
        let padded = place(uvec2(192, 128));
        assert_eq!(padded, whole(vec2(-42.0, -28.0), vec2(384.0, 256.0)));
        assert_eq!(padded.texel(uvec2(192, 128), INNER, dvec2(0.5, 0.5)), Some(uvec2(96, 64)));
        assert_eq!(place(uvec2(38, 25)).texel(uvec2(38, 25), INNER, dvec2(0.99, 0.0)), Some(uvec2(37, 0)));
        assert_eq!(padded.texel(uvec2(192, 128), INNER, dvec2(2.0, 0.5)), None);
    }

    #[test]
    fn a_pyramid_far_larger_than_the_picture_lies_where_its_method_says() {
        // An image of 332 x 232 padded to 1024: its half is larger than the image itself.
        let place = Place::of(uvec2(512, 512), INNER, 16, Some(2));
        assert_eq!(place, Place { min: vec2(-362.0, -412.0), size: vec2(1024.0, 1024.0) });
    }
}
