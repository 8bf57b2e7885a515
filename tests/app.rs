//! The window, driven as a user drives it: by the names of its inputs and by the mouse.

#![cfg(feature = "app")]

use defocus::app::{App, AppOptions, Arrangement, Document, MethodChoice, PaneId, Show, apply_style, wgpu_setup};
use eframe::egui::{self, Modifiers, PointerButton, Pos2, Role, pos2, vec2};
use eframe::egui_wgpu::RendererOptions;
use egui_kittest::kittest::Queryable;
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state};
use egui_kittest::{Harness, SnapshotOptions};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

type Window = Harness<'static, App>;

/// A window of `size` points that starts with `document`, once it has settled.
fn window(size: [f32; 2], document: Document) -> Window {
    let state = create_render_state(wgpu_setup(None), RendererOptions::PREDICTABLE);
    let options = AppOptions { document: Some(document), ..AppOptions::default() };
    let app = App::new(&state, options);
    let mut window = Harness::builder()
        .with_size(vec2(size[0], size[1]))
        .with_max_steps(1)
        .with_step_dt(0.3)
        .with_render_cursor(false)
        .with_context_setup(apply_style)
        .renderer(WgpuTestRenderer::from_render_state(state))
        .build_ui_state(|ui, app: &mut App| app.show(ui), app);
    settle(&mut window);
    window
}

/// A small window: two methods that are cheap on a software GPU.
fn small(methods: &[&str]) -> Window {
    let document = Document::of_methods(methods.iter().map(|id| MethodChoice::new(id)));
    // Wide enough for the whole bar at the top: what is cut off cannot be clicked.
    window([900.0, 420.0], Document { overscan_px: 16, ..document })
}

/// Goes on until nothing moves, loads or converges any more.
fn settle(window: &mut Window) {
    let start = Instant::now();
    window.step();
    while !window.state().is_settled() {
        assert!(
            start.elapsed() < Duration::from_secs(120),
            "the window does not settle: {:?}",
            window.state().last_error()
        );
        std::thread::sleep(Duration::from_millis(2));
        window.step();
    }
    // Once more, for what follows the picture: names, numbers, statistics.
    window.step();
    window.step();
}

fn type_number(window: &mut Window, name: &str, text: &str) {
    window.get_by_role_and_label(Role::SpinButton, name).click();
    window.step();
    window.step();
    window.key_combination_modifiers(Modifiers::COMMAND, &[egui::Key::A]);
    window.step();
    let field = window.query_by_role_and_label(Role::TextInput, name);
    field.unwrap_or_else(|| window.get_by_role_and_label(Role::SpinButton, name)).type_text(text);
    window.step();
    window.key_press(egui::Key::Enter);
    settle(window);
}

/// The first pane's method.
fn method(window: &Window) -> &MethodChoice {
    &window.state().document().panes[0].method
}

/// Lens points that the first pane's reference has and will have.
fn progress(window: &Window) -> Option<(u32, u32)> {
    window.state().engine().pane(PaneId(1)).expect("there is a pane").progress()
}

fn point(window: &Window, x: f32, y: f32) -> Pos2 {
    let picture = window.state().picture_rect(window.state().document().a).expect("the picture is laid out");
    picture.min + vec2(x, y) * picture.size()
}

fn button(window: &Window, at: Pos2, pressed: bool) {
    let button = PointerButton::Primary;
    window.event(egui::Event::PointerButton { pos: at, button, pressed, modifiers: Modifiers::NONE });
}

fn click(window: &mut Window, at: Pos2) {
    window.event(egui::Event::PointerMoved(at));
    window.step();
    button(window, at, true);
    window.step();
    button(window, at, false);
    settle(window);
}

fn drag(window: &mut Window, from: Pos2, to: Pos2) {
    window.event(egui::Event::PointerMoved(from));
    window.step();
    button(window, from, true);
    window.step();
    for share in [0.5, 1.0] {
        window.event(egui::Event::PointerMoved(from + (to - from) * share));
        window.step();
    }
    button(window, to, false);
    settle(window);
}

fn choose(window: &mut Window, list: &str, entry: &str) {
    window.get_by_role_and_label(Role::ComboBox, list).click();
    window.step();
    window.step();
    window.get_all_by_label(entry).last().expect("the entry is in the list").click();
    window.step();
    settle(window);
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
