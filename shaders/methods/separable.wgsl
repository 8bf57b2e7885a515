// separable: an adaptive filter along rows, then columns (src/methods/separable.rs).
//
//   weight of tap q at x px from the centre p
//     = reach(r_q, x) / thinning(r_q) * [q farther than p, or blurred]
//
//         1 ------.                 reach: the circle of radius r_q, with a ramp of one
//                  \                pixel around its edge
//         0 --------'----> |x|
//                 r_q

#import lens
#import color
#import sampling

struct Params {
    /// Filter radius over the CoC diameter.
    radius_per_coc: f32,
    /// Radius, px, to which wider filters are cut.
    max_radius: f32,
    /// CoC diameter, px, up to which a nearer tap is refused.
    sharp_coc: f32,
    /// 1: look as far as any circle reaches; 0: over the pixel's own circle.
    neighbours: u32,
    /// 1: thin light by the circle's diameter; 0: by its area.
    by_diameter: u32,
    /// Overscan, px.
    overscan: u32,
}

@group(0) @binding(0) var<uniform> lens: Lens;
@group(0) @binding(1) var<uniform> params: Params;
@group(0) @binding(2) var color: texture_2d<f32>;
@group(0) @binding(3) var depth: texture_2d<f32>;
@group(0) @binding(4) var tile_radius_out: texture_storage_2d<r32float, write>;
@group(0) @binding(5) var tile_radius: texture_2d<f32>;
@group(0) @binding(6) var tile_reach_out: texture_storage_2d<rg32float, write>;
/// Greatest radius that reaches a tile along rows and along columns.
@group(0) @binding(7) var tile_reach: texture_2d<f32>;
@group(0) @binding(8) var result: texture_storage_2d<COLOR_FORMAT, write>;

const PI = 3.14159265;
const TILE = 16;

struct Tap {
    z: f32,
    /// CoC diameter, px.
    diameter: f32,
    /// Filter radius, px.
    radius: f32,
}

fn tap_at(p: vec2i) -> Tap {
    let z = textureLoad(depth, p, 0).r;
    let c = abs(coc_diameter_px(lens, z));
    // A depth that is not finite has no blur.
    let diameter = select(0.0, c, is_finite(vec3f(c)));
    return Tap(z, diameter, min(params.radius_per_coc * diameter, params.max_radius));
}

// ---- how far circles reach, for reach "neighbours" ----

@compute @workgroup_size(8, 8)
fn tile_radii(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(depth);
    let corner = TILE * id.xy;
    if any(corner >= size) {
        return;
    }
    var greatest = 0.0;
    for (var i = 0u; i < TILE * TILE; i++) {
        let p = min(corner + vec2u(i % TILE, i / TILE), size - 1);
        greatest = max(greatest, tap_at(vec2i(p)).radius);
    }
    textureStore(tile_radius_out, id.xy, vec4f(greatest));
}

/// Greatest radius among the tiles along `step` that reaches the tile `at`.
fn dilated(at: vec2i, step: vec2i) -> f32 {
    let tiles = vec2i(textureDimensions(tile_radius));
    let count = dot(tiles, step);
    let here = dot(at, step);
    var greatest = 0.0;
    for (var other = 0; other < count; other++) {
        let radius = textureLoad(tile_radius, at + (other - here) * step, 0).r;
        // From the last pixel of one to the first of the other.
        let gap = max(TILE * abs(other - here) - (TILE - 1), 0);
        greatest = max(greatest, select(0.0, radius, f32(gap) < radius + 0.5));
    }
    return greatest;
}

@compute @workgroup_size(8, 8)
fn dilate_tiles(@builtin(global_invocation_id) id: vec3u) {
    let at = vec2i(id.xy);
    if all(at < vec2i(textureDimensions(tile_radius))) {
        textureStore(tile_reach_out, at, vec4f(dilated(at, vec2i(1, 0)), dilated(at, vec2i(0, 1)), 0.0, 0.0));
    }
}

// ---- the filter ----

/// Share of a circle's light that a tap at `distance` gives, with a ramp of one pixel.
fn reach(radius: f32, distance: f32) -> f32 {
    return saturate(radius + 0.5 - distance);
}

/// A circle within its pixel has the pixel's own area, or width.
fn thinning(radius: f32) -> f32 {
    if params.by_diameter != 0u {
        return max(2.0 * radius, 1.0);
    }
    return max(PI * radius * radius, 1.0);
}

fn weight(centre: Tap, tap: Tap, distance: f32) -> f32 {
    var shared_reach = reach(tap.radius, distance);
    if params.neighbours == 0u {
        shared_reach = min(shared_reach, reach(centre.radius, distance));
    }
    var w = shared_reach / thinning(tap.radius);
    // z = near / d: greater is nearer.
    if tap.z > centre.z {
        w *= saturate(tap.diameter - params.sharp_coc);
    }
    return w;
}

/// Filters along `step` around `p` of the outer frame; `color` lacks `cut` px of it.
fn filtered(p: vec2i, step: vec2i, cut: vec2i) -> vec3f {
    let size = vec2i(textureDimensions(depth));
    let centre = tap_at(p);
    var radius = centre.radius;
    if params.neighbours != 0u {
        radius = dot(textureLoad(tile_reach, p / TILE, 0).rg, vec2f(step));
    }
    let here = dot(p, step);
    let extent = i32(ceil(radius + 0.5)) - 1;
    let first = max(-extent, -here);
    let last = min(extent, dot(size, step) - 1 - here);
    // Differences from the centre are summed, so that a constant colour stays exactly that.
    let own = textureLoad(color, p - cut, 0).rgb;
    let base = select(vec3f(0.0), own, is_finite(own));
    var sum = vec3f(0.0);
    var weights = 0.0;
    for (var x = first; x <= last; x++) {
        let q = p + x * step;
        var w = 1.0 / thinning(centre.radius);
        if x != 0 {
            w = weight(centre, tap_at(q), f32(abs(x)));
        }
        if w > 0.0 {
            let rgb = textureLoad(color, q - cut, 0).rgb;
            if is_finite(rgb) {
                sum += w * (rgb - base);
                weights += w;
            }
        }
    }
    // Nothing is left where the only tap was not finite.
    return select(base, base + sum / weights, weights > 0.0);
}

@compute @workgroup_size(8, 8)
fn filter_rows(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(result)) {
        return;
    }
    let p = vec2i(id.xy) + vec2i(i32(params.overscan), 0);
    textureStore(result, id.xy, vec4f(filtered(p, vec2i(1, 0), vec2i(0)), 1.0));
}

@compute @workgroup_size(8, 8)
fn filter_columns(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(result)) {
        return;
    }
    let p = vec2i(id.xy) + i32(params.overscan);
    textureStore(result, id.xy, vec4f(filtered(p, vec2i(0, 1), vec2i(i32(params.overscan), 0)), 1.0));
}
