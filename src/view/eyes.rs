//! Eyes on a lens.

use glam::Vec4;

/// The eyes on a lens, in view space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Eyes {
    /// How far from the lens's centre they lie at most, m.
    pub radius_m: f32,
    /// Distance at which all of them see the same frame, m; may be infinite.
    pub focus_m: f32,
}

impl Eyes {
    /// How far the sides of a frustum lie from those of the lens's centre at most where this
    /// sphere (centre, radius) is, m: the sides meet in focus and are apart by the eye's
    /// distance at the lens.
    pub(super) fn shift_m(&self, sphere: Vec4) -> f32 {
        let at = |d: f32| (1.0 - d / self.focus_m).abs();
        self.radius_m * at(-sphere.z - sphere.w).max(at(-sphere.z + sphere.w))
    }
}
