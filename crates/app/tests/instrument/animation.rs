//! Animations in the window: played, stopped, scrubbed, kept and copied.

use crate::common::window::{Tiny, Window, settle, tiny_with};
use crate::tiny_files;
use defocus::gpu::download_rgba8;
use defocus_app::window::{Action, AppOptions, Edit, Moment, PaneId, command_line, read_state, write_state};
use eframe::egui::Role;
use egui_kittest::kittest::Queryable;
use serde_json::json;

fn window() -> Tiny {
    let mut scene = tiny_files::animated();
    // The camera looks at the square from in front of it.
    scene.json["nodes"][1]["translation"] = json!([0.5, 0.5, 4.0]);
    scene.json["materials"][0]["doubleSided"] = json!(true);
    tiny_with(&scene.glb(), &["pinhole"], AppOptions::default())
}

fn perform(window: &mut Window, action: Action) {
    let ctx = window.ctx.clone();
    window.state_mut().perform(&ctx, action);
    settle(window);
}

fn show(window: &mut Window, animation: &str, time_s: f64) {
    let moment = Some(Moment { animation: animation.into(), time_s });
    perform(window, Action::Edit(Edit::Moment(moment)));
}

fn picture(window: &Window) -> Vec<[u8; 4]> {
    let engine = window.state().engine();
    let shown = engine.pane(PaneId(1)).and_then(|pane| pane.shown()).expect("a picture");
    download_rgba8(engine.gpu(), shown).pixels
}

#[test]
fn a_moment_is_shown_and_left_again() {
    let Tiny { mut window, folder: _folder } = window();
    let at_rest = picture(&window);
    show(&mut window, "Way", 1.0);
    let at_1_s = picture(&window);
    assert_ne!(at_1_s, at_rest, "the square is elsewhere at 1 s");
    show(&mut window, "Way", 0.5);
    assert_ne!(picture(&window), at_1_s);
    show(&mut window, "Way", 1.0);
    assert_eq!(picture(&window), at_1_s, "the same moment is the same picture");
    perform(&mut window, Action::Edit(Edit::Moment(None)));
    assert_eq!(picture(&window), at_rest, "the rest pose is what it was");
    assert_eq!(window.state().last_error(), None);
}

#[test]
fn a_camera_of_the_file_is_followed_until_the_person_moves_it() {
    let Tiny { mut window, folder: _folder } = window();
    let camera = |window: &Window| window.state().document().camera.expect("a scene has one");
    let at_rest = camera(&window);
    show(&mut window, "Flight", 1.0);
    assert!((camera(&window).position - at_rest.position).length() > 1.0, "the file moves its camera");
    let mut own = camera(&window);
    own.position.z += 1.0;
    perform(&mut window, Action::Edit(Edit::Camera(own, 1.0)));
    show(&mut window, "Flight", 2.0);
    assert_eq!(camera(&window), own, "a camera that was moved by hand stays");
}

#[test]
fn the_bar_plays_stops_and_scrubs() {
    let Tiny { mut window, folder: _folder } = window();
    assert!(window.query_by_role_and_label(Role::Slider, "Time").is_some(), "a scene with animations has the bar");
    let time_s = |window: &Window| window.state().document().moment.as_ref().map_or(0.0, |moment| moment.time_s);
    window.get_by_label("Play").click_accesskit();
    let start = std::time::Instant::now();
    while time_s(&window) == 0.0 {
        assert!(start.elapsed().as_secs() < 60, "it does not play");
        window.step();
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    window.run_steps(2);
    window.get_by_label("Pause").click_accesskit();
    settle(&mut window);
    let stopped = time_s(&window);
    window.run_steps(5);
    assert_eq!(time_s(&window), stopped, "it stands still once it is stopped");
    window.get_by_role_and_label(Role::Slider, "Time").set_value_accesskit(1.5);
    settle(&mut window);
    assert!((time_s(&window) - 1.5).abs() < 1e-6, "{}", time_s(&window));
    window.get_by_label("Rest pose").click_accesskit();
    settle(&mut window);
    assert_eq!(window.state().document().moment, None);
}

#[test]
fn a_moment_is_kept_copied_and_no_step_of_undo() {
    let Tiny { mut window, folder } = window();
    perform(&mut window, Action::Edit(Edit::ApertureDiameter(2.0)));
    window.run_steps(6);
    show(&mut window, "Way", 1.25);
    let document = window.state().document().clone();
    let line = command_line(&document, glam::uvec2(64, 48));
    assert!(line.contains("--animation Way --time 1.25"), "{line}");
    let file = folder.path().join("moment.ron");
    write_state(&file, &document).expect("it can be written");
    assert_eq!(read_state(&file).expect("it can be read").moment, document.moment);
    window.run_steps(6);
    perform(&mut window, Action::Undo);
    assert_eq!(window.state().document().moment, document.moment, "undo leaves the moment alone");
    assert_ne!(window.state().document().lens, document.lens);
}

#[test]
fn an_animation_that_is_not_there_is_told_and_the_scene_stays() {
    let Tiny { mut window, folder: _folder } = window();
    let before = picture(&window);
    show(&mut window, "Jump", 1.0);
    let error = window.state().last_error().unwrap_or_default().to_owned();
    assert!(error.contains("Jump") && error.contains("Way"), "{error}");
    assert_eq!(window.state().document().moment, None);
    assert_eq!(picture(&window), before);
}
