// mipmap by discs: what pixels read (src/methods/mipmap/passes.rs; what the pyramids hold is
// told in shaders/lib/mipmap_discs.wgsl).
//
//   blur      the picture
//   explain   the same, to look at: how each pixel and each tile got its colour
//
// A pixel sees through what lies in front of it and is more blurred than itself, which is
// spread over it by its own blur, and sees the rest through its own:
//
//   spread + (1 - alpha of spread) * own
//
// Behind the focus distance `own` is made of what lies behind it only, and of nothing that is
// much sharper (equation 9); in front, of everything, as the paper has it.

#import mipmap_discs
#import mipmap_atlas
#import sampling

@group(0) @binding(2) var color: texture_2d<f32>;
@group(0) @binding(3) var depth: texture_2d<f32>;
@group(0) @binding(4) var atlas: texture_2d_array<f32>;
@group(0) @binding(5) var linear_clamp: sampler;
@group(0) @binding(6) var result: texture_storage_2d<COLOR_FORMAT, write>;
@group(0) @binding(7) var explained: texture_storage_2d<rgba16float, write>;
@group(0) @binding(8) var tile_classes: texture_storage_2d<r32float, write>;

/// Side of a tile, px, and of what the discs on the image reach around it.
const SIDE = 8u;
const AROUND = 12u;

// ---- levels ----

/// A level, at the position `at`, px.
fn read_level(at: vec2f, l: u32, layer: i32) -> vec4f {
    let level = min(l, params.levels);
    let size = vec2f(level_size(level));
    let texel = (at + vec2f(params.padding)) * exp2(-f32(level));
    let inside = clamp(texel, vec2f(0.5), size - 0.5) + vec2f(level_origin(level));
    return textureSampleLevel(atlas, linear_clamp, inside / vec2f(textureDimensions(atlas)), layer, 0.0);
}

/// The paper's level, continuous, whose narrow disc has the given variance, px^2.
fn level_of_variance(wanted: f32) -> f32 {
    return 0.5 * log2((wanted + 0.25) / (0.25 + BILINEAR_VARIANCE + params.disc_variance.y));
}

/// The colour of a read whose alpha is its weight; `fallback` where there is none.
fn color_of(read: vec4f, fallback: vec3f) -> vec3f {
    return select(fallback, read.rgb / max(read.a, 1e-20), read.a > 1e-6);
}

/// What lies behind the focus distance, at `at`, through a disc of the given variance, at
/// least that of the first node: the two nearest discs blended, of diameters 1 : sqrt(2).
fn behind_through(at: vec2f, wanted: f32, sharp: vec3f) -> vec3f {
    let level = u32(max(1.0, floor(level_of_variance(wanted))));
    let narrow = node(level);
    let wide = disc_variance(f32(level), 2u);
    let wider = wanted >= wide;
    let low = select(narrow, wide, wider);
    let high = select(wide, node(level + 1u), wider);
    let fine = read_level(at, level, select(NARROW, WIDE, wider));
    let coarse = read_level(at, level + u32(wider), select(WIDE, NARROW, wider));
    let beta = clamp((wanted - low) / (high - low), 0.0, 1.0);
    let fine_color = color_of(fine, sharp);
    return blend_levels(fine_color, color_of(coarse, fine_color), beta);
}

/// The same of everything, by discs of diameters 1 : 2.
fn everything_through(at: vec2f, wanted: f32) -> vec3f {
    let level = u32(max(1.0, floor(level_of_variance(wanted))));
    let fine = read_level(at, level, EVERYTHING).rgb;
    let coarse = read_level(at, level + 1u, EVERYTHING).rgb;
    return blend_levels(fine, coarse, handed_on(wanted, level));
}

// ---- pixels ----

/// Shares of a pixel's light, by the variance of its blur, in the three discs around it and
/// in itself; what is left is in the levels.
struct Shares {
    discs: vec3f,
    itself: f32,
}

fn shares(variance: f32) -> Shares {
    let v = params.disc_variance;
    let beyond = clamp((vec3f(variance) - vec3f(0.0, v.xy)) / (v.xyz - vec3f(0.0, v.xy)), vec3f(0.0), vec3f(1.0));
    let on = handed_on(variance, 0u);
    return Shares(beyond - vec3f(beyond.yz, on), 1.0 - beyond.x);
}

/// The part of it that a neighbour gets.
fn share_of(s: Shares, weights: vec3f, itself: bool) -> f32 {
    return dot(s.discs, weights) + select(0.0, s.itself, itself);
}

/// How far something in front of the focus distance counts as lying before a pixel: it does
/// if it is twice as blurred, and does not if it is less blurred. Signed CoCs, px.
fn is_before(c: f32, pixel: f32) -> f32 {
    return select(clamp(c / pixel - 1.0, 0.0, 1.0), 1.0, pixel >= 0.0);
}

/// The same for what ends on level l, all of it blurred at least by the node before it.
fn is_level_before(l: u32, variance: f32) -> f32 {
    return clamp(sqrt(node(l - 1u) / max(variance, 1e-12)) - 1.0, 0.0, 1.0);
}

struct Seen {
    color: vec3f,
    coc: f32,
    /// Share of what is spread over it from in front.
    covered: f32,
    /// The paper's level of its own blur, at least 0.
    level: f32,
    /// The same for the whole tile.
    class_of: u32,
}

