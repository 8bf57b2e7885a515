//! Primaries other than those of Rec. 709.

use exr::meta::attribute::Chromaticities;
use glam::{Mat3, Vec2, Vec3};

/// Rec. 709, as OpenEXR assumes where a file says nothing.
const REC709: [Vec2; 4] =
    [Vec2::new(0.64, 0.33), Vec2::new(0.30, 0.60), Vec2::new(0.15, 0.06), Vec2::new(0.3127, 0.3290)];

/// Weights of linear Rec. 709 in luminance.
pub(super) const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// Bradford's cone responses (Lam 1985), in rows.
const BRADFORD: Mat3 =
    Mat3::from_cols_array(&[0.8951, -0.7502, 0.0389, 0.2664, 1.7135, -0.0685, -0.1614, 0.0367, 1.0296]);

/// Weights of a file's primaries in luminance, as its luminance-chroma images use them; those of
/// Rec. 709 where they are no primaries.
pub(super) fn luminance(file: &Chromaticities) -> Vec3 {
    let own = [file.red, file.green, file.blue, file.white].map(|at| Vec2::new(at.0, at.1));
    xyz_from(own).map_or(LUMINANCE, |matrix| matrix.row(1))
}

/// From linear colour in a file's primaries to Rec. 709, its white to white; `None` where
/// they are the same, or no primaries at all.
pub(super) fn rec709_from(file: &Chromaticities) -> Option<Mat3> {
    let own = [file.red, file.green, file.blue, file.white].map(|at| Vec2::new(at.0, at.1));
    if own.iter().zip(REC709).all(|(a, b)| a.abs_diff_eq(b, 1e-4)) {
        return None;
    }
    let (from, to) = (xyz_from(own)?, xyz_from(REC709)?);
    let cones = |white: Vec2| BRADFORD * xyz_of(white);
    let adapt = BRADFORD.inverse() * Mat3::from_diagonal(cones(REC709[3]) / cones(own[3])) * BRADFORD;
    let matrix = to.inverse() * adapt * from;
    matrix.is_finite().then_some(matrix)
}

/// From linear colour in these primaries (red, green, blue, white) to XYZ, white at Y = 1.
fn xyz_from([r, g, b, white]: [Vec2; 4]) -> Option<Mat3> {
    if [r, g, b, white].iter().any(|at| !at.is_finite() || at.y.abs() < 1e-6) {
        return None;
    }
    let columns = Mat3::from_cols(xyz_of(r), xyz_of(g), xyz_of(b));
    let scale = columns.inverse() * xyz_of(white);
    let matrix = columns * Mat3::from_diagonal(scale);
    (matrix.is_finite() && matrix.determinant().abs() > 1e-9).then_some(matrix)
}

/// XYZ of a chromaticity at Y = 1.
fn xyz_of(at: Vec2) -> Vec3 {
    Vec3::new(at.x / at.y, 1.0, (1.0 - at.x - at.y) / at.y)
}

/// Colour from luminance and the two chroma channels of OpenEXR: RY = (R - Y) / Y; `weights` are those
/// of red, green and blue in luminance.
pub(super) fn rgb_from_luminance(y: f32, ry: f32, by: f32, weights: Vec3) -> Vec3 {
    let (r, b) = ((ry + 1.0) * y, (by + 1.0) * y);
    Vec3::new(r, (y - r * weights.x - b * weights.z) / weights.y, b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::math::Vec2 as Pair;

    #[test]
    fn white_stays_white_and_aces_red_is_beyond_rec709() {
        let aces = Chromaticities {
            red: Pair(0.7347, 0.2653),
            green: Pair(0.0, 1.0),
            blue: Pair(0.0001, -0.077),
            white: Pair(0.32168, 0.33767),
        };
        let matrix = rec709_from(&aces).expect("other primaries");
        assert!((matrix * Vec3::ONE - 1.0).abs().max_element() < 1e-4, "{}", matrix * Vec3::ONE);
        // The matrix from AP0 to Rec. 709 with Bradford's adaptation, as ACES prints it.
        assert!(
            (matrix * Vec3::X - Vec3::new(2.5217, -0.2765, -0.0154)).abs().max_element() < 2e-3,
            "{}",
            matrix * Vec3::X
        );
        let own = Chromaticities {
            red: Pair(0.64, 0.33),
            green: Pair(0.30, 0.60),
            blue: Pair(0.15, 0.06),
            white: Pair(0.3127, 0.3290),
        };
        assert_eq!(rec709_from(&own), None);
        assert!((luminance(&own) - LUMINANCE).abs().max_element() < 1e-4, "{}", luminance(&own));
        assert!((rgb_from_luminance(0.5, 0.0, 0.0, luminance(&own)) - 0.5).abs().max_element() < 1e-6);
    }
}
