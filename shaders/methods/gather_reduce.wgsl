// gather, before the rings: the reduced image with its levels, the list of bright texels, and what
// is known of tiles (src/methods/gather/passes.rs).

#import color
#import gather
#import sampling

@group(0) @binding(1) var color: texture_2d<f32>;
@group(0) @binding(2) var depth: texture_2d<f32>;
@group(0) @binding(3) var image_0: texture_storage_2d<COLOR_FORMAT, write>;
@group(0) @binding(4) var image_1: texture_storage_2d<COLOR_FORMAT, write>;
@group(0) @binding(5) var image_2: texture_storage_2d<COLOR_FORMAT, write>;
@group(0) @binding(6) var image_3: texture_storage_2d<COLOR_FORMAT, write>;
@group(0) @binding(7) var<storage, read_write> new_tiles: array<Tile>;
@group(0) @binding(8) var<storage, read> tiles: array<Tile>;
/// Position (x | y << 16), CoC, red and green, blue of each sprite.
@group(0) @binding(9) var<storage, read_write> new_sprites: array<vec4u>;
/// Vertices, instances, first of each.
@group(0) @binding(10) var<storage, read_write> sprite_draw: array<atomic<u32>, 4>;

/// Corners of a sprite.
const SPRITE_CORNERS = 4u;

/// Side of a workgroup, and its texels.
const SIDE = 8u;
const TEXELS = 64u;
/// The binary logarithm of that.
const ROUNDS = 6u;

/// The texels of the workgroup, then of each level the first ones.
var<workgroup> texels: array<vec4f, TEXELS>;
var<workgroup> coarser: array<vec4f, 16>;
/// Sums over the workgroup: colours of texels that count, and their number.
var<workgroup> sums: array<vec4f, TEXELS>;
/// Least and greatest c, and greatest |c|.
var<workgroup> bounds: array<vec3f, TEXELS>;

/// How much a pixel or texel with `c` counts in one whose widest CoC is `widest`.
fn likeness(c: f32, widest: f32) -> f32 {
    let alike = saturate(1.5 - abs(c - widest) / half_thickness(widest));
    return select(1.0, alike, params.prefilter != 0u);
}

/// The wider of two CoCs; of equal ones the nearer, whichever comes first.
fn wider(a: f32, b: f32) -> f32 {
    let is_b = abs(b) > abs(a) || (abs(b) == abs(a) && b < a);
    return select(a, b, is_b);
}

/// How much of the pixel at `at` lies in a texel around `centre`, px.
fn covered_share(at: vec2i, centre: vec2f) -> f32 {
    let covered = saturate(0.5 * f32(params.step) + 0.5 - abs(vec2f(at) + 0.5 - centre));
    return covered.x * covered.y;
}

/// Mean of the pixels of a texel that are like the widest of them, and their c.
fn reduced(id: vec2u) -> vec4f {
    let size = textureDimensions(color);
    let side = f32(params.step);
    let centre = side * (vec2f(id) + 0.5) - params.margin;
    let first = vec2i(floor(centre - 0.5 * side));
    let count = params.footprint * params.footprint;
    var widest = 0.0;
    for (var i = 0u; i < count; i++) {
        let at = first + vec2i(vec2u(i % params.footprint, i / params.footprint));
        let c = coc_diameter_px(params.lens, textureLoad(depth, clamp_to_image(at, size), 0).r);
        widest = select(widest, wider(widest, c), covered_share(at, centre) > 0.0);
    }
    var sum = vec4f(0.0);
    var weights = 0.0;
    for (var i = 0u; i < count; i++) {
        let at = first + vec2i(vec2u(i % params.footprint, i / params.footprint));
        let p = clamp_to_image(at, size);
        let c = coc_diameter_px(params.lens, textureLoad(depth, p, 0).r);
        let rgb = textureLoad(color, p, 0).rgb;
        let weight = select(0.0, covered_share(at, centre) * likeness(c, widest), is_finite(rgb));
        sum += weight * vec4f(select(vec3f(0.0), rgb, is_finite(rgb)), c);
        weights += weight;
    }
    return select(vec4f(0.0, 0.0, 0.0, widest), sum / weights, weights > 0.0);
}

/// Four texels as one of the next level, in the same way.
fn joined(a: vec4f, b: vec4f, c: vec4f, d: vec4f) -> vec4f {
    let widest = wider(wider(a.a, b.a), wider(c.a, d.a));
    let weights = vec4f(likeness(a.a, widest), likeness(b.a, widest), likeness(c.a, widest), likeness(d.a, widest));
    return (weights.x * a + weights.y * b + weights.z * c + weights.w * d) / dot(weights, vec4f(1.0));
}

/// How many times brighter than the mean around it a texel is that becomes a sprite: taps meet
/// what is not.
const BRIGHTER = 2.0;

/// Least radius, in texels, of a sprite: smaller spots are met by the taps.
const LEAST_SPRITE = 1.5;

fn greatest_of(color: vec3f) -> f32 {
    return max(color.r, max(color.g, color.b));
}

/// Sums `sums` and finds the bounds over the workgroup; the result is in the first.
fn sum_up(index: u32) {
    for (var k = 0u; k < ROUNDS; k++) {
        let half = (TEXELS / 2u) >> k;
        workgroupBarrier();
        if index < half {
            sums[index] += sums[index + half];
            let other = bounds[index + half];
            let own = bounds[index];
            bounds[index] = vec3f(min(own.x, other.x), max(own.yz, other.yz));
        }
    }
    workgroupBarrier();
}

