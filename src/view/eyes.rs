//! Eyes on a lens.

use glam::Vec4;

/// The eyes on a lens, in view space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Eyes {
    /// How far from the lens's centre they lie at most, m.
    pub radius_m: f32,
    /// Vergence, D, at which all of them see the same frame: that of what is sharp, less than 0 where
    /// nothing is.
    pub focus_d: f32,
    /// By how much astigmatism moves the frame at most, over the distance.
    pub astigmatism_slope: f32,
}

impl Eyes {
    /// How far the sides of a frustum lie from those of the lens's centre at most where this
    /// sphere (centre, radius) is, m: the sides meet in focus and are apart by the eye's
    /// distance at the lens. Astigmatism turns them further.
    pub(super) fn shift_m(&self, sphere: Vec4) -> f32 {
        let at = |d: f32| (1.0 - d * self.focus_d).abs();
        let (near_m, far_m) = (-sphere.z - sphere.w, -sphere.z + sphere.w);
        self.radius_m * at(near_m).max(at(far_m)) + self.astigmatism_slope * far_m.max(0.0)
    }
}
