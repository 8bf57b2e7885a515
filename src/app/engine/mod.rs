//! What the window shows, kept up to date: renders when something it depends on changed
//! and does nothing when nothing did. Knows the library, not the user interface.

mod figures;
mod inside;
mod pane;
mod request;
mod troubles;

pub use figures::{Figures, Judged};
pub use inside::Reading;
pub(super) use inside::channel_of;
pub use pane::Pane;
pub use request::{Development, Exposure, Request};

use super::document::PaneId;
use super::timing::History;
use crate::camera::Camera;
use crate::gpu::{Frame, FrameStats, Gpu, Timings, download};
use crate::image::ColorImage;
use crate::lens::Lens;
use crate::methods::MethodError;
use crate::study::GpuSource;
use crate::view::View;
use figures::{Judge, Purpose};
use glam::{DVec2, UVec2};
use pane::Milestone;
use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};
use troubles::Troubles;

/// GPU time that a step of a progressive reference may take, ms: at 60 Hz two refreshes,
/// so that the interface stays smooth beside it.
const STEP_BUDGET_MS: f64 = 30.0;

/// Views of a step at most, however fast they are.
const MAX_STEP_VIEWS: u32 = 32;

/// Depths that the CoC statistics are taken over, at most: their 95th percentile then has
/// a standard error of 0.2 % in rank, and a lens slider costs under a millisecond.
const DEPTH_SAMPLES: usize = 16_384;

/// What all panes together may take in a frame before those not under the pointer are
/// rendered less often, ms: the refresh interval of a display of 60 Hz.
pub const DISPLAY_INTERVAL_MS: f64 = 1000.0 / 60.0;

/// Frames of the first pane for one of another, where not all can be rendered in each.
const FRAMES_PER_OTHER: u32 = 4;

/// Submitted and unfinished frames beyond which nothing is added: a slow GPU would be
/// asked for pictures that nobody wants any more.
const MAX_IN_FLIGHT: usize = 2;

/// How long pictures must rest before they are measured, which takes all cores.
const REST: Duration = Duration::from_millis(250);

/// How soon to look again whether a held reference may go on.
const HOLD: Duration = Duration::from_millis(100);

/// A submitted frame whose times have not arrived.
struct InFlight {
    parts: Vec<Part>,
    timings: Timings,
    cpu_ms: f64,
    since: Instant,
}

/// Which passes of a frame are a pane's.
struct Part {
    pane: PaneId,
    /// Lens points drawn, of a reference.
    views: u32,
    passes: Range<usize>,
}

/// The renderer behind the panes.
pub struct Engine {
    gpu: Gpu,
    source: Option<GpuSource>,
    view: Option<(View, UVec2)>,
    panes: BTreeMap<PaneId, Pane>,
    /// Panes that wait for their turn.
    waiting: Vec<PaneId>,
    frames_without_others: u32,
    in_flight: Vec<InFlight>,
    revisions: u64,
    ms_per_view: f64,
    held: bool,
    depths_m: Option<Vec<f32>>,
    colors: HashMap<PaneId, (u64, Arc<ColorImage>)>,
    judge: Judge,
    unjudged: bool,
    changed_at: Instant,
    rendered_frames: u64,
    stats: FrameStats,
    troubles: Troubles,
    /// Times of the last frames.
    pub history: History,
}

