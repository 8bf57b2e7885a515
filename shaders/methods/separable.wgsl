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

/// What a pixel needs to know of a tap.
struct Weighted {
    /// Negative where the colour is not finite: such a tap reaches nothing.
    radius: f32,
    z: f32,
    /// What it counts where the circle reaches; and where it is nearer than the centre.
    weight: f32,
    weight_if_nearer: f32,
}

fn weighted(tap: Tap, is_finite_color: bool) -> Weighted {
    let weight = 1.0 / thinning(tap.radius);
    let nearer = saturate(tap.diameter - params.sharp_coc);
    return Weighted(select(-1.0, tap.radius, is_finite_color), tap.z, weight, nearer * weight);
}

/// The pixel that is filtered.
struct Centre {
    z: f32,
    radius: f32,
    weight: f32,
    /// Its colour; black where that is not finite.
    base: vec3f,
    /// Where it lies along the line, px, and how far to either side it looks.
    here: i32,
    extent: i32,
}

/// The pixel `at`, of which `color` lacks `cut` px.
fn centre_at(at: vec2i, step: vec2i, cut: vec2i) -> Centre {
    let tap = tap_at(at);
    var radius = tap.radius;
    if params.neighbours != 0u {
        radius = dot(textureLoad(tile_reach, at / TILE, 0).rg, vec2f(step));
    }
    let own = textureLoad(color, at - cut, 0).rgb;
    let base = select(vec3f(0.0), own, is_finite(own));
    let extent = i32(ceil(radius + 0.5)) - 1;
    return Centre(tap.z, tap.radius, 1.0 / thinning(tap.radius), base, dot(at, step), extent);
}

/// No filter looks farther than this, px.
fn greatest_extent() -> i32 {
    return i32(ceil(params.max_radius + 0.5));
}

/// Weight of the tap x px from the centre.
fn weight_of(centre: Centre, tap: Weighted, x: i32) -> f32 {
    let distance = f32(abs(x));
    var shared_reach = reach(tap.radius, distance);
    if params.neighbours == 0u {
        shared_reach = min(shared_reach, reach(centre.radius, distance));
    }
    // z = near / d: greater is nearer.
    let w = shared_reach * select(tap.weight, tap.weight_if_nearer, tap.z > centre.z);
    return select(w, select(0.0, centre.weight, tap.radius >= 0.0), x == 0);
}

/// Differences from the centre are summed, so that a constant colour stays exactly that.
struct Sum {
    light: vec3f,
    weight: f32,
}

fn with_tap(sum: Sum, centre: Centre, tap: Weighted, rgb: vec3f, x: i32) -> Sum {
    let w = weight_of(centre, tap, x);
    if w > 0.0 {
        return Sum(sum.light + w * (rgb - centre.base), sum.weight + w);
    }
    return sum;
}

/// Nothing is left where the only tap was not finite.
fn mean(sum: Sum, centre: Centre) -> vec3f {
    return select(centre.base, centre.base + sum.light / sum.weight, sum.weight > 0.0);
}

// ---- tap by tap: for software adapters ----

