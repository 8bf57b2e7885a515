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
    /// Pixels of a circle that `table` has, along an axis.
    table_reach: u32,
    /// Share of a pixel that one of its sub-pixels stands for.
    share: f32,
    _0: u32,
    _1: u32,
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

/// Some rows of the chunks of offsets that a workgroup gathers from.
struct Part {
    /// The first of them, counted from the uppermost.
    first_row: u32,
    rows: u32,
    /// 1: what was gathered is the result.
    is_last: u32,
    _unused: u32,
}

@group(0) @binding(10) var<uniform> part: Part;
/// Gathered in parts before this one.
@group(0) @binding(11) var sums: texture_2d<f32>;
@group(0) @binding(12) var new_sums: texture_storage_2d<rgba32float, write>;

/// How many sub-pixels of a regular grid lie within circles (src/methods/linear/table.rs): where
/// the counts of each pixel begin, and two counts a word.
@group(0) @binding(13) var<storage, read> table_begins: array<u32>;
@group(0) @binding(14) var<storage, read> table: array<u32>;

const PI = 3.14159265;
const TILE = 16;
const HALF_DIAGONAL = 0.70710678;
/// Radius below which a circle lies within its own pixel.
const OWN_PIXEL_RADIUS = 0.5;

// A regular grid is measured in units of half a sub-pixel: rows and columns lie at a, a + 2, ...,
// a + 2 (side - 1), all of them whole numbers, and so are squared distances. Of a circle only its
// squared radius matters, `r2`, and only by which whole numbers are less.

fn squared_radius(radius: f32) -> f32 {
    let r = 2.0 * f32(params.side) * radius;
    return r * r;
}

/// Least and greatest squared distance of the sub-pixels of the pixel at `offset`, both
/// coordinates at least 0, the first the greater and at least 1.
fn distances_squared(offset: vec2f) -> vec2f {
    let side = f32(params.side);
    let near = 2.0 * side * offset - (side - 1.0);
    let far = 2.0 * side * offset + (side - 1.0);
    // In the circle's own row the nearest lies at 0, or beside it if their number is even.
    let beside = f32(1u - (params.side & 1u));
    let nearest = vec2f(near.x, max(near.y, beside));
    return vec2f(dot(nearest, nearest), dot(far, far));
}

/// Share of the sub-pixels that lie within the circle, row by row: all lie to the right of its
/// centre, those within it first.
fn grid_coverage(r2: f32, offset: vec2f) -> f32 {
    let side = f32(params.side);
    let first = 2.0 * side * offset - (side - 1.0);
    var count = 0.0;
    // Two rows a round, one of them beyond the pixel where `side` is odd.
    for (var row = 0u; row < params.side; row += 2u) {
        let rows = f32(row) + vec2f(0.0, 1.0);
        let y = first.y + 2.0 * rows;
        let half_chord = sqrt(max(r2 - y * y, vec2f(0.0)));
        let columns = clamp(ceil(0.5 * (half_chord - first.x)), vec2f(0.0), vec2f(side));
        count += columns.x + select(0.0, columns.y, rows.y < side);
    }
    return count / (side * side);
}

/// The same by the table, for a pixel with the least squared distance `nearest`.
fn table_coverage(r2: f32, offset: vec2u, nearest: f32) -> f32 {
    let pixel = offset.x * (offset.x + 1u) / 2u + offset.y;
    // The first count is that of the first whole number beyond the nearest one.
    let entry = table_begins[pixel] + u32(ceil(r2) - nearest) - 1u;
    let count = (table[entry / 2u] >> (16u * (entry & 1u))) & 0xffffu;
    return f32(count) * params.share;
}

/// Share of a pixel, not the circle's own one, as `distances_squared` has it.
fn regular_coverage(r2: f32, offset: vec2f) -> f32 {
    let distances = distances_squared(offset);
    if r2 <= distances.x {
        return 0.0;
    }
    if r2 > distances.y {
        return 1.0;
    }
    if offset.x <= f32(params.table_reach) {
        return table_coverage(r2, vec2u(offset), distances.x);
    }
    return grid_coverage(r2, offset);
}

