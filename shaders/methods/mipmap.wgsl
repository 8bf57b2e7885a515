// mipmap: anisotropically filtered mipmap interpolation (src/methods/mipmap.rs).
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

#import lens
#import sampling

struct Params {
    /// DoB over CoC diameter: the paper's 1/2.
    sigma_per_coc: f32,
    /// Level calibration "paper": m = 1 + log2(k * sigma).
    k: f32,
    /// How much blurrier, px of sigma, a background texel must be to refuse another.
    delta: f32,
    /// 1: equation (8) as printed, geometric; 0: as in section 6, arithmetic.
    geometric: u32,
    /// 1: level from the pyramid's measured second moment; 0: the paper's k.
    measured: u32,
    /// Standard deviation that is wanted, over DoB: the lens's own over sigma_per_coc.
    wanted_per_dob: f32,
    anisotropic: u32,
    circular: u32,
    /// Level-0 texels left of and above the image in the pyramid's padded frame.
    padding: vec2i,
    /// Number of levels in the pyramid: the paper's M.
    levels: u32,
    /// Overscan, px.
    overscan: u32,
}

@group(0) @binding(0) var<uniform> lens: Lens;
@group(0) @binding(1) var<uniform> params: Params;
@group(0) @binding(2) var color: texture_2d<f32>;
@group(0) @binding(3) var depth: texture_2d<f32>;
@group(0) @binding(4) var finer_color: texture_2d<f32>;
@group(0) @binding(5) var finer_blur: texture_2d<f32>;
@group(0) @binding(6) var coarser_color: texture_storage_2d<COLOR_FORMAT, write>;
@group(0) @binding(7) var coarser_blur: texture_storage_2d<rgba16float, write>;
@group(0) @binding(8) var color_pyramid: texture_2d<f32>;
@group(0) @binding(9) var blur_pyramid: texture_2d<f32>;
@group(0) @binding(10) var linear_clamp: sampler;
@group(0) @binding(11) var result: texture_storage_2d<COLOR_FORMAT, write>;

/// DoB, px, of a signed CoC.
fn dob(c: f32) -> f32 {
    return params.sigma_per_coc * abs(c);
}

// ---- steps 1 and 2: the pyramids ----

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

// ---- step 3: a level for a blur ----

/// Variance, px^2 per axis, of what `interpolate` does at the integer level l >= 1: l - 1
/// reductions (0.75 texel^2 each, geometric sum), the bilinear read of level l - 1 (1/6
/// texel^2 on average over its phases) and the circular filter (3/8 texel^2).
fn level_variance(l: f32) -> f32 {
    if l < 1.5 {
        // Level 0 is read at pixel centres: only the diagonal offsets fall between texels.
        return 0.375 + 0.25 * SQRT_HALF * (1.0 - SQRT_HALF);
    }
    let texel2 = exp2(2.0 * (l - 1.0));
    return 0.25 * (texel2 - 1.0) + texel2 * (1.0 / 6.0 + 0.375);
}

const SQRT_HALF = 0.70710678;

/// Mipmap level m, continuous, that blurs as a DoB of `sigma` px does.
fn level_of_dob(sigma: f32) -> f32 {
    if params.measured == 0u {
        // Equation (6).
        return select(0.0, 1.0 + log2(params.k * sigma), params.k * sigma >= 0.5);
    }
    let variance = pow(params.wanted_per_dob * sigma, 2.0);
    let first = level_variance(1.0);
    if variance <= first {
        return variance / first;
    }
    // The blend of two levels has the blend of their variances.
    var l = max(1.0, floor(1.0 + 0.5 * log2((variance + 0.25) / (0.25 + 1.0 / 6.0 + 0.375))));
    let low = level_variance(l);
    let high = level_variance(l + 1.0);
    return l + clamp((variance - low) / (high - low), 0.0, 1.0);
}

// ---- steps 4 and 5: reading the pyramids ----

