// Interleaves draws of one texel a pixel to a layer of more (src/view/fine.rs).

struct Interleave {
    /// Texels of the layer on each side of a pixel.
    texels_a_side: u32,
    /// Which of them was drawn.
    part: vec2u,
}

@group(0) @binding(0) var<uniform> interleaving: Interleave;
@group(0) @binding(1) var color: texture_2d<f32>;
@group(0) @binding(2) var depth: texture_2d<f32>;
@group(0) @binding(3) var fine_color: texture_storage_2d<rgba16float, write>;
@group(0) @binding(4) var fine_depth: texture_storage_2d<r32float, write>;

@compute @workgroup_size(8, 8)
fn interleave(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(color)) {
        return;
    }
    let texel = interleaving.texels_a_side * id.xy + interleaving.part;
    textureStore(fine_color, texel, textureLoad(color, id.xy, 0));
    textureStore(fine_depth, texel, textureLoad(depth, id.xy, 0));
}
