// Which sheets the lens rays of each 8x8 tile can meet (src/methods/sheet_rays.rs).
//
//   mark_sheets    stored depth of the nearest and the farthest sheet in each tile of the outer frame
//   reach_sheets   CoC radii of those whose blur reaches a tile of the inner frame

#import lens

const TILE = 8u;

/// Greatest |s|, px: `GREATEST_SHEET_S` in lib/sheet_rays.wgsl.
const GREATEST_S = 160.0;

struct SheetTiles {
    /// Tiles of the outer and of the inner frame.
    tiles: vec2u,
    inner_tiles: vec2u,
    lens: Lens,
    /// Outer tile of the inner frame's first pixel, in both directions.
    first_tile: u32,
    /// Margin around the inner frame, px.
    overscan: u32,
    /// Tiles on every side from which a blur can come.
    reach: u32,
    /// Greatest |v| of a lens point.
    lens_radius: f32,
    /// By how much the longer half axis of an astigmatic eye's blur is longer than |s|, px.
    more_s: f32,
}

@group(0) @binding(0) var<uniform> params: SheetTiles;
/// Stored depth of up to four layers, nearest first, -1 where they are empty.
@group(0) @binding(1) var sheet_depths: texture_2d<f32>;
@group(0) @binding(2) var<storage, read_write> new_marked: array<vec2f>;
/// By outer tile: greatest and least stored depth, the first -1 where there is none.
@group(0) @binding(3) var<storage, read> marked: array<vec2f>;
@group(0) @binding(4) var<storage, read_write> new_bounds: array<vec2f>;

@compute @workgroup_size(8, 8)
fn mark_sheets(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= params.tiles) {
        return;
    }
    let size = vec2i(textureDimensions(sheet_depths));
    let first = vec2i(id.xy * TILE + params.overscan) - i32(params.first_tile * TILE);
    var nearest = -1.0;
    var farthest = 2.0;
    for (var i = 0u; i < TILE * TILE; i++) {
        let at = first + vec2i(vec2u(i % TILE, i / TILE));
        if all(at >= vec2i(0)) && all(at < size) {
            let z = textureLoad(sheet_depths, at, 0);
            nearest = max(nearest, z.x);
            let there = select(vec4f(2.0), z, z >= vec4f(0.0));
            farthest = min(farthest, min(min(there.x, there.y), min(there.z, there.w)));
        }
    }
    new_marked[id.y * params.tiles.x + id.x] = vec2f(nearest, farthest);
}

fn s_of(z: f32) -> f32 {
    return clamp(0.5 * coc_diameter_px(params.lens, z), -GREATEST_S, GREATEST_S);
}

@compute @workgroup_size(8, 8)
fn reach_sheets(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= params.inner_tiles) {
        return;
    }
    let at = id.xy + params.first_tile;
    let low = max(at, vec2u(params.reach)) - params.reach;
    let high = min(at + params.reach, params.tiles - 1u);
    var bounds = vec2f(1e6, -1e6);
    for (var y = low.y; y <= high.y; y++) {
        for (var x = low.x; x <= high.x; x++) {
            let tile = marked[y * params.tiles.x + x];
            let apart = max(max(x, at.x) - min(x, at.x), max(y, at.y) - min(y, at.y));
            // From the last pixel of a tile to the first of another.
            let gap = select(f32(TILE * (max(apart, 1u) - 1u)) + 1.0, 0.0, apart == 0u);
            let s = vec2f(s_of(tile.x), s_of(tile.y));
            let reaches = tile.x >= 0.0 && (max(abs(s.x), abs(s.y)) + params.more_s) * params.lens_radius + 1.0 >= gap;
            bounds.x = select(bounds.x, min(bounds.x, s.x), reaches);
            bounds.y = select(bounds.y, max(bounds.y, s.y), reaches);
        }
    }
    new_bounds[id.y * params.inner_tiles.x + id.x] = bounds;
}