fn write_tile_and_levels(id: vec2u, group: vec2u, index: u32) {
    if index == 0u {
        let b = bounds[0];
        let near_radius = select(0.0, 0.5 * params.aperture_radius * max(-b.x, 0.0), params.near != 0u);
        new_tiles[group.y * (params.grid.x / TILE) + group.x] = Tile(b.x, b.y, near_radius, b.z);
    }
    textureStore(image_0, id, texels[index]);
    // Each level by the invocations at the group's beginning.
    if index < 16u {
        let at = 2u * (index % 4u) + 2u * SIDE * (index / 4u);
        coarser[index] = joined(texels[at], texels[at + 1u], texels[at + SIDE], texels[at + SIDE + 1u]);
        textureStore(image_1, 4u * group + vec2u(index % 4u, index / 4u), coarser[index]);
    }
    workgroupBarrier();
    if index < 4u {
        let at = 2u * (index % 2u) + 8u * (index / 2u);
        texels[index] = joined(coarser[at], coarser[at + 1u], coarser[at + 4u], coarser[at + 5u]);
        textureStore(image_2, 2u * group + vec2u(index % 2u, index / 2u), texels[index]);
    }
    workgroupBarrier();
    if index == 0u {
        textureStore(image_3, group, joined(texels[0], texels[1], texels[2], texels[3]));
    }
}

@compute @workgroup_size(8, 8)
fn reduce(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let texel = reduced(id.xy);
    texels[index] = texel;
    sums[index] = vec4f(0.0);
    bounds[index] = vec3f(texel.a, texel.a, abs(texel.a));
    sum_up(index);
    write_tile_and_levels(id.xy, group.xy, index);
}

/// The same where something in view is bright: what is far brighter than the tile around it is
/// replaced by the mean of what is not, and listed.
@compute @workgroup_size(8, 8)
fn reduce_and_list(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    var texel = reduced(id.xy);
    sums[index] = vec4f(greatest_of(texel.rgb), 0.0, 0.0, 0.0);
    bounds[index] = vec3f(texel.a, texel.a, abs(texel.a));
    sum_up(index);
    let mean = sums[0].x / f32(TEXELS);
    workgroupBarrier();
    let limit = max(params.sprite_threshold, BRIGHTER * mean);
    let is_wide = params.aperture_radius * own_radius(texel.a) > LEAST_SPRITE * f32(params.step);
    let is_sprite = greatest_of(texel.rgb) > limit && is_wide;
    sums[index] = select(vec4f(texel.rgb, 1.0), vec4f(0.0), is_sprite);
    sum_up(index);
    if all(id.xy == vec2u(0u)) {
        atomicStore(&sprite_draw[0], SPRITE_CORNERS);
    }
    if is_sprite {
        let place = atomicAdd(&sprite_draw[1], 1u);
        let rgb = min(texel.rgb, vec3f(MAX_F16));
        let packed = vec2u(pack2x16float(rgb.rg), pack2x16float(vec2f(rgb.b, 0.0)));
        new_sprites[place] = vec4u(id.x | (id.y << 16u), bitcast<u32>(texel.a), packed);
        // Not all of a tile is brighter than twice its mean.
        texel = vec4f(sums[0].rgb / max(sums[0].a, 1.0), texel.a);
    }
    texels[index] = texel;
    workgroupBarrier();
    write_tile_and_levels(id.xy, group.xy, index);
}

/// Least distance, px, between texels of two tiles that lie `tiles` apart.
fn distance_px(tiles: vec2i) -> f32 {
    let apart = vec2f(max(abs(tiles) - 1, vec2i(0)) * i32(TILE) + select(vec2i(0), vec2i(1), tiles != vec2i(0)));
    return length(apart) * f32(params.step);
}

/// Each tile with what reaches it: foreground by its own blur, and one tile more, so that values
/// between tiles' centres can be interpolated; what the tile's own taps meet by its widest blur.
@compute @workgroup_size(8, 8)
fn spread_tiles(@builtin(global_invocation_id) id: vec3u) {
    let count = params.grid / TILE;
    if any(id.xy >= count) {
        return;
    }
    let own = tiles[id.y * count.x + id.x];
    let own_reach = 0.5 * params.aperture_radius * own.widest;
    var reached = own;
    let reach = i32(params.reach_tiles);
    let first = max(vec2i(id.xy) - reach - 1, vec2i(0));
    let last = min(vec2i(id.xy) + reach + 1, vec2i(count) - 1);
    for (var y = first.y; y <= last.y; y++) {
        for (var x = first.x; x <= last.x; x++) {
            let tile = tiles[u32(y) * count.x + u32(x)];
            let apart = vec2i(x, y) - vec2i(id.xy);
            let nearer_by_one = sign(apart) * max(abs(apart) - 1, vec2i(0));
            if tile.near_radius >= distance_px(nearer_by_one) {
                reached.near_radius = max(reached.near_radius, tile.near_radius);
            }
            if own_reach >= distance_px(apart) {
                reached.nearest = min(reached.nearest, tile.nearest);
                reached.farthest = max(reached.farthest, tile.farthest);
            }
        }
    }
    new_tiles[id.y * count.x + id.x] = reached;
}
