//! The panels, each alone and driven by the names of its inputs.

#![cfg(feature = "window")]

mod common;

use defocus::aperture::Aperture;
use defocus::display::Display;
use defocus::image::{ColorImage, Image};
use defocus::lens::Lens;
use defocus::presets::{LensPreset, preset};
use defocus::stereo::{Layout, Stereo};
use defocus_app::window::apply_style;
use defocus_app::window::panels::{
    Focusing, Inspection, LensChanges, LensPanel, LensReadings, PaneValue, VrAction, VrReadings, aperture_panel,
    focus_panel, image_histogram, inspector_panel, neighbourhood, vr_panel,
};
use defocus_app::window::{DistanceUnit, FocusMode, FocusSettings};
use eframe::egui::{self, Modifiers, PointerButton, Role, Ui, pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use glam::{UVec2, Vec3, uvec2};

const DEPTHS_M: [f32; 6] = [0.8, 1.0, 1.5, 2.5, 6.0, f32::INFINITY];

fn harness<S: 'static>(state: S, show: impl FnMut(&mut Ui, &mut S) + 'static) -> Harness<'static, S> {
    let mut harness = Harness::builder()
        .with_size(vec2(330.0, 980.0))
        .with_max_steps(4)
        // Two clicks within the 0.3 s of a double-click.
        .with_step_dt(0.02)
        .with_context_setup(apply_style)
        .build_ui_state(show, state);
    harness.run_steps(2);
    harness
}

fn type_number<S>(window: &mut Harness<'_, S>, name: &str, text: &str) {
    window.get_by_role_and_label(Role::SpinButton, name).click();
    window.run_steps(2);
    window.key_combination_modifiers(Modifiers::COMMAND, &[egui::Key::A]);
    window.run_steps(1);
    let field = window.query_by_role_and_label(Role::TextInput, name);
    field.unwrap_or_else(|| window.get_by_role_and_label(Role::SpinButton, name)).type_text(text);
    window.run_steps(1);
    window.key_press(egui::Key::Enter);
    window.run_steps(2);
}

fn choose<S>(window: &mut Harness<'_, S>, list: &str, entry: &str) {
    window.get_by_role_and_label(Role::ComboBox, list).click();
    window.run_steps(2);
    window.get_all_by_label(entry).last().expect("the entry is in the list").click();
    window.run_steps(3);
}

fn press(window: &Harness<'_, impl Sized>, at: egui::Pos2, pressed: bool) {
    let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
    window.event(egui::Event::PointerButton { pos: at, button, pressed, modifiers });
}

fn double_click<S>(window: &mut Harness<'_, S>, at: egui::Pos2) {
    window.event(egui::Event::PointerMoved(at));
    // Longer than three clicks in a row may take: the last one, elsewhere, would count.
    window.run_steps(20);
    for pressed in [true, false, true, false] {
        press(window, at, pressed);
        window.run_steps(1);
    }
    window.run_steps(1);
}

struct Bench {
    panel: LensPanel,
    lens: Lens,
    automatic: bool,
    own: Vec<LensPreset>,
    fov_x: f64,
    done: LensChanges,
    wants_image: bool,
}

/// What was done over all frames.
fn add(done: &mut LensChanges, new: LensChanges) {
    done.lens |= new.lens;
    done.focus |= new.focus;
    done.suit_scene |= new.suit_scene;
    done.camera_fov_x = new.camera_fov_x.or(done.camera_fov_x);
}

fn lens_bench(lens: Lens) -> Harness<'static, Bench> {
    let bench = Bench {
        panel: LensPanel::default(),
        lens,
        automatic: false,
        own: Vec::new(),
        fov_x: 1.0,
        done: LensChanges::default(),
        wants_image: false,
    };
    harness(bench, |ui, bench| {
        let readings = LensReadings {
            depths_m: Some(&DEPTHS_M),
            acceptable_px: 2.0,
            size_px: uvec2(800, 600),
            fov_x: Some(bench.fov_x),
            has_camera: true,
        };
        let new = bench.panel.show(ui, &mut bench.lens, bench.automatic, &mut bench.own, readings);
        add(&mut bench.done, new);
        bench.wants_image |= aperture_panel(ui, &mut bench.lens.aperture).wants_image;
    })
}

fn projection() -> Lens {
    preset("projection").unwrap().lens
}

