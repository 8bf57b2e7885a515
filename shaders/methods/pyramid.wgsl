// pyramid: sub-images with disocclusion, Kraus and Strengert 2007 (src/methods/pyramid.rs).
//
// Sub-images and levels as in lib/subimages.wgsl. Here: pull-push, which fills what nearer
// surfaces hide; the matte, fused with the first analysis step; and the last synthesis
// step, fused with blending.
//
// Pull-push texels are premultiplied with w, how well a texel is known: (w rgb, w), w z.

#import lens
#import sampling
#import subimages

@group(0) @binding(0) var<uniform> lens: Lens;
@group(0) @binding(1) var<uniform> sub_images: SubImages;
@group(0) @binding(2) var<storage, read> occupied: u32;
@group(0) @binding(3) var color: texture_2d<f32>;
@group(0) @binding(4) var depth: texture_2d<f32>;
@group(0) @binding(5) var known_color: texture_2d_array<f32>;
@group(0) @binding(6) var known_depth: texture_2d_array<f32>;
@group(0) @binding(7) var filled_color: texture_2d_array<f32>;
@group(0) @binding(8) var filled_depth: texture_2d_array<f32>;
@group(0) @binding(9) var color_out: texture_storage_2d_array<COLOR_FORMAT, write>;
@group(0) @binding(10) var depth_out: texture_storage_2d_array<r32float, write>;
@group(0) @binding(11) var coarser: texture_storage_2d_array<COLOR_FORMAT, write>;
@group(0) @binding(12) var analysis: texture_2d_array<f32>;
@group(0) @binding(13) var blur: texture_2d_array<f32>;
@group(0) @binding(14) var result: texture_storage_2d<COLOR_FORMAT, write>;

/// A premultiplied texel of pull-push.
struct Known {
    color: vec4f,
    z: f32,
}

fn plus(a: Known, weight: f32, b: Known) -> Known {
    return Known(a.color + weight * b.color, a.z + weight * b.z);
}

/// The pixel p from the centre, as far as it is not in front of the layer's sub-image.
/// Nothing is known beyond the border: that is extrapolated.
fn culled(layer: u32, p: vec2i) -> Known {
    let at = p + sub_images.centre;
    if any(at < vec2i(0)) || any(at >= vec2i(textureDimensions(depth))) {
        return Known(vec4f(0.0), 0.0);
    }
    let z = textureLoad(depth, at, 0).r;
    let w = not_in_front(sub_images.ramps[layer], ramp_variable(sub_images.variance_ramps, lens, z));
    if w == 0.0 {
        return Known(vec4f(0.0), 0.0);
    }
    return Known(w * vec4f(textureLoad(color, at, 0).rgb, 1.0), w * z);
}

// ---- disocclusion ----

/// One known texel in the box is enough to know its mean.
fn store_mean(id: vec3u, sum: Known) {
    let scale = 1.0 / max(sum.color.a, 1.0);
    textureStore(color_out, id.xy, id.z, scale * sum.color);
    textureStore(depth_out, id.xy, id.z, vec4f(scale * sum.z));
}

@compute @workgroup_size(8, 8)
fn pull_image(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(color_out);
    if any(id.xy >= size) || !is_occupied(occupied, id.z) {
        return;
    }
    let p = texel_from_centre(id.xy, size);
    var sum = Known(vec4f(0.0), 0.0);
    for (var i = 0; i < 16; i++) {
        sum = plus(sum, 1.0, culled(id.z, box_texel(p, i)));
    }
    store_mean(id, sum);
}

@compute @workgroup_size(8, 8)
fn pull_level(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(color_out);
    if any(id.xy >= size) || !is_occupied(occupied, id.z) {
        return;
    }
    let p = texel_from_centre(id.xy, size);
    let finer = textureDimensions(known_color);
    var sum = Known(vec4f(0.0), 0.0);
    for (var i = 0; i < 16; i++) {
        let at = texel_index(box_texel(p, i), finer);
        if all(at == clamp_to_image(at, finer)) {
            let texel = Known(textureLoad(known_color, at, id.z, 0), textureLoad(known_depth, at, id.z, 0).r);
            sum = plus(sum, 1.0, texel);
        }
    }
    store_mean(id, sum);
}

