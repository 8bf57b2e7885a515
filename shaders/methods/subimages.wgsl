// The pyramidal blur of sub-images (src/methods/subimages.rs): the passes between levels.
//
// Strengert, Kraus and Ertl 2006 as Kraus 2011, section 4 uses it: analysis with a 4x4 box,
// synthesis towards a biquadratic B-spline. z of the grid is the layer.

#import subimages

struct Level {
    /// Number of the finer level of the two.
    finer: u32,
    _0: u32,
    _1: u32,
    _2: u32,
}

@group(0) @binding(0) var<uniform> sub_images: SubImages;
@group(0) @binding(1) var<uniform> level: Level;
/// Bit l is set if any pixel lies in the sub-image of layer l.
@group(0) @binding(2) var<storage, read> occupied: u32;
@group(0) @binding(3) var finer: texture_2d_array<f32>;
@group(0) @binding(4) var coarser: texture_storage_2d_array<COLOR_FORMAT, write>;
@group(0) @binding(5) var analysis: texture_2d_array<f32>;
@group(0) @binding(6) var finer_analysis: texture_2d_array<f32>;
@group(0) @binding(7) var blur: texture_2d_array<f32>;
@group(0) @binding(8) var glow: texture_2d_array<f32>;
@group(0) @binding(9) var finer_blur: texture_storage_2d_array<COLOR_FORMAT, write>;
@group(0) @binding(10) var finer_glow: texture_storage_2d_array<r32float, write>;

// ---- analysis ----

var<workgroup> blocks: array<vec4f, 256>;

@compute @workgroup_size(16, 16)
fn reduce(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let size = textureDimensions(coarser);
    let finer_size = textureDimensions(finer);
    let texel = BOXES * group.xy + local.xy;
    let is_here = is_occupied(occupied, group.z);
    if is_here {
        let b = texel_from_centre(texel, size);
        var sum = vec4f(0.0);
        for (var i = 0u; i < 4u; i++) {
            let at = texel_index(block_texel(b, i), finer_size);
            let inside = clamp(at, vec2i(0), vec2i(finer_size) - 1);
            if all(at == inside) || sub_images.transparent_border == 0u {
                sum += textureLoad(finer, inside, group.z, 0);
            }
        }
        blocks[index] = sum;
    }
    workgroupBarrier();
    if is_here && all(local.xy < vec2u(BOXES)) && all(texel < size) {
        let sum = blocks[index] + blocks[index + 1u] + blocks[index + BLOCKS] + blocks[index + BLOCKS + 1u];
        textureStore(coarser, texel, group.z, sum / 16.0);
    }
}

// ---- synthesis ----

@compute @workgroup_size(8, 8)
fn expand(@builtin(global_invocation_id) id: vec3u) {
    if !is_occupied(occupied, id.z) {
        return;
    }
    let size = textureDimensions(finer_blur);
    let b = block_from_centre(id.xy, size);
    let place = quad_place(b, textureDimensions(analysis));
    // The level at which synthesis starts is that of the analysis itself.
    var quad: Quad;
    if sub_images.order[id.z].x == level.finer + 1u {
        quad = quad_of(analysis, place, id.z);
    } else {
        quad = quad_of(blur, place, id.z);
    }
    for (var i = 0u; i < 4u; i++) {
        let at = texel_index(block_texel(b, i), size);
        if all(at >= vec2i(0)) && all(at < vec2i(size)) {
            textureStore(finer_blur, at, id.z, expanded(quad, i));
        }
    }
}

/// With the glow, equation (8): the transparencies of the expanded level and of the
/// analysis are multiplied, so that no opacity decreases.
@compute @workgroup_size(8, 8)
fn expand_with_glow(@builtin(global_invocation_id) id: vec3u) {
    if !is_occupied(occupied, id.z) {
        return;
    }
    let size = textureDimensions(finer_blur);
    let b = block_from_centre(id.xy, size);
    let place = quad_place(b, textureDimensions(analysis));
    var quad: Quad;
    var glow_quad: Quad;
    if sub_images.order[id.z].x == level.finer + 1u {
        quad = quad_of(analysis, place, id.z);
        glow_quad = opacities(quad);
    } else {
        quad = quad_of(blur, place, id.z);
        glow_quad = quad_of(glow, place, id.z);
    }
    for (var i = 0u; i < 4u; i++) {
        let at = texel_index(block_texel(b, i), size);
        if all(at >= vec2i(0)) && all(at < vec2i(size)) {
            let analysed = textureLoad(finer_analysis, at, id.z, 0).a;
            let opacity = 1.0 - (1.0 - expanded(glow_quad, i).r) * (1.0 - analysed);
            textureStore(finer_blur, at, id.z, expanded(quad, i));
            textureStore(finer_glow, at, id.z, vec4f(opacity));
        }
    }
}
