//! Every real scene and image of the shared data, where it is there, without a special case.

use defocus::image_io;
use defocus::scene::gltf;
use defocus::scene::rgbd::{self, DepthEncoding, DepthKind};
use std::path::Path;

/// The folder of real data beside the repository, where there is one.
fn shared(folder: &str) -> Option<std::path::PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared").join(folder);
    if !path.is_dir() {
        eprintln!("{} is absent: no real files are tried", path.display());
        return None;
    }
    Some(path)
}

#[test]
fn scenes_load_and_are_sound() {
    let Some(folder) = shared("scenes") else { return };
    let files = std::fs::read_dir(folder).expect("can be listed").map(|entry| entry.expect("an entry").path());
    let mut count = 0;
    for path in files.filter(|path| path.extension().is_some_and(|e| e == "glb" || e == "gltf")) {
        let scene = gltf::load(&path).unwrap_or_else(|e| panic!("{e}"));
        count += 1;
        eprintln!(
            "{}: {} triangles, {} textures, {:?}",
            scene.name,
            scene.triangle_count(),
            scene.textures.len(),
            scene.notes
        );
        assert!(scene.triangle_count() > 100 && !scene.cameras.is_empty());
        let unit = |v: glam::Vec3| (v.length() - 1.0).abs() < 1e-4;
        for mesh in &scene.meshes {
            assert!(mesh.indices.len() % 3 == 0 && mesh.material < scene.materials.len());
            assert!(mesh.indices.iter().all(|&i| (i as usize) < mesh.vertices.len()));
            assert!(
                mesh.vertices.iter().all(|v| unit(v.normal) && unit(v.tangent.truncate()) && v.tangent.w.abs() == 1.0),
                "{}",
                mesh.name
            );
        }
    }
    assert!(count > 0, "no scene was found");
}

#[test]
fn images_with_depth_load() {
    let Some(folder) = shared("rgbd") else { return };
    let mut count = 0;
    for entry in std::fs::read_dir(folder).expect("can be listed") {
        let folder = entry.expect("an entry").path();
        let Ok(meta) = std::fs::read_to_string(folder.join("meta.json")) else { continue };
        let meta: serde_json::Value = serde_json::from_str(&meta).expect("JSON");
        for (color, depth, encoding) in pairs(&folder, &meta) {
            let scene = rgbd::load(&color, depth.as_deref(), &encoding, 0.8).unwrap_or_else(|e| panic!("{e}"));
            count += 1;

            let (near, far) =
                scene.depth.pixels.iter().fold((f32::INFINITY, 0.0_f32), |(lo, hi), &d| (lo.min(d), hi.max(d)));
            eprintln!("{}: {} px, {near} to {far} m, {:?}", color.display(), scene.depth.size, scene.notes);
            assert!(scene.depth.pixels.iter().all(|d| *d > 0.0) && scene.color.pixels.iter().all(|c| c.is_finite()));
            let range = meta.get("range_m").or(meta.get("range")).and_then(|range| range[0].as_f64()).expect("a range");
            assert!((f64::from(near) - range).abs() < 0.01 * range, "{}: {near} instead of {range}", color.display());
            let unknown = meta["unknown_fraction"].as_f64().or_else(|| Some(1.0 - meta["covered_fraction"].as_f64()?));
            if let Some(unknown) = unknown {
                assert!((scene.unknown_share - unknown).abs() < 1e-6, "{}: {}", color.display(), scene.unknown_share);
            }
        }
    }
    assert!(count > 0, "no image was found");
}

type Pair = (std::path::PathBuf, Option<std::path::PathBuf>, DepthEncoding);

/// Every colour with every depth that a folder offers.
fn pairs(folder: &Path, meta: &serde_json::Value) -> Vec<Pair> {
    let existing =
        |names: &[&str]| names.iter().map(|name| folder.join(name)).filter(|path| path.is_file()).collect::<Vec<_>>();
    let per_unit = meta["depth_scale"].as_f64().or(meta["depth_scale_u16"].as_f64()).unwrap_or(1.0);
    let unknown = Some(0.0);
    let own = existing(&["rgbaz_right.exr", "flat_rgbaz.exr", "multipart.0001.exr"]);
    let mut pairs: Vec<Pair> =
        own.into_iter().map(|color| (color, None, DepthEncoding { unknown, ..DepthEncoding::METRES })).collect();
    for color in existing(&["rgb.png", "rgb.jpg"]) {
        for depth in existing(&["depth_u16.png", "depth_m.exr", "flat_rgbaz.exr"]) {
            let is_png = depth.extension().is_some_and(|e| e == "png");
            let kind = DepthKind::Metres { per_unit: if is_png { per_unit } else { 1.0 } };
            pairs.push((color.clone(), Some(depth), DepthEncoding { kind, unknown, infinity: None }));
        }
    }
    pairs
}

#[test]
fn deep_files_are_refused_clearly() {
    let Some(folder) = shared("rgbd/openexr_deep_trees") else { return };
    for name in ["Balls_deep.exr", "Leaves_deep.exr", "Trunks_deep.exr"] {
        let path = folder.join(name);
        let message = image_io::read_color(&path).expect_err("deep data").to_string();
        assert!(message.contains(name) && message.contains("deep data") && message.contains("flatten"), "{message}");
        let message = rgbd::load(&path, None, &DepthEncoding::METRES, 0.8).expect_err("deep data").to_string();
        assert!(message.contains(name) && message.contains("deep data"), "{message}");
    }
}

/// The single-part file was made from one view of the ten-part one.
#[test]
fn a_part_of_a_multi_part_file_is_the_single_part_file() {
    let Some(folder) = shared("rgbd/openexr_beachball") else { return };
    let encoding = DepthEncoding { unknown: Some(0.0), ..DepthEncoding::METRES };
    let [many, one] = ["multipart.0001.exr", "rgbaz_right.exr"]
        .map(|name| rgbd::load(&folder.join(name), None, &encoding, 0.8).unwrap_or_else(|e| panic!("{e}")));
    assert!(many.color == one.color && many.depth == one.depth);
}
