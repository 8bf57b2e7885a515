//! What the numbers in a depth file mean.

/// The encoding of a depth file.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct DepthEncoding {
    /// From number to metres.
    pub kind: DepthKind,
    /// The number, as it stands in the file, that means "not measured".
    pub unknown: Option<f32>,
    /// The number, as it stands in the file, that means "infinitely far".
    #[serde(default)]
    pub infinity: Option<f32>,
}

/// From number to metres along the optical axis. `v` is the number divided by its full
/// scale: by 255 or 65535 in files of 8 or 16 bits, by 1 in float files.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum DepthKind {
    /// `d = number * per_unit`: the number itself, not `v`.
    Metres {
        /// Metres per unit, such as 0.001 for millimetres.
        per_unit: f64,
    },
    /// Distance from the camera along each pixel's ray: `d = number * per_unit *
    /// cos(angle between ray and axis)`, by the field of view.
    Distance {
        /// Metres per unit.
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
    /// Inverse depth up to an unknown scale and shift, as depth networks give it (MiDaS,
    /// Depth Anything): like [`DepthKind::Inverse`], with the least number of the image in
    /// the place of 0 and the greatest in that of 1.
    Relative {
        /// Depth at the greatest number, metres.
        near_m: f64,
        /// Depth at the least number, metres; may be infinite.
        far_m: f64,
    },
    /// Inverse metres: `1/d = number * per_unit`, as phones give it.
    Dioptres {
        /// Dioptres per unit.
        per_unit: f64,
    },
    /// A stereo pair's disparity in pixels: `d = focal * baseline / (number * per_unit +
    /// offset)`.
    Disparity {
        /// Focal length, pixels of the disparity map.
        focal_px: f64,
        /// Distance of the two cameras, metres.
        baseline_m: f64,
        /// Difference of the principal points (Middlebury's `doffs`), px.
        offset_px: f64,
        /// Pixels per unit, such as 1/256 for KITTI.
        per_unit: f64,
    },
}

impl DepthKind {
    /// Whether the numbers are lengths, so that a very great one is far away.
    pub(super) fn is_length(&self) -> bool {
        matches!(self, Self::Metres { .. } | Self::Distance { .. })
    }

    /// The full vertical field of view, radians, that a calibration tells of an image of
    /// that height, px.
    pub(super) fn fov_y(&self, height: u32) -> Option<f64> {
        match self {
            Self::Disparity { focal_px, .. } => Some(2.0 * (0.5 * f64::from(height) / focal_px).atan()),
            _ => None,
        }
    }
}

/// Why numbers and encoding do not go together.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EncodingError {
    /// A scale that is not positive.
    #[error("the depth scale is {per_unit} metres per unit; it must be a positive number (--depth-scale)")]
    Scale {
        /// The value given.
        per_unit: f64,
    },
    /// A calibration that no pair of cameras has.
    #[error(
        "the calibration is a focal length of {focal_px} px and a baseline of {baseline_m} m; both must be positive (--depth-calibration FOCAL_PX,BASELINE_M[,OFFSET_PX])"
    )]
    Calibration {
        /// Focal length, px.
        focal_px: f64,
        /// Baseline, metres.
        baseline_m: f64,
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
    pub const METRES: Self = Self { kind: DepthKind::Metres { per_unit: 1.0 }, unknown: None, infinity: None };

    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// A scale that is not positive, a range that is empty.
    pub fn check(&self) -> Result<(), EncodingError> {
        match self.kind {
            DepthKind::Metres { per_unit }
            | DepthKind::Distance { per_unit }
            | DepthKind::Dioptres { per_unit }
            | DepthKind::Disparity { per_unit, .. }
                if !(per_unit > 0.0 && per_unit.is_finite()) =>
            {
                Err(EncodingError::Scale { per_unit })
            }
            DepthKind::Inverse { near_m, far_m }
            | DepthKind::Device { near_m, far_m }
            | DepthKind::Relative { near_m, far_m }
                if !(near_m > 0.0 && near_m < far_m) =>
            {
                Err(EncodingError::Range { near_m, far_m })
            }
            DepthKind::Disparity { focal_px, baseline_m, offset_px, .. }
                if !(focal_px > 0.0
                    && baseline_m > 0.0
                    && (focal_px * baseline_m).is_finite()
                    && offset_px.is_finite()) =>
            {
                Err(EncodingError::Calibration { focal_px, baseline_m })
            }
            _ => Ok(()),
        }
    }

    /// Depths of raw values whose full scale (the number that stands for 1) is given.
    /// Distances along rays stay distances: only their places make depths of them.
    pub(super) fn measure_all(&self, raw: &[f32], full_scale: f64) -> Result<Vec<Measured>, EncodingError> {
        let ends = match self.kind {
            DepthKind::Relative { .. } => self.ends(raw),
            _ => [0.0; 2],
        };
        raw.iter().map(|&value| self.measure(value, full_scale, ends)).collect()
    }

    /// Least and greatest of the numbers that mean a depth.
    fn ends(&self, raw: &[f32]) -> [f64; 2] {
        let values =
            raw.iter().copied().filter(|v| v.is_finite() && !means(self.unknown, *v) && !means(self.infinity, *v));
        let wider = |[lo, hi]: [f64; 2], v: f32| [lo.min(f64::from(v)), hi.max(f64::from(v))];
        values.fold([f64::INFINITY, f64::NEG_INFINITY], wider)
    }

    fn measure(&self, raw: f32, full_scale: f64, [least, greatest]: [f64; 2]) -> Result<Measured, EncodingError> {
        if means(self.unknown, raw) {
            return Ok(Measured::Unknown);
        }
        if means(self.infinity, raw) {
            return Ok(Measured::Depth(f32::INFINITY));
        }
        if raw.is_nan() {
            return Ok(Measured::Damaged);
        }
        let number = f64::from(raw);
        let depth_m = match self.kind {
            DepthKind::Metres { per_unit } | DepthKind::Distance { per_unit } => number * per_unit,
            DepthKind::Inverse { near_m, far_m } => inverse_lerp(far_m, near_m, unit(raw, full_scale)?),
            DepthKind::Device { near_m, far_m } => inverse_lerp(near_m, far_m, unit(raw, full_scale)?),
            // An image of one number alone is as far as its far end.
            DepthKind::Relative { near_m, far_m } if greatest > least => {
                inverse_lerp(far_m, near_m, (number - least) / (greatest - least))
            }
            DepthKind::Relative { far_m, .. } => far_m,
            // What is not seen twice has no disparity: Middlebury marks it infinite.
            DepthKind::Disparity { .. } | DepthKind::Dioptres { .. } if raw.is_infinite() => {
                return Ok(Measured::Unknown);
            }
            DepthKind::Dioptres { per_unit } => (number * per_unit).recip(),
            DepthKind::Disparity { focal_px, baseline_m, offset_px, per_unit } => {
                focal_px * baseline_m / (number * per_unit + offset_px)
            }
        };
        let depth_m = depth_m as f32;
        Ok(if depth_m > 0.0 { Measured::Depth(depth_m) } else { Measured::Damaged })
    }
}

