// mipmap as printed (src/methods/mipmap/passes.rs).
//
// Lee, Kim and Choi, TVCG 2009. Pyramid levels here are the paper's levels 1, 2, ...:
// the paper's level 0 is the pinhole image itself and is read where it is.
//
//   reduce_image, reduce_level   steps 2 and 3: level l texel p covers texels 2p and 2p + 1 of
//       level l - 1; the kernel of shaders/lib/mipmap.wgsl is applied texel by texel, so that
//       a texel is either refused or taken, never half of each
//   blur                         steps 4 and 5
//   explain                      the same, to look at
//
// blur texel = (c, sigma, rho): signed CoC px, DoB px, DoN px.

#import mipmap
#import sampling

@group(0) @binding(2) var color: texture_2d<f32>;
@group(0) @binding(3) var depth: texture_2d<f32>;
@group(0) @binding(4) var finer_color: texture_2d<f32>;
@group(0) @binding(5) var finer_blur: texture_2d<f32>;
@group(0) @binding(6) var coarser_color: texture_storage_2d<COLOR_FORMAT, write>;
@group(0) @binding(7) var coarser_blur: texture_storage_2d<rgba16float, write>;
@group(0) @binding(8) var color_pyramid: texture_2d<f32>;
/// The pyramid of (c, sigma, rho).
@group(0) @binding(9) var blur_pyramid: texture_2d<f32>;
@group(0) @binding(10) var linear_clamp: sampler;
@group(0) @binding(11) var result: texture_storage_2d<COLOR_FORMAT, write>;
@group(0) @binding(12) var explained: texture_storage_2d<rgba16float, write>;

// ---- steps 2 and 3: the pyramids ----

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

/// H = 0, equation (9): a background centre takes no colour that is sharper than itself.
fn refuses(centre: vec3f, sigma: f32) -> bool {
    return params.anisotropic != 0u && centre.x > 0.0 && centre.y > sigma + params.delta;
}

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
        let w = select(KERNEL[i % 4u] * KERNEL[i / 4u], 0.0, refuses(blur, texel.blur.y));
        color += w * texel.color;
        weight += w;
        // DoN, equation (10): the greatest DoB among foreground texels nearer than the
        // centre. Each level finds its own from the CoC and DoB of the level below: what a
        // finer level has found is not carried on, or one speck would mark the whole of the
        // coarsest level around it.
        let nearer = texel.blur.x < 0.0 && texel.blur.x < blur.x;
        rho = max(rho, select(0.0, texel.blur.y, nearer));
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

@compute @workgroup_size(8, 8)
fn reduce_image(@builtin(global_invocation_id) id: vec3u) {
    var texels: array<Texel, 16>;
    for (var i = 0; i < 16; i++) {
        texels[i] = level_0(2 * vec2i(id.xy) + vec2i(i % 4, i / 4) - 1);
    }
    store(id.xy, reduce(&texels));
}

@compute @workgroup_size(8, 8)
fn reduce_level(@builtin(global_invocation_id) id: vec3u) {
    var texels: array<Texel, 16>;
    for (var i = 0; i < 16; i++) {
        texels[i] = level_n(2 * vec2i(id.xy) + vec2i(i % 4, i / 4) - 1);
    }
    store(id.xy, reduce(&texels));
}

// ---- step 4: a level for a blur, and the smoothed DoB ----

/// Mipmap level m, continuous, that blurs as a DoB of `sigma` px does.
fn level_of_dob(sigma: f32) -> f32 {
    if params.measured == 0u {
        return level_as_printed(sigma);
    }
    let variance = pow(params.wanted_per_dob * sigma, 2.0);
    let first = variance_as_printed(1.0);
    if variance <= first {
        return variance / first;
    }
    // The blend of two levels has the blend of their variances.
    let l = max(1.0, floor(1.0 + 0.5 * log2((variance + 0.25) / (0.25 + BILINEAR_VARIANCE + 0.375))));
    let low = variance_as_printed(l);
    let high = variance_as_printed(l + 1.0);
    return l + clamp((variance - low) / (high - low), 0.0, 1.0);
}

/// Variance, px^2 per axis, of level l magnified by bilinear reads.
fn variance_magnified(l: f32) -> f32 {
    let texel2 = exp2(2.0 * l);
    return level_variance(texel2) + texel2 * BILINEAR_VARIANCE;
}

