// `splat` by tiles (src/methods/splat/tiles.rs): each pixel of the inner frame sums what
// reaches it, where `splat_sprites` draws and blends.
//
// A workgroup has a tile of 16x16 pixels, an invocation 2x2 of them. All invocations go through
// the same offsets at the same time, each to the source that lies there from its own pixels: where
// blur varies slowly, all are within their spots at once, or on their borders, or beyond.
//
//   offsets up to 18 x 11 at a time; the sources that lie there from any pixel of the tile, up
//   to 32 x 25, are put into workgroup memory first:
//
//        tile         offsets        sources
//       +----+                       +--------+
//       |    |    +   +----+    =    |        |
//       +----+        +----+         |        |
//                                    +--------+
//
// The order of the sums is that of the offsets: the same whichever invocation comes first.

#import splat

const TILE = 16u;
const INVOCATIONS_A_SIDE = 8u;
const INVOCATIONS = 64u;

/// Most offsets that are gone through at a time, and the sources that they take: as far as the
/// last 2x2 pixels see at the last offset.
const MOST_OFFSETS = vec2u(18u, 11u);
const COLUMNS = 32u;
const SOURCES = 800u;

struct Tiles {
    /// Tiles of the outer frame: they begin where those of the inner frame do.
    count: vec2u,
    /// The tile on both axes that holds the inner frame's first pixel.
    first: u32,
    /// Tiles on every side whose spots may reach a tile.
    window: u32,
    /// The part of the chunks of offsets that this pass sums.
    part_begin: u32,
    part_end: u32,
    /// 1: the first part, which begins with what is sharp.
    is_first: u32,
    /// 1: `arrays` says what is drawn.
    reduced: u32,
}

@group(0) @binding(0) var<uniform> tiles: Tiles;
/// How far from its centre the widest spot of a tile lies, px; 0 for none.
@group(0) @binding(1) var<storage, read> tile_reach_px: array<f32>;
@group(0) @binding(2) var<storage, read_write> new_tile_reach_px: array<f32>;
/// Sums of the parts before.
@group(0) @binding(3) var sum_front: texture_2d<f32>;
@group(0) @binding(4) var sum_same: texture_2d<f32>;
@group(0) @binding(5) var sum_behind: texture_2d<f32>;
@group(0) @binding(6) var new_front: texture_storage_2d<rgba32float, write>;
@group(0) @binding(7) var new_same: texture_storage_2d<rgba32float, write>;
@group(0) @binding(8) var new_behind: texture_storage_2d<rgba32float, write>;
/// What `idf_sums` holds, row by row.
@group(0) @binding(9) var<storage, read> idf_table: array<vec4f>;

/// The first pixel of the outer frame that an invocation has of a tile, x and y.
fn first_pixel(tile: vec2u, local: vec2u) -> vec2i {
    return vec2i(TILE * tile + 2u * local) - i32(TILE * tiles.first) + i32(sprites.overscan);
}

fn is_pixel(p: vec2i) -> bool {
    return all(p >= vec2i(0)) && all(p < vec2i(textureDimensions(depth)));
}

/// What a pixel spreads.
fn spread_by_pixel(p: vec2i, is_visible: bool) -> Spot {
    if !is_pixel(p) || (tiles.reduced != 0u && !is_drawn_by(EACH_ITS_OWN, vec2u(p) / 2u)) {
        return Spot(vec4f(0.0), 0.0);
    }
    if is_visible {
        return visible_spot(vec2u(p));
    }
    return pixel_spot(vec2u(p));
}

/// The block of 2x2 pixels whose first one is among the 2x2 pixels from `p` on.
fn block_from(p: vec2i) -> vec2i {
    return (p + 1) >> vec2u(1u);
}

/// What a block spreads.
fn spread_by_block(block: vec2i) -> Spot {
    if tiles.reduced == 0u || !is_pixel(2 * block) || !is_drawn_by(ONE_FOR_FOUR, vec2u(block)) {
        return Spot(vec4f(0.0), 0.0);
    }
    return block_spot(vec2u(block));
}

/// How far from its centre the pixels of a spot lie, px.
fn reach_px(spot: Spot) -> f32 {
    return select(0.0, 0.5 * sprites.radius * greatest_diameter_px(lens, spot.c) + 0.5, spot.light.a > 0.0);
}

// ---- how far the spots of each tile reach ----

/// The bits of the greatest: floats that are not negative are ordered as their bits are.
var<workgroup> farthest: atomic<u32>;

