//! What the window shows, kept up to date: renders when something it depends on changed
//! and does nothing when nothing did. Knows the library, not the user interface.

use super::settings::{MethodChoice, Show};
use super::timing::History;
use crate::camera::Camera;
use crate::display::Display;
use crate::gpu::{Frame, FrameStats, Gpu, Texture, Timings};
use crate::lens::Lens;
use crate::methods::{self, AccumulationRun, IN_FOCUS_COC_PX, Method, MethodError, Value};
use crate::present::{self, Overlay};
use crate::study::GpuSource;
use crate::view::View;
use glam::{DVec2, UVec2};
use std::time::Instant;

/// GPU time that a step of a progressive reference may take, ms: at 60 Hz two refreshes,
/// so that the interface stays smooth beside it.
const STEP_BUDGET_MS: f64 = 30.0;

/// Views of a step at most, however fast they are.
const MAX_STEP_VIEWS: u32 = 32;

/// Depths that the CoC statistics are taken over, at most: their 95th percentile then has
/// a standard error of 0.2 % in rank, and a lens slider costs under a millisecond.
const DEPTH_SAMPLES: usize = 16_384;

/// Everything that the shown textures depend on.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// Where the scene is seen from; ignored for an image.
    pub camera: Option<Camera>,
    /// Size to render, px.
    pub size: UVec2,
    /// Margin around it, px.
    pub overscan_px: u32,
    /// The lens, its density scaled with the size.
    pub lens: Lens,
    /// The methods.
    pub methods: Vec<MethodChoice>,
    /// Exposure and tone map.
    pub display: Display,
    /// What is shown.
    pub show: Show,
    /// |c| up to which a point counts as sharp, px at this size.
    pub acceptable_coc_px: f32,
    /// |c| at the ends of the CoC's colour map, px at this size.
    pub coc_scale_px: f32,
}

impl Request {
    fn same_picture(&self, other: &Self) -> bool {
        self.camera == other.camera
            && self.size == other.size
            && self.overscan_px == other.overscan_px
            && self.lens == other.lens
    }
}

/// What a pane shows.
pub struct Pane {
    choice: MethodChoice,
    linear: Option<Texture>,
    run: Option<Progressive>,
    /// Display values, once there are some.
    pub shown: Option<Texture>,
    /// Why there is no picture.
    pub error: Option<String>,
}

struct Progressive {
    run: AccumulationRun,
    samples: u32,
}

/// A submitted frame whose times have not arrived.
struct InFlight {
    timings: Timings,
    cpu_ms: f64,
    views: u32,
    since: Instant,
}

/// The renderer behind the viewport.
pub struct Engine {
    gpu: Gpu,
    source: Option<GpuSource>,
    view: Option<(View, UVec2)>,
    panes: Vec<Pane>,
    done: Option<Request>,
    in_flight: Vec<InFlight>,
    ms_per_view: f64,
    depths_m: Option<Vec<f32>>,
    rendered_frames: u64,
    stats: FrameStats,
    /// Times of the last frames.
    pub history: History,
}

impl Engine {
    /// An engine with nothing to show yet.
    pub fn new(gpu: Gpu) -> Self {
        Self {
            gpu,
            source: None,
            view: None,
            panes: Vec::new(),
            done: None,
            in_flight: Vec::new(),
            ms_per_view: STEP_BUDGET_MS,
            depths_m: None,
            rendered_frames: 0,
            stats: FrameStats::default(),
            history: History::default(),
        }
    }

    /// The GPU that everything runs on.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// What is shown, if anything.
    pub fn source(&self) -> Option<&GpuSource> {
        self.source.as_ref()
    }

    /// Shows something else from the next [`Engine::update`] on.
    pub fn set_source(&mut self, source: GpuSource) {
        self.source = Some(source);
        self.view = None;
        self.done = None;
        self.depths_m = None;
        self.panes.clear();
    }

    /// What the panes show.
    pub fn panes(&self) -> &[Pane] {
        &self.panes
    }

    /// Size of the picture, px; the shape of an image is its own.
    pub fn size(&self) -> Option<UVec2> {
        self.view.as_ref().map(|(view, _)| view.size())
    }

    /// Frames submitted to the GPU since the start: it stands still while nothing changes.
    pub fn rendered_frames(&self) -> u64 {
        self.rendered_frames
    }

    /// Counters of the last submitted frame.
    pub fn stats(&self) -> &FrameStats {
        &self.stats
    }

    /// Lens points that a pane's reference has and will have, if it is one.
    pub fn progress(&self, pane: usize) -> Option<(u32, u32)> {
        let progressive = self.panes.get(pane)?.run.as_ref()?;
        Some((progressive.run.count(), progressive.samples))
    }

