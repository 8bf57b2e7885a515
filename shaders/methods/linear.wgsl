// linear: each pixel's light spread evenly over its circle (src/methods/linear.rs).
//
// Gathered: out(p) = sum over q of e_q k(r_q, |p - q|). The kernel k is the share of p
// that the circle around q covers, over the sum of those shares, so that each circle's
// energies sum to 1. The arithmetic is that of src/methods/linear/circle.rs in f32.
//
//        +---+---+---+        within sqrt(2)/2 of the edge: supersampled
//        | 8 |96 |82 |        farther inside: 100 %, farther outside: 0
//        +---+---+---+

#import lens
#import color

struct Params {
    /// Radius of a circle over the CoC diameter.
    radius_per_coc: f32,
    /// Radius, px, to which greater circles are cut.
    max_radius: f32,
    /// 1: a pixel lies in a circle or not.
    naive: u32,
    /// 1: sub-pixels come from `sub_pixels`; 0: they lie on a regular grid.
    jittered: u32,
    /// Sub-pixels along each side of a pixel.
    side: u32,
    /// 1: divide by the energy of a white image.
    normalise: u32,
    /// Overscan, px.
    overscan: u32,
    /// Pixels that the greatest circle in view may reach along an axis.
    reach: u32,
}

@group(0) @binding(0) var<uniform> lens: Lens;
@group(0) @binding(1) var<uniform> params: Params;
@group(0) @binding(2) var<storage, read> sub_pixels: array<vec2f>;
@group(0) @binding(3) var color: texture_2d<f32>;
@group(0) @binding(4) var depth: texture_2d<f32>;
/// (r, energy for each covered pixel).
@group(0) @binding(5) var circles_out: texture_storage_2d<rg32float, write>;
@group(0) @binding(6) var tile_radius_out: texture_storage_2d<r32float, write>;
@group(0) @binding(7) var circles: texture_2d<f32>;
@group(0) @binding(8) var tile_radius: texture_2d<f32>;
@group(0) @binding(9) var result: texture_storage_2d<COLOR_FORMAT, write>;

/// Some rows of the tiles of sources that reach a tile.
struct Part {
    /// The first of them, counted from the uppermost that reaches it.
    first_row: i32,
    rows: i32,
    /// 1: what was gathered is the result.
    is_last: u32,
    _unused: u32,
}

@group(0) @binding(10) var<uniform> part: Part;
/// Gathered in parts before this one.
@group(0) @binding(11) var sums: texture_2d<f32>;
@group(0) @binding(12) var new_sums: texture_storage_2d<rgba32float, write>;

const PI = 3.14159265;
const TILE = 16;
const HALF_DIAGONAL = 0.70710678;
/// Radius below which a circle lies within its own pixel.
const OWN_PIXEL_RADIUS = 0.5;

/// Four rows are counted in each round of a loop, and sources are gathered in parts: llvmpipe
/// ends all loops of an invocation after 65,535 rounds in all, inner ones counted, and a
/// circle of 300 px across has more pixels than that.
const FOUR = vec4f(0.0, 1.0, 2.0, 3.0);

/// Sub-pixels of the pixel at `offset` within the circle, row by row of a regular grid, in
/// units of half a sub-pixel: the columns lie at a, a + 2, ..., a + 2 (side - 1).
fn grid_coverage(radius: f32, offset: vec2f) -> f32 {
    let side = f32(params.side);
    let first = 2.0 * side * offset - (side - 1.0);
    let r = 2.0 * side * radius;
    var count = 0.0;
    for (var row = 0u; row < params.side; row += 4u) {
        let rows = f32(row) + FOUR;
        let y = first.y + 2.0 * rows;
        let left = r * r - y * y;
        let half_chord = sqrt(max(left, vec4f(0.0)));
        let end = clamp(ceil(0.5 * (half_chord - first.x)), vec4f(0.0), vec4f(side));
        let begin = clamp(floor(0.5 * (-half_chord - first.x)) + 1.0, vec4f(0.0), vec4f(side));
        let columns = max(end - begin, vec4f(0.0));
        count += dot(select(vec4f(0.0), columns, (rows < vec4f(side)) & (left > vec4f(0.0))), vec4f(1.0));
    }
    return count / (side * side);
}

/// 1 where a sub-pixel of the pixel at `offset` lies within the circle.
fn jittered_share(radius: f32, offset: vec2f, i: u32) -> f32 {
    if i >= params.side * params.side {
        return 0.0;
    }
    let at = offset + sub_pixels[i];
    return select(0.0, 1.0, dot(at, at) < radius * radius);
}

fn jittered_coverage(radius: f32, offset: vec2f) -> f32 {
    var count = 0.0;
    for (var i = 0u; i < params.side * params.side; i += 4u) {
        count += jittered_share(radius, offset, i) + jittered_share(radius, offset, i + 1u);
        count += jittered_share(radius, offset, i + 2u) + jittered_share(radius, offset, i + 3u);
    }
    return count / f32(params.side * params.side);
}