/// `known`, completed from the filled coarser level around texel p of the finer.
fn completed(known: Known, layer: u32, p: vec2i) -> Known {
    if known.color.a >= 1.0 {
        return known;
    }
    let size = textureDimensions(filled_color);
    var around = Known(vec4f(0.0), 0.0);
    for (var i = 0; i < 4; i++) {
        let n = neighbour(p, i);
        let at = clamp_to_image(texel_index(n.at, size), size);
        let texel = Known(textureLoad(filled_color, at, layer, 0), textureLoad(filled_depth, at, layer, 0).r);
        around = plus(around, n.weight, texel);
    }
    let missing = 1.0 - known.color.a;
    return plus(known, missing / max(around.color.a, 1e-6), around);
}

@compute @workgroup_size(8, 8)
fn push_level(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(color_out);
    if any(id.xy >= size) || !is_occupied(occupied, id.z) {
        return;
    }
    let known = Known(textureLoad(known_color, id.xy, id.z, 0), textureLoad(known_depth, id.xy, id.z, 0).r);
    let filled = completed(known, id.z, texel_from_centre(id.xy, size));
    textureStore(color_out, id.xy, id.z, filled.color);
    textureStore(depth_out, id.xy, id.z, vec4f(filled.z));
}

// ---- matte and blur ----

/// The disoccluded sub-image, matted and premultiplied, at the pixel p from the centre.
fn matted(layer: u32, p: vec2i) -> vec4f {
    let filled = completed(culled(layer, p), layer, p);
    // The rising ramp was the culling's: what is in front has been replaced.
    let omega = not_behind(sub_images.ramps[layer], ramp_variable(sub_images.variance_ramps, lens, filled.z));
    return omega * filled.color;
}

@compute @workgroup_size(8, 8)
fn matte_and_reduce(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(coarser);
    if any(id.xy >= size) || !is_occupied(occupied, id.z) {
        return;
    }
    let p = texel_from_centre(id.xy, size);
    var sum = vec4f(0.0);
    for (var i = 0; i < 16; i++) {
        sum += matted(id.z, box_texel(p, i));
    }
    textureStore(coarser, id.xy, id.z, sum / 16.0);
}

/// The blurred sub-image at the pixel p from the centre.
fn blurred(layer: u32, p: vec2i) -> vec4f {
    let size = textureDimensions(analysis);
    let starts = sub_images.order[layer].x == 1u;
    var sum = vec4f(0.0);
    for (var i = 0; i < 4; i++) {
        let n = neighbour(p, i);
        let at = clamp_to_image(texel_index(n.at, size), size);
        if starts {
            sum += n.weight * textureLoad(analysis, at, layer, 0);
        } else {
            sum += n.weight * textureLoad(blur, at, layer, 0);
        }
    }
    return sum;
}

/// Blending from front to back, divided by the opacity that was reached.
@compute @workgroup_size(8, 8)
fn blur_and_blend(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(result)) {
        return;
    }
    let p = vec2i(id.xy + sub_images.overscan) - sub_images.centre;
    var light = vec3f(0.0);
    var transparency = 1.0;
    var through = 1.0;
    for (var i = 0u; i < sub_images.count && through > 0.0; i++) {
        let layer = sub_images.order[i].y;
        if !is_occupied(occupied, layer) {
            continue;
        }
        var sub: vec4f;
        if sub_images.order[layer].x > 0u {
            sub = blurred(layer, p);
        } else {
            sub = matted(layer, p);
        }
        light += through * sub.rgb;
        transparency *= 1.0 - sub.a;
        through *= 1.0 - (1.0 - sub_images.repeated_inclusion) * sub.a;
    }
    textureStore(result, id.xy, vec4f(light / max(1.0 - transparency, 1e-6), 1.0));
}
