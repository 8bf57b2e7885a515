// Colour of linear Rec. 709.

/// Relative luminance of a linear Rec. 709 colour (Rec. ITU-R BT.709).
fn luminance(color: vec3f) -> f32 {
    return dot(color, vec3f(0.2126, 0.7152, 0.0722));
}

/// The greatest finite f16: what a colour is clamped to before it is stored as one.
const MAX_F16 = 65504.0;

/// Whether no channel is NaN or infinite, by its bits: compilers may assume that there are
/// no such numbers and drop comparisons.
fn is_finite(color: vec3f) -> bool {
    return all((bitcast<vec3u>(color) & vec3u(0x7f800000u)) != vec3u(0x7f800000u));
}