#[test]
fn every_number_of_the_lens_can_be_typed_and_reset() {
    type Read = fn(&Lens) -> f64;
    let numbers: [(&str, &str, Read, f64); 6] = [
        ("Aperture E", "6.5", |l| l.aperture_diameter_mm, 6.5),
        ("f-number", "4", |l| l.aperture_diameter_mm, 17.0 / 4.0),
        ("Focal length F", "20", |l| l.focal_length_mm, 20.0),
        ("Image at dr", "22", |l| l.image_distance_mm, 22.0),
        ("Screen at ds", "2000", |l| l.screen_distance_mm, 2000.0),
        ("Screen DPI", "0.5", |l| l.density_px_per_mm, 0.5),
    ];
    for (name, text, read, expected) in numbers {
        let mut window = lens_bench(projection());
        type_number(&mut window, name, text);
        assert_eq!(read(&window.state().lens), expected, "{name}");
        assert!(window.state().done.lens && !window.state().done.focus, "{name}");
        let name_at = window.get_by_role_and_label(Role::Label, name).rect().center();
        double_click(&mut window, name_at);
        let before = read(&projection());
        assert!((read(&window.state().lens) / before - 1.0).abs() < 1e-12, "{name} is not reset");
    }
}

#[test]
fn focus_is_given_in_any_unit() {
    for (unit, symbol, text, metres) in [
        (DistanceUnit::Metres, "m", "0.8", 0.8),
        (DistanceUnit::Centimetres, "cm", "65", 0.65),
        (DistanceUnit::Feet, "ft", "3", 0.9144),
        (DistanceUnit::Dioptres, "dpt", "2.5", 0.4),
        (DistanceUnit::Dioptres, "dpt", "0", f64::INFINITY),
    ] {
        let mut window = lens_bench(projection());
        window.get_by_label(symbol).click();
        window.run_steps(2);
        assert_eq!(window.state().panel.unit, unit);
        type_number(&mut window, "Focus distance", text);
        let focus_m = window.state().lens.focus_distance_m;
        assert!(focus_m == metres || (focus_m / metres - 1.0).abs() < 1e-12, "{text} {symbol}: {focus_m}");
        assert!(window.state().done.focus);
    }
}

#[test]
fn a_display_is_given_by_field_of_view_and_resolution() {
    let mut window = lens_bench(projection());
    window.get_by_label("field of view").click();
    window.run_steps(2);
    type_number(&mut window, "Resolution", "1440");
    type_number(&mut window, "Field of view", "90");
    let lens = &window.state().lens;
    assert!((lens.display_fov_x(1440).to_degrees() - 90.0).abs() < 1e-9);
    assert_eq!(lens.screen_distance_mm, 3000.0, "ds stays");
}

#[test]
fn a_false_perspective_is_told_and_made_true() {
    let mut window = lens_bench(projection());
    let display_fov = projection().display_fov_x(800);
    window.get_by_label("Fit the camera").click();
    window.run_steps(1);
    assert_eq!(window.state().done.camera_fov_x, Some(display_fov));
    window.get_by_label("Fit the display").click();
    window.run_steps(2);
    assert!((window.state().lens.display_fov_x(800) - 1.0).abs() < 1e-9);
    assert!(window.query_by_label("Fit the camera").is_none(), "nothing is wrong any more");
}

#[test]
fn presets_are_chosen_saved_and_forgotten() {
    let mut window = lens_bench(projection());
    choose(&mut window, "Preset", "camera-50mm");
    let camera = preset("camera-50mm").unwrap().lens;
    assert_eq!(window.state().lens, Lens { focus_distance_m: projection().focus_distance_m, ..camera });
    type_number(&mut window, "Aperture E", "11");
    window.get_by_label("Save").click();
    window.run_steps(2);
    window.get_by_role_and_label(Role::TextInput, "Save as").click();
    window.run_steps(1);
    window.get_by_role_and_label(Role::TextInput, "Save as").type_text("mine");
    window.run_steps(2);
    window.get_by_label("Save preset").click();
    window.run_steps(2);
    assert_eq!(window.state().own.len(), 1);
    assert_eq!((window.state().own[0].name.as_str(), window.state().own[0].lens.aperture_diameter_mm), ("mine", 11.0));
    choose(&mut window, "Preset", "projection");
    choose(&mut window, "Preset", "mine");
    assert_eq!(window.state().lens.aperture_diameter_mm, 11.0);
    window.get_by_label("Save").click();
    window.run_steps(2);
    window.get_by_label("Forget").click();
    window.run_steps(2);
    assert!(window.state().own.is_empty());
    choose(&mut window, "Preset", "Suits the scene");
    assert!(window.state().done.suit_scene);
}

