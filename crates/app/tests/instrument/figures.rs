//! Figures are about the pictures that are shown: over random actions on the engine, and in
//! the window after a change.

use crate::common::window::{Tiny, Window, settle, type_number};
use crate::{common, tiny_files};
use defocus::gpu::{download, download_rgba8};
use defocus::image::ColorImage;
use defocus::methods::{self, Accumulation};
use defocus_app::window::{
    Action, Difference, DifferenceKind, Document, Engine, Figures, Measured, MethodChoice, Pairing, PaneId,
    PaneMetrics, PaneState, Request, Show, Tempo,
};
use defocus_study::metrics::{self, CompareOptions};
use defocus_study::{DepthArgs, GpuSource, Source};
use glam::{DVec3, UVec2, uvec2};
use std::time::Duration;

/// Random actions of each of the four runs of the property.
const ACTIONS: u32 = 500;

/// One in so many of the figures that are shown is computed again from nothing.
const RECOMPUTED_EVERY: u32 = 4;

/// Lens points of references: few, and a milestone on the way.
const SAMPLES: [u32; 3] = [8, 9, 17];

/// xorshift64*: the same numbers in every run.
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        ((self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 16) % end.max(1) as u64) as usize
    }

    fn of<T: Clone>(&mut self, list: &[T]) -> T {
        list[self.below(list.len())].clone()
    }
}

/// The engine with what is asked of it and the sources that it may show.
struct Bench {
    engine: Engine,
    document: Document,
    size: UVec2,
    sources: Vec<GpuSource>,
    shown: usize,
}