fn measure(tile: vec2u, local: vec2u, is_visible: bool) {
    let first = first_pixel(tile, local);
    // A block may have its centre half a pixel beyond the tile.
    let block = spread_by_block(block_from(first));
    var reach = select(0.0, reach_px(block) + 0.5, block.light.a > 0.0);
    for (var i = 0; i < 4; i++) {
        reach = max(reach, reach_px(spread_by_pixel(first + vec2i(i & 1, i >> 1u), is_visible)));
    }
    atomicMax(&farthest, bitcast<u32>(reach));
    workgroupBarrier();
    if all(local == vec2u(0u)) {
        new_tile_reach_px[tile.y * tiles.count.x + tile.x] = bitcast<f32>(atomicLoad(&farthest));
    }
}

@compute @workgroup_size(8, 8)
fn measure_visible(@builtin(workgroup_id) tile: vec3u, @builtin(local_invocation_id) local: vec3u) {
    measure(tile.xy, local.xy, true);
}

@compute @workgroup_size(8, 8)
fn measure_hidden(@builtin(workgroup_id) tile: vec3u, @builtin(local_invocation_id) local: vec3u) {
    measure(tile.xy, local.xy, false);
}

// ---- the shares of a spot that fall on 2x2 pixels ----

/// Shares of a spot that fall on the 2x2 pixels from `offset` px away from it on.
fn quad_shares(offset: vec2f, c: f32) -> vec4f {
    if lens.astigmatism_px != 0.0 {
        return quad_shares_of_ellipse(offset, c);
    }
    let width = max(abs(c), 1e-3);
    let farthest = max(abs(offset - 0.5), abs(offset + 1.5));
    let solid = 0.5 * sprites.solid * width;
    if dot(farthest, farthest) <= solid * solid {
        return vec4f(sprites.solid_intensity * 4.0 * (1.0 / (width * width)));
    }
    let cells_per_px = f32(sprites.cells) / (sprites.radius * width);
    if cells_per_px <= 1.0 {
        let side = vec2f(select(1.0, -1.0, c < 0.0));
        return vec4f(
            share_of_cells(idf_sums, sprites, side * offset, vec2f(cells_per_px)),
            share_of_cells(idf_sums, sprites, side * (offset + vec2f(1.0, 0.0)), vec2f(cells_per_px)),
            share_of_cells(idf_sums, sprites, side * (offset + vec2f(0.0, 1.0)), vec2f(cells_per_px)),
            share_of_cells(idf_sums, sprites, side * (offset + 1.0), vec2f(cells_per_px)),
        );
    }
    // As `sprite_share`, with the corners that pixels have in common read once.
    let signed_cells_per_px = select(cells_per_px, -cells_per_px, c < 0.0);
    let x = edges_of(offset.x, signed_cells_per_px);
    let y = edges_of(offset.y, signed_cells_per_px);
    let top = sums_at(x, y.cells.x, y.inside.x);
    let middle = sums_at(x, y.cells.y, y.inside.y);
    let bottom = sums_at(x, y.cells.z, y.inside.z);
    let shares = vec4f((middle.yz - top.yz) - (middle.xy - top.xy), (bottom.yz - middle.yz) - (bottom.xy - middle.xy));
    return select(vec4f(0.0), shares, shares > vec4f(SHARE_NOISE));
}

/// Where the edges of two neighbouring pixels lie in the table, on one axis: cells, and how far
/// within them.
struct Edges {
    cells: vec3u,
    inside: vec3f,
}

fn edges_of(offset: f32, cells_per_px: f32) -> Edges {
    let count = f32(sprites.cells);
    let at = clamp(0.5 * count + (offset + vec3f(-0.5, 0.5, 1.5)) * cells_per_px, vec3f(0.0), vec3f(count));
    let cells = min(floor(at), vec3f(count - 1.0));
    return Edges(vec3u(cells), at - cells);
}

/// `idf_sum` at three places of a row.
fn sums_at(x: Edges, row: u32, inside: f32) -> vec3f {
    let first = row * sprites.cells;
    let a = idf_table[first + x.cells.x];
    let b = idf_table[first + x.cells.y];
    let c = idf_table[first + x.cells.z];
    let left = mix(vec3f(a.x, b.x, c.x), vec3f(a.z, b.z, c.z), inside);
    let right = mix(vec3f(a.y, b.y, c.y), vec3f(a.w, b.w, c.w), inside);
    return mix(left, right, x.inside);
}

