// The lens as a shader sees it. c is the signed CoC diameter in pixels, negative in
// front of the focus distance; z is the stored depth near / d, so that c is affine in z
// (src/lens.rs), up to diameters that no image can show.

struct Lens {
    /// K: CoC diameter at infinity, px.
    k_px: f32,
    /// K * df / near, px: c = k_px - slope_px * z.
    slope_px: f32,
    /// z of the focus distance: near / df.
    focus_z: f32,
    /// Standard deviation per axis of the lens's intensity distribution over C.
    sigma_per_coc: f32,
}

/// Greatest CoC diameter, px (src/lens.rs): four of the widest images' sides, and twice it
/// fits into f16.
const GREATEST_COC = 30000.0;

/// Signed CoC diameter, px, at stored depth z. The same as k_px - slope_px * z, but near the
/// focus, where that is the small difference of two roundings, this one is exact.
fn coc_diameter_px(lens: Lens, z: f32) -> f32 {
    return clamp(lens.slope_px * (lens.focus_z - z), -GREATEST_COC, GREATEST_COC);
}
