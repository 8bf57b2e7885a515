// mipmap: steps 3 to 5, what pixels read of the pyramids (src/methods/mipmap.rs).
//
//   classify_tiles   the blur of each pixel; which 8x8 tiles are in focus, which read levels
//                    only, which are near blurred foreground
//   smooth_tiles     the blur in the last of these, smoothed over the foreground's edges
//   blur_near        any blur, from the image and its levels
//   blur_far         blur so wide that all of it comes from levels
//   blur_as_printed  every pixel, with the circular filter around each
//
// A compute pass costs what the longest path through it costs wherever pixels of one group
// part ways, and on software adapters everywhere: hence a pass for each kind of tile.

#import mipmap
#import sampling
#import tile_lists

@group(0) @binding(2) var color: texture_2d<f32>;
@group(0) @binding(3) var depth: texture_2d<f32>;
@group(0) @binding(4) var color_pyramid: texture_2d<f32>;
/// The pyramid of (c, sigma, rho); through the narrow disc but for `blur_as_printed`.
@group(0) @binding(5) var blur_pyramid: texture_2d<f32>;
/// The pyramid of colour through the narrow and the wide disc.
@group(0) @binding(6) var disc_pyramid: texture_2d_array<f32>;
@group(0) @binding(7) var linear_clamp: sampler;
@group(0) @binding(8) var result: texture_storage_2d<COLOR_FORMAT, write>;
/// With which a pixel is to be blurred, px^2 per axis.
@group(0) @binding(9) var new_variance: texture_storage_2d<r32float, write>;
@group(0) @binding(10) var variance: texture_2d<f32>;
@group(0) @binding(11) var explained: texture_storage_2d<rgba16float, write>;

/// Classes of tiles beside IN_FOCUS.
const NEAR = 1u;
const FAR = 2u;
const SMOOTHED = 3u;

// ---- step 3: a level for a blur ----

/// Variance, texel^2 per axis, that reading a level by a bilinear filter adds, on average
/// over its phases.
const BILINEAR_VARIANCE = 1.0 / 6.0;

/// Variance, px^2 per axis, of level l: of l reductions, 0.75 texel^2 each (geometric sum).
fn level_variance(texel2: f32) -> f32 {
    return 0.25 * (texel2 - 1.0);
}

/// Variance, px^2 per axis, of what the circular filter does at the integer level m >= 1:
/// that of level m - 1, of the bilinear read and of the filter, 3/8 texel^2.
fn variance_as_printed(m: f32) -> f32 {
    if m < 1.5 {
        // Level 0 is read at pixel centres: only the diagonal offsets fall between texels.
        return 0.375 + 0.25 * SQRT_HALF * (1.0 - SQRT_HALF);
    }
    let texel2 = exp2(2.0 * (m - 1.0));
    return level_variance(texel2) + texel2 * (BILINEAR_VARIANCE + 0.375);
}

const SQRT_HALF = 0.70710678;

/// The paper's level of a DoB of `sigma` px, equation (6).
fn level_as_printed(sigma: f32) -> f32 {
    return select(0.0, 1.0 + log2(params.k * sigma), params.k * sigma >= 0.5);
}

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

/// Variance, px^2 per axis, with which a DoB of `sigma` px is to be blurred.
fn variance_of_dob(sigma: f32) -> f32 {
    if params.measured != 0u {
        return pow(params.wanted_per_dob * sigma, 2.0);
    }
    let m = level_as_printed(sigma);
    if m < 1.0 {
        return m * variance_as_printed(1.0);
    }
    return mix(variance_as_printed(floor(m)), variance_as_printed(floor(m) + 1.0), fract(m));
}

// ---- reading the pyramids ----

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

// ---- steps 4 and 5 by discs ----

/// Variance, px^2 per axis, of level l (of the paper) through disc 1 (narrow) or 2 (wide).
fn disc_variance(l: f32, disc: u32) -> f32 {
    let texel2 = exp2(2.0 * l);
    return level_variance(texel2) + texel2 * (BILINEAR_VARIANCE + params.disc_variance[disc]);
}

/// A disc on a level, as `disc_pyramid` has it.
struct Node {
    /// The paper's level.
    level: f32,
    /// 0 narrow, 1 wide.
    wide: u32,
}

fn read_node(uv: vec2f, node: Node) -> vec3f {
    return textureSampleLevel(disc_pyramid, linear_clamp, uv, node.wide, min(node.level, f32(params.levels)) - 1.0).rgb;
}

/// The paper's level, continuous, whose narrow disc has the given variance, px^2.
fn level_of_variance(wanted: f32) -> f32 {
    return 0.5 * log2((wanted + 0.25) / (0.25 + BILINEAR_VARIANCE + params.disc_variance.y));
}

