// mipmap by discs: the pyramids (src/methods/mipmap/passes.rs; shaders/lib/mipmap_discs.wgsl
// says what they hold).
//
//   reduce_image    level 1
//   reduce_level    any other
//   reduce_levels   two others, the second from the first by way of workgroup memory
//   filter_levels   all levels through the two discs, into one image
//
// Level l texel p covers texels 2p and 2p + 1 of level l - 1 and is made by the kernel
// [1 3 3 1] x [1 3 3 1] / 64: four bilinear reads.

#import mipmap_discs
#import mipmap_atlas
#import sampling

@group(0) @binding(2) var color: texture_2d<f32>;
@group(0) @binding(3) var depth: texture_2d<f32>;
/// The level below.
@group(0) @binding(4) var finer: texture_2d_array<f32>;
@group(0) @binding(5) var coarser: texture_storage_2d_array<COLOR_FORMAT, write>;
@group(0) @binding(6) var coarsest: texture_storage_2d_array<COLOR_FORMAT, write>;
@group(0) @binding(7) var linear_clamp: sampler;
/// All levels.
@group(0) @binding(8) var pyramid: texture_2d_array<f32>;
@group(0) @binding(9) var atlas: texture_storage_2d_array<COLOR_FORMAT, write>;

struct Reduction {
    /// The paper's level that is made, the first of two.
    level: u32,
}

@group(0) @binding(10) var<uniform> reduction: Reduction;

struct Texel {
    behind: vec4f,
    before: vec4f,
    all: vec4f,
    /// Of `behind` and of `before`.
    coc: vec2f,
}

fn no_texel() -> Texel {
    return Texel(vec4f(0.0), vec4f(0.0), vec4f(0.0), vec2f(0.0));
}

/// The sum with w times a texel.
fn plus(sum: Texel, w: f32, t: Texel) -> Texel {
    return Texel(sum.behind + w * t.behind, sum.before + w * t.before, sum.all + w * t.all, sum.coc + w * t.coc);
}

/// What of a texel that was reduced to level l has a part in that level.
fn settled(t: Texel, l: u32) -> Texel {
    // Means over what is there; 0 of nothing.
    let coc = t.coc / max(vec2f(t.behind.a, t.before.a), vec2f(1e-20));
    let behind = part(variance_of_coc(coc.x), narrow_disc(l));
    let before = handed_on(variance_of_coc(coc.y), l - 1u);
    return Texel(behind * t.behind, before * t.before, t.all, vec2f(behind, before) * t.coc);
}

// ---- level 1 ----

/// Pixels along a side that 8x8 texels are made of.
const SPAN = 18u;

/// Colour and signed CoC, px, of pixels; their part in level 1.
var<workgroup> pixels: array<vec4f, 324>;
var<workgroup> parts: array<f32, 324>;

@compute @workgroup_size(8, 8)
fn reduce_image(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let first = 16 * vec2i(group.xy) - 1 - params.padding;
    for (var i = index; i < SPAN * SPAN; i += 64u) {
        let p = clamp_to_image(first + vec2i(vec2u(i % SPAN, i / SPAN)), textureDimensions(depth));
        let c = coc_of(textureLoad(depth, p, 0).r);
        let variance = variance_of_coc(c);
        pixels[i] = vec4f(textureLoad(color, p, 0).rgb, c);
        parts[i] = select(part(variance, narrow_disc(1u)), handed_on(variance, 0u), c < 0.0);
    }
    workgroupBarrier();
    var sum = no_texel();
    for (var i = 0u; i < 16u; i++) {
        let at = (2u * local.y + i / 4u) * SPAN + 2u * local.x + i % 4u;
        let pixel = pixels[at];
        let w = KERNEL[i % 4u] * KERNEL[i / 4u];
        let before = pixel.w < 0.0;
        let weights = w * select(vec2f(parts[at], 0.0), vec2f(0.0, parts[at]), before);
        sum.behind += weights.x * vec4f(pixel.rgb, 1.0);
        sum.before += weights.y * vec4f(pixel.rgb, 1.0);
        sum.all += w * vec4f(pixel.rgb, select(0.0, 1.0, before));
        sum.coc += weights * abs(pixel.w);
    }
    let at = 8u * group.xy + local.xy;
    textureStore(coarser, at, BEHIND, sum.behind);
    textureStore(coarser, at, BEFORE, sum.before);
    textureStore(coarser, at, ALL, sum.all);
    textureStore(coarser, at, COC, vec4f(sum.coc, 0.0, 0.0));
}

// ---- other levels ----

