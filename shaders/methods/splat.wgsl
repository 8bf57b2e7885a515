// splat: point splatting on per-pixel layers (src/methods/splat.rs).
//
// Lee, Kim and Choi, Pacific Graphics 2008. A destination pixel q sorts what arrives from
// a source pixel p into three layers by the signed CoC diameters c(p) and c_v(q), c_v that
// of the visible surface at q:
//
//        front (L0)         same (L1)            behind (L2)
//     -------------)[-----------+-----------](-------------->  c(p), far is right
//            c_v - delta C_v   c_v   c_v + delta C_v

#import color
#import sprites
#import sampling

struct Params {
    /// Half width of the middle layer over C_v: the paper's delta.
    delta: f32,
    /// Stored depth z that a hidden surface must lie behind the visible one.
    separation_z: f32,
    /// Mean difference of c, px, between neighbours and a pixel that partially occludes.
    occlusion_px: f32,
    /// 0: all sprites go to the middle layer.
    layered: u32,
    /// 1: each layer is divided by its alpha as it is composed.
    normalised: u32,
    /// 1: the hidden image adds no more to a layer than is missing there.
    filling: u32,
    /// 1: bright pixels are made brighter, for images that were cut at white.
    highlights: u32,
    /// lambda_0, beta and gamma of equation (8).
    highlight_threshold: f32,
    highlight_falloff: f32,
    highlight_gain: f32,
}

@group(0) @binding(0) var<uniform> lens: Lens;
@group(0) @binding(1) var<uniform> sprites: Sprites;
@group(0) @binding(2) var<uniform> params: Params;
/// The source: the visible or the hidden image.
@group(0) @binding(3) var color: texture_2d<f32>;
@group(0) @binding(4) var depth: texture_2d<f32>;
@group(0) @binding(5) var visible_depth: texture_2d<f32>;
@group(0) @binding(6) var idf_sums: texture_2d<f32>;
@group(0) @binding(7) var arrays: texture_2d<u32>;
@group(0) @binding(8) var layer_front: texture_2d<f32>;
@group(0) @binding(9) var layer_same: texture_2d<f32>;
@group(0) @binding(10) var layer_behind: texture_2d<f32>;
/// Of the hidden image: M1 and M2.
@group(0) @binding(11) var hidden_same: texture_2d<f32>;
@group(0) @binding(12) var hidden_behind: texture_2d<f32>;
@group(0) @binding(13) var behind_z: texture_storage_2d<r32float, write>;
@group(0) @binding(14) var chosen_arrays: texture_storage_2d<r32uint, write>;
@group(0) @binding(15) var result: texture_storage_2d<COLOR_FORMAT, write>;
@group(0) @binding(16) var explained: texture_storage_2d<rgba16float, write>;

fn visible_coc_px(p: vec2i) -> f32 {
    return coc_diameter_px(lens, textureLoad(visible_depth, clamp_to_image(p, textureDimensions(visible_depth)), 0).r);
}

// ---- section 3.2: what may be seen behind a visible pixel ----

/// 12 points of the unit disc, at least half its radius apart as Poisson disc samples
/// are, but symmetric, so that a mirrored image is treated alike.
const NEIGHBOURS = array<vec2f, 3>(vec2f(0.27, 0.27), vec2f(0.40, 0.87), vec2f(0.87, 0.40));

/// Whether the surfaces around p, within `scan` of its CoC, lie so much farther that
/// something behind it can be seen: L(p) of equation (4), in c.
fn occludes_partially(p: vec2i, scan: f32) -> bool {
    let c = visible_coc_px(p);
    if c >= 0.0 {
        return false;
    }
    let reach = 0.5 * scan * sprites.radius * abs(c);
    var farther = 0.0;
    for (var i = 0; i < 12; i++) {
        let sign = vec2f(vec2i(i & 1, (i >> 1) & 1) * 2 - 1);
        let at = vec2f(p) + 0.5 + reach * sign * NEIGHBOURS[i >> 2];
        farther += visible_coc_px(vec2i(floor(at))) - c;
    }
    return farther / 12.0 >= params.occlusion_px;
}