/// The image at `at` through a disc of the given variance, at least that of the first node:
/// the two nearest discs blended, of diameters 1 : sqrt(2).
fn between_nodes(at: vec2f, wanted: f32) -> vec3f {
    let level = max(1.0, floor(level_of_variance(wanted)));
    let narrow = disc_variance(level, 1u);
    let wide = disc_variance(level, 2u);
    let wider = wanted >= wide;
    let low = select(narrow, wide, wider);
    let high = select(wide, disc_variance(level + 1.0, 1u), wider);
    let uv = pyramid_uv(at);
    let fine = read_node(uv, Node(level, u32(wider)));
    let coarse = read_node(uv, Node(level + f32(wider), 1u - u32(wider)));
    return blend_levels(fine, coarse, clamp((wanted - low) / (high - low), 0.0, 1.0));
}

/// As above for any variance. Below the first node the discs are drawn on the image.
fn disc_at(at: vec2f, wanted: f32) -> vec3f {
    var discs = array<vec3f, 3>(vec3f(0.0), vec3f(0.0), vec3f(0.0));
    let centre = vec2i(floor(at));
    let size = textureDimensions(color);
    for (var i = 0u; i < NEIGHBOURS; i++) {
        let w = disc_weights(i);
        if w.z > 0.0 {
            let c = textureLoad(color, clamp_to_image(centre + neighbour(i), size), 0).rgb;
            discs[0] += w.x * c;
            discs[1] += w.y * c;
            discs[2] += w.z * c;
        }
    }
    let known = params.disc_variance;
    let first = disc_variance(1.0, 1u);
    let coarse = between_nodes(at, max(wanted, first));
    if wanted <= known.x {
        let sharp = textureLoad(color, clamp_to_image(centre, size), 0).rgb;
        return blend_levels(sharp, discs[0], wanted / known.x);
    }
    if wanted <= known.y {
        return blend_levels(discs[0], discs[1], (wanted - known.x) / (known.y - known.x));
    }
    if wanted <= known.z {
        return blend_levels(discs[1], discs[2], (wanted - known.y) / (known.z - known.y));
    }
    return blend_levels(discs[2], coarse, min((wanted - known.z) / (first - known.z), 1.0));
}

/// The pixel's DoB, px, smoothed over the edges of the foreground. Equation (11): n is 0 for
/// background and focused pixels, whose rho is 0.
fn smoothed_dob(at: vec2f) -> f32 {
    let n = min(level_of_dob(blur_at(at, f32(params.levels)).z), f32(params.levels));
    return blur_at(at, n).y;
}

/// Position in texels of the top level, from the centre of its first.
fn top_texels(at: vec2f) -> vec2f {
    return (at + vec2f(params.padding)) * exp2(-f32(params.levels)) - 0.5;
}

/// Of the tiles of a row of eight: whether there is a pixel out of focus, one whose blur is
/// too narrow for levels alone, and DoN.
var<workgroup> defocused: array<atomic<u32>, 8>;
var<workgroup> near: array<atomic<u32>, 8>;
var<workgroup> some_rho: array<atomic<u32>, 8>;

/// Each row of invocations looks at one tile, a column of pixels each.
@compute @workgroup_size(8, 8)
fn classify_tiles(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let tile = vec2u(TILE * group.x + local.y, group.y);
    let corner = tile * TILE + params.overscan;
    var greatest = 0.0;
    var least = 1e30;
    for (var y = 0u; y < TILE; y++) {
        let p = clamp_to_image(vec2i(corner + vec2u(local.x, y)), textureDimensions(depth));
        let sigma = dob(coc_diameter_px(lens, textureLoad(depth, p, 0).r));
        textureStore(new_variance, tile * TILE + vec2u(local.x, y), vec4f(variance_of_dob(sigma)));
        greatest = max(greatest, sigma);
        least = min(least, sigma);
    }
    if greatest > dob(params.in_focus_coc_px) {
        atomicOr(&defocused[local.y], 1u);
    }
    if variance_of_dob(least) < disc_variance(1.0, 1u) {
        atomicOr(&near[local.y], 1u);
    }
    if params.smoothing != 0u && some_rho_near(vec2f(corner), local.x) {
        atomicOr(&some_rho[local.y], 1u);
    }
    workgroupBarrier();
    if local.x == 0u && is_tile(tile) {
        var class_of = select(FAR, NEAR, atomicLoad(&near[local.y]) != 0u);
        class_of = select(IN_FOCUS, class_of, atomicLoad(&defocused[local.y]) != 0u);
        list_tile(tile, select(class_of, SMOOTHED, atomicLoad(&some_rho[local.y]) != 0u));
    }
}

/// Whether there is DoN in one eighth of the texels of the top level that bilinear reads in
/// the tile at `corner`, px, touch.
fn some_rho_near(corner: vec2f, lane: u32) -> bool {
    let first = vec2i(floor(top_texels(corner + 0.5)));
    let side = vec2u(vec2i(floor(top_texels(corner + f32(TILE) - 0.5))) - first + 2);
    let top = params.levels - 1u;
    let size = textureDimensions(blur_pyramid, top);
    var greatest = 0.0;
    for (var i = lane; i < side.x * side.y; i += 8u) {
        let texel = first + vec2i(vec2u(i % side.x, i / side.x));
        greatest = max(greatest, textureLoad(blur_pyramid, clamp_to_image(texel, size), top).z);
    }
    return greatest > 0.0;
}