    /// Whether a later [`Engine::update`] has work to do or times to fetch.
    pub fn is_busy(&self) -> bool {
        !self.in_flight.is_empty() || self.panes.iter().any(Pane::is_converging)
    }

    /// Brings everything up to date with `request`; true if something was rendered.
    ///
    /// # Errors
    ///
    /// A view that cannot be drawn, or a lens that forms no image; what a single method
    /// cannot do is told in its [`Pane`].
    pub fn update(&mut self, request: &Request) -> Result<bool, MethodError> {
        self.poll();
        if self.source.is_none() {
            return Ok(false);
        }
        if self.done.as_ref() != Some(request) {
            request.lens.check()?;
            self.prepare_view(request)?;
            self.render(request);
            return Ok(true);
        }
        // One step at a time: work never queues up behind the interface.
        if self.in_flight.is_empty() && self.panes.iter().any(Pane::is_converging) {
            self.step(request);
            return Ok(true);
        }
        Ok(false)
    }

    fn prepare_view(&mut self, request: &Request) -> Result<(), MethodError> {
        let Some(source) = &self.source else { return Ok(()) };
        let is_scene = source.source().is_scene();
        match &mut self.view {
            Some((view, _)) if is_scene => {
                let before = (view.camera().copied(), *view.projection());
                view.set_size(&self.gpu, request.size, request.overscan_px)?;
                if let Some(camera) = request.camera {
                    view.set_camera(camera);
                }
                if before != (view.camera().copied(), *view.projection()) {
                    self.depths_m = None;
                }
            }
            Some((_, size)) if *size == request.size => {}
            _ => {
                let mut view = source.view(0, request.size, request.overscan_px, None)?;
                if let Some(camera) = request.camera {
                    view.set_camera(camera);
                }
                self.view = Some((view, request.size));
                self.depths_m = None;
            }
        }
        Ok(())
    }

    fn render(&mut self, request: &Request) {
        let same = self.done.as_ref().is_some_and(|done| done.same_picture(request));
        self.panes.truncate(request.methods.len());
        for (index, choice) in request.methods.iter().enumerate() {
            match self.panes.get_mut(index) {
                Some(pane) if same && pane.choice == *choice => {}
                Some(pane) => pane.restart(choice),
                None => self.panes.push(Pane::new(choice)),
            }
        }
        self.done = Some(request.clone());
        self.submit(request, 1);
    }

    fn step(&mut self, request: &Request) {
        let views = (STEP_BUDGET_MS / self.ms_per_view).clamp(1.0, f64::from(MAX_STEP_VIEWS)) as u32;
        self.submit(request, views);
    }

    /// Renders what panes lack, adds `views` to those that converge, and presents all.
    fn submit(&mut self, request: &Request, views: u32) {
        let Some((view, _)) = &mut self.view else { return };
        let start = Instant::now();
        let gpu = self.gpu.clone();
        let mut frame = gpu.frame();
        let mut drawn = 0;
        for pane in &mut self.panes {
            let before = pane.run.as_ref().map_or(0, |p| p.run.count());
            if let Err(error) = pane.advance(&mut frame, view, &request.lens, views) {
                pane.error = Some(error);
                pane.linear = None;
            }
            drawn += pane.run.as_ref().map_or(0, |p| p.run.count()) - before;
        }
        frame.set_prefix("present/");
        present_panes(&mut self.panes, &mut frame, view, request);
        let submitted = frame.finish();
        self.rendered_frames += 1;
        self.stats = submitted.stats;
        let cpu_ms = start.elapsed().as_secs_f64() * 1e3;
        self.in_flight.push(InFlight { timings: submitted.timings, cpu_ms, views: drawn, since: start });
    }

    /// Takes in the times that have arrived.
    fn poll(&mut self) {
        // A lost device never answers; after this long nobody waits for the times any more.
        const GIVE_UP_S: f32 = 10.0;
        let (history, ms_per_view) = (&mut self.history, &mut self.ms_per_view);
        self.in_flight.retain(|flight| match flight.timings.poll() {
            Some(passes) => {
                let gpu_ms: f64 = passes.iter().map(|p| p.ms).sum();
                if flight.views > 0 {
                    *ms_per_view = (gpu_ms.max(flight.cpu_ms) / f64::from(flight.views)).max(1e-3);
                }
                history.push(flight.cpu_ms, &passes);
                false
            }
            None => flight.since.elapsed().as_secs_f32() < GIVE_UP_S,
        });
    }