#[test]
fn the_focus_is_dragged_in_the_plot() {
    let mut window = lens_bench(projection());
    let plot = window.get_by_role_and_label(Role::Slider, "Focus in the plot").rect();
    let at = |x: f32| pos2(plot.left() + x * plot.width(), plot.center().y);
    window.event(egui::Event::PointerMoved(at(0.2)));
    window.run_steps(1);
    press(&window, at(0.2), true);
    window.run_steps(1);
    let mut seen = Vec::new();
    for x in [0.3, 0.5, 0.7] {
        window.event(egui::Event::PointerMoved(at(x)));
        window.run_steps(1);
        seen.push(window.state().lens.focus_distance_m);
    }
    press(&window, at(0.7), false);
    window.run_steps(1);
    assert!(seen.windows(2).all(|w| w[0] < w[1]), "farther to the right: {seen:?}");
    assert!(window.state().done.focus && !window.state().done.lens);
    // Over 0.64 m to 7.5 m of the scene, 70 % of the logarithmic way.
    assert!((2.5..5.0).contains(&seen[2]), "{seen:?}");
}

#[test]
fn the_aperture_has_every_shape() {
    let mut window = lens_bench(projection());
    choose(&mut window, "Aperture shape", "Polygon");
    type_number(&mut window, "Blades", "5");
    type_number(&mut window, "Roundness", "0.4");
    type_number(&mut window, "Rotation", "30");
    let expected = Aperture::Polygon { blades: 5, rotation_deg: 30.0, roundness: 0.4 };
    assert_eq!(window.state().lens.aperture, expected);
    choose(&mut window, "Aperture shape", "Gaussian");
    type_number(&mut window, "Sigma / C", "0.25");
    assert_eq!(window.state().lens.aperture, Aperture::Gaussian { sigma_per_coc: 0.25 });
    choose(&mut window, "Aperture shape", "Image");
    assert!(window.state().wants_image);
    assert_eq!(window.state().lens.aperture, Aperture::Gaussian { sigma_per_coc: 0.25 }, "until there is an image");
    choose(&mut window, "Aperture shape", "Disc");
    assert_eq!(window.state().lens.aperture, Aperture::Disc);
    assert!(window.query_by_label("Aperture drawing").is_some());
}

/// Whatever is typed: impossible lenses are shown as such, and nothing panics.
#[test]
fn no_number_breaks_the_panel() {
    let names =
        ["Aperture E", "f-number", "Focal length F", "Image at dr", "Screen at ds", "Screen DPI", "Focus distance"];
    for text in ["0", "-5", "1e300", "∞", "nan"] {
        let mut window = lens_bench(projection());
        for name in names {
            type_number(&mut window, name, text);
        }
        assert!(window.query_by_label("Preset").is_some());
        let mut window = lens_bench(projection());
        window.get_by_label("field of view").click();
        window.run_steps(2);
        choose(&mut window, "Aperture shape", "Polygon");
        for name in ["Resolution", "Field of view", "Blades", "Roundness", "Rotation", "Mean blur"] {
            type_number(&mut window, name, text);
        }
        assert_eq!(window.state().lens.aperture.check(), Ok(()), "{text}");
    }
}

#[test]
fn focus_modes_and_the_eye_can_be_set() {
    let mut window = harness(FocusSettings::default(), |ui, settings| {
        focus_panel(ui, settings, false);
    });
    for (mode, name, _) in FocusMode::ALL {
        choose(&mut window, "Focus on", name);
        assert_eq!(window.state().mode, mode);
    }
    type_number(&mut window, "Eye's lag", "0.5");
    type_number(&mut window, "Area", "21");
    assert_eq!(*window.state(), FocusSettings { mode: FocusMode::Centre, area_radius_px: 10, time_constant_s: 0.5 });
}

