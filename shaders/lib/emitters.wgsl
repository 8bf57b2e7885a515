// Light far brighter than white, apart from all other: taken out of what lens rays read,
// and brought to the pixels that its blur covers one by one.

/// Radiance above which a blurred texel becomes an emitter: the same in src/view/samples.rs.
const HIGHLIGHT_LIMIT = 2.0;

/// What a surface emits over the limit.
fn over_limit(color: vec3f) -> vec3f {
    return max(color - HIGHLIGHT_LIMIT, vec3f(0.0));
}

/// The share of that which emitters bring, for a surface with CoC radius s: none in focus,
/// where rays read it as it is, and no step on the way.
fn emitted_share(s: f32) -> f32 {
    return clamp(abs(s) - 1.5, 0.0, 1.0);
}

/// Light over the limit in one pixel of the outer frame: sums over samples.
struct Light {
    /// Radiance over the limit, divided by the number of samples.
    excess: vec3f,
    /// Sum of the components of `excess`: the weight of what follows.
    weight: f32,
    /// Weighted: offset from the pixel's centre, px.
    offset: vec2f,
    /// Weighted: square of the offset.
    square: f32,
    /// Weighted: stored depth.
    z: f32,
}

fn with_sample(light: Light, color: vec3f, z: f32, offset: vec2f, share: f32) -> Light {
    let over = share * over_limit(color);
    let weight = over.r + over.g + over.b;
    return Light(
        light.excess + over,
        light.weight + weight,
        light.offset + weight * offset,
        light.square + weight * dot(offset, offset),
        light.z + weight * z,
    );
}

/// One or many pixels' light, as one square of even radiance.
struct Emitter {
    /// Radiance over the limit times its area, px^2.
    excess: vec3f,
    /// CoC radius, px.
    s: f32,
    /// Centroid, px of the outer frame.
    at: vec2f,
    /// Side of the square, px.
    side: f32,
}

struct Highlights {
    /// Emitters that a tile can list.
    capacity: u32,
    /// Distance of a light's samples, px.
    sample_px: f32,
}
