//! The lens in the window: focus, aperture, two eyes and what lies under the pointer.

#![cfg(feature = "window")]

mod common;

use common::window::{Window, choose, click, drag, drag_with, name_file, point, settle, small, type_number};
use defocus::aperture::Aperture;
use defocus::combine::Channel;
use defocus::focus::{area_depth_m, depth_of_m, world_point};
use defocus::gpu::download_rgba8;
use defocus::image::ColorImage;
use defocus::image_io::read_color;
use defocus::stereo::{Layout, Stereo};
use defocus_app::window::{Action, PaneId, PictureKind};
use defocus_app::window::{FocusMode, FocusSettings};
use eframe::egui::{self, Modifiers, Role};
use egui_kittest::kittest::Queryable;
use glam::{DVec2, dvec2, uvec2};

fn focus_m(window: &Window) -> f64 {
    window.state().document().lens.focus_distance_m
}

fn perform(window: &mut Window, action: Action) {
    let ctx = window.ctx.clone();
    window.state_mut().perform(&ctx, action);
    settle(window);
}

fn hover(window: &mut Window, x: f32, y: f32) {
    let at = point(window, x, y);
    window.event(egui::Event::PointerMoved(at));
    window.step();
}

#[test]
fn dragging_with_ctrl_opens_the_aperture_and_with_alt_moves_the_focus() {
    let mut window = small(&["mipmap"]);
    let camera = window.state().document().camera;
    let before = window.state().document().lens.aperture_diameter_mm;
    let (from, to) = (point(&window, 0.3, 0.5), point(&window, 0.6, 0.5));
    drag_with(&mut window, from, to, Modifiers::COMMAND);
    let opened = window.state().document().lens.aperture_diameter_mm;
    let expected = (f64::from(to.x - from.x) / 150.0).exp();
    // Points are f32, some 200 of them.
    assert!((opened / before / expected - 1.0).abs() < 1e-4, "{opened} from {before}");
    drag_with(&mut window, to, from, Modifiers::COMMAND);
    assert!((window.state().document().lens.aperture_diameter_mm / before - 1.0).abs() < 1e-4);
    let (from, to) = (point(&window, 0.3, 0.5), point(&window, 0.35, 0.75));
    drag_with(&mut window, from, to, Modifiers::ALT);
    let expected = window.state_mut().depth_at_m(dvec2(0.35, 0.75)).expect("there is a view");
    assert_eq!(focus_m(&window), expected);
    assert_eq!(window.state().document().camera, camera, "neither moves the camera");
    assert_eq!(window.state().engine().stats().triangles, 0);
}

#[test]
fn an_area_and_an_object_are_focused_on() {
    let mut window = small(&["pinhole"]);
    choose(&mut window, "Focus on", "Area clicked");
    type_number(&mut window, "Area", "31");
    assert_eq!(window.state().document().focus.radius_px(), 15);
    let at = point(&window, 0.35, 0.75);
    click(&mut window, at);
    let area = |window: &mut Window, at: DVec2, radius| {
        let app = window.state_mut();
        let gpu = app.engine().gpu().clone();
        app.view().and_then(|view| area_depth_m(&view.depth_m(&gpu), at, radius)).expect("there is a view")
    };
    assert_eq!(focus_m(&window), area(&mut window, dvec2(0.35, 0.75), 15));

    choose(&mut window, "Focus on", "Object clicked");
    click(&mut window, at);
    let camera = window.state().document().camera.expect("a scene has a camera");
    let projection = *window.state_mut().view().expect("there is a view").projection();
    let anchor = world_point(&camera, &projection, dvec2(0.35, 0.75), focus_m(&window)).expect("no sky");
    let before = focus_m(&window);
    let (from, to) = (point(&window, 0.6, 0.3), point(&window, 0.5, 0.34));
    drag(&mut window, from, to);
    let moved = window.state().document().camera.expect("a scene has a camera");
    assert_ne!(camera, moved);
    let expected = depth_of_m(&moved, anchor).expect("still before the camera");
    // The anchor comes from a click in f32 points.
    assert!((focus_m(&window) / expected - 1.0).abs() < 1e-3, "{} not {expected}", focus_m(&window));
    assert!((focus_m(&window) / before - 1.0).abs() > 1e-4, "its distance has changed");
}

