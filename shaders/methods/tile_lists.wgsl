// The lists of tiles that several methods share (src/methods/tile_lists.rs).
//
//   mark_reach       the widest blur in each tile of the outer frame
//   spread_rows      the widest that reaches a tile from the left and the right
//   spread_columns   the same up and down
//   list_by_focus    the inner frame's tiles by whether anything reaches them
//   plan_dispatches  lengths of lists to grids of workgroups
//   copy_tiles       the picture of tiles that are left as they are
//   show_class       the class of each tile, as a debug image

#import lens
#import tile_lists

struct Focus {
    /// Tiles of the outer frame; tile `first_tile` holds the inner frame's first pixel.
    tiles: vec2u,
    first_tile: u32,
    /// Overscan, px.
    overscan: u32,
    /// How far a pixel's blur counts as reaching, over its CoC diameter.
    reach_per_coc: f32,
    /// CoC diameter, px, below which a pixel is left as it is.
    in_focus_coc_px: f32,
    /// Tiles on every side whose blur may reach a tile.
    reach: u32,
    /// Added to CoC diameters, px: an astigmatic eye's blur is longer than wide.
    more_coc_px: f32,
}

@group(0) @binding(0) var<uniform> focus: Focus;
@group(0) @binding(1) var<uniform> lens: Lens;
@group(0) @binding(2) var depth: texture_2d<f32>;
@group(0) @binding(3) var<storage, read_write> new_reach_px: array<f32>;
@group(0) @binding(4) var<storage, read> reach_px: array<f32>;

/// The class of tiles that blur reaches, of `list_by_focus`.
const DEFOCUSED = 1u;

/// Of the greatest |c| of each tile in a row of eight, its bits: floats that are not
/// negative are ordered as their bits are.
var<workgroup> greatest: array<atomic<u32>, 8>;

/// Each row of invocations looks at one tile, a column of pixels each.
@compute @workgroup_size(8, 8)
fn mark_reach(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let tile = vec2u(TILE * group.x + local.y, group.y);
    let first = vec2i(tile * TILE + vec2u(local.x, 0u) + focus.overscan) - i32(focus.first_tile * TILE);
    var c = 0.0;
    for (var y = 0; y < i32(TILE); y++) {
        let at = first + vec2i(0, y);
        if all(at >= vec2i(0)) && all(at < vec2i(textureDimensions(depth))) {
            c = max(c, abs(coc_diameter_px(lens, textureLoad(depth, at, 0).r)));
        }
    }
    atomicMax(&greatest[local.y], bitcast<u32>(c));
    workgroupBarrier();
    if local.x == 0u && all(tile < focus.tiles) {
        let widest = bitcast<f32>(atomicLoad(&greatest[local.y])) + focus.more_coc_px;
        // What is in focus reaches nothing, itself included.
        let reach = select(widest * focus.reach_per_coc + 1.0, 0.0, widest <= focus.in_focus_coc_px);
        new_reach_px[tile.y * focus.tiles.x + tile.x] = reach;
    }
}

/// Of the reach of a tile what arrives `tiles` tiles away: all or nothing. From the last
/// pixel of a tile to the first of another there are 8 (tiles - 1) + 1 px.
fn arriving(reach: f32, tiles: u32) -> f32 {
    return select(0.0, reach, tiles == 0u || reach >= f32(TILE * (tiles - 1u)) + 1.0);
}

/// Of what reaches tile `id` along `axis`, (1, 0) or (0, 1), the greatest.
fn spread(id: vec2u, axis: vec2u) {
    if any(id >= focus.tiles) {
        return;
    }
    let own = dot(id, axis);
    let last = min(own + focus.reach, dot(focus.tiles, axis) - 1u);
    var widest = 0.0;
    for (var i = max(own, focus.reach) - focus.reach; i <= last; i++) {
        let tile = id * (1u - axis) + i * axis;
        let reach = reach_px[tile.y * focus.tiles.x + tile.x];
        widest = max(widest, arriving(reach, max(i, own) - min(i, own)));
    }
    new_reach_px[id.y * focus.tiles.x + id.x] = widest;
}

@compute @workgroup_size(8, 8)
fn spread_rows(@builtin(global_invocation_id) id: vec3u) {
    spread(id.xy, vec2u(1u, 0u));
}

@compute @workgroup_size(8, 8)
fn spread_columns(@builtin(global_invocation_id) id: vec3u) {
    spread(id.xy, vec2u(0u, 1u));
}

fn is_reached(tile: vec2u) -> bool {
    return reach_px[tile.y * focus.tiles.x + tile.x] > 0.0;
}

@compute @workgroup_size(8, 8)
fn list_by_focus(@builtin(global_invocation_id) id: vec3u) {
    if all(id.xy < listed.tiles) {
        list_tile(id.xy, select(IN_FOCUS, DEFOCUSED, is_reached(id.xy + focus.first_tile)));
    }
}

@compute @workgroup_size(1)
fn plan_dispatches() {
    for (var i = 0u; i < CLASSES; i++) {
        let length = atomicLoad(&new_dispatches[4u * i + 3u]);
        atomicStore(&new_dispatches[4u * i], min(length, MAX_GROUPS));
        atomicStore(&new_dispatches[4u * i + 1u], (length + MAX_GROUPS - 1u) / MAX_GROUPS);
        atomicStore(&new_dispatches[4u * i + 2u], 1u);
    }
}

// ---- tiles that are left as they are ----

@group(0) @binding(5) var color: texture_2d<f32>;
@group(0) @binding(6) var result: texture_storage_2d<COLOR_FORMAT, write>;

@compute @workgroup_size(8, 8)
fn copy_tiles(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let tile = listed_tile(group);
    if !is_tile(tile) {
        return;
    }
    let at = tile * TILE + local.xy;
    if all(at < textureDimensions(result)) {
        textureStore(result, at, textureLoad(color, at + focus.overscan, 0));
    }
}

// ---- to look at ----

@group(0) @binding(8) var classes: texture_storage_2d<r32float, write>;

@compute @workgroup_size(1)
fn show_class(@builtin(workgroup_id) group: vec3u) {
    let tile = listed_tile(group);
    if is_tile(tile) {
        textureStore(classes, tile, vec4f(f32(listed.class_of), 0.0, 0.0, 0.0));
    }
}
