//! Every control by its accessible name, what is inside methods, and what may go wrong.
//!
//! Snapshots lie in `crates/app/tests/snapshots`; after a wanted change of the window's looks they are
//! made anew, looked at, and committed:
//!
//! ```sh
//! UPDATE_SNAPSHOTS=1 cargo test --test app --test controls _as_
//! ```

#![cfg(feature = "window")]

mod common;
#[path = "../../../tests/tiny_files/mod.rs"]
mod tiny_files;

use common::window::{Tiny, Window, choose, name_file, press, settle, tiny_with, type_number, unfold_method};
use defocus::gpu::download_rgba8;
use defocus::methods::{self, Scale};
use defocus::stereo::Layout;
use defocus_app::window::{Action, AppOptions, Arrangement, PaneId, Preferences, Theme};
use eframe::egui::accesskit::Action as Request;
use eframe::egui::{self, Key, Modifiers, Rect, Role, pos2};
use egui_kittest::SnapshotOptions;
use egui_kittest::kittest::{NodeT, Queryable};
use glam::{DVec2, dvec2};
use std::collections::BTreeSet;
use std::path::Path;
use std::time::{Duration, Instant};

fn tiny(methods: &[&str]) -> Tiny {
    tiny_with(&tiny_files::squares().glb(), methods, AppOptions::default())
}

fn perform(window: &mut Window, action: Action) {
    let ctx = window.ctx.clone();
    window.state_mut().perform(&ctx, action);
    settle(window);
}

/// Opens the groups of the panel that are closed at first.
fn open_groups(window: &mut Window) {
    for group in ["Aperture", "Inspector", "Stereo and headsets"] {
        window.get_by_label(group).scroll_to_me();
        window.run_steps(3);
        window.get_by_label(group).click();
        window.run_steps(3);
    }
}

/// Name, value and reach of the sliders with that name, or of all.
fn sliders(window: &Window, name: Option<&str>) -> Vec<(String, f64, [f64; 2])> {
    let nodes = window.root().children_recursive().map(|node| node.accesskit_node());
    let slider = nodes.filter(|node| node.role() == Role::Slider).filter_map(|node| {
        let reach = [node.min_numeric_value()?, node.max_numeric_value()?];
        Some((node.label()?, node.numeric_value()?, reach))
    });
    slider.filter(|(label, ..)| name.is_none_or(|name| name == label)).collect()
}

/// Sets every slider that is not among those `seen`, and reads it again.
fn set_all(window: &mut Window, seen: &mut BTreeSet<String>) {
    for (name, ..) in sliders(window, None) {
        if !seen.insert(name.clone()) {
            continue;
        }
        let (_, before, [low, high]) = sliders(window, Some(&name))[0].clone();
        let wanted = if high.is_finite() { low + 0.3 * (high - low) } else { 4.0 };
        window.get_by_role_and_label(Role::Slider, &name).set_value_accesskit(wanted);
        window.run_steps(3);
        let (_, after, _) = sliders(window, Some(&name))[0].clone();
        // Whole numbers are rounded, that of the area to odd ones; some fields set others and
        // are computed back.
        let tolerance =
            if after.fract() == 0.0 { 1.01 } else { (0.1 * (high - low)).min(0.51) }.max(1e-3 * wanted.abs());
        assert!((after - wanted).abs() <= tolerance, "{name}: {after} in place of {wanted}, from {before}");
    }
    settle(window);
}

