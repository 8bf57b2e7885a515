//! The window, driven as a user drives it: by the names of its inputs and by the mouse.

#![cfg(feature = "window")]

mod common;

use common::window::{Window, choose, click, drag, point, settle, small, type_number, unfold_method, window};
use defocus_app::window::{App, Arrangement, Document, MethodChoice, PaneId, Show};
use eframe::egui::{self, Role, pos2, vec2};
use egui_kittest::SnapshotOptions;
use egui_kittest::kittest::Queryable;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// The first pane's method.
fn method(window: &Window) -> &MethodChoice {
    &window.state().document().panes[0].method
}

/// Lens points that the first pane's reference has and will have.
fn progress(window: &Window) -> Option<(u32, u32)> {
    window.state().engine().pane(PaneId(1)).expect("there is a pane").progress()
}

#[test]
fn first_start_shows_a_blurred_scene_and_then_rests() {
    let mut window = small(&["mipmap"]);
    assert_eq!(window.state().document().scene, "cans");
    assert!(window.state().document().lens.k_px() > 1.0, "there is visible blur");
    let frames = window.state().engine().rendered_frames();
    assert!(frames > 0);
    for _ in 0..8 {
        window.step();
    }
    assert_eq!(window.state().engine().rendered_frames(), frames, "nothing is rendered while nothing changes");
    let root = &window.output().viewport_output[&egui::ViewportId::ROOT];
    assert!(
        root.repaint_delay > Duration::from_secs(60),
        "no repaint is asked for, but one in {:?}",
        root.repaint_delay
    );
    window.check_accessibility();
}

#[test]
fn lens_inputs_change_the_lens_and_draw_no_triangle() {
    let mut window = small(&["mipmap"]);
    let frames = window.state().engine().rendered_frames();
    type Read = fn(&App) -> f64;
    let inputs: [(&str, &str, Read, f64); 6] = [
        ("Aperture E", "6.5", |app| app.document().lens.aperture_diameter_mm, 6.5),
        ("Focal length F", "18", |app| app.document().lens.focal_length_mm, 18.0),
        ("Image at dr", "23", |app| app.document().lens.image_distance_mm, 23.0),
        ("Screen at ds", "2500", |app| app.document().lens.screen_distance_mm, 2500.0),
        ("Screen DPI", "0.5", |app| app.document().lens.density_px_per_mm, 0.5),
        ("Focus distance", "0.8", |app| app.document().lens.focus_distance_m, 0.8),
    ];
    for (name, text, value, expected) in inputs {
        type_number(&mut window, name, text);
        assert_eq!(value(window.state()), expected, "{name}");
        assert_eq!(window.state().engine().stats().triangles, 0, "{name} must not redraw the scene");
    }
    assert!(window.state().engine().rendered_frames() > frames, "the blur was rendered anew");
    assert!(!window.state().document().automatic_lens, "the lens is the user's own now");
}

#[test]
fn an_impossible_lens_is_told_and_the_picture_stays() {
    let mut window = small(&["mipmap"]);
    let frames = window.state().engine().rendered_frames();
    type_number(&mut window, "Focal length F", "900");
    let problem = window.state().problem().expect("the focus lies inside the focal length").to_owned();
    assert!(problem.contains("focal length") && problem.contains("move the focus farther"), "{problem}");
    assert_eq!(window.state().engine().rendered_frames(), frames);
    type_number(&mut window, "Focal length F", "20");
    assert_eq!(window.state().problem(), None);
}

#[test]
fn method_and_its_parameters_can_be_set() {
    let mut window = small(&["pinhole"]);
    choose(&mut window, "Method of pane 1", "Anisotropic mipmaps");
    assert_eq!(method(&window), &MethodChoice::new("mipmap"));
    unfold_method(&mut window);
    // The panel scrolls: the switch may lie below the window's edge.
    window.get_by_role_and_label(Role::CheckBox, "Anisotropic weights").click_accesskit();
    settle(&mut window);
    assert_eq!(method(&window).params["anisotropic"], "off");
}

#[test]
fn a_click_focuses_on_what_lies_under_the_pointer() {
    let mut window = small(&["mipmap"]);
    let depth = |window: &mut Window, x, y| window.state_mut().depth_at_m(glam::dvec2(x, y)).expect("there is a view");
    for (x, y) in [(0.35, 0.75), (0.8, 0.45)] {
        let expected = depth(&mut window, f64::from(x), f64::from(y));
        let at = point(&window, x, y);
        click(&mut window, at);
        let focus = window.state().document().lens.focus_distance_m;
        // The same texel of the same depth image.
        assert_eq!(focus, expected, "at ({x}, {y})");
        assert_eq!(window.state().engine().stats().triangles, 0, "focus never redraws the scene");
    }
    assert!(depth(&mut window, 0.35, 0.75) < depth(&mut window, 0.8, 0.45), "the two points differ in depth");
}

