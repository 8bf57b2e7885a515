//! What the numbers in a depth file mean.

/// The encoding of a depth file. Depth is along the optical axis.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct DepthEncoding {
    /// From number to metres.
    pub kind: DepthKind,
    /// The number, as it stands in the file, that means "not measured".
    pub unknown: Option<f32>,
}

/// From number to metres. `v` is the number divided by its full scale: by 255 or 65535 in
/// files of 8 or 16 bits, by 1 in float files.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum DepthKind {
    /// `d = number * per_unit`: the number itself, not `v`.
    Metres {
        /// Metres per unit, such as 0.001 for millimetres.
        per_unit: f64,
    },
    /// Disparity: `1/d = (1 - v) / far + v / near`; 1 is near.
    Inverse {
        /// Depth at v = 1, metres.
        near_m: f64,
        /// Depth at v = 0, metres; may be infinite.
        far_m: f64,
    },
    /// A depth buffer, not reversed: `1/d = (1 - v) / near + v / far`; 0 is near.
    Device {
        /// Depth at v = 0, metres.
        near_m: f64,
        /// Depth at v = 1, metres; may be infinite.
        far_m: f64,
    },
}

/// Why numbers and encoding do not go together.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EncodingError {
    /// A scale that is not positive.
    #[error("the depth scale is {per_unit} metres per unit; it must be a positive number (--depth-scale)")]
    Scale {
        /// The value given.
        per_unit: f64,
    },
    /// A range that is empty or reversed.
    #[error("the depth range is {near_m} to {far_m} metres; it must be 0 < near < far (--depth-range NEAR,FAR)")]
    Range {
        /// Near end, metres.
        near_m: f64,
        /// Far end, metres.
        far_m: f64,
    },
    /// A float outside [0, 1] where the encoding has none.
    #[error(
        "the depth value {value} lies outside 0 to 1, where inverse and device depths lie; try --depth-kind metres"
    )]
    Value {
        /// The first such value.
        value: f32,
    },
}

/// Rounding allowed beyond [0, 1]: half-float files hold values near 1 to within 2^-11.
const UNIT_SLACK: f64 = 1.0 / 2048.0;

/// A pixel's depth, or why it has none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Measured {
    /// Metres, positive; may be infinite.
    Depth(f32),
    /// The encoding's "unknown".
    Unknown,
    /// NaN, zero or negative.
    Damaged,
}

impl Measured {
    pub(super) fn depth_or_zero(&self) -> f32 {
        match self {
            Self::Depth(depth_m) => *depth_m,
            Self::Unknown | Self::Damaged => 0.0,
        }
    }
}

impl DepthEncoding {
    /// Metres, without an unknown value.
    pub const METRES: Self = Self { kind: DepthKind::Metres { per_unit: 1.0 }, unknown: None };

    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// A scale that is not positive, a range that is empty.
    pub fn check(&self) -> Result<(), EncodingError> {
        match self.kind {
            DepthKind::Metres { per_unit } if !(per_unit > 0.0 && per_unit.is_finite()) => {
                Err(EncodingError::Scale { per_unit })
            }
            DepthKind::Inverse { near_m, far_m } | DepthKind::Device { near_m, far_m }
                if !(near_m > 0.0 && near_m < far_m) =>
            {
                Err(EncodingError::Range { near_m, far_m })
            }
            _ => Ok(()),
        }
    }

    /// Depths of raw values whose full scale (the number that stands for 1) is given.
    pub(super) fn measure_all(&self, raw: &[f32], full_scale: f64) -> Result<Vec<Measured>, EncodingError> {
        raw.iter().map(|&value| self.measure(value, full_scale)).collect()
    }

    fn measure(&self, raw: f32, full_scale: f64) -> Result<Measured, EncodingError> {
        let is_unknown = self.unknown.is_some_and(|unknown| raw == unknown || (raw.is_nan() && unknown.is_nan()));
        if is_unknown {
            return Ok(Measured::Unknown);
        }
        if raw.is_nan() {
            return Ok(Measured::Damaged);
        }
        let depth_m = match self.kind {
            DepthKind::Metres { per_unit } => f64::from(raw) * per_unit,
            DepthKind::Inverse { near_m, far_m } => inverse_lerp(far_m, near_m, unit(raw, full_scale)?),
            DepthKind::Device { near_m, far_m } => inverse_lerp(near_m, far_m, unit(raw, full_scale)?),
        };
        let depth_m = depth_m as f32;
        Ok(if depth_m > 0.0 { Measured::Depth(depth_m) } else { Measured::Damaged })
    }
}