impl Bench {
    fn new(budget_ms: f64) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder can be made");
        let gpu = common::gpu().clone();
        let squares = tiny_files::squares();
        let one = tiny_files::TinyGltf::square();
        let source = |(name, glb): (&str, Vec<u8>)| {
            let file = tiny_files::write(folder.path(), name, &glb);
            let source = Source::open(&file.to_string_lossy(), &DepthArgs::default()).expect("it is a scene");
            source.upload(&gpu, Default::default())
        };
        let sources: Vec<_> = [("squares.glb", squares.glb()), ("one.glb", one.glb())].map(source).into();
        let mut engine = Engine::new(gpu);
        engine.set_tempo(Tempo { budget_ms, rest: Duration::ZERO });
        let mut reference = MethodChoice::reference();
        reference.params.insert("samples".into(), "9".into());
        let document = Document::of_methods([MethodChoice::new("mipmap"), reference]);
        let mut bench = Self { engine, document, size: uvec2(40, 30), sources, shown: 0 };
        bench.show(0);
        bench
    }

    fn show(&mut self, index: usize) {
        let source = self.sources[index].clone();
        let Source::Scene(scene) = source.source() else { panic!("it is a scene") };
        self.document.camera = scene.cameras.first().map(|c| c.camera);
        self.engine.set_source(source);
        let lens = self.engine.default_lens(self.document.camera, self.size).expect("the scene can be drawn");
        self.document.lens = lens;
        self.shown = index;
    }

    fn request(&self) -> Request {
        Request::new(&self.document, self.size, self.document.a)
    }

    fn update(&mut self) -> Request {
        let request = self.request();
        self.engine.update(&request).expect("the lens forms an image");
        request
    }

    /// Goes on until nothing is to be waited for any more.
    fn settle(&mut self) -> Request {
        for _ in 0..60_000 {
            let request = self.update();
            if self.engine.wants_update_in().is_none() {
                return request;
            }
            std::thread::sleep(Duration::from_micros(500));
        }
        panic!("it does not settle");
    }

    fn act(&mut self, random: &mut Random) -> &'static str {
        let ids: Vec<PaneId> = self.document.panes.iter().map(|pane| pane.id).collect();
        let id = random.of(&ids);
        match random.below(16) {
            0 | 1 => {
                let method = random.of(&["pinhole", "mipmap", "separable", "preblur", "accumulation"]);
                self.set_method(id, method, random);
                "method"
            }
            2 => {
                if let Some(pane) = self.document.pane_mut(id).filter(|pane| pane.method.id == "mipmap") {
                    pane.method.params.insert("smoothing".into(), random.of(&["on", "off"]).into());
                }
                "parameter"
            }
            3 | 4 => {
                self.document.lens.aperture_diameter_mm *= random.of(&[0.0, 0.5, 0.9, 1.1, 2.0]);
                self.document.lens.aperture_diameter_mm = self.document.lens.aperture_diameter_mm.clamp(0.0, 400.0);
                if self.document.lens.aperture_diameter_mm == 0.0 && random.below(2) == 0 {
                    self.document.lens.aperture_diameter_mm = 20.0;
                }
                "aperture"
            }
            5 | 6 => {
                let focus_m = self.document.lens.focus_distance_m * random.of(&[0.8, 0.95, 1.05, 1.3]);
                let nearest_m = 2.0 * self.document.lens.focal_length_mm / 1000.0;
                self.document.lens.focus_distance_m = focus_m.clamp(nearest_m, 50.0);
                "focus"
            }
            7 => {
                if let Some(camera) = &mut self.document.camera {
                    camera.position += DVec3::new(random.of(&[-0.05, 0.05]), random.of(&[-0.03, 0.0]), 0.0);
                }
                "camera"
            }
            8 => {
                self.size = random.of(&[uvec2(40, 30), uvec2(48, 20), uvec2(24, 30)]);
                "size"
            }
            9 => {
                self.document.display.exposure_ev = random.of(&[-1.0, 0.0, 0.5]);
                "exposure"
            }
            10 => {
                let against = random.of(&ids);
                let kind = random.of(&DifferenceKind::ALL).0;
                if let Some(pane) = self.document.pane_mut(id).filter(|_| against != id) {
                    pane.show =
                        random.of(&[Show::Picture, Show::Coc, Show::Difference(Difference::new(against, kind))]);
                }
                "show"
            }
            11 => {
                if self.document.panes.len() < 4 {
                    self.document.add_pane(MethodChoice::new("pinhole"));
                } else {
                    self.document.close_pane(id);
                }
                "panes"
            }
            12 => {
                self.document.measure = !self.document.measure;
                "measure"
            }
            13 => {
                self.document.arrangement =
                    random.of(&[defocus_app::window::Arrangement::One, defocus_app::window::Arrangement::Tiles]);
                "arrangement"
            }
            14 if random.below(4) == 0 => {
                self.show(1 - self.shown);
                "scene"
            }
            _ => "nothing",
        }
    }

    fn set_method(&mut self, id: PaneId, method: &str, random: &mut Random) {
        let Some(pane) = self.document.pane_mut(id) else { return };
        pane.method = MethodChoice::new(method);
        if method == "accumulation" {
            pane.method.params.insert("samples".into(), random.of(&SAMPLES).to_string());
            pane.method.params.insert("view_dependent".into(), random.of(&["on", "off"]).into());
        }
    }

    /// Holds all that is shown to what was asked for; the current figures.
    fn check(&self, request: &Request, after: &str) -> Vec<(PaneId, Measured)> {
        let mut current = Vec::new();
        for state in request.panes.iter().filter(|state| request.visible.contains(&state.id)) {
            let pane_metrics = self.engine.pane_metrics(state.id);
            let Some(truth) = request.reference.filter(|truth| *truth != state.id) else {
                assert_eq!(pane_metrics, PaneMetrics::Unasked, "after {after}");
                continue;
            };
            match pane_metrics {
                PaneMetrics::Current(measured) => {
                    let Pairing { picture, truth: of, display, .. } = &measured.of;
                    let shown = self.engine.pane(state.id).and_then(|pane| pane.identity());
                    assert_eq!(shown, Some(picture), "after {after}: figures of what is shown");
                    assert_eq!((&picture.method, &picture.render), (&state.method, &request.render), "after {after}");
                    let truth = request.panes.iter().find(|pane| pane.id == truth).expect("it is asked for");
                    assert_eq!((&of.method, &of.render), (&truth.method, &request.render), "after {after}");
                    assert_eq!(*display, request.display_settings.display, "after {after}");
                    current.push((state.id, measured.clone()));
                }
                PaneMetrics::Outdated(_, departures) => {
                    assert!(!departures.is_empty(), "after {after}: it says what it is of");
                }
                PaneMetrics::Pending => {}
                PaneMetrics::Unasked => panic!("after {after}: there is a reference"),
            }
        }
        current
    }

    /// A picture made from nothing by what its identity says.
    fn picture(&self, of: &defocus_app::window::Identity) -> ColorImage {
        let source = &self.sources[self.shown];
        let mut view = source.view(0, of.render.size, of.render.overscan_px, None).expect("the view can be made");
        if let Some(camera) = of.render.camera {
            view.set_camera(camera);
        }
        let mut method = of.method.build().expect("there is such a method");
        if let Some(samples) = of.samples {
            let text = of.method.params.get("view_dependent").is_some_and(|text| text == "on");
            method = Box::new(Accumulation { samples, view_dependent: text });
        }
        let mut frame = common::gpu().frame();
        let texture =
            methods::record(method.as_ref(), &mut frame, &mut view, &of.render.lens).expect("it can be drawn");
        frame.finish();
        download(common::gpu(), &texture)
    }

    fn recompute(&self, measured: &Measured, after: &str) {
        let Pairing { picture, truth, display, viewing } = &measured.of;
        let (a, b) = (self.picture(picture), self.picture(truth));
        let options = CompareOptions { display: *display, viewing: *viewing, ..Default::default() };
        let m = metrics::compare(&a, &b, &options).expect("they can be compared");
        let wanted = Figures {
            identical: m.identical,
            psnr_db: m.psnr_db,
            ssim: m.ssim,
            flip: m.flip,
            px_per_degree: m.px_per_degree,
            jod: m.jod,
        };
        assert_eq!(measured.result, Ok(wanted), "after {after}: {picture:?}");
    }

    /// What a pane shows is what its identity says, as the display shows it.
    fn recompute_shown(&self, state: &PaneState, request: &Request, after: &str) {
        let Some(pane) = self.engine.pane(state.id) else { return };
        let (Some(identity), Some(shown)) = (pane.identity(), pane.shown()) else { return };
        if state.show != Show::Picture || identity.samples.is_some() {
            return;
        }
        let shown = download_rgba8(common::gpu(), shown);
        let wanted = defocus_study::report::shown(&self.picture(identity), request.display_settings.display);
        let differs = |(a, b): (&[u8; 4], &[u8; 3])| a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > 1);
        assert_eq!(shown.size, wanted.size, "after {after}");
        let wrong = shown.pixels.iter().zip(&wanted.pixels).filter(|pair| differs(*pair)).count();
        assert_eq!(wrong, 0, "after {after}: pixels of {:?} that are not what it says", identity.method);
    }
}

