// gather: rings of taps in the texel's own CoC, and in that of the foreground near by
// (src/methods/gather/mod.rs).
//
// A tap stands for an area of its own, and brings the share of that area's light that its own
// CoC carries to the texel. With R the radius of the rings, N the taps, r a tap's radius and d
// its distance:
//
//          R^2 / N              (r - d)
//       --------------  *  ramp(-------)      a disc's share; other apertures' from running sums
//        r^2 + R^2 / N           side

#import gather
#import sprites

@group(0) @binding(1) var<uniform> sprites: Sprites;
@group(0) @binding(2) var image: texture_2d<f32>;
@group(0) @binding(3) var idf_sums: texture_2d<f32>;
@group(0) @binding(4) var<storage, read> tiles: array<Tile>;
@group(0) @binding(5) var<storage, read> points: array<vec2f>;
@group(0) @binding(6) var front: texture_storage_2d<COLOR_FORMAT, write>;
@group(0) @binding(7) var base: texture_storage_2d<COLOR_FORMAT, write>;
@group(0) @binding(8) var gathered_front: texture_2d<f32>;
@group(0) @binding(9) var gathered_base: texture_2d<f32>;
@group(0) @binding(10) var classes: texture_storage_2d<r32float, write>;

const IN_FOCUS = 0.0;
const ONE_BLUR = 1.0;
const MIXED = 2.0;

/// How far CoCs may differ, over the widest, in a tile of one blur: what is added up there without
/// comparisons is then the same surface, and its areas differ by a fifth.
const ONE_BLUR_RANGE = 0.1;

fn class_of(tile: Tile) -> f32 {
    if params.tiles == 0u {
        return MIXED;
    }
    let no_foreground = tile.near_radius <= 0.5 * params.aperture_radius * max(-tile.nearest, 0.0);
    if tile.widest < params.in_focus_coc && tile.near_radius == 0.0 {
        return IN_FOCUS;
    }
    let is_one = tile.farthest - tile.nearest <= ONE_BLUR_RANGE * tile.widest;
    return select(MIXED, ONE_BLUR, is_one && no_foreground);
}

fn tile_of(tile: vec2u) -> Tile {
    let count = params.grid / TILE;
    let at = min(tile, count - 1u);
    return tiles[at.y * count.x + at.x];
}

/// The foreground's radius, between the centres of tiles: no step from one to the next.
fn near_radius_at(id: vec2u) -> f32 {
    let last = vec2f(params.grid / TILE - 1u);
    let at = clamp((vec2f(id) + 0.5) / f32(TILE) - 0.5, vec2f(0.0), last);
    let corner = vec2u(floor(at));
    let part = fract(at);
    let top = mix(tile_of(corner).near_radius, tile_of(corner + vec2u(1u, 0u)).near_radius, part.x);
    let bottom = mix(tile_of(corner + vec2u(0u, 1u)).near_radius, tile_of(corner + 1u).near_radius, part.x);
    return mix(top, bottom, part.y);
}

/// Rings around a texel.
struct Rings {
    /// px, of the aperture's greatest |v|.
    radius: f32,
    /// Side, px, of the square of a tap's area.
    side: f32,
    /// The level that taps read: texels no wider than a tap's area.
    level: u32,
}

fn rings_of(radius: f32) -> Rings {
    let side = radius * sqrt(PI / f32(params.taps));
    let level = clamp(floor(log2(max(side / f32(params.step), 1.0))), 0.0, f32(LEVELS - 1u));
    return Rings(radius, side, u32(level));
}

/// The texel `offset` px from a texel's centre, on a level. Nearest, since a mean of two surfaces'
/// CoCs is neither's; on the finest level rounded as a distance, so that mirrored offsets read
/// mirrored texels.
fn tap(id: vec2u, offset: vec2f, level: u32) -> vec4f {
    let texels = offset / f32(params.step);
    let rounded = vec2i(id) + vec2i(sign(texels) * floor(abs(texels) + 0.5));
    let scale = exp2(-f32(level));
    let coarse = vec2i(floor((vec2f(id) + 0.5 + texels) * scale));
    let at = select(coarse, rounded, level == 0u);
    return textureLoad(image, clamp(at, vec2i(0), vec2i(params.grid >> vec2u(level))  - 1), level);
}