/// The texel of the level above `finer`.
fn reduced(at: vec2i) -> Texel {
    var sum = no_texel();
    let size = vec2f(textureDimensions(finer));
    for (var i = 0u; i < 4u; i++) {
        let offset = select(vec2f(0.25), vec2f(1.75), vec2<bool>((i & 1u) != 0u, (i & 2u) != 0u));
        let uv = (2.0 * vec2f(at) + offset) / size;
        let texel = Texel(
            textureSampleLevel(finer, linear_clamp, uv, BEHIND, 0.0),
            textureSampleLevel(finer, linear_clamp, uv, BEFORE, 0.0),
            textureSampleLevel(finer, linear_clamp, uv, ALL, 0.0),
            textureSampleLevel(finer, linear_clamp, uv, COC, 0.0).xy,
        );
        sum = plus(sum, 0.25, texel);
    }
    return sum;
}

fn store_coarser(at: vec2u, t: Texel) {
    textureStore(coarser, at, BEHIND, t.behind);
    textureStore(coarser, at, BEFORE, t.before);
    textureStore(coarser, at, ALL, t.all);
    textureStore(coarser, at, COC, vec4f(t.coc, 0.0, 0.0));
}

@compute @workgroup_size(8, 8)
fn reduce_level(@builtin(global_invocation_id) id: vec3u) {
    store_coarser(id.xy, settled(reduced(vec2i(id.xy)), reduction.level));
}

/// Texels along a side of the first level that 4x4 of the second are made of.
const FIRST = 10u;

var<workgroup> first_level: array<Texel, 100>;

@compute @workgroup_size(8, 8)
fn reduce_levels(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) index: u32) {
    let corner = 8 * vec2i(group.xy) - 1;
    let size = textureDimensions(coarser);
    for (var i = index; i < FIRST * FIRST; i += 64u) {
        let in_tile = vec2i(vec2u(i % FIRST, i / FIRST));
        let at = clamp_to_image(corner + in_tile, size);
        let texel = settled(reduced(at), reduction.level);
        first_level[i] = texel;
        if all(in_tile > vec2i(0)) && all(in_tile <= vec2i(8)) {
            store_coarser(vec2u(corner + in_tile), texel);
        }
    }
    workgroupBarrier();
    if index >= 16u {
        return;
    }
    let local = vec2u(index % 4u, index / 4u);
    var sum = no_texel();
    for (var i = 0u; i < 16u; i++) {
        let at = (2u * local.y + i / 4u) * FIRST + 2u * local.x + i % 4u;
        sum = plus(sum, KERNEL[i % 4u] * KERNEL[i / 4u], first_level[at]);
    }
    let t = settled(sum, reduction.level + 1u);
    let at = 4u * group.xy + local;
    textureStore(coarsest, at, BEHIND, t.behind);
    textureStore(coarsest, at, BEFORE, t.before);
    textureStore(coarsest, at, ALL, t.all);
    textureStore(coarsest, at, COC, vec4f(t.coc, 0.0, 0.0));
}

// ---- filtered levels ----

/// Texels along a side that the discs around 8x8 reach.
const TILE = 12u;

/// Tiles of four kinds, one after another: what is behind; what in front ends on the level,
/// in its narrow and in its wide disc; the rest.
var<workgroup> tiles: array<vec4f, 576>;
const KIND = 144u;
/// Which of them hold anything.
var<workgroup> kinds: atomic<u32>;
const HAS_BEHIND = 1u;
const HAS_ENDING = 2u;
const HAS_REST = 4u;

/// Sums over the neighbours of a texel that have the same share in a disc: itself, then as in
/// `Params.discs`.
struct Rings {
    itself: vec4f,
    edge: vec4f,
    corner: vec4f,
}

struct OuterRings {
    edge: vec4f,
    knight: vec4f,
    corner: vec4f,
}

fn rings(t: u32) -> Rings {
    let corner = tiles[t - TILE - 1u] + tiles[t - TILE + 1u] + tiles[t + TILE - 1u] + tiles[t + TILE + 1u];
    return Rings(tiles[t], tiles[t - TILE] + tiles[t - 1u] + tiles[t + 1u] + tiles[t + TILE], corner);
}

fn outer_rings(t: u32) -> OuterRings {
    let up = t - 2u * TILE;
    let down = t + 2u * TILE;
    let knight = tiles[up - 1u] + tiles[up + 1u] + tiles[down - 1u] + tiles[down + 1u]
        + tiles[t - TILE - 2u] + tiles[t - TILE + 2u] + tiles[t + TILE - 2u] + tiles[t + TILE + 2u];
    let corner = tiles[up - 2u] + tiles[up + 2u] + tiles[down - 2u] + tiles[down + 2u];
    return OuterRings(tiles[up] + tiles[t - 2u] + tiles[t + 2u] + tiles[down], knight, corner);
}