/// The stored depth below which a hidden surface is accepted; 0 rejects all.
@compute @workgroup_size(8, 8)
fn find_hidden_limit(@builtin(global_invocation_id) id: vec3u) {
    var limit = 0.0;
    if occludes_partially(vec2i(id.xy), 1.0) {
        limit = textureLoad(visible_depth, id.xy, 0).r - params.separation_z;
    }
    textureStore(behind_z, id.xy, vec4f(limit, 0.0, 0.0, 0.0));
}

// ---- section 5: which pixels need a sprite of their own ----

const ONE_FOR_FOUR = 1u;
const EACH_ITS_OWN = 2u;

/// CoC diameter, px, below which every pixel keeps its sprite.
const FOCUSED_COC_PX = 4.0;

/// How much less of the CoC the reduced array scans for partial occlusion: where only
/// this finds none, both arrays draw and no holes are left between them.
const REDUCED_SCAN = 0.95;

/// Arrays that draw the 2x2 pixels from 2 * id on, as bits.
@compute @workgroup_size(8, 8)
fn choose_arrays(@builtin(global_invocation_id) id: vec3u) {
    let first = vec2i(2u * id.xy);
    var nearest = visible_coc_px(first);
    var farthest = nearest;
    var sharpest = abs(nearest);
    var occludes = false;
    var occludes_in_reduced = false;
    for (var i = 0; i < 4; i++) {
        let p = first + vec2i(i & 1, i >> 1);
        let c = visible_coc_px(p);
        nearest = min(nearest, c);
        farthest = max(farthest, c);
        sharpest = min(sharpest, abs(c));
        occludes |= occludes_partially(p, 1.0);
        occludes_in_reduced |= occludes_partially(p, REDUCED_SCAN);
    }
    let inside = all(2u * id.xy + 1u < textureDimensions(visible_depth));
    // One sprite cannot stand for surfaces that go to different layers.
    let one_surface = farthest - nearest <= params.delta * sharpest;
    let uniform_blur = inside && one_surface && sharpest >= FOCUSED_COC_PX;
    let reduced = uniform_blur && !occludes_in_reduced;
    let full = !reduced || occludes;
    let bits = select(0u, ONE_FOR_FOUR, reduced) | select(0u, EACH_ITS_OWN, full);
    textureStore(chosen_arrays, id.xy, vec4u(bits));
}

fn is_drawn_by(array: u32, block: vec2u) -> bool {
    return (textureLoad(arrays, block, 0).r & array) != 0u;
}

// ---- sections 3.3 and 3.4: sprites on layers ----

struct Fragment {
    @builtin(position) at: vec4f,
    /// On the inner frame, px.
    @location(0) @interpolate(flat) centre: vec2f,
    @location(1) @interpolate(flat) c: f32,
    /// Colour times weight, and weight: the number of pixels that this one stands for.
    @location(2) @interpolate(flat) light: vec4f,
}

struct Layers {
    @location(0) front: vec4f,
    @location(1) same: vec4f,
    @location(2) behind: vec4f,
}

/// Equation (8).
fn with_highlights(rgb: vec3f) -> vec3f {
    let lambda = dot(rgb, vec3f(0.3, 0.59, 0.11));
    if params.highlights == 0u || lambda <= params.highlight_threshold {
        return rgb;
    }
    // Above white the paper's polynomial would grow without bounds.
    let above = min((lambda - params.highlight_threshold) / (1.0 - params.highlight_threshold), 1.0);
    let share = pow(above, params.highlight_falloff);
    return min((1.0 - share + share * params.highlight_gain) * rgb, vec3f(MAX_F16));
}

