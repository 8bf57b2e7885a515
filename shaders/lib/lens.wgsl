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
    /// Direction of the one of the eye's two meridians that is nearer to x; y points down.
    meridian: vec2f,
    /// What astigmatism adds to c along that meridian, px, and takes from it across; 0 for a round
    /// blur.
    astigmatism_px: f32,
    _unused: f32,
}

/// Greatest CoC diameter, px (src/lens.rs): four of the widest images' sides, and twice it
/// fits into f16.
const GREATEST_COC = 30000.0;

/// Signed CoC diameter, px, at stored depth z. The same as k_px - slope_px * z, but near the
/// focus, where that is the small difference of two roundings, this one is exact.
fn coc_diameter_px(lens: Lens, z: f32) -> f32 {
    return clamp(lens.slope_px * (lens.focus_z - z), -GREATEST_COC, GREATEST_COC);
}

// An astigmatic eye blurs to an ellipse that turns with depth (`Refraction::astigmatism_d` in
// src/eye/refraction.rs). A point with CoC c is seen from the lens point v at
//
//   p + M v / 2,   M = c I + A,   A symmetric, without trace, the same at every depth
//
// so the ellipse's diameters are |c + a| along the meridian and |c - a| across it. In (x, y, c)
// lens rays stay straight: A only moves where they begin.

/// A v / 2, px: how far astigmatism moves what the lens point v sees.
fn astigmatic_offset_px(lens: Lens, v: vec2f) -> vec2f {
    return 0.5 * lens.astigmatism_px * (2.0 * dot(lens.meridian, v) * lens.meridian - v);
}

/// Longer and shorter diameter, px, of the ellipse that a point with CoC c blurs to.
fn greatest_diameter_px(lens: Lens, c: f32) -> f32 {
    return abs(c) + abs(lens.astigmatism_px);
}

fn least_diameter_px(lens: Lens, c: f32) -> f32 {
    return abs(abs(c) - abs(lens.astigmatism_px));
}

/// Signed diameters of the ellipse, px, along the meridian and across it.
fn diameters_px(lens: Lens, c: f32) -> vec2f {
    return vec2f(c + lens.astigmatism_px, c - lens.astigmatism_px);
}

/// An offset's components along the meridian and across it, a quarter turn from x to y.
fn by_meridian(lens: Lens, offset: vec2f) -> vec2f {
    let along = lens.meridian;
    return vec2f(dot(along, offset), along.x * offset.y - along.y * offset.x);
}

/// The offset with those components.
fn from_meridian(lens: Lens, components: vec2f) -> vec2f {
    let along = lens.meridian;
    return vec2f(
        along.x * components.x - along.y * components.y,
        along.y * components.x + along.x * components.y,
    );
}

/// Width and height, px, of the ellipse.
fn blur_extent_px(lens: Lens, c: f32) -> vec2f {
    let d = diameters_px(lens, c);
    let along = lens.meridian;
    let extent = vec2f(length(d * along), length(d * along.yx));
    return select(extent, vec2f(abs(c)), lens.astigmatism_px == 0.0);
}
