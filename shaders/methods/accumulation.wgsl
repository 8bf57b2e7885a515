// accumulation: views over the lens, summed in 32 bits (src/methods/accumulation.rs).

struct Mean {
    reciprocal_count: f32,
}

@group(0) @binding(0) var view: texture_2d<f32>;
@group(0) @binding(1) var sum: texture_2d<f32>;
@group(0) @binding(2) var next: texture_storage_2d<rgba32float, write>;
@group(0) @binding(3) var<uniform> scale: Mean;

@compute @workgroup_size(8, 8)
fn first_view(@builtin(global_invocation_id) id: vec3u) {
    textureStore(next, id.xy, textureLoad(view, id.xy, 0));
}

@compute @workgroup_size(8, 8)
fn add_view(@builtin(global_invocation_id) id: vec3u) {
    textureStore(next, id.xy, textureLoad(sum, id.xy, 0) + textureLoad(view, id.xy, 0));
}

@compute @workgroup_size(8, 8)
fn mean_of_views(@builtin(global_invocation_id) id: vec3u) {
    textureStore(next, id.xy, textureLoad(sum, id.xy, 0) * scale.reciprocal_count);
}
