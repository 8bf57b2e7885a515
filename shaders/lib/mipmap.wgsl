// What the two parts of `mipmap` share: its numbers (src/methods/mipmap.rs).

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
    /// 1: the DoB is smoothed over the edges of the foreground, which there is.
    smoothing: u32,
    /// CoC diameter, px, below which a pixel is left as it is.
    in_focus_coc_px: f32,
    _unused: vec2u,
    /// Variance per axis, texel^2, of the three discs below.
    disc_variance: vec4f,
    /// Share of each neighbour in a disc of 2, 3 and 3 sqrt(2) texels, by the greater and
    /// the smaller of its distances on the axes: (0, 0), (1, 0), (1, 1), (2, 0), (2, 1),
    /// (2, 2).
    discs: array<vec4f, 6>,
}

@group(0) @binding(0) var<uniform> lens: Lens;
@group(0) @binding(1) var<uniform> params: Params;

/// DoB, px, of a signed CoC.
fn dob(c: f32) -> f32 {
    return params.sigma_per_coc * abs(c);
}

/// Neighbours in 5x5 texels around one.
const NEIGHBOURS = 25u;

fn neighbour(i: u32) -> vec2i {
    return vec2i(i32(i % 5u), i32(i / 5u)) - 2;
}

/// Shares of neighbour i in the three discs around a texel.
fn disc_weights(i: u32) -> vec3f {
    let distance = vec2u(abs(neighbour(i)));
    let far = max(distance.x, distance.y);
    return params.discs[far * (far + 1u) / 2u + min(distance.x, distance.y)].xyz;
}