/// Whether a number is the one that stands for something else.
fn means(special: Option<f32>, raw: f32) -> bool {
    special.is_some_and(|special| raw == special || (raw.is_nan() && special.is_nan()))
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
        match (DepthEncoding { kind, ..DepthEncoding::METRES }).measure(raw, full_scale, [0.0, 1.0]) {
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
    fn disparities_dioptres_and_relative_depths() {
        let kind = DepthKind::Disparity { focal_px: 1000.0, baseline_m: 0.2, offset_px: 10.0, per_unit: 0.5 };
        assert_eq!(depth(kind, 80.0, 65535.0), 4.0);
        assert!((kind.fov_y(2000).expect("a calibration") - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert_eq!(depth(DepthKind::Dioptres { per_unit: 1.0 }, 0.25, 1.0), 4.0);
        assert_eq!(depth(DepthKind::Dioptres { per_unit: 1.0 }, 0.0, 1.0), f32::INFINITY);
        let kind = DepthKind::Relative { near_m: 1.0, far_m: 4.0 };
        let relative = DepthEncoding { kind, unknown: Some(-9.0), infinity: None };
        let measured = relative.measure_all(&[300.0, 100.0, 200.0, -9.0], 1.0).expect("numbers");
        let depth = |d: f64| Measured::Depth(d as f32);
        assert_eq!(measured, [depth(1.0), depth(4.0), depth(1.0 / 0.625), Measured::Unknown]);
        let stereo = DepthEncoding { kind: DepthKind::Dioptres { per_unit: 1.0 }, ..DepthEncoding::METRES };
        assert_eq!(stereo.measure_all(&[f32::INFINITY], 1.0), Ok(vec![Measured::Unknown]));
    }

    #[test]
    fn sixteen_bits_keep_their_precision() {
        let kind = DepthKind::Metres { per_unit: 0.001 };
        let depths: Vec<f32> = (1..=65535_u16).map(|v| depth(kind, f32::from(v), 65535.0)).collect();
        assert!(depths.windows(2).all(|pair| pair[0] < pair[1]));
    }

    #[test]
    fn impossible_encodings_and_values_are_refused() {
        let check = |kind| DepthEncoding { kind, ..DepthEncoding::METRES }.check();
        for per_unit in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(check(DepthKind::Metres { per_unit }), Err(EncodingError::Scale { .. })));
        }
        for (near_m, far_m) in [(0.0, 1.0), (2.0, 1.0), (1.0, 1.0), (f64::NAN, 1.0), (1.0, f64::NAN)] {
            assert!(matches!(check(DepthKind::Inverse { near_m, far_m }), Err(EncodingError::Range { .. })));
            assert!(matches!(check(DepthKind::Device { near_m, far_m }), Err(EncodingError::Range { .. })));
        }
        let kind = DepthKind::Device { near_m: 0.1, far_m: 9.0 };
        let device = DepthEncoding { kind, unknown: Some(7.0), infinity: Some(8.0) };
        assert_eq!(device.measure(3.0, 1.0, [0.0; 2]), Err(EncodingError::Value { value: 3.0 }));
        assert_eq!(device.measure(7.0, 1.0, [0.0; 2]), Ok(Measured::Unknown));
        assert_eq!(device.measure(8.0, 1.0, [0.0; 2]), Ok(Measured::Depth(f32::INFINITY)));
        for raw in [f32::NAN, -1.0, 0.0] {
            assert_eq!(DepthEncoding::METRES.measure(raw, 1.0, [0.0; 2]), Ok(Measured::Damaged));
        }
    }
}