/// As `level_of_dob`, for levels that are magnified by bilinear reads.
fn magnified_level_of_dob(sigma: f32) -> f32 {
    if params.measured == 0u {
        return level_as_printed(sigma);
    }
    let variance = pow(params.wanted_per_dob * sigma, 2.0);
    let first = variance_magnified(1.0);
    if variance <= first {
        return variance / first;
    }
    let l = max(1.0, floor(0.5 * log2((variance + 0.25) / (0.25 + BILINEAR_VARIANCE))));
    let low = variance_magnified(l);
    return l + clamp((variance - low) / (variance_magnified(l + 1.0) - low), 0.0, 1.0);
}

/// Normalised coordinates in the pyramids of the level-0 position `at`, px.
fn pyramid_uv(at: vec2f) -> vec2f {
    return (at + vec2f(params.padding)) / (2.0 * vec2f(textureDimensions(blur_pyramid)));
}

/// (c, sigma, rho) of the pixel at `at`: the paper's level 0.
fn sharp_blur_at(at: vec2f) -> vec3f {
    let p = clamp_to_image(vec2i(floor(at)), textureDimensions(depth));
    let c = coc_diameter_px(lens, textureLoad(depth, p, 0).r);
    return vec3f(c, dob(c), 0.0);
}

fn blur_at(at: vec2f, level: f32) -> vec3f {
    if level < 1.0 {
        // Between the image and level 1.
        return mix(sharp_blur_at(at), textureSampleLevel(blur_pyramid, linear_clamp, pyramid_uv(at), 0.0).xyz, level);
    }
    return textureSampleLevel(blur_pyramid, linear_clamp, pyramid_uv(at), level - 1.0).xyz;
}

/// The nine offsets on the unit circle with the weights of a 3x3 Gaussian (Fig. 4b);
/// without `circular`, the paper's rectangular ones (Fig. 4a).
fn tap(i: u32) -> vec3f {
    let x = f32(i % 3u) - 1.0;
    let y = f32(i / 3u) - 1.0;
    let weight = (2.0 - abs(x)) * (2.0 - abs(y)) / 16.0;
    let shrink = select(1.0, SQRT_HALF, params.circular != 0u && x * y != 0.0);
    return vec3f(shrink * vec2f(x, y), weight);
}

/// The blur at `level`, read with the circular filter of one texel of that level. Of its nine
/// points five are those that are not diagonal, twice as heavy but for the one in the middle,
/// so that the weights are 1/2 there and 1/8 around it.
fn smooth_blur_at(at: vec2f, level: f32) -> vec3f {
    let radius = exp2(level);
    var sum = vec3f(0.0);
    if params.five_points != 0u {
        for (var i = 0u; i < 5u; i++) {
            let t = tap(select(2u * i - 1u, 4u, i == 0u));
            sum += select(0.125, 0.5, i == 0u) * blur_at(at + radius * t.xy, level);
        }
        return sum;
    }
    for (var i = 0u; i < 9u; i++) {
        let t = tap(i);
        sum += t.z * blur_at(at + radius * t.xy, level);
    }
    return sum;
}

/// The pixel's DoB, px, smoothed over the edges of the foreground. Equation (11): n is 0 for
/// background and focused pixels, whose rho is 0.
fn smoothed_dob(at: vec2f) -> f32 {
    if params.smoothing != 0u {
        let n = min(level_of_dob(smooth_blur_at(at, f32(params.levels)).z), f32(params.levels));
        if n > 0.0 {
            return smooth_blur_at(at, n).y;
        }
    }
    return sharp_blur_at(at).y;
}

// ---- step 5: colour ----

/// Bilinear read of the image.
fn image_at(at: vec2f) -> vec3f {
    let b = bilinear(at);
    let size = textureDimensions(color);
    var sum = vec3f(0.0);
    for (var i = 0; i < 4; i++) {
        let w = mix(1.0 - b.weight, b.weight, vec2f(vec2i(i & 1, i >> 1)));
        if w.x * w.y > 0.0 {
            sum += w.x * w.y * textureLoad(color, clamp_to_image(b.corner + vec2i(i & 1, i >> 1), size), 0).rgb;
        }
    }
    return sum;
}

/// Bilinear read of the image that leaves out the pixels that `centre` refuses; alpha is the
/// weight that is left.
fn accepted_image_at(at: vec2f, centre: vec3f) -> vec4f {
    let b = bilinear(at);
    let size = textureDimensions(color);
    var sum = vec4f(0.0);
    for (var i = 0; i < 4; i++) {
        let w = mix(1.0 - b.weight, b.weight, vec2f(vec2i(i & 1, i >> 1)));
        let p = clamp_to_image(b.corner + vec2i(i & 1, i >> 1), size);
        if w.x * w.y > 0.0 && !refuses(centre, dob(coc_diameter_px(lens, textureLoad(depth, p, 0).r))) {
            sum += w.x * w.y * vec4f(textureLoad(color, p, 0).rgb, 1.0);
        }
    }
    return sum;
}