#[test]
fn the_focus_follows_the_pointer_as_an_eye_does() {
    let mut window = small(&["mipmap"]);
    perform(&mut window, Action::SetFocusMode(FocusMode::Gaze));
    hover(&mut window, 0.35, 0.75);
    settle(&mut window);
    let near = window.state_mut().depth_at_m(dvec2(0.35, 0.75)).expect("there is a view");
    assert!((focus_m(&window) / near - 1.0).abs() < 0.05, "{} at {near}", focus_m(&window));
    hover(&mut window, 0.5, 0.2);
    let on_the_way = focus_m(&window);
    settle(&mut window);
    let far = focus_m(&window);
    assert!(near < on_the_way && on_the_way < far, "{near}, {on_the_way}, {far}");
    // Autofocus goes by the middle, wherever the pointer is.
    perform(&mut window, Action::SetFocusMode(FocusMode::Centre));
    let middle = window.state_mut().depth_at_m(dvec2(0.5, 0.5)).expect("there is a view");
    assert!((focus_m(&window) / middle - 1.0).abs() < 0.1, "{} at {middle}", focus_m(&window));
    let frames = window.state().engine().rendered_frames();
    window.run_steps(5);
    assert_eq!(window.state().engine().rendered_frames(), frames, "an eye that has arrived rests");
    let focus = FocusSettings { mode: FocusMode::Centre, ..FocusSettings::default() };
    assert_eq!(window.state().document().focus, focus);
}

#[test]
fn two_eyes_see_each_their_own_view() {
    let mut window = small(&["mipmap"]);
    let whole = window.state().shown_size(PaneId(1)).expect("there is a picture");
    for (layout, _) in Layout::ALL {
        perform(&mut window, Action::SetStereo(Some(layout)));
        assert_eq!(window.state().document().stereo, Some(Stereo { layout, ..Stereo::default() }));
        let shown = window.state().shown_size(PaneId(1)).expect("there is a picture");
        assert_eq!(shown.y, whole.y);
        assert!(shown.x.abs_diff(whole.x) <= 1, "{layout:?}: {shown} in place of {whole}");
        let eye = window.state().engine().size().expect("there is a view");
        assert_eq!(eye, layout.eye_size(whole));
    }
    assert_eq!(window.state().problem(), None);
    perform(&mut window, Action::SetStereo(Some(Layout::Parallel)));
    // The same place of the two halves shows different things: the eyes stand apart.
    let focus = |window: &mut Window, x: f32| {
        let at = point(window, x, 0.62);
        click(window, at);
        focus_m(window)
    };
    let (left, right): (Vec<f64>, Vec<f64>) =
        (1..8).map(|i| (focus(&mut window, i as f32 / 16.0), focus(&mut window, 0.5 + i as f32 / 16.0))).unzip();
    assert!(left.iter().zip(&right).any(|(l, r)| (l / r - 1.0).abs() > 0.05), "{left:?} and {right:?}");
    perform(&mut window, Action::SetStereo(None));
    assert_eq!(window.state().shown_size(PaneId(1)), Some(whole));
}