/// Classes of tiles: TILE_CLASSES in src/methods/mipmap/passes.rs.
const IN_FOCUS = 0u;
const NEAR = 1u;
const FAR = 2u;

/// Signed CoC and its variance of the pixels of a tile and around it.
var<workgroup> cocs: array<vec2f, 144>;
var<workgroup> colors: array<vec4f, 144>;
/// Whether a pixel of the tile is blurred; whether a disc on the image reaches or makes one.
var<workgroup> blurred: atomic<u32>;
var<workgroup> drawn: atomic<u32>;

fn see(group: vec3u, local: vec3u, index: u32) -> Seen {
    let corner = vec2i(SIDE * group.xy + params.overscan) - 2;
    let size = textureDimensions(depth);
    for (var i = index; i < AROUND * AROUND; i += 64u) {
        let in_tile = vec2i(vec2u(i % AROUND, i / AROUND));
        let c = coc_of(textureLoad(depth, clamp_to_image(corner + in_tile, size), 0).r);
        let variance = variance_of_coc(c);
        cocs[i] = vec2f(c, variance);
        let own = all(in_tile >= vec2i(2)) && all(in_tile < vec2i(2 + i32(SIDE)));
        if own && c != 0.0 {
            atomicOr(&blurred, 1u);
        }
        if c != 0.0 && variance < node(1u) && (own || (c < 0.0 && params.smoothing != 0u)) {
            atomicOr(&drawn, 1u);
        }
    }
    workgroupBarrier();
    let is_drawn = atomicLoad(&drawn) != 0u;
    let is_blurred = atomicLoad(&blurred) != 0u;
    for (var i = index; i < select(0u, AROUND * AROUND, is_drawn); i += 64u) {
        let p = clamp_to_image(corner + vec2i(vec2u(i % AROUND, i / AROUND)), size);
        colors[i] = vec4f(textureLoad(color, p, 0).rgb, 1.0);
    }
    workgroupBarrier();

    let pixel = SIDE * group.xy + local.xy;
    let at = vec2f(pixel + params.overscan) + 0.5;
    let centre = (local.y + 2u) * AROUND + local.x + 2u;
    let own_coc = cocs[centre];
    let sharp = textureLoad(color, clamp_to_image(vec2i(at), size), 0).rgb;
    let in_background = own_coc.x >= 0.0 && params.anisotropic != 0u;

    // Discs on the image.
    let own_shares = shares(own_coc.y);
    var sum = vec4f(0.0);
    var spread = vec4f(0.0);
    for (var i = 0u; i < select(0u, NEIGHBOURS, is_drawn); i++) {
        let weights = disc_weights(i);
        let itself = i == NEIGHBOURS / 2u;
        let q = centre + (i / 5u) * AROUND + i % 5u - 2u * AROUND - 2u;
        let c = cocs[q];
        var taken = share_of(own_shares, weights, itself);
        if in_background && !itself {
            taken *= select(part(c.y, max(own_coc.y, 1e-12)), 0.0, c.x < 0.0);
        }
        sum += taken * colors[q];
        if c.x < 0.0 && params.smoothing != 0u {
            spread += share_of(shares(c.y), weights, itself) * is_before(c.x, own_coc.x) * colors[q];
        }
    }
    var own = color_of(sum, sharp);

    // Levels.
    let on = handed_on(own_coc.y, 0u);
    if on > 0.0 {
        let wanted = max(own_coc.y, node(1u));
        var coarse = vec3f(0.0);
        if in_background {
            coarse = behind_through(at, wanted, sharp);
        } else {
            coarse = everything_through(at, wanted);
        }
        own = blend_levels(own, coarse, on);
    }
    // The coarsest level tells whether anything in front is near by: its texels are wider than
    // what ends on any level reaches.
    let reached = params.smoothing != 0u && read_level(at, params.levels, EVERYTHING).a > 0.0;
    for (var l = 1u; l < select(0u, params.levels, reached); l++) {
        let before = select(is_level_before(l, own_coc.y), 1.0, own_coc.x >= 0.0);
        spread += before * read_level(at, l, SPREAD);
    }

    let covered = min(spread.a, 1.0);
    let seen = spread.rgb / max(spread.a, 1.0) + (1.0 - covered) * own;
    let class_of = select(select(IN_FOCUS, FAR, is_blurred), NEAR, is_drawn);
    return Seen(seen, own_coc.x, covered, max(level_of_variance(own_coc.y), 0.0), class_of);
}

fn put(pixel: vec2u, c: vec3f) {
    textureStore(result, pixel, vec4f(c, 1.0));
}

@compute @workgroup_size(8, 8)
fn blur(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    put(SIDE * group.xy + local.xy, see(group, local, index).color);
}

@compute @workgroup_size(8, 8)
fn explain(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let seen = see(group, local, index);
    let level = min(seen.level, f32(params.levels));
    textureStore(explained, SIDE * group.xy + local.xy, vec4f(seen.coc, dob(seen.coc), seen.covered, level));
    if index == 0u {
        textureStore(tile_classes, group.xy, vec4f(f32(seen.class_of), 0.0, 0.0, 0.0));
    }
}
