// adaptive, pass 3: each pixel's lens rays through peeled layers, gathered in buckets of s
// (src/methods/adaptive/mod.rs).

#import layers
#import lens_views
#import listed_tiles
#import ray_colors
#import sheet_rays

/// Lens points of the 8x8 pixels of a tile: the first of each pixel, then the second of each...
@group(0) @binding(1) var<storage, read> lens_points: array<vec2f>;
/// Premultiplied hits, one array layer a bucket.
@group(0) @binding(2) var new_buckets: texture_storage_2d_array<rgba16float, write>;
/// Rays, texels read, sum of the layers that were hit (0 the nearest), rays that hit nothing.
@group(0) @binding(3) var counts: texture_storage_2d<rgba16float, write>;

/// What is far brighter than white, by pixel of the outer frame; one element where nothing is.
@group(0) @binding(4) var<storage, read> lights: array<Light>;
/// By tile of the inner frame, the buckets that have something in any pixel, a bit each.
@group(0) @binding(5) var<storage, read_write> tile_buckets: array<u32>;

/// Emitters whose blur covers the tile.
var<workgroup> emitter_count: u32;

/// The layer that was hit, 0 the nearest.
fn layer_number(hit: Hit) -> f32 {
    return select(f32(hit.layer), 0.0, hit.layer == SAMPLE);
}

var<private> sums: array<vec4f, BUCKETS>;

/// Buckets that have something in any pixel of the tile, a bit each.
var<workgroup> found_buckets: atomic<u32>;

/// Says which buckets the pixel has something in.
fn note_buckets() {
    var found = 0u;
    for (var b = 0u; b < BUCKETS; b++) {
        found |= select(0u, 1u << b, sums[b].w != 0.0);
    }
    atomicOr(&found_buckets, found);
}

/// Stores the buckets that any pixel of the tile has something in: the others are not read.
fn store_sums(pixel: vec2u, hits: f32) {
    let found = atomicLoad(&found_buckets);
    if all(pixel % TILE == vec2u(0u)) {
        let tile = pixel / TILE;
        tile_buckets[tile.y * adaptive.inner_tiles.x + tile.x] = found;
    }
    for (var b = 0u; b < BUCKETS; b++) {
        if adaptive.diagnose != 0u || (found & (1u << b)) != 0u {
            textureStore(new_buckets, pixel, b, sums[b] / hits);
        }
    }
}

/// Adds to a bucket: a loop over all, as what is indexed at run time leaves the registers.
fn add_to(bucket: u32, light: vec4f) {
    for (var b = 0u; b < BUCKETS; b++) {
        sums[b] += select(vec4f(0.0), light, b == bucket);
    }
}

/// What the rays of a pixel have found so far.
var<private> hit_count: f32;
var<private> layer_sum: f32;
/// Sum of the colours of every other ray less that of the rest.
var<private> imbalance: vec3f;
/// The share of noise that the composite's filter leaves in the sharpest bucket that was hit:
/// what a bucket covers of those behind it is as noisy as itself.
var<private> unfiltered: f32;

/// The share of independent noise, as a standard deviation, that the composite's filter leaves in a
/// bucket: all in the sharp one, which is not filtered; else that of [1 2 1] / 4 or
/// [1 2 2 2 1] / 8 on both axes.
fn noise_left(bucket: u32) -> f32 {
    if bucket == SHARP {
        return 1.0;
    }
    return select(0.375, 0.21875, bucket == 0u || bucket == BUCKETS - 1u);
}

/// Adds what ray `number` meets at s: light, and the share of the ray that ends there.
fn add_light(s: f32, light: vec4f, number: u32) {
    let bucket = bucket_of(s);
    add_to(bucket, light);
    hit_count += light.a;
    imbalance += select(-1.0, 1.0, (number & 1u) == 0u) * light.rgb;
    unfiltered = max(unfiltered, noise_left(bucket));
}

fn add_hit(s: f32, color: vec3f, number: u32, share: f32) {
    add_light(s, share * vec4f(color, 1.0), number);
}

/// s of the sheets that the tile's rays can meet, nearest and farthest.
var<workgroup> tile_sheets: vec2f;

/// Adds the sheets that a ray crosses in front of s = `up_to`, and returns what is left of it.
fn cross_sheets(p: vec2f, v: vec2f, up_to: f32, number: u32) -> f32 {
    if !SHEETS {
        return 1.0;
    }
    var ray = sheet_ray(ray_from(p, v), v, tile_sheets);
    for (var i = 0u; i < MOST_CROSSINGS && ray.s < ray.end_s; i++) {
        let crossing = next_sheet(&ray, adaptive.lens, up_to);
        if crossing.light.a <= 0.0 {
            break;
        }
        add_light(crossing.s, crossing.light, number);
    }
    return ray.left;
}