fn through_narrow(r: Rings) -> vec4f {
    return params.discs[0].y * r.itself + params.discs[1].y * r.edge + params.discs[2].y * r.corner;
}

fn through_wide(r: Rings, o: OuterRings) -> vec4f {
    return params.discs[0].z * r.itself + params.discs[1].z * r.edge + params.discs[2].z * r.corner
        + params.discs[3].z * o.edge + params.discs[4].z * o.knight + params.discs[5].z * o.corner;
}

/// A workgroup for each 8x8 texels of each level, one level after another.
@compute @workgroup_size(8, 8)
fn filter_levels(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    var level = 1u;
    var place = group.x + group.y * MAX_GROUPS;
    var groups = (level_size(level) + 7u) / 8u;
    while level < params.levels && place >= groups.x * groups.y {
        place -= groups.x * groups.y;
        level += 1u;
        groups = (level_size(level) + 7u) / 8u;
    }
    let corner = 8 * vec2i(vec2u(place % groups.x, place / groups.x));
    let size = level_size(level);
    // Around what pixels of the image without overscan read by bilinear filters nothing is read.
    let overscan = vec2i(i32(params.overscan));
    let first_read = ((params.padding + overscan) >> vec2u(level)) - 1;
    let last_read = ((2 * vec2i(params.level_1) - params.padding - overscan) >> vec2u(level)) + 1;
    if any(corner > last_read) || any(corner + 7 < first_read) {
        return;
    }
    let reads_rest = params.foreground != 0u || params.anisotropic == 0u;
    var found = 0u;
    for (var i = index; i < TILE * TILE; i += 64u) {
        let at = clamp_to_image(corner + vec2i(vec2u(i % TILE, i / TILE)) - 2, size);
        if params.background != 0u {
            let behind = textureLoad(pyramid, at, BEHIND, level - 1u);
            tiles[i] = behind;
            found |= select(0u, HAS_BEHIND, any(behind != vec4f(0.0)));
        }
        if reads_rest {
            let everything = textureLoad(pyramid, at, ALL, level - 1u);
            var own = vec4f(0.0);
            var coc = 0.0;
            // What is in front has a part in ALL, too.
            if everything.a > 0.0 {
                own = textureLoad(pyramid, at, BEFORE, level - 1u);
                coc = textureLoad(pyramid, at, COC, level - 1u).y / max(own.a, 1e-20);
            }
            let variance = variance_of_coc(coc);
            let wider = clamp((variance - narrow_disc(level)) / (widest(level) - narrow_disc(level)), 0.0, 1.0);
            let has_ending = level < params.front_level;
            let presence = select(vec4f(0.0), vec4f(0.0, 0.0, 0.0, everything.a), level == params.front_level);
            let in_narrow = select(presence, (1.0 - wider) * own, has_ending);
            let in_wide = select(vec4f(0.0), (wider - handed_on(variance, level)) * own, has_ending);
            tiles[KIND + i] = in_narrow;
            tiles[2u * KIND + i] = in_wide;
            tiles[3u * KIND + i] = max(vec4f(everything.rgb, 1.0) - own, vec4f(0.0));
            found |= select(0u, HAS_ENDING, any(in_narrow != vec4f(0.0)) || any(in_wide != vec4f(0.0)));
            // Only what is in front looks behind itself. On coarser levels a single pixel's share is
            // less than a number can hold.
            found |= select(0u, HAS_REST, everything.a > 0.0 || level > 6u || params.anisotropic == 0u);
        }
    }
    if found != 0u {
        atomicOr(&kinds, found);
    }
    workgroupBarrier();
    found = atomicLoad(&kinds);
    var narrow = vec4f(0.0);
    var wide = vec4f(0.0);
    var ending = vec4f(0.0);
    var remaining = vec4f(0.0);
    let centre = (local.y + 2u) * TILE + local.x + 2u;
    if (found & HAS_BEHIND) != 0u {
        let r = rings(centre);
        narrow = through_narrow(r);
        wide = through_wide(r, outer_rings(centre));
    }
    if (found & HAS_ENDING) != 0u {
        let w = centre + 2u * KIND;
        ending = through_narrow(rings(centre + KIND)) + through_wide(rings(w), outer_rings(w));
    }
    if (found & HAS_REST) != 0u {
        remaining = through_narrow(rings(centre + 3u * KIND));
    }
    let texel = vec2u(corner) + local.xy;
    if place < groups.x * groups.y && all(texel < size) {
        let at = level_origin(level) + texel;
        textureStore(atlas, at, NARROW, narrow);
        textureStore(atlas, at, WIDE, wide);
        textureStore(atlas, at, SPREAD, ending);
        textureStore(atlas, at, REST, remaining);
    }
}