#[test]
fn every_slider_is_set_by_its_name() {
    let Tiny { mut window, folder: _folder } = tiny(&["mipmap"]);
    open_groups(&mut window);
    unfold_method(&mut window);
    choose(&mut window, "Aperture shape", "Polygon");
    window.get_by_role_and_label(Role::CheckBox, "Stereo").click_accesskit();
    choose(&mut window, "Shown in pane 1", "Circle of confusion");
    let mut seen = BTreeSet::new();
    set_all(&mut window, &mut seen);
    // A focus that follows something is not set by its slider.
    choose(&mut window, "Focus on", "Autofocus");
    choose(&mut window, "Aperture shape", "Gaussian");
    window.get_by_label("field of view").click_accesskit();
    window.run_steps(3);
    set_all(&mut window, &mut seen);
    window.get_by_role_and_label(Role::CheckBox, "Stereo").click_accesskit();
    // Without blur, a pinhole's lens, the reference is done at once.
    type_number(&mut window, "Aperture E", "0");
    for about in methods::all().iter().map(|m| m.about()) {
        perform(&mut window, Action::SetMethod(PaneId(1), about.id.into()));
        set_all(&mut window, &mut seen);
    }
    for name in ["Aperture E", "Focus distance", "Exposure", "Overscan", "Blades", "Eye distance", "Eye's lag"] {
        assert!(seen.contains(name), "{name} is no slider: {seen:?}");
    }
    assert!(seen.len() > 40, "{seen:?}");
    assert_eq!(window.state().last_error(), None);
}

/// What can be reached with the keys and has no name.
fn unnamed(window: &Window) -> Vec<String> {
    let nodes = window.root().children_recursive().map(|node| node.accesskit_node());
    let focusable = nodes.filter(|node| node.data().supports_action(Request::Focus) && !node.is_hidden());
    // The gaps between tiles, where they are dragged, belong to a library and take no name.
    let is_gap = |rect: &Rect| rect.width().min(rect.height()) <= 6.5;
    let unnamed = focusable.filter(|node| {
        let rect = node.raw_bounds().map(|r| [r.x0, r.y0, r.x1, r.y1].map(|v| v as f32));
        let rect = rect.map(|[x0, y0, x1, y1]| Rect::from_min_max(pos2(x0, y0), pos2(x1, y1)));
        !rect.is_some_and(|rect| is_gap(&rect))
    });
    let unnamed = unnamed.filter(|node| {
        let told = [node.label(), node.value(), node.data().placeholder().map(str::to_owned)];
        told.iter().flatten().all(|text| text.trim().is_empty())
    });
    unnamed.map(|node| format!("{:?} at {:?}", node.role(), node.raw_bounds())).collect()
}

#[test]
fn nothing_is_unnamed() {
    let Tiny { mut window, folder } = tiny(&["mipmap", "pinhole", "separable"]);
    open_groups(&mut window);
    let check = |window: &mut Window, state: &str| {
        window.run_steps(3);
        window.check_accessibility();
        assert_eq!(unnamed(window), Vec::<String>::new(), "{state}");
    };
    perform(&mut window, Action::SetShow(PaneId(1), 5));
    perform(&mut window, Action::SetShow(PaneId(2), 4));
    perform(&mut window, Action::SetStereo(Some(Layout::Parallel)));
    check(&mut window, "three panes");
    for arrangement in [Arrangement::Wipe, Arrangement::One] {
        perform(&mut window, Action::Arrange(arrangement));
        check(&mut window, "another arrangement");
    }
    for (action, state) in [(Action::Palette, "palette"), (Action::Help, "sheet of keys")] {
        perform(&mut window, action.clone());
        check(&mut window, state);
        perform(&mut window, action);
    }
    for list in ["File", "Menu of pane 1", "Save"] {
        let menu = window.get_all_by_label(list).next().expect("the menu is there");
        menu.click_accesskit();
        check(&mut window, list);
        window.key_press(Key::Escape);
        window.run_steps(2);
    }
    perform(&mut window, Action::Open);
    window.get_by_role_and_label(Role::TextInput, "File").type_text(&folder.path().join("x.png").to_string_lossy());
    check(&mut window, "an image without depth is opened");
}

fn inside_at(window: &Window, at: DVec2) -> f32 {
    window.state().engine().inside_at(PaneId(1), at).expect("numbers are shown").1
}

