// mipmap by discs: what pixels read (src/methods/mipmap/passes.rs; what the pyramids hold is
// told in shaders/lib/mipmap_discs.wgsl).
//
//   blur      the picture
//   explain   the same, to look at: how each pixel and each tile got its colour
//
// Over each pixel is spread what lies in front of the focus distance, by its own blur, and
// what of that leaves open shows what is behind it:
//
//   spread + (1 - alpha of spread) * own
//
// Of a pixel behind the focus distance `own` is made, through its blur, of what lies behind it
// as well and is not much sharper (equation 9). Of one in front it is what is known of things
// behind it near by, since the image does not have what it hides.

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
/// least that of the first: the two nearest discs blended, of diameters 1 : sqrt(2). With
/// isotropic weights all that is not in front, by discs of diameters 1 : 2.
fn behind_through(at: vec2f, wanted: f32, sharp: vec3f) -> vec3f {
    let level = u32(max(1.0, floor(level_of_variance(wanted))));
    let isotropic = params.anisotropic == 0u;
    let wider = !isotropic && wanted >= widest(level);
    let low = select(narrow_disc(level), widest(level), wider);
    let next = isotropic || wider;
    let high = select(widest(level), narrow_disc(level + 1u), next);
    let fine = read_level(at, level, select(select(NARROW, WIDE, wider), REST, isotropic));
    let coarse = read_level(at, level + u32(next), select(select(WIDE, NARROW, wider), REST, isotropic));
    let beta = clamp((wanted - low) / (high - low), 0.0, 1.0);
    let fine_color = color_of(fine, sharp);
    return blend_levels(fine_color, color_of(coarse, fine_color), beta);
}

// ---- pixels ----

/// Shares of a pixel's light, by the variance of its blur, in the three discs around it and
/// in itself; what is left is in the levels.
fn shares(variance: f32) -> vec4f {
    let v = params.disc_variance;
    let beyond = clamp((vec3f(variance) - vec3f(0.0, v.xy)) / (v.xyz - vec3f(0.0, v.xy)), vec3f(0.0), vec3f(1.0));
    let on = handed_on(variance, 0u);
    return vec4f(beyond - vec3f(beyond.yz, on), 1.0 - beyond.x);
}

