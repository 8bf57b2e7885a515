//! A scene in another unit of length, for files whose numbers are not metres.

use defocus::scene::{LightKind, Scene};
use glam::DAffine3;

/// Factors that a scene may be scaled by: from files in micrometres to files in kilometres.
pub const SCENE_SCALE: std::ops::RangeInclusive<f64> = 1e-6..=1e3;

/// The scene with every length `factor` times as long, seen and lit as before: distances,
/// cameras and lights grow together, and a light's candela with the square, so that its
/// illuminance stays.
///
/// The lens and frame that a scene is made for go: they are those of its own lengths.
pub fn scaled(scene: &Scene, factor: f64) -> Scene {
    let mut scene = scene.clone();
    let grown = DAffine3::from_scale(glam::DVec3::splat(factor));
    for instance in &mut scene.instances {
        instance.world_from_object = grown * instance.world_from_object;
    }
    for light in &mut scene.lights {
        match &mut light.kind {
            LightKind::Directional { .. } => {}
            LightKind::Point { position, range_m } | LightKind::Spot { position, range_m, .. } => {
                *position *= factor;
                *range_m *= factor;
                light.intensity *= (factor * factor) as f32;
            }
        }
    }
    for named in &mut scene.cameras {
        named.camera.position *= factor;
        named.camera.near_m *= factor;
    }
    scene.focus_hint_m = scene.focus_hint_m.map(|m| m * factor);
    scene.made_for = None;
    scene.notes.push(format!("every length is {factor} times that of the file, as was asked for"));
    scene
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_seen_and_how_it_is_lit_stays() {
        let file = crate::builtin::builtin("cans").expect("a built-in scene");
        let scene = file.load().expect("it can be read");
        let small = scaled(&scene, 0.01);
        assert_eq!(small.meshes.len(), scene.meshes.len());
        for (a, b) in scene.instances.iter().zip(&small.instances) {
            let point = glam::DVec3::new(0.3, -0.2, 0.7);
            let [a, b] = [a, b].map(|i| i.world_from_object.transform_point3(point));
            assert!((a * 0.01 - b).length() < 1e-9 * a.length().max(1.0), "{a} and {b}");
        }
        for (a, b) in scene.cameras.iter().zip(&small.cameras) {
            assert!((a.camera.position * 0.01 - b.camera.position).length() < 1e-12);
            assert_eq!(a.camera.fov_y, b.camera.fov_y);
        }
        for (a, b) in scene.lights.iter().zip(&small.lights) {
            // Illuminance at a point that moves with the scene.
            let lux = |light: &defocus::scene::Light, factor: f64| match light.kind {
                LightKind::Directional { .. } => light.intensity.x,
                LightKind::Point { position, .. } | LightKind::Spot { position, .. } => {
                    let at = glam::DVec3::new(1.0, 2.0, 3.0) * factor;
                    light.intensity.x / (position - at).length_squared() as f32
                }
            };
            assert!((lux(a, 1.0) / lux(b, 0.01) - 1.0).abs() < 1e-3);
        }
        assert!(small.notes.last().is_some_and(|note| note.contains("0.01 times")));
    }
}
