//! The picture has a size of its own.

use crate::common::window::{Tiny, Window, choose, press, settle, tiny, type_number, window_with};
use crate::{says, tiny_files};
use defocus::gpu::Texture;
use defocus_app::window::{
    Action, AppOptions, Arrangement, Document, Identity, MethodChoice, PaneId, PictureSize, Theme, read_state,
    write_state,
};
use eframe::egui::{Key, Modifiers, Role};
use egui_kittest::kittest::Queryable;
use glam::uvec2;

fn perform(window: &mut Window, action: Action) {
    let ctx = window.ctx.clone();
    window.state_mut().perform(&ctx, action);
}

fn picture(window: &Window, id: u32) -> (Identity, Texture) {
    let pane = window.state().engine().pane(PaneId(id)).expect("the pane is there");
    (pane.identity().cloned().expect("there is a picture"), pane.linear().cloned().expect("there is a picture"))
}

#[test]
fn a_layout_a_row_and_a_theme_change_nothing_that_is_measured() {
    let Tiny { mut window, folder: _folder } = tiny(&tiny_files::squares().glb(), &["mipmap", "accumulation"]);
    perform(&mut window, Action::SetSize(PictureSize::Pixels(96, 72)));
    settle(&mut window);
    let lens = window.state().document().lens.clone();
    let known = [picture(&window, 1), picture(&window, 2)];
    let same = |window: &mut Window, what: &str| {
        settle(window);
        for (id, (identity, texture)) in (1..).zip(&known) {
            let (now, shown) = picture(window, id);
            assert_eq!(now, *identity, "{what}");
            assert!(shown.same(texture), "{what}: the picture of pane {id} was made anew");
        }
        assert_eq!(window.state().engine().pane(PaneId(2)).and_then(|p| p.progress()), Some((8, 8)), "{what}");
        assert_eq!(window.state().document().lens, lens, "{what}");
    };
    press(&mut window, Modifiers::NONE, Key::T);
    same(&mut window, "another arrangement");
    for size in [[1120.0, 500.0], [1300.0, 300.0]] {
        window.set_size(size.into());
        same(&mut window, "another window");
    }
    for theme in [Theme::Light, Theme::Dark] {
        perform(&mut window, Action::SetTheme(theme));
        same(&mut window, "another theme");
    }
    perform(&mut window, Action::Arrange(Arrangement::Tiles));
    // A second row in the head.
    perform(&mut window, Action::SetShow(PaneId(1), 4));
    same(&mut window, "a row in the head");
    perform(&mut window, Action::ToggleZoom);
    same(&mut window, "another zoom");
    perform(&mut window, Action::AddPane);
    same(&mut window, "one more pane");
    // As large as the window is the choice that says otherwise.
    perform(&mut window, Action::SetSize(PictureSize::Window));
    settle(&mut window);
    assert_ne!(picture(&window, 1).0, known[0].0);
}

#[test]
fn a_size_is_chosen_typed_kept_and_copied() {
    let Tiny { mut window, folder } = tiny(&tiny_files::squares().glb(), &["pinhole"]);
    choose(&mut window, "Picture size", "640 x 480");
    assert_eq!(window.state().document().size, PictureSize::Pixels(640, 480));
    type_number(&mut window, "Picture width", "120");
    type_number(&mut window, "Picture height", "90");
    assert_eq!(window.state().document().size, PictureSize::Pixels(120, 90));
    assert_eq!(window.state().engine().size(), Some(uvec2(120, 90)));
    assert!(says(&window, "120 x 90 px"), "the line below says it");
    let file = folder.path().join("state.ron");
    write_state(&file, window.state().document()).expect("it can be written");
    assert_eq!(read_state(&file).expect("it can be read").size, PictureSize::Pixels(120, 90));
    let line = defocus_app::window::command_line(window.state().document(), uvec2(120, 90));
    assert!(line.contains("--size 120x90"), "{line}");
    // The scene's own is what the command line draws without a size.
    choose(&mut window, "Picture size", "As the scene has it");
    let source = window.state().engine().source().expect("it is open").source().default_size(0);
    assert_eq!(window.state().engine().size(), Some(source));
}

#[test]
fn panes_say_how_large_they_show_the_picture() {
    let Tiny { mut window, folder: _folder } = tiny(&tiny_files::squares().glb(), &["pinhole"]);
    perform(&mut window, Action::SetSize(PictureSize::Pixels(400, 300)));
    settle(&mut window);
    let shown = window.state().picture_rect(PaneId(1)).expect("it is laid out");
    let percent = (100.0 * shown.width() / 400.0).round();
    assert!(percent < 100.0, "the window is lower than the picture");
    let says_percent = |window: &Window, wanted: f32| {
        crate::texts(window).iter().any(|text| {
            text.strip_suffix(" %").and_then(|text| text.parse::<f32>().ok()).is_some_and(|p| (p - wanted).abs() <= 1.0)
        })
    };
    assert!(says_percent(&window, percent), "{:?}", crate::texts(&window));
    perform(&mut window, Action::ZoomTo(2.0));
    settle(&mut window);
    assert!(says_percent(&window, 200.0));
}

#[test]
fn each_eye_has_the_size_of_the_picture() {
    let Tiny { mut window, folder: _folder } = tiny(&tiny_files::squares().glb(), &["pinhole"]);
    perform(&mut window, Action::SetSize(PictureSize::Pixels(64, 48)));
    settle(&mut window);
    let one = picture(&window, 1).0.render.size;
    perform(&mut window, Action::SetStereo(Some(defocus::stereo::Layout::Parallel)));
    settle(&mut window);
    assert_eq!(picture(&window, 1).0.render.size, one, "two eyes do not halve it");
    assert_eq!(window.state().shown_size(PaneId(1)), Some(uvec2(128, 48)));
    let line = defocus_app::window::command_line(window.state().document(), one);
    assert!(line.contains("--size 128x48") && line.contains("--stereo parallel"), "{line}");
}

#[test]
fn an_image_with_depth_has_the_field_of_view_that_it_was_taken_with_in_any_window() {
    let document = Document {
        scene: "forest".into(),
        size: PictureSize::Window,
        ..Document::of_methods([MethodChoice::new("pinhole")])
    };
    let options = AppOptions { document: Some(document), ..AppOptions::default() };
    let mut window = window_with([900.0, 420.0], options);
    let warns = |window: &Window| says(window, "° shown as ");
    assert!(!warns(&window), "a lens that suits the image needs no warning");
    // A lens of one's own for this size of the picture: right stays right.
    let lens = window.state().document().lens.clone();
    let size = window.state().engine().size().expect("there is a picture");
    type_number(&mut window, "Screen DPI", &(0.5 * lens.density_px_per_mm).to_string());
    assert!(warns(&window), "half as dense, it spans another angle");
    window.get_by_role_and_label(Role::Button, "Fit the display").click_accesskit();
    settle(&mut window);
    let fitted = window.state().document().lens.density_px_per_mm;
    assert!((fitted / lens.density_px_per_mm - 1.0).abs() < 1e-9, "{fitted} in place of {}", lens.density_px_per_mm);
    assert!(!warns(&window));
    let line = defocus_app::window::command_line(window.state().document(), size);
    assert!(line.contains(&format!("--size {}x{}", size.x, size.y)), "{line}");
}
