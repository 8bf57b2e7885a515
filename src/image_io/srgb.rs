//! The exact sRGB transfer function (IEC 61966-2-1), piecewise, in f32 and f64.
//!
//! Values outside [0, 1] are not clamped: the curve is continued to negative values by
//! point symmetry, and beyond 1 by itself.

/// Linear value of an sRGB-encoded one.
pub fn linear_from_srgb(encoded: f64) -> f64 {
    let x = encoded.abs();
    let linear = if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) };
    linear.copysign(encoded)
}

/// sRGB-encoded value of a linear one.
pub fn srgb_from_linear(linear: f64) -> f64 {
    let x = linear.abs();
    let encoded = if x <= 0.0031308 { x * 12.92 } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
    encoded.copysign(linear)
}

/// [`linear_from_srgb`] rounded to f32.
pub fn linear_from_srgb_f32(encoded: f32) -> f32 {
    linear_from_srgb(f64::from(encoded)) as f32
}

/// [`srgb_from_linear`] rounded to f32.
pub fn srgb_from_linear_f32(linear: f32) -> f32 {
    srgb_from_linear(f64::from(linear)) as f32
}

/// The nearest 8-bit sRGB value of a linear one; NaN becomes 0.
pub fn srgb8_from_linear(linear: f32) -> u8 {
    (srgb_from_linear(f64::from(linear)) * 255.0).round().clamp(0.0, 255.0) as u8
}

/// Linear values of the 256 sRGB bytes.
pub fn linear_from_srgb8_table() -> [f32; 256] {
    std::array::from_fn(|byte| linear_from_srgb(byte as f64 / 255.0) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values_and_round_trip() {
        // 0.5 encoded is 0.21404114 linear; both branches of the curve agree at their joint
        // to the 3e-8 by which the standard's rounded constants miss each other.
        assert!((linear_from_srgb(0.5) - 0.214_041_140_482_232).abs() < 1e-14);
        let joint = 0.04045_f64;
        assert!((joint / 12.92 - ((joint + 0.055) / 1.055).powf(2.4)).abs() < 3e-8);
        for byte in 0..=255_u8 {
            assert_eq!(srgb8_from_linear(linear_from_srgb8_table()[usize::from(byte)]), byte);
        }
        for i in -200..400 {
            let x = f64::from(i) * 0.01;
            assert!((srgb_from_linear(linear_from_srgb(x)) - x).abs() < 1e-7, "at {x}");
        }
        assert_eq!(srgb8_from_linear(f32::NAN), 0);
    }
}
