//! The window in a test, driven as a user drives it.

use defocus_app::window::{
    App, AppOptions, Document, MethodChoice, PictureSize, Preferences, Tempo, apply_style, wgpu_setup,
};
use eframe::egui::{self, Modifiers, PointerButton, Pos2, Role, vec2};
use eframe::egui_wgpu::RendererOptions;
use egui_kittest::Harness;
use egui_kittest::kittest::{By, Queryable};
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state};
use std::path::PathBuf;
use std::time::{Duration, Instant};

pub type Window = Harness<'static, App>;

/// A window of `size` points that starts with `document`, once it has settled. Unless the
/// document says another size than its scene's, the picture is as large as the window: a
/// small one is quick.
pub fn window(size: [f32; 2], document: Document) -> Window {
    window_in(size, document, None)
}

/// The same, which saves into `folder` unless it is told otherwise.
pub fn window_in(size: [f32; 2], document: Document, folder: Option<PathBuf>) -> Window {
    let document = match document.size {
        PictureSize::Own => Document { size: PictureSize::Window, ..document },
        _ => document,
    };
    window_with(size, AppOptions { document: Some(document), folder, ..AppOptions::default() })
}

/// A window of `size` points that starts as `options` say, once it has settled.
pub fn window_with(size: [f32; 2], options: AppOptions) -> Window {
    let mut options = options;
    if options.tempo == Tempo::default() {
        // Whatever the machine has to do beside: pictures are drawn at once and in full.
        options.tempo.budget_ms = f64::INFINITY;
    }
    // What is folded at first has no names to be found by.
    let unfolded = ["Optics and display", "View", "Timing"].map(str::to_owned);
    let preferences = options.preferences.take().unwrap_or_default();
    options.preferences = Some(Preferences { open_groups: unfolded.into(), ..preferences });
    window_as_asked(size, options)
}

