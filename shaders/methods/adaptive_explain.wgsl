// adaptive, debug images: rays, texel reads and layers hit, by pixel
// (src/methods/adaptive/explain.rs).

struct Shown {
    /// Component of `counts`.
    component: u32,
    /// Component that it is divided by, or NONE.
    divisor: u32,
    /// What is shown as white.
    white: f32,
}

const NONE = 4u;

@group(0) @binding(0) var<uniform> shown: Shown;
@group(0) @binding(1) var counts: texture_2d<f32>;
@group(0) @binding(2) var buckets: texture_2d_array<f32>;
/// COPY, UNIFORM or COMPLEX over 2, by tile.
@group(0) @binding(3) var classes: texture_2d<f32>;
@group(0) @binding(4) var overlay: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn show_count(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(overlay)) {
        return;
    }
    let count = textureLoad(counts, id.xy, 0);
    var value = count[shown.component] / shown.white;
    if shown.divisor != NONE {
        value /= max(count[shown.divisor], 1.0);
    }
    textureStore(overlay, id.xy, vec4f(vec3f(value), 1.0));
}

fn share(pixel: vec2u, bucket: u32) -> f32 {
    return textureLoad(buckets, pixel, bucket, 0).a;
}

/// Shares of hits in front of the focus, in it and behind it; the narrower bucket darker.
@compute @workgroup_size(8, 8)
fn show_buckets(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(overlay)) {
        return;
    }
    var color = vec3f(0.0, 1.0, 0.0);
    // Tiles in focus have no buckets.
    if textureLoad(classes, id.xy / 8u, 0).r > 0.0 {
        color.r = share(id.xy, 0u) + 0.5 * share(id.xy, 1u);
        color.g = share(id.xy, 2u);
        color.b = share(id.xy, 4u) + 0.5 * share(id.xy, 3u);
    }
    textureStore(overlay, id.xy, vec4f(color, 1.0));
}
