// `splat` by tiles (src/methods/splat/tiles.rs): each pixel of the inner frame sums what
// reaches it, where `splat_sprites` draws and blends.
//
// A workgroup has a tile of 16x16 pixels, an invocation 2x2 of them. All invocations go through
// the same offsets at the same time, each to the source that lies there from its own pixels: where
// blur varies slowly, all are within their spots at once, or on their borders, or beyond.
//
//   offsets 16 x 16 at a time, those of one tile from another, in two halves; the sources that
//   lie there from any pixel of the tile, 30 x 22, are put into workgroup memory first:
//
//        tile         offsets        sources
//       +----+                       +-------+
//       |    |    +   +----+    =    |       |
//       +----+        +----+         +-------+
//
// The order of the sums is that of the offsets: the same whichever invocation comes first.

#import splat

const TILE = 16u;
const INVOCATIONS_A_SIDE = 8u;
const INVOCATIONS = 64u;

/// Rows of offsets that are gone through at a time.
const ROWS = 8u;

/// Sources in workgroup memory, and how many of their columns and rows are in use: as far as
/// the last 2x2 pixels see at the last offset.
const COLUMNS = 32u;
const SOURCES = 704u;
const USED_COLUMNS = 30u;
const USED_ROWS = 22u;

struct Tiles {
    /// Tiles of the outer frame: they begin where those of the inner frame do.
    count: vec2u,
    /// The tile on both axes that holds the inner frame's first pixel.
    first: u32,
    /// Offsets that are gone through: from so many tiles on each side.
    window: u32,
    /// The part of the tiles of offsets that this pass sums.
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
        return vec4f(sprites.solid_intensity * 4.0 / (width * width));
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

/// Adds the light of a spot `offset` px before the first of 2x2 pixels.
fn add(quad: ptr<function, Quad>, surface: Surface, offset: vec2f, c: f32, light: vec4f) {
    let shares = quad_shares(offset, c);
    let farther = c - surface.c;
    let in_front = farther < -surface.before;
    let is_behind = farther > surface.beyond;
    if any(in_front | is_behind) {
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
/// Bits of the farthest that any of them has light, px.
var<workgroup> light_reach: atomic<u32>;
/// Which of 64 tiles of offsets have sources that may reach the tile.
var<workgroup> near_tiles: array<atomic<u32>, 2>;

/// Pixels, or blocks of 2x2 pixels, as sources: how far apart they are, px, and how far the
/// one at offset 0 lies from the first of 2x2 pixels.
struct Grid {
    step: f32,
    shift: f32,
    is_visible: bool,
    of_blocks: bool,
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

/// Puts sources into workgroup memory, from one on.
fn put(grid: Grid, first: vec2i, index: u32) {
    var farthest_px = 0.0;
    for (var n = index; n < SOURCES; n += INVOCATIONS) {
        let at = vec2u(n % COLUMNS, n / COLUMNS);
        if at.x >= USED_COLUMNS || at.y >= USED_ROWS {
            continue;
        }
        var spot: Spot;
        if grid.of_blocks {
            spot = spread_by_block(first + vec2i(at));
        } else {
            spot = spread_by_pixel(first + vec2i(at), grid.is_visible);
        }
        let here = slot(grid, at);
        let has_light = spot.light.a > 0.0;
        lights[here] = spot.light;
        cocs[here] = select(0.0, spot.c, has_light);
        farthest_px = max(farthest_px, select(0.0, light_reach_px(spot.c), has_light));
    }
    atomicMax(&light_reach, bitcast<u32>(farthest_px));
}

/// Goes through offsets, `count` of them from `begin` on, in steps of the grid.
fn gather_from(grid: Grid, quad: ptr<function, Quad>, surface: Surface, local: vec2u, begin: vec2i, count: vec2u) {
    let reach = bitcast<f32>(atomicLoad(&light_reach));
    let own = select(2u, 1u, grid.of_blocks) * local;
    for (var y = 0u; y < count.y; y++) {
        let from_first_y = grid.step * f32(begin.y + i32(y)) + grid.shift;
        let away_y = distance_px(from_first_y);
        if away_y >= reach {
            continue;
        }
        for (var x = 0u; x < count.x; x++) {
            let from_first = vec2f(grid.step * f32(begin.x + i32(x)) + grid.shift, from_first_y);
            let away_x = distance_px(from_first.x);
            let away2 = away_x * away_x + away_y * away_y;
            if away2 >= reach * reach {
                continue;
            }
            let source = slot(grid, own + vec2u(x, y));
            let c = cocs[source];
            let light_px = light_reach_px(c);
            if away2 >= light_px * light_px {
                continue;
            }
            add(quad, surface, -from_first, c, lights[source]);
        }
    }
}

/// Whether sources at a tile of offsets, in tiles, may reach the tile `own`.
fn is_near(own: vec2i, offset: vec2i) -> bool {
    // From a tile's pixels they lie in two tiles on each axis.
    var reach = 0.0;
    for (var i = 0; i < 4; i++) {
        let tile = own + offset + vec2i(i & 1, i >> 1u);
        if all(tile >= vec2i(0)) && all(tile < vec2i(tiles.count)) {
            reach = max(reach, tile_reach_px[u32(tile.y) * tiles.count.x + u32(tile.x)]);
        }
    }
    let first = i32(TILE) * offset;
    let last = first + i32(TILE) - 1;
    // 2x2 pixels reach one farther.
    let away = max(max(first - 1, -last), vec2i(0));
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
    let own = vec2i(group + tiles.first);
    let corner = vec2i(TILE * group + sprites.overscan);
    let side = 2u * tiles.window;
    let end = min(tiles.part_end, side * side);
    for (var begin = tiles.part_begin; begin < end; begin += INVOCATIONS) {
        workgroupBarrier();
        if index < 2u {
            atomicStore(&near_tiles[index], 0u);
        }
        workgroupBarrier();
        let mine = begin + index;
        if mine < end && is_near(own, tile_offset(mine, side)) {
            atomicOr(&near_tiles[index / 32u], 1u << (index % 32u));
        }
        workgroupBarrier();
        for (var word = 0u; word < 2u; word++) {
            var bits = atomicLoad(&near_tiles[word]);
            while bits != 0u {
                let offset = tile_offset(begin + 32u * word + firstTrailingBit(bits), side);
                bits &= bits - 1u;
                for (var part = 0u; part < 2u * select(1u, 2u, tiles.reduced != 0u); part++) {
                    let of_blocks = part >= 2u;
                    let rows = i32(ROWS * (part & 1u));
                    var grid = Grid(1.0, 0.0, is_visible, false);
                    var first = i32(TILE) * offset + vec2i(0, rows);
                    var source = corner + first;
                    var count = vec2u(TILE, ROWS);
                    if of_blocks {
                        // The block of an odd pixel begins after it.
                        grid = Grid(2.0, f32(sprites.overscan & 1u) + 0.5, is_visible, true);
                        first /= 2;
                        source = block_from(corner) + first;
                        count /= 2u;
                    }
                    workgroupBarrier();
                    if index == 0u {
                        atomicStore(&light_reach, 0u);
                    }
                    workgroupBarrier();
                    put(grid, source, index);
                    workgroupBarrier();
                    gather_from(grid, &quad, surface, local, first, count);
                }
            }
        }
    }
    return quad;
}

/// Offset, in tiles, of one of the tiles of offsets.
fn tile_offset(index: u32, side: u32) -> vec2i {
    return vec2i(vec2u(index % side, index / side)) - i32(tiles.window);
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