#[test]
fn whatever_is_shown_matches_a_recomputation_over_random_actions() {
    random_actions(0x9e37_79b9_7f4a_7c15);
}

#[test]
fn whatever_is_shown_matches_a_recomputation_over_other_actions() {
    random_actions(0xd1b5_4a32_d192_ed03);
}

#[test]
fn whatever_is_shown_matches_a_recomputation_over_yet_others() {
    random_actions(0x2545_f491_4f6c_dd1d);
}

#[test]
fn whatever_is_shown_matches_a_recomputation_over_the_last_of_two_thousand() {
    random_actions(0x94d0_49bb_1331_11eb);
}

fn random_actions(seed: u64) {
    let mut bench = Bench::new(f64::INFINITY);
    let mut random = Random(seed);
    let (mut seen, mut recomputed, mut settled) = (0, 0, 0);
    for index in 0..ACTIONS {
        let after = format!("action {index}, {}", bench.act(&mut random));
        for _ in 0..random.below(4) {
            let request = bench.update();
            for (_, measured) in bench.check(&request, &after) {
                seen += 1;
                if seen % RECOMPUTED_EVERY == 0 {
                    bench.recompute(&measured, &after);
                    recomputed += 1;
                }
            }
        }
        if index % 20 != 19 {
            continue;
        }
        // The last answer always arrives, and is about all of the reference.
        let request = bench.settle();
        let current = bench.check(&request, &after);
        settled += 1;
        let measured = request.visible.iter().filter(|id| request.reference.is_some_and(|truth| truth != **id));
        assert_eq!(current.len(), measured.count(), "after {after}: every pane has its figures");
        for (_, Measured { of, .. }) in &current {
            let goal = of.truth.method.params.get("samples").and_then(|text| text.parse().ok());
            // Without blur, the reference is the pinhole image at once.
            assert!(of.truth.samples.is_none() || of.truth.samples == goal, "after {after}: {:?}", of.truth);
        }
        for (_, measured) in current.iter().take(1) {
            bench.recompute(measured, &after);
            recomputed += 1;
        }
        if settled % 10 == 0 {
            request.panes.iter().for_each(|state| bench.recompute_shown(state, &request, &after));
        }
    }
    eprintln!("{seen} current figures seen, {recomputed} computed again, settled {settled} times");
    // At rest there are figures in most of the cases; on the way as many as there was time for.
    assert!(recomputed > 8, "{seen} figures on the way, {recomputed} computed again");
}