/// Filters along `step` around `p` of the outer frame; `color` lacks `cut` px of it.
fn filtered(p: vec2i, step: vec2i, cut: vec2i) -> vec3f {
    let centre = centre_at(p, step, cut);
    let first = max(-centre.extent, -centre.here);
    let last = min(greatest_extent(), min(centre.extent, dot(vec2i(textureDimensions(depth)), step) - 1 - centre.here));
    var sum = Sum(vec3f(0.0), 0.0);
    for (var x = first; x <= last; x++) {
        let q = p + x * step;
        let tap = weighted(tap_at(q), true);
        if weight_of(centre, tap, x) > 0.0 {
            let rgb = textureLoad(color, q - cut, 0).rgb;
            if is_finite(rgb) {
                sum = with_tap(sum, centre, tap, rgb, x);
            }
        }
    }
    return mean(sum, centre);
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

// ---- by windows: for hardware ----
//
// A workgroup filters pieces of some lines, rows or columns. It goes along them with a window of
// taps that all its pixels read from its memory: windows follow one another from the first tap
// that any of them needs to the last.

/// Pixels of a workgroup: 4 rows of 64, or 8 columns of 32. The window is 112 or 56 taps
/// long: what fits into 16 KB.
const INVOCATIONS = 256u;
const WINDOW_TAPS = 448u;
const ROWS = 4u;
const COLUMNS = 8u;

var<workgroup> tap_colors: array<vec3f, 448>;
/// As in `Weighted`.
var<workgroup> tap_weights: array<vec4f, 448>;
/// Farthest tap, px, of any pixel of the workgroup.
var<workgroup> farthest: atomic<u32>;

fn load_tap(slot: u32, q: vec2i, cut: vec2i) {
    let inside = clamp_to_image(q, textureDimensions(depth));
    let at = clamp_to_image(inside - cut, textureDimensions(color));
    let rgb = textureLoad(color, at, 0).rgb;
    let tap = weighted(tap_at(inside), is_finite(rgb));
    tap_colors[slot] = rgb;
    tap_weights[slot] = vec4f(tap.radius, tap.z, tap.weight, tap.weight_if_nearer);
}

/// As `filtered`, around `p`, which is in line `line` of `lines`; `group_first` is where the
/// workgroup begins.
fn filtered_by_windows(
    p: vec2i,
    step: vec2i,
    cut: vec2i,
    index: u32,
    line: u32,
    lines: u32,
    group_first: vec2i,
) -> vec3f {
    let size = vec2i(textureDimensions(depth));
    let at = clamp_to_image(clamp_to_image(p, textureDimensions(depth)) - cut, textureDimensions(color)) + cut;
    let centre = centre_at(at, step, cut);
    if all(p == at) {
        atomicMax(&farthest, u32(max(centre.extent, 0)));
    }
    workgroupBarrier();
    let farthest_tap = min(i32(atomicLoad(&farthest)), greatest_extent());
    let window = i32(WINDOW_TAPS / lines);
    let group_begin = dot(group_first, step);
    let begin = group_begin - farthest_tap;
    let taps = i32(INVOCATIONS / lines) + 2 * farthest_tap;
    let windows = (taps + window - 1) / window;
    // Slots follow one another as pixels of a row do.
    let down = step.y != 0;
    let stride = select(1u, lines, down);
    let line_stride = select(u32(window), 1u, down);
    var sum = Sum(vec3f(0.0), 0.0);
    for (var i = 0; i < windows; i++) {
        let first_tap = begin + i * window;
        workgroupBarrier();
        for (var slot = index; slot < WINDOW_TAPS; slot += INVOCATIONS) {
            let of_line = select(slot / line_stride, slot % stride, down);
            let along = i32(select(slot % line_stride, slot / stride, down));
            if i * window + along < taps {
                load_tap(slot, group_first + (first_tap + along - group_begin) * step + i32(of_line) * step.yx, cut);
            }
        }
        workgroupBarrier();
        let first = max(max(-centre.extent, -centre.here), first_tap - centre.here);
        let end = min(dot(size, step), first_tap + window) - centre.here;
        let last = min(greatest_extent(), min(centre.extent, end - 1));
        for (var x = first; x <= last; x++) {
            let slot = line * line_stride + u32(centre.here + x - first_tap) * stride;
            let tap = tap_weights[slot];
            sum = with_tap(sum, centre, Weighted(tap.x, tap.y, tap.z, tap.w), tap_colors[slot], x);
        }
    }
    return mean(sum, centre);
}

fn put(at: vec2u, rgb: vec3f) {
    if all(at < textureDimensions(result)) {
        textureStore(result, at, vec4f(rgb, 1.0));
    }
}

@compute @workgroup_size(64, 4)
fn filter_rows_by_windows(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let at = group.xy * vec2u(64u, ROWS) + local.xy;
    let outer = vec2i(i32(params.overscan), 0);
    let group_first = vec2i(group.xy * vec2u(64u, ROWS)) + outer;
    put(at, filtered_by_windows(vec2i(at) + outer, vec2i(1, 0), vec2i(0), index, local.y, ROWS, group_first));
}

@compute @workgroup_size(8, 32)
fn filter_columns_by_windows(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let at = group.xy * vec2u(COLUMNS, 32u) + local.xy;
    let outer = vec2i(i32(params.overscan));
    let group_first = vec2i(group.xy * vec2u(COLUMNS, 32u)) + outer;
    put(at, filtered_by_windows(vec2i(at) + outer, vec2i(0, 1), vec2i(outer.x, 0), index, local.x, COLUMNS, group_first));
}
