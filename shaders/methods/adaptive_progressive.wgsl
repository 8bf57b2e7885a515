// adaptive, progressive: the mean of frames with turned lens points and the mean of true
// views, blended (src/methods/adaptive/progressive.rs).

struct Blend {
    /// Share of the true views.
    share: f32,
}

@group(0) @binding(0) var<uniform> blend: Blend;
@group(0) @binding(1) var turned: texture_2d<f32>;
@group(0) @binding(2) var views: texture_2d<f32>;
@group(0) @binding(3) var blended: texture_storage_2d<rgba32float, write>;

@compute @workgroup_size(8, 8)
fn blend_means(@builtin(global_invocation_id) id: vec3u) {
    textureStore(blended, id.xy, mix(textureLoad(turned, id.xy, 0), textureLoad(views, id.xy, 0), blend.share));
}
