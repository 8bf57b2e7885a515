//! Numbers that stand for "infinitely far".
//!
//! Renderers fill the background of a depth pass with a number of their own: 1e10, the
//! greatest half float, the greatest float, or 0. As distances they would take the focus,
//! and be a surface beyond which nothing is.

use super::encoding::{DepthKind, Measured};

/// Metres from which on everything is infinitely far: the distance of the moon. Its blur is
/// that of infinity to the last bit of what is shown.
const ENDLESS_M: f32 = 1e8;

/// The greatest half float, which stands for all that is too far for it.
const GREATEST_HALF: f32 = 65504.0;

/// Makes infinity of what stands for it in a file of floats, and says how many pixels.
///
/// The greatest half float counts, whatever its unit; so does 0, where nothing in the file
/// is infinite already, unknown or damaged otherwise: a renderer then left the background
/// empty. Of relative depths and depth buffers nothing is known beyond their ends.
pub(super) fn to_infinity(raw: &[f32], is_float: bool, kind: &DepthKind, measured: &mut [Measured]) -> usize {
    if !kind.is_length() {
        return 0;
    }
    let is_background = |raw: f32, m: &Measured| match m {
        Measured::Depth(depth_m) => depth_m.is_finite() && (*depth_m >= ENDLESS_M || is_float && raw == GREATEST_HALF),
        Measured::Unknown | Measured::Damaged => false,
    };
    let is_zero = |raw: f32, m: &Measured| raw == 0.0 && *m == Measured::Damaged;
    let all_else_is_finite = raw.iter().zip(measured.iter()).all(|(&raw, m)| match m {
        Measured::Depth(depth_m) => depth_m.is_finite() && !is_background(raw, m),
        Measured::Unknown => false,
        Measured::Damaged => raw == 0.0,
    });
    let mut count = 0;
    for (&raw, m) in raw.iter().zip(measured) {
        if is_background(raw, m) || is_float && all_else_is_finite && is_zero(raw, m) {
            *m = Measured::Depth(f32::INFINITY);
            count += 1;
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    fn infinite(raw: &[f32], is_float: bool) -> Vec<bool> {
        let kind = DepthKind::Metres { per_unit: 1.0 };
        let measure = |&v: &f32| if v > 0.0 { Measured::Depth(v) } else { Measured::Damaged };
        let mut measured: Vec<Measured> = raw.iter().map(measure).collect();
        to_infinity(raw, is_float, &kind, &mut measured);
        measured.iter().map(|m| *m == Measured::Depth(f32::INFINITY)).collect()
    }

    #[test]
    fn far_sentinels_are_infinity() {
        assert_eq!(infinite(&[2.0, 1e10, 3e38, 50.0], true), [false, true, true, false]);
        assert_eq!(infinite(&[2.0, 65504.0, 65000.0], true), [false, true, false]);
        assert_eq!(infinite(&[2.0, 0.0, 3.0], true), [false, true, false]);
        // A sensor's holes: in integers, beside other damage, or where the sky is infinite.
        assert_eq!(infinite(&[2.0, 0.0, 3.0], false), [false; 3]);
        assert_eq!(infinite(&[2.0, 0.0, f32::NAN], true), [false; 3]);
        assert_eq!(infinite(&[2.0, 0.0, f32::INFINITY], true), [false, false, true]);
        assert_eq!(infinite(&[2.0, 65504.0], false), [false; 2]);
    }
}
