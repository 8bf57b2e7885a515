//! Moving the camera: around a point, along the image, on the wing. World +y stays up.

use defocus::camera::Camera;
use glam::{DQuat, DVec2, DVec3, UVec2};

/// Turn for a drag over the height of the viewport, radians.
const TURN_PER_HEIGHT: f64 = std::f64::consts::PI;

/// How steep the camera may look up or down: at 90 degrees up and north are the same.
const MAX_SINE: f64 = 0.9998;

/// The orbited point comes no nearer than this many near planes.
const LEAST_PIVOT_NEARS: f64 = 2.0;

/// The orientation turned by a drag (fraction of the viewport's height, y down): to the
/// sides about the world's up axis, up and down about the camera's own right axis.
fn turned(orientation: DQuat, drag: DVec2) -> DQuat {
    let yaw = DQuat::from_rotation_y(-drag.x * TURN_PER_HEIGHT);
    let sideways = (yaw * orientation).normalize();
    let pitched = (sideways * DQuat::from_rotation_x(-drag.y * TURN_PER_HEIGHT)).normalize();
    let steepness = |q: DQuat| (q * DVec3::NEG_Z).y.abs();
    // A camera that starts out steeper may still come back.
    let allowed = steepness(pitched) <= MAX_SINE.max(steepness(orientation));
    if allowed { pitched } else { sideways }
}

/// Moves around the point `pivot_m` metres ahead.
pub fn orbit(camera: &mut Camera, pivot_m: f64, drag: DVec2) {
    let pivot = camera.position + camera.forward() * pivot_m;
    camera.orientation = turned(camera.orientation, drag);
    camera.position = pivot - camera.forward() * pivot_m;
}

/// Turns on the spot.
pub fn look(camera: &mut Camera, drag: DVec2) {
    // What is dragged goes with the pointer, as it does while orbiting.
    camera.orientation = turned(camera.orientation, -drag);
}

/// Moves across so that what lies `pivot_m` ahead follows the pointer, which moved by
/// `drag_px` in a frame of `size`.
pub fn pan(camera: &mut Camera, pivot_m: f64, drag_px: DVec2, size: UVec2) {
    let metres_per_px = pivot_m / camera.projection(size, 0).focal_px;
    let across = DVec3::new(-drag_px.x, drag_px.y, 0.0) * metres_per_px;
    camera.position += camera.orientation * across;
}

/// Comes nearer (`factor` below 1) to the point `pivot_m` ahead, or goes away from it;
/// returns its new distance.
pub fn zoom(camera: &mut Camera, pivot_m: f64, factor: f64) -> f64 {
    let nearer = (pivot_m * factor).max(camera.near_m * LEAST_PIVOT_NEARS);
    camera.position += camera.forward() * (pivot_m - nearer);
    nearer
}

/// Flies by `along` metres in view space (x right, y up, z back).
pub fn fly(camera: &mut Camera, along: DVec3) {
    camera.position += camera.orientation * along;
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{dvec2, uvec2};

    fn camera() -> Camera {
        Camera::look_at(DVec3::new(1.0, 2.0, 5.0), DVec3::new(1.0, 1.0, 0.0), 0.8, 0.1)
    }

    #[test]
    fn orbiting_keeps_the_pivot_and_its_distance() {
        let mut moved = camera();
        let pivot = moved.position + moved.forward() * 3.0;
        for _ in 0..40 {
            orbit(&mut moved, 3.0, dvec2(0.07, 0.11));
            assert!((moved.position + moved.forward() * 3.0 - pivot).length() < 1e-12);
        }
        let right = moved.orientation * DVec3::X;
        assert!(right.y.abs() < 1e-9, "the horizon stays level, right is {right}");
        assert!(moved.forward().y.abs() <= MAX_SINE);
    }

    #[test]
    fn panning_moves_the_pivot_with_the_pointer() {
        let (mut moved, size) = (camera(), uvec2(640, 480));
        let pivot = moved.position + moved.forward() * 3.0;
        pan(&mut moved, 3.0, dvec2(40.0, -25.0), size);
        let seen = moved.view_from_world().transform_point3(pivot);
        let px = moved.projection(size, 0).focal_px / -seen.z;
        assert!((dvec2(seen.x, -seen.y) * px - dvec2(40.0, -25.0)).length() < 1e-9);
    }

    #[test]
    fn zooming_never_passes_the_pivot() {
        let mut moved = camera();
        let pivot = moved.position + moved.forward() * 3.0;
        let mut distance = 3.0;
        for _ in 0..200 {
            distance = zoom(&mut moved, distance, 0.7);
            assert!((moved.position.distance(pivot) - distance).abs() < 1e-9);
        }
        assert!(distance > 0.0);
    }
}
