//! What an image with depth hides, guessed from what is seen beside it.
//!
//! A lens sees past the outline of a blurred surface what is behind it. A scene is drawn for
//! that; an image does not know. So surfaces that nearer ones interrupt go on behind those, with
//! the colour and the depth of their ends: `shaders/hidden.wgsl`.

use super::Layer;
use crate::gpu::{Buffer, Frame, Shader, Texture};
use crate::{shader, uniform};
use glam::UVec2;

const SHADER: Shader = shader!("hidden");

/// Rows and columns are followed in both directions.
const DIRECTIONS: u32 = 4;
/// Bytes of a pixel's distances, one for each direction.
const PIXEL_BYTES: u64 = 4 * 4;
/// Bytes of the `DIRECTIONS` times `REMEMBERED` times `Surface` of a row.
const ROW_BYTES: u64 = 4 * 16 * 8;

uniform! {
    struct Hidden {
        separation_z: f32,
        _unused: u32,
        size: [u32; 2],
    }
}

/// What the surfaces of `seen` hide, as a layer of its size: where nothing is hidden its alpha
/// is 0, and it holds what is seen. Hidden surfaces lie at least `separation_z` of stored depth
/// behind what hides them, and not in front of `below`, R32F, whose texels of -1 want none.
pub(super) fn behind(frame: &mut Frame<'_>, seen: &Layer, below: &Texture, separation_z: f32) -> Layer {
    let distances = follow(frame, seen, separation_z);
    show(frame, seen, &distances, below, separation_z)
}

/// For each pixel and direction the distance to the end of a surface that goes on behind it.
pub(super) fn follow(frame: &mut Frame<'_>, seen: &Layer, separation_z: f32) -> Buffer {
    let size = seen.depth.size();
    let gpu = frame.gpu();
    let distances = gpu.scratch("distances to hidden surfaces", PIXEL_BYTES * u64::from(size.x) * u64::from(size.y));
    let rows = size.max_element();
    let interrupted = gpu.scratch("interrupted surfaces", ROW_BYTES * u64::from(rows));
    frame
        .pass(&SHADER, "follow")
        .uniform("params", &Hidden { separation_z, _unused: 0, size: size.to_array() })
        .texture("depth", &seen.depth)
        .buffer("distances", &distances)
        .buffer("interrupted", &interrupted)
        .dispatch(UVec2::new(rows, DIRECTIONS));
    distances
}

/// The layer that these distances make, as of [`behind`].
pub(super) fn show(
    frame: &mut Frame<'_>,
    seen: &Layer,
    distances: &Buffer,
    below: &Texture,
    separation_z: f32,
) -> Layer {
    let size = seen.depth.size();
    let layer = super::fine::empty(frame, size);
    frame
        .pass(&SHADER, "show_hidden")
        .uniform("params", &Hidden { separation_z, _unused: 0, size: size.to_array() })
        .texture("color", &seen.color)
        .texture("depth", &seen.depth)
        .texture("below", below)
        .buffer("distances", distances)
        .texture("hidden_color", &layer.color)
        .texture("hidden_depth", &layer.depth)
        .dispatch(size);
    layer
}
