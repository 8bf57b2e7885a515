// Tiles of one class, as `plan_dispatches` in adaptive_tiles.wgsl lists them: what an
// indirect dispatch of one workgroup a tile works on.

#import layers

@group(1) @binding(0) var<uniform> listed: Listed;
@group(1) @binding(1) var<storage, read> lists: array<u32>;
@group(1) @binding(2) var<storage, read> dispatches: array<vec4u, 3>;
@group(1) @binding(3) var<storage, read> tiles: array<Tile>;

struct Listed {
    /// COPY, UNIFORM or COMPLEX.
    class_of: u32,
}

/// A tile of the list, or beyond the frame where the grid is larger than the list.
fn listed_tile(group: vec3u) -> vec2u {
    let place = group.x + group.y * 65535u;
    if place >= dispatches[listed.class_of].w {
        return vec2u(0xffffu);
    }
    let tile = lists[listed.class_of * adaptive.inner_tiles.x * adaptive.inner_tiles.y + place];
    return vec2u(tile & 0xffffu, tile >> 16u);
}

fn is_tile(tile: vec2u) -> bool {
    return all(tile < adaptive.inner_tiles);
}

fn tile_at(tile: vec2u) -> Tile {
    return tiles[tile.y * adaptive.inner_tiles.x + tile.x];
}
