// What the passes of `splat` share: its numbers, its source and the visible surface
// (src/methods/splat/).

#import color
#import spots
#import sampling

struct Params {
    /// Half width of the middle layer over C_v: the paper's delta.
    delta: f32,
    /// Stored depth z that a hidden surface must lie behind the visible one.
    separation_z: f32,
    /// Mean difference of c, px, between neighbours and a pixel that partially occludes.
    occlusion_px: f32,
    /// 0: all sprites go to the middle layer.
    layered: u32,
    /// 1: each layer is divided by its alpha as it is composed.
    normalised: u32,
    /// 1: the hidden image adds no more to a layer than is missing there.
    filling: u32,
    /// 1: bright pixels are made brighter, for images that were cut at white.
    highlights: u32,
    /// lambda_0, beta and gamma of equation (8).
    highlight_threshold: f32,
    highlight_falloff: f32,
    highlight_gain: f32,
    /// 1: the source is a layer of sheets, whose alpha is coverage and whose colour is multiplied
    /// with it.
    sheets: u32,
}

@group(1) @binding(0) var<uniform> lens: Lens;
@group(1) @binding(1) var<uniform> sprites: Sprites;
@group(1) @binding(2) var<uniform> params: Params;
/// The source: the visible or the hidden image.
@group(1) @binding(3) var color: texture_2d<f32>;
@group(1) @binding(4) var depth: texture_2d<f32>;
@group(1) @binding(5) var visible_depth: texture_2d<f32>;
@group(1) @binding(6) var idf_sums: texture_2d<f32>;
/// Of section 5: what draws 2x2 pixels, as bits.
@group(1) @binding(7) var arrays: texture_2d<u32>;

fn visible_coc_px(p: vec2i) -> f32 {
    return coc_diameter_px(lens, textureLoad(visible_depth, clamp_to_image(p, textureDimensions(visible_depth)), 0).r);
}

/// Equation (8), which is about the values that an image of 8 bits stores: sRGB-encoded ones.
fn with_highlights(rgb: vec3f) -> vec3f {
    let stored = srgb_encoded(rgb);
    let lambda = dot(stored, vec3f(0.3, 0.59, 0.11));
    if params.highlights == 0u || lambda <= params.highlight_threshold {
        return rgb;
    }
    // Above white the paper's polynomial would grow without bounds.
    let above = min((lambda - params.highlight_threshold) / (1.0 - params.highlight_threshold), 1.0);
    let share = pow(above, params.highlight_falloff);
    return min(srgb_decoded((1.0 - share + share * params.highlight_gain) * stored), vec3f(MAX_F16));
}

/// A source pixel: colour and 1, or 0 where there is nothing that can be drawn.
fn source(p: vec2u) -> vec4f {
    let texel = textureLoad(color, p, 0);
    let there = texel.a > 0.0 && is_finite_source(texel.rgb, textureLoad(depth, p, 0).r);
    if params.sheets != 0u {
        return select(vec4f(0.0), vec4f(with_highlights(texel.rgb / max(texel.a, 1e-6)) * texel.a, texel.a), there);
    }
    return select(vec4f(0.0), vec4f(with_highlights(texel.rgb), 1.0), there);
}

/// What is spread: a colour times its weight and the weight, the number of pixels that it
/// stands for, 0 for nothing; and its signed CoC diameter, px.
struct Spot {
    light: vec4f,
    c: f32,
}

fn pixel_spot(p: vec2u) -> Spot {
    return Spot(source(p), coc_diameter_px(lens, textureLoad(depth, p, 0).r));
}

/// A visible pixel, if its spot is larger than a pixel; the others are `sharp_light`.
fn visible_spot(p: vec2u) -> Spot {
    var spot = pixel_spot(p);
    spot.light = select(spot.light, vec4f(0.0), is_single_pixel_spot(sprites, lens, spot.c));
    return spot;
}

/// A visible pixel that stays within itself: it never gets to another layer.
fn sharp_light(p: vec2u) -> vec4f {
    return select(vec4f(0.0), source(p), is_single_pixel_spot(sprites, lens, visible_coc_px(vec2i(p))));
}

// ---- section 5: one spot for four pixels ----

const ONE_FOR_FOUR = 1u;
const EACH_ITS_OWN = 2u;

fn is_drawn_by(array: u32, block: vec2u) -> bool {
    return (textureLoad(arrays, block, 0).r & array) != 0u;
}

/// Four visible pixels as one; its place is their common corner.
fn block_spot(block: vec2u) -> Spot {
    var z = 0.0;
    var light = vec4f(0.0);
    for (var i = 0u; i < 4u; i++) {
        let p = 2u * block + vec2u(i & 1u, i >> 1u);
        z += 0.25 * textureLoad(depth, p, 0).r;
        light += source(p);
    }
    return Spot(light, coc_diameter_px(lens, z));
}

// ---- section 3.4 ----

const FRONT = 0;
const SAME = 1;
const BEHIND = 2;

/// The layer on which a spot arrives where the visible surface has the CoC `c_v`: equation
/// (6), with the longer diameter of an ellipse: so far its own pixels reach.
fn layer_of(c: f32, c_v: f32) -> i32 {
    let farther = c - c_v;
    if params.layered == 0u || abs(farther) <= params.delta * greatest_diameter_px(lens, c_v) {
        return SAME;
    }
    return select(BEHIND, FRONT, farther < 0.0);
}
