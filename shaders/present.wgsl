// From a linear HDR image to display values: exposure, tone map, sRGB, as src/display.rs
// does it on the CPU; and the overlays that show what is behind a picture.
//
//   color -> * 2^EV -> tone map -> clamp -> sRGB -> [overlay] -> RGBA8
//
// c is the signed CoC diameter in pixels, negative in front of the focus distance.

#import lens
#import color

struct Present {
    /// Two to the power of the exposure.
    gain: f32,
    /// 0 none, 1 Reinhard, 2 AgX.
    tone_map: u32,
    /// What reaches the end of the colour map: |c| in px, or the stored depth of the
    /// nearest surface, or a difference of display values.
    full_scale: f32,
    /// Margin of the depth around the colour, px.
    overscan: u32,
    /// Added to what a relative difference is relative to.
    dark: f32,
    /// How much an overlay hides of the picture, 0 to 1.
    opacity: f32,
}

/// One channel of a texture on a colour scale.
struct Plane {
    low: f32,
    high: f32,
    channel: u32,
    _unused: u32,
    /// Upper left corner of the texture, px of the picture, and its texels a pixel.
    min_px: vec2f,
    texels_per_px: vec2f,
}

@group(0) @binding(0) var<uniform> present: Present;
@group(0) @binding(1) var color: texture_2d<f32>;
@group(0) @binding(2) var other: texture_2d<f32>;
@group(0) @binding(3) var depth: texture_2d<f32>;
@group(0) @binding(4) var<uniform> lens: Lens;
@group(0) @binding(5) var<storage, read> color_map: array<vec4f, 256>;
@group(0) @binding(6) var result: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(7) var<uniform> plane: Plane;
@group(0) @binding(8) var<storage, read_write> bounds: array<atomic<u32>, 2>;

/// sRGB encoding of linear values in [0, 1] (IEC 61966-2-1).
fn srgb_encode(linear: vec3f) -> vec3f {
    let curve = 1.055 * pow(linear, vec3f(1.0 / 2.4)) - 0.055;
    return select(curve, 12.92 * linear, linear <= vec3f(0.0031308));
}

/// Reinhard et al. 2002, equation (3), on the luminance.
fn reinhard(c: vec3f) -> vec3f {
    return c / (1.0 + max(luminance(c), 0.0));
}

/// Wrensch's sixth-order fit of AgX's default contrast curve on [0, 1].
fn agx_contrast(x: vec3f) -> vec3f {
    let x2 = x * x;
    let x4 = x2 * x2;
    return 15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x - 0.00232;
}

/// AgX up to linear display values; constants and source as in src/display.rs.
fn agx(c: vec3f) -> vec3f {
    let inset = mat3x3f(
        vec3f(0.84247906, 0.042328242, 0.042375655),
        vec3f(0.0784336, 0.878468640, 0.0784336),
        vec3f(0.079223745, 0.07916613, 0.879143),
    );
    let outset = mat3x3f(
        vec3f(1.196879, -0.05289685, -0.052971635),
        vec3f(-0.09802088, 1.1519031, -0.09804345),
        vec3f(-0.09902974, -0.09896118, 1.1510737),
    );
    let min_ev = -12.47393;
    let max_ev = 4.026069;
    // WGSL leaves log2(0) open; 2^-24 lies below the darkest value already.
    let exposed = max(inset * max(c, vec3f(0.0)), vec3f(exp2(-24.0)));
    let x = (clamp(log2(exposed), vec3f(min_ev), vec3f(max_ev)) - min_ev) / (max_ev - min_ev);
    return pow(max(outset * agx_contrast(x), vec3f(0.0)), vec3f(2.2));
}

/// sRGB-encoded display value of a linear scene-referred colour.
fn encoded(scene: vec3f) -> vec3f {
    var c = scene * present.gain;
    if present.tone_map == 1u {
        c = reinhard(c);
    } else if present.tone_map == 2u {
        c = agx(c);
    }
    return srgb_encode(clamp(c, vec3f(0.0), vec3f(1.0)));
}

fn encoded_at(p: vec2u) -> vec3f {
    return encoded(textureLoad(color, p, 0).rgb);
}

fn coc_at(p: vec2u) -> f32 {
    return coc_diameter_px(lens, textureLoad(depth, p + present.overscan, 0).r);
}

/// Colour of t in [0, 1].
fn mapped(t: f32) -> vec3f {
    return color_map[u32(round(clamp(t, 0.0, 1.0) * 255.0))].rgb;
}

/// The picture as grey: under a map its colours would look like the map's.
fn grey_at(p: vec2u) -> vec3f {
    return vec3f(luminance(encoded_at(p)));
}

