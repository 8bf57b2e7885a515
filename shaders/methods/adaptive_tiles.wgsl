// adaptive, passes 1 and 2: which CoC radii the lens rays of each 8x8 tile can meet
// (src/methods/adaptive/tiles.rs).
//
//   mark_tiles      s of all layers packed in one texel; the tile's occupied bins
//   dilate_rows     bins of the tiles to the left and right whose blur reaches here
//   classify_tiles  the same up and down, the umbra cull, the class, the lists

#import layers

@group(0) @binding(2) var depth: texture_2d_array<f32>;
@group(0) @binding(3) var radii: texture_storage_2d<rgba16float, write>;
@group(0) @binding(4) var<storage, read_write> marked: array<Tile>;
@group(0) @binding(5) var<storage, read_write> rows: array<Tile>;
@group(0) @binding(6) var<storage, read_write> dilated: array<Tile>;
/// By 8x8 pixels of the outer frame, bit 0 where the first layer holds light that is kept apart; one
/// element where there is none at all.
@group(0) @binding(14) var<storage, read> light_tiles: array<u32>;
/// The number of emitters, then the length of each inner tile's list of them.
@group(0) @binding(10) var<storage, read> emitter_counts: array<u32>;
/// By inner tile: s of the nearest and the farthest sheet that its rays can meet, the first the
/// greater where there is none. One element is bound where there are no sheets at all.
@group(0) @binding(11) var<storage, read> sheet_bounds: array<vec2f>;
/// By tile of the layers, whether hidden ones may be seen there (src/view/peel.rs): they are empty
/// elsewhere.
@group(0) @binding(12) var<storage, read> needed: array<u32>;
/// By inner tile, its buckets: tracing writes those of tiles out of focus.
@group(0) @binding(13) var<storage, read_write> tile_buckets: array<u32>;
@group(0) @binding(9) var classes: texture_storage_2d<rgba16float, write>;

/// What the pixels of the tile have found, and then its rows of pixels.
var<workgroup> found_in: array<Tile, 64>;

/// What a texel adds to its tile: `marked` with the bins of all layers, whose radii are packed.
fn mark_texel(at: vec2u, marked: Tile) -> Tile {
    var tile = marked;
    var s = vec4f(EMPTY_S);
    let place = at / (TILE * adaptive.fineness);
    let row = (textureDimensions(depth).x + TILE * adaptive.fineness - 1u) / (TILE * adaptive.fineness);
    let layers = select(1u, adaptive.layers, needed[place.y * row + place.x] != 0u);
    for (var k = 0u; k < layers; k++) {
        let z = textureLoad(depth, at, k, 0).r;
        if z < 0.0 {
            break;
        }
        let met = s_of_depth(adaptive, z);
        let bin = bin_of(adaptive, met);
        tile.low |= select(0u, 1u << (bin & 31u), bin < 32u);
        tile.high |= select(0u, 1u << (bin & 31u), bin >= 32u);
        tile.farthest = max(tile.farthest, select(0u, bin, k == 0u));
        tile.hidden = max(tile.hidden, select(0u, bin, k == 1u));
        s = select(s, vec4f(met), vec4u(0u, 1u, 2u, 3u) == vec4u(k));
    }
    textureStore(radii, at, s);
    let last = textureDimensions(depth) - 1u;
    let right = s_of_depth(adaptive, textureLoad(depth, min(at + vec2u(1u, 0u), last), 0, 0).r);
    let below = s_of_depth(adaptive, textureLoad(depth, min(at + vec2u(0u, 1u), last), 0, 0).r);
    tile.step_s = max(tile.step_s, max(abs(right - s.x), abs(below - s.x)));
    tile.lit |= light_tiles[min(place.y * row + place.x, arrayLength(&light_tiles) - 1u)] & 1u;
    return tile;
}

/// The bin of one layer at a texel; BINS for none.
fn bin_at(at: vec2u, layer: u32) -> u32 {
    let z = textureLoad(depth, at, layer, 0).r;
    return select(bin_of(adaptive, s_of_depth(adaptive, z)), BINS, z < 0.0);
}

/// The bin of what lies behind a texel that is itself in front of others in the tile; 0 for
/// none.
fn hidden_at(at: vec2u, back: u32) -> u32 {
    let second = bin_at(at, 1u);
    return select(0u, second, second < BINS && in_front(adaptive, bin_at(at, 0u), back));
}

