// A foreign program's colour and depth as a pinhole image: linear RGBA16F and stored depth
// near / d (src/view/import.rs).

#import color

struct Import {
    /// Stored depth is offset + scale * (the depth texture's value): every usual
    /// convention is affine in it.
    offset: f32,
    scale: f32,
}

@group(0) @binding(0) var<uniform> import_: Import;
@group(0) @binding(1) var color: texture_2d<f32>;
@group(0) @binding(2) var depth: texture_2d<f32>;
@group(0) @binding(3) var depth_buffer: texture_depth_2d;
@group(0) @binding(4) var color_out: texture_storage_2d<rgba16float, write>;
@group(0) @binding(5) var depth_out: texture_storage_2d<r32float, write>;
@group(0) @binding(6) var<storage, read_write> repaired: atomic<u32>;

fn store(at: vec2u, z: f32) {
    let texel = textureLoad(color, at, 0).rgb;
    let good_color = is_finite(texel);
    let stored = import_.offset + import_.scale * z;
    let good_depth = is_finite(vec3f(stored));
    if !(good_color && good_depth) {
        atomicAdd(&repaired, 1u);
    }
    let kept = clamp(select(vec3f(0.0), texel, good_color), vec3f(-MAX_F16), vec3f(MAX_F16));
    textureStore(color_out, at, vec4f(kept, 1.0));
    textureStore(depth_out, at, vec4f(max(select(0.0, stored, good_depth), 0.0)));
}

@compute @workgroup_size(8, 8)
fn import_plane(@builtin(global_invocation_id) id: vec3u) {
    if all(id.xy < textureDimensions(color_out)) {
        store(id.xy, textureLoad(depth, id.xy, 0).r);
    }
}

@compute @workgroup_size(8, 8)
fn import_depth_buffer(@builtin(global_invocation_id) id: vec3u) {
    if all(id.xy < textureDimensions(color_out)) {
        store(id.xy, textureLoad(depth_buffer, id.xy, 0));
    }
}