/// Share of the light of a tap's area that arrives, the tap `offset` px away.
fn share_of(c: f32, offset: vec2f, rings: Rings) -> f32 {
    if params.is_disc == 0u {
        let side = max(rings.side, 1e-3);
        return sprite_share(idf_sums, sprites, -offset / side, sign(c) * 2.0 * own_radius(c) / side);
    }
    let radius = own_radius(c);
    let area = rings.side * rings.side / PI;
    let widened = radius * radius + area;
    return area / max(widened, 1e-9) * reached(sqrt(widened), offset, rings);
}

/// Whether a spot of that radius reaches the texel, by a ramp as wide as a tap.
fn reached(radius: f32, offset: vec2f, rings: Rings) -> f32 {
    return saturate((radius - length(offset)) / max(rings.side, 1e-3) + 0.5);
}

/// How much less what does not reach the texel counts behind a surface than what does: it only
/// fills where there is nothing else.
const FILLING = 0.01;

/// What arrives in each layer: colours times shares, and shares.
struct Arrived {
    front: vec4f,
    own: vec4f,
    behind: vec4f,
}

fn of_one_blur(id: vec2u, rings: Rings, count: u32) -> vec4f {
    var sum = vec4f(0.0);
    for (var i = 0u; i < count; i++) {
        let offset = rings.radius * points[i];
        let texel = tap(id, offset, rings.level);
        let share = select(share_of(texel.a, offset, rings), 1.0, params.is_disc != 0u);
        sum += share * vec4f(texel.rgb, 1.0);
    }
    return sum;
}

fn of_own_rings(id: vec2u, c_own: f32, rings: Rings, count: u32) -> Arrived {
    var arrived = Arrived(vec4f(0.0), vec4f(0.0), vec4f(0.0));
    for (var i = 0u; i < count; i++) {
        let offset = rings.radius * points[i];
        let texel = tap(id, offset, rings.level);
        let light = vec4f(texel.rgb, 1.0);
        let share = share_of(texel.a, offset, rings);
        let nearer = in_front(texel.a, c_own);
        let farther = behind(texel.a, c_own);
        arrived.front += nearer * share * light;
        arrived.own += (1.0 - nearer - farther) * share * light;
        // Closer taps first.
        let filling = FILLING * pow(1.0 - min(length(points[i]), 0.99), 4.0);
        arrived.behind += farther * (share * f32(params.taps) + filling) * light;
    }
    return arrived;
}

fn of_foreground(id: vec2u, c_own: f32, rings: Rings, count: u32) -> vec4f {
    var sum = vec4f(0.0);
    for (var i = 0u; i < count; i++) {
        let offset = rings.radius * points[i];
        let texel = tap(id, offset, rings.level);
        sum += in_front(texel.a, c_own) * share_of(texel.a, offset, rings) * vec4f(texel.rgb, 1.0);
    }
    return sum;
}

/// Divided by what is more than 1: an alpha.
fn at_most_1(light: vec4f) -> vec4f {
    return light / max(light.a, 1.0);
}

