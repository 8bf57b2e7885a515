// opaque: the opaque image blur of Kraus 2011 (src/methods/opaque.rs).
//
// Sub-images and levels as in lib/subimages.wgsl. Here: the matte, fused with the first
// analysis step, and the last synthesis step, fused with rescaling and blending. Both work on
// blocks of 2x2 pixels, in all sub-images: a pixel is read once.

#import subimage_pixels

@group(0) @binding(6) var coarser: texture_storage_2d_array<COLOR_FORMAT, write>;
@group(0) @binding(7) var analysis: texture_2d_array<f32>;
@group(0) @binding(8) var blur: texture_2d_array<f32>;
@group(0) @binding(9) var glow: texture_2d_array<f32>;
@group(0) @binding(10) var result: texture_storage_2d<COLOR_FORMAT, write>;

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

/// The matted sub-image, premultiplied, at a pixel.
fn matted(layer: u32, p: Pixel) -> vec4f {
    let omega = weight(layer, p.x);
    if omega == 0.0 {
        return vec4f(0.0);
    }
    return omega * vec4f(p.color, 1.0);
}

/// Of two layers, one after the other.
var<workgroup> blocks: array<vec4f, 512>;

@compute @workgroup_size(16, 16)
fn matte_and_reduce(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let size = textureDimensions(coarser);
    let texel = BOXES * group.xy + local.xy;
    let block = pixel_block(texel_from_centre(texel, size), sub_images.transparent_border != 0u);
    note_layers(ramp_variables(block));
    workgroupBarrier();
    let found = atomicLoad(&found_here);
    if index == 0u {
        atomicOr(&occupied_out, found);
    }
    let stores = all(local.xy < vec2u(BOXES)) && all(texel < size);
    var slot = index;
    for (var layer = 0u; layer < sub_images.count; layer++) {
        // Layers are sorted by level: what is not blurred comes last.
        if sub_images.order[layer].x == 0u {
            break;
        }
        if !is_occupied(found, layer) {
            if stores {
                textureStore(coarser, texel, layer, vec4f(0.0));
            }
            continue;
        }
        blocks[slot] = matted(layer, block.a) + matted(layer, block.b) + matted(layer, block.c) + matted(layer, block.d);
        workgroupBarrier();
        if stores {
            let sum = blocks[slot] + blocks[slot + 1u] + blocks[slot + BLOCKS] + blocks[slot + BLOCKS + 1u];
            textureStore(coarser, texel, layer, sum / 16.0);
        }
        // The other half is free: all have read it before they came to the barrier.
        slot ^= 256u;
    }
}

/// The blurred sub-image at a pixel, where `sharp` is what it was before.
fn opaque_blur(sharp: vec4f, blurred: vec4f, glow_here: f32) -> vec4f {
    // Nothing of it is near; or it is so thin that its blur is less than a number can hold.
    if blurred.a <= 0.0 {
        return sharp;
    }
    // Equations (8) and (7).
    let opacity = 1.0 - (1.0 - glow_here) * (1.0 - sharp.a);
    return vec4f(blurred.rgb * (opacity / blurred.a), opacity);
}

/// Light so far, from the front, and the share of what is behind that shows through.
struct Seen {
    light: vec3f,
    through: f32,
}

fn behind(seen: Seen, sub: vec4f) -> Seen {
    return Seen(seen.light + seen.through * sub.rgb, seen.through * (1.0 - sub.a));
}

/// A layer behind what is seen, at corner i of a block.
fn blended(seen: Seen, layer: u32, p: Pixel, quad: Quad, glow_quad: Quad, i: u32) -> Seen {
    var sub = weight(layer, p.x) * vec4f(p.color, 1.0);
    if sub_images.order[layer].x > 0u {
        sub = opaque_blur(sub, expanded(quad, i), expanded(glow_quad, i).r);
    }
    return behind(seen, sub);
}

/// Equation (6), from front to back: the same sum, and it ends where nothing shows through.
@compute @workgroup_size(8, 8)
fn blur_and_blend(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let b = first_block() + vec2i(id.xy);
    let pixels = pixel_block(b, false);
    let place = quad_place(b, textureDimensions(analysis));
    let start = Seen(vec3f(0.0), 1.0);
    var seen_a = start;
    var seen_b = start;
    var seen_c = start;
    var seen_d = start;
    var open = true;
    for (var i = 0u; i < sub_images.count && open; i++) {
        let layer = sub_images.order[i].y;
        if !is_occupied(occupied, layer) {
            continue;
        }
        let level = sub_images.order[layer].x;
        var quad: Quad;
        var glow_quad: Quad;
        if level == 1u {
            quad = quad_of(analysis, place, layer);
            glow_quad = opacities(quad);
        } else if level > 1u {
            quad = quad_of(blur, place, layer);
            glow_quad = quad_of(glow, place, layer);
        }
        seen_a = blended(seen_a, layer, pixels.a, quad, glow_quad, 0u);
        seen_b = blended(seen_b, layer, pixels.b, quad, glow_quad, 1u);
        seen_c = blended(seen_c, layer, pixels.c, quad, glow_quad, 2u);
        seen_d = blended(seen_d, layer, pixels.d, quad, glow_quad, 3u);
        open = max(max(seen_a.through, seen_b.through), max(seen_c.through, seen_d.through)) > 0.0;
    }
    hand_over(local.xy, 0u, seen_a.light);
    hand_over(local.xy, 1u, seen_b.light);
    hand_over(local.xy, 2u, seen_c.light);
    hand_over(local.xy, 3u, seen_d.light);
    workgroupBarrier();
    for (var i = index; i < 256u; i += 64u) {
        let at = result_pixel(group.xy, i);
        if all(at >= vec2i(0)) && all(at < vec2i(textureDimensions(result))) {
            textureStore(result, at, vec4f(results[i], 1.0));
        }
    }
}
