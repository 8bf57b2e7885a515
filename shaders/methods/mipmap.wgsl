// mipmap: anisotropically filtered mipmap interpolation, the pyramids
// (src/methods/mipmap.rs; what pixels read of them is in mipmap_read.wgsl).
//
// Lee, Kim and Choi, TVCG 2009. Pyramid levels here are the paper's levels 1, 2, ...:
// the paper's level 0 is the pinhole image itself and is read where it is.
//
//   level l texel p covers texels 2p and 2p+1 of level l-1; the paper's 3x3 Gaussian, read
//   with the hardware's bilinear filter at the corner between them, is the 4x4 kernel
//   [1 3 3 1] x [1 3 3 1] / 64, which is applied texel by texel so that a texel is either
//   refused or taken, never half of each.
//
// blur texel = (c, sigma, rho): signed CoC px, DoB px, DoN px.

#import mipmap
#import sampling
#import tile_lists

@group(0) @binding(2) var color: texture_2d<f32>;
@group(0) @binding(3) var depth: texture_2d<f32>;
@group(0) @binding(4) var finer_color: texture_2d<f32>;
@group(0) @binding(5) var finer_blur: texture_2d<f32>;
@group(0) @binding(6) var coarser_color: texture_storage_2d<COLOR_FORMAT, write>;
@group(0) @binding(7) var coarser_blur: texture_storage_2d<rgba16float, write>;
/// Colour through the narrow and the wide disc.
@group(0) @binding(8) var new_discs: texture_storage_2d_array<COLOR_FORMAT, write>;
@group(0) @binding(9) var new_blur: texture_storage_2d<rgba16float, write>;
@group(0) @binding(10) var linear_clamp: sampler;

struct Texel {
    color: vec3f,
    /// c, sigma, rho
    blur: vec3f,
}

fn level_0(at: vec2i) -> Texel {
    let p = clamp_to_image(at - params.padding, textureDimensions(depth));
    let c = coc_diameter_px(lens, textureLoad(depth, p, 0).r);
    return Texel(textureLoad(color, p, 0).rgb, vec3f(c, dob(c), 0.0));
}

fn level_n(at: vec2i) -> Texel {
    let p = clamp_to_image(at, textureDimensions(finer_blur));
    return Texel(textureLoad(finer_color, p, 0).rgb, textureLoad(finer_blur, p, 0).xyz);
}

const KERNEL = array<f32, 4>(0.125, 0.375, 0.375, 0.125);

/// One texel of the next level from the 4x4 texels around its centre.
fn reduce(texels: ptr<function, array<Texel, 16>>) -> Texel {
    var blur = vec3f(0.0);
    for (var i = 0u; i < 16u; i++) {
        blur += KERNEL[i % 4u] * KERNEL[i / 4u] * (*texels)[i].blur;
    }
    var color = vec3f(0.0);
    var weight = 0.0;
    var rho = 0.0;
    for (var i = 0u; i < 16u; i++) {
        let texel = (*texels)[i];
        // H, equation (9): a background centre takes no colour that is sharper than itself.
        let refused = params.anisotropic != 0u && blur.x > 0.0 && blur.y > texel.blur.y + params.delta;
        let w = select(KERNEL[i % 4u] * KERNEL[i / 4u], 0.0, refused);
        color += w * texel.color;
        weight += w;
        // DoN, equation (10): the greatest DoB among foreground texels nearer than the
        // centre; what lower levels have found is carried on.
        let nearer = texel.blur.x < 0.0 && texel.blur.x < blur.x;
        rho = max(rho, max(texel.blur.z, select(0.0, texel.blur.y, nearer)));
    }
    // A centre cannot be blurrier than all of its texels, so some weight is left; but if
    // delta is negative there may be none.
    if weight < 1e-6 {
        color = vec3f(0.0);
        for (var i = 0u; i < 16u; i++) {
            color += KERNEL[i % 4u] * KERNEL[i / 4u] * (*texels)[i].color;
        }
        weight = 1.0;
    }
    return Texel(color / weight, vec3f(blur.xy, rho));
}

fn store(at: vec2u, texel: Texel) {
    textureStore(coarser_color, at, vec4f(texel.color, 1.0));
    textureStore(coarser_blur, at, vec4f(texel.blur, 0.0));
}

/// The texel of an invocation; beyond the image in blocks that reach over its border, where
/// nothing is stored.
fn listed_texel(group: vec3u, local: vec3u) -> vec2u {
    return listed_tile(group) * TILE + local.xy;
}

@compute @workgroup_size(8, 8)
fn reduce_image(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let id = listed_texel(group, local);
    var texels: array<Texel, 16>;
    for (var i = 0; i < 16; i++) {
        texels[i] = level_0(2 * vec2i(id) + vec2i(i % 4, i / 4) - 1);
    }
    store(id, reduce(&texels));
}

@compute @workgroup_size(8, 8)
fn reduce_level(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let id = listed_texel(group, local);
    var texels: array<Texel, 16>;
    for (var i = 0; i < 16; i++) {
        texels[i] = level_n(2 * vec2i(id) + vec2i(i % 4, i / 4) - 1);
    }
    store(id, reduce(&texels));
}

// Where everything around is in focus, hardly anything reads the levels: one read will do.

fn mean_of_four(image: texture_2d<f32>, corner: vec2f) -> Texel {
    let uv = corner / vec2f(textureDimensions(image));
    return Texel(textureSampleLevel(image, linear_clamp, uv, 0.0).rgb, vec3f(0.0));
}

@compute @workgroup_size(8, 8)
fn halve_image(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let id = listed_texel(group, local);
    store(id, mean_of_four(color, vec2f(2 * vec2i(id) + 1 - params.padding)));
}

@compute @workgroup_size(8, 8)
fn halve_level(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let id = listed_texel(group, local);
    store(id, mean_of_four(finer_color, vec2f(2u * id + 1u)));
}

@compute @workgroup_size(8, 8)
fn keep_level(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let id = listed_texel(group, local);
    let texel = level_n(vec2i(id));
    store_filtered(id, texel.color, texel.color, texel.blur);
}

fn store_filtered(at: vec2u, narrow: vec3f, wide: vec3f, blur: vec3f) {
    textureStore(new_discs, at, 0, vec4f(narrow, 1.0));
    textureStore(new_discs, at, 1, vec4f(wide, 1.0));
    textureStore(new_blur, at, vec4f(blur, 0.0));
}

/// Texels of one level through the narrow and the wide disc, and their blur through the
/// narrow one: read between texels, that is the image through discs of all diameters.
@compute @workgroup_size(8, 8)
fn filter_level(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let id = listed_texel(group, local);
    var narrow = vec3f(0.0);
    var wide = vec3f(0.0);
    var blur = vec3f(0.0);
    let size = textureDimensions(finer_color);
    for (var i = 0u; i < NEIGHBOURS; i++) {
        let w = disc_weights(i);
        if w.z > 0.0 {
            let c = textureLoad(finer_color, clamp_to_image(vec2i(id) + neighbour(i), size), 0).rgb;
            narrow += w.y * c;
            wide += w.z * c;
        }
    }
    if params.smoothing != 0u {
        for (var i = 0; i < 9; i++) {
            let offset = vec2i(i % 3, i / 3) - 1;
            let w = disc_weights(u32(12 + offset.x + 5 * offset.y)).y;
            blur += w * textureLoad(finer_blur, clamp_to_image(vec2i(id) + offset, size), 0).xyz;
        }
    }
    store_filtered(id, narrow, wide, blur);
}
