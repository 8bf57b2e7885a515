// adaptive: the CoC radii of four views from off the lens's centre, in one texel
// (src/methods/adaptive/views.rs).

#import lens

struct Bounds {
    nearest_s: f32,
    farthest_s: f32,
}

@group(0) @binding(0) var<uniform> lens: Lens;
@group(0) @binding(1) var<uniform> bounds: Bounds;
@group(0) @binding(2) var depth_0: texture_2d<f32>;
@group(0) @binding(3) var depth_1: texture_2d<f32>;
@group(0) @binding(4) var depth_2: texture_2d<f32>;
@group(0) @binding(5) var depth_3: texture_2d<f32>;
@group(0) @binding(6) var radii: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn pack_views(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(radii)) {
        return;
    }
    let z = vec4f(
        textureLoad(depth_0, id.xy, 0).r,
        textureLoad(depth_1, id.xy, 0).r,
        textureLoad(depth_2, id.xy, 0).r,
        textureLoad(depth_3, id.xy, 0).r,
    );
    var s: vec4f;
    for (var i = 0; i < 4; i++) {
        s[i] = clamp(0.5 * coc_diameter_px(lens, z[i]), bounds.nearest_s, bounds.farthest_s);
    }
    textureStore(radii, id.xy, s);
}
