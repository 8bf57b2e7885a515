//! Texture look-ups: bilinear on the full image. A lens ray has no footprint, so there is
//! no level to choose; the mean over many lens points is what filters.

use crate::scene::{TextureImage, TextureUse, Wrap};
use glam::{Vec2, Vec4, vec4};
use std::sync::{Arc, LazyLock};

/// sRGB bytes decoded to linear light, IEC 61966-2-1.
static LINEAR_OF_SRGB: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|byte| {
        let encoded = byte as f64 / 255.0;
        let linear = if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) };
        linear as f32
    })
});

/// The texture of a material's slot at the two vertex texture coordinates `uv`; white where
/// the slot is empty, as glTF has it.
pub(super) fn lookup(textures: &[Arc<TextureImage>], slot: Option<&TextureUse>, uv: [Vec2; 2]) -> Vec4 {
    match slot {
        None => Vec4::ONE,
        Some(slot) => {
            let at = uv[usize::from(slot.second_uv)].extend(1.0);
            bilinear(&textures[slot.texture], Vec2::new(slot.u_row.dot(at), slot.v_row.dot(at)))
        }
    }
}

/// Bilinear look-up with texel centres at half integers. sRGB is decoded texel by texel
/// *before* filtering, as GPUs do; alpha is always linear.
fn bilinear(texture: &TextureImage, uv: Vec2) -> Vec4 {
    let (width, height) = (texture.size.x, texture.size.y);
    if width == 0 || height == 0 {
        return Vec4::ONE;
    }
    let x = uv.x * width as f32 - 0.5;
    let y = uv.y * height as f32 - 0.5;
    let (left, top) = (x.floor(), y.floor());
    let (fx, fy) = (x - left, y - top);
    let columns = [wrapped(left as i64, width, texture.wrap[0]), wrapped(left as i64 + 1, width, texture.wrap[0])];
    let rows = [wrapped(top as i64, height, texture.wrap[1]), wrapped(top as i64 + 1, height, texture.wrap[1])];
    let upper = texel(texture, columns[0], rows[0]).lerp(texel(texture, columns[1], rows[0]), fx);
    let lower = texel(texture, columns[0], rows[1]).lerp(texel(texture, columns[1], rows[1]), fx);
    upper.lerp(lower, fy)
}

/// The texel index that `index` stands for in a row of `count` texels.
fn wrapped(index: i64, count: u32, wrap: Wrap) -> usize {
    let count = i64::from(count);
    let within = match wrap {
        Wrap::Repeat => index.rem_euclid(count),
        Wrap::Clamp => index.clamp(0, count - 1),
        Wrap::Mirror => {
            let twice = index.rem_euclid(2 * count);
            twice.min(2 * count - 1 - twice)
        }
    };
    within as usize
}

/// One texel in linear light.
fn texel(texture: &TextureImage, x: usize, y: usize) -> Vec4 {
    let [r, g, b, a] = texture.rgba8[y * texture.size.x as usize + x];
    let plain = |byte: u8| f32::from(byte) * (1.0 / 255.0);
    if texture.srgb {
        let linear = &*LINEAR_OF_SRGB;
        vec4(linear[usize::from(r)], linear[usize::from(g)], linear[usize::from(b)], plain(a))
    } else {
        vec4(plain(r), plain(g), plain(b), plain(a))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{uvec2, vec2};

    fn ramp(wrap: Wrap, srgb: bool) -> TextureImage {
        let rgba8 = vec![[0, 0, 0, 255], [100, 100, 100, 255], [200, 200, 200, 0]];
        TextureImage { name: "ramp".into(), size: uvec2(3, 1), rgba8, srgb, wrap: [wrap, wrap] }
    }

    #[test]
    fn texel_centres_are_exact_and_midpoints_are_means() {
        let ramp = ramp(Wrap::Clamp, false);
        let at = |texels: f32| bilinear(&ramp, vec2(texels / 3.0, 0.5)).x * 255.0;
        // f32 texture coordinates: a few 1e-7 of 200.
        for (position, value) in [(0.5, 0.0), (1.5, 100.0), (2.5, 200.0), (1.0, 50.0), (2.0, 150.0), (1.75, 125.0)] {
            assert!((at(position) - value).abs() < 1e-3, "{position}: {}", at(position));
        }
    }

    #[test]
    fn addressing_beyond_the_image() {
        let indices = |wrap| (-4..=6).map(|i| wrapped(i, 3, wrap)).collect::<Vec<_>>();
        assert_eq!(indices(Wrap::Repeat), [2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0]);
        assert_eq!(indices(Wrap::Clamp), [0, 0, 0, 0, 0, 1, 2, 2, 2, 2, 2]);
        assert_eq!(indices(Wrap::Mirror), [2, 2, 1, 0, 0, 1, 2, 2, 1, 0, 0]);
    }

    #[test]
    fn srgb_is_decoded_before_filtering() {
        let ramp = ramp(Wrap::Clamp, true);
        let middle = bilinear(&ramp, vec2(2.0 / 3.0, 0.5));
        let decode = |byte: f64| ((byte / 255.0 + 0.055) / 1.055).powf(2.4);
        let mean = 0.5 * (decode(100.0) + decode(200.0));
        assert!((f64::from(middle.x) - mean).abs() < 1e-6, "{} is not {mean}", middle.x);
        assert!((middle.w - 0.5).abs() < 1e-6, "alpha is linear: {}", middle.w);
    }
}
