// adaptive, pass 5: buckets filtered over neighbouring pixels, whose lens points differ,
// and composited front to back (src/methods/adaptive/mod.rs).

#import color
#import layers
#import listed_tiles

/// The samples of the first layer.
@group(0) @binding(1) var sample_colors: texture_2d<f32>;
/// By tile, the buckets that have something in any pixel, a bit each: the others are not written. Of
/// tiles in focus the sharp one, which is what the pinhole sees, and IN_FOCUS_TILE.
@group(0) @binding(6) var<storage, read> tile_buckets: array<u32>;
@group(0) @binding(2) var buckets: texture_2d_array<f32>;
@group(0) @binding(3) var glow: texture_2d<f32>;
@group(0) @binding(4) var result: texture_storage_2d<COLOR_FORMAT, write>;
@group(0) @binding(5) var counts: texture_storage_2d<rgba16float, write>;

/// What the pinhole sees at the centre of a pixel of the inner frame.
fn pinhole_color(pixel: vec2u) -> vec3f {
    return textureLoad(sample_colors, (pixel + adaptive.overscan) * adaptive.samples_a_side, 0).rgb;
}

/// Side of a tile with the two pixels around it that the widest filter reads, and its pixels.
const APRON_SIDE = 12u;
const APRON = APRON_SIDE * APRON_SIDE;
/// The part of them that lies in the tile's columns.
const ROWS = APRON_SIDE * TILE;

/// Of one bucket, by pixel of the tile and its surroundings: what hits it, and what is left to hit it in
/// front of those behind it. All zero beyond the frame: nothing was traced there, and nothing remains.
var<workgroup> hits: array<vec4f, APRON>;
var<workgroup> rests: array<f32, APRON>;

/// The same filtered along rows.
var<workgroup> row_hits: array<vec4f, ROWS>;
var<workgroup> row_rests: array<f32, ROWS>;

/// A pixel that an invocation brings.
struct Brought {
    /// The buckets that have something in its tile, a bit each (`tile_buckets`).
    buckets: u32,
    /// What is left to hit the buckets so far, from the farthest on.
    rest: f32,
}

fn apron_pixel(tile: vec2u, i: u32) -> vec2i {
    return vec2i(tile * TILE) + vec2i(vec2u(i % APRON_SIDE, i / APRON_SIDE)) - 2;
}

fn brought(tile: vec2u, i: u32) -> Brought {
    let at = apron_pixel(tile, i);
    if i >= APRON || any(at < vec2i(0)) || any(at >= vec2i(adaptive.size)) {
        return Brought(0u, 0.0);
    }
    return Brought(tile_buckets[u32(at.y) / TILE * adaptive.inner_tiles.x + u32(at.x) / TILE], 0.0);
}

/// Brings what hits a bucket in a pixel.
fn bring(tile: vec2u, i: u32, bucket: u32, pixel: Brought) -> Brought {
    var hit = vec4f(0.0);
    if (pixel.buckets & (1u << bucket)) != 0u {
        let at = apron_pixel(tile, i);
        if (pixel.buckets & IN_FOCUS_TILE) != 0u {
            hit = vec4f(pinhole_color(vec2u(at)), 1.0);
        } else {
            hit = textureLoad(buckets, at, bucket, 0);
        }
    }
    let rest = pixel.rest + hit.w;
    if i < APRON {
        hits[i] = hit;
        rests[i] = rest;
    }
    return Brought(pixel.buckets, rest);
}

/// Weight of one of five pixels along a row or column in the filter of a bucket: the outermost are
/// filtered by [1 2 2 2 1] / 2, their neighbours by [1 2 1] / 2, the sharp one not.
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

/// Filters one place of the tile's columns along its row.
fn filter_row(bucket: u32, i: u32) {
    let first = (i / TILE) * APRON_SIDE + i % TILE;
    var hit = vec4f(0.0);
    var rest = 0.0;
    for (var tap = 0u; tap < TAPS; tap++) {
        let weight = weight_of(bucket, tap);
        if weight > 0.0 {
            hit += weight * hits[first + tap];
            rest += weight * rests[first + tap];
        }
    }
    row_hits[i] = hit;
    row_rests[i] = rest;
}

/// What is seen of a bucket and those behind it: premultiplied colour, and how much of all light passes.
struct Seen {
    color: vec3f,
    transmitted: f32,
}

/// Puts a bucket, filtered at a pixel of the tile, in front of what is seen behind it.
fn in_front_of(behind: Seen, bucket: u32, local: vec2u) -> Seen {
    var hit = vec4f(0.0);
    var rest = 0.0;
    for (var tap = 0u; tap < TAPS; tap++) {
        let weight = weight_of(bucket, tap);
        if weight > 0.0 {
            let row = (local.y + tap) * TILE + local.x;
            hit += weight * row_hits[row];
            rest += weight * row_rests[row];
        }
    }
    // Weights are f16: less than this is a rounding of 1.
    if rest <= 2e-3 {
        return behind;
    }
    let passes = max(0.0, 1.0 - hit.w / rest);
    return Seen(hit.rgb / rest + passes * behind.color, passes * behind.transmitted);
}

/// The buckets that have something in a tile or in those around it, a bit each.
fn buckets_around(tile: vec2u) -> u32 {
    var found = 0u;
    for (var i = 0u; i < 9u; i++) {
        let at = vec2i(tile) + vec2i(vec2u(i % 3u, i / 3u)) - 1;
        if all(at >= vec2i(0)) && all(at < vec2i(adaptive.inner_tiles)) {
            found |= tile_buckets[u32(at.y) * adaptive.inner_tiles.x + u32(at.x)];
        }
    }
    return found;
}

@compute @workgroup_size(8, 8)
fn composite(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let tile = listed_tile(group);
    if !is_tile(tile) {
        return;
    }
    let found = buckets_around(tile);
    var first = brought(tile, index);
    var second = brought(tile, index + 64u);
    var third = brought(tile, index + 128u);
    var seen = Seen(vec3f(0.0), 1.0);
    // From the farthest bucket on. All invocations meet at the barriers.
    for (var behind = 0u; behind < BUCKETS; behind++) {
        let b = BUCKETS - 1u - behind;
        let is_found = (found & (1u << b)) != 0u;
        if is_found {
            first = bring(tile, index, b, first);
            second = bring(tile, index + 64u, b, second);
            third = bring(tile, index + 128u, b, third);
        }
        workgroupBarrier();
        if is_found {
            filter_row(b, index);
            if index < ROWS - 64u {
                filter_row(b, index + 64u);
            }
        }
        workgroupBarrier();
        if is_found {
            seen = in_front_of(seen, b, local.xy);
        }
    }
    let pixel = tile * TILE + local.xy;
    if any(pixel >= adaptive.size) {
        return;
    }
    var color = seen.color / (1.0 - seen.transmitted);
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