/// A source pixel: colour and 1, or 0 where there is nothing that can be drawn.
fn source(p: vec2u) -> vec4f {
    let texel = textureLoad(color, p, 0);
    let there = texel.a > 0.0 && is_finite_source(texel.rgb, textureLoad(depth, p, 0).r);
    return select(vec4f(0.0), vec4f(with_highlights(texel.rgb), 1.0), there);
}

fn sprite(corner: u32, centre_px: vec2f, c: f32, light: vec4f) -> Fragment {
    let centre = centre_px - f32(sprites.overscan);
    let position = sprite_corner(sprites, corner, centre, c);
    return Fragment(select(NOWHERE, position, light.a > 0.0), centre, c, light);
}

fn pixel_of(index: u32) -> vec2u {
    let width = textureDimensions(depth).x;
    return vec2u(index % width, index / width);
}

/// A visible pixel, if its spot is larger than a pixel; the others are in `fs_sharp`.
fn visible_sprite(corner: u32, p: vec2u) -> Fragment {
    let c = coc_diameter_px(lens, textureLoad(depth, p, 0).r);
    return sprite(corner, vec2f(p) + 0.5, c, select(source(p), vec4f(0.0), is_single_pixel(sprites, c)));
}

@vertex
fn vs_pixel(@builtin(vertex_index) corner: u32, @builtin(instance_index) index: u32) -> Fragment {
    return visible_sprite(corner, pixel_of(index));
}

/// What the reduced array leaves to the full one.
@vertex
fn vs_pixel_not_reduced(@builtin(vertex_index) corner: u32, @builtin(instance_index) index: u32) -> Fragment {
    let p = pixel_of(index);
    if !is_drawn_by(EACH_ITS_OWN, p / 2u) {
        return Fragment(NOWHERE, vec2f(0.0), 0.0, vec4f(0.0));
    }
    return visible_sprite(corner, p);
}

/// Four visible pixels as one.
@vertex
fn vs_block(@builtin(vertex_index) corner: u32, @builtin(instance_index) index: u32) -> Fragment {
    let width = textureDimensions(arrays).x;
    let block = vec2u(index % width, index / width);
    if !is_drawn_by(ONE_FOR_FOUR, block) {
        return Fragment(NOWHERE, vec2f(0.0), 0.0, vec4f(0.0));
    }
    var z = 0.0;
    var light = vec4f(0.0);
    for (var i = 0u; i < 4u; i++) {
        let p = 2u * block + vec2u(i & 1u, i >> 1u);
        z += 0.25 * textureLoad(depth, p, 0).r;
        light += source(p);
    }
    return sprite(corner, vec2f(2u * block) + 1.0, coc_diameter_px(lens, z), light);
}

@vertex
fn vs_hidden(@builtin(vertex_index) corner: u32, @builtin(instance_index) index: u32) -> Fragment {
    let p = pixel_of(index);
    return sprite(corner, vec2f(p) + 0.5, coc_diameter_px(lens, textureLoad(depth, p, 0).r), source(p));
}

/// What reaches this pixel, on its layer: equations (5) and (6).
fn layered(in: Fragment) -> Layers {
    let share = sprite_share(idf_sums, sprites, in.at.xy - in.centre, in.c);
    if share <= 0.0 {
        discard;
    }
    let light = share * in.light;
    let c_v = visible_coc_px(vec2i(floor(in.at.xy)) + i32(sprites.overscan));
    let farther = in.c - c_v;
    let limit = params.delta * abs(c_v);
    if params.layered == 0u || abs(farther) <= limit {
        return Layers(vec4f(0.0), light, vec4f(0.0));
    }
    if farther < 0.0 {
        return Layers(light, vec4f(0.0), vec4f(0.0));
    }
    return Layers(vec4f(0.0), vec4f(0.0), light);
}

@fragment
fn fs_visible(in: Fragment) -> Layers {
    return layered(in);
}

