// lens-layers: lens rays through depth-peeled layers (src/methods/lens_layers.rs).
//
// Lee, Eisemann and Seidel, SIGGRAPH 2010. In (x, y, s), s = c / 2 the signed CoC radius in
// pixels, the lens ray through pixel p and lens point v is straight: it is at p - v s. Each layer
// is a height field of s; a ray meets them from near to far:
//
//        p                        s grows away from the eye
//   ----\|-----  layer 0          the ray leans over by |v| px for each px of s
//        |\  ____ layer 0
//   -----|-\---  layer 1

#import hash
#import lens
#import sheet_rays
#import tile_lists

struct Params {
    /// Of the outer frame, px.
    size: vec2u,
    overscan: u32,
    layers: u32,
    /// Lens points a pixel, and sets of them: each pixel has one.
    samples: u32,
    sets: u32,
    /// Greatest |v| of a lens point.
    lens_radius: f32,
    /// Levels of the bounds.
    levels: u32,
}

/// s of a texel without a surface.
const EMPTY_S = 60000.0;

@group(0) @binding(0) var<uniform> lens: Lens;
@group(0) @binding(1) var<uniform> params: Params;
/// The first layer, with its lights; then the layers behind it.
@group(0) @binding(2) var first_color: texture_2d<f32>;
@group(0) @binding(3) var colors: texture_2d_array<f32>;
@group(0) @binding(4) var depth: texture_2d_array<f32>;
@group(0) @binding(5) var<storage, read> lens_points: array<vec2f>;
/// s of up to four layers.
@group(0) @binding(6) var radii: texture_2d<f32>;
@group(0) @binding(7) var bounds: texture_2d<f32>;
@group(0) @binding(8) var new_radii: texture_storage_2d<rgba32float, write>;
/// Least and greatest s of all layers in squares of texels.
@group(0) @binding(9) var new_bounds: texture_storage_2d<rgba32float, write>;
@group(0) @binding(10) var finer: texture_2d<f32>;
@group(0) @binding(11) var result: texture_storage_2d<COLOR_FORMAT, write>;

// ---- how far layers lie from focus, and within which bounds ----

/// Greatest |s|, px: rays that leave the picture by more see its border.
const GREATEST_S = 4096.0;

@compute @workgroup_size(8, 8)
fn measure(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= params.size) {
        return;
    }
    var s = vec4f(EMPTY_S);
    for (var k = 0u; k < min(params.layers, 4u); k++) {
        let z = textureLoad(depth, id.xy, k, 0).r;
        s[k] = select(clamp(0.5 * coc_diameter_px(lens, z), -GREATEST_S, GREATEST_S), EMPTY_S, z < 0.0);
    }
    textureStore(new_radii, id.xy, s);
    let filled = s < vec4f(EMPTY_S);
    let low = min(min(s.x, s.y), min(s.z, s.w));
    let high = max(
        max(select(-EMPTY_S, s.x, filled.x), select(-EMPTY_S, s.y, filled.y)),
        max(select(-EMPTY_S, s.z, filled.z), select(-EMPTY_S, s.w, filled.w)),
    );
    textureStore(new_bounds, id.xy, vec4f(low, high, 0.0, 0.0));
}

/// Bounds of 2x2 squares.
@compute @workgroup_size(8, 8)
fn widen(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(new_bounds)) {
        return;
    }
    let last = textureDimensions(finer) - 1u;
    var low = EMPTY_S;
    var high = -EMPTY_S;
    for (var i = 0u; i < 4u; i++) {
        let part = textureLoad(finer, min(2u * id.xy + vec2u(i & 1u, i >> 1u), last), 0).rg;
        low = min(low, part.x);
        high = max(high, part.y);
    }
    textureStore(new_bounds, id.xy, vec4f(low, high, 0.0, 0.0));
}

/// Least and greatest s within `reach` px of a pixel, of the level whose squares are at least as wide:
/// 3x3 of them cover it.
fn bounds_around(pixel: vec2i, reach: f32) -> vec2f {
    let level = i32(clamp(ceil(log2(max(reach, 1.0))), 0.0, f32(params.levels - 1u)));
    let last = vec2i(textureDimensions(bounds, level)) - 1;
    let middle = pixel >> vec2u(u32(level));
    var low = EMPTY_S;
    var high = -EMPTY_S;
    for (var i = 0; i < 9; i++) {
        let at = clamp(middle + vec2i(i % 3, i / 3) - 1, vec2i(0), last);
        let part = textureLoad(bounds, at, level).rg;
        low = min(low, part.x);
        high = max(high, part.y);
    }
    return vec2f(low, high);
}