/// Rays of a pixel that are traced together.
const TOGETHER = 8u;

/// What the rays of the tile's pixels hit: ray by ray, 64 pixels each.
var<workgroup> hit_layers: array<i32, TOGETHER * 64u>;
var<workgroup> hit_s: array<f32, TOGETHER * 64u>;
var<workgroup> hit_at_s: array<f32, TOGETHER * 64u>;

fn lens_point(index: u32, i: u32) -> vec2f {
    return lens_points[i * TILE * TILE + index];
}

/// Traces the rays of a pixel from `first` up to `end`, `TOGETHER` at most. A pixel begins its next ray as
/// soon as one has ended: pixels that go on at the same time wait for the longest of all rays together
/// and not for the longest of each.
fn trace_together(p: vec2f, index: u32, first: u32, end: u32) {
    var i = first;
    var ray = ray_up_to(p, lens_point(index, i), EMPTY_S);
    for (var step = 0u; step < MAX_STEPS && i < end; step++) {
        let hit = advance(&ray);
        if hit.layer != NO_HIT || is_over(ray) {
            let place = (i - first) * 64u + index;
            hit_layers[place] = hit.layer;
            hit_s[place] = hit.s;
            hit_at_s[place] = hit.at_s;
            i += 1u;
            ray = ray_up_to(p, lens_point(index, min(i, end - 1u)), EMPTY_S);
        }
    }
}

/// Adds what the ray through lens point `i` hits, if a view from off the lens's centre knows that.
fn found_in_view(p: vec2f, v: vec2f, i: u32) -> bool {
    let nearby = serving_view(v);
    if nearby < 0 {
        return false;
    }
    let seen = trace_in_view(p, v, nearby);
    texels_read += seen.reads;
    if seen.layer >= 0 {
        let left = cross_sheets(p, v, seen.s, i);
        add_hit(seen.s, color_in_view(seen, p, v, nearby, emitter_count > 0u), i, left);
    }
    return seen.layer >= 0;
}

/// Casts the rays of a pixel through its lens points from `first` up to `end`.
fn cast_rays(p: vec2f, index: u32, first: u32, end: u32) {
    for (var batch = first; batch < end; batch += TOGETHER) {
        let last = min(batch + TOGETHER, end);
        trace_together(p, index, batch, last);
        for (var i = batch; i < last; i++) {
            let v = lens_point(index, i);
            if found_in_view(p, v, i) {
                continue;
            }
            let place = (i - batch) * 64u + index;
            let hit = Hit(hit_layers[place], hit_s[place], hit_at_s[place]);
            if hit.layer >= 0 {
                let left = cross_sheets(p, v, hit.s, i);
                add_hit(hit.s, color_of(hit, p, v, emitter_count > 0u), i, left);
                layer_sum += layer_number(hit);
                texels_read += 1u;
            }
        }
    }
}

/// Squared error of a pixel as a display shows it, estimated from the difference of two halves
/// of its rays.
fn estimated_error() -> f32 {
    if hit_count == 0.0 {
        return 0.0;
    }
    var sum = vec3f(0.0);
    for (var b = 0u; b < BUCKETS; b++) {
        sum += sums[b].rgb;
    }
    let mean = sum / hit_count;
    let error = unfiltered * imbalance / hit_count;
    // Slope of the sRGB curve, and none where the display is at its brightest.
    let slope = min(vec3f(12.92), 0.44 * pow(max(mean, vec3f(1e-4)), vec3f(-0.583)));
    let shown = select(slope, vec3f(0.0), mean - abs(error) > vec3f(1.0)) * error;
    return min(dot(shown, shown) / 3.0, 1.0);
}

/// Most sets of lens points (`MAX_REFINE` in src/methods/adaptive/mod.rs).
const MOST_SETS = 4u;

/// Sum over the tile's pixels of their squared errors after each set, in units of 1e-6.
var<workgroup> tile_error: array<atomic<u32>, MOST_SETS>;

/// 1: light that rays alone bring reaches the tile.
var<workgroup> is_bright: atomic<u32>;

/// How far, px, such light reaches: the greatest |s| of a light that is not all of it an emitter's
/// (`emitted_share`), and a pixel for the light itself.
const BRIGHT_REACH_PX = 3;
const BRIGHT_SIDE = TILE + 2u * u32(BRIGHT_REACH_PX);

