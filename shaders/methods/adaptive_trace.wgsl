// adaptive, pass 3: each pixel's lens rays through peeled layers, gathered in buckets of s
// (src/methods/adaptive/mod.rs).

#import layers
#import lens_rays
#import lens_views
#import listed_tiles

/// `adaptive.points` lens points for each of the 8x8 pixels of a tile.
@group(0) @binding(1) var<storage, read> lens_points: array<vec2f>;
/// Premultiplied hits, one array layer a bucket.
@group(0) @binding(2) var new_buckets: texture_storage_2d_array<rgba16float, write>;
/// Rays, texels read, sum of the layers that were hit (0 the nearest), rays that hit nothing.
@group(0) @binding(3) var counts: texture_storage_2d<rgba16float, write>;

/// The layer that was hit, 0 the nearest.
fn layer_number(hit: Hit) -> f32 {
    return select(f32(hit.layer), 0.0, hit.layer == SAMPLE);
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
    if index == 0u && is_tile(tile) {
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
    var layers_hit = 0.0;
    for (var i = 0u; i < adaptive.points; i++) {
        let v = lens_points[index * adaptive.points + i];
        let nearby = serving_view(v);
        if nearby >= 0 {
            let seen = trace_in_view(p, v, nearby);
            reads += seen.reads;
            if seen.layer >= 0 {
                sums[bucket_of(seen.s)] += vec4f(color_in_view(seen, p, v, nearby, emitter_count > 0u), 1.0);
                hits += 1.0;
                reads += 1u;
                continue;
            }
        }
        let hit = trace(p, v);
        reads += hit.reads;
        if hit.layer >= 0 {
            sums[bucket_of(hit.s)] += vec4f(color_of(hit, p, v, emitter_count > 0u), 1.0);
            hits += 1.0;
            layers_hit += layer_number(hit);
            reads += 1u;
        }
    }
    let missed = f32(adaptive.points) - hits;
    if hits == 0.0 {
        // Nothing but cracks: what the pinhole sees.
        let own = radii_at(p).x;
        let color = pinhole_color(p);
        sums[bucket_of(own)] = vec4f(color, 1.0);
        hits = 1.0;
    }
    store_sums(pixel, hits);
    if adaptive.diagnose != 0u {
        textureStore(counts, pixel, vec4f(f32(adaptive.points), f32(reads), layers_hit, missed));
    }
}

/// Colour of a hit from the mipmap level that fits between rays.
fn smooth_color_of(hit: Hit, p: vec2f, v: vec2f) -> vec3f {
    let k = f32(adaptive.fineness);
    let spacing = 0.35 * abs(hit.s) * sqrt(adaptive.lens_variance * PI / f32(adaptive.points));
    let footprint = k * spacing;
    // Mipmaps are of the first layer's mean, and hold what is around the surface too.
    if footprint <= 1.0 || hit.layer != 0 || !surrounded(hit, spacing) {
        return color_of(hit, p, v, false);
    }
    // A box of `footprint` texels, read bilinearly.
    let read_blur = (footprint * footprint - 0.333) / (k * k);
    let at = color_place(0, p - v * (hit.s * shrink(hit.s, read_blur)));
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

/// What a ray hits where all surfaces have about the s of its pixel, `own`.
fn meet(p: vec2f, v: vec2f, own: f32) -> Hit {
    // What lies in front by more than surfaces in one tile of this class do is in focus
    // and does not reach here.
    let nearest = own - 1.0 - 0.5 * abs(own);
    let at = place_on_ray(p, v, own);
    if is_fine(own) {
        let s = sample_s(sample_at(at));
        if s >= nearest {
            return Hit(SAMPLE, s, p - v * s, 1u);
        }
    }
    let there = radii_at(at);
    let k = first_within(there, nearest, 0.5 * EMPTY_S);
    if k < 0 {
        return Hit(NO_HIT, 0.0, at, 1u);
    }
    return Hit(k, there[k], place_on_ray(p, v, there[k]), 1u);
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
    var layers_hit = 0.0;
    for (var i = 0u; i < adaptive.points; i++) {
        let v = lens_points[index * adaptive.points + i];
        let hit = meet(p, v, own);
        if hit.layer >= 0 {
            sums[bucket_of(hit.s)] += vec4f(smooth_color_of(hit, p, v), 1.0);
            hits += 1.0;
            layers_hit += layer_number(hit);
        }
    }
    let missed = f32(adaptive.points) - hits;
    if hits == 0.0 {
        sums[bucket_of(own)] = vec4f(pinhole_color(p), 1.0);
        hits = 1.0;
    }
    store_sums(pixel, hits);
    if adaptive.diagnose != 0u {
        let rays = f32(adaptive.points);
        textureStore(counts, pixel, vec4f(rays, 2.0 * rays, layers_hit, missed));
    }
}
