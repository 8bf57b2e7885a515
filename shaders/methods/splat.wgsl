// splat: point splatting on per-pixel layers (src/methods/splat/mod.rs).
//
// Lee, Kim and Choi, Pacific Graphics 2008. A destination pixel q sorts what arrives from
// a source pixel p into three layers by the signed CoC diameters c(p) and c_v(q), c_v that
// of the visible surface at q:
//
//        front (L0)         same (L1)            behind (L2)
//     -------------)[-----------+-----------](-------------->  c(p), far is right
//            c_v - delta C_v   c_v   c_v + delta C_v

#import splat

@group(0) @binding(0) var layer_front: texture_2d<f32>;
@group(0) @binding(1) var layer_same: texture_2d<f32>;
@group(0) @binding(2) var layer_behind: texture_2d<f32>;
/// Of the hidden image: M1 and M2.
@group(0) @binding(3) var hidden_same: texture_2d<f32>;
@group(0) @binding(4) var hidden_behind: texture_2d<f32>;
@group(0) @binding(5) var behind_z: texture_storage_2d<r32float, write>;
@group(0) @binding(6) var chosen_arrays: texture_storage_2d<r32uint, write>;
@group(0) @binding(7) var result: texture_storage_2d<COLOR_FORMAT, write>;
@group(0) @binding(8) var explained: texture_storage_2d<rgba16float, write>;

// ---- section 3.2: what may be seen behind a visible pixel ----

/// 12 points of the unit disc, at least half its radius apart as Poisson disc samples
/// are, but symmetric, so that a mirrored image is treated alike.
const NEIGHBOURS = array<vec2f, 3>(vec2f(0.27, 0.27), vec2f(0.40, 0.87), vec2f(0.87, 0.40));

/// Whether the surfaces around p, within `scan` of its CoC, lie so much farther that
/// something behind it can be seen: L(p) of equation (4), in c.
fn occludes_partially(p: vec2i, scan: f32) -> bool {
    let c = visible_coc_px(p);
    // An ellipse's longer diameter is that of a blur in front of focus up to here.
    if c >= abs(lens.astigmatism_px) {
        return false;
    }
    let reach = 0.5 * scan * sprites.radius * greatest_diameter_px(lens, c);
    var farther = 0.0;
    for (var i = 0; i < 12; i++) {
        let sign = vec2f(vec2i(i & 1, (i >> 1) & 1) * 2 - 1);
        let at = vec2f(p) + 0.5 + reach * sign * NEIGHBOURS[i >> 2];
        farther += visible_coc_px(vec2i(floor(at))) - c;
    }
    return farther / 12.0 >= params.occlusion_px;
}

/// The stored depth below which a hidden surface is accepted; -1 rejects all.
@compute @workgroup_size(8, 8)
fn find_hidden_limit(@builtin(global_invocation_id) id: vec3u) {
    var limit = -1.0;
    if occludes_partially(vec2i(id.xy), 1.0) {
        limit = textureLoad(visible_depth, id.xy, 0).r - params.separation_z;
    }
    textureStore(behind_z, id.xy, vec4f(limit, 0.0, 0.0, 0.0));
}

// ---- section 5: which pixels need a sprite of their own ----

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
    var sharpest = least_diameter_px(lens, nearest);
    var occludes = false;
    var occludes_in_reduced = false;
    for (var i = 0; i < 4; i++) {
        let p = first + vec2i(i & 1, i >> 1);
        let c = visible_coc_px(p);
        nearest = min(nearest, c);
        farthest = max(farthest, c);
        sharpest = min(sharpest, least_diameter_px(lens, c));
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

/// Share of a disc with radius 1 that lies beyond a line `distance` from its centre.
fn share_beyond(distance: f32) -> f32 {
    let x = clamp(distance, -1.0, 1.0);
    return (acos(x) - x * sqrt(1.0 - x * x)) / 3.14159265;
}

/// Share of the spot of the surface that `pixel`, of the outer frame, shows which lies in that frame:
/// what light from beyond it would bring is missing and not hidden. A quarter in a corner, not less.
fn share_in_frame(pixel: vec2u) -> f32 {
    let extent = blur_extent_px(lens, visible_coc_px(vec2i(pixel)));
    let radius = max(0.5 * sprites.radius * extent, vec2f(0.5));
    let low = (vec2f(pixel) + 0.5) / radius;
    let high = (vec2f(textureDimensions(visible_depth)) - vec2f(pixel) - 0.5) / radius;
    let x = 1.0 - share_beyond(low.x) - share_beyond(high.x);
    let y = 1.0 - share_beyond(low.y) - share_beyond(high.y);
    return clamp(x * y, 0.25, 1.0);
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
    // The paper adds what is hidden, wherever it is.
    let in_frame = select(1.0, share_in_frame(id.xy + sprites.overscan), params.filling != 0u);
    let seen = textureLoad(layer_same, id.xy, 0) / in_frame;
    let same = completed(seen, textureLoad(hidden_same, id.xy, 0));
    let behind = completed(textureLoad(layer_behind, id.xy, 0), textureLoad(hidden_behind, id.xy, 0));
    textureStore(result, id.xy, composed(behind, same, front));
}

// ---- sheets: surfaces that cover a part of what lies behind them (src/methods/splat/sheets.rs) ----

@group(0) @binding(9) var sheet_color: texture_2d_array<f32>;
@group(0) @binding(10) var sheet_depths: texture_2d<f32>;
@group(0) @binding(11) var spot_color: texture_storage_2d<rgba16float, write>;
@group(0) @binding(12) var spot_depth: texture_storage_2d<r32float, write>;
/// Sums of what sheets bring in front of the visible surface, or behind it.
@group(0) @binding(13) var sheet_sums: texture_2d<f32>;
@group(0) @binding(14) var seen: texture_2d<f32>;
@group(0) @binding(15) var new_behind: texture_storage_2d<rgba32float, write>;

struct SheetLayer {
    index: u32,
}

@group(0) @binding(16) var<uniform> sheet_layer: SheetLayer;

/// What one layer of sheets spreads: as much as those in front of it let through.
@compute @workgroup_size(8, 8)
fn take_sheets(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(spot_color)) {
        return;
    }
    let k = min(sheet_layer.index, 3u);
    var left = 1.0;
    for (var i = 0u; i < k; i++) {
        left *= 1.0 - textureLoad(sheet_color, id.xy, i, 0).a;
    }
    let z = textureLoad(sheet_depths, id.xy, 0)[k];
    textureStore(spot_color, id.xy, select(vec4f(0.0), left * textureLoad(sheet_color, id.xy, k, 0), z >= 0.0));
    textureStore(spot_depth, id.xy, vec4f(max(z, 0.0)));
}

/// Sheets over what lies behind them; where they overlap to more than 1, nothing shines through.
fn over_solid(sheets: vec4f, solid: vec4f) -> vec4f {
    return sheets / max(sheets.a, 1.0) + max(1.0 - sheets.a, 0.0) * solid;
}

@compute @workgroup_size(8, 8)
fn sheets_behind(@builtin(global_invocation_id) id: vec3u) {
    if all(id.xy < textureDimensions(new_behind)) {
        textureStore(new_behind, id.xy, over_solid(textureLoad(sheet_sums, id.xy, 0), textureLoad(layer_behind, id.xy, 0)));
    }
}

@compute @workgroup_size(8, 8)
fn sheets_in_front(@builtin(global_invocation_id) id: vec3u) {
    textureStore(result, id.xy, over_solid(textureLoad(sheet_sums, id.xy, 0), textureLoad(seen, id.xy, 0)));
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