#[test]
fn numbers_inside_a_method_have_names_units_and_a_scale() {
    let Tiny { mut window, folder: _folder } = tiny(&["mipmap"]);
    choose(&mut window, "Shown in pane 1", "Inside the method");
    choose(&mut window, "Texture in pane 1", "blur and level of each pixel");
    // The nearest square's middle, and what lies farthest behind.
    let points = [dvec2(0.5, 0.5), dvec2(0.3, 0.4), dvec2(0.9, 0.9)];
    let depths: Vec<f64> = points.map(|at| window.state_mut().depth_at_m(at).expect("there is a view")).into();
    let lens = window.state().document().lens.clone();
    for (channel, of_coc) in [("CoC", 1.0), ("DoB", 0.5)] {
        choose(&mut window, "Channel in pane 1", channel);
        let reading = window.state().engine().pane(PaneId(1)).and_then(|p| p.reading()).expect("it has a scale");
        assert_eq!((reading.quantity.name, reading.quantity.unit), (channel, " px"));
        for (at, depth_m) in points.iter().zip(&depths) {
            let c = lens.coc_diameter_px(*depth_m);
            let expected = if channel == "DoB" { of_coc * c.abs() } else { of_coc * c };
            // f16 holds 11 bits.
            let value = f64::from(inside_at(&window, *at));
            assert!((value - expected).abs() <= 2e-3 * expected.abs() + 1e-3, "{channel}: {value}, not {expected}");
        }
    }
    choose(&mut window, "Channel in pane 1", "mipmap level");
    open_groups(&mut window);
    let at = common::window::point(&window, 0.3, 0.4);
    window.event(egui::Event::PointerMoved(at));
    settle(&mut window);
    assert!(window.query_all_by_label("mipmap level").next().is_some(), "the inspector tells it too");
}

#[test]
fn sub_images_and_slabs_are_told_by_number() {
    let Tiny { mut window, folder: _folder } = tiny(&["pinhole"]);
    // Beyond the squares, which are blurred foreground then, each over other pixels.
    type_number(&mut window, "Focus distance", "30");
    let aperture_mm = 6.0 * window.state().document().lens.aperture_diameter_mm;
    type_number(&mut window, "Aperture E", &aperture_mm.to_string());
    for (method, texture, quantity) in [
        ("opaque", "sub-image of each pixel", "sub-image index"),
        ("pyramid", "sub-image of each pixel", "sub-image index"),
        ("multiview", "slabs of each pixel", "slab index"),
    ] {
        perform(&mut window, Action::SetMethod(PaneId(1), method.into()));
        choose(&mut window, "Shown in pane 1", "Inside the method");
        choose(&mut window, "Texture in pane 1", texture);
        let reading = window.state().engine().pane(PaneId(1)).and_then(|p| p.reading()).expect("it has a scale");
        assert_eq!(reading.quantity.name, quantity, "{method}");
        let [low, high] = reading.ends;
        let scale = reading.quantity.scale;
        let mut found = BTreeSet::new();
        for i in 0..400_u32 {
            let at = dvec2(f64::from(i % 20) + 0.5, f64::from(i / 20) + 0.5) / 20.0;
            let value = inside_at(&window, at);
            assert!((low..=high).contains(&value), "{method}: {value} is not in {low} to {high}");
            match scale {
                Scale::Classes(classes) => assert!(classes.iter().any(|(v, _)| *v == value), "{method}: {value}"),
                _ => assert_eq!(value.fract(), 0.0, "{method}"),
            }
            found.insert((2.0 * value) as i32);
        }
        assert!(found.len() > 1, "{method} has squares at three depths, but only {found:?}");
        perform(&mut window, Action::SetShow(PaneId(1), 0));
    }
}

#[test]
fn the_comparison_is_saved_as_html() {
    let Tiny { mut window, folder } = tiny(&["mipmap", "accumulation"]);
    let file = folder.path().join("comparison.html");
    press(&mut window, Modifiers::COMMAND, Key::R);
    name_file(&mut window, &file);
    settle(&mut window);
    let html = std::fs::read_to_string(&file).expect("it was written");
    for part in ["Anisotropic mipmaps", "data:image/png;base64", "--methods mipmap", "squares"] {
        assert!(html.contains(part), "{part} is missing");
    }
    assert_eq!(window.state().last_error(), None);
}

