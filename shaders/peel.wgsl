// Peeling layers (src/view/peel.rs): empty texels are marked, the next layer is bounded,
// and the first layer gets box-filtered levels.

struct Params {
    /// Stored depth z that the next layer lies behind this one at least.
    separation_z: f32,
    /// 1 for the first layer, which has no empty texels whatever its alpha.
    nearest: u32,
}

struct Reduction {
    /// Texels of the finer level that hold something; the rest pads it.
    finer_size: vec2u,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var color: texture_2d<f32>;
@group(0) @binding(2) var depth: texture_2d<f32>;
@group(0) @binding(3) var marked: texture_storage_2d<r32float, write>;
@group(0) @binding(4) var below: texture_storage_2d<r32float, write>;
@group(0) @binding(5) var<uniform> reduction: Reduction;
@group(0) @binding(6) var finer: texture_2d_array<f32>;
@group(0) @binding(7) var coarser: texture_storage_2d_array<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn mark_layer(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(depth)) {
        return;
    }
    let z = textureLoad(depth, id.xy, 0).r;
    // The background lies at z = 0 as nothing does, but has an alpha.
    let empty = params.nearest == 0u && z <= 0.0 && textureLoad(color, id.xy, 0).a == 0.0;
    textureStore(marked, id.xy, vec4f(select(max(z, 0.0), -1.0, empty)));
    textureStore(below, id.xy, vec4f(z - params.separation_z));
}

@compute @workgroup_size(8, 8)
fn reduce_layer(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(coarser)) {
        return;
    }
    var sum = vec4f(0.0);
    for (var i = 0u; i < 4u; i++) {
        sum += textureLoad(finer, min(2u * id.xy + vec2u(i % 2u, i / 2u), reduction.finer_size - 1u), 0, 0);
    }
    textureStore(coarser, id.xy, 0, 0.25 * sum);
}
