//! The interface goes on whatever a method takes: counted in what is drawn in its frames.

use crate::common::window::{Window, settle, window_with};
use crate::{says, tiny_files};
use defocus::gpu::download;
use defocus_app::window::{Action, AppOptions, Document, MethodChoice, PaneId, PaneMetrics, PictureSize, Tempo};
use glam::{UVec2, uvec2};

/// Pixels of the picture.
const SIZE: UVec2 = uvec2(96, 64);

struct Slow {
    window: Window,
    _folder: tempfile::TempDir,
}

/// A window in which no method is quick enough to be drawn in full at once.
fn slow(methods: &[&str], tempo: Tempo) -> Slow {
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let scene = tiny_files::write(folder.path(), "squares.glb", &tiny_files::squares().glb());
    let choice = |id: &&str| {
        let mut choice = MethodChoice::new(id);
        if *id == "accumulation" {
            choice.params.insert("samples".into(), "9".into());
        }
        choice
    };
    let document = Document {
        overscan_px: 8,
        scene: scene.to_string_lossy().into_owned(),
        size: PictureSize::Pixels(SIZE.x, SIZE.y),
        ..Document::of_methods(methods.iter().map(choice))
    };
    let options = AppOptions { document: Some(document), tempo, ..AppOptions::default() };
    Slow { window: window_with([1120.0, 260.0], options), _folder: folder }
}

fn no_time() -> Tempo {
    Tempo { budget_ms: 1e-6, ..Tempo::default() }
}

fn shown_size(window: &Window, id: u32) -> UVec2 {
    let pane = window.state().engine().pane(PaneId(id)).expect("the pane is there");
    pane.linear().expect("there is a picture").size()
}

#[test]
fn what_is_slow_is_drawn_smaller_while_a_value_changes_says_so_and_sharpens() {
    let Slow { mut window, _folder } = slow(&["splat"], no_time());
    assert_eq!(shown_size(&window, 1), SIZE, "at rest it is drawn in full");
    assert!(!says(&window, "drawn at 1/"));
    // As while a slider is dragged: another value in each frame.
    for step in 1..=3 {
        let lens = window.state().document().lens.clone();
        drag_aperture(&mut window);
        assert_ne!(window.state().document().lens, lens, "step {step}");
        let pane = window.state().engine().pane(PaneId(1)).expect("the pane is there");
        assert_eq!(pane.divisor(), 8, "nothing larger is drawn in the interface's frames");
        assert_eq!(shown_size(&window, 1), SIZE / 8);
    }
    window.step();
    assert!(says(&window, "drawn at 1/8"), "{:?}", crate::texts(&window));
    settle(&mut window);
    assert_eq!(shown_size(&window, 1), SIZE, "it sharpens when it rests");
    assert!(!says(&window, "drawn at 1/"));
}

/// Moves the aperture's slider a little, in one frame.
fn drag_aperture(window: &mut Window) {
    use eframe::egui::Role;
    use egui_kittest::kittest::Queryable;
    let slider = window.get_by_role_and_label(Role::Slider, "Aperture E");
    // That of the slider is the one of the frame before.
    let value = window.state().document().lens.aperture_diameter_mm;
    // Downwards: a wide lens may stand near the slider's end.
    slider.set_value_accesskit(0.9 * value);
    window.step();
}

#[test]
fn what_is_drawn_beside_is_what_is_drawn_here() {
    let at_once = Tempo { budget_ms: 1e9, ..Tempo::default() };
    for methods in [["mipmap", "accumulation"], ["adaptive", "splat"]] {
        let pictures = [at_once, no_time()].map(|tempo| {
            let Slow { window, _folder } = slow(&methods, tempo);
            let engine = window.state().engine();
            [1, 2].map(|id| {
                let pane = engine.pane(PaneId(id)).expect("the pane is there");
                assert_eq!(pane.error(), None);
                (pane.identity().cloned(), download(engine.gpu(), pane.linear().expect("there is a picture")))
            })
        });
        let [here, beside] = pictures;
        for ((identity, picture), (identity_beside, picture_beside)) in here.into_iter().zip(beside) {
            let method = identity.as_ref().map(|i| (i.method.id.clone(), i.samples));
            let beside = identity_beside.as_ref().map(|i| (i.method.id.clone(), i.samples));
            assert_eq!(method, beside);
            let differs = |(a, b): (&glam::Vec3, &glam::Vec3)| (*a - *b).abs().max_element() > 1e-6;
            let wrong = picture.pixels.iter().zip(&picture_beside.pixels).filter(|pair| differs(*pair)).count();
            assert_eq!(wrong, 0, "{method:?}");
        }
    }
}

#[test]
fn figures_of_what_is_drawn_beside_are_of_the_full_picture() {
    let Slow { mut window, _folder } = slow(&["mipmap", "accumulation"], no_time());
    for change in 0..2 {
        let PaneMetrics::Current(measured) = window.state().engine().pane_metrics(PaneId(1)) else {
            panic!("after {change} changes: {:?}", window.state().engine().pane_metrics(PaneId(1)));
        };
        assert_eq!(measured.of.picture.render.size, SIZE);
        assert_eq!(measured.of.truth.samples, Some(9));
        let frames = window.state().engine().rendered_frames();
        window.run_steps(3);
        assert_eq!(window.state().engine().rendered_frames(), frames, "at rest nothing is drawn");
        drag_aperture(&mut window);
        settle(&mut window);
    }
}

#[test]
fn what_is_not_wanted_any_more_is_given_up() {
    let Slow { mut window, _folder } = slow(&["pinhole"], no_time());
    let ctx = window.ctx.clone();
    window.state_mut().perform(&ctx, Action::SetMethod(PaneId(1), "accumulation".into()));
    for _ in 0..8 {
        window.step();
    }
    assert!(!window.state().is_settled(), "256 views take a while");
    window.state_mut().perform(&ctx, Action::SetMethod(PaneId(1), "pinhole".into()));
    settle(&mut window);
    let pane = window.state().engine().pane(PaneId(1)).expect("the pane is there");
    assert_eq!(pane.identity().map(|identity| identity.method.id.clone()).as_deref(), Some("pinhole"));
    assert!(!pane.is_drawn_beside());
}

#[test]
fn it_is_told_which_pass_costs_most_also_in_software() {
    let Slow { mut window, _folder } = slow(&["mipmap"], Tempo { budget_ms: 1e9, ..Tempo::default() });
    let ctx = window.ctx.clone();
    window.state_mut().perform(&ctx, Action::TimePasses);
    settle(&mut window);
    let timed = window.state().engine().pass_times().expect("they were asked for");
    assert_eq!((timed.of.method.id.as_str(), timed.of.render.size), ("mipmap", SIZE));
    let times = timed.times.as_ref().expect("they are there").as_ref().expect("it can be drawn");
    assert!(times.len() > 3 && times.iter().all(|pass| pass.ms >= 0.0), "{times:?}");
    assert!(times.iter().any(|pass| pass.label.starts_with("mipmap/")), "{times:?}");
}
