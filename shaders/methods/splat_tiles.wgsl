// `splat` by tiles (src/methods/splat/tiles.rs): each pixel of the inner frame sums what
// reaches it, where `splat_sprites` draws and blends.
//
// A workgroup has a tile of 16x16 pixels, an invocation 2x2 of them. One after another the
// tiles of sources around it whose spots are wide enough are put into workgroup memory, and
// of those sources the ones that reach the tile are gone through in order: sums do not
// depend on which invocation comes first.

#import splat

const TILE = 16u;
const INVOCATIONS_A_SIDE = 8u;

/// Pixels of a tile, then blocks of 2x2 pixels that one spot stands for.
const TILE_PIXELS = 256u;
const SOURCES = 320u;

/// Words of 32 bits, a bit a source.
const WORDS = 10u;

struct Tiles {
    /// Tiles of the outer frame: they begin where those of the inner frame do.
    count: vec2u,
    /// The tile on both axes that holds the inner frame's first pixel.
    first: u32,
    /// Tiles on every side whose spots may reach a tile.
    window: u32,
    /// The part of the tiles in the window that this pass sums.
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

// ---- the sources of a tile that reach another ----

var<workgroup> lights: array<vec4f, SOURCES>;
/// Place on the inner frame, px, and CoC diameter.
var<workgroup> places: array<vec3f, SOURCES>;
/// Which of them reach the tile.
var<workgroup> reaching: array<atomic<u32>, WORDS>;

/// Puts a source into workgroup memory, if it reaches the tile from pixel `low` to `high`.
fn offer(index: u32, spot: Spot, place: vec2f, low: vec2f, high: vec2f) {
    let reach = reach_px(spot);
    if reach > 0.0 && all(abs(place - clamp(place, low, high)) < vec2f(reach)) {
        lights[index] = spot.light;
        places[index] = vec3f(place, spot.c);
        atomicOr(&reaching[index / 32u], 1u << (index % 32u));
    }
}

/// Puts the 2x2 pixels of an invocation there, and the block that begins among them.
fn offer_quad(tile: vec2u, local: vec2u, low: vec2f, is_visible: bool) {
    let first = first_pixel(tile, local);
    let high = low + f32(TILE - 1u);
    let on_inner = 0.5 - f32(sprites.overscan);
    let index = local.y * INVOCATIONS_A_SIDE + local.x;
    for (var i = 0u; i < 4u; i++) {
        let p = first + vec2i(vec2u(i & 1u, i >> 1u));
        offer(4u * index + i, spread_by_pixel(p, is_visible), vec2f(p) + on_inner, low, high);
    }
    let block = block_from(first);
    offer(TILE_PIXELS + index, spread_by_block(block), vec2f(2 * block) + 0.5 + on_inner, low, high);
}

// ---- the sums of 2x2 pixels ----

/// Shares of a spot that fall on the 2x2 pixels from `offset` px away from it on.
fn quad_shares(offset: vec2f, c: f32) -> vec4f {
    let width = max(abs(c), 1e-3);
    let v = max(abs(offset - 0.5), abs(offset + 1.5)) * (2.0 / width);
    if dot(v, v) <= sprites.solid * sprites.solid {
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
    let v_per_px = 2.0 / select(width, -width, c < 0.0);
    let low = (offset - 0.5) * v_per_px;
    let middle = (offset + 0.5) * v_per_px;
    let high = (offset + 1.5) * v_per_px;
    let top = vec3f(idf(low.x, low.y), idf(middle.x, low.y), idf(high.x, low.y));
    let centre = vec3f(idf(low.x, middle.y), idf(middle.x, middle.y), idf(high.x, middle.y));
    let bottom = vec3f(idf(low.x, high.y), idf(middle.x, high.y), idf(high.x, high.y));
    let shares = vec4f(
        (centre.yz - top.yz) - (centre.xy - top.xy),
        (bottom.yz - centre.yz) - (bottom.xy - centre.xy),
    );
    return select(vec4f(0.0), shares, shares > vec4f(SHARE_NOISE));
}

fn idf(x: f32, y: f32) -> f32 {
    return idf_sum(idf_sums, sprites, vec2f(x, y));
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

/// The layer on which light arrives: that of the paper, or for sheets whether they lie behind the
/// visible surface or not.
fn layer_for(c: f32, c_v: f32) -> i32 {
    let of_sheet = select(SAME, BEHIND, c > c_v);
    return select(layer_of(c, c_v), of_sheet, params.sheets != 0u);
}

fn with_light(sums: Sums, light: vec4f, layer: i32) -> Sums {
    let none = vec4f(0.0);
    return Sums(
        sums.front + select(none, light, layer == FRONT),
        sums.same + select(none, light, layer == SAME),
        sums.behind + select(none, light, layer == BEHIND),
    );
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
    let c_v = vec4f(
        visible_coc_px(outer),
        visible_coc_px(outer + vec2i(right)),
        visible_coc_px(outer + vec2i(down)),
        visible_coc_px(outer + 1),
    );
    let centre = vec2f(at) + 0.5;
    let low = vec2f(TILE * group) + 0.5;
    let index = local.y * INVOCATIONS_A_SIDE + local.x;
    let own = group + tiles.first;
    let begin = max(own, vec2u(tiles.window)) - tiles.window;
    let size = min(own + tiles.window + 1u, tiles.count) - begin;
    let end = min(tiles.part_end, size.x * size.y);
    for (var i = tiles.part_begin; i < end; i++) {
        let tile = begin + vec2u(i % size.x, i / size.x);
        // From the last pixel of a tile to the first of the next there is one.
        let apart = max(tile, own) - min(tile, own);
        let gap = f32(max(TILE * max(apart.x, apart.y), TILE - 1u) - (TILE - 1u));
        if tile_reach_px[tile.y * tiles.count.x + tile.x] <= gap {
            continue;
        }
        workgroupBarrier();
        if index < WORDS {
            atomicStore(&reaching[index], 0u);
        }
        workgroupBarrier();
        offer_quad(tile, local, low, is_visible);
        workgroupBarrier();
        for (var word = 0u; word < WORDS; word++) {
            var bits = atomicLoad(&reaching[word]);
            while bits != 0u {
                let source = 32u * word + firstTrailingBit(bits);
                bits &= bits - 1u;
                let c = places[source].z;
                let offset = centre - places[source].xy;
                let reach = spot_reach_px(sprites, lens, c);
                if any(offset >= reach) || any(offset <= -1.0 - reach) {
                    continue;
                }
                var shares = quad_shares(offset, c);
                // A loop that ends at once, as in `spot_share`.
                for (var k = 0u; k < select(0u, 4u, lens.astigmatism_px != 0.0); k++) {
                    let pixel = offset + vec2f(vec2u(k & 1u, k >> 1u));
                    shares[k] = share_of_ellipse(idf_sums, sprites, lens, c, Square(pixel, 1.0));
                }
                let light = lights[source];
                quad.a = with_light(quad.a, shares.x * light, layer_for(c, c_v.x));
                quad.b = with_light(quad.b, shares.y * light, layer_for(c, c_v.y));
                quad.c = with_light(quad.c, shares.z * light, layer_for(c, c_v.z));
                quad.d = with_light(quad.d, shares.w * light, layer_for(c, c_v.w));
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