fn unit(raw: f32, full_scale: f64) -> Result<f64, EncodingError> {
    let v = f64::from(raw) / full_scale;
    let inside = (-UNIT_SLACK..=1.0 + UNIT_SLACK).contains(&v);
    if inside { Ok(v.clamp(0.0, 1.0)) } else { Err(EncodingError::Value { value: raw }) }
}

/// The depth whose reciprocal lies at `v` between those of `at_0` and `at_1`.
fn inverse_lerp(at_0: f64, at_1: f64, v: f64) -> f64 {
    1.0 / ((1.0 - v) / at_0 + v / at_1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn depth(kind: DepthKind, raw: f32, full_scale: f64) -> f32 {
        match (DepthEncoding { kind, unknown: None }).measure(raw, full_scale) {
            Ok(Measured::Depth(depth_m)) => depth_m,
            other => panic!("{kind:?} of {raw}: {other:?}"),
        }
    }

    #[test]
    fn ends_of_every_range_are_exact() {
        let (near_m, far_m) = (0.5, 20.0);
        assert_eq!(depth(DepthKind::Metres { per_unit: 0.0002 }, 5000.0, 65535.0), 1.0);
        assert_eq!(depth(DepthKind::Inverse { near_m, far_m }, 65535.0, 65535.0), 0.5);
        assert_eq!(depth(DepthKind::Inverse { near_m, far_m }, 0.0, 255.0), 20.0);
        assert_eq!(depth(DepthKind::Device { near_m, far_m }, 0.0, 1.0), 0.5);
        assert_eq!(depth(DepthKind::Device { near_m, far_m }, 1.0, 1.0), 20.0);
        // A depth buffer by its usual formula: z = far (d - near) / (d (far - near)).
        let z = 20.0 * (3.0 - 0.5) / (3.0 * (20.0 - 0.5));
        assert!((depth(DepthKind::Device { near_m, far_m }, z as f32, 1.0) - 3.0).abs() < 1e-5);
        assert_eq!(depth(DepthKind::Inverse { near_m, far_m: f64::INFINITY }, 0.0, 1.0), f32::INFINITY);
    }

    #[test]
    fn sixteen_bits_keep_their_precision() {
        let kind = DepthKind::Metres { per_unit: 0.001 };
        let depths: Vec<f32> = (1..=65535_u16).map(|v| depth(kind, f32::from(v), 65535.0)).collect();
        assert!(depths.windows(2).all(|pair| pair[0] < pair[1]));
    }

    #[test]
    fn impossible_encodings_and_values_are_refused() {
        let check = |kind| DepthEncoding { kind, unknown: None }.check();
        for per_unit in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(check(DepthKind::Metres { per_unit }), Err(EncodingError::Scale { .. })));
        }
        for (near_m, far_m) in [(0.0, 1.0), (2.0, 1.0), (1.0, 1.0), (f64::NAN, 1.0), (1.0, f64::NAN)] {
            assert!(matches!(check(DepthKind::Inverse { near_m, far_m }), Err(EncodingError::Range { .. })));
            assert!(matches!(check(DepthKind::Device { near_m, far_m }), Err(EncodingError::Range { .. })));
        }
        let device = DepthEncoding { kind: DepthKind::Device { near_m: 0.1, far_m: 9.0 }, unknown: Some(7.0) };
        assert_eq!(device.measure(3.0, 1.0), Err(EncodingError::Value { value: 3.0 }));
        assert_eq!(device.measure(7.0, 1.0), Ok(Measured::Unknown));
        for raw in [f32::NAN, -1.0, 0.0] {
            assert_eq!(DepthEncoding::METRES.measure(raw, 1.0), Ok(Measured::Damaged));
        }
    }
}