struct HiddenLayers {
    @location(0) same: vec4f,
    @location(1) behind: vec4f,
}

/// Hidden pixels occlude nothing: what would lie in front is dropped.
@fragment
fn fs_hidden(in: Fragment) -> HiddenLayers {
    let layers = layered(in);
    if layers.front.a > 0.0 {
        discard;
    }
    return HiddenLayers(layers.same, layers.behind);
}

@vertex
fn vs_all(@builtin(vertex_index) corner: u32) -> @builtin(position) vec4f {
    return vec4f(vec2f(f32(corner & 1u), f32(corner >> 1u)) * 4.0 - 1.0, 0.0, 1.0);
}

/// Visible pixels that stay within themselves: no sprites, and never another layer.
@fragment
fn fs_sharp(@builtin(position) at: vec4f) -> Layers {
    let p = vec2u(at.xy) + sprites.overscan;
    let sharp = is_single_pixel(sprites, visible_coc_px(vec2i(p)));
    return Layers(vec4f(0.0), select(vec4f(0.0), source(p), sharp), vec4f(0.0));
}

// ---- section 3.5: composition ----

/// Divided by its alpha where there is any.
fn normalised(light: vec4f) -> vec4f {
    if params.normalised == 0u || light.a <= 0.0 {
        return light;
    }
    return vec4f(light.rgb / light.a, 1.0);
}

/// Equation (7). Overlapping CoCs of several sizes sum to more than 1: then nothing
/// shines through, rather than a negative amount.
fn over(near: vec4f, far: vec4f) -> vec4f {
    return normalised(near + max(1.0 - near.a, 0.0) * far);
}

fn composed(behind: vec4f, same: vec4f, front: vec4f) -> vec4f {
    return vec4f(over(front, over(same, normalised(behind))).rgb, 1.0);
}

@compute @workgroup_size(8, 8)
fn compose_visible(@builtin(global_invocation_id) id: vec3u) {
    let front = textureLoad(layer_front, id.xy, 0);
    let same = textureLoad(layer_same, id.xy, 0);
    textureStore(result, id.xy, composed(textureLoad(layer_behind, id.xy, 0), same, front));
}

/// A visible layer with what the hidden image adds to it.
fn completed(visible: vec4f, hidden: vec4f) -> vec4f {
    let missing = max(1.0 - visible.a, 0.0);
    let cut = params.filling != 0u && hidden.a > missing;
    return visible + hidden * select(1.0, missing / hidden.a, cut);
}

@compute @workgroup_size(8, 8)
fn compose_with_hidden(@builtin(global_invocation_id) id: vec3u) {
    let front = textureLoad(layer_front, id.xy, 0);
    let same = completed(textureLoad(layer_same, id.xy, 0), textureLoad(hidden_same, id.xy, 0));
    let behind = completed(textureLoad(layer_behind, id.xy, 0), textureLoad(hidden_behind, id.xy, 0));
    textureStore(result, id.xy, composed(behind, same, front));
}

/// Share of a pixel from which on a layer counts as seen.
const SEEN = 0.02;

/// To look at: which of the visible layers are seen beside the middle one (1 in front, 2
/// behind, 3 both), and the share of each.
@compute @workgroup_size(8, 8)
fn explain_layers(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(explained)) {
        return;
    }
    let front = saturate(textureLoad(layer_front, id.xy, 0).a);
    let same = (1.0 - front) * saturate(textureLoad(layer_same, id.xy, 0).a);
    let behind = (1.0 - front - same) * saturate(textureLoad(layer_behind, id.xy, 0).a);
    // What sums to less than 1 is divided by its sum, as the composed layers are.
    let shares = vec3f(front, same, behind) / max(front + same + behind, 1e-6);
    let seen = select(0.0, 1.0, shares.x >= SEEN) + select(0.0, 2.0, shares.z >= SEEN);
    textureStore(explained, id.xy, vec4f(seen, shares));
}