fn is_texel(at: vec2i) -> bool {
    return all(at >= vec2i(0)) && all(at < vec2i(textureDimensions(depth)));
}

fn both(a: Tile, b: Tile) -> Tile {
    var tile = a;
    tile.low |= b.low;
    tile.high |= b.high;
    tile.farthest = max(a.farthest, b.farthest);
    tile.hidden = max(a.hidden, b.hidden);
    tile.hidden_by_front = max(a.hidden_by_front, b.hidden_by_front);
    tile.step_s = max(a.step_s, b.step_s);
    tile.lit |= b.lit;
    return tile;
}

/// Leaves in the first element of `found_in` what all of them have found.
fn merge_found(index: u32) {
    workgroupBarrier();
    if index % TILE == 0u {
        for (var i = 1u; i < TILE; i++) {
            found_in[index] = both(found_in[index], found_in[index + i]);
        }
    }
    workgroupBarrier();
    if index == 0u {
        for (var i = 1u; i < TILE; i++) {
            found_in[0] = both(found_in[0], found_in[TILE * i]);
        }
    }
    workgroupBarrier();
}

/// One of the texels that an invocation looks at: those of a tile lie in blocks of 8x8, in each of which
/// neighbouring invocations have neighbouring texels.
fn texel_of(first: vec2i, local: vec2u, i: u32) -> vec2i {
    return first + vec2i(TILE * vec2u(i % adaptive.fineness, i / adaptive.fineness) + local);
}

/// A workgroup looks at a tile, each invocation at as many texels as a pixel has.
@compute @workgroup_size(8, 8)
fn mark_tiles(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let k = adaptive.fineness;
    let pixel = vec2i(group.xy * TILE + adaptive.overscan) - i32(adaptive.first_tile * TILE);
    let first = pixel * i32(k);
    var found = Tile();
    for (var i = 0u; i < k * k; i++) {
        let at = texel_of(first, local.xy, i);
        if is_texel(at) {
            found = mark_texel(vec2u(at), found);
        }
    }
    found_in[index] = found;
    merge_found(index);
    let tile = found_in[0];
    workgroupBarrier();
    // Where the tile has hidden surfaces.
    for (var i = 0u; i < select(0u, k * k, tile.hidden > 0u); i++) {
        let at = texel_of(first, local.xy, i);
        if is_texel(at) {
            found.hidden_by_front = max(found.hidden_by_front, hidden_at(vec2u(at), tile.farthest));
        }
    }
    found_in[index] = found;
    merge_found(index);
    if index == 0u {
        marked[group.y * adaptive.tiles.x + group.x] = found_in[0];
    }
}

/// Bins whose blur reaches over `tiles` tiles: from the last pixel of a tile to the first
/// of another there are 8 (tiles - 1) + 1 px. A ray may hit a surface a quarter of a pixel
/// of s away from it and half a texel to the side.
fn reaching_bins(tiles: u32) -> vec2u {
    if tiles == 0u {
        return vec2u(0xffffffffu);
    }
    let distance = f32(TILE * (tiles - 1u)) + 1.0;
    let t = sqrt(max((distance - 0.5) / adaptive.lens_radius - astigmatic_s() - 0.25, 0.0));
    // Near bins with their near edge at or before -t, far ones with their far edge at or
    // behind t.
    let near_bins = clamp(floor((-t - adaptive.first_t) / adaptive.bin_t) + 1.0, 0.0, f32(BINS));
    let before_far = clamp(ceil((t - adaptive.first_t) / adaptive.bin_t) - 1.0, 0.0, f32(BINS));
    return first_bins(u32(near_bins)) | ~first_bins(u32(before_far));
}

fn merged(tile: Tile, other: Tile, tiles: u32) -> Tile {
    let mask = reaching_bins(tiles) & vec2u(other.low, other.high);
    var sum = tile;
    sum.low |= mask.x;
    sum.high |= mask.y;
    sum.step_s = max(sum.step_s, select(0.0, other.step_s, any(mask != vec2u(0u))));
    return sum;
}

