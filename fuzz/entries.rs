//! What the fuzz targets and the smoke run in the tests feed bytes to. Each entry panics if
//! the program does not keep its word, and returns whether it accepted the input.

use defocus::presets::LensPreset;
use defocus::scene::Scene;
use defocus::scene::rgbd::{DepthEncoding, DepthKind};
use defocus::scene::{gltf as loader, rgbd};
use defocus_app::window;
use std::path::Path;

/// An error is for one line on a terminal.
fn one_line(error: &dyn std::fmt::Display) {
    let message = error.to_string();
    assert!(!message.is_empty() && !message.contains('\n'), "not one line: {message}");
}

/// A scene file.
pub fn gltf(data: &[u8]) -> bool {
    let file = match loader::Animated::from_bytes("fuzzed.glb", data) {
        Ok(file) => file,
        Err(error) => {
            one_line(&error);
            return false;
        }
    };
    check_scene(file.at_rest());
    if !file.at_rest().animations.is_empty() {
        match file.at(&loader::Moment { animation: None, time_s: 0.4 }) {
            Ok(posed) => check_scene(&posed),
            Err(error) => one_line(&error),
        }
    }
    true
}

/// A scene holds what the renderers rely on.
fn check_scene(scene: &Scene) {
    assert!(scene.triangle_count() > 0 && !scene.cameras.is_empty());
    for mesh in &scene.meshes {
        assert!(mesh.material < scene.materials.len(), "a material that is not there");
        assert!(mesh.indices.iter().all(|i| (*i as usize) < mesh.vertices.len()), "an index out of range");
        assert!(mesh.vertices.iter().all(|v| v.position.is_finite() && v.normal.is_finite()), "a vertex nowhere");
    }
    assert!(scene.instances.iter().all(|i| i.mesh < scene.meshes.len() && i.world_from_object.is_finite()));
    for camera in scene.cameras.iter().map(|c| c.camera) {
        assert!(camera.position.is_finite() && camera.fov_y > 0.0 && camera.near_m > 0.0, "{camera:?}");
    }
}

/// Encodings of depth by the first byte.
fn encoding(byte: u8) -> DepthEncoding {
    let kind = match byte % 8 {
        0 => DepthKind::Metres { per_unit: 0.001 },
        1 => DepthKind::Inverse { near_m: 0.1, far_m: f64::INFINITY },
        2 => DepthKind::Device { near_m: 0.1, far_m: 100.0 },
        3 => DepthKind::Metres { per_unit: 1e-30 },
        4 => DepthKind::Distance { per_unit: 1.0 },
        5 => DepthKind::Relative { near_m: 0.1, far_m: f64::INFINITY },
        6 => DepthKind::Dioptres { per_unit: 1.0 },
        _ => DepthKind::Disparity { focal_px: 500.0, baseline_m: 0.1, offset_px: -3.0, per_unit: 1.0 },
    };
    DepthEncoding { kind, unknown: (byte & 0x80 != 0).then_some(0.0), infinity: None }
}

/// A colour image with its depth map; without any byte of depth, an EXR that holds both.
pub fn image_depth(data: &[u8]) -> bool {
    let Some((&[kind, low, high], rest)) = data.split_first_chunk::<3>() else { return false };
    let length = usize::from(u16::from_le_bytes([low, high])).min(rest.len());
    let (color, depth) = rest.split_at(length);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("the temporary folder can be written");
        path
    };
    let color_path = write("color", color);
    let depth_path = (!depth.is_empty()).then(|| write("depth", depth));
    match rgbd::load(&color_path, depth_path.as_deref().map(Path::new), &encoding(kind), 0.8) {
        Ok(scene) => {
            assert_eq!(scene.color.size, scene.depth.size);
            assert!(scene.color.pixels.iter().all(|c| c.is_finite()), "a colour that is no number");
            assert!(scene.depth.pixels.iter().all(|d| *d > 0.0), "a depth that is none");
            true
        }
        Err(error) => {
            one_line(&error);
            false
        }
    }
}

/// Lens presets.
pub fn presets(data: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(data) else { return false };
    let Ok(presets) = ron::from_str::<Vec<LensPreset>>(text) else { return false };
    let good = presets.iter().filter(|preset| check_lens(&preset.lens)).count();
    good == presets.len()
}

/// A lens that passes its check has numbers for the shaders.
fn check_lens(lens: &defocus::lens::Lens) -> bool {
    if let Err(error) = lens.check() {
        one_line(&error);
        return false;
    }
    let coc = lens.coc();
    assert!(coc.k_px.is_finite() && coc.k_df_px_m.is_finite(), "{lens:?}");
    assert!(lens.aperture.lens_points(8).iter().all(|v| v.is_finite()), "{lens:?}");
    assert!(lens.aperture.radius().is_finite() && lens.aperture.sigma_per_coc() > 0.0, "{lens:?}");
    true
}

/// A saved state of the window.
pub fn state(data: &[u8]) -> bool {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("fuzzed.ron");
    std::fs::write(&file, data).expect("the temporary folder can be written");
    let document = match window::read_state(&file) {
        Ok(document) => document,
        Err(error) => {
            one_line(&error);
            return false;
        }
    };
    assert!(!document.panes.is_empty());
    let built = document.panes.iter().fold(true, |all, pane| match pane.method.build() {
        Ok(_) => all,
        Err(error) => {
            one_line(&error);
            false
        }
    });
    check_lens(&document.lens) && built
}