// ---- rays ----

/// Difference of s, px, up to which two neighbouring texels of a layer are one surface, that a ray
/// passes through between them: layers lie half a pixel to a pixel apart.
const ONE_SURFACE_S = 1.0;

/// Most texels that a ray visits; longer ones take longer steps.
const MAX_STEPS = 1024u;

fn on_image(p: vec2f) -> vec2i {
    return clamp(vec2i(floor(p)), vec2i(0), vec2i(params.size) - 1);
}

/// A solid surface that a ray meets: what it shows and 1, or 0 where there is none, and its s.
struct Met {
    color: vec4f,
    s: f32,
}

/// What a ray sees and 1, or what sheets cover of one that meets nothing solid.
fn see(p: vec2f, v: vec2f, range: vec2f, sheets: vec2f) -> vec4f {
    let met = trace(p, v, range.x, range.y);
    var ray = sheet_ray(p, v, sheets);
    var sum = vec4f(0.0);
    for (var i = 0u; i < MOST_CROSSINGS; i++) {
        let crossing = next_sheet(&ray, lens, met.s);
        if crossing.light.a <= 0.0 {
            break;
        }
        sum += crossing.light;
    }
    return sum + ray.left * met.color;
}

/// The nearest solid surface that a ray meets where s lies between `low` and `high`.
fn trace(p: vec2f, v: vec2f, low: f32, high: f32) -> Met {
    let steps = clamp(ceil(length(v) * (high - low)), 1.0, f32(MAX_STEPS));
    let step_s = (high - low) / steps;
    var before = vec4f(EMPTY_S);
    for (var i = 0u; i < min(u32(steps), MAX_STEPS); i++) {
        let from_s = low + f32(i) * step_s;
        let to_s = from_s + step_s;
        let at = on_image(p - v * (from_s + 0.5 * step_s));
        let s = textureLoad(radii, at, 0);
        for (var k = 0u; k < 4u; k++) {
            // The ray meets it here, or passed through it since the texel before.
            let inside = s[k] >= from_s && s[k] <= to_s + 1e-3;
            let crossed = i > 0u && s[k] < from_s && before[k] >= from_s && before[k] - s[k] <= ONE_SURFACE_S;
            if inside || crossed {
                if k == 0u {
                    return Met(vec4f(textureLoad(first_color, at, 0).rgb, 1.0), s[k]);
                }
                return Met(vec4f(textureLoad(colors, at, k, 0).rgb, 1.0), s[k]);
            }
        }
        before = s;
    }
    return Met(vec4f(0.0), GREATEST_S);
}

@compute @workgroup_size(8, 8)
fn trace_tiles(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let tile = listed_tile(group);
    let id = tile * TILE + local.xy;
    if !is_tile(tile) || any(id >= textureDimensions(result)) {
        return;
    }
    let pixel = id + params.overscan;
    let p = vec2f(pixel) + 0.5;
    // Within the reach of all that is seen anywhere, then within that of what lies there.
    let anywhere = textureLoad(bounds, vec2u(0u), params.levels - 1u).rg;
    let widest = params.lens_radius * max(abs(anywhere.x), abs(anywhere.y));
    let near = bounds_around(vec2i(pixel), widest);
    let reach = params.lens_radius * max(abs(near.x), abs(near.y));
    let range = bounds_around(vec2i(pixel), reach);
    let sheets = sheet_bounds_of(tile.y * ((textureDimensions(result).x + TILE - 1u) / TILE) + tile.x);
    let first = (hash(id.x + hash(id.y)) % params.sets) * params.samples;
    var sum = vec4f(0.0);
    for (var i = 0u; i < params.samples; i++) {
        sum += see(p, lens_points[first + i], range, sheets);
    }
    // Rays between texels of a slope meet nothing: the others stand for them.
    var color = textureLoad(first_color, pixel, 0).rgb;
    if sum.a > 0.0 {
        color = sum.rgb / sum.a;
    }
    textureStore(result, id, vec4f(color, 1.0));
}
