//! Panes, commands and files of the window, driven as a user drives them.

#![cfg(feature = "window")]

mod common;
#[path = "../../../tests/tiny_files/mod.rs"]
mod tiny_files;

use common::window::{Tiny, Window, choose, click, name_file, point, press, settle, type_number, window};
use defocus::gpu::download_rgba8;
use defocus::stereo::Layout;
use defocus::{image_io, methods};
use defocus_app::window::{
    Action, Arrangement, Difference, DifferenceKind, Document, MAX_PANES, MethodChoice, PaneId, PaneMetrics, Show,
    read_state,
};
use eframe::egui::{Key, Modifiers, Role};
use egui_kittest::kittest::Queryable;
use glam::{DVec2, dvec2};
use tiny_files::squares;

/// [`common::window::tiny`] with squares one behind the other.
fn tiny(methods: &[&str]) -> Tiny {
    common::window::tiny(&squares().glb(), methods)
}

fn command(window: &mut Window, text: &str) {
    window.key_combination_modifiers(Modifiers::COMMAND, &[Key::P]);
    window.run_steps(3);
    window.get_by_role_and_label(Role::TextInput, "Command").type_text(text);
    window.run_steps(2);
    window.key_press(Key::Enter);
    settle(window);
}

fn document(window: &Window) -> &Document {
    window.state().document()
}

#[test]
fn within_three_actions_two_methods_stand_side_by_side_focused_on_what_was_clicked() {
    // The scene of the first start.
    let first = Document { overscan_px: 16, ..Document::of_methods([MethodChoice::new("mipmap")]) };
    let mut window = window([900.0, 260.0], first);
    window.get_by_label("Compare").click();
    window.run_steps(4);
    let shown: Vec<_> = document(&window).panes.iter().map(|p| p.method.id.as_str()).collect();
    assert_eq!(shown, ["mipmap", "accumulation"]);
    assert_eq!(document(&window).visible().len(), 2);
    choose_samples(&mut window);
    let at = point(&window, 0.35, 0.75);
    let expected = window.state_mut().depth_at_m(dvec2(0.35, 0.75)).expect("there is a view");
    click(&mut window, at);
    assert_eq!(document(&window).lens.focus_distance_m, expected);
    let engine = window.state().engine();
    let PaneMetrics::Current(measured) = engine.pane_metrics(PaneId(1)) else {
        panic!("they were measured: {:?}", engine.pane_metrics(PaneId(1)));
    };
    let figures = measured.result.as_ref().expect("the images can be compared");
    let samples = engine.pane(PaneId(2)).and_then(|p| p.progress()).expect("the reference converges");
    assert_eq!(measured.of.truth.samples, Some(samples.1), "the figures say at how many lens points they stand");
    assert!(figures.psnr_db.is_some_and(|db| db > 15.0) && figures.flip > 0.0, "{figures:?}");
    window.check_accessibility();
}

/// Fewer lens points for the pane with the reference: what is tested is not their number.
fn choose_samples(window: &mut Window) {
    window.get_by_label("Pane 2").click();
    window.run_steps(3);
    type_number(window, "Lens points", "9");
    window.get_by_label("Pane 1").click();
    settle(window);
}

#[test]
fn every_method_can_be_chosen_in_every_pane() {
    let Tiny { mut window, folder: _folder } = tiny(&["pinhole", "pinhole"]);
    for pane in [1, 2] {
        for about in methods::all().iter().map(|m| m.about()) {
            // Nobody waits for the 256 lens points of the reference.
            let list = format!("Method of pane {pane}");
            window.get_by_role_and_label(Role::ComboBox, &list).click();
            window.run_steps(2);
            window.get_all_by_label(about.title).last().expect("the method is in the list").scroll_to_me();
            window.run_steps(5);
            window.get_all_by_label(about.title).last().expect("the method is in the list").click();
            window.run_steps(4);
            let state = document(&window).pane(PaneId(pane)).expect("the pane is there");
            assert_eq!(state.method.id, about.id);
            if about.id == "accumulation" {
                continue;
            }
            settle(&mut window);
            let shown = window.state().engine().pane(PaneId(pane)).expect("the pane is there");
            assert!(shown.shown().is_some() && shown.error().is_none(), "{}: {:?}", about.id, shown.error());
        }
    }
    assert_eq!(window.state().last_error(), None);
}

