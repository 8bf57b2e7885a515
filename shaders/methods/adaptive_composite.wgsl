// adaptive, pass 5: buckets filtered over neighbouring pixels, whose lens points differ,
// and composited front to back (src/methods/adaptive/mod.rs).

#import color
#import layers
#import listed_tiles

/// The samples of the first layer.
@group(0) @binding(1) var sample_colors: texture_2d<f32>;
/// By tile, the buckets that have something in any pixel, a bit each: the others are not written.
@group(0) @binding(6) var<storage, read> tile_buckets: array<u32>;
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

/// What hits the buckets of the tile and its surroundings, four f16 as they are stored; all zero beyond
/// the frame.
var<workgroup> apron: array<array<vec2u, BUCKETS>, APRON_SIDE * APRON_SIDE>;

/// The same filtered along rows, by row of the surroundings and column of the tile, and what is left to
/// hit each bucket.
var<workgroup> row_hits: array<array<vec4f, BUCKETS>, APRON_SIDE * TILE>;
var<workgroup> row_rests: array<array<f32, BUCKETS>, APRON_SIDE * TILE>;

/// Buckets that any of these has something in, a bit each: the others need no filter.
var<workgroup> occupied: atomic<u32>;

fn packed(hit: vec4f) -> vec2u {
    return vec2u(pack2x16float(hit.xy), pack2x16float(hit.zw));
}

fn unpacked(hit: vec2u) -> vec4f {
    return vec4f(unpack2x16float(hit.x), unpack2x16float(hit.y));
}

fn load_apron(tile: vec2u, i: u32) {
    let at = vec2i(tile * TILE) + vec2i(vec2u(i % APRON_SIDE, i / APRON_SIDE)) - 2;
    for (var b = 0u; b < BUCKETS; b++) {
        apron[i][b] = vec2u(0u);
    }
    if any(at < vec2i(0)) || any(at >= vec2i(adaptive.size)) {
        return;
    }
    if tile_at(vec2u(at) / TILE).class_of == COPY {
        apron[i][SHARP] = packed(vec4f(pinhole_color(vec2u(at)), 1.0));
        atomicOr(&occupied, 1u << SHARP);
        return;
    }
    let written = tile_buckets[u32(at.y) / TILE * adaptive.inner_tiles.x + u32(at.x) / TILE];
    var found = 0u;
    for (var b = 0u; b < BUCKETS; b++) {
        if (written & (1u << b)) != 0u {
            let hit = textureLoad(buckets, at, b, 0);
            apron[i][b] = packed(hit);
            found |= u32(hit.w > 0.0) << b;
        }
    }
    atomicOr(&occupied, found);
}

/// Weight of one of the five pixels along a row or column in the filter of a bucket: the outermost are
/// filtered by [1 2 2 2 1] / 2, their neighbours by [1 2 1] / 2, each on both axes, the sharp one not.
fn weight_of(bucket: u32, tap: u32) -> f32 {
    let away = abs(f32(tap) - 2.0);
    if bucket == SHARP {
        return select(0.0, 1.0, away == 0.0);
    }
    if bucket == 0u || bucket == BUCKETS - 1u {
        return min(1.0, 1.5 - 0.5 * away);
    }
    return max(0.0, 1.0 - 0.5 * away);
}

/// Pixels that the widest filter reads along a row or column.
const TAPS = 5u;

/// Filters one place of `row_hits` along its row, in the buckets that have something.
fn filter_row(i: u32, found: u32) {
    let first = (i / TILE) * APRON_SIDE + i % TILE;
    // Beyond the frame nothing was traced, and nothing remains.
    var rest: array<f32, TAPS>;
    for (var tap = 0u; tap < TAPS; tap++) {
        for (var b = 0u; b < BUCKETS; b++) {
            rest[tap] += unpack2x16float(apron[first + tap][b].y).y;
        }
    }
    for (var b = 0u; b < BUCKETS; b++) {
        if (found & (1u << b)) == 0u {
            continue;
        }
        var hits = vec4f(0.0);
        var rests = 0.0;
        for (var tap = 0u; tap < TAPS; tap++) {
            let hit = unpacked(apron[first + tap][b]);
            let weight = weight_of(b, tap);
            hits += weight * hit;
            rests += weight * max(rest[tap], 0.0);
            rest[tap] -= hit.w;
        }
        row_hits[i][b] = hits;
        row_rests[i][b] = rests;
    }
}

@compute @workgroup_size(8, 8)
fn composite(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let tile = listed_tile(group);
    if is_tile(tile) {
        for (var i = index; i < APRON_SIDE * APRON_SIDE; i += TILE * TILE) {
            load_apron(tile, i);
        }
    }
    workgroupBarrier();
    if is_tile(tile) {
        for (var i = index; i < APRON_SIDE * TILE; i += TILE * TILE) {
            filter_row(i, atomicLoad(&occupied));
        }
    }
    workgroupBarrier();
    let pixel = tile * TILE + local.xy;
    if any(pixel >= adaptive.size) {
        return;
    }
    var color = vec3f(0.0);
    var transmitted = 1.0;
    let found = atomicLoad(&occupied);
    for (var b = 0u; b < BUCKETS; b++) {
        if (found & (1u << b)) == 0u {
            continue;
        }
        // What hits the bucket and what is left to hit it, both filtered.
        var filtered = vec4f(0.0);
        var remaining = 0.0;
        for (var tap = 0u; tap < TAPS; tap++) {
            let row = (local.y + tap) * TILE + local.x;
            let weight = weight_of(b, tap);
            filtered += weight * row_hits[row][b];
            remaining += weight * row_rests[row][b];
        }
        // Weights are f16: less than this is a rounding of 1.
        if remaining > 2e-3 {
            color += transmitted * filtered.rgb / remaining;
            transmitted *= max(0.0, 1.0 - filtered.w / remaining);
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
