//! The nearest surface around each pixel, so that lens rays leave out empty space.

use crate::gpu::{Frame, Shader, Texture, TextureKey};
use crate::{shader, uniform};
use glam::UVec2;

const SHADER: Shader = shader!("nearest");

/// How far around a pixel each layer of [`Peeled::nearest`](super::Peeled::nearest) looks, px.
pub const NEAREST_REACH_PX: [u32; 2] = [5, 13];

/// How the layers follow from one another, the first of them from one that is not kept: pixels that are
/// asked on each side of a pixel, and how far apart they lie, px. Windows overlap or touch:
/// spacing <= 2 * reach + 1.
const STEPS: [(u32, u32); 3] = [(1, 1), (2, 2), (1, 8)];

/// How far, px, the sample of a place may lie from it: the pixel beside it.
pub const SAMPLE_SLACK_PX: f64 = 1.0;

uniform! {
    struct Spread {
        size: [u32; 2],
        samples_a_side: u32,
        taps: u32,
        spacing: u32,
        _pad: [u32; 3],
    }
}

/// An R32F array of the outer frame, of `size`: the greatest stored depth of the samples within
/// [`NEAREST_REACH_PX`] pixels along x and y. `depth` has `samples_a_side` samples a pixel on each side.
pub(super) fn nearest_depths(frame: &mut Frame<'_>, depth: &Texture, size: UVec2, samples_a_side: u32) -> Texture {
    let format = wgpu::TextureFormat::R32Float;
    let key = TextureKey { size, levels: 1, layers: NEAREST_REACH_PX.len() as u32, format };
    let nearest = frame.gpu().texture_of("nearest depths", key);
    let spread = Spread { size: size.to_array(), samples_a_side, ..Default::default() };
    let pixels = frame.texture("nearest in pixels", size, format);
    frame
        .pass(&SHADER, "nearest_in_pixels")
        .uniform("spread", &spread)
        .texture("depth", depth)
        .texture("nearest", &pixels)
        .dispatch(size);
    let beside = frame.texture("nearest beside pixels", size, format);
    for (index, (taps, spacing)) in (0..).zip(STEPS) {
        let pass = frame.pass(&SHADER, "nearest_around_pixels").uniform("spread", &Spread { taps, spacing, ..spread });
        let pass = match index {
            0 => pass.texture("depth", &pixels).texture("nearest", &beside),
            1 => pass.texture("depth", &beside).slice("nearest", &nearest, 0, 0),
            _ => pass.slice("depth", &nearest, 0, index - 2).slice("nearest", &nearest, 0, index - 1),
        };
        pass.dispatch(size);
    }
    nearest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_look_as_far_as_they_say_without_gaps() {
        let mut reaches = vec![0];
        for (taps, spacing) in STEPS {
            let reach = reaches[reaches.len() - 1];
            assert!(spacing <= 2 * reach + 1, "gaps between windows of {reach} px");
            reaches.push(reach + taps * spacing);
        }
        assert!(reaches.ends_with(&NEAREST_REACH_PX), "{reaches:?}");
    }
}