#[test]
fn a_texture_inside_is_chosen_with_level_and_channel() {
    let Tiny { mut window, folder: _folder } = tiny(&["mipmap"]);
    choose(&mut window, "Shown in pane 1", "Inside the method");
    choose(&mut window, "Texture in pane 1", "blur and level of each pixel");
    choose(&mut window, "Channel in pane 1", "DoB");
    let pane = window.state().engine().pane(PaneId(1)).expect("the pane is there");
    let [low, high] = pane.reading().expect("one channel has a scale").ends;
    assert!(low >= 0.0 && high > low, "a DoB is not negative and differs: {low} to {high}");
    choose(&mut window, "Texture in pane 1", "pyramid: behind, before, all, CoC");
    let size = |window: &Window| {
        let pane = window.state().engine().pane(PaneId(1)).expect("the pane is there");
        pane.shown().expect("it is shown").size()
    };
    let before = size(&window);
    type_number(&mut window, "Texture level in pane 1", "2");
    let after = size(&window);
    assert!(after.x < before.x, "a coarser level has fewer texels: {before} and {after}");
}

/// The colours of a pane, and those of the colour map over its numbers at 9 places.
fn colours(window: &Window) -> Vec<([u8; 3], [u8; 3])> {
    let engine = window.state().engine();
    let pane = engine.pane(PaneId(1)).expect("the pane is there");
    let shown = download_rgba8(engine.gpu(), pane.shown().expect("it is shown"));
    let places = (0..9).map(|i| dvec2(f64::from(i % 3) + 0.5, f64::from(i / 3) + 0.5) / 3.0);
    let colour = |at: DVec2| {
        let pixel = (at * shown.size.as_dvec2()).as_uvec2();
        let [r, g, b, _] = shown.at(pixel.x, pixel.y);
        let (reading, value) = engine.inside_at(PaneId(1), at).expect("numbers are shown");
        ([r, g, b], reading.map.srgb8(reading.place(value)))
    };
    places.map(colour).collect()
}

#[test]
fn numbers_inside_lie_over_the_picture_as_densely_as_is_asked_for() {
    let Tiny { mut window, folder } = tiny(&["mipmap"]);
    choose(&mut window, "Shown in pane 1", "Inside the method");
    choose(&mut window, "Texture in pane 1", "blur and level of each pixel");
    choose(&mut window, "Channel in pane 1", "DoB");
    let picture = window.state().engine().size();
    assert_eq!(window.state().shown_size(PaneId(1)), picture, "at first the picture is seen under the numbers");
    let is_map = |(shown, map): &([u8; 3], [u8; 3])| shown.iter().zip(map).all(|(s, m)| s.abs_diff(*m) <= 3);
    let is_grey = |(shown, _): &([u8; 3], [u8; 3])| shown.iter().all(|s| s.abs_diff(shown[0]) <= 1);
    assert!(!colours(&window).iter().any(is_map), "both are mixed");
    let file = folder.path().join("overlay.ron");
    defocus_app::window::write_state(&file, document(&window)).expect("it can be written");
    type_number(&mut window, "Opacity in pane 1", "100");
    assert!(colours(&window).iter().all(is_map), "the numbers alone");
    type_number(&mut window, "Opacity in pane 1", "0");
    assert!(colours(&window).iter().all(is_grey), "the picture alone, grey");
    assert_eq!(document(&window).panes[0].opacity, 0.0);
    // A state of an earlier program knows nothing of it.
    let text = std::fs::read_to_string(&file).expect("it was written");
    let earlier: String =
        text.lines().filter(|line| !line.contains("opacity:")).map(|line| format!("{line}\n")).collect();
    assert_ne!(earlier, text);
    std::fs::write(&file, earlier).expect("it can be written");
    assert_eq!(read_state(&file).expect("it can still be read").panes[0].opacity, 0.6);
    // The overlays that every method has take the same control.
    for show in ["Circle of confusion", "Depth"] {
        choose(&mut window, "Shown in pane 1", show);
        type_number(&mut window, "Overlay opacity", "35");
        assert_eq!(document(&window).panes[0].opacity, 0.35);
        type_number(&mut window, "Overlay opacity", "80");
        assert_eq!(window.state().engine().stats().triangles, 0, "{show} comes from what is there");
    }
}