@compute @workgroup_size(8, 8)
fn gather(@builtin(global_invocation_id) id: vec3u, @builtin(workgroup_id) group: vec3u) {
    let tile = tile_of(group.xy);
    let class_ = class_of(tile);
    // Loops that end at once, no branches: software adapters run both sides of those.
    let one_blur = select(0u, params.taps, class_ == ONE_BLUR);
    let mixed = select(0u, params.taps, class_ == MIXED);
    let middle = textureLoad(image, id.xy, 0);
    let own_rings = rings_of(params.aperture_radius * own_radius(middle.a));
    // The foreground's rings are no smaller than the texel's own: with no foreground both are the
    // same, whichever counts what is in front.
    let near_radius = near_radius_at(id.xy);
    let near_rings = rings_of(max(near_radius, own_rings.radius));
    let has_near = mixed != 0u && near_radius > 0.0;

    let same = of_one_blur(id.xy, own_rings, one_blur);
    let own = of_own_rings(id.xy, middle.a, own_rings, mixed);
    let near = of_foreground(id.xy, middle.a, near_rings, select(0u, mixed, has_near));
    let nearer = at_most_1(select(own.front, near, has_near));

    // What the surface leaves open of its own disc, filled by what is behind it.
    let surface = at_most_1(own.own);
    let open = (1.0 - surface.a) * f32(params.fill);
    let fills = own.behind.a / (own.behind.a + 0.1 * FILLING);
    let filling = own.behind.rgb / max(own.behind.a, 1e-9);
    let filled = surface + open * fills * vec4f(filling, 1.0);
    var own_color = select(middle.rgb, filled.rgb / max(filled.a, 1e-9), filled.a > 1e-4);
    var own_share = select(1.0, surface.a / max(filled.a, 1e-9), filled.a > 1e-4);
    if same.a > 0.0 {
        own_color = same.rgb / same.a;
        own_share = 1.0;
    }
    textureStore(front, id.xy, nearer);
    textureStore(base, id.xy, vec4f(own_color, own_share));
}

// ---- post filter ----

const MEDIAN = 1u;

/// Pairs to be ordered one after the other, after which the fifth of nine is their median: the
/// sorting network of Devillard, "Fast median search: an ANSI C implementation" (1998), after Paeth.
const PAIRS = array<vec2u, 19>(
    vec2u(1u, 2u), vec2u(4u, 5u), vec2u(7u, 8u), vec2u(0u, 1u), vec2u(3u, 4u), vec2u(6u, 7u),
    vec2u(1u, 2u), vec2u(4u, 5u), vec2u(7u, 8u), vec2u(0u, 3u), vec2u(5u, 8u), vec2u(4u, 7u),
    vec2u(3u, 6u), vec2u(1u, 4u), vec2u(2u, 5u), vec2u(4u, 7u), vec2u(4u, 2u), vec2u(6u, 4u),
    vec2u(4u, 2u),
);

/// Median of nine, channel by channel.
fn median_of(unordered: array<vec4f, 9>) -> vec4f {
    var v = unordered;
    for (var i = 0u; i < 19u; i++) {
        let pair = PAIRS[i];
        let low = min(v[pair.x], v[pair.y]);
        v[pair.y] = max(v[pair.x], v[pair.y]);
        v[pair.x] = low;
    }
    return v[4];
}

/// The 3x3 texels of a layer, those of another surface replaced by the middle one.
fn filtered(layer: texture_2d<f32>, id: vec2u) -> vec4f {
    let c_own = textureLoad(image, id, 0).a;
    let middle = textureLoad(layer, id, 0);
    // Slight blur keeps its detail.
    let amount = saturate(0.5 * abs(c_own) / f32(params.step) - 1.0);
    var around: array<vec4f, 9>;
    var mean = vec4f(0.0);
    for (var i = 0u; i < 9u; i++) {
        let p = clamp(vec2i(id) + vec2i(vec2u(i % 3u, i / 3u)) - 1, vec2i(0), vec2i(params.grid) - 1);
        let c = textureLoad(image, p, 0).a;
        let other = max(in_front(c, c_own), behind(c, c_own));
        around[i] = mix(textureLoad(layer, p, 0), middle, other);
        let weight = vec2f(2 - abs(vec2i(vec2u(i % 3u, i / 3u)) - 1)) * 0.25;
        mean += weight.x * weight.y * around[i];
    }
    return mix(middle, select(mean, median_of(around), params.post_filter == MEDIAN), amount);
}

@compute @workgroup_size(8, 8)
fn filter_layers(@builtin(global_invocation_id) id: vec3u) {
    textureStore(front, id.xy, filtered(gathered_front, id.xy));
    textureStore(base, id.xy, filtered(gathered_base, id.xy));
}

// ---- to look at ----

@compute @workgroup_size(8, 8)
fn show_classes(@builtin(global_invocation_id) id: vec3u) {
    if all(id.xy < params.grid / TILE) {
        textureStore(classes, id.xy, vec4f(class_of(tile_of(id.xy)), 0.0, 0.0, 0.0));
    }
}
