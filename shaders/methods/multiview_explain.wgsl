// multiview, to look at: in which slabs each pixel has surfaces
// (src/methods/multiview/slabs.rs).

struct Explained {
    /// First texel of the inner frame in the slabs.
    origin: vec2i,
    /// Number of slabs.
    count: u32,
    _unused: u32,
}

@group(0) @binding(0) var<uniform> slabs: Explained;
/// Stored depth by slab, below 0 where there is nothing.
@group(0) @binding(1) var slab_depth: texture_2d_array<f32>;
@group(0) @binding(2) var explained: texture_storage_2d<rgba16float, write>;

/// (the first slab that has a surface here, how many slabs have one)
@compute @workgroup_size(8, 8)
fn explain(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(explained)) {
        return;
    }
    var first = slabs.count;
    var surfaces = 0u;
    for (var slab = 0u; slab < slabs.count; slab++) {
        if textureLoad(slab_depth, vec2i(id.xy) + slabs.origin, slab, 0).r >= 0.0 {
            first = min(first, slab);
            surfaces++;
        }
    }
    textureStore(explained, id.xy, vec4f(f32(first), f32(surfaces), 0.0, 0.0));
}
