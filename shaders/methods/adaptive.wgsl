// adaptive, passes 3 and 4: lens rays through peeled layers, and what they hit composited
// (src/methods/adaptive/mod.rs).
//
//   s ^            each ray is straight in (x, y, s); it walks the bins that the tile's
//     |  / / ray   mask says are occupied, front (s < 0) to back, and hits the first
//     |_/_/__ x    surface whose s the texel under it holds
//     |/ /
//
// Hits go to five buckets by s, premultiplied. Neighbouring pixels have other lens points,
// so a small filter over each bucket multiplies their number; the buckets are then
// composited front to back.

#import color
#import layers
#import sampling

@group(0) @binding(0) var<uniform> adaptive: Adaptive;
/// s of up to four layers, nearest first.
@group(0) @binding(1) var radii: texture_2d<f32>;
@group(0) @binding(2) var colors: texture_2d_array<f32>;
@group(0) @binding(3) var linear_clamp: sampler;
@group(0) @binding(4) var<storage, read> tiles: array<Tile>;
@group(0) @binding(5) var<storage, read> lists: array<u32>;
@group(0) @binding(6) var<storage, read> dispatches: array<vec4u, 3>;
/// `adaptive.points` lens points for each of the 8x8 pixels of a tile.
@group(0) @binding(7) var<storage, read> lens_points: array<vec2f>;
@group(0) @binding(8) var new_buckets: texture_storage_2d_array<rgba16float, write>;
@group(0) @binding(9) var buckets: texture_2d_array<f32>;
@group(0) @binding(10) var result: texture_storage_2d<COLOR_FORMAT, write>;
@group(0) @binding(11) var counts: texture_storage_2d<rgba16float, write>;
@group(0) @binding(12) var<uniform> listed: Listed;
@group(0) @binding(13) var<uniform> highlights: Highlights;
@group(0) @binding(14) var<storage, read> emitter_lists: array<u32>;
@group(0) @binding(15) var<storage, read> emitters: array<Emitter>;
/// Density of lens points over the square of v from -2 to 2 lens radii, with mipmaps.
@group(0) @binding(16) var aperture: texture_2d<f32>;

struct Listed {
    /// COPY, UNIFORM or COMPLEX.
    class_of: u32,
}

struct Highlights {
    /// Emitters that a tile can list.
    capacity: u32,
}

const BUCKETS = 5u;
/// The array layer behind the buckets: what emitters add to the composite.
const GLOW = BUCKETS;
/// The bucket in focus, which is not filtered.
const SHARP = 2u;
/// How far, px of s, a surface may be from a ray's step to be hit: cracks open at 0, edges
/// thicken from 1 on.
const TOLERANCE_S = 0.25;
const PI = 3.14159265;

/// A tile of the list, or beyond the frame where the grid is larger than the list.
fn listed_tile(group: vec3u) -> vec2u {
    let place = group.x + group.y * 65535u;
    if place >= dispatches[listed.class_of].w {
        return vec2u(0xffffu);
    }
    let tile = lists[listed.class_of * adaptive.inner_tiles.x * adaptive.inner_tiles.y + place];
    return vec2u(tile & 0xffffu, tile >> 16u);
}

fn tile_at(tile: vec2u) -> Tile {
    return tiles[tile.y * adaptive.inner_tiles.x + tile.x];
}

/// The texel of the layers at a position, px.
fn texel_at(position: vec2f) -> vec2i {
    return clamp_to_image(vec2i(floor(texels_of(adaptive, position))), textureDimensions(radii));
}

/// What the pinhole sees at the centre of a pixel of the inner frame.
fn pinhole_color(pixel: vec2u) -> vec3f {
    return textureLoad(colors, (pixel + adaptive.overscan) * adaptive.fineness, 0, 0).rgb;
}

fn radii_at(position: vec2f) -> vec4f {
    return textureLoad(radii, texel_at(position), 0);
}