/// Adds to what is seen behind something in front what a coarser read has of it, as far as
/// finer ones have left it open: half of a read is enough to go by. Alpha is how far it is
/// known.
fn finest(known: vec4f, read: vec4f) -> vec4f {
    let share = (1.0 - known.a) * min(2.0 * read.a, 1.0);
    return known + share * vec4f(color_of(read, vec3f(0.0)), 1.0);
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

/// Of the pixels of a tile and around it colour and signed CoC, px; and their shares in the discs.
var<workgroup> pixels: array<vec4f, 144>;
var<workgroup> shares_out: array<vec3f, 144>;
/// What holds for any pixel of the tile, or any that may reach it.
var<workgroup> flags: atomic<u32>;
/// A pixel of the tile is blurred.
const BLURRED = 1u;
/// One is, by a disc on the image.
const DRAWN = 2u;
/// One in front of the focus distance is, in the tile or around it.
const SPREADING = 4u;
/// The widest of the discs is among those: the others do not reach farther than next to a pixel.
const FAR_REACHING = 8u;

/// What the discs on the image give a pixel: through its own blur, and from in front by theirs.
struct Drawn {
    sum: vec4f,
    spread: vec4f,
}

/// A pixel, and what of its tile is drawn at all.
struct Receiver {
    /// 2 over its signed CoC, 1/px.
    two_per_coc: f32,
    /// (reach^2 / 3) over the variance of its blur: `part` of another's variance grows by that.
    part_per_variance: f32,
    in_front: bool,
    takes: bool,
    is_spread_over: bool,
}

/// With the neighbour in slot q: `own` is its share in the pixel's discs, `disc` that of a
/// neighbour there in each disc, and `itself` is 1 for the pixel.
fn with_neighbour(drawn: Drawn, to: Receiver, q: i32, own: f32, disc: vec3f, itself: f32) -> Drawn {
    let pixel = pixels[q];
    let c = pixel.w;
    let light = vec4f(pixel.rgb, 1.0);
    let is_behind = c >= 0.0;
    // How far it counts as the surface of a pixel in front of the focus distance, or as lying
    // before it: as soon as it is as blurred, and not at all if half as blurred.
    let before_own = select(clamp(c * to.two_per_coc - 1.0, 0.0, 1.0), 0.0, is_behind);
    var result = drawn;
    if to.takes {
        let others = clamp(to.part_per_variance * variance_of_coc(c) - 1.0 / 3.0, 0.0, 1.0);
        let of_behind = select(0.0, select(1.0, others, params.anisotropic != 0u), is_behind);
        let taken = select(select(of_behind, 1.0, itself > 0.0), 1.0 - before_own, to.in_front);
        result.sum += own * taken * light;
    }
    if to.is_spread_over {
        let out = shares_out[q];
        // What is in no disc is in the pixel itself, but for what the levels have.
        let variance = variance_of_coc(c);
        let in_itself = itself * (1.0 - clamp(variance / params.disc_variance.x, 0.0, 1.0));
        let before = select(select(1.0, 0.0, is_behind), before_own, to.in_front);
        result.spread += (dot(out, disc) + in_itself) * before * light;
    }
    return result;
}

/// What the discs around the pixels near `centre`, a slot, give it; `reaches_far`: in 5x5 of them.
fn draw(to: Receiver, own_shares: vec4f, centre: u32, reaches_far: bool) -> Drawn {
    let middle = params.discs[0].xyz;
    let edge = params.discs[1].xyz;
    let corner = params.discs[2].xyz;
    let far_edge = params.discs[3].xyz;
    let knight = params.discs[4].xyz;
    let far_corner = params.discs[5].xyz;
    let own = own_shares.xyz;
    var drawn = Drawn(vec4f(0.0), vec4f(0.0));
    drawn = with_neighbour(drawn, to, i32(centre), dot(own, middle) + own_shares.w, middle, 1.0);
    // The four quarters, each a quarter turn after the one before.
    var along = 1;
    var across = i32(AROUND);
    for (var quarter = 0; quarter < 4; quarter++) {
        let first = i32(centre) + along;
        drawn = with_neighbour(drawn, to, first, dot(own, edge), edge, 0.0);
        drawn = with_neighbour(drawn, to, first + across, dot(own, corner), corner, 0.0);
        if reaches_far {
            let second = first + along;
            drawn = with_neighbour(drawn, to, second, dot(own, far_edge), far_edge, 0.0);
            drawn = with_neighbour(drawn, to, second - across, dot(own, knight), knight, 0.0);
            drawn = with_neighbour(drawn, to, second + across, dot(own, knight), knight, 0.0);
            drawn = with_neighbour(drawn, to, second + 2 * across, dot(own, far_corner), far_corner, 0.0);
        }
        let turned = -along;
        along = across;
        across = turned;
    }
    return drawn;
}

fn see(group: vec3u, local: vec3u, index: u32) -> Seen {
    let corner = vec2i(SIDE * group.xy + params.overscan) - 2;
    let size = textureDimensions(depth);
    var found = 0u;
    for (var i = index; i < AROUND * AROUND; i += 64u) {
        let in_tile = vec2i(vec2u(i % AROUND, i / AROUND));
        let c = coc_of(textureLoad(depth, clamp_to_image(corner + in_tile, size), 0).r);
        pixels[i] = vec4f(0.0, 0.0, 0.0, c);
        let own = all(in_tile >= vec2i(2)) && all(in_tile < vec2i(2 + i32(SIDE)));
        let variance = variance_of_coc(c);
        let on_image = c != 0.0 && variance < narrow_disc(1u);
        found |= select(0u, BLURRED, own && c != 0.0);
        found |= select(0u, DRAWN, own && on_image);
        found |= select(0u, SPREADING, c < 0.0 && on_image);
        found |= select(0u, FAR_REACHING, on_image && variance > params.disc_variance.y);
    }
    if found != 0u {
        atomicOr(&flags, found);
    }
    workgroupBarrier();
    found = atomicLoad(&flags);
    let is_drawn = (found & DRAWN) != 0u;
    let is_spread = (found & SPREADING) != 0u;
    let is_blurred = (found & BLURRED) != 0u;
    for (var i = index; i < select(0u, AROUND * AROUND, is_drawn | is_spread); i += 64u) {
        let p = clamp_to_image(corner + vec2i(vec2u(i % AROUND, i / AROUND)), size);
        let c = pixels[i].w;
        pixels[i] = vec4f(textureLoad(color, p, 0).rgb, c);
        shares_out[i] = shares(variance_of_coc(c)).xyz;
    }
    workgroupBarrier();

    let pixel = SIDE * group.xy + local.xy;
    let at = vec2f(pixel + params.overscan) + 0.5;
    let centre = (local.y + 2u) * AROUND + local.x + 2u;
    let c = pixels[centre].w;
    let own_coc = vec2f(c, variance_of_coc(c));
    let sharp = textureLoad(color, clamp_to_image(vec2i(at), size), 0).rgb;

    // Discs on the image.
    let in_front = own_coc.x < 0.0;
    let sees_front = in_front || params.smoothing != 0u;
    let part_per_variance = params.reach * params.reach / (3.0 * max(own_coc.y, 1e-12));
    let to = Receiver(2.0 / own_coc.x, part_per_variance, in_front, is_drawn, is_spread && sees_front);
    var drawn = Drawn(vec4f(0.0), vec4f(0.0));
    if is_drawn || to.is_spread_over {
        drawn = draw(to, shares(own_coc.y), centre, (found & FAR_REACHING) != 0u);
    }
    let sum = drawn.sum;
    var spread = drawn.spread;

    // Levels. The front level tells whether anything in front is near by: its texels are wider
    // than what ends on any level reaches.
    let own_level = u32(max(level_of_variance(own_coc.y), 0.0));
    let reached = sees_front && params.foreground != 0u && read_level(at, params.front_level, SPREAD).a > 0.0;
    for (var l = 1u; l < select(0u, params.front_level, reached); l++) {
        // Of something in front only what is as blurred: the level before its own fades out.
        let fading = select(0.0, 1.0 - handed_on(own_coc.y, own_level), l + 1u == own_level);
        let before = select(1.0, select(fading, 1.0, l >= own_level), in_front);
        spread += before * read_level(at, l, SPREAD);
    }
    var behind = select(vec4f(0.0), finest(vec4f(0.0), sum), in_front);
    for (var l = 1u; l < select(0u, min(own_level + 2u, params.levels), in_front); l++) {
        behind = finest(behind, read_level(at, l, REST));
    }
    let on = handed_on(own_coc.y, 0u);
    var own = color_of(sum, sharp);
    if in_front {
        let front = color_of(spread, sharp);
        own = mix(front, color_of(behind, front), behind.a);
    } else if on > 0.0 {
        own = blend_levels(own, behind_through(at, max(own_coc.y, narrow_disc(1u)), sharp), on);
    }

    let covered = min(spread.a, 1.0);
    let seen = spread.rgb / max(spread.a, 1.0) + (1.0 - covered) * own;
    let class_of = select(select(IN_FOCUS, FAR, is_blurred), NEAR, is_drawn || is_spread);
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