/// Looks for light around the tile that is near focus, each invocation at some pixels. A ray meets it
/// seldom and it shows wherever one does: no estimate of noise knows it.
fn find_bright(tile: vec2u, index: u32) {
    let outer = adaptive.size + 2u * adaptive.overscan;
    let first = vec2i(tile * TILE + adaptive.overscan) - BRIGHT_REACH_PX;
    let count = select(0u, BRIGHT_SIDE * BRIGHT_SIDE, tile_at(tile).lit != 0u && !IMAGE);
    for (var i = index; i < count; i += 64u) {
        let at = clamp_to_image(first + vec2i(vec2u(i % BRIGHT_SIDE, i / BRIGHT_SIDE)), outer);
        let light = lights[u32(at.y) * outer.x + u32(at.x)];
        if light.weight > 0.0 {
            let s = s_of_depth(adaptive, light.z / light.weight);
            atomicOr(&is_bright, select(0u, 1u, emitted_share(greatest_s(s), adaptive.lens_radius, false) < 1.0));
        }
    }
}

@compute @workgroup_size(8, 8)
fn trace_complex(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let tile = listed_tile(group);
    if !is_tile(tile) {
        return;
    }
    if index == 0u {
        let found = tile_at(tile);
        find_runs(vec2u(found.low, found.high));
        emitter_count = found.emitters;
        tile_sheets = sheet_bounds_of(tile.y * adaptive.inner_tiles.x + tile.x);
    }
    find_bright(tile, index);
    find_nearest(tile, index);
    workgroupBarrier();
    let pixel = tile * TILE + local.xy;
    let inside = all(pixel < adaptive.size);
    let p = vec2f(pixel + adaptive.overscan) + 0.5;
    let limit = 64e6 * adaptive.noise_limit * adaptive.noise_limit;
    // As many points again while the tile is noisy; loops that end at once, no branches: all
    // invocations meet at the barriers.
    var rays = 0u;
    for (var k = 0u; k < MOST_SETS; k++) {
        let end = min(rays + adaptive.points, adaptive.most_points);
        let noisy = k == 0u || atomicLoad(&is_bright) != 0u || f32(atomicLoad(&tile_error[max(k, 1u) - 1u])) > limit;
        let next = select(rays, end, noisy);
        cast_rays(p, index, rays, select(rays, next, inside));
        rays = next;
        atomicAdd(&tile_error[k], u32(1e6 * estimated_error()));
        workgroupBarrier();
    }
    let missed = f32(rays) - hit_count;
    if hit_count == 0.0 && inside {
        // Nothing but cracks: what the pinhole sees.
        let own = radii_at(p).x;
        let color = pinhole_color(p);
        add_to(bucket_of(own), vec4f(color, 1.0));
        hit_count = 1.0;
    }
    note_buckets();
    workgroupBarrier();
    if !inside {
        return;
    }
    store_sums(pixel, hit_count);
    if adaptive.diagnose != 0u {
        textureStore(counts, pixel, vec4f(f32(rays), f32(texels_read), layer_sum, missed));
    }
}

/// Half a texel of a mipmap level before the image's end, or the centre of its only texel, texels of level 0.
fn last_centre(size: vec2f, level: f32) -> vec2f {
    let half_texel = vec2f(0.5 * exp2(level));
    return max(size - half_texel, half_texel);
}

/// Colour of a hit from the mipmap level that fits between rays.
fn smooth_color_of(hit: Hit, p: vec2f, v: vec2f) -> vec3f {
    let k = f32(adaptive.fineness);
    let spacing = 0.35 * least_s(hit.s) * sqrt(adaptive.lens_variance * PI / f32(adaptive.points));
    let footprint = k * spacing;
    // Mipmaps are of the first layer's mean, and hold what is around the surface too.
    if footprint <= 1.0 || hit.layer != 0 {
        return color_of(hit, p, v, false);
    }
    // A box of `footprint` texels, read bilinearly.
    let read_blur = (footprint * footprint - 0.333) / (k * k);
    let at = color_place(0, p - shrunk_offset(v, hit.s, shrink(hit.s, read_blur)));
    let level = log2(footprint);
    let size = vec2f(textureDimensions(radii));
    // Beyond that texels of a level may hold nothing.
    let inside = clamp(at, vec2f(0.0), min(last_centre(size, floor(level)), last_centre(size, ceil(level))));
    return textureSampleLevel(colors, linear_clamp, inside / vec2f(textureDimensions(colors)), 0, level).rgb;
}

