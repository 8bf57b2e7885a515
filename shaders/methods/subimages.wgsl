// The pyramidal blur of sub-images (src/methods/subimages.rs): the passes between levels.
//
// Strengert, Kraus and Ertl 2006 as Kraus 2011, section 4 uses it: analysis with a 4x4 box,
// synthesis towards a biquadratic B-spline. z of the grid is the layer.

#import lens
#import sampling
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
@group(0) @binding(3) var<storage, read_write> occupied_out: atomic<u32>;
@group(0) @binding(4) var<uniform> lens: Lens;
@group(0) @binding(5) var depth: texture_2d<f32>;
@group(0) @binding(6) var finer: texture_2d_array<f32>;
@group(0) @binding(7) var coarser: texture_storage_2d_array<COLOR_FORMAT, write>;
@group(0) @binding(8) var analysis: texture_2d_array<f32>;
@group(0) @binding(9) var finer_analysis: texture_2d_array<f32>;
@group(0) @binding(10) var blur: texture_2d_array<f32>;
@group(0) @binding(11) var glow: texture_2d_array<f32>;
@group(0) @binding(12) var finer_blur: texture_storage_2d_array<COLOR_FORMAT, write>;
@group(0) @binding(13) var finer_glow: texture_storage_2d_array<r32float, write>;

// ---- which sub-images are empty ----

var<workgroup> found: atomic<u32>;

@compute @workgroup_size(8, 8)
fn occupancy(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) thread: u32) {
    let size = textureDimensions(depth);
    var bits = 0u;
    // 4x4 pixels an invocation.
    for (var i = 0u; i < 16u; i++) {
        let p = 4u * id.xy + vec2u(i % 4u, i / 4u);
        if all(p < size) {
            let x = ramp_variable(sub_images.variance_ramps, lens, textureLoad(depth, p, 0).r);
            for (var layer = 0u; layer < sub_images.count; layer++) {
                let ramps = sub_images.ramps[layer];
                bits |= select(0u, 1u << layer, x > ramps.x && x < ramps.w);
            }
        }
    }
    atomicOr(&found, bits);
    workgroupBarrier();
    if thread == 0u {
        atomicOr(&occupied_out, atomicLoad(&found));
    }
}

// ---- analysis ----

@compute @workgroup_size(8, 8)
fn reduce(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(coarser);
    if any(id.xy >= size) || !is_occupied(occupied, id.z) {
        return;
    }
    let p = texel_from_centre(id.xy, size);
    let finer_size = textureDimensions(finer);
    var sum = vec4f(0.0);
    for (var i = 0; i < 16; i++) {
        let at = texel_index(box_texel(p, i), finer_size);
        let inside = clamp_to_image(at, finer_size);
        if all(at == inside) || sub_images.transparent_border == 0u {
            sum += textureLoad(finer, inside, id.z, 0);
        }
    }
    textureStore(coarser, id.xy, id.z, sum / 16.0);
}

// ---- synthesis ----

/// The coarser level, expanded to texel p of the finer: the blur's colour and opacity.
fn expanded_blur(p: vec2i, layer: u32) -> vec4f {
    let size = textureDimensions(analysis);
    // The level at which synthesis starts is that of the analysis itself.
    let starts = sub_images.order[layer].x == level.finer + 1u;
    var sum = vec4f(0.0);
    for (var i = 0; i < 4; i++) {
        let n = neighbour(p, i);
        let at = clamp_to_image(texel_index(n.at, size), size);
        if starts {
            sum += n.weight * textureLoad(analysis, at, layer, 0);
        } else {
            sum += n.weight * textureLoad(blur, at, layer, 0);
        }
    }
    return sum;
}

/// The same of the glow's opacity.
fn expanded_glow(p: vec2i, layer: u32) -> f32 {
    let size = textureDimensions(analysis);
    let starts = sub_images.order[layer].x == level.finer + 1u;
    var sum = 0.0;
    for (var i = 0; i < 4; i++) {
        let n = neighbour(p, i);
        let at = clamp_to_image(texel_index(n.at, size), size);
        if starts {
            sum += n.weight * textureLoad(analysis, at, layer, 0).a;
        } else {
            sum += n.weight * textureLoad(glow, at, layer, 0).r;
        }
    }
    return sum;
}

@compute @workgroup_size(8, 8)
fn expand(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(finer_blur);
    if any(id.xy >= size) || !is_occupied(occupied, id.z) {
        return;
    }
    let p = texel_from_centre(id.xy, size);
    textureStore(finer_blur, id.xy, id.z, expanded_blur(p, id.z));
}

/// With the glow, equation (8): the transparencies of the expanded level and of the
/// analysis are multiplied, so that no opacity decreases.
@compute @workgroup_size(8, 8)
fn expand_with_glow(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(finer_blur);
    if any(id.xy >= size) || !is_occupied(occupied, id.z) {
        return;
    }
    let p = texel_from_centre(id.xy, size);
    textureStore(finer_blur, id.xy, id.z, expanded_blur(p, id.z));
    let analysed = textureLoad(finer_analysis, id.xy, id.z, 0).a;
    let opacity = 1.0 - (1.0 - expanded_glow(p, id.z)) * (1.0 - analysed);
    textureStore(finer_glow, id.xy, id.z, vec4f(opacity));
}