// ---- tracing ----

/// Longest list of runs of occupied bins: every other one.
const MAX_RUNS = 32u;

/// s of the near and far end of each run of occupied bins.
var<workgroup> runs: array<vec2f, MAX_RUNS>;
var<workgroup> run_count: u32;
var<workgroup> emitter_count: u32;

fn find_runs(mask: vec2u) {
    var rest = mask;
    var count = 0u;
    while any(rest != vec2u(0u)) {
        let start = first_bin(rest);
        // The first bin from `start` on that is not occupied.
        let free = ~rest & ~first_bins(start);
        let end = select(BINS, first_bin(free), any(free != vec2u(0u)));
        runs[count] = vec2f(edge_of(adaptive, start), edge_of(adaptive, end));
        count += 1u;
        rest &= ~first_bins(end);
    }
    run_count = count;
}

struct Hit {
    /// Layer, or -1 for none.
    layer: i32,
    s: f32,
    /// Where the ray meets it, px of the outer frame.
    at: vec2f,
    /// Texels of radii that were read.
    reads: u32,
}

fn first_within(s: vec4f, low: f32, high: f32) -> i32 {
    for (var k = 0; k < 4; k++) {
        if s[k] >= low && s[k] <= high {
            return k;
        }
    }
    return -1;
}

fn nearest_to(s: vec4f, wanted: f32) -> i32 {
    let d = abs(s - wanted);
    let first = select(0, 1, d.y < d.x);
    let second = select(2, 3, d.w < d.z);
    return select(first, second, min(d.z, d.w) < min(d.x, d.y));
}

/// The first surface on the ray through `p` and lens point `v`.
fn trace(p: vec2f, v: vec2f) -> Hit {
    var reads = 0u;
    for (var r = 0u; r < run_count; r++) {
        let run = runs[r];
        // A step may cross two pixels, but near the focus a texel: there silhouettes are sharp.
        let sharp = adaptive.fineness > 1u && max(abs(run.x), abs(run.y)) < 2.5;
        let steps_per_px = select(0.5, f32(adaptive.fineness), sharp);
        let steps = max(1u, u32(ceil(steps_per_px * length(v) * (run.y - run.x))));
        let width = (run.y - run.x) / f32(steps);
        for (var i = 0u; i < steps; i++) {
            let start = run.x + f32(i) * width;
            let at = p - v * (start + 0.5 * width);
            let s = radii_at(at);
            reads += 1u;
            let k = first_within(s, start - TOLERANCE_S, start + width + TOLERANCE_S);
            if k < 0 {
                continue;
            }
            // Where the ray meets the surface that this texel holds, there may be another.
            let refined = p - v * s[k];
            let there = radii_at(refined);
            let j = nearest_to(there, s[k]);
            if abs(there[j] - s[k]) <= max(0.5, TOLERANCE_S + width) {
                return Hit(j, there[j], p - v * there[j], reads + 1u);
            }
            return Hit(k, s[k], at, reads + 1u);
        }
    }
    return Hit(-1, 0.0, p, reads);
}

fn bucket_of(s: f32) -> u32 {
    let size = abs(s);
    if size <= adaptive.sharp_s {
        return SHARP;
    }
    let offset = select(1u, 2u, size > adaptive.narrow_s);
    return select(SHARP + offset, SHARP - offset, s < 0.0);
}

/// Four times the variance, px^2 per axis, of the filter that `composite` applies to a
/// bucket: [1 2 1] / 4 has 1/2, [1 2 2 2 1] / 8 has 3/2.
fn filter_blur(bucket: u32) -> f32 {
    if bucket == SHARP {
        return 0.0;
    }
    return select(2.0, 6.0, bucket == 0u || bucket == BUCKETS - 1u);
}

