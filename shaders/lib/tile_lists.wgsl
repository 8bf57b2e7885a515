// 8x8 tiles of an image by class (src/methods/tile_lists.rs): what dispatches of one
// workgroup a tile work on. A pass either says of each tile which class it has, by
// `list_tile`, or works on those of one, by `listed_tile`.
//
// By lists, each class has one, and a dispatch as many workgroups as its list is long. By
// branches a dispatch has a workgroup for every tile, which asks for the tile's class.

const TILE = 8u;

/// Classes that can be told apart.
const CLASSES = 4u;

/// The class of tiles that are left as they are.
const IN_FOCUS = 0u;

/// Workgroups along x: what every adapter allows. Longer lists go on along y.
const MAX_GROUPS = 65535u;

struct Listed {
    /// Tiles of the image.
    tiles: vec2u,
    /// The class that is worked on.
    class_of: u32,
    /// 1: `lists` holds the class of each tile, row by row.
    by_branches: u32,
}

@group(1) @binding(0) var<uniform> listed: Listed;
@group(1) @binding(1) var<storage, read> lists: array<u32>;
/// Workgroups x, y, z and the list's length of each class.
@group(1) @binding(2) var<storage, read> dispatches: array<vec4u, CLASSES>;
@group(1) @binding(3) var<storage, read_write> new_lists: array<u32>;
@group(1) @binding(4) var<storage, read_write> new_dispatches: array<atomic<u32>, 16>;

/// Adds a tile to a class; its position in the list depends on the order of the invocations.
fn list_tile(tile: vec2u, class_of: u32) {
    if listed.by_branches != 0u {
        new_lists[tile.y * listed.tiles.x + tile.x] = class_of;
        return;
    }
    let place = atomicAdd(&new_dispatches[4u * class_of + 3u], 1u);
    new_lists[class_of * listed.tiles.x * listed.tiles.y + place] = tile.x | (tile.y << 16u);
}

/// The tile of a workgroup; one beyond the image where it has none.
fn listed_tile(group: vec3u) -> vec2u {
    if listed.by_branches != 0u {
        let is_listed = all(group.xy < listed.tiles) && lists[group.y * listed.tiles.x + group.x] == listed.class_of;
        return select(vec2u(0xffffu), group.xy, is_listed);
    }
    let place = group.x + group.y * MAX_GROUPS;
    if place >= dispatches[listed.class_of].w {
        return vec2u(0xffffu);
    }
    let tile = lists[listed.class_of * listed.tiles.x * listed.tiles.y + place];
    return vec2u(tile & 0xffffu, tile >> 16u);
}

fn is_tile(tile: vec2u) -> bool {
    return all(tile < listed.tiles);
}
