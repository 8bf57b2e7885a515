// Sub-images, to look at: in which one each pixel of the image lies
// (src/methods/subimages.rs).

#import lens
#import subimages

@group(0) @binding(0) var<uniform> sub_images: SubImages;
@group(0) @binding(1) var<uniform> lens: Lens;
@group(0) @binding(2) var depth: texture_2d<f32>;
@group(0) @binding(3) var explained: texture_storage_2d<rgba16float, write>;

/// (i of the sub-image that shows most of the pixel, negative in front of the focus; |i|,
/// the levels of its pyramid)
@compute @workgroup_size(8, 8)
fn explain(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(explained)) {
        return;
    }
    let z = textureLoad(depth, id.xy + sub_images.overscan, 0).r;
    let x = ramp_variable(sub_images.variance_ramps, lens, z);
    var i = 0.0;
    var side = -1.0;
    // From front to back: one that has faded out by half leaves most to the next.
    for (var k = 0u; k < sub_images.count; k++) {
        let layer = sub_images.order[k].y;
        let level = f32(sub_images.order[layer].x);
        side = select(side, 1.0, level == 0.0);
        i = side * level;
        if not_behind(sub_images.ramps[layer], x) >= 0.5 {
            break;
        }
    }
    textureStore(explained, id.xy, vec4f(i, abs(i), 0.0, 0.0));
}
