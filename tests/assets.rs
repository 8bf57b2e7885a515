//! The built-in scenes: what they promise, and that their program still makes them.

#[path = "../examples/make_scenes/generate/mod.rs"]
mod generate;

use defocus::scene::builtin;

#[test]
fn built_in_scenes_load_as_described() {
    let names: Vec<&str> = builtin::all().iter().map(|scene| scene.name).collect();
    assert_eq!(names, generate::NAMES, "the table and the generator must list the same scenes");
    for entry in builtin::all() {
        let scene = entry.load().unwrap_or_else(|e| panic!("{}: {e}", entry.name));
        assert_eq!(scene.name, entry.name);
        assert!(scene.notes.is_empty(), "{}: something was approximated: {:?}", entry.name, scene.notes);
        assert!(!scene.lights.is_empty(), "{} has lights of its own", entry.name);
        // Enough that drawing counts, little enough for software rendering.
        assert!((100_000..1_300_000).contains(&scene.triangle_count()), "{}: {}", entry.name, scene.triangle_count());
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

#[test]
fn a_scene_is_made_again_byte_for_byte() {
    let entry = builtin::builtin("handrail").expect("it is in the table");
    let stage = generate::stage(entry.name).expect("the generator knows it");
    let made = generate::glb::write(&stage);
    // Exact: integer noise, one order of operations, and positions rounded to 2^-16 m.
    assert!(made == entry.glb, "handrail.glb is not what make_scenes makes: run it, and look at the result");
}