#[test]
fn both_eyes_are_saved_as_they_are_laid_out() {
    let mut window = small(&["pinhole"]);
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let mut save = |layout: Layout| {
        perform(&mut window, Action::SetStereo(Some(layout)));
        let file = folder.path().join(format!("{}.exr", layout.id()));
        let ctx = window.ctx.clone();
        window.state_mut().perform(&ctx, Action::SavePicture(PaneId(1), PictureKind::Exr));
        name_file(&mut window, &file);
        settle(&mut window);
        file
    };
    let [parallel, crossed] = [Layout::Parallel, Layout::Crossed].map(|layout| {
        let file = save(layout);
        read_color(&file).expect("it was written")
    });
    let anaglyph = save(Layout::Anaglyph);
    let eye = uvec2(parallel.size.x / 2, parallel.size.y);
    let half = |image: &ColorImage, x: u32| image.crop(uvec2(x, 0), eye);
    assert!(half(&parallel, 0) == half(&crossed, eye.x) && half(&parallel, eye.x) == half(&crossed, 0));
    assert!(half(&parallel, 0) != half(&parallel, eye.x), "the eyes stand apart");
    let error = window.state().last_error().unwrap_or_default();
    assert!(error.contains("save it as PNG") && !anaglyph.exists(), "{error}");
}

#[test]
fn the_camera_is_fitted_to_the_display_and_an_image_becomes_the_aperture() {
    let mut window = small(&["pinhole"]);
    type_number(&mut window, "Screen DPI", "0.2");
    let display_fov = window.state().document().lens.display_fov_x(window.state().engine().size().expect("a view").x);
    window.get_by_label("Fit the camera").scroll_to_me();
    window.run_steps(3);
    window.get_by_label("Fit the camera").click();
    settle(&mut window);
    let fov = window.state_mut().view().expect("there is a view").projection().fov_x();
    assert!((fov / display_fov - 1.0).abs() < 1e-9, "{fov} not {display_fov}");
    let line = defocus_app::window::command_line(window.state().document(), uvec2(320, 200));
    assert!(line.contains(" --fov "), "the camera is not the scene's any more: {line}");
    assert!(window.query_by_label("Fit the camera").is_none());

    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let file = folder.path().join("star.png");
    image::GrayImage::from_fn(16, 16, |x, y| image::Luma([if x.abs_diff(y) < 4 { 255 } else { 0 }]))
        .save(&file)
        .expect("a temporary file can be written");
    window.get_by_label("Aperture").scroll_to_me();
    window.run_steps(3);
    window.get_by_label("Aperture").click();
    window.run_steps(6);
    choose(&mut window, "Aperture shape", "Image");
    window.get_by_role_and_label(Role::TextInput, "File").type_text(&file.to_string_lossy());
    window.run_steps(2);
    window.key_press(egui::Key::Enter);
    settle(&mut window);
    let Aperture::Image(image) = &window.state().document().lens.aperture else { panic!("it is an image") };
    assert!(image.name().ends_with("star.png"), "{}", image.name());
}

#[test]
fn the_inspector_reads_what_lies_under_the_pointer_and_a_channel_is_shown_alone() {
    let mut window = small(&["pinhole", "mipmap"]);
    window.get_by_label("Inspector").scroll_to_me();
    window.run_steps(3);
    window.get_by_label("Inspector").click();
    window.run_steps(6);
    hover(&mut window, 0.4, 0.7);
    settle(&mut window);
    let size = window.state().engine().size().expect("there is a view");
    let pixel = dvec2(0.4, 0.7) * size.as_dvec2();
    assert!(window.query_by_label_contains(&format!("{}, ", pixel.x as u32)).is_some(), "the pixel is shown");
    for name in ["Neighbourhood", "Luminance histogram", "CoC histogram", "1 Pinhole", "mipmap level", "tile class"] {
        assert!(window.query_all_by_label_contains(name).next().is_some(), "{name} is not shown");
    }

    choose(&mut window, "Channel", "Green");
    assert_eq!(window.state().document().channel, Channel::Green);
    let gpu = window.state().engine().gpu().clone();
    let shown = window.state().engine().pane(PaneId(1)).and_then(|p| p.shown()).expect("there is a picture").clone();
    let pixels = download_rgba8(&gpu, &shown).pixels;
    assert!(pixels.iter().all(|[r, g, b, _]| r == g && g == b));
    assert!(pixels.iter().any(|[r, ..]| *r > 60), "there is something to see");
}
