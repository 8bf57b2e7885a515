// The inner frame of an overscanned image (src/methods/pinhole.rs). Also what every time
// of a method is compared with: one read and one write a pixel.

struct Copy {
    /// Margin on every side, px.
    overscan: u32,
}

@group(0) @binding(0) var<uniform> copy: Copy;
@group(0) @binding(1) var color: texture_2d<f32>;
@group(0) @binding(2) var result: texture_storage_2d<COLOR_FORMAT, write>;

@compute @workgroup_size(8, 8)
fn copy_inner(@builtin(global_invocation_id) id: vec3u) {
    textureStore(result, id.xy, textureLoad(color, id.xy + copy.overscan, 0));
}