/// A window exactly as `options` say, with what is folded at first still folded.
pub fn window_as_asked(size: [f32; 2], options: AppOptions) -> Window {
    let state = create_render_state(wgpu_setup(None), RendererOptions::PREDICTABLE);
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
pub fn small(methods: &[&str]) -> Window {
    let document = Document::of_methods(methods.iter().map(|id| MethodChoice::new(id)));
    // Wide enough for the whole bar at the top: what is cut off cannot be clicked.
    window([900.0, 420.0], Document { overscan_px: 16, ..document })
}

/// A window with its folder, in which lies the scene that it shows.
pub struct Tiny {
    pub window: Window,
    pub folder: tempfile::TempDir,
}

/// A low window over the scene `glb` with so few pixels and lens points that every method
/// is done at once on a software GPU; as wide as the bar at the top.
pub fn tiny(glb: &[u8], methods: &[&str]) -> Tiny {
    tiny_with(glb, methods, AppOptions::default())
}

/// The same with other options.
pub fn tiny_with(glb: &[u8], methods: &[&str], options: AppOptions) -> Tiny {
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let scene = folder.path().join("squares.glb");
    std::fs::write(&scene, glb).expect("a temporary file can be written");
    let choice = |id: &&str| {
        let mut choice = MethodChoice::new(id);
        if *id == "accumulation" {
            choice.params.insert("samples".into(), "8".into());
        }
        choice
    };
    let document = Document::of_methods(methods.iter().map(choice));
    let document =
        Document { overscan_px: 8, size: PictureSize::Window, scene: scene.to_string_lossy().into_owned(), ..document };
    let options = AppOptions { document: Some(document), folder: Some(folder.path().into()), ..options };
    Tiny { window: window_with([1120.0, 260.0], options), folder }
}

/// Presses keys, and waits until the window has settled.
pub fn press(window: &mut Window, modifiers: Modifiers, key: egui::Key) {
    window.key_combination_modifiers(modifiers, &[key]);
    settle(window);
}

/// Types a file's name where one is asked for, and confirms.
pub fn name_file(window: &mut Window, file: &std::path::Path) {
    window.run_steps(3);
    window.get_by_role_and_label(Role::TextInput, "File").focus();
    window.run_steps(2);
    window.key_combination_modifiers(Modifiers::COMMAND, &[egui::Key::A]);
    window.step();
    window.get_by_role_and_label(Role::TextInput, "File").type_text(&file.to_string_lossy());
    window.run_steps(2);
    window.key_press(egui::Key::Enter);
    window.run_steps(2);
}

/// Goes on until nothing moves, loads or converges any more.
pub fn settle(window: &mut Window) {
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

/// Types a number into the field of that name, wherever the panel has to be scrolled to.
pub fn type_number(window: &mut Window, name: &str, text: &str) {
    window.get_by_role_and_label(Role::SpinButton, name).scroll_to_me();
    window.run_steps(3);
    window.get_by_role_and_label(Role::SpinButton, name).click();
    window.run_steps(2);
    window.key_combination_modifiers(Modifiers::COMMAND, &[egui::Key::A]);
    window.step();
    let field = window.query_by_role_and_label(Role::TextInput, name);
    field.unwrap_or_else(|| window.get_by_role_and_label(Role::SpinButton, name)).type_text(text);
    window.step();
    window.key_press(egui::Key::Enter);
    settle(window);
}

/// The point of the window that shows a point of the picture, from (0, 0) to (1, 1).
pub fn point(window: &Window, x: f32, y: f32) -> Pos2 {
    let picture = window.state().picture_rect(window.state().document().a).expect("the picture is laid out");
    picture.min + vec2(x, y) * picture.size()
}

/// Presses or releases the mouse's first button, together with the keys held.
pub fn button(window: &Window, at: Pos2, pressed: bool, modifiers: Modifiers) {
    let button = PointerButton::Primary;
    window.event(egui::Event::PointerButton { pos: at, button, pressed, modifiers });
}

/// Clicks, and waits until the window has settled.
pub fn click(window: &mut Window, at: Pos2) {
    window.event(egui::Event::PointerMoved(at));
    window.step();
    button(window, at, true, Modifiers::NONE);
    window.step();
    button(window, at, false, Modifiers::NONE);
    settle(window);
}

/// Drags, and waits until the window has settled.
pub fn drag(window: &mut Window, from: Pos2, to: Pos2) {
    drag_with(window, from, to, Modifiers::NONE);
}

/// Drags while keys are held, and waits until the window has settled.
pub fn drag_with(window: &mut Window, from: Pos2, to: Pos2, modifiers: Modifiers) {
    window.event(egui::Event::ModifiersChanged(modifiers));
    window.event(egui::Event::PointerMoved(from));
    window.step();
    button(window, from, true, modifiers);
    window.step();
    for share in [0.5, 1.0] {
        window.event(egui::Event::PointerMoved(from + (to - from) * share));
        window.step();
    }
    button(window, to, false, modifiers);
    window.step();
    window.event(egui::Event::ModifiersChanged(Modifiers::NONE));
    settle(window);
}

/// Unfolds the parameters of the method that have no room in the panel.
pub fn unfold_method(window: &mut Window) {
    let of_method =
        || By::new().predicate(|node| node.label().is_some_and(|label| label.starts_with("More of the method")));
    window.get(of_method()).scroll_to_me();
    window.run_steps(3);
    window.get(of_method()).click();
    settle(window);
}

/// Chooses an entry of a list by its name.
pub fn choose(window: &mut Window, list: &str, entry: &str) {
    window.get_by_role_and_label(Role::ComboBox, list).scroll_to_me();
    window.run_steps(3);
    window.get_by_role_and_label(Role::ComboBox, list).click();
    window.run_steps(2);
    // A long list scrolls.
    window.get_all_by_label(entry).last().expect("the entry is in the list").scroll_to_me();
    window.run_steps(5);
    window.get_all_by_label(entry).last().expect("the entry is in the list").click();
    window.step();
    settle(window);
}