#[test]
fn a_lost_device_is_told_and_the_state_can_be_saved() {
    let Tiny { mut window, folder } = tiny(&["mipmap", "pinhole"]);
    open_groups(&mut window);
    window.state().engine().gpu().device().destroy();
    let at = common::window::point(&window, 0.4, 0.5);
    common::window::button(&window, at, true, Modifiers::NONE);
    window.run_steps(2);
    common::window::button(&window, at, false, Modifiers::NONE);
    // The driver tells it from a thread of its own.
    for _ in 0..100 {
        window.run_steps(1);
        if window.state().engine().is_lost() {
            break;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    assert!(window.state().engine().is_lost());
    let error = window.state().last_error().unwrap_or_default().to_owned();
    assert!(error.contains("the graphics device was lost; save the state"), "{error}");
    let file = folder.path().join("rescued.ron");
    window.key_combination_modifiers(Modifiers::COMMAND, &[Key::S]);
    name_file(&mut window, &file);
    window.run_steps(3);
    assert_eq!(&defocus_app::window::read_state(&file).expect("it was written"), window.state().document());
    let ctx = window.ctx.clone();
    for action in [Action::AddPane, Action::SetShow(PaneId(1), 1), Action::CopyImage(PaneId(1)), Action::ToggleZoom] {
        window.state_mut().perform(&ctx, action);
        window.run_steps(2);
    }
    window.set_size(egui::vec2(900.0, 300.0));
    window.run_steps(3);
}

/// Steps until `done`, some seconds at most: files are looked at once a second.
fn wait_for(window: &mut Window, what: &str, done: impl Fn(&Window) -> bool) {
    let start = Instant::now();
    while !done(window) {
        assert!(start.elapsed() < Duration::from_secs(20), "{what} does not happen");
        std::thread::sleep(Duration::from_millis(20));
        window.step();
    }
    settle(window);
}

fn copy_folder(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("a temporary folder can be made");
    for entry in std::fs::read_dir(from).expect("the shaders are there").flatten() {
        let (file, copy) = (entry.path(), to.join(entry.file_name()));
        match file.is_dir() {
            true => copy_folder(&file, &copy),
            false => std::fs::copy(&file, &copy).map(|_| ()).expect("it is copied"),
        }
    }
}

#[test]
fn a_saved_shader_is_read_again_and_a_broken_one_leaves_the_last() {
    let shaders = tempfile::tempdir().expect("a temporary folder can be made");
    copy_folder(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shaders"), shaders.path());
    let preferences = Preferences { reload_shaders: true, ..Preferences::default() };
    let options =
        AppOptions { shaders: Some(shaders.path().into()), preferences: Some(preferences), ..AppOptions::default() };
    let Tiny { mut window, folder: _folder } = tiny_with(&tiny_files::squares().glb(), &["mipmap"], options);
    let picture = |window: &Window| {
        let engine = window.state().engine();
        download_rgba8(engine.gpu(), engine.pane(PaneId(1)).and_then(|p| p.shown()).expect("it is shown")).pixels
    };
    let before = picture(&window);
    let file = shaders.path().join("methods/mipmap_read.wgsl");
    let source = std::fs::read_to_string(&file).expect("it can be read");
    // The watch takes the files' times as it starts.
    std::thread::sleep(Duration::from_millis(300));
    std::fs::write(&file, format!("{source}\nfn broken( {{")).expect("it can be written");
    wait_for(&mut window, "an error", |window| window.state().last_error().is_some());
    let error = window.state().last_error().unwrap_or_default().to_owned();
    assert!(error.contains("methods/mipmap_read") && error.contains("expected"), "{error}");
    assert!(picture(&window) == before, "the last good shader goes on");
    let black = source.replace(
        "textureStore(result, pixel, vec4f(c, 1.0));",
        "textureStore(result, pixel, vec4f(0.0, 0.0, 0.0, 1.0));",
    );
    std::fs::write(&file, black).expect("it can be written");
    wait_for(&mut window, "another picture", |window| picture(window) != before);
    // The interface around the picture is not black.
    let black = picture(&window).iter().filter(|[r, g, b, _]| [*r, *g, *b] == [0; 3]).count();
    assert!(2 * black > before.len(), "the new shader draws black");
}

#[test]
fn two_builds_of_a_shader_stand_side_by_side() {
    let shaders = tempfile::tempdir().expect("a temporary folder can be made");
    copy_folder(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shaders"), shaders.path());
    let options = AppOptions { shaders: Some(shaders.path().into()), ..AppOptions::default() };
    let Tiny { mut window, folder: _folder } = tiny_with(&tiny_files::squares().glb(), &["mipmap"], options);
    let picture = |window: &Window, id: u32| {
        let engine = window.state().engine();
        download_rgba8(engine.gpu(), engine.pane(PaneId(id)).and_then(|p| p.shown()).expect("it is shown")).pixels
    };
    perform(&mut window, Action::CompareBuilds(PaneId(1)));
    assert!(window.state().preferences().reload_shaders, "files are watched from now on");
    let before = [picture(&window, 1), picture(&window, 2)];
    assert!(before[0] == before[1], "nothing was edited yet");
    let file = shaders.path().join("methods/mipmap_read.wgsl");
    let source = std::fs::read_to_string(&file).expect("it can be read");
    let black = source.replace(
        "textureStore(result, pixel, vec4f(c, 1.0));",
        "textureStore(result, pixel, vec4f(0.0, 0.0, 0.0, 1.0));",
    );
    // The watch takes the files' times as it starts.
    std::thread::sleep(Duration::from_millis(300));
    std::fs::write(&file, black).expect("it can be written");
    wait_for(&mut window, "another picture", |window| picture(window, 1) != before[0]);
    settle(&mut window);
    assert!(picture(&window, 1) != before[0], "the pane follows the file");
    assert!(picture(&window, 2) == before[1], "the other is drawn as the program was built");
    assert!(window.query_all_by_label_contains("shaders as built").next().is_some());
}

/// What differs from run to run and from machine to machine: times, the adapter's name.
fn mask_times(window: &mut Window) {
    let screen = window.ctx.content_rect();
    let panel = window.get_by_label("Lens").rect().left() - 24.0;
    window.mask(Rect::from_min_max(pos2(0.0, screen.bottom() - 62.0), pos2(panel, screen.bottom())));
    window.mask(Rect::from_min_max(pos2(0.0, screen.bottom() - 40.0), screen.max));
}

/// As in `main_window_looks_as_it_did`: 2 % of the pixels.
fn snapshot(window: &mut Window, name: &str) {
    window.remove_cursor();
    window.run_steps(2);
    mask_times(window);
    let pixels = window.ctx.content_rect().area();
    let tolerance = SnapshotOptions::new().threshold(1.0).max_failed_pixels((0.02 * pixels) as usize);
    window.snapshot_options(name, &tolerance);
}

#[test]
fn main_states_look_as_they_did() {
    let preferences = Preferences { theme: Theme::Light, ..Preferences::default() };
    let options = AppOptions { preferences: Some(preferences), ..AppOptions::default() };
    let Tiny { mut window, folder: _folder } = tiny_with(&tiny_files::squares().glb(), &["mipmap", "pinhole"], options);
    perform(&mut window, Action::SetShow(PaneId(1), 1));
    perform(&mut window, Action::Arrange(Arrangement::Wipe));
    snapshot(&mut window, "window_wipe_light");
    perform(&mut window, Action::SetTheme(Theme::Dark));
    perform(&mut window, Action::Arrange(Arrangement::Tiles));
    perform(&mut window, Action::SetMethod(PaneId(2), "opaque".into()));
    perform(&mut window, Action::SetShow(PaneId(2), 5));
    choose(&mut window, "Texture in pane 2", "sub-image of each pixel");
    snapshot(&mut window, "window_inside");
    perform(&mut window, Action::Palette);
    snapshot(&mut window, "window_palette");
}
