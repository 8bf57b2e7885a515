// opaque: the opaque image blur of Kraus 2011 (src/methods/opaque.rs).
//
// Sub-images and levels as in lib/subimages.wgsl. Here: the matte, fused with the first
// analysis step, and the last synthesis step, fused with rescaling and blending.

#import lens
#import sampling
#import subimages

@group(0) @binding(0) var<uniform> lens: Lens;
@group(0) @binding(1) var<uniform> sub_images: SubImages;
@group(0) @binding(2) var<storage, read> occupied: u32;
@group(0) @binding(3) var color: texture_2d<f32>;
@group(0) @binding(4) var depth: texture_2d<f32>;
@group(0) @binding(5) var coarser: texture_storage_2d_array<COLOR_FORMAT, write>;
@group(0) @binding(6) var analysis: texture_2d_array<f32>;
@group(0) @binding(7) var blur: texture_2d_array<f32>;
@group(0) @binding(8) var glow: texture_2d_array<f32>;
@group(0) @binding(9) var result: texture_storage_2d<COLOR_FORMAT, write>;

/// omega of a layer at x.
fn weight(layer: u32, x: f32) -> f32 {
    let ramps = sub_images.ramps[layer];
    let omega = min(not_in_front(ramps, x), not_behind(ramps, x));
    if sub_images.glow_undone == 0u || omega <= 0.0 || omega >= 1.0 {
        return omega;
    }
    // Over a flat region the glow multiplies |i| + 1 equal transparencies.
    return 1.0 - pow(1.0 - omega, 1.0 / f32(sub_images.order[layer].x + 1u));
}

/// The matted sub-image, premultiplied, at the pixel p from the centre.
fn matted(layer: u32, p: vec2i) -> vec4f {
    let at = p + sub_images.centre;
    let inside = clamp_to_image(at, textureDimensions(depth));
    if any(at != inside) && sub_images.transparent_border != 0u {
        return vec4f(0.0);
    }
    let omega = weight(layer, ramp_variable(sub_images.variance_ramps, lens, textureLoad(depth, inside, 0).r));
    if omega == 0.0 {
        return vec4f(0.0);
    }
    return omega * vec4f(textureLoad(color, inside, 0).rgb, 1.0);
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

/// The blurred sub-image at the pixel p from the centre, where `sharp` is what it was before.
fn opaque_blur(layer: u32, p: vec2i, sharp: vec4f) -> vec4f {
    let size = textureDimensions(analysis);
    let starts = sub_images.order[layer].x == 1u;
    var blurred = vec4f(0.0);
    var expanded = 0.0;
    for (var i = 0; i < 4; i++) {
        let n = neighbour(p, i);
        let at = clamp_to_image(texel_index(n.at, size), size);
        if starts {
            let texel = textureLoad(analysis, at, layer, 0);
            blurred += n.weight * texel;
            expanded += n.weight * texel.a;
        } else {
            blurred += n.weight * textureLoad(blur, at, layer, 0);
            expanded += n.weight * textureLoad(glow, at, layer, 0).r;
        }
    }
    // Nothing of it is near; or it is so thin that its blur is less than a number can hold.
    if blurred.a <= 0.0 {
        return sharp;
    }
    // Equations (8) and (7).
    let opacity = 1.0 - (1.0 - expanded) * (1.0 - sharp.a);
    return vec4f(blurred.rgb * (opacity / blurred.a), opacity);
}

/// Equation (6), from front to back: the same sum, and it ends where nothing shows through.
@compute @workgroup_size(8, 8)
fn blur_and_blend(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(result)) {
        return;
    }
    let at = vec2i(id.xy + sub_images.overscan);
    let p = at - sub_images.centre;
    let here = textureLoad(color, at, 0).rgb;
    let x = ramp_variable(sub_images.variance_ramps, lens, textureLoad(depth, at, 0).r);
    var light = vec3f(0.0);
    var through = 1.0;
    for (var i = 0u; i < sub_images.count && through > 0.0; i++) {
        let layer = sub_images.order[i].y;
        if !is_occupied(occupied, layer) {
            continue;
        }
        let omega = weight(layer, x);
        var sub = omega * vec4f(here, 1.0);
        if sub_images.order[layer].x > 0u {
            sub = opaque_blur(layer, p, sub);
        }
        light += through * sub.rgb;
        through *= 1.0 - sub.a;
    }
    textureStore(result, id.xy, vec4f(light, 1.0));
}