/// By how much a ray's offset shrinks so that the blur of reading a texel (`read_blur`)
/// and of the filter, both four times a variance, are not added to the lens's own.
fn shrink(s: f32, read_blur: f32) -> f32 {
    let s2 = s * s * adaptive.lens_variance;
    // Where the read alone blurs as much as the lens, no offset is right; the read's blur
    // then fades in with the lens's.
    if s2 < 2.16 * read_blur {
        return 0.481 * sqrt(s2 / read_blur);
    }
    return sqrt(1.0 - min((read_blur + filter_blur(bucket_of(s))) / s2, 0.9));
}

/// Four times the variance, texel^2, of a bilinear read at arbitrary phases.
const BILINEAR_BLUR = 0.667;

/// Colour of a hit. `limited`: without what emitters bring.
fn color_of(hit: Hit, p: vec2f, v: vec2f, limited: bool) -> vec3f {
    let size = vec2f(textureDimensions(radii));
    let read_blur = BILINEAR_BLUR / f32(adaptive.fineness * adaptive.fineness);
    let ray = texels_of(adaptive, p - v * (hit.s * shrink(hit.s, read_blur)));
    let at = clamp(ray, vec2f(0.5), size - 0.5);
    let b = bilinear(at);
    var same = true;
    var s: vec4f;
    for (var i = 0; i < 4; i++) {
        s[i] = textureLoad(radii, corner_of(b, i), 0)[hit.layer];
        same = same && abs(s[i] - hit.s) <= 0.25 + 0.08 * abs(hit.s);
    }
    if !same {
        let texel = texel_at(hit.at);
        return limited_color(texel, hit.layer, hit.s, limited);
    }
    if !limited {
        return textureSampleLevel(colors, linear_clamp, at / vec2f(textureDimensions(colors)), hit.layer, 0.0).rgb;
    }
    var sum = vec3f(0.0);
    for (var i = 0; i < 4; i++) {
        let w = mix(1.0 - b.weight, b.weight, vec2f(vec2i(i & 1, i >> 1)));
        sum += w.x * w.y * limited_color(corner_of(b, i), hit.layer, s[i], limited);
    }
    return sum;
}

fn corner_of(b: Bilinear, i: i32) -> vec2i {
    return clamp_to_image(b.corner + vec2i(i & 1, i >> 1), textureDimensions(radii));
}

fn limited_color(texel: vec2i, layer: i32, s: f32, limited: bool) -> vec3f {
    let color = textureLoad(colors, texel, layer, 0).rgb;
    // Emitters are texels of the first layer.
    return select(color, min(color, vec3f(highlight_limit(s))), limited && layer == 0);
}

// ---- emitters ----

/// What the tile's emitters bring to `p`, each through one ray.
fn glow(p: vec2f, tile: vec2u, count: u32) -> vec3f {
    let listed_count = min(count, highlights.capacity);
    let start = (tile.y * adaptive.inner_tiles.x + tile.x) * highlights.capacity;
    var sum = vec3f(0.0);
    for (var i = 0u; i < listed_count; i++) {
        let emitter = emitters[emitter_lists[start + i]];
        // The emitter covers a square of the lens, and mipmaps hold means over such. One
        // level finer, as the bilinear read is as wide again; four times the variance of
        // both, (side / 2)^2, is taken off the lens's own.
        let side_over_s = emitter.side / emitter.s;
        let narrowing = 0.25 * side_over_s * side_over_s / max(adaptive.lens_variance, 0.5);
        let narrowed = emitter.s * sqrt(1.0 - narrowing);
        let v = (p - emitter.at) / narrowed;
        let texel_v = 4.0 * adaptive.lens_radius / f32(textureDimensions(aperture).x);
        let level = log2(emitter.side / (abs(emitter.s) * texel_v)) - 1.0;
        let uv = 0.5 + 0.25 * v / adaptive.lens_radius;
        let density = textureSampleLevel(aperture, linear_clamp, uv, level).r;
        if density <= 0.0 || any(uv < vec2f(0.0)) || any(uv > vec2f(1.0)) {
            continue;
        }
        let hit = trace(p, v);
        if hit.layer >= 0 && hit.s < emitter.s - 0.5 - 0.1 * abs(emitter.s) {
            continue;
        }
        sum += emitter.excess * (density / (narrowed * narrowed));
    }
    // Those that did not fit in the list count as the mean of those that did.
    return sum * (f32(count) / f32(max(listed_count, 1u)));
}