/// The texts at the feet of panes that tell figures.
fn feet(window: &Window) -> Vec<String> {
    crate::texts(window).into_iter().filter(|text| text.contains("FLIP 0")).collect()
}

fn tiny() -> Tiny {
    common::window::tiny(&tiny_files::squares().glb(), &["mipmap", "accumulation"])
}

fn psnr_db(window: &Window) -> f64 {
    let PaneMetrics::Current(Measured { result: Ok(figures), .. }) = window.state().engine().pane_metrics(PaneId(1))
    else {
        panic!("{:?}", window.state().engine().pane_metrics(PaneId(1)));
    };
    figures.psnr_db.expect("the pictures differ")
}

#[test]
fn a_method_chosen_by_keys_takes_the_figures_of_the_one_before_with_it() {
    let Tiny { mut window, folder: _folder } = tiny();
    let before_db = psnr_db(&window);
    let starts = |window: &Window, start: String| feet(window).iter().any(|text| text.starts_with(&start));
    assert!(starts(&window, format!("{before_db:.1} dB")), "{:?}", feet(&window));
    let ctx = window.ctx.clone();
    window.state_mut().perform(&ctx, Action::SetMethod(PaneId(1), "pinhole".into()));
    // In the very frame in which the picture is another one.
    window.step();
    assert!(starts(&window, format!("before (Anisotropic mipmaps): {before_db:.1} dB")), "{:?}", feet(&window));
    assert!(matches!(window.state().engine().pane_metrics(PaneId(1)), PaneMetrics::Outdated(..)));
    settle(&mut window);
    let after_db = psnr_db(&window);
    assert_ne!(after_db, before_db, "another method is as far from the truth as it is");
    assert!(starts(&window, format!("{after_db:.1} dB")), "{:?}", feet(&window));
    assert!(!starts(&window, "before".into()), "{:?}", feet(&window));
}

#[test]
fn the_last_answer_arrives_without_the_pointer() {
    let Tiny { mut window, folder: _folder } = tiny();
    type_number(&mut window, "Focus distance", "1.5");
    // As eframe does: a frame only where one is asked for.
    let mut frames = 0;
    loop {
        let wait = window.output().viewport_output[&eframe::egui::ViewportId::ROOT].repaint_delay;
        if wait > Duration::from_secs(60) && !window.ctx.has_requested_repaint() {
            break;
        }
        std::thread::sleep(wait.min(Duration::from_millis(20)));
        window.step();
        frames += 1;
        assert!(frames < 5000, "it goes on for ever");
    }
    let shown = feet(&window);
    assert!(shown.iter().any(|text| text.ends_with("at 8 points")), "{shown:?}");
    let PaneMetrics::Current(measured) = window.state().engine().pane_metrics(PaneId(1)) else { panic!("{shown:?}") };
    assert_eq!(measured.of.truth.samples, Some(8));
}
