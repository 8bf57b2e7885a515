//! The window before a class: lessons, the picture alone, keys for aperture and focus.

use crate::common::window::{Tiny, Window, press, settle, tiny, window_with};
use crate::{says, tiny_files};
use defocus_app::window::{Action, AppOptions, Document, LESSONS, PictureSize};
use eframe::egui::{Key, Modifiers, Role, ViewportCommand};
use egui_kittest::kittest::Queryable;

fn perform(window: &mut Window, action: Action) {
    let ctx = window.ctx.clone();
    window.state_mut().perform(&ctx, action);
    settle(window);
}

/// A window over the scene of the lessons, with pictures that are quick to draw.
fn classroom() -> Window {
    let document = Document { size: PictureSize::Pixels(48, 36), scene: "cans".into(), ..Document::default() };
    window_with([1280.0, 720.0], AppOptions { document: Some(document), ..AppOptions::default() })
}

#[test]
fn a_lesson_is_a_state_with_one_thing_to_drag_and_leads_back() {
    let mut window = classroom();
    let before = window.state().document().clone();
    // The lesson about a headset: one pane, a method that is quick.
    let index = LESSONS.iter().position(|l| l.title.contains("headset")).expect("it is one of them");
    perform(&mut window, Action::Lesson(index));
    assert_eq!(window.state().lesson(), Some(index));
    assert!(says(&window, LESSONS[index].sentence) && says(&window, LESSONS[index].task));
    let document = window.state().document();
    assert!(document.camera.is_some(), "the scene's camera was chosen");
    assert_eq!((document.lens.aperture_diameter_mm, document.lens.focus_distance_m), (2.0, 0.46));
    window.get_by_role_and_label(Role::Slider, "Drag: aperture E").set_value_accesskit(6.0);
    settle(&mut window);
    assert_eq!(window.state().document().lens.aperture_diameter_mm, 6.0);
    press(&mut window, Modifiers::NONE, Key::PageDown);
    assert_eq!(window.state().lesson(), Some(index + 1));
    window.get_by_role_and_label(Role::Slider, "Drag: age").set_value_accesskit(70.0);
    settle(&mut window);
    let document = window.state().document();
    assert_eq!(document.age_years, Some(70.0));
    assert!(document.lens.eye.accommodation_d.is_some_and(|d| d < 1.0), "an old eye hardly accommodates");
    press(&mut window, Modifiers::NONE, Key::PageUp);
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert_eq!(window.state().lesson(), None);
    assert_eq!(window.state().document(), &before, "it is as it was before the lessons");
}

#[test]
fn the_picture_alone_keeps_aperture_and_focus() {
    let Tiny { mut window, folder: _folder } = tiny(&tiny_files::squares().glb(), &["mipmap"]);
    press(&mut window, Modifiers::NONE, Key::Tab);
    assert!(window.state().preferences().panels_hidden);
    for gone in ["Focus distance", "Aperture E"] {
        assert!(window.query_by_role_and_label(Role::Slider, gone).is_none(), "{gone} is still there");
    }
    assert!(window.query_by_label("File").is_none(), "the bar at the top is still there");
    window.get_by_role_and_label(Role::Slider, "Opening E").set_value_accesskit(3.0);
    settle(&mut window);
    assert_eq!(window.state().document().lens.aperture_diameter_mm, 3.0);
    window.get_by_role_and_label(Role::Slider, "Focus at").set_value_accesskit(1.5);
    settle(&mut window);
    assert_eq!(window.state().document().lens.focus_distance_m, 1.5);
    press(&mut window, Modifiers::NONE, Key::Tab);
    assert!(!window.state().preferences().panels_hidden);
    assert!(window.query_by_role_and_label(Role::Slider, "Aperture E").is_some());
}

#[test]
fn tab_goes_on_from_a_field_that_has_the_focus() {
    let Tiny { mut window, folder: _folder } = tiny(&tiny_files::squares().glb(), &["mipmap"]);
    window.get_by_role_and_label(Role::Slider, "Focus distance").focus();
    window.run_steps(2);
    window.key_press(Key::Tab);
    window.run_steps(2);
    assert!(!window.state().preferences().panels_hidden, "the key belongs to the field");
}

