// Lists of 8x8 tiles of an image, one list a class (src/methods/tile_lists.rs): what
// indirect dispatches of one workgroup a tile work on. A pass either writes the lists, by
// `list_tile`, or works on one, by `listed_tile`.

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
    _unused: u32,
}

@group(1) @binding(0) var<uniform> listed: Listed;
@group(1) @binding(1) var<storage, read> lists: array<u32>;
/// Workgroups x, y, z and the list's length of each class.
@group(1) @binding(2) var<storage, read> dispatches: array<vec4u, CLASSES>;
@group(1) @binding(3) var<storage, read_write> new_lists: array<u32>;
@group(1) @binding(4) var<storage, read_write> new_dispatches: array<atomic<u32>, 16>;

/// Adds a tile to a class; its position there depends on who comes first.
fn list_tile(tile: vec2u, class_of: u32) {
    let place = atomicAdd(&new_dispatches[4u * class_of + 3u], 1u);
    new_lists[class_of * listed.tiles.x * listed.tiles.y + place] = tile.x | (tile.y << 16u);
}

/// The tile of a workgroup; one beyond the image where the grid is larger than the list.
fn listed_tile(group: vec3u) -> vec2u {
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