/// The farthest bin that a ray from a tile can meet; `rows` have the greatest of each row of tiles within
/// reach. Where the farthest surface that the
/// pinhole sees within reach is passed, a ray has met one, unless it went around something
/// nearer and meets what that hides: a gap seen by no pixel.
fn farthest_met(at: vec2u) -> u32 {
    let from_tile = max(at, vec2u(adaptive.reach)) - adaptive.reach;
    let to_tile = min(at + adaptive.reach, adaptive.tiles - 1u);
    var seen = 0u;
    var met = 0u;
    for (var y = from_tile.y; y <= to_tile.y; y++) {
        let row = y * adaptive.tiles.x + at.x;
        seen = max(seen, rows[row].farthest);
        met = max(met, rows[row].hidden_by_front);
    }
    met = max(met, seen);
    for (var y = from_tile.y; y <= to_tile.y; y++) {
        // What a tile hides by its front lies no farther than what it hides at all.
        let count = select(0u, to_tile.x + 1u - from_tile.x, rows[y * adaptive.tiles.x + at.x].hidden > met);
        for (var i = 0u; i < count; i++) {
            let tile = marked[y * adaptive.tiles.x + from_tile.x + i];
            met = max(met, select(0u, tile.hidden, in_front(adaptive, tile.farthest, seen)));
        }
    }
    return met;
}

@compute @workgroup_size(8, 8)
fn dilate_rows(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= adaptive.tiles) {
        return;
    }
    var tile = Tile();
    let from_x = max(id.x, adaptive.reach) - adaptive.reach;
    let to_x = min(id.x + adaptive.reach, adaptive.tiles.x - 1u);
    for (var x = from_x; x <= to_x; x++) {
        let other = marked[id.y * adaptive.tiles.x + x];
        tile = merged(tile, other, max(x, id.x) - min(x, id.x));
        tile.farthest = max(tile.farthest, other.farthest);
        tile.hidden = max(tile.hidden, other.hidden);
        tile.hidden_by_front = max(tile.hidden_by_front, other.hidden_by_front);
    }
    rows[id.y * adaptive.tiles.x + id.x] = tile;
}

/// Everything is in focus: a disc of 0.2 px radius has a standard deviation of 0.1 px.
const COPY_S = 0.05;

/// Difference of s, px, between neighbouring texels that one surface may have where rays do
/// not search for it.
const UNIFORM_STEP_S = 0.25;

fn class_of(mask: vec2u, step_s: f32) -> u32 {
    let nearest = edge_of(adaptive, first_bin(mask));
    let farthest = edge_of(adaptive, last_bin(mask) + 1u);
    let greatest = max(abs(nearest), abs(farthest));
    if greatest_s(greatest) * sqrt(adaptive.lens_variance) < COPY_S {
        return COPY;
    }
    return select(COMPLEX, UNIFORM, farthest - nearest <= 0.5 + 0.3 * greatest && step_s <= UNIFORM_STEP_S);
}

@compute @workgroup_size(8, 8)
fn classify_tiles(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= adaptive.inner_tiles) {
        return;
    }
    let at = id.xy + adaptive.first_tile;
    var tile = Tile();
    let from_y = max(at.y, adaptive.reach) - adaptive.reach;
    let to_y = min(at.y + adaptive.reach, adaptive.tiles.y - 1u);
    for (var y = from_y; y <= to_y; y++) {
        tile = merged(tile, rows[y * adaptive.tiles.x + at.x], max(y, at.y) - min(y, at.y));
    }
    if adaptive.cull != 0u {
        let kept = first_bins(farthest_met(at) + 1u);
        tile.low &= kept.x;
        tile.high &= kept.y;
    }
    let index = id.y * adaptive.inner_tiles.x + id.x;
    for (var i = 0u; i < 9u; i++) {
        let beside = clamp(vec2i(at) + vec2i(vec2u(i % 3u, i / 3u)) - 1, vec2i(0), vec2i(adaptive.tiles) - 1);
        tile.lit |= marked[u32(beside.y) * adaptive.tiles.x + u32(beside.x)].lit;
    }
    tile.emitters = emitter_counts[1u + index];
    let sheets = sheet_bounds[min(index, arrayLength(&sheet_bounds) - 1u)];
    let needs_rays = tile.emitters > 0u || sheets.x <= sheets.y;
    tile.class_of = select(class_of(vec2u(tile.low, tile.high), tile.step_s), COMPLEX, needs_rays);
    dilated[index] = tile;
    tile_buckets[index] = select(0u, (1u << SHARP) | IN_FOCUS_TILE, tile.class_of == COPY);
    list_tile(id.xy, tile.class_of);
    textureStore(classes, id.xy, vec4f(f32(tile.class_of) * 0.5));
}