fn quad_shares_of_ellipse(offset: vec2f, c: f32) -> vec4f {
    return vec4f(
        share_of_ellipse(idf_sums, sprites, lens, c, Square(offset, 1.0)),
        share_of_ellipse(idf_sums, sprites, lens, c, Square(offset + vec2f(1.0, 0.0), 1.0)),
        share_of_ellipse(idf_sums, sprites, lens, c, Square(offset + vec2f(0.0, 1.0), 1.0)),
        share_of_ellipse(idf_sums, sprites, lens, c, Square(offset + 1.0, 1.0)),
    );
}

/// How far from its centre a spot of CoC c has light, px: the aperture, and the cells of the table
/// that it touches.
fn light_reach_px(c: f32) -> f32 {
    let cells = 1.0 + 2.0 * sqrt(2.0) / f32(sprites.cells);
    return 0.5 * sprites.radius * cells * max(greatest_diameter_px(lens, c), 1e-3) + 1e-3;
}

/// The layers of a pixel.
struct Sums {
    front: vec4f,
    same: vec4f,
    behind: vec4f,
}

/// The layers of 2x2 pixels, row by row.
struct Quad {
    a: Sums,
    b: Sums,
    c: Sums,
    d: Sums,
}

/// The visible surface at 2x2 pixels, and by how much less or more CoC a spot arrives in front of
/// it or behind it: equation (6), or for sheets whether they lie behind it or not.
struct Surface {
    c: vec4f,
    before: vec4f,
    beyond: vec4f,
}

/// More than any two c differ by.
const NO_LAYER_PX = 1e30;

fn surface_of(c: vec4f) -> Surface {
    if params.sheets != 0u {
        return Surface(c, vec4f(NO_LAYER_PX), vec4f(0.0));
    }
    if params.layered == 0u {
        return Surface(c, vec4f(NO_LAYER_PX), vec4f(NO_LAYER_PX));
    }
    let depth = params.delta * (abs(c) + abs(lens.astigmatism_px));
    return Surface(c, depth, depth);
}

fn with_light(sums: Sums, light: vec4f, in_front: bool, is_behind: bool) -> Sums {
    let none = vec4f(0.0);
    return Sums(
        sums.front + select(none, light, in_front),
        sums.same + select(light, none, in_front || is_behind),
        sums.behind + select(none, light, is_behind),
    );
}

/// Whether spots between two CoCs all arrive at the surface.
fn all_at(surface: Surface, c: vec2f) -> bool {
    return all(c.x - surface.c >= -surface.before) && all(c.y - surface.c <= surface.beyond);
}

/// Adds the light of a spot `offset` px before the first of 2x2 pixels; `at_surface`: on the middle layer.
fn add(quad: ptr<function, Quad>, surface: Surface, offset: vec2f, c: f32, light: vec4f, at_surface: bool) {
    let shares = quad_shares(offset, c);
    if !at_surface && !all_at(surface, vec2f(c)) {
        let farther = c - surface.c;
        let in_front = farther < -surface.before;
        let is_behind = farther > surface.beyond;
        (*quad).a = with_light((*quad).a, shares.x * light, in_front.x, is_behind.x);
        (*quad).b = with_light((*quad).b, shares.y * light, in_front.y, is_behind.y);
        (*quad).c = with_light((*quad).c, shares.z * light, in_front.z, is_behind.z);
        (*quad).d = with_light((*quad).d, shares.w * light, in_front.w, is_behind.w);
    } else {
        (*quad).a.same += shares.x * light;
        (*quad).b.same += shares.y * light;
        (*quad).c.same += shares.z * light;
        (*quad).d.same += shares.w * light;
    }
}

/// What the sums of pixel `at` of the inner frame begin with.
fn first_sums(at: vec2u, is_visible: bool) -> Sums {
    let none = vec4f(0.0);
    if tiles.is_first == 0u {
        let front = textureLoad(sum_front, at, 0);
        return Sums(front, textureLoad(sum_same, at, 0), textureLoad(sum_behind, at, 0));
    }
    if is_visible && all(at < sprites.size) {
        return Sums(none, sharp_light(at + sprites.overscan), none);
    }
    return Sums(none, none, none);
}

// ---- the sources around a tile ----

var<workgroup> lights: array<vec4f, SOURCES>;
var<workgroup> cocs: array<f32, SOURCES>;
/// Bits of how far the spots reach that may reach the tile, px.
var<workgroup> tile_reach: atomic<u32>;
/// Bits of the farthest that any of the sources has light, px.
var<workgroup> light_reach: atomic<u32>;
/// Least and greatest c of them, by `ordered`: the least turned round.
var<workgroup> least_c: atomic<u32>;
var<workgroup> greatest_c: atomic<u32>;
/// Which of 64 chunks have sources that may reach the tile.
var<workgroup> near_chunks: array<atomic<u32>, 2>;