/// The paper's level l (0 is the image) at a position; alpha is the weight that it has for
/// `centre`, equation (9).
fn accepted_at(at: vec2f, l: u32, centre: vec3f) -> vec4f {
    if l == 0u {
        return accepted_image_at(at, centre);
    }
    let uv = pyramid_uv(at);
    let level = f32(l - 1u);
    // Only where the centre can refuse anything.
    if params.anisotropic != 0u && centre.x > 0.0 && centre.y > params.delta {
        if refuses(centre, textureSampleLevel(blur_pyramid, linear_clamp, uv, level).y) {
            return vec4f(0.0);
        }
    }
    return vec4f(textureSampleLevel(color_pyramid, linear_clamp, uv, level).rgb, 1.0);
}

/// Below this level a pixel is left as it is: a lens with a CoC of IN_FOCUS_COC_PX
/// (src/methods/mod.rs) has a variance of (0.05 px / 4)^2, 0.0003 of the first level's.
const LEAST_LEVEL = 3e-4;

/// Equation (8): levels l-1 and l with l = floor(m), through the circular filter.
fn interpolate(at: vec2f, sigma: f32) -> vec3f {
    let top = f32(params.levels) + 0.999;
    let level = clamp(level_of_dob(sigma), 0.0, top);
    if level <= LEAST_LEVEL {
        return image_at(at);
    }
    let centre = vec3f(sharp_blur_at(at).x, sigma, 0.0);
    if params.bilinear != 0u {
        return magnified(at, min(magnified_level_of_dob(sigma), f32(params.levels)), centre);
    }
    if level < 1.0 {
        // Below the first level the filter fades in over the sharp image.
        return blend_levels(image_at(at), filtered(at, 0u, 0.0, 1.0, centre), level);
    }
    let l = u32(level);
    let beta = level - f32(l);
    // The radius whose square is the blend of the two levels' texels: then so is the
    // variance of the filter.
    let texel2 = exp2(2.0 * f32(l - 1u));
    return filtered(at, l - 1u, beta, sqrt(texel2 * (1.0 + 3.0 * beta)), centre);
}

/// Equation (7): levels l and l + 1 with l = floor(m), each by one bilinear read.
fn magnified(at: vec2f, level: f32, centre: vec3f) -> vec3f {
    let l = u32(level);
    let fine = accepted_at(at, l, centre);
    let coarse = accepted_at(at, l + 1u, centre);
    if fine.a + coarse.a <= 1e-6 {
        return image_at(at);
    }
    if fine.a <= 1e-6 {
        return coarse.rgb;
    }
    let beta = select(0.0, level - f32(l), coarse.a > 0.0);
    return blend_levels(fine.rgb / fine.a, coarse.rgb, beta);
}

/// The circular filter; equation (9) holds for what it reads, as the paper's section 4
/// replaces G of equation (8).
fn filtered(at: vec2f, l: u32, beta: f32, radius: f32, centre: vec3f) -> vec3f {
    var sum = vec3f(0.0);
    var weight = 0.0;
    for (var i = 0u; i < 9u; i++) {
        let t = tap(i);
        let p = at + radius * t.xy;
        let fine = accepted_at(p, l, centre);
        var c = fine.rgb / max(fine.a, 1e-6);
        var w = fine.a;
        if beta > 0.0 {
            let coarse = accepted_at(p, l + 1u, centre);
            c = select(coarse.rgb, blend_levels(c, coarse.rgb, select(0.0, beta, coarse.a > 0.0)), fine.a > 0.0);
            w = max(fine.a, coarse.a);
        }
        sum += t.z * w * c;
        weight += t.z * w;
    }
    return select(image_at(at), sum / max(weight, 1e-6), weight > 1e-6);
}

/// The centre of a pixel of the inner frame in the outer one.
fn centre_of(pixel: vec2u) -> vec2f {
    return vec2f(pixel) + 0.5 + f32(params.overscan);
}

@compute @workgroup_size(8, 8)
fn blur(@builtin(global_invocation_id) id: vec3u) {
    let at = centre_of(id.xy);
    textureStore(result, id.xy, vec4f(interpolate(at, smoothed_dob(at)), 1.0));
}

/// (c, DoB, DoB that is used, px; the level that is read for it).
@compute @workgroup_size(8, 8)
fn explain(@builtin(global_invocation_id) id: vec3u) {
    let at = centre_of(id.xy);
    let sigma = smoothed_dob(at);
    let level = clamp(level_of_dob(sigma), 0.0, f32(params.levels) + 0.999);
    textureStore(explained, id.xy, vec4f(sharp_blur_at(at).xy, sigma, level));
}