impl Engine {
    /// An engine with nothing to show yet.
    pub fn new(gpu: Gpu) -> Self {
        Self {
            troubles: Troubles::watch(gpu.device()),
            gpu,
            source: None,
            view: None,
            panes: BTreeMap::new(),
            waiting: Vec::new(),
            frames_without_others: 0,
            in_flight: Vec::new(),
            revisions: 0,
            ms_per_view: STEP_BUDGET_MS,
            held: false,
            depths_m: None,
            colors: HashMap::new(),
            judge: Judge::default(),
            unjudged: false,
            changed_at: Instant::now(),
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
        self.depths_m = None;
        self.panes.clear();
        self.colors.clear();
    }

    /// Makes every picture anew, as after a shader was replaced.
    pub fn forget_pictures(&mut self) {
        self.panes.values_mut().for_each(|pane| pane.made_for = None);
        self.view = None;
        self.depths_m = None;
    }

    /// What the engine has of a pane.
    pub fn pane(&self, id: PaneId) -> Option<&Pane> {
        self.panes.get(&id)
    }

    /// Whether a pane waits because another one is rendered first.
    pub fn is_behind(&self, id: PaneId) -> bool {
        self.waiting.contains(&id)
    }

    /// Size of the picture, px; the shape of an image is its own.
    pub fn size(&self) -> Option<UVec2> {
        self.view.as_ref().map(|(view, _)| view.size())
    }

    /// Margin drawn around the picture, px.
    pub fn overscan_px(&self) -> u32 {
        self.view.as_ref().map_or(0, |(view, _)| view.overscan_px())
    }

    /// Frames submitted to the GPU since the start: it stands still while nothing changes.
    pub fn rendered_frames(&self) -> u64 {
        self.rendered_frames
    }

    /// Counters of the last submitted frame.
    pub fn stats(&self) -> &FrameStats {
        &self.stats
    }

    /// Whether the graphics device is gone: nothing is drawn or read back any more.
    pub fn is_lost(&self) -> bool {
        self.troubles.is_lost()
    }

    /// What the driver complained about since the last call.
    pub fn take_troubles(&mut self) -> Vec<String> {
        self.troubles.take()
    }

    /// When [`Engine::update`] should be called again although nothing was changed: soon
    /// where there is work to do, later where there is only something to wait for.
    pub fn wants_update_in(&self) -> Option<Duration> {
        let busy = !self.in_flight.is_empty() || !self.waiting.is_empty();
        match busy || self.is_converging() {
            true if !busy && self.held => Some(HOLD),
            // Soon enough to keep a GPU busy with a converging reference.
            true => Some(Duration::from_millis(4)),
            false if self.judge.is_busy() || self.unjudged => Some(Duration::from_millis(60)),
            false => None,
        }
    }

    fn is_converging(&self) -> bool {
        self.panes.values().any(Pane::is_converging)
    }

    /// Brings everything up to date with `request`; true if something was rendered.
    ///
    /// # Errors
    ///
    /// A view that cannot be drawn, or a lens that forms no image; what a single method
    /// cannot do is told in its [`Pane`].
    pub fn update(&mut self, request: &Request) -> Result<bool, MethodError> {
        self.poll();
        if self.source.is_none() || self.troubles.is_lost() {
            self.waiting.clear();
            return Ok(false);
        }
        request.exposure.lens.check()?;
        self.prepare_view(&request.exposure)?;
        let needed = self.follow(request);
        let stale = |id: &PaneId| self.panes.get(id).is_some_and(|p| p.made_for.as_ref() != Some(&request.exposure));
        self.waiting = needed.iter().copied().filter(stale).collect();
        let chosen = self.choose(request);
        self.held = request.held && self.ms_per_view > STEP_BUDGET_MS;
        let idle = chosen.is_empty() && self.in_flight.is_empty() && self.waiting.is_empty();
        let converging = match idle && !self.held {
            true => needed.iter().copied().filter(|id| self.panes[id].is_converging()).collect(),
            false => Vec::new(),
        };
        self.judge(request);
        if chosen.is_empty() && converging.is_empty() && !self.wants_presenting(request) {
            return Ok(false);
        }
        if !chosen.is_empty() {
            self.waiting.retain(|id| !chosen.contains(id));
            self.changed_at = Instant::now();
        }
        self.submit(request, &chosen, &converging);
        Ok(true)
    }

    /// Renders `chosen` anew, adds lens points to `converging` and presents what changed.
    fn submit(&mut self, request: &Request, chosen: &[PaneId], converging: &[PaneId]) {
        let start = Instant::now();
        let gpu = self.gpu.clone();
        let mut frame = gpu.frame();
        // The panes show them, and how much a step of a reference may do follows from them.
        frame.time_passes();
        let mut parts = Vec::new();
        if let (false, Some((view, _))) = (chosen.is_empty(), &mut self.view) {
            // The pinhole image before all others: no method's time has it.
            frame.set_prefix("view/");
            view.pinhole(&mut frame);
            view.z_bounds(&mut frame);
        }
        for id in chosen {
            parts.extend(self.render(&mut frame, *id, request, 1));
        }
        let views = (STEP_BUDGET_MS / self.ms_per_view).clamp(1.0, f64::from(MAX_STEP_VIEWS)) as u32;
        for id in converging {
            parts.extend(self.render(&mut frame, *id, request, views));
        }
        self.present(&mut frame, request);
        let submitted = frame.finish();
        self.rendered_frames += 1;
        self.stats = submitted.stats;
        let cpu_ms = start.elapsed().as_secs_f64() * 1e3;
        self.in_flight.push(InFlight { parts, timings: submitted.timings, cpu_ms, since: start });
    }

    fn prepare_view(&mut self, exposure: &Exposure) -> Result<(), MethodError> {
        let Some(source) = &self.source else { return Ok(()) };
        let is_scene = source.source().is_scene();
        match &mut self.view {
            Some((view, _)) if is_scene => {
                let before = (view.camera().copied(), *view.projection());
                view.set_size(&self.gpu, exposure.size, exposure.overscan_px)?;
                if let Some(camera) = exposure.camera {
                    view.set_camera(camera);
                }
                if before != (view.camera().copied(), *view.projection()) {
                    self.depths_m = None;
                }
            }
            Some((_, size)) if *size == exposure.size => {}
            _ => {
                let mut view = source.view(0, exposure.size, exposure.overscan_px, None)?;
                if let Some(camera) = exposure.camera {
                    view.set_camera(camera);
                }
                self.view = Some((view, exposure.size));
                self.depths_m = None;
            }
        }
        Ok(())
    }

    /// Makes the engine's panes those of the request; returns the needed ones.
    fn follow(&mut self, request: &Request) -> Vec<PaneId> {
        let needed = request.needed();
        // A pane that is not on the screen keeps its picture for when it comes back.
        self.panes.retain(|id, _| request.pane(*id).is_some());
        self.colors.retain(|id, _| request.pane(*id).is_some());
        for state in &request.panes {
            self.panes.entry(state.id).or_insert_with(|| Pane::new(state)).follow(state, request.explain);
        }
        for (id, pane) in &mut self.panes {
            // What is not needed does not go on converging.
            if !needed.contains(id) && pane.is_converging() {
                (pane.made_for, pane.run) = (None, None);
            }
        }
        needed
    }

    /// Which of the waiting panes to render now: all where they fit into a refresh of the
    /// display, else the first one, and one of the others every few frames.
    fn choose(&mut self, request: &Request) -> Vec<PaneId> {
        if self.waiting.is_empty() || self.in_flight.len() >= MAX_IN_FLIGHT {
            return Vec::new();
        }
        let ms: f64 = self.waiting.iter().filter_map(|id| self.panes[id].ms).sum();
        if ms <= DISPLAY_INTERVAL_MS || self.waiting.len() == 1 {
            self.frames_without_others = 0;
            return self.waiting.clone();
        }
        let first = self.waiting.contains(&request.first).then_some(request.first);
        let others = self.waiting.iter().copied().filter(|id| Some(*id) != first);
        let oldest = others.min_by_key(|id| self.panes[id].made_at);
        self.frames_without_others += 1;
        let other = oldest.filter(|_| first.is_none() || self.frames_without_others >= FRAMES_PER_OTHER);
        if other.is_some() {
            self.frames_without_others = 0;
        }
        first.into_iter().chain(other).collect()
    }

    /// Records a pane's picture, or `views` more lens points of it.
    fn render(&mut self, frame: &mut Frame<'_>, id: PaneId, request: &Request, views: u32) -> Option<Part> {
        let (view, pane) = (&mut self.view.as_mut()?.0, self.panes.get_mut(&id)?);
        if pane.made_for.as_ref() != Some(&request.exposure) {
            pane.restart(&request.exposure);
        }
        self.revisions += 1;
        let counted = pane.progress().map_or(0, |(count, _)| count);
        let first = frame.stats.passes as usize;
        if pane.wants_intermediates() {
            frame.keep_intermediates();
        }
        if let Err(error) = pane.record(frame, view, &request.exposure.lens, views, self.revisions) {
            pane.error = Some(error);
            pane.linear = None;
        }
        pane.keep(frame.take_intermediates());
        let views = pane.progress().map_or(0, |(count, _)| count.saturating_sub(counted));
        Some(Part { pane: id, views, passes: first..frame.stats.passes as usize })
    }

    fn wants_presenting(&self, request: &Request) -> bool {
        request.visible.iter().any(|id| {
            let pane = self.panes.get(id);
            pane.is_some_and(|pane| pane.wants_presenting(request, self.compared_with(request, *id).as_ref()))
        })
    }

    /// The picture that the difference which a pane shows is taken from.
    fn compared_with(&self, request: &Request, id: PaneId) -> Option<Milestone> {
        self.panes.get(&request.pane(id)?.show.against()?)?.to_compare()
    }

    /// Turns new pictures into what is seen.
    fn present(&mut self, frame: &mut Frame<'_>, request: &Request) {
        for id in &request.visible {
            let other = self.compared_with(request, *id);
            if let (Some((view, _)), Some(pane)) = (&mut self.view, self.panes.get_mut(id)) {
                pane.present(frame, view, request, other.as_ref());
            }
        }
    }

    /// Measures what has come to rest.
    fn judge(&mut self, request: &Request) {
        let panes = &mut self.panes;
        self.judge.poll(&self.gpu, |id| panes.get_mut(&id).map(|p| &mut p.judged));
        self.unjudged = false;
        let display = request.development.display;
        let truth = request.reference.and_then(|id| Some((id, panes.get(&id)?.milestone.clone()?)));
        let rested = self.waiting.is_empty() && self.changed_at.elapsed() >= REST;
        for id in &request.visible {
            let Some(pane) = panes.get(id) else { continue };
            let truth = truth.as_ref().filter(|(truth, _)| truth != id).map(|(_, milestone)| milestone);
            let against = pane.wants_flip_against().and_then(|other| panes.get(&other)?.milestone.as_ref());
            for (other, purpose) in [(against, Purpose::FlipMap), (truth, Purpose::Figures)] {
                let (Some(other), Some(own)) = (other, &pane.milestone) else { continue };
                self.unjudged |= match rested {
                    true => self.judge.judge(&self.gpu, *id, &pane.judged, (own, other), display, purpose),
                    false => true,
                };
            }
        }
        // Without a truth there is nothing that old figures could be about.
        for id in request.visible.iter().filter(|_| request.reference.is_none()) {
            if let Some(pane) = panes.get_mut(id).filter(|p| p.wants_flip_against().is_none()) {
                pane.judged.forget();
            }
        }
    }

    /// Takes in the times that have arrived.
    fn poll(&mut self) {
        // A lost device never answers; after this long nobody waits for the times any more.
        const GIVE_UP_S: f32 = 10.0;
        let software = self.gpu.is_software();
        let (history, panes, ms_per_view) = (&mut self.history, &mut self.panes, &mut self.ms_per_view);
        self.in_flight.retain(|flight| {
            let Some(passes) = flight.timings.poll() else {
                return flight.since.elapsed().as_secs_f32() < GIVE_UP_S;
            };
            for part in &flight.parts {
                // Without timestamps there is the whole frame's time: that of a pane which
                // was the only one in it.
                let own = match software {
                    true if flight.parts.len() == 1 => &passes[..],
                    true => &[],
                    false => passes.get(part.passes.start..part.passes.end.min(passes.len())).unwrap_or_default(),
                };
                let gpu_ms: f64 = own.iter().map(|p| p.ms).sum();
                let views = f64::from(part.views.max(1));
                if part.views > 0 {
                    *ms_per_view = (gpu_ms.max(flight.cpu_ms) / views).max(1e-3);
                }
                if let Some(pane) = panes.get_mut(&part.pane).filter(|_| !own.is_empty()) {
                    pane.ms = Some(gpu_ms / views);
                }
            }
            history.push(flight.cpu_ms, &passes);
            false
        });
    }

    /// Depth, metres, at a point of the picture given from (0, 0) top left to (1, 1).
    /// Reads the depth back if that was not done since the view was last drawn.
    pub fn depth_at_m(&mut self, at: DVec2) -> Option<f64> {
        if self.troubles.is_lost() {
            return None;
        }
        let (view, _) = self.view.as_mut()?;
        let depth = view.depth_m(&self.gpu);
        let texel = (at.clamp(DVec2::ZERO, DVec2::ONE) * depth.size.as_dvec2()).as_uvec2();
        let texel = texel.min(depth.size - 1);
        Some(f64::from(depth.at(texel.x, texel.y)))
    }

    /// A regular sample of the depths in view, metres, read back at most once a redraw;
    /// `None` before there is a view, and where nothing is known yet and `read` is false.
    pub fn depths_m(&mut self, read: bool) -> Option<&[f32]> {
        if self.depths_m.is_none() && read && !self.troubles.is_lost() {
            let depth = self.view.as_mut()?.0.depth_m(&self.gpu);
            let stride = depth.pixels.len().div_ceil(DEPTH_SAMPLES).max(1);
            self.depths_m = Some(depth.pixels.iter().step_by(stride).copied().collect());
        }
        self.depths_m.as_deref()
    }

    /// The view that is shown, for whoever needs more of it than the depths; `None` once the
    /// device is lost.
    pub fn view(&mut self) -> Option<&mut View> {
        self.view.as_mut().filter(|_| !self.troubles.is_lost()).map(|(view, _)| view)
    }

    /// A pane's picture, linear, on the CPU: read back at most once for each picture, which
    /// waits for the GPU.
    pub fn color(&mut self, id: PaneId) -> Option<Arc<ColorImage>> {
        let pane = self.panes.get(&id)?;
        let linear = pane.linear.as_ref().filter(|_| !self.troubles.is_lost())?;
        match self.colors.get(&id) {
            Some((revision, color)) if *revision == pane.revision => Some(color.clone()),
            _ => {
                let color = Arc::new(download(&self.gpu, linear));
                self.colors.insert(id, (pane.revision, color.clone()));
                Some(color)
            }
        }
    }

    /// A lens that suits the source seen by `camera` in a frame of `size`, on a display that
    /// shows it under the angle under which it was taken.
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
        let lens = source.source().default_lens(&view.depth_m(&self.gpu));
        let fitted = lens.with_display_fov_x(view.size().x, view.projection().fov_x());
        // The CoC in pixels is proportional to both.
        let as_wide = lens.density_px_per_mm / fitted.density_px_per_mm;
        Ok(Lens { aperture_diameter_mm: lens.aperture_diameter_mm * as_wide, ..fitted })
    }
}
