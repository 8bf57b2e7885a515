//! What an image with depth hides, guessed from what is seen beside it.
//!
//! A lens sees past the outline of a blurred surface what is behind it. A scene is drawn for
//! that; an image does not know. So surfaces that nearer ones interrupt go on behind those, with
//! the colour and the depth of their ends: `shaders/hidden.wgsl`.

use super::Layer;
use crate::gpu::{Frame, Shader, Texture};
use crate::{shader, uniform};
use glam::UVec2;

const SHADER: Shader = shader!("hidden");

/// Bytes of `Guess` in the shader.
const GUESS_BYTES: u64 = 32;
/// Bytes of the `REMEMBERED` times `Surface` of a row.
const ROW_BYTES: u64 = 16 * 32;

uniform! {
    struct Hidden {
        separation_z: f32,
        direction: u32,
        size: [u32; 2],
    }
}

/// What the surfaces of `seen` hide, as a layer of its size: where nothing is hidden its alpha
/// is 0, and it holds what is seen. Hidden surfaces lie at least `separation_z` of stored depth
/// behind what hides them, and not in front of `below`, R32F, whose texels of -1 want none.
pub(super) fn behind(frame: &mut Frame<'_>, seen: &Layer, below: &Texture, separation_z: f32) -> Layer {
    let size = seen.depth.size();
    let gpu = frame.gpu();
    let guesses = gpu.buffer("guesses", GUESS_BYTES * u64::from(size.x) * u64::from(size.y));
    let interrupted = gpu.scratch("interrupted surfaces", ROW_BYTES * u64::from(size.max_element()));
    let params = Hidden { separation_z, direction: 0, size: size.to_array() };
    for direction in 0..4 {
        let rows = if direction < 2 { size.y } else { size.x };
        frame
            .pass(&SHADER, "follow")
            .uniform("params", &Hidden { direction, ..params })
            .texture("color", &seen.color)
            .texture("depth", &seen.depth)
            .buffer("guesses", &guesses)
            .buffer("interrupted", &interrupted)
            .dispatch(UVec2::new(rows, 1));
    }
    let layer = super::fine::empty(frame, size);
    frame
        .pass(&SHADER, "show_hidden")
        .uniform("params", &params)
        .texture("color", &seen.color)
        .texture("depth", &seen.depth)
        .texture("below", below)
        .buffer("guesses", &guesses)
        .texture("hidden_color", &layer.color)
        .texture("hidden_depth", &layer.depth)
        .dispatch(size);
    layer
}