/// Normalised coordinates in the pyramids of the level-0 position `at`, px.
fn pyramid_uv(at: vec2f) -> vec2f {
    return (at + vec2f(params.padding)) / (2.0 * vec2f(textureDimensions(color_pyramid)));
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

fn blur_at(at: vec2f, level: f32) -> vec3f {
    if level < 1.0 {
        // Between the image and level 1.
        let p = clamp_to_image(vec2i(floor(at)), textureDimensions(depth));
        let c = coc_diameter_px(lens, textureLoad(depth, p, 0).r);
        let sharp = vec3f(c, dob(c), 0.0);
        return mix(sharp, textureSampleLevel(blur_pyramid, linear_clamp, pyramid_uv(at), 0.0).xyz, level);
    }
    return textureSampleLevel(blur_pyramid, linear_clamp, pyramid_uv(at), level - 1.0).xyz;
}

/// The blur at `level`, read with the circular filter of one texel of that level.
fn smooth_blur_at(at: vec2f, level: f32) -> vec3f {
    let radius = exp2(level);
    var sum = vec3f(0.0);
    for (var i = 0u; i < 9u; i++) {
        let t = tap(i);
        sum += t.z * blur_at(at + radius * t.xy, level);
    }
    return sum;
}

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

/// The paper's level l (0 is the image) at a position.
fn color_at(at: vec2f, l: u32) -> vec3f {
    if l == 0u {
        return image_at(at);
    }
    return textureSampleLevel(color_pyramid, linear_clamp, pyramid_uv(at), f32(l - 1u)).rgb;
}

fn blend_levels(fine: vec3f, coarse: vec3f, beta: f32) -> vec3f {
    if params.geometric != 0u {
        // Equation (8). pow(0, 0) is undefined in WGSL, hence the floor, far below f16.
        let least = vec3f(1e-12);
        return pow(max(fine, least), vec3f(1.0 - beta)) * pow(max(coarse, least), vec3f(beta));
    }
    return mix(fine, coarse, beta);
}

/// Below this level a pixel is left as it is: a lens with a CoC of IN_FOCUS_COC_PX
/// (src/methods/mod.rs) has a variance of (0.05 px / 4)^2, 0.0003 of the first level's.
const LEAST_LEVEL = 3e-4;

/// Equation (8): levels l-1 and l with l = floor(m), through the circular filter.
fn interpolate(at: vec2f, m: f32) -> vec3f {
    let top = f32(params.levels) + 0.999;
    let level = clamp(m, 0.0, top);
    if level < 1.0 {
        // Below the first level the filter fades in over the sharp image.
        if level <= LEAST_LEVEL {
            return image_at(at);
        }
        return blend_levels(image_at(at), filtered(at, 0u, 0.0, 1.0), level);
    }
    let l = u32(level);
    let beta = level - f32(l);
    // The radius whose square is the blend of the two levels' texels: then so is the
    // variance of the filter.
    let texel2 = exp2(2.0 * f32(l - 1u));
    return filtered(at, l - 1u, beta, sqrt(texel2 * (1.0 + 3.0 * beta)));
}

fn filtered(at: vec2f, l: u32, beta: f32, radius: f32) -> vec3f {
    var sum = vec3f(0.0);
    for (var i = 0u; i < 9u; i++) {
        let t = tap(i);
        let p = at + radius * t.xy;
        var c = color_at(p, l);
        if beta > 0.0 {
            c = blend_levels(c, color_at(p, l + 1u), beta);
        }
        sum += t.z * c;
    }
    return sum;
}

@compute @workgroup_size(8, 8)
fn interpolate_sharp(@builtin(global_invocation_id) id: vec3u) {
    let at = vec2f(id.xy) + 0.5 + f32(params.overscan);
    let sigma = blur_at(at, 0.0).y;
    textureStore(result, id.xy, vec4f(interpolate(at, level_of_dob(sigma)), 1.0));
}

/// Pixels on a side of a workgroup.
const TILE = 8;

/// Texels of the top level that the circular filter reads from a tile, on a side: where
/// they are smallest, 2 px, the tile is 4 wide, the filter reaches 1 to either side and
/// the bilinear reads one more.
const TOP_SIDE = 9;

/// The top level's DoN around the tile.
var<workgroup> top_rho: array<f32, 81>;

/// Whether any of it is not 0.
var<workgroup> some_rho: atomic<u32>;

/// Position in texels of the top level, from the centre of its first.
fn top_texels(at: vec2f) -> vec2f {
    return (at + vec2f(params.padding)) * exp2(-f32(params.levels)) - 0.5;
}

/// First texel of the top level that a tile beginning at `corner`, px, reads.
fn first_top_texel(corner: vec2f) -> vec2i {
    return vec2i(floor(top_texels(corner + 0.5) - 1.0));
}

fn load_top_rho(first: vec2i, index: i32) {
    let texel = clamp_to_image(first + vec2i(index % TOP_SIDE, index / TOP_SIDE), textureDimensions(blur_pyramid, params.levels - 1u));
    let rho = textureLoad(blur_pyramid, texel, params.levels - 1u).z;
    top_rho[index] = rho;
    if rho > 0.0 {
        atomicOr(&some_rho, 1u);
    }
}

/// The top level's DoN through the circular filter: as `smooth_blur_at`, from what the tile
/// has read.
fn smooth_top_rho(at: vec2f, first: vec2i) -> f32 {
    let centre = top_texels(at) - vec2f(first);
    var sum = 0.0;
    for (var i = 0u; i < 9u; i++) {
        let t = tap(i);
        let p = centre + t.xy;
        let corner = vec2i(floor(p));
        let w = p - floor(p);
        let index = corner.y * TOP_SIDE + corner.x;
        let upper = mix(top_rho[index], top_rho[index + 1], w.x);
        let lower = mix(top_rho[index + TOP_SIDE], top_rho[index + TOP_SIDE + 1], w.x);
        sum += t.z * mix(upper, lower, w.y);
    }
    return sum;
}

/// As above, with the DoB of foreground and its surroundings smoothed (section 5).
@compute @workgroup_size(8, 8)
fn interpolate_smoothed(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let first = first_top_texel(vec2f(group.xy * u32(TILE)) + f32(params.overscan));
    load_top_rho(first, i32(local));
    if local < 17u {
        load_top_rho(first, 64 + i32(local));
    }
    workgroupBarrier();
    let at = vec2f(id.xy) + 0.5 + f32(params.overscan);
    var sigma = blur_at(at, 0.0).y;
    if atomicLoad(&some_rho) != 0u {
        // Equation (11): 0 for background and focused pixels, whose rho is 0.
        let n = min(level_of_dob(smooth_top_rho(at, first)), f32(params.levels));
        if n > 0.0 {
            sigma = smooth_blur_at(at, n).y;
        }
    }
    textureStore(result, id.xy, vec4f(interpolate(at, level_of_dob(sigma)), 1.0));
}