/// What a ray hits where all surfaces have about the s of its pixel, `own`.
fn meet(p: vec2f, v: vec2f, own: f32) -> Hit {
    // What lies in front by more than surfaces in one tile of this class do is in focus
    // and does not reach here.
    let nearest = own - 1.0 - 0.5 * abs(own);
    let from_p = ray_from(p, v);
    let at = place_on_ray(from_p, v, own);
    if is_fine(own) {
        let s = sample_s(sample_at(at));
        if s >= nearest {
            return Hit(SAMPLE, s, s);
        }
    }
    let there = radii_at(at);
    let k = first_within(there, nearest, 0.5 * EMPTY_S);
    let s = component(there, k);
    return Hit(select(k, NO_HIT, k < 0), s, s);
}

/// Radius of a disc, px, that reaches no farther than a pixel's neighbours.
const NEIGHBOUR_REACH_PX = 1.5;

/// What all rays together meet where the pixels of an image, squares, have about the CoC radius
/// `own` and a disc reaches no farther than the neighbours: the squares, each by its part of the disc.
fn mean_of_squares(p: vec2f, own: f32) -> vec3f {
    let r = max(abs(own) * adaptive.lens_radius, 1e-3);
    let inner = circle_before(r, vec2f(0.5));
    // By symmetry there are three parts: of the pixel itself, of one beside it, of one at its corner.
    let left = circle_before(r, vec2f(-0.5, 0.5));
    let corner = max(circle_before(r, vec2f(-0.5)), 0.0);
    let itself = inner - 2.0 * left + corner;
    let beside = max(left - corner, 0.0);
    // What lies in front of this is in focus: `meet`.
    let nearest = own - 1.0 - 0.5 * abs(own);
    var sum = vec4f(0.0);
    for (var i = 0u; i < 9u; i++) {
        let offset = vec2f(vec2u(i % 3u, i / 3u)) - 1.0;
        let sides = abs(offset.x) + abs(offset.y);
        let part = select(select(corner, beside, sides < 1.5), itself, sides < 0.5);
        let texel = sample_at(p + offset);
        let weight = select(0.0, part, sample_s(texel) >= nearest);
        sum += weight * vec4f(textureLoad(sample_colors, texel, 0).rgb, 1.0);
    }
    return select(pinhole_color(p), sum.rgb / max(sum.a, 1e-9), sum.a > 0.0);
}

/// What the rays of a pixel have met.
struct Met {
    hits: f32,
    /// Rays cast, texels read, sum of the layers, rays that hit nothing.
    counts: vec4f,
}

/// Gathers what the rays of a pixel meet where all surfaces have about the s of its own.
fn meet_all(p: vec2f, index: u32) -> Met {
    let own = radii_at(p).x;
    if IMAGE && adaptive.is_disc != 0u && abs(own) * adaptive.lens_radius <= NEIGHBOUR_REACH_PX {
        add_to(bucket_of(own), vec4f(mean_of_squares(p, own), 1.0));
        return Met(1.0, vec4f(1.0, 9.0, 0.0, 0.0));
    }
    var hits = 0.0;
    var layers_hit = 0.0;
    for (var i = 0u; i < adaptive.points; i++) {
        let v = lens_point(index, i);
        let hit = meet(p, v, own);
        if hit.layer >= 0 {
            add_to(bucket_of(hit.s), vec4f(smooth_color_of(hit, p, v), 1.0));
            hits += 1.0;
            layers_hit += layer_number(hit);
        }
    }
    let rays = f32(adaptive.points);
    let counts = vec4f(rays, 2.0 * rays, layers_hit, rays - hits);
    if hits == 0.0 {
        add_to(bucket_of(own), vec4f(pinhole_color(p), 1.0));
        return Met(1.0, counts);
    }
    return Met(hits, counts);
}

/// Surfaces of about one CoC, in front of which only what is in focus may lie: no march.
@compute @workgroup_size(8, 8)
fn trace_uniform(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let tile = listed_tile(group);
    if !is_tile(tile) {
        return;
    }
    let pixel = tile * TILE + local.xy;
    let inside = all(pixel < adaptive.size);
    var found = Met();
    if inside {
        found = meet_all(vec2f(pixel + adaptive.overscan) + 0.5, index);
        note_buckets();
    }
    workgroupBarrier();
    if !inside {
        return;
    }
    store_sums(pixel, found.hits);
    if adaptive.diagnose != 0u {
        textureStore(counts, pixel, found.counts);
    }
}
