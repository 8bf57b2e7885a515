// adaptive, pass 4: what emitters bring to the pixels that their blur covers, each through
// one ray that asks whether the pixel sees it (src/methods/adaptive/highlights.rs).

#import emitters
#import layers
#import lens_rays
#import listed_tiles

@group(0) @binding(1) var<uniform> highlights: Highlights;
@group(0) @binding(2) var<storage, read> emitter_lists: array<u32>;
@group(0) @binding(3) var<storage, read> emitters: array<Emitter>;
/// Density of lens points over the square of v from -2 to 2 lens radii, with mipmaps.
@group(0) @binding(4) var aperture: texture_2d<f32>;
/// For each inner tile the length of its list.
@group(0) @binding(6) var<storage, read> listed_counts: array<u32>;
@group(0) @binding(5) var new_glow: texture_storage_2d<rgba16float, write>;

/// Density of any lens at `v`, averaged over the emitter.
fn aperture_density(emitter: Emitter, v: vec2f) -> f32 {
    // The emitter covers a square of the lens, and mipmaps hold means over such: one level
    // finer, as the bilinear read widens it to nearly the square's own variance.
    let texel_v = 4.0 * adaptive.lens_radius / f32(textureDimensions(aperture).x);
    let level = log2(side_of(emitter) / (abs(emitter.s) * texel_v)) - 1.0;
    let uv = 0.5 + 0.25 * v / adaptive.lens_radius;
    let density = textureSampleLevel(aperture, linear_clamp, uv, level).r;
    return select(0.0, density, all(uv >= vec2f(0.0)) && all(uv <= vec2f(1.0)));
}

/// How far, px of s, a surface lies in front of an emitter at least to hide it. Layers lie
/// farther apart than this (`LayerSeparation::of`), so that a layer hides what is behind it,
/// and an emitter's own surface, a rounding away, does not.
const IN_FRONT_S = 0.5;

/// Whether an emitter is one pixel of an image, all of it.
fn is_pixel(emitter: Emitter) -> bool {
    return adaptive.is_image != 0u && abs(side_of(emitter) - 1.0) < 1e-3;
}

/// What the tile's emitters bring to `p`, each through one ray.
fn glow(p: vec2f, tile: vec2u, count: u32) -> vec3f {
    let index = tile.y * adaptive.inner_tiles.x + tile.x;
    let listed_count = min(listed_counts[index], highlights.capacity);
    let start = index * highlights.capacity;
    var sum = vec3f(0.0);
    for (var i = 0u; i < listed_count; i++) {
        let emitter = emitters[emitter_lists[start + i]];
        var v = (p - emitter.at) / emitter.s;
        var density = 0.0;
        if highlights.is_disc != 0u && is_pixel(emitter) {
            density = disc_density_of_pixel(emitter.s, p - emitter.at, adaptive.lens_radius);
            // The centre of a pixel may lie beyond the lens when a part of it does not.
            v *= min(1.0, adaptive.lens_radius / max(length(v), 1e-6));
        } else if highlights.is_disc != 0u {
            density = disc_density(emitter, p - emitter.at, adaptive.lens_radius);
        } else {
            density = aperture_density(emitter, v);
        }
        if density <= 0.0 {
            continue;
        }
        let in_front_s = emitter.s - IN_FRONT_S;
        let hit = trace_up_to(p, v, in_front_s);
        if hit.layer >= 0 && hit.s < in_front_s {
            continue;
        }
        sum += emitter.excess * (density / (emitter.s * emitter.s));
    }
    // Those that are not listed count as the mean of those that are.
    return sum * (f32(count) / f32(max(listed_count, 1u)));
}

@compute @workgroup_size(8, 8)
fn add_glow(
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
    rays_are_filtered = false;
    let pixel = tile * TILE + local.xy;
    if emitter_count > 0u && all(pixel < adaptive.size) {
        let p = vec2f(pixel + adaptive.overscan) + 0.5;
        textureStore(new_glow, pixel, vec4f(glow(p, tile, emitter_count), 1.0));
    }
}