/// Numbers ordered as floats are.
fn ordered(x: f32) -> u32 {
    let bits = bitcast<u32>(x);
    return select(bits | 0x80000000u, ~bits, (bits >> 31u) != 0u);
}

fn of_ordered(bits: u32) -> f32 {
    return bitcast<f32>(select(~bits, bits & 0x7fffffffu, (bits >> 31u) != 0u));
}

/// The offsets of sources from which a tile is reached, in chunks; sources are pixels, or blocks of
/// 2x2 pixels. An offset is that of a source from the first of an invocation's 2x2 pixels, or
/// from the block there.
struct Grid {
    of_blocks: bool,
    /// How far apart sources are, px, and how far the one at offset 0 lies from the first pixel.
    step: f32,
    shift: f32,
    /// First offset on both axes, and how many there are on each.
    first: i32,
    count: u32,
    /// Offsets of a chunk, and chunks.
    chunk: vec2u,
    chunks: vec2u,
}

fn grid_of(reach: f32, of_blocks: bool) -> Grid {
    // As wide as the frame at most.
    let most = f32(TILE * (tiles.window + 1u));
    let half_count = i32(ceil(min(select(reach, 0.5 * reach + 0.75, of_blocks), most)));
    let first = select(1 - half_count, -half_count, of_blocks);
    let count = u32(2 * half_count) + u32(of_blocks);
    let chunks = (vec2u(count) + MOST_OFFSETS - 1u) / MOST_OFFSETS;
    let chunk = (vec2u(count) + chunks - 1u) / max(chunks, vec2u(1u));
    // The block of an odd pixel begins after it.
    let shift = select(0.0, f32(sprites.overscan & 1u) + 0.5, of_blocks);
    return Grid(of_blocks, select(1.0, 2.0, of_blocks), shift, first, count, chunk, chunks);
}

/// First offset of a chunk.
fn chunk_first(grid: Grid, index: u32) -> vec2i {
    return grid.first + vec2i(grid.chunk * vec2u(index % grid.chunks.x, index / grid.chunks.x));
}

/// How many sources an invocation's 2x2 pixels are apart from the next one's.
fn stride(grid: Grid) -> u32 {
    return select(2u, 1u, grid.of_blocks);
}

/// The source at offset 0 of the tile whose first pixel is `corner`.
fn source_of(grid: Grid, corner: vec2i) -> vec2i {
    return select(corner, block_from(corner), grid.of_blocks);
}

/// Sources of a chunk along each axis.
fn chunk_sources(grid: Grid) -> vec2u {
    return grid.chunk + stride(grid) * (INVOCATIONS_A_SIDE - 1u);
}

/// Where a source is in workgroup memory. Those of neighbouring invocations at one offset are
/// two pixels or one block apart; they lie beside one another.
fn slot(grid: Grid, at: vec2u) -> u32 {
    return select(COLUMNS * at.y + (at.x & 1u) * (COLUMNS / 2u) + at.x / 2u, COLUMNS * at.y + at.x, grid.of_blocks);
}

/// Distance, px, of a source from the nearest point of 2x2 pixels on one axis, `from_first` px from the
/// centre of the first.
fn distance_px(from_first: f32) -> f32 {
    return max(abs(from_first - 0.5) - 1.0, 0.0);
}

/// Puts the sources of a chunk into workgroup memory, from source `first` on.
fn put(grid: Grid, first: vec2i, index: u32, is_visible: bool) {
    let size = min(chunk_sources(grid), vec2u(COLUMNS, SOURCES / COLUMNS));
    var farthest_px = 0.0;
    var least = 0u;
    var greatest = 0u;
    for (var n = index; n < COLUMNS * size.y; n += INVOCATIONS) {
        let at = vec2u(n % COLUMNS, n / COLUMNS);
        if at.x >= size.x {
            continue;
        }
        var spot: Spot;
        if grid.of_blocks {
            spot = spread_by_block(first + vec2i(at));
        } else {
            spot = spread_by_pixel(first + vec2i(at), is_visible);
        }
        let here = slot(grid, at);
        lights[here] = spot.light;
        cocs[here] = 0.0;
        if spot.light.a > 0.0 {
            cocs[here] = spot.c;
            farthest_px = max(farthest_px, light_reach_px(spot.c));
            least = max(least, ~ordered(spot.c));
            greatest = max(greatest, ordered(spot.c));
        }
    }
    if farthest_px > 0.0 {
        atomicMax(&light_reach, bitcast<u32>(farthest_px));
        atomicMax(&least_c, least);
        atomicMax(&greatest_c, greatest);
    }
}

