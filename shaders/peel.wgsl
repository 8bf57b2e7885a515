// Peeling layers (src/view/peel.rs): empty texels are marked, the next layer is bounded,
// and its mean over more samples gets box-filtered levels.
//
// A lens ray gets behind a surface only past an edge of it. From the edge, it gets there at
// most as far as the surface's CoC radius differs from that of what lies behind: so tiles
// without an edge that near need no hidden layers, and are left out.

struct Params {
    /// Stored depth z that the next layer lies behind this one at least.
    separation_z: f32,
    /// Stored depth in front of which it lies farther behind.
    widening_from_z: f32,
    /// 1 for the first layer, which has no empty texels whatever its alpha.
    nearest: u32,
    /// Side of a tile, texels.
    tile: u32,
    tiles_x: u32,
    tiles_y: u32,
    /// CoC radius, texels, of one unit of stored depth through any lens that the layers are
    /// to serve, at most.
    radius_per_z: f32,
    /// Difference of CoC radius, texels, between neighbours that makes an edge.
    edge: f32,
}

struct Reduction {
    /// Texels of the finer level that hold something; the rest pads it.
    finer_size: vec2u,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var color: texture_2d<f32>;
@group(0) @binding(2) var depth: texture_2d<f32>;
@group(0) @binding(3) var marked: texture_storage_2d<r32float, write>;
@group(0) @binding(4) var below: texture_storage_2d<r32float, write>;
@group(0) @binding(5) var<uniform> reduction: Reduction;
@group(0) @binding(6) var finer: texture_2d_array<f32>;
@group(0) @binding(7) var coarser: texture_storage_2d_array<rgba16float, write>;

/// By tile: greatest stored depth in x, distance in tiles to the nearest edge in y.
@group(0) @binding(8) var<storage, read_write> edges: array<vec2f>;
/// The same after a search along rows, and then whether hidden layers may be seen, in x.
@group(0) @binding(9) var<storage, read_write> row_edges: array<vec2f>;
@group(0) @binding(10) var<storage, read_write> needed: array<u32>;

const NO_EDGE = 1e6;

/// What is added to the separation behind the second layer, over the distance in front of
/// `widening_from_z`: what lies right behind a visible surface still shows past its edge.
const WIDENING = 0.05;

/// Stored depth that the layer behind a surface at z lies behind it at least.
fn separation(z: f32) -> f32 {
    let widening = select(WIDENING, 0.0, params.nearest != 0u);
    return params.separation_z + widening * max(0.0, z - params.widening_from_z);
}

fn is_edge(at: vec2u, z: f32) -> bool {
    let last = textureDimensions(depth) - 1u;
    let right = textureLoad(depth, min(at + vec2u(1u, 0u), last), 0).r;
    let below_it = textureLoad(depth, min(at + vec2u(0u, 1u), last), 0).r;
    return params.radius_per_z * max(abs(right - z), abs(below_it - z)) >= params.edge;
}

@compute @workgroup_size(8, 8)
fn find_edges(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= params.tiles_x || id.y >= params.tiles_y {
        return;
    }
    let end = min((id.xy + 1u) * params.tile, textureDimensions(depth));
    var nearest = 0.0;
    var edge = false;
    for (var y = id.y * params.tile; y < end.y; y++) {
        for (var x = id.x * params.tile; x < end.x; x++) {
            let z = textureLoad(depth, vec2u(x, y), 0).r;
            nearest = max(nearest, z);
            edge = edge || is_edge(vec2u(x, y), z);
        }
    }
    edges[id.y * params.tiles_x + id.x] = vec2f(nearest, select(NO_EDGE, 0.0, edge));
}

@compute @workgroup_size(8, 8)
fn spread_edges(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= params.tiles_x || id.y >= params.tiles_y {
        return;
    }
    var distance = NO_EDGE;
    for (var x = 0u; x < params.tiles_x; x++) {
        let apart = f32(max(x, id.x) - min(x, id.x));
        distance = min(distance, apart + edges[id.y * params.tiles_x + x].y);
    }
    let index = id.y * params.tiles_x + id.x;
    row_edges[index] = vec2f(edges[index].x, distance);
}

@compute @workgroup_size(8, 8)
fn mark_needed(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= params.tiles_x || id.y >= params.tiles_y {
        return;
    }
    var distance = NO_EDGE;
    for (var y = 0u; y < params.tiles_y; y++) {
        let apart = f32(max(y, id.y) - min(y, id.y));
        distance = min(distance, max(apart, row_edges[y * params.tiles_x + id.x].y));
    }
    let index = id.y * params.tiles_x + id.x;
    // Between tiles that are n apart lie n - 1 others; a texel for the read.
    let apart_texels = (distance - 1.0) * f32(params.tile) - 1.0;
    needed[index] = u32(apart_texels <= params.radius_per_z * row_edges[index].x);
}

@compute @workgroup_size(8, 8)
fn mark_layer(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(depth)) {
        return;
    }
    let z = textureLoad(depth, id.xy, 0).r;
    // The background lies at z = 0 as nothing does, but has an alpha.
    let empty = params.nearest == 0u && textureLoad(color, id.xy, 0).a == 0.0;
    textureStore(marked, id.xy, vec4f(select(max(z, 0.0), -1.0, empty)));
    let tile = id.xy / params.tile;
    let shows = needed[tile.y * params.tiles_x + tile.x] != 0u;
    textureStore(below, id.xy, vec4f(select(-1.0, z - separation(z), shows)));
}

@compute @workgroup_size(8, 8)
fn reduce_layer(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(coarser)) {
        return;
    }
    var sum = vec4f(0.0);
    for (var i = 0u; i < 4u; i++) {
        sum += textureLoad(finer, min(2u * id.xy + vec2u(i % 2u, i / 2u), reduction.finer_size - 1u), 0, 0);
    }
    textureStore(coarser, id.xy, 0, 0.25 * sum);
}