#[test]
fn a_following_focus_goes_on_until_it_arrives() {
    let mut focusing = Focusing::default();
    let (mut focus_m, mut frames) = (4.0, 0);
    loop {
        let step = focusing.follow(0.5, focus_m, 0.3, 1.0 / 60.0);
        assert!(step.focus_m <= focus_m);
        (focus_m, frames) = (step.focus_m, frames + 1);
        if !step.moving {
            break;
        }
    }
    assert_eq!(focus_m, 0.5);
    // ln(1.75 / 0.01) time constants from 0.25 to 2 dioptres.
    assert_eq!(frames, (175.0_f64.ln() * 0.3 * 60.0).ceil() as i32);
    // Something else moved the focus: the eye starts there.
    let step = focusing.follow(0.5, 100.0, 0.3, 1e-3);
    assert!(step.focus_m > 50.0 && step.moving);
}

#[test]
fn two_eyes_and_headsets_are_chosen() {
    struct State {
        stereo: Option<Stereo>,
        lens: Lens,
        action: Option<VrAction>,
    }
    let state = State { stereo: None, lens: projection(), action: None };
    let mut window = harness(state, |ui, state| {
        let focus_m = state.lens.focus_distance_m;
        let readings = VrReadings { is_scene: true, focal_px: Some(600.0), focus_m, size_px: uvec2(64, 48) };
        state.action = vr_panel(ui, &mut state.stereo, &state.lens, readings).or(state.action);
    });
    window.get_by_role_and_label(Role::CheckBox, "Stereo").click();
    window.run_steps(2);
    assert_eq!(window.state().stereo, Some(Stereo::default()));
    for (layout, name) in Layout::ALL {
        choose(&mut window, "Eyes", name);
        assert_eq!(window.state().stereo.map(|s| s.layout), Some(layout));
    }
    type_number(&mut window, "Eye distance", "65");
    type_number(&mut window, "Window at", "2");
    let expected = Stereo { layout: Layout::GreyAnaglyph, ipd_mm: 65.0, window_m: 2.0 };
    assert_eq!(window.state().stereo, Some(expected));
    assert!(window.query_by_label("Picture as large as its eye").is_none(), "the lens is no headset's");
    let preset = preset("hmd-xr4").expect("it is one of the presets");
    let headset = preset.headset.expect("it is a headset");
    window.state_mut().lens = Lens { aperture_diameter_mm: 6.5, focus_distance_m: 0.7, ..preset.lens };
    window.run_steps(2);
    assert!(window.query_by_label_contains("Varjo XR-4").is_some());
    window.get_by_label("Picture as large as its eye").click();
    window.run_steps(2);
    assert_eq!(window.state().action, Some(VrAction::PictureSize(headset.eye_px.0, headset.eye_px.1)));
    window.get_by_role_and_label(Role::CheckBox, "Stereo").click();
    window.run_steps(2);
    assert_eq!(window.state().stereo, None);
}

#[test]
fn the_inspector_tells_everything_about_a_pixel() {
    let picture: ColorImage = Image::from_fn(uvec2(32, 24), |x, y| Vec3::new(x as f32 / 16.0, y as f32 / 24.0, 0.25));
    let pixel = uvec2(31, 0);
    let inspection = Inspection {
        pixel,
        depth_m: 0.6,
        panes: vec![PaneValue {
            name: "1 mipmap".into(),
            color: picture.at(31, 0),
            numbers: vec![("slab index".into(), "2".into())],
            divisor: 4,
        }],
        neighbourhood: neighbourhood(&picture, pixel, 7),
    };
    assert_eq!(inspection.neighbourhood.size, UVec2::splat(15));
    assert_eq!(inspection.neighbourhood.at(7, 7), picture.at(31, 0));
    assert_eq!(inspection.neighbourhood.at(14, 0), picture.at(31, 0), "beyond the border it repeats");
    let lens = projection();
    let display = Display::default();
    let histogram = image_histogram(&picture, &display);
    assert_eq!(histogram.total(), 32 * 24);
    let coc = lens.coc_diameter_px(0.6);
    let window = harness((), move |ui, ()| {
        inspector_panel(ui, Some(&inspection), &lens, &display, Some(&histogram), Some(&DEPTHS_M));
    });
    assert!(coc < 0.0);
    for text in ["31, 0", "0.6 m", "1.94 0 0.25", "255 0 137", "in the picture at 1/4:"] {
        assert!(window.query_by_label_contains(text).is_some(), "{text} is not shown");
    }
    for name in ["Neighbourhood", "Luminance histogram", "CoC histogram"] {
        assert!(window.query_all_by_label(name).next().is_some(), "{name} is not shown");
    }
}