var<private> sums: array<vec4f, BUCKETS>;

fn store_sums(pixel: vec2u, hits: f32) {
    for (var b = 0u; b < BUCKETS; b++) {
        textureStore(new_buckets, pixel, b, sums[b] / hits);
    }
}

@compute @workgroup_size(8, 8)
fn trace_complex(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let tile = listed_tile(group);
    if index == 0u && all(tile < adaptive.inner_tiles) {
        let found = tile_at(tile);
        find_runs(vec2u(found.low, found.high));
        emitter_count = found.emitters;
    }
    workgroupBarrier();
    let pixel = tile * TILE + local.xy;
    if any(pixel >= adaptive.size) {
        return;
    }
    let p = vec2f(pixel + adaptive.overscan) + 0.5;
    var hits = 0.0;
    var reads = 0u;
    var hidden = 0.0;
    for (var i = 0u; i < adaptive.points; i++) {
        let v = lens_points[index * adaptive.points + i];
        let hit = trace(p, v);
        reads += hit.reads;
        if hit.layer >= 0 {
            sums[bucket_of(hit.s)] += vec4f(color_of(hit, p, v, emitter_count > 0u), 1.0);
            hits += 1.0;
            hidden += f32(hit.layer > 0);
            reads += 1u;
        }
    }
    if hits == 0.0 {
        // Nothing but cracks: what the pinhole sees.
        let own = radii_at(p).x;
        let color = pinhole_color(pixel);
        sums[bucket_of(own)] = vec4f(color, 1.0);
        hits = 1.0;
    }
    store_sums(pixel, hits);
    if emitter_count > 0u {
        textureStore(new_buckets, pixel, GLOW, vec4f(glow(p, tile, emitter_count), 1.0));
    }
    if adaptive.diagnose != 0u {
        let rays = f32(adaptive.points);
        textureStore(counts, pixel, vec4f(f32(reads), hidden / rays, 1.0 - hits / rays, 1.0));
    }
}

/// Colour of a hit from the mipmap level that fits between rays.
fn smooth_color_of(hit: Hit, p: vec2f, v: vec2f) -> vec3f {
    let k = f32(adaptive.fineness);
    let spacing = 0.35 * abs(hit.s) * sqrt(adaptive.lens_variance * PI / f32(adaptive.points));
    let footprint = k * spacing;
    // Mipmaps are of the first layer, and hold what is around the surface too.
    if footprint <= 1.0 || hit.layer != 0 || !surrounded(hit, spacing) {
        return color_of(hit, p, v, false);
    }
    // A box of `footprint` texels, read bilinearly.
    let read_blur = (footprint * footprint - 0.333) / (k * k);
    let at = texels_of(adaptive, p - v * (hit.s * shrink(hit.s, read_blur)));
    let level = log2(footprint);
    let margin = 0.5 * exp2(ceil(level));
    let size = vec2f(textureDimensions(radii));
    let inside = clamp(at, vec2f(margin), max(size - margin, vec2f(margin)));
    return textureSampleLevel(colors, linear_clamp, inside / vec2f(textureDimensions(colors)), 0, level).rgb;
}

/// Whether the first layer is the surface that was hit up to `distance` px around.
fn surrounded(hit: Hit, distance: f32) -> bool {
    var same = true;
    for (var i = 0; i < 4; i++) {
        let offset = 2.0 * vec2f(vec2i(i & 1, i >> 1)) - 1.0;
        same = same && abs(radii_at(hit.at + distance * offset).x - hit.s) <= 0.25 + 0.08 * abs(hit.s);
    }
    return same;
}