#[test]
fn what_a_method_did_is_chosen_by_name() {
    let Tiny { mut window, folder: _folder } = tiny(&["mipmap"]);
    let shown = |window: &Window| {
        let pane = window.state().engine().pane(PaneId(1)).expect("the pane is there");
        pane.reading().expect("numbers are shown").quantity.name
    };
    for name in ["covered by foreground", "DoB", "mipmap level", "tile class"] {
        choose(&mut window, "Shown in pane 1", name);
        assert_eq!(shown(&window), name);
        assert_eq!(
            window.state().shown_size(PaneId(1)),
            window.state().engine().size(),
            "{name} lies over the picture"
        );
    }
    // Another method that has it too goes on showing it.
    choose(&mut window, "Method of pane 1", "Multiview synthesis");
    assert_eq!(shown(&window), "tile class");
    command(&mut window, "overlay slab index");
    assert_eq!(shown(&window), "slab index");
}

#[test]
fn differences_of_every_kind_are_taken_from_the_chosen_pane() {
    let Tiny { mut window, folder: _folder } = tiny(&["mipmap", "pinhole"]);
    choose(&mut window, "Shown in pane 1", "Difference");
    let against = PaneId(2);
    for (kind, name) in DifferenceKind::ALL {
        choose(&mut window, "Kind of difference in pane 1", name);
        assert_eq!(document(&window).panes[0].show, Show::Difference(Difference::new(against, kind)));
        assert!(window.state().engine().pane(PaneId(1)).is_some_and(|p| p.shown().is_some()), "{name}");
    }
    window.get_by_label("Close pane 2").click();
    settle(&mut window);
    assert_eq!(document(&window).panes[0].show, Show::Picture, "nothing is left to differ from");
}

#[test]
fn panes_come_go_and_change_places_by_keys() {
    let Tiny { mut window, folder: _folder } = tiny(&["pinhole", "accumulation"]);
    let ids = |window: &Window| document(window).panes.iter().map(|p| p.id.0).collect::<Vec<_>>();
    for count in 3..=MAX_PANES {
        press(&mut window, Modifiers::NONE, Key::N);
        assert_eq!(ids(&window).len(), count);
    }
    press(&mut window, Modifiers::NONE, Key::N);
    assert_eq!(ids(&window).len(), MAX_PANES, "there are no more than six");
    press(&mut window, Modifiers::NONE, Key::Num4);
    press(&mut window, Modifiers::SHIFT, Key::Num2);
    assert_eq!((document(&window).a, document(&window).b), (PaneId(4), PaneId(2)));
    press(&mut window, Modifiers::NONE, Key::X);
    assert_eq!((document(&window).a, document(&window).b), (PaneId(2), PaneId(4)));
    for expected in [Arrangement::One, Arrangement::Wipe, Arrangement::Tiles] {
        press(&mut window, Modifiers::NONE, Key::T);
        assert_eq!(document(&window).arrangement, expected);
    }
    press(&mut window, Modifiers::NONE, Key::Delete);
    assert_eq!(ids(&window), [1, 3, 4, 5, 6]);
}

