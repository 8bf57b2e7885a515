// adaptive, pass 4: what emitters bring to the pixels that their blur covers, each through
// one ray that asks whether the pixel sees it (src/methods/adaptive/highlights.rs).

#import emitters
#import layers
#import lens_rays
#import listed_tiles
#import sheet_rays
#import spots

@group(0) @binding(1) var<uniform> highlights: Highlights;
@group(0) @binding(2) var<storage, read> emitter_lists: array<u32>;
@group(0) @binding(3) var<storage, read> emitters: array<Emitter>;
/// Share of the lens's light that passes below and to the left, at the corners of a grid over the
/// square of v from -1 to 1 lens radii; of an astigmatic eye the running sums of lib/spots.wgsl.
@group(0) @binding(4) var aperture: texture_2d<f32>;
/// For each inner tile the length of its list.
@group(0) @binding(6) var<storage, read> listed_counts: array<u32>;
@group(0) @binding(5) var new_glow: texture_storage_2d<rgba16float, write>;

/// Share of the lens's light through lens points below and to the left of `at`, texels of the
/// table: as exact as its densities are even within a texel.
fn light_before(at: vec2f) -> f32 {
    let last = vec2i(textureDimensions(aperture)) - 1;
    let clamped = clamp(at, vec2f(0.0), vec2f(last));
    let low = min(vec2i(clamped), last - 1);
    let share = clamped - vec2f(low);
    let left = mix(textureLoad(aperture, low, 0).r, textureLoad(aperture, low + vec2i(0, 1), 0).r, share.y);
    let right = mix(textureLoad(aperture, low + vec2i(1, 0), 0).r, textureLoad(aperture, low + 1, 0).r, share.y);
    return mix(left, right, share.x);
}

/// Density of any lens seen from `offset` px beside the emitter, averaged over its square: over
/// all pixels that adds up to all of the emitter's light, however small the blur. The square is
/// a texel of the table wide at least, as differences of its sums are rounded.
fn aperture_density(emitter: Emitter, offset: vec2f) -> f32 {
    let texel_v = 2.0 * adaptive.lens_radius / f32(textureDimensions(aperture).x - 1u);
    let side = max(side_of(emitter) / (abs(emitter.s) * texel_v), 1.0);
    let low = (offset / emitter.s + adaptive.lens_radius) / texel_v - 0.5 * side;
    let high = low + side;
    let light = light_before(high) - light_before(vec2f(low.x, high.y)) - light_before(vec2f(high.x, low.y))
        + light_before(low);
    // What is left of a difference of equal sums is rounding.
    return select(0.0, light, light > 1e-6) / (side * side * texel_v * texel_v);
}

/// What an emitter brings to a pixel: the share of its light for each px^2, times s^2 where the blur
/// is round, and the lens point through which the pixel sees it.
struct Seen {
    density: f32,
    v: vec2f,
}

/// Of an astigmatic eye: the emitter's square is known, and where a meridian is in focus that
/// square is all that its blur is wide. The lens point is then the likeliest, in the least squares
/// sense, of those that may see a part of the square.
fn seen_in_ellipse(emitter: Emitter, offset: vec2f) -> Seen {
    let cells = textureDimensions(aperture).x;
    let sprites = Sprites(vec2u(0u), adaptive.lens_radius, cells, 0u, 0.0, 0.0);
    let side = side_of(emitter);
    let share = share_of_ellipse(aperture, sprites, adaptive.lens, 2.0 * emitter.s, Square(offset, side));
    let axes = half_axes(emitter.s);
    // Variances: of the square side^2 / 12, of lens points lens_radius^2 / 4 on each axis.
    let spread = side * side / (3.0 * adaptive.lens_radius * adaptive.lens_radius);
    let v = by_meridian(adaptive.lens, offset) * axes / (axes * axes + spread);
    return Seen(share / (side * side), from_meridian(adaptive.lens, v));
}

/// How far, px of s, a surface lies in front of an emitter at least to hide it. Layers lie
/// farther apart than this (`LayerSeparation::of`), so that a layer hides what is behind it,
/// and an emitter's own surface, a rounding away, does not.
const IN_FRONT_S = 0.5;

/// What the tile's emitters bring to `p`, each through one ray.
fn glow(p: vec2f, tile: vec2u, count: u32) -> vec3f {
    let index = tile.y * adaptive.inner_tiles.x + tile.x;
    let listed_count = min(listed_counts[index], highlights.capacity);
    let start = index * highlights.capacity;
    // The pixels of an image, and cells of them.
    let is_square = IMAGE;
    let is_astigmatic = ASTIGMATIC;
    let sheets = sheet_bounds_of(index);
    var sum = vec3f(0.0);
    for (var i = 0u; i < listed_count; i++) {
        let emitter = emitters[emitter_lists[start + i]];
        var v = (p - emitter.at) / emitter.s;
        var density = 0.0;
        var size = emitter.s * emitter.s;
        if highlights.is_disc != 0u && is_square {
            density = disc_density_of_square(emitter, p - emitter.at, adaptive.lens_radius);
        } else if highlights.is_disc != 0u {
            density = disc_density(emitter, p - emitter.at, adaptive.lens_radius);
        } else {
            density = aperture_density(emitter, p - emitter.at);
        }
        // A loop that ends at once, no branch: software adapters run both sides of those.
        for (var k = 0u; k < select(0u, 1u, is_astigmatic); k++) {
            let seen = seen_in_ellipse(emitter, p - emitter.at);
            density = seen.density;
            v = seen.v;
            size = 1.0;
        }
        if density <= 0.0 {
            continue;
        }
        if is_square || is_astigmatic {
            // The centre of a square may lie beyond the lens when a part of it does not.
            v *= min(1.0, adaptive.lens_radius / max(length(v), 1e-6));
        }
        let in_front_s = emitter.s - IN_FRONT_S;
        let hit = trace_up_to(p, v, in_front_s);
        if hit.layer >= 0 && hit.s < in_front_s {
            continue;
        }
        var left = 1.0;
        if SHEETS {
            left = left_by_sheets(ray_from(p, v), v, sheets, adaptive.lens, in_front_s);
        }
        sum += emitter.excess * (left * density / size);
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
    if !is_tile(tile) {
        return;
    }
    let found = tile_at(tile);
    if found.emitters == 0u {
        return;
    }
    if index == 0u {
        find_runs(vec2u(found.low, found.high));
    }
    find_nearest(tile, index);
    workgroupBarrier();
    rays_are_filtered = false;
    let pixel = tile * TILE + local.xy;
    if all(pixel < adaptive.size) {
        let p = vec2f(pixel + adaptive.overscan) + 0.5;
        textureStore(new_glow, pixel, vec4f(glow(p, tile, found.emitters), 1.0));
    }
}
