//! The built-in scenes: what they promise, and that their program still makes them.

#[path = "../examples/make_scenes/generate/mod.rs"]
mod generate;

use defocus_study::builtin;

#[test]
fn built_in_scenes_load_as_described() {
    let names: Vec<&str> = builtin::all().iter().map(|scene| scene.name).collect();
    assert_eq!(names, generate::NAMES, "the table and the generator must list the same scenes");
    for entry in builtin::all() {
        let scene = entry.load().unwrap_or_else(|e| panic!("{}: {e}", entry.name));
        assert_eq!(scene.name, entry.name);
        // Where light comes from is always noted, and what is seen through; nothing else may be.
        let known = ["light:", "environment:", "light passes transmissive", "what blended and transmissive"];
        let other: Vec<_> =
            scene.notes.iter().filter(|note| !known.iter().any(|known| note.starts_with(known))).collect();
        assert!(other.is_empty(), "{}: something was approximated: {other:?}", entry.name);
        assert!(!scene.lights.is_empty(), "{} has lights of its own", entry.name);
        // Enough that drawing counts, little enough for software rendering.
        assert!((40_000..1_300_000).contains(&scene.triangle_count()), "{}: {}", entry.name, scene.triangle_count());
        let focus_m = scene.focus_hint_m.unwrap_or_else(|| panic!("{} recommends a focus distance", entry.name));
        assert!(focus_m > scene.cameras[0].camera.near_m);
        for named in &scene.cameras {
            let aspect = named.camera.aspect.unwrap_or_else(|| panic!("{} says its aspect", named.name));
            // The file holds the aspect as written from an f64.
            assert!((aspect - 4.0 / 3.0).abs() < 1e-6, "{}: {aspect}", named.name);
        }
    }
    assert!(builtin::builtin("no such scene").is_none());
}

/// Byte for byte but for the baked light, which takes half a minute unoptimised:
/// `make_scenes --check` compares that too.
#[test]
fn a_scene_is_made_again_byte_for_byte() {
    let entry = builtin::builtin("branches").expect("it is in the table");
    let mut stage = generate::unlit(entry.name).expect("the generator knows it");
    let made = generate::glb::write(&stage);
    // Exact: integer noise, one order of operations, and positions rounded to 2^-16 m.
    let stored = without_colours(&entry.glb());
    assert!(without_colours(&made) == stored, "branches.glb is not what make_scenes makes: run it, and look");
    stage.nodes.pop();
    assert!(without_colours(&generate::glb::write(&stage)) != stored, "a missing node must show");
}

/// The light of a small stage: a corner under a roof is darker than one beside it, and
/// baking twice gives the same.
#[test]
fn baked_light_is_repeatable_and_darkens_what_is_covered() {
    use generate::shape::Shape;
    use generate::stage::{Material, Sky, Stage};
    use glam::{Vec3, vec3};
    let tints = || {
        let grey = Vec3::splat(0.3);
        let sky = Sky { zenith: grey, horizon: grey, ground: grey, softbox: 0.0 };
        let mut stage = Stage { sky, occlusion_m: 1.0, ..Stage::default() };
        let material = stage.material(Material::default());
        stage.sun(Vec3::splat(3.0), Vec3::NEG_Y, 0.01);
        stage.place(Shape::cuboid(Vec3::ZERO, vec3(4.0, 0.1, 4.0), 0.5), material);
        stage.place(Shape::cuboid(vec3(1.0, 0.3, 0.0), vec3(1.0, 0.1, 1.0), 0.5), material);
        generate::bake::bake(&mut stage);
        let top = stage.meshes[0].0.corners.iter().filter(|c| c.normal.y > 0.5);
        top.map(|c| (c.position, c.tint)).collect::<Vec<_>>()
    };
    let first = tints();
    assert_eq!(first, tints());
    let at = |x: f32| first.iter().find(|(p, _)| p.x == x && p.z == 0.0).expect("a corner of the grid").1.x;
    assert_eq!(at(-1.0), 1.0, "nothing is above it");
    // Direct light is 3/pi of 3/pi + 0.3 in all, and none of it arrives.
    assert!(at(1.0) < 0.3 / (0.3 + 3.0 / std::f32::consts::PI), "{}", at(1.0));
}

/// A binary glTF with its vertex colours zeroed.
fn without_colours(file: &[u8]) -> Vec<u8> {
    let mut file = file.to_vec();
    let text = u32::from_le_bytes(file[12..16].try_into().expect("four bytes")) as usize;
    let document: serde_json::Value = serde_json::from_slice(&file[20..20 + text]).expect("the writer's JSON");
    let number = |value: &serde_json::Value| value.as_u64().expect("an index or a size") as usize;
    for mesh in document["meshes"].as_array().expect("meshes") {
        let accessor = number(&mesh["primitives"][0]["attributes"]["COLOR_0"]);
        let view = &document["bufferViews"][number(&document["accessors"][accessor]["bufferView"])];
        let start = 28 + text + number(&view["byteOffset"]);
        file[start..start + number(&view["byteLength"])].fill(0);
    }
    file
}
