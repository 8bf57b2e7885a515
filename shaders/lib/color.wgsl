// Colour of linear Rec. 709.

/// Relative luminance of a linear Rec. 709 colour (Rec. ITU-R BT.709).
fn luminance(color: vec3f) -> f32 {
    return dot(color, vec3f(0.2126, 0.7152, 0.0722));
}

/// sRGB encoding of a linear colour (IEC 61966-2-1), carried on above 1.
fn srgb_encoded(linear: vec3f) -> vec3f {
    let curve = 1.055 * pow(max(linear, vec3f(0.0)), vec3f(1.0 / 2.4)) - 0.055;
    return select(curve, 12.92 * linear, linear <= vec3f(0.0031308));
}

/// Linear colour of an sRGB-encoded one (IEC 61966-2-1), carried on above 1.
fn srgb_decoded(encoded: vec3f) -> vec3f {
    let curve = pow((max(encoded, vec3f(0.0)) + 0.055) / 1.055, vec3f(2.4));
    return select(curve, encoded / 12.92, encoded <= vec3f(0.04045));
}

/// The greatest finite f16: what a colour is clamped to before it is stored as one.
const MAX_F16 = 65504.0;

/// Whether no channel is NaN or infinite, by its bits: compilers may assume that there are
/// no such numbers and drop comparisons.
fn is_finite(color: vec3f) -> bool {
    return all((bitcast<vec3u>(color) & vec3u(0x7f800000u)) != vec3u(0x7f800000u));
}