    /// Depth, metres, at a point of the picture given from (0, 0) top left to (1, 1).
    /// Reads the depth back if that was not done since the view was last drawn.
    pub fn depth_at_m(&mut self, at: DVec2) -> Option<f64> {
        let (view, _) = self.view.as_mut()?;
        let depth = view.depth_m(&self.gpu);
        let texel = (at.clamp(DVec2::ZERO, DVec2::ONE) * depth.size.as_dvec2()).as_uvec2();
        let texel = texel.min(depth.size - 1);
        Some(f64::from(depth.at(texel.x, texel.y)))
    }

    /// A regular sample of the depths in view, metres, read back at most once a redraw;
    /// `None` before there is a view, and where nothing is known yet and `read` is false.
    pub fn depths_m(&mut self, read: bool) -> Option<&[f32]> {
        if self.depths_m.is_none() && read {
            let depth = self.view.as_mut()?.0.depth_m(&self.gpu);
            let stride = depth.pixels.len().div_ceil(DEPTH_SAMPLES).max(1);
            self.depths_m = Some(depth.pixels.iter().step_by(stride).copied().collect());
        }
        self.depths_m.as_deref()
    }

    /// A lens that suits the source seen by `camera` in a frame of `size`.
    ///
    /// # Errors
    ///
    /// A view that cannot be drawn.
    pub fn default_lens(&mut self, camera: Option<Camera>, size: UVec2) -> Result<Lens, MethodError> {
        let Some(source) = &self.source else { return Ok(Lens::PINHOLE) };
        let mut view = source.view(0, size, 0, None)?;
        if let Some(camera) = camera {
            view.set_camera(camera);
        }
        Ok(source.source().default_lens(&view.depth_m(&self.gpu)))
    }
}

impl Pane {
    fn new(choice: &MethodChoice) -> Self {
        Self { choice: choice.clone(), linear: None, run: None, shown: None, error: None }
    }

    /// Starts anew; the last picture stays until there is a next one.
    fn restart(&mut self, choice: &MethodChoice) {
        *self = Self { shown: self.shown.take(), ..Self::new(choice) };
    }

    fn is_converging(&self) -> bool {
        self.error.is_none() && self.run.as_ref().is_some_and(|p| p.run.count() < p.samples)
    }

    fn advance(&mut self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens, views: u32) -> Result<(), String> {
        if self.error.is_some() || (self.linear.is_some() && !self.is_converging()) {
            return Ok(());
        }
        if self.linear.is_none() {
            let mut method = self.choice.build()?;
            if let Some(progressive) = progressive(method.as_mut(), frame, view, lens) {
                self.run = Some(progressive);
            } else {
                self.linear = Some(methods::record(method.as_ref(), frame, view, lens).map_err(|e| e.to_string())?);
                return Ok(());
            }
        }
        if let Some(Progressive { run, samples }) = &mut self.run {
            frame.set_prefix("accumulation/");
            let views = views.min(*samples - run.count());
            run.advance(frame, view, lens, views).map_err(|e| e.to_string())?;
            self.linear = Some(run.mean(frame));
        }
        Ok(())
    }
}

/// A run for the method that converges over many frames, where there is blur to converge.
fn progressive(method: &mut dyn Method, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Option<Progressive> {
    if method.about().id != "accumulation" {
        return None;
    }
    let [low, high] = view.coc_bounds_px(frame, lens);
    if low.abs().max(high.abs()) < IN_FOCUS_COC_PX {
        return None;
    }
    let (mut samples, mut view_dependent) = (1, false);
    for param in method.params() {
        match (param.key, param.value) {
            ("samples", Value::Int { value, .. }) => samples = *value,
            ("view_dependent", Value::Switch(on)) => view_dependent = *on,
            _ => {}
        }
    }
    Some(Progressive { run: AccumulationRun::new(view_dependent), samples: samples.max(1) })
}

fn present_panes(panes: &mut [Pane], frame: &mut Frame<'_>, view: &mut View, request: &Request) {
    let display = &request.display;
    if request.show == Show::Difference
        && let [Pane { linear: Some(a), .. }, Pane { linear: Some(b), .. }] = &panes[..]
    {
        let difference = present::difference(frame, a, b, display);
        for pane in panes {
            pane.shown = Some(difference.clone());
        }
        return;
    }
    let overlay = match request.show {
        Show::Picture | Show::Difference => None,
        Show::Coc => Some(Overlay::Coc { full_scale_px: request.coc_scale_px }),
        Show::Depth => Some(Overlay::Depth),
        Show::Zone => Some(Overlay::Zone { acceptable_px: request.acceptable_coc_px }),
    };
    for pane in panes {
        pane.shown = pane.linear.as_ref().map(|linear| match overlay {
            None => present::picture(frame, linear, display),
            Some(overlay) => present::overlay(frame, view, linear, &request.lens, display, overlay),
        });
    }
}