#[test]
fn dragging_orbits_and_the_divider_wipes() {
    let document = Document::of_methods(["mipmap", "pinhole"].map(MethodChoice::new));
    let mut window = window([900.0, 420.0], Document { arrangement: Arrangement::Wipe, ..document });
    let camera = window.state().document().camera.expect("a scene has a camera");
    let (from, to) = (point(&window, 0.5, 0.3), point(&window, 0.2, 0.3));
    drag(&mut window, from, to);
    assert!((window.state().document().divider - 0.2).abs() < 0.02, "{}", window.state().document().divider);
    assert_eq!(window.state().document().camera, Some(camera), "the divider does not move the camera");
    let (from, to) = (point(&window, 0.7, 0.6), point(&window, 0.8, 0.55));
    drag(&mut window, from, to);
    let moved = window.state().document().camera.expect("a scene has a camera");
    assert!(moved.position.distance(camera.position) > 1e-3, "dragging moves the camera");
}

#[test]
fn the_reference_converges_and_starts_again_on_a_change() {
    let mut choice = MethodChoice::new("accumulation");
    choice.params.insert("samples".into(), "6".into());
    let document = Document { overscan_px: 0, ..Document::of_methods([choice]) };
    let mut window = window([560.0, 320.0], document);
    assert_eq!(progress(&window), Some((6, 6)));
    type_number(&mut window, "Aperture E", "3");
    assert_eq!(progress(&window), Some((6, 6)));
    let frames = window.state().engine().rendered_frames();
    window.run_steps(4);
    assert_eq!(window.state().engine().rendered_frames(), frames, "a finished reference rests");
}

#[test]
fn shows_what_is_behind_the_picture() {
    let mut window = small(&["mipmap"]);
    for (entry, show) in Show::NAMES.into_iter().skip(1).zip([Show::Coc, Show::Depth, Show::Zone]) {
        choose(&mut window, "Shown in pane 1", entry);
        assert_eq!(window.state().document().panes[0].show, show);
        assert_eq!(window.state().engine().stats().triangles, 0, "{entry} comes from what is there");
    }
}

#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|e| e.to_string())
    }
}

#[test]
fn a_damaged_file_is_told_and_the_scene_stays() {
    let mut window = small(&["pinhole"]);
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let file = folder.path().join("broken.glb");
    std::fs::write(&file, b"glTF\x02\0\0\0 this is not a scene").expect("a temporary file can be written");
    window.input_mut().dropped_files.push(Arc::new(Dropped(file)));
    settle(&mut window);
    let error = window.state().last_error().expect("an error is shown").to_owned();
    assert!(error.contains("broken.glb"), "{error}");
    assert_eq!(window.state().document().scene, "cans");
    let at = point(&window, 0.35, 0.75);
    click(&mut window, at);
    assert!(window.state().document().lens.focus_distance_m.is_finite(), "the scene is still there to be focused on");
}

#[test]
fn a_window_shrunk_to_nothing_survives() {
    let mut window = small(&["mipmap"]);
    for size in [[40.0, 30.0], [1.0, 1.0], [330.0, 60.0], [720.0, 420.0]] {
        window.set_size(vec2(size[0], size[1]));
        window.run_steps(3);
    }
    settle(&mut window);
    assert_eq!(window.state().problem(), None);
}

#[test]
fn main_window_looks_as_it_did() {
    let mut window = window([1280.0, 800.0], Document::of_methods([MethodChoice::new("pinhole")]));
    // Times and the adapter's name differ from run to run and from machine to machine.
    window.mask(egui::Rect::from_min_max(pos2(360.0, 770.0), pos2(1280.0, 800.0)));
    window.mask(egui::Rect::from_min_max(pos2(965.0, 330.0), pos2(1280.0, 770.0)));
    window.mask(egui::Rect::from_min_max(pos2(700.0, 746.0), pos2(965.0, 770.0)));
    // 2 % of the pixels: another GPU rounds textures and triangle edges differently; a
    // moved or missing control changes more than that.
    let tolerance = SnapshotOptions::new().threshold(1.0).max_failed_pixels(20_480);
    window.snapshot_options("main_window", &tolerance);
}
