// adaptive, pass 5: buckets filtered over neighbouring pixels, whose lens points differ,
// and composited front to back (src/methods/adaptive/mod.rs).

#import color
#import layers
#import listed_tiles

/// The samples of the first layer.
@group(0) @binding(1) var sample_colors: texture_2d<f32>;
@group(0) @binding(2) var buckets: texture_2d_array<f32>;
@group(0) @binding(3) var glow: texture_2d<f32>;
@group(0) @binding(4) var result: texture_storage_2d<COLOR_FORMAT, write>;
@group(0) @binding(5) var counts: texture_storage_2d<rgba16float, write>;

/// What the pinhole sees at the centre of a pixel of the inner frame.
fn pinhole_color(pixel: vec2u) -> vec3f {
    return textureLoad(sample_colors, (pixel + adaptive.overscan) * adaptive.samples_a_side, 0).rgb;
}

/// Side of a tile with the two pixels around it that the widest filter reads.
const APRON_SIDE = 12u;

/// Buckets of the tile and its surroundings; all zero beyond the frame.
var<workgroup> apron: array<array<vec4f, BUCKETS>, APRON_SIDE * APRON_SIDE>;

/// Buckets that any of these has something in, a bit each: the others need no filter.
var<workgroup> occupied: atomic<u32>;

fn load_apron(tile: vec2u, i: u32) {
    let at = vec2i(tile * TILE) + vec2i(vec2u(i % APRON_SIDE, i / APRON_SIDE)) - 2;
    for (var b = 0u; b < BUCKETS; b++) {
        apron[i][b] = vec4f(0.0);
    }
    if any(at < vec2i(0)) || any(at >= vec2i(adaptive.size)) {
        return;
    }
    if tile_at(vec2u(at) / TILE).class_of == COPY {
        apron[i][SHARP] = vec4f(pinhole_color(vec2u(at)), 1.0);
        atomicOr(&occupied, 1u << SHARP);
        return;
    }
    var found = 0u;
    for (var b = 0u; b < BUCKETS; b++) {
        let hit = textureLoad(buckets, at, b, 0);
        apron[i][b] = hit;
        found |= u32(hit.w > 0.0) << b;
    }
    atomicOr(&occupied, found);
}

@compute @workgroup_size(8, 8)
fn composite(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let tile = listed_tile(group);
    if all(tile < adaptive.inner_tiles) {
        for (var i = index; i < APRON_SIDE * APRON_SIDE; i += TILE * TILE) {
            load_apron(tile, i);
        }
    }
    workgroupBarrier();
    let pixel = tile * TILE + local.xy;
    if any(pixel >= adaptive.size) {
        return;
    }
    let found = atomicLoad(&occupied);
    let first = countTrailingZeros(found);
    let end = 32u - countLeadingZeros(found);
    // The outermost buckets are filtered over 5x5 pixels, their neighbours over 3x3.
    let reach = select(select(1u, 0u, found == 1u << SHARP), 2u, first == 0u || end == BUCKETS);
    let side = 2u * reach + 1u;
    // Per bucket, what hits it and what is left to hit it, both filtered.
    var filtered: array<vec4f, BUCKETS>;
    var remaining: array<f32, BUCKETS>;
    for (var i = 0u; i < side * side; i++) {
        let offset = vec2u(i % side, i / side) + 2u - reach;
        let from_centre = abs(vec2f(offset) - 2.0);
        let narrow = max(vec2f(0.0), 1.0 - 0.5 * from_centre) * vec2f(from_centre < vec2f(1.5));
        let wide = min(vec2f(1.0), 1.5 - 0.5 * from_centre);
        let weights = vec3f(wide.x * wide.y, narrow.x * narrow.y, f32(all(offset == vec2u(2u))));
        let texel = (local.y + offset.y) * APRON_SIDE + local.x + offset.x;
        // Beyond the frame nothing was traced, and nothing remains.
        var rest = 0.0;
        for (var b = first; b < end; b++) {
            rest += apron[texel][b].w;
        }
        for (var b = first; b < end; b++) {
            let hit = apron[texel][b];
            let weight = weights[min(b, BUCKETS - 1u - b)];
            filtered[b] += weight * hit;
            remaining[b] += weight * max(rest, 0.0);
            rest -= hit.w;
        }
    }
    var color = vec3f(0.0);
    var transmitted = 1.0;
    for (var b = first; b < end; b++) {
        // Weights are f16: less than this is a rounding of 1.
        if remaining[b] > 2e-3 {
            color += transmitted * filtered[b].rgb / remaining[b];
            transmitted *= max(0.0, 1.0 - filtered[b].w / remaining[b]);
        }
    }
    color /= 1.0 - transmitted;
    if tile_at(tile).emitters > 0u {
        color += textureLoad(glow, pixel, 0).rgb;
    }
    textureStore(result, pixel, vec4f(min(color, vec3f(MAX_F16)), 1.0));
}

@compute @workgroup_size(8, 8)
fn copy_sharp(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let pixel = listed_tile(group) * TILE + local.xy;
    if all(pixel < adaptive.size) {
        let color = pinhole_color(pixel);
        textureStore(result, pixel, vec4f(color, 1.0));
        if adaptive.diagnose != 0u {
            textureStore(counts, pixel, vec4f(0.0, 1.0, 0.0, 0.0));
        }
    }
}
