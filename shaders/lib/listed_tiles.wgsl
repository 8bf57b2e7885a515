// The tiles of `adaptive` by their lists.

#import layers
#import tile_lists

@group(1) @binding(5) var<storage, read> tiles: array<Tile>;

fn tile_at(tile: vec2u) -> Tile {
    return tiles[tile.y * listed.tiles.x + tile.x];
}