/// A map's colour with so much of the picture left that one finds one's way in it.
fn over_picture(map: vec3f, p: vec2u) -> vec3f {
    return mix(grey_at(p), map, present.opacity);
}

fn store(p: vec2u, c: vec3f) {
    textureStore(result, p, vec4f(c, 1.0));
}

@compute @workgroup_size(8, 8)
fn picture(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(result)) {
        return;
    }
    store(id.xy, encoded_at(id.xy));
}

/// The signed CoC, from -full_scale to full_scale over the map.
@compute @workgroup_size(8, 8)
fn coc(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(result)) {
        return;
    }
    store(id.xy, over_picture(mapped(0.5 + 0.5 * coc_at(id.xy) / present.full_scale), id.xy));
}

/// Reciprocal depth, the nearest surface at the end of the map and infinity at its start.
@compute @workgroup_size(8, 8)
fn reciprocal_depth(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(result)) {
        return;
    }
    let z = textureLoad(depth, id.xy + present.overscan, 0).r;
    store(id.xy, over_picture(mapped(z / present.full_scale), id.xy));
}

/// What |c| <= full_scale keeps its colours; the rest is grey, tinted with the map's ends.
@compute @workgroup_size(8, 8)
fn zone(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(result)) {
        return;
    }
    let c = coc_at(id.xy);
    var shown = encoded_at(id.xy);
    if abs(c) > present.full_scale {
        shown = over_picture(mapped(select(1.0, 0.0, c < 0.0)), id.xy);
    }
    store(id.xy, shown);
}

/// The greatest difference of display values over the channels.
@compute @workgroup_size(8, 8)
fn difference(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(result)) {
        return;
    }
    let d = abs(encoded_at(id.xy) - encoded(textureLoad(other, id.xy, 0).rgb));
    store(id.xy, mapped(max(d.r, max(d.g, d.b)) / present.full_scale));
}

/// The mean over the channels of a - b, from -full_scale to full_scale over the map.
@compute @workgroup_size(8, 8)
fn signed_difference(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(result)) {
        return;
    }
    let d = encoded_at(id.xy) - encoded(textureLoad(other, id.xy, 0).rgb);
    store(id.xy, mapped(0.5 + 0.5 * dot(d, vec3f(1.0 / 3.0)) / present.full_scale));
}

/// The greatest |a - b| / (|b| + dark) of linear values over the channels; `dark` keeps
/// noise in black from counting as a difference.
@compute @workgroup_size(8, 8)
fn relative_difference(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(result)) {
        return;
    }
    let b = textureLoad(other, id.xy, 0).rgb;
    let d = abs(textureLoad(color, id.xy, 0).rgb - b) / (abs(b) + present.dark);
    store(id.xy, mapped(max(d.r, max(d.g, d.b)) / present.full_scale));
}

fn ordered(v: f32) -> u32 {
    // Makes the bits of any two floats order as the floats do.
    let bits = bitcast<u32>(v);
    return select(bits | 0x80000000u, ~bits, (bits & 0x80000000u) != 0u);
}

/// Least and greatest finite value of one channel.
@compute @workgroup_size(8, 8)
fn channel_range(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(color)) {
        return;
    }
    let v = textureLoad(color, id.xy, 0)[plane.channel];
    if is_finite(vec3f(v)) {
        atomicMin(&bounds[0], ordered(v));
        atomicMax(&bounds[1], ordered(v));
    }
}

/// The map's colour of a value, `low` at its start and `high` at its end.
fn mapped_between(v: f32) -> vec3f {
    return mapped((v - plane.low) / max(plane.high - plane.low, 1.0e-30));
}

/// One channel alone.
@compute @workgroup_size(8, 8)
fn one_channel(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(result)) {
        return;
    }
    store(id.xy, mapped_between(textureLoad(color, id.xy, 0)[plane.channel]));
}

/// One channel of `other` over the picture: of each pixel the texel that its centre lies in.
@compute @workgroup_size(8, 8)
fn one_channel_over(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(result)) {
        return;
    }
    let texel = vec2i(floor((vec2f(id.xy) + 0.5 - plane.min_px) * plane.texels_per_px));
    var shown = grey_at(id.xy);
    if all(texel >= vec2i(0)) && all(texel < vec2i(textureDimensions(other))) {
        let v = textureLoad(other, texel, 0)[plane.channel];
        if is_finite(vec3f(v)) {
            shown = over_picture(mapped_between(v), id.xy);
        }
    }
    store(id.xy, shown);
}