#[test]
fn what_was_done_can_be_undone_and_done_again() {
    let Tiny { mut window, folder: _folder } = tiny(&["pinhole"]);
    let rest = |window: &mut Window| window.run_steps(6);
    rest(&mut window);
    type_number(&mut window, "Focus distance", "0.9");
    rest(&mut window);
    choose(&mut window, "Method of pane 1", "Anisotropic mipmaps");
    rest(&mut window);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(document(&window).panes[0].method.id, "pinhole");
    assert_eq!(document(&window).lens.focus_distance_m, 0.9);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_ne!(document(&window).lens.focus_distance_m, 0.9);
    press(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    window.get_by_label("Redo").click();
    settle(&mut window);
    assert_eq!(document(&window).panes[0].method.id, "mipmap");
    assert_eq!(document(&window).lens.focus_distance_m, 0.9);
}

#[test]
fn a_scene_that_was_left_comes_back_with_undo() {
    let Tiny { mut window, folder: _folder } = tiny(&["pinhole"]);
    window.run_steps(6);
    let camera = document(&window).camera;
    command(&mut window, "scene forest");
    window.run_steps(6);
    assert_eq!((document(&window).scene.as_str(), document(&window).camera), ("forest", None));
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert!(document(&window).scene.ends_with("squares.glb"));
    assert_eq!(document(&window).camera, camera);
    assert_eq!(window.state().engine().source().map(|s| s.source().name()), Some("squares"));
}

#[test]
fn the_palette_finds_and_does() {
    let Tiny { mut window, folder: _folder } = tiny(&["pinhole"]);
    command(&mut window, "method separable");
    assert_eq!(document(&window).panes[0].method.id, "separable");
    command(&mut window, "arrang wipe");
    assert_eq!(document(&window).arrangement, Arrangement::Wipe);
    command(&mut window, "zoom 400");
    assert_eq!(document(&window).zoom.scale, Some(4.0));
    press(&mut window, Modifiers::NONE, Key::Z);
    assert_eq!(document(&window).zoom.scale, None);
    press(&mut window, Modifiers::COMMAND, Key::P);
    window.key_press(Key::Escape);
    settle(&mut window);
    assert!(window.query_by_role_and_label(Role::TextInput, "Command").is_none(), "Escape closes it");
}

#[test]
fn a_saved_state_reopens_exactly() {
    let Tiny { mut window, folder } = tiny(&["mipmap", "separable"]);
    type_number(&mut window, "Aperture E", "5.25");
    choose(&mut window, "Shown in pane 2", "Circle of confusion");
    command(&mut window, "zoom 200");
    press(&mut window, Modifiers::COMMAND, Key::S);
    name_file(&mut window, &folder.path().join("view.ron"));
    settle(&mut window);
    let saved = document(&window).clone();
    assert_eq!(read_state(&folder.path().join("view.ron")).expect("it can be read"), saved);
    type_number(&mut window, "Aperture E", "1");
    window.get_by_label("Close pane 2").click();
    settle(&mut window);
    press(&mut window, Modifiers::COMMAND, Key::O);
    name_file(&mut window, &folder.path().join("view.ron"));
    settle(&mut window);
    assert_eq!(document(&window), &saved);
    assert_eq!(window.state().last_error(), None);
}

#[test]
fn pictures_are_saved_as_they_are_shown_and_as_they_are() {
    let Tiny { mut window, folder } = tiny(&["mipmap"]);
    let size = window.state().engine().size().expect("there is a picture");
    press(&mut window, Modifiers::COMMAND, Key::E);
    name_file(&mut window, &folder.path().join("shown"));
    settle(&mut window);
    let png = image_io::read_color(&folder.path().join("shown.png")).expect("the ending was added");
    assert_eq!(png.size, size);
    press(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::E);
    name_file(&mut window, &folder.path().join("linear.exr"));
    settle(&mut window);
    let exr = image_io::read_color(&folder.path().join("linear.exr")).expect("it can be read");
    let shown = window.state().document().display;
    // A display step of 1/255 is worth at most 1 % of linear white.
    let worst = exr.pixels.iter().zip(&png.pixels).map(|(l, s)| (shown.linear(*l) - *s).abs().max_element());
    assert!(worst.fold(0.0, f32::max) < 0.01, "the PNG is the EXR as the display shows it");
}

#[test]
fn a_state_that_cannot_be_read_is_told() {
    let Tiny { mut window, folder } = tiny(&["pinhole"]);
    let before = document(&window).clone();
    for (name, text, expected) in [
        ("missing.ron", None, "check that the file exists"),
        ("damaged.ron", Some("(defocus_state: 1, document: (lens: 3))"), "is not a saved state"),
        ("later.ron", Some("(defocus_state: 99, document: ())"), "update defocus"),
    ] {
        let file = folder.path().join(name);
        if let Some(text) = text {
            std::fs::write(&file, text).expect("a temporary file can be written");
        }
        press(&mut window, Modifiers::COMMAND, Key::O);
        name_file(&mut window, &file);
        settle(&mut window);
        let error = window.state().last_error().unwrap_or_default().to_owned();
        assert!(error.contains(name) && error.contains(expected), "{error}");
        assert_eq!(document(&window), &before);
    }
}

#[test]
fn an_image_without_depth_is_asked_for_one() {
    let Tiny { mut window, folder } = tiny(&["pinhole"]);
    let (color, depth) = (folder.path().join("color.png"), folder.path().join("depth.png"));
    let gradient = |x: u32, y: u32| [(x * 4) as u8, (y * 5) as u8, 90, 255];
    let image = defocus::image::Image::from_fn(glam::uvec2(60, 40), gradient);
    image_io::write_png(&color, &image).expect("it can be written");
    let grey = image.map(|[r, ..]| [r.max(8), r.max(8), r.max(8), 255]);
    image_io::write_png(&depth, &grey).expect("it can be written");
    press(&mut window, Modifiers::COMMAND, Key::O);
    window.run_steps(3);
    window.get_by_role_and_label(Role::TextInput, "File").type_text(&color.to_string_lossy());
    window.run_steps(3);
    window.get_by_role_and_label(Role::TextInput, "Depth file").focus();
    window.run_steps(2);
    window.get_by_role_and_label(Role::TextInput, "Depth file").type_text(&depth.to_string_lossy());
    window.run_steps(2);
    window.get_by_label("Open").click();
    settle(&mut window);
    assert_eq!(window.state().last_error(), None);
    assert_eq!(document(&window).depth.file.as_deref(), Some(depth.as_path()));
    assert_eq!(document(&window).camera, None, "an image is seen from where it was taken");
}

#[test]
fn the_command_line_names_all_that_makes_the_picture() {
    let Tiny { window, folder: _folder } = tiny(&["mipmap", "separable", "accumulation"]);
    let line = defocus_app::window::command_line(document(&window), glam::uvec2(320, 200));
    for part in [
        "defocus compare ",
        "squares.glb",
        "--size 320x200",
        "--methods mipmap,separable",
        "--pose ",
        "-E ",
        "--focus ",
    ] {
        assert!(line.contains(part), "{part} is missing in {line}");
    }
}

#[test]
fn the_command_line_has_both_eyes() {
    let Tiny { mut window, folder: _folder } = tiny(&["mipmap"]);
    let ctx = window.ctx.clone();
    window.state_mut().perform(&ctx, Action::SetStereo(Some(Layout::Anaglyph)));
    settle(&mut window);
    let line = defocus_app::window::command_line(document(&window), glam::uvec2(320, 200));
    assert!(line.contains("--stereo anaglyph --ipd-mm 63 --stereo-window inf"), "{line}");
    assert!(defocus_app::window::left_out(document(&window)).is_empty());
}
