//! Fields keep what they hold, understand units, and say what they do not understand.

use crate::common::window::{Tiny, Window, choose, settle, tiny, type_number};
use crate::{says, tiny_files};
use defocus_app::window::{Action, PaneId};
use eframe::egui::{Key, Role};
use egui_kittest::kittest::Queryable;

fn window() -> Tiny {
    tiny(&tiny_files::squares().glb(), &["mipmap"])
}

fn focus_m(window: &Window) -> f64 {
    window.state().document().lens.focus_distance_m
}

/// Clicks a number and presses Enter, as one does who only looks.
fn look_at(window: &mut Window, name: &str) {
    window.get_by_role_and_label(Role::SpinButton, name).scroll_to_me();
    window.run_steps(3);
    window.get_by_role_and_label(Role::SpinButton, name).click();
    window.run_steps(3);
    window.key_press(Key::Enter);
    settle(window);
}

#[test]
fn a_click_and_enter_change_no_number() {
    let Tiny { mut window, folder: _folder } = window();
    let before = window.state().document().clone();
    assert!(before.automatic_lens);
    for name in
        ["Focus distance", "Aperture E", "f-number", "Focal length F", "Image at dr", "Screen at ds", "Screen DPI"]
    {
        look_at(&mut window, name);
        assert_eq!(window.state().document().lens, before.lens, "{name}");
    }
    assert!(window.state().document().automatic_lens, "the lens is not the user's own for having been looked at");
}

#[test]
fn all_digits_are_there_to_be_edited() {
    let Tiny { mut window, folder: _folder } = window();
    type_number(&mut window, "Aperture E", "9.438990123456");
    let name = "Aperture E";
    window.get_by_role_and_label(Role::SpinButton, name).click();
    window.run_steps(3);
    assert!(says(&window, "9.438990123456"), "{:?}", crate::texts(&window));
    window.key_press(Key::Escape);
    window.run_steps(2);
    assert_eq!(window.state().document().lens.aperture_diameter_mm, 9.438990123456);
}

#[test]
fn units_are_understood() {
    let Tiny { mut window, folder: _folder } = window();
    for (text, metres) in [("60 cm", 0.6), ("1200 mm", 1.2), ("2 D", 0.5), ("2 ft", 0.6096), ("0,75", 0.75)] {
        type_number(&mut window, "Focus distance", text);
        assert!((focus_m(&window) - metres).abs() < 1e-12, "{text}: {} m", focus_m(&window));
    }
    type_number(&mut window, "Screen DPI", "25 px/deg");
    let px_per_degree = window.state().document().lens.px_per_degree();
    assert!((px_per_degree - 25.0).abs() < 1e-9, "{px_per_degree}");
    type_number(&mut window, "Aperture E", "0.5 cm");
    assert_eq!(window.state().document().lens.aperture_diameter_mm, 5.0);
}

#[test]
fn what_is_not_understood_is_said() {
    let Tiny { mut window, folder: _folder } = window();
    let before = focus_m(&window);
    type_number(&mut window, "Focus distance", "60 apples");
    assert_eq!(focus_m(&window), before);
    assert!(says(&window, "“60 apples” is not understood"), "{:?}", crate::texts(&window));
    type_number(&mut window, "Focus distance", "60 cm");
    assert!(!says(&window, "is not understood"), "what was put right is not spoken of any more");
}

#[test]
fn a_shape_that_a_method_cannot_show_is_said_with_those_that_can() {
    let Tiny { mut window, folder: _folder } = window();
    window.get_by_label("Aperture").scroll_to_me();
    window.run_steps(3);
    window.get_by_label("Aperture").click();
    window.run_steps(3);
    assert!(!says(&window, "round aperture"));
    choose(&mut window, "Aperture shape", "Polygon");
    assert!(says(&window, "round aperture"), "in the pane");
    assert!(says(&window, "its shape is shown by"), "where it is chosen: {:?}", crate::texts(&window));
    let ctx = window.ctx.clone();
    window.state_mut().perform(&ctx, Action::SetMethod(PaneId(1), "splat".into()));
    settle(&mut window);
    assert!(!says(&window, "round aperture") && !says(&window, "its shape is shown by"));
}

#[test]
fn colour_scales_fit_and_can_be_fixed_and_stretched() {
    let Tiny { mut window, folder: _folder } = tiny(&tiny_files::squares().glb(), &["mipmap", "pinhole"]);
    choose(&mut window, "Shown in pane 1", "Circle of confusion");
    let depths = window.state_mut().view().map(|view| *view.projection());
    assert!(depths.is_some());
    let request = |window: &Window| window.state().coc_scale_px();
    let fitted = request(&window);
    let wider_mm = 10.0 * window.state().document().lens.aperture_diameter_mm;
    type_number(&mut window, "Aperture E", &wider_mm.to_string());
    assert!((request(&window) / fitted - 10.0).abs() < 1e-3, "{} follows {fitted}", request(&window));
    window.get_by_role_and_label(Role::CheckBox, "CoC scale fits").click_accesskit();
    settle(&mut window);
    type_number(&mut window, "CoC scale", "12");
    assert_eq!(request(&window), 12.0);
    type_number(&mut window, "Aperture E", &(2.0 * wider_mm).to_string());
    assert_eq!(request(&window), 12.0, "fixed, it stays");
    choose(&mut window, "Shown in pane 1", "Difference");
    let mean = |window: &Window| {
        let engine = window.state().engine();
        let shown = engine.pane(PaneId(1)).and_then(|p| p.shown()).expect("it is shown");
        let image = defocus::gpu::download_rgba8(engine.gpu(), shown);
        image.pixels.iter().map(|[r, g, b, _]| u64::from(*r) + u64::from(*g) + u64::from(*b)).sum::<u64>()
    };
    let plain = mean(&window);
    choose(&mut window, "Gain of the difference in pane 1", "16x");
    assert!(mean(&window) > plain, "the scale is stretched");
}
