//! Where to focus: areas, objects, and an eye that takes its time.
//!
//! Everything that moves the focus by itself moves it in dioptres (reciprocal metres): the
//! CoC is affine in them, so equal steps look equal, and infinity is a number like others.

use crate::camera::{Camera, Projection};
use crate::image::DepthImage;
use glam::{DVec2, DVec3, UVec2};

/// Time constant of [`Accommodation`], seconds, unless another is chosen.
///
/// Responses of the accommodation to a step are fitted well by exponentials (Kasthurirangan
/// and Glasser, "Influence of Amplitude and Starting Point on Accommodative Dynamics in
/// Humans", IOVS 46, 2005). An exponential with this constant goes from 10 % to 90 % of a
/// step in `ln 9 * 0.3 = 0.66` s; Campbell and Westheimer, "Dynamics of Accommodation
/// Responses of the Human Eye" (Journal of Physiology 151, 1960), measured 0.64 s from far
/// to near and 0.56 s back. The latency of 0.37 s before the response is left out: what the
/// pointer stands for is known without it.
pub const ACCOMMODATION_SECONDS: f64 = 0.3;

/// A focus so near to its target, dioptres, has arrived: the depth of focus of the eye is
/// ten times as large (Campbell, "The Depth of Field of the Human Eye", Optica Acta 4, 1957,
/// has 0.3 dioptres and more).
const ARRIVED_DPT: f64 = 0.01;

/// A distance in dioptres; 0 for infinity.
pub fn dioptres(distance_m: f64) -> f64 {
    1.0 / distance_m
}

/// A distance in metres; infinite for 0 dioptres and below, as relaxed as an eye can be.
pub fn metres(vergence_dpt: f64) -> f64 {
    if vergence_dpt > 0.0 { 1.0 / vergence_dpt } else { f64::INFINITY }
}

/// An eye's focus under way: a first-order response in dioptres.
///
/// ```text
/// dD/dt = (target - D) / time_constant
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accommodation {
    state_dpt: f64,
}

impl Accommodation {
    /// An eye at rest, focused at `distance_m`.
    pub fn at(distance_m: f64) -> Self {
        Self { state_dpt: dioptres(distance_m) }
    }

    /// Where it is focused now, metres.
    pub fn distance_m(&self) -> f64 {
        metres(self.state_dpt)
    }

    /// Goes on for `dt_s` seconds towards `target_m`, exactly: two half steps are one whole
    /// step. Arrives at once where the time constant is not above 0. Returns whether it has
    /// arrived; then it is focused at `target_m` itself.
    pub fn advance(&mut self, target_m: f64, time_constant_s: f64, dt_s: f64) -> bool {
        let target_dpt = dioptres(target_m);
        let left = if time_constant_s > 0.0 { (-dt_s.max(0.0) / time_constant_s).exp() } else { 0.0 };
        self.state_dpt = target_dpt + (self.state_dpt - target_dpt) * left;
        let arrived = (self.state_dpt - target_dpt).abs() <= ARRIVED_DPT;
        if arrived {
            self.state_dpt = target_dpt;
        }
        arrived
    }
}

/// Median depth, metres, of the square of `2 * radius_px + 1` pixels around a point of the
/// image given from (0, 0) top left to (1, 1), as far as it lies inside. A single pixel
/// between leaves does not decide where to focus; an edge does not give a depth between.
/// `None` for an empty image.
pub fn area_depth_m(depth_m: &DepthImage, at: DVec2, radius_px: u32) -> Option<f64> {
    if depth_m.size.min_element() == 0 {
        return None;
    }
    let centre = pixel(depth_m.size, at);
    let low = centre.saturating_sub(UVec2::splat(radius_px));
    let high = centre.saturating_add(UVec2::splat(radius_px)).min(depth_m.size - 1);
    let row = |y| (low.x..=high.x).map(move |x| depth_m.at(x, y));
    let mut depths: Vec<f32> = (low.y..=high.y).flat_map(row).collect();
    let middle = (depths.len() - 1) / 2;
    let (_, median, _) = depths.select_nth_unstable_by(middle, f32::total_cmp);
    Some(f64::from(*median))
}

/// The pixel under a point of an image given from (0, 0) top left to (1, 1).
pub fn pixel(size: UVec2, at: DVec2) -> UVec2 {
    let at = if at.is_finite() { at } else { DVec2::splat(0.5) };
    (at.clamp(DVec2::ZERO, DVec2::ONE) * size.as_dvec2()).as_uvec2().min(size.saturating_sub(UVec2::ONE))
}

/// The point in world space, metres, that a camera shows at `at` (from (0, 0) to (1, 1)) at
/// a depth of `depth_m`; `None` for what is infinitely far, which has no place.
pub fn world_point(camera: &Camera, projection: &Projection, at: DVec2, depth_m: f64) -> Option<DVec3> {
    let direction = projection.view_direction(at * projection.size.as_dvec2());
    let point = camera.position + camera.orientation * (direction * depth_m);
    point.is_finite().then_some(point)
}

/// Depth, metres, of a point in world space along a camera's optical axis; `None` where it
/// is nearer than the near plane or behind the camera.
pub fn depth_of_m(camera: &Camera, world: DVec3) -> Option<f64> {
    let depth_m = (world - camera.position).dot(camera.forward());
    (depth_m >= camera.near_m && depth_m > 0.0).then_some(depth_m)
}