#[test]
fn keys_change_aperture_and_focus() {
    let Tiny { mut window, folder: _folder } = tiny(&tiny_files::squares().glb(), &["mipmap"]);
    let lens = |window: &Window| window.state().document().lens.clone();
    let before = lens(&window);
    press(&mut window, Modifiers::NONE, Key::Period);
    let opened = lens(&window).aperture_diameter_mm / before.aperture_diameter_mm;
    assert!((opened - 1.1).abs() < 1e-9, "{opened}");
    press(&mut window, Modifiers::NONE, Key::Comma);
    assert!((lens(&window).aperture_diameter_mm / before.aperture_diameter_mm - 1.0).abs() < 1e-9);
    press(&mut window, Modifiers::NONE, Key::K);
    let nearer_d = 1.0 / lens(&window).focus_distance_m - 1.0 / before.focus_distance_m;
    assert!((nearer_d - 0.1).abs() < 1e-9, "{nearer_d}");
    (0..200).for_each(|_| {
        let ctx = window.ctx.clone();
        window.state_mut().perform(&ctx, Action::NudgeFocus(-1));
    });
    assert!(lens(&window).focus_distance_m.is_infinite(), "the last step is infinity");
    (0..2000).for_each(|_| {
        let ctx = window.ctx.clone();
        window.state_mut().perform(&ctx, Action::NudgeFocus(1));
    });
    assert!(lens(&window).check().is_ok(), "no nearer than an image forms");
}

#[test]
fn full_screen_and_size_of_the_interface_are_asked_for() {
    let Tiny { mut window, folder: _folder } = tiny(&tiny_files::squares().glb(), &["mipmap"]);
    assert!(window.state().commands().iter().any(|command| {
        command.action == Action::ToggleFullScreen && command.keys.is_some_and(|keys| keys.logical_key == Key::F11)
    }));
    let ctx = window.ctx.clone();
    window.state_mut().perform(&ctx, Action::ToggleFullScreen);
    window.step();
    let output = &window.output().viewport_output[&eframe::egui::ViewportId::ROOT];
    let asks = |command: &ViewportCommand| matches!(command, ViewportCommand::Fullscreen(true));
    assert!(output.commands.iter().any(asks), "the system is asked for the whole screen: {:?}", output.commands);
    perform(&mut window, Action::ScaleInterface(1.25));
    assert_eq!(window.ctx.zoom_factor(), 1.25);
    window.run_steps(2);
    assert_eq!(window.state().preferences().ui_scale, 1.25, "it is kept");
}

#[test]
fn the_unit_of_a_file_is_asked_for_where_all_of_it_is_far_away() {
    // Two squares, a hundred times as large and as far: as a file in centimetres is read.
    let mut far = tiny_files::squares();
    far.list("nodes").push(serde_json::json!({"children": [0, 1, 2], "scale": [100.0, 100.0, 100.0]}));
    far.json["scenes"][0]["nodes"] = serde_json::json!([3]);
    let Tiny { mut window, folder: _folder } = tiny(&far.glb(), &["mipmap"]);
    assert!(says(&window, "Is the file in another unit?"));
    let before_m = window.state_mut().depth_at_m(glam::DVec2::splat(0.5)).expect("there is a view");
    window.get_by_role_and_label(Role::Button, "Centimetres").click();
    window.step();
    settle(&mut window);
    assert!(!says(&window, "Is the file in another unit?"));
    let after_m = window.state_mut().depth_at_m(glam::DVec2::splat(0.5)).expect("there is a view");
    // The question took some of the picture's height.
    assert!((before_m / after_m - 100.0).abs() < 1.0, "{before_m} m became {after_m} m");
    assert_eq!(window.state().document().depth.scene_scale, Some(0.01));
    let Tiny { window, folder: _folder } = tiny(&tiny_files::squares().glb(), &["mipmap"]);
    assert!(!says(&window, "Is the file in another unit?"), "what is near is not asked about");
}