/// The same of the circle's own pixel: its centre is the pixel's.
fn own_coverage(r2: f32) -> f32 {
    let side = f32(params.side);
    let first = -(side - 1.0);
    var count = 0.0;
    for (var row = 0u; row < params.side; row++) {
        let y = first + 2.0 * f32(row);
        let left = r2 - y * y;
        let half_chord = sqrt(max(left, 0.0));
        let end = clamp(ceil(0.5 * (half_chord - first)), 0.0, side);
        let begin = clamp(floor(0.5 * (-half_chord - first)) + 1.0, 0.0, side);
        count += select(0.0, max(end - begin, 0.0), left > 0.0);
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

/// 1: coverage is by a regular grid.
fn is_regular() -> bool {
    return params.naive == 0u && params.jittered == 0u;
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
    let r2 = squared_radius(radius);
    if folded.x == 0.0 {
        return own_coverage(r2);
    }
    return regular_coverage(r2, folded);
}

/// Sum of all coverages of a circle, from one eighth of the plane: column by column, the pixels
/// wholly inside at once. The column's ends are rounded outwards by a pixel, so that none is missed.
fn circle_area(radius: f32) -> f32 {
    let reach = u32(radius + 0.5);
    let inside = max(radius - HALF_DIAGONAL, 0.0);
    let outside = radius + HALF_DIAGONAL;
    var sum = 0.0;
    for (var x = 0u; x <= reach; x++) {
        let x2 = f32(x * x);
        let begin = min(u32(max(floor(sqrt(max(inside * inside - x2, 0.0))) - 1.0, 0.0)), x);
        let end = min(u32(sqrt(max(outside * outside - x2, 0.0))) + 1u, x);
        // Four images of the one on the axis, eight of the others.
        sum += select(0.0, 8.0 * f32(begin) - 4.0, begin > 0u);
        for (var y = begin; y <= end; y++) {
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

// Sources are gathered by their offset, the same one for all pixels of a workgroup: so neighbours
// that are blurred alike meet their sources' edges at the same time. The square of offsets that
// any source in reach has is cut into chunks, the sources of which fit into the workgroup's memory.

/// Pixels of a workgroup.
const PIXELS = vec2i(16, 8);
/// Offsets along a side of a chunk.
const CHUNK = 17;
/// Sources that they reach.
const WINDOW = vec2i(32, 24);
const SOURCES = 768u;
const INVOCATIONS = 128u;

/// Colour times energy for each covered pixel, and that energy.
var<workgroup> source_light: array<vec4f, 768>;
/// Its radius, px; where coverage is by a regular grid `squared_radius`. 0 of a circle within its
/// own pixel.
var<workgroup> source_size: array<f32, 768>;
/// Of all tiles in reach, of a chunk, and of the chunk after it.
var<workgroup> group_radius_bits: atomic<u32>;
var<workgroup> chunk_radius_bits: array<atomic<u32>, 2>;

/// Puts the source at `at` in the workgroup's memory, and returns its radius; nothing where
/// there is no pixel.
fn load_source(slot: u32, at: vec2i) -> f32 {
    var light = vec4f(0.0);
    // Reaches nothing.
    var radius = -1.0;
    if all(at >= vec2i(0)) && all(at < vec2i(textureDimensions(color))) {
        let rgb = textureLoad(color, at, 0).rgb;
        let circle = textureLoad(circles, at, 0).rg;
        // A pixel that is not finite must not spread.
        if is_finite(rgb) {
            light = vec4f(rgb * circle.g, circle.g);
            radius = circle.r;
        }
    }
    source_light[slot] = light;
    source_size[slot] = select(radius, squared_radius(radius), is_regular() && radius > 0.0);
    return radius;
}

/// Offset, px, up to which circles of the radius may reach a pixel.
fn offset_reached(radius: f32) -> i32 {
    return i32(min(radius, params.max_radius) + 0.5);
}

/// Greatest radius of tiles that reach the pixels from `first` to `last`, as far as one of the
/// workgroup's invocations looks.
fn radius_in_reach(first: vec2i, last: vec2i, index: u32) -> f32 {
    let tiles = vec2i(textureDimensions(tile_radius));
    let reach = i32(params.reach);
    let begin = max(first - reach, vec2i(0)) / TILE;
    let count = vec2u(min((last + reach) / TILE, tiles - 1) - begin + 1);
    var greatest = 0.0;
    for (var i = index; i < count.x * count.y; i += INVOCATIONS) {
        let tile = begin + vec2i(vec2u(i % count.x, i / count.x));
        let corner = tile * TILE;
        let gap = max(max(corner - last, first - corner - (TILE - 1)), vec2i(0));
        let radius = textureLoad(tile_radius, tile, 0).r;
        greatest = max(greatest, select(radius, 0.0, f32(max(gap.x, gap.y)) > radius + 0.5));
    }
    return greatest;
}

/// What the source in `slot` of the loaded window spreads to a pixel at `offset` from it.
fn light_of(slot: i32, offset: vec2f) -> vec4f {
    let radius = source_size[slot];
    if max(offset.x, offset.y) > radius + 0.5 {
        return vec4f(0.0);
    }
    var share = 1.0;
    if radius >= OWN_PIXEL_RADIUS {
        share = coverage(radius, offset);
    }
    return share * source_light[slot];
}

/// The same where coverage is by a regular grid. The offset is the same for all pixels of the
/// workgroup, and so is all that follows from it alone.
fn regular_light_of(slot: i32, offset: vec2f) -> vec4f {
    let r2 = source_size[slot];
    let folded = vec2f(max(offset.x, offset.y), min(offset.x, offset.y));
    if folded.x == 0.0 {
        var own = 1.0;
        if r2 > 0.0 {
            own = own_coverage(r2);
        }
        return own * source_light[slot];
    }
    let distances = distances_squared(folded);
    if r2 <= distances.x {
        return vec4f(0.0);
    }
    let light = source_light[slot];
    if r2 > distances.y {
        return light;
    }
    if folded.x <= f32(params.table_reach) {
        return table_coverage(r2, vec2u(folded), distances.x) * light;
    }
    return grid_coverage(r2, folded) * light;
}

/// What the sources of the loaded window whose offsets lie between `low` and `high` spread to the
/// pixel `local` of the workgroup; the window begins at the offset `begin`.
fn light_from_window(local: vec2i, begin: vec2i, low: vec2i, high: vec2i) -> vec4f {
    let regular = is_regular();
    var sum = vec4f(0.0);
    for (var y = low.y; y <= high.y; y++) {
        let row = (local.y + y - begin.y) * WINDOW.x + local.x - begin.x;
        for (var x = low.x; x <= high.x; x++) {
            let offset = vec2f(abs(vec2i(x, y)));
            if regular {
                sum += regular_light_of(row + x, offset);
            } else {
                sum += light_of(row + x, offset);
            }
        }
    }
    return sum;
}

@compute @workgroup_size(16, 8)
fn gather_circles(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let first = vec2i(group.xy) * PIXELS + i32(params.overscan);
    let at = vec2i(group.xy) * PIXELS + vec2i(local.xy);
    let is_inside = all(at < vec2i(textureDimensions(result)));
    // Beyond the image there are only hands to load with.
    var sum = vec4f(0.0);
    if is_inside && part.first_row > 0u {
        sum = textureLoad(sums, at, 0);
    }
    // Radii are not negative, so that bits order as the numbers do.
    atomicMax(&group_radius_bits, bitcast<u32>(radius_in_reach(first, first + PIXELS - 1, index)));
    workgroupBarrier();
    let reach = offset_reached(bitcast<f32>(atomicLoad(&group_radius_bits)));
    let chunks = u32(2 * reach + CHUNK) / u32(CHUNK);
    let first_row = min(part.first_row, chunks);
    let end = min(first_row + part.rows, chunks) * chunks;
    for (var chunk = first_row * chunks; chunk < end; chunk++) {
        let begin = CHUNK * vec2i(vec2u(chunk % chunks, chunk / chunks)) - reach;
        var greatest = 0.0;
        for (var i = index; i < SOURCES; i += INVOCATIONS) {
            let in_window = vec2i(vec2u(i % u32(WINDOW.x), i / u32(WINDOW.x)));
            greatest = max(greatest, load_source(i, first + begin + in_window));
        }
        atomicMax(&chunk_radius_bits[chunk & 1u], bitcast<u32>(greatest));
        workgroupBarrier();
        let reached = offset_reached(bitcast<f32>(atomicLoad(&chunk_radius_bits[chunk & 1u])));
        let low = max(begin, vec2i(-reached));
        let high = min(begin + CHUNK - 1, vec2i(min(reached, reach)));
        if is_inside {
            sum += light_from_window(vec2i(local.xy), begin, low, high);
        }
        workgroupBarrier();
        if index == 0u {
            atomicStore(&chunk_radius_bits[chunk & 1u], 0u);
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