/// Share of the pixel at `offset`, both coordinates at least 0, within the circle.
fn coverage(radius: f32, offset: vec2f) -> f32 {
    let distance = length(offset);
    if params.naive != 0u {
        return select(0.0, 1.0, distance < radius);
    }
    if distance + HALF_DIAGONAL <= radius {
        return 1.0;
    }
    if distance - HALF_DIAGONAL >= radius {
        return 0.0;
    }
    // The same for all eight mirror images, so that a mirrored image is blurred alike.
    let folded = vec2f(max(offset.x, offset.y), min(offset.x, offset.y));
    if params.jittered != 0u {
        return jittered_coverage(radius, folded);
    }
    return grid_coverage(radius, folded);
}

/// Sum of all coverages of a circle, from one eighth of the plane.
fn circle_area(radius: f32) -> f32 {
    let reach = u32(radius + 0.5);
    var sum = 0.0;
    for (var x = 0u; x <= reach; x++) {
        for (var y = 0u; y <= x; y++) {
            let images = select(select(8.0, 4.0, y == 0u || x == y), 1.0, x == 0u);
            sum += images * coverage(radius, vec2f(vec2u(x, y)));
        }
    }
    return sum;
}

var<workgroup> greatest_radius_bits: atomic<u32>;

@compute @workgroup_size(16, 16)
fn measure_circles(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(workgroup_id) tile: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    // A radius outside the image is 0 and a radius is not negative, so that bits order as
    // the numbers do.
    var radius = 0.0;
    if all(id.xy < textureDimensions(depth)) {
        let c = coc_diameter_px(lens, textureLoad(depth, id.xy, 0).r);
        let wanted = min(params.radius_per_coc * abs(c), params.max_radius);
        var energy = 1.0;
        if is_finite(vec3f(c)) && wanted >= OWN_PIXEL_RADIUS {
            radius = wanted;
            energy = 1.0 / select(circle_area(radius), PI * radius * radius, params.naive != 0u);
        }
        textureStore(circles_out, id.xy, vec4f(radius, energy, 0.0, 0.0));
    }
    atomicMax(&greatest_radius_bits, bitcast<u32>(radius));
    workgroupBarrier();
    if local == 0u {
        textureStore(tile_radius_out, tile.xy, vec4f(bitcast<f32>(atomicLoad(&greatest_radius_bits))));
    }
}

/// Colour times energy for each covered pixel, and that energy.
var<workgroup> source_light: array<vec4f, 256>;
var<workgroup> source_radius: array<f32, 256>;

/// Puts the source at `at` in the workgroup's memory; nothing where there is no pixel.
fn load_source(slot: u32, at: vec2i) {
    var light = vec4f(0.0);
    // Reaches nothing.
    var radius = -1.0;
    if all(at < vec2i(textureDimensions(color))) {
        let rgb = textureLoad(color, at, 0).rgb;
        let circle = textureLoad(circles, at, 0).rg;
        // A pixel that is not finite must not spread.
        if is_finite(rgb) {
            light = vec4f(rgb * circle.g, circle.g);
            radius = circle.r;
        }
    }
    source_light[slot] = light;
    source_radius[slot] = radius;
}

/// What the loaded tile, whose corner is `corner`, spreads to the pixel `p`.
fn light_from_tile(p: vec2i, corner: vec2i) -> vec4f {
    var sum = vec4f(0.0);
    for (var i = 0; i < TILE * TILE; i++) {
        let radius = source_radius[i];
        let offset = vec2f(abs(p - corner - vec2i(i % TILE, i / TILE)));
        if max(offset.x, offset.y) > radius + 0.5 {
            continue;
        }
        var share = 1.0;
        if radius >= OWN_PIXEL_RADIUS {
            share = coverage(radius, offset);
        }
        sum += share * source_light[i];
    }
    return sum;
}

@compute @workgroup_size(16, 16)
fn gather_circles(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let first = vec2i(group.xy) * TILE + i32(params.overscan);
    let last = first + TILE - 1;
    let p = first + vec2i(local.xy);
    let tiles = vec2i(textureDimensions(tile_radius));
    let reach = i32(params.reach);
    let begin = max(first - reach, vec2i(0)) / TILE;
    let end = min((last + reach) / TILE, tiles - 1);
    let at = p - i32(params.overscan);
    let is_inside = all(at < vec2i(textureDimensions(result)));
    var sum = vec4f(0.0);
    if is_inside && part.first_row > 0 {
        sum = textureLoad(sums, at, 0);
    }
    let first_row = begin.y + part.first_row;
    for (var y = first_row; y <= min(end.y, first_row + part.rows - 1); y++) {
        for (var x = begin.x; x <= end.x; x++) {
            let corner = vec2i(x, y) * TILE;
            let gap = max(max(corner - last, first - corner - (TILE - 1)), vec2i(0));
            if f32(max(gap.x, gap.y)) > textureLoad(tile_radius, vec2i(x, y), 0).r + 0.5 {
                continue;
            }
            workgroupBarrier();
            load_source(index, corner + vec2i(local.xy));
            workgroupBarrier();
            // Beyond the image there are only hands to load with.
            if is_inside {
                sum += light_from_tile(p, corner);
            }
        }
    }
    if is_inside && part.is_last == 0u {
        textureStore(new_sums, at, sum);
        return;
    }
    if params.normalise != 0u && sum.w > 0.0 {
        sum /= sum.w;
    }
    if is_inside {
        textureStore(result, at, vec4f(clamp(sum.rgb, vec3f(-MAX_F16), vec3f(MAX_F16)), 1.0));
    }
}