/// Goes through the offsets of a chunk, from `first` on.
fn gather_from(grid: Grid, quad: ptr<function, Quad>, surface: Surface, local: vec2u, first: vec2i) {
    let reach = bitcast<f32>(atomicLoad(&light_reach));
    if reach <= 0.0 {
        return;
    }
    let c_range = vec2f(of_ordered(~atomicLoad(&least_c)), of_ordered(atomicLoad(&greatest_c)));
    let at_surface = all_at(surface, c_range);
    let own = stride(grid) * local;
    let end = min(grid.chunk, MOST_OFFSETS);
    for (var y = 0u; y < end.y; y++) {
        let from_first_y = grid.step * f32(first.y + i32(y)) + grid.shift;
        let away_y = distance_px(from_first_y);
        let left = reach * reach - away_y * away_y;
        if left <= 0.0 {
            continue;
        }
        // Between these no offset of the row is left out.
        let half_width = sqrt(left) + 1.0;
        let low = floor((0.5 - half_width - grid.shift) / grid.step) - f32(first.x);
        let high = ceil((0.5 + half_width - grid.shift) / grid.step) - f32(first.x) + 1.0;
        let row_end = min(u32(clamp(high, 0.0, 64.0)), end.x);
        for (var x = u32(clamp(low, 0.0, 64.0)); x < row_end; x++) {
            let source = slot(grid, own + vec2u(x, y));
            let from_first = vec2f(grid.step * f32(first.x + i32(x)) + grid.shift, from_first_y);
            let away_x = distance_px(from_first.x);
            let c = cocs[source];
            let light_px = light_reach_px(c);
            if away_x * away_x + away_y * away_y >= light_px * light_px {
                continue;
            }
            add(quad, surface, -from_first, c, lights[source], at_surface);
        }
    }
}

/// How far the spots of a tile of the outer frame reach, px.
fn reach_of_tile(tile: vec2i) -> f32 {
    if any(tile < vec2i(0)) || any(tile >= vec2i(tiles.count)) {
        return 0.0;
    }
    return tile_reach_px[u32(tile.y) * tiles.count.x + u32(tile.x)];
}

/// Finds how far spots reach that may reach the tile `own`; an invocation looks at each 64th of
/// the tiles around it.
fn find_tile_reach(own: vec2u, index: u32) {
    let begin = max(own, vec2u(tiles.window)) - tiles.window;
    let size = min(own + tiles.window + 1u, tiles.count) - begin;
    var reach = 0.0;
    for (var i = index; i < size.x * size.y; i += INVOCATIONS) {
        let tile = begin + vec2u(i % size.x, i / size.x);
        // From the last pixel of a tile to the first of the next there is one.
        let apart = max(tile, own) - min(tile, own);
        let gap = f32(max(TILE * max(apart.x, apart.y), TILE - 1u) - (TILE - 1u));
        let of_tile = reach_of_tile(vec2i(tile));
        reach = max(reach, select(0.0, of_tile, of_tile > gap));
    }
    atomicMax(&tile_reach, bitcast<u32>(reach));
}

/// Whether sources of a chunk may reach the tile whose first pixel is `corner`.
fn is_near(grid: Grid, corner: vec2i, index: u32) -> bool {
    let first = chunk_first(grid, index);
    let step = i32(grid.step);
    // Of the outer frame: a block lies half a pixel after its first one.
    let low = step * (source_of(grid, corner) + first);
    let high = low + step * vec2i(chunk_sources(grid));
    let to_tiles = i32(TILE * tiles.first) - i32(sprites.overscan);
    let first_tile = (low + to_tiles) >> vec2u(4u);
    let last_tile = (high + to_tiles) >> vec2u(4u);
    let size = vec2u(clamp(last_tile - first_tile + 1, vec2i(0), vec2i(8)));
    var reach = 0.0;
    for (var i = 0u; i < size.x * size.y; i++) {
        reach = max(reach, reach_of_tile(first_tile + vec2i(vec2u(i % size.x, i / size.x))));
    }
    // The second pixel of two lies one farther; blocks lie up to 1.5 px off.
    let begin = step * first;
    let end = step * (first + vec2i(grid.chunk) - 1) + select(0, 2, grid.of_blocks);
    let away = max(max(begin - 1, -end), vec2i(0));
    return reach > f32(max(away.x, away.y));
}