/// Variances of the tiles of class SMOOTHED; lists them anew by what is left of them.
@compute @workgroup_size(8, 8)
fn smooth_tiles(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let tile = listed_tile(group);
    let pixel = tile * TILE + local.xy;
    let variance = variance_of_dob(smoothed_dob(centre_of(pixel)));
    textureStore(new_variance, pixel, vec4f(variance));
    if variance < disc_variance(1.0, 1u) {
        atomicOr(&near[0], 1u);
    }
    if variance > variance_of_dob(dob(params.in_focus_coc_px)) {
        atomicOr(&defocused[0], 1u);
    }
    workgroupBarrier();
    if index == 0u && is_tile(tile) {
        let class_of = select(FAR, NEAR, atomicLoad(&near[0]) != 0u);
        list_tile(tile, select(IN_FOCUS, class_of, atomicLoad(&defocused[0]) != 0u));
    }
}

const NO_PIXEL = 0xffffffffu;

/// The pixel of an invocation; one beyond the frame where there is none.
fn listed_pixel(group: vec3u, local: vec3u) -> vec2u {
    let tile = listed_tile(group);
    let pixel = tile * TILE + local.xy;
    return select(vec2u(NO_PIXEL), pixel, is_tile(tile) && all(pixel < textureDimensions(result)));
}

/// The centre of a pixel of the inner frame in the outer one.
fn centre_of(pixel: vec2u) -> vec2f {
    return vec2f(pixel) + 0.5 + f32(params.overscan);
}

fn put(pixel: vec2u, c: vec3f) {
    textureStore(result, pixel, vec4f(c, 1.0));
}

@compute @workgroup_size(8, 8)
fn blur_near(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let pixel = listed_pixel(group, local);
    if pixel.x != NO_PIXEL {
        put(pixel, disc_at(centre_of(pixel), textureLoad(variance, pixel, 0).r));
    }
}

@compute @workgroup_size(8, 8)
fn blur_far(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let pixel = listed_pixel(group, local);
    if pixel.x != NO_PIXEL {
        put(pixel, between_nodes(centre_of(pixel), textureLoad(variance, pixel, 0).r));
    }
}

// ---- steps 4 and 5 as printed ----

/// The nine offsets on the unit circle with the weights of a 3x3 Gaussian (Fig. 4b);
/// without `circular`, the paper's rectangular ones (Fig. 4a).
fn tap(i: u32) -> vec3f {
    let x = f32(i % 3u) - 1.0;
    let y = f32(i / 3u) - 1.0;
    let weight = (2.0 - abs(x)) * (2.0 - abs(y)) / 16.0;
    let shrink = select(1.0, SQRT_HALF, params.circular != 0u && x * y != 0.0);
    return vec3f(shrink * vec2f(x, y), weight);
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

/// As `smoothed_dob`, through the circular filter.
fn dob_as_printed(at: vec2f) -> f32 {
    if params.smoothing != 0u {
        let n = min(level_of_dob(smooth_blur_at(at, f32(params.levels)).z), f32(params.levels));
        if n > 0.0 {
            return smooth_blur_at(at, n).y;
        }
    }
    return sharp_blur_at(at).y;
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
    if level <= LEAST_LEVEL {
        return image_at(at);
    }
    if level < 1.0 {
        // Below the first level the filter fades in over the sharp image.
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
fn blur_as_printed(@builtin(global_invocation_id) id: vec3u) {
    let at = centre_of(id.xy);
    put(id.xy, interpolate(at, level_of_dob(dob_as_printed(at))));
}

// ---- to look at: (c, DoB, DoB that is used, px; the level that is read for it) ----

fn store_explained(pixel: vec2u, used_dob: f32, level: f32) {
    textureStore(explained, pixel, vec4f(sharp_blur_at(centre_of(pixel)).xy, used_dob, level));
}

@compute @workgroup_size(8, 8)
fn explain_discs(@builtin(global_invocation_id) id: vec3u) {
    let at = centre_of(id.xy);
    var sigma = sharp_blur_at(at).y;
    if params.smoothing != 0u {
        sigma = smoothed_dob(at);
    }
    // Below the first level the image is read.
    let level = level_of_variance(variance_of_dob(sigma));
    store_explained(id.xy, sigma, clamp(level, 0.0, f32(params.levels)));
}

@compute @workgroup_size(8, 8)
fn explain_as_printed(@builtin(global_invocation_id) id: vec3u) {
    let sigma = dob_as_printed(centre_of(id.xy));
    store_explained(id.xy, sigma, clamp(level_of_dob(sigma), 0.0, f32(params.levels) + 0.999));
}
