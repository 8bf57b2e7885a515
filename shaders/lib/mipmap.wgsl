// What the parts of `mipmap` share: its numbers (src/methods/mipmap/).

#import lens

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
    /// 1: foreground blurs over its edges, and there is some.
    smoothing: u32,
    /// CoC diameter, px, below which a pixel is left as it is.
    in_focus_coc_px: f32,
    /// 1: something in view lies in front of the focus distance.
    foreground: u32,
    /// 1: something in view lies behind the focus distance.
    background: u32,
    /// Size of level 1, texels.
    level_1: vec2u,
    /// How many times as wide as its own a blur is that a background pixel has no part in.
    reach: f32,
    /// Standard deviation, px, of the blur by discs, over CoC diameter.
    sigma_px_per_coc: f32,
    /// 1: as printed, levels are magnified by bilinear reads alone, equation (7).
    bilinear: u32,
    /// 1: DoB and DoN are read at 5 points instead of 9.
    five_points: u32,
    /// The first level above all on which something in front of the focus distance ends.
    front_level: u32,
    _unused: u32,
    /// Variance per axis, texel^2, of the three discs below.
    disc_variance: vec4f,
    /// Share of each neighbour in a disc of 2, 3 and 3 sqrt(2) texels, by the greater and
    /// the smaller of its distances on the axes: (0, 0), (1, 0), (1, 1), (2, 0), (2, 1),
    /// (2, 2).
    discs: array<vec4f, 6>,
}

@group(0) @binding(0) var<uniform> lens: Lens;
@group(0) @binding(1) var<uniform> params: Params;

/// The [1 3 3 1] kernel: the paper's 3x3 Gaussian, read by the hardware's bilinear filter at
/// the corner between texels.
const KERNEL = array<f32, 4>(0.125, 0.375, 0.375, 0.125);

/// DoB, px, of a signed CoC.
fn dob(c: f32) -> f32 {
    return params.sigma_per_coc * abs(c);
}

/// Variance, texel^2 per axis, that reading a level by a bilinear filter adds, on average
/// over its phases.
const BILINEAR_VARIANCE = 1.0 / 6.0;

const SQRT_HALF = 0.70710678;

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

/// The paper's level of a DoB of `sigma` px, equation (6).
fn level_as_printed(sigma: f32) -> f32 {
    return select(0.0, 1.0 + log2(params.k * sigma), params.k * sigma >= 0.5);
}

/// Blends what two levels say, or an image and a level.
fn blend_levels(fine: vec3f, coarse: vec3f, beta: f32) -> vec3f {
    if params.geometric != 0u {
        // Equation (8). pow(0, 0) is undefined in WGSL, hence the floor, far below f16.
        let least = vec3f(1e-12);
        return pow(max(fine, least), vec3f(1.0 - beta)) * pow(max(coarse, least), vec3f(beta));
    }
    return mix(fine, coarse, beta);
}