/// Sums of the 2x2 pixels that an invocation has of a tile of the inner frame.
fn gathered(group: vec2u, local: vec2u, is_visible: bool) -> Quad {
    let at = TILE * group + 2u * local;
    let right = vec2u(1u, 0u);
    let down = vec2u(0u, 1u);
    var quad = Quad(
        first_sums(at, is_visible),
        first_sums(at + right, is_visible),
        first_sums(at + down, is_visible),
        first_sums(at + 1u, is_visible),
    );
    let outer = vec2i(at + sprites.overscan);
    let surface = surface_of(vec4f(
        visible_coc_px(outer),
        visible_coc_px(outer + vec2i(right)),
        visible_coc_px(outer + vec2i(down)),
        visible_coc_px(outer + 1),
    ));
    let index = local.y * INVOCATIONS_A_SIDE + local.x;
    let corner = vec2i(TILE * group + sprites.overscan);
    if index == 0u {
        atomicStore(&tile_reach, 0u);
    }
    workgroupBarrier();
    find_tile_reach(group + tiles.first, index);
    workgroupBarrier();
    let reach = bitcast<f32>(atomicLoad(&tile_reach));
    let of_pixels = grid_of(reach, false);
    let of_blocks = grid_of(reach, true);
    let pixel_chunks = of_pixels.chunks.x * of_pixels.chunks.y;
    let block_chunks = select(0u, of_blocks.chunks.x * of_blocks.chunks.y, tiles.reduced != 0u && reach > 0.0);
    let end = min(tiles.part_end, pixel_chunks + block_chunks);
    for (var begin = tiles.part_begin; begin < end; begin += INVOCATIONS) {
        workgroupBarrier();
        if index < 2u {
            atomicStore(&near_chunks[index], 0u);
        }
        workgroupBarrier();
        let mine = begin + index;
        if mine < end {
            let is_block = mine >= pixel_chunks;
            let grid = grid_of(reach, is_block);
            if is_near(grid, corner, mine - select(0u, pixel_chunks, is_block)) {
                atomicOr(&near_chunks[index / 32u], 1u << (index % 32u));
            }
        }
        workgroupBarrier();
        for (var word = 0u; word < 2u; word++) {
            var bits = atomicLoad(&near_chunks[word]);
            while bits != 0u {
                let chunk = begin + 32u * word + firstTrailingBit(bits);
                bits &= bits - 1u;
                let is_block = chunk >= pixel_chunks;
                let grid = grid_of(reach, is_block);
                let first = chunk_first(grid, chunk - select(0u, pixel_chunks, is_block));
                workgroupBarrier();
                if index == 0u {
                    atomicStore(&light_reach, 0u);
                    atomicStore(&least_c, 0u);
                    atomicStore(&greatest_c, 0u);
                }
                workgroupBarrier();
                put(grid, source_of(grid, corner) + first, index, is_visible);
                workgroupBarrier();
                gather_from(grid, &quad, surface, local, first);
            }
        }
    }
    return quad;
}

fn store_same_and_behind(at: vec2u, sums: Sums) {
    if all(at < sprites.size) {
        textureStore(new_same, at, sums.same);
        textureStore(new_behind, at, sums.behind);
    }
}

fn store(at: vec2u, sums: Sums) {
    if all(at < sprites.size) {
        textureStore(new_front, at, sums.front);
    }
    store_same_and_behind(at, sums);
}

@compute @workgroup_size(8, 8)
fn gather_visible(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let quad = gathered(group.xy, local.xy, true);
    let at = TILE * group.xy + 2u * local.xy;
    store(at, quad.a);
    store(at + vec2u(1u, 0u), quad.b);
    store(at + vec2u(0u, 1u), quad.c);
    store(at + 1u, quad.d);
}

/// Hidden pixels occlude nothing: what would lie in front is dropped.
@compute @workgroup_size(8, 8)
fn gather_hidden(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let quad = gathered(group.xy, local.xy, false);
    let at = TILE * group.xy + 2u * local.xy;
    store_same_and_behind(at, quad.a);
    store_same_and_behind(at + vec2u(1u, 0u), quad.b);
    store_same_and_behind(at + vec2u(0u, 1u), quad.c);
    store_same_and_behind(at + 1u, quad.d);
}