/// Surfaces of about one CoC, in front of which only what is in focus may lie: no march.
@compute @workgroup_size(8, 8)
fn trace_uniform(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let pixel = listed_tile(group) * TILE + local.xy;
    if any(pixel >= adaptive.size) {
        return;
    }
    let p = vec2f(pixel + adaptive.overscan) + 0.5;
    let own = radii_at(p).x;
    var hits = 0.0;
    for (var i = 0u; i < adaptive.points; i++) {
        let v = lens_points[index * adaptive.points + i];
        // What lies in front by more than surfaces in one tile of this class do is in focus
        // and does not reach here.
        let there = radii_at(p - v * own);
        let k = first_within(there, own - 1.0 - 0.5 * abs(own), 0.5 * EMPTY_S);
        if k >= 0 {
            let s = there[k];
            sums[bucket_of(s)] += vec4f(smooth_color_of(Hit(k, s, p - v * s, 1u), p, v), 1.0);
            hits += 1.0;
        }
    }
    if hits == 0.0 {
        sums[bucket_of(own)] = vec4f(pinhole_color(pixel), 1.0);
        hits = 1.0;
    }
    store_sums(pixel, hits);
    if adaptive.diagnose != 0u {
        let rays = f32(adaptive.points);
        textureStore(counts, pixel, vec4f(2.0 * rays, 0.0, 1.0 - hits / rays, 0.5));
    }
}

// ---- compositing ----

/// Side of a tile with the two pixels around it that the widest filter reads.
const APRON_SIDE = 12u;

/// Buckets of the tile and its surroundings; all zero beyond the frame.
var<workgroup> apron: array<array<vec4f, BUCKETS>, APRON_SIDE * APRON_SIDE>;

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
        return;
    }
    for (var b = 0u; b < BUCKETS; b++) {
        apron[i][b] = textureLoad(buckets, at, b, 0);
    }
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
    // Per bucket, what hits it and what is left to hit it, both filtered.
    var filtered: array<vec4f, BUCKETS>;
    var remaining: array<f32, BUCKETS>;
    for (var i = 0u; i < 25u; i++) {
        let offset = vec2u(i % 5u, i / 5u);
        let from_centre = abs(vec2f(offset) - 2.0);
        let narrow = max(vec2f(0.0), 1.0 - 0.5 * from_centre) * vec2f(from_centre < vec2f(1.5));
        let wide = min(vec2f(1.0), 1.5 - 0.5 * from_centre);
        let weights = vec3f(wide.x * wide.y, narrow.x * narrow.y, f32(i == 12u));
        let texel = (local.y + offset.y) * APRON_SIDE + local.x + offset.x;
        // Beyond the frame nothing was traced, and nothing remains.
        var rest = 0.0;
        for (var b = 0u; b < BUCKETS; b++) {
            rest += apron[texel][b].w;
        }
        for (var b = 0u; b < BUCKETS; b++) {
            let hit = apron[texel][b];
            let weight = weights[min(b, BUCKETS - 1u - b)];
            filtered[b] += weight * hit;
            remaining[b] += weight * max(rest, 0.0);
            rest -= hit.w;
        }
    }
    var color = vec3f(0.0);
    var transmitted = 1.0;
    for (var b = 0u; b < BUCKETS; b++) {
        // Weights are f16: less than this is a rounding of 1.
        if remaining[b] > 2e-3 {
            color += transmitted * filtered[b].rgb / remaining[b];
            transmitted *= max(0.0, 1.0 - filtered[b].w / remaining[b]);
        }
    }
    color /= 1.0 - transmitted;
    if tile_at(tile).emitters > 0u {
        color += textureLoad(buckets, pixel, GLOW, 0).rgb;
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
            textureStore(counts, pixel, vec4f(1.0, 0.0, 0.0, 0.0));
        }
    }
}
