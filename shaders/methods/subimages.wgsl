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

/// Loads what the tile of the finer level that begins at p lies between.
fn load_around(first: vec2i, layer: u32, index: u32) {
    if index >= AROUND * AROUND {
        return;
    }
    let at = around_texel(first, index, textureDimensions(analysis));
    // The level at which synthesis starts is that of the analysis itself.
    if sub_images.order[layer].x == level.finer + 1u {
        around_colors[index] = textureLoad(analysis, at, layer, 0);
    } else {
        around_colors[index] = textureLoad(blur, at, layer, 0);
    }
}

@compute @workgroup_size(16, 16)
fn expand(
    @builtin(workgroup_id) group: vec3u,
    @builtin(global_invocation_id) id: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let size = textureDimensions(finer_blur);
    let first = first_around(texel_from_centre(TILE * group.xy, size));
    let is_here = is_occupied(occupied, group.z);
    if is_here {
        load_around(first, group.z, index);
    }
    workgroupBarrier();
    if is_here && all(id.xy < size) {
        textureStore(finer_blur, id.xy, id.z, expanded_color(place_in(first, texel_from_centre(id.xy, size))));
    }
}

/// With the glow, equation (8): the transparencies of the expanded level and of the
/// analysis are multiplied, so that no opacity decreases.
@compute @workgroup_size(16, 16)
fn expand_with_glow(
    @builtin(workgroup_id) group: vec3u,
    @builtin(global_invocation_id) id: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let size = textureDimensions(finer_blur);
    let first = first_around(texel_from_centre(TILE * group.xy, size));
    let is_here = is_occupied(occupied, group.z);
    if is_here {
        load_around(first, group.z, index);
        if index < AROUND * AROUND {
            // Where synthesis starts the glow is the opacity itself.
            let glow_here = textureLoad(glow, around_texel(first, index, textureDimensions(analysis)), group.z, 0).r;
            let starts = sub_images.order[group.z].x == level.finer + 1u;
            around_numbers[index] = select(glow_here, around_colors[index].a, starts);
        }
    }
    workgroupBarrier();
    if is_here && all(id.xy < size) {
        let place = place_in(first, texel_from_centre(id.xy, size));
        let analysed = textureLoad(finer_analysis, id.xy, id.z, 0).a;
        let opacity = 1.0 - (1.0 - expanded_number(place)) * (1.0 - analysed);
        textureStore(finer_blur, id.xy, id.z, expanded_color(place));
        textureStore(finer_glow, id.xy, id.z, vec4f(opacity));
    }
}
