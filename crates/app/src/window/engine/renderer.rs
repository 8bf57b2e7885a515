//! The engine itself: what it holds, and what it tells of it.

use super::activity::Activity;
use super::device_errors::DeviceErrors;
use super::errand::PassTimes;
use super::figures::{MetricsWorker, PaneMetrics};
use super::flight::InFlight;
use super::history::History;
use super::identity::{Identity, Pairing};
use super::kernel::Kernel;
use super::lane::Lane;
use super::pane::Pane;
use super::request::{DisplaySettings, Request};
use super::tempo::{STEP_BUDGET_MS, Tempo};
use super::views::Views;
use super::wake::Wake;
use crate::window::model::PaneId;
use defocus::gpu::{FrameStats, Gpu, ShaderError};
use defocus::image::ColorImage;
use defocus_study::GpuSource;
use glam::UVec2;
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How soon to look whether something has arrived that wakes the interface by itself.
const WAKEN: Duration = Duration::from_millis(100);

/// How soon to look again whether a held reference may go on.
const HOLD: Duration = Duration::from_millis(100);

/// The renderer behind the panes.
pub struct Engine {
    pub(super) gpu: Gpu,
    pub(super) source: Option<GpuSource>,
    pub(super) views: Views,
    pub(super) panes: BTreeMap<PaneId, Pane>,
    /// Panes that wait for their turn.
    pub(super) waiting: Vec<PaneId>,
    pub(super) frames_without_others: u32,
    pub(super) in_flight: Vec<InFlight>,
    pub(super) revisions: u64,
    /// Which scene or image and which shaders there are: another number for others.
    pub(super) world: u64,
    /// What was asked for last.
    pub(super) asked: Option<Request>,
    pub(super) wake: Wake,
    pub(super) tempo: Tempo,
    pub(super) activity: Activity,
    /// Mean blur of the picture that is asked for, px.
    pub(super) blur_px: f64,
    pub(super) lane: Option<Lane>,
    pub(super) pass_times: Option<PassTimes>,
    pub(super) kernel: Option<Kernel>,
    pub(super) tickets: u64,
    /// Shaders that were replaced, by name.
    pub(super) shaders: BTreeMap<String, String>,
    pub(super) ms_per_view: f64,
    pub(super) held: bool,
    pub(super) depths_m: Option<Vec<f32>>,
    pub(super) colors: HashMap<PaneId, (u64, Arc<ColorImage>)>,
    pub(super) metrics_worker: MetricsWorker,
    pub(super) unmeasured: bool,
    pub(super) changed_at: Instant,
    pub(super) rendered_frames: u64,
    pub(super) stats: FrameStats,
    pub(super) device_errors: DeviceErrors,
    /// Times of the last frames.
    pub history: History,
}

impl Engine {
    /// An engine with nothing to show yet.
    pub fn new(gpu: Gpu) -> Self {
        Self {
            device_errors: DeviceErrors::watch(gpu.device()),
            gpu,
            source: None,
            views: Views::default(),
            panes: BTreeMap::new(),
            waiting: Vec::new(),
            frames_without_others: 0,
            in_flight: Vec::new(),
            revisions: 0,
            world: 0,
            asked: None,
            wake: Wake::default(),
            tempo: Tempo::default(),
            activity: Activity::default(),
            blur_px: 0.0,
            lane: None,
            pass_times: None,
            kernel: None,
            tickets: 0,
            shaders: BTreeMap::new(),
            ms_per_view: STEP_BUDGET_MS,
            held: false,
            depths_m: None,
            colors: HashMap::new(),
            metrics_worker: MetricsWorker::default(),
            unmeasured: false,
            changed_at: Instant::now(),
            rendered_frames: 0,
            stats: FrameStats::default(),
            history: History::default(),
        }
    }

    /// Shares time with the interface in another way.
    pub fn set_tempo(&mut self, tempo: Tempo) {
        self.tempo = tempo;
    }

    /// How time is shared with the interface.
    pub fn tempo(&self) -> Tempo {
        self.tempo
    }

    /// The GPU that everything runs on, but for what takes long.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// An engine with nothing to show yet but the same source, which works as this one does.
    pub fn sibling(&self) -> Self {
        let mut sibling = Self::new(self.gpu.clone());
        (sibling.source, sibling.wake, sibling.tempo) = (self.source.clone(), self.wake.clone(), self.tempo);
        sibling.shaders.clone_from(&self.shaders);
        sibling
    }

    /// Has `wake` told, from whichever thread, when something arrives that
    /// [`Engine::update`] takes in.
    pub fn set_wake(&mut self, wake: Wake) {
        self.wake = wake;
    }

    /// What is shown, if anything.
    pub fn source(&self) -> Option<&GpuSource> {
        self.source.as_ref()
    }

    /// Which scene or image and which shaders there are: another number for others.
    pub fn world(&self) -> u64 {
        self.world
    }

    /// Shows something else from the next [`Engine::update`] on.
    pub fn set_source(&mut self, source: GpuSource) {
        self.source = Some(source);
        self.world += 1;
        self.asked = None;
        self.views = Views::default();
        self.depths_m = None;
        self.panes.clear();
        self.colors.clear();
    }

    /// Shows the same source at another moment; what is shown stays until the new pictures are there.
    pub fn pose_source(&mut self, source: GpuSource) {
        self.source = Some(source);
        self.forget_pictures();
    }

    /// Makes every picture anew, as after a shader was replaced.
    pub fn forget_pictures(&mut self) {
        self.panes.values_mut().for_each(|pane| pane.made_for = None);
        self.world += 1;
        self.views = Views::default();
        self.depths_m = None;
    }

    /// Uses another source for a shader from now on, and makes every picture anew.
    ///
    /// # Errors
    ///
    /// An invalid source; the last good one stays.
    pub fn replace_shader(&mut self, name: &str, source: &str) -> Result<(), ShaderError> {
        self.gpu.replace_shader(name, source)?;
        self.take_shader(name, source);
        Ok(())
    }

    /// As [`Engine::replace_shader`], where the GPU of this engine has the source already.
    pub fn take_shader(&mut self, name: &str, source: &str) {
        self.shaders.insert(name.into(), source.into());
        if let Some(lane) = &self.lane {
            lane.replace_shader(name, source);
        }
        self.forget_pictures();
    }

    /// What the engine has of a pane.
    pub fn pane(&self, id: PaneId) -> Option<&Pane> {
        self.panes.get(&id)
    }

    /// How far a pane's picture is from the truth, as far as that is known.
    pub fn pane_metrics(&self, id: PaneId) -> PaneMetrics<'_> {
        let (Some(pane), Some(asked)) = (self.panes.get(&id), &self.asked) else { return PaneMetrics::Unasked };
        // An image with depth has no truth, whatever is asked for.
        let is_there = |truth: &PaneId| *truth != id && self.panes.get(truth).is_none_or(|pane| pane.error.is_none());
        let Some(truth) = asked.reference.filter(is_there) else { return PaneMetrics::Unasked };
        let (Some(last), Some(now)) = (pane.results.last(), self.pair(asked, id, truth)) else {
            return PaneMetrics::Pending;
        };
        if pane.error.is_some() {
            return PaneMetrics::Pending;
        }
        let departures = last.of.departures(&now);
        match departures.is_empty() {
            true if pane.identity.as_ref() == Some(&now.picture) => PaneMetrics::Current(last),
            // What is asked for was measured before, and is not shown yet.
            true => PaneMetrics::Pending,
            false => PaneMetrics::Outdated(last, departures),
        }
    }

    /// The pictures that a pane's figures are to be about.
    pub(super) fn pair(&self, asked: &Request, id: PaneId, truth: PaneId) -> Option<Pairing> {
        let identity = |id: PaneId, samples| {
            let method = asked.pane(id)?.method.clone();
            Some(Identity { world: self.world, method, render: asked.render.clone(), samples })
        };
        let samples = |id: PaneId| self.panes.get(&id)?.identity.as_ref()?.samples;
        let (picture, truth) = (identity(id, samples(id))?, identity(truth, samples(truth))?);
        let DisplaySettings { display, viewing, .. } = asked.display_settings;
        Some(Pairing { picture, truth, display, viewing })
    }

    /// Which pane shows the truth, or converges to it unseen.
    pub fn reference(&self) -> Option<PaneId> {
        self.asked.as_ref()?.reference
    }

    /// Whether a pane waits because another one is rendered first.
    pub fn is_behind(&self, id: PaneId) -> bool {
        self.waiting.contains(&id)
    }

    /// Size of the picture, px; the shape of an image is its own.
    pub fn size(&self) -> Option<UVec2> {
        let asked = self.asked.as_ref()?;
        Some(self.source.as_ref()?.source().fitted_size(asked.render.size))
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
        self.device_errors.is_lost()
    }

    /// What the driver complained about since the last call.
    pub fn take_device_errors(&mut self) -> Vec<String> {
        self.device_errors.take()
    }

    /// When [`Engine::update`] should be called again although nothing was changed: soon
    /// where there is work to do, later where there is only something to wait for.
    pub fn wants_update_in(&self) -> Option<Duration> {
        let busy = !self.in_flight.is_empty() || !self.waiting.is_empty();
        match busy || self.is_converging() {
            true if !busy && self.held => Some(HOLD),
            // Soon enough to keep a GPU busy with a converging reference.
            true => Some(Duration::from_millis(4)),
            // What these have wakes the interface; this is for where that fails.
            false if self.metrics_worker.is_busy() || self.is_drawing_beside() => Some(WAKEN),
            false if self.unmeasured => Some(self.tempo.rest.min(WAKEN)),
            false => None,
        }
    }

    fn is_drawing_beside(&self) -> bool {
        let is_timing = self.pass_times.as_ref().is_some_and(|timed| timed.times.is_none());
        let is_measuring = self.kernel.as_ref().is_some_and(|kernel| kernel.psf.is_none());
        is_timing || is_measuring || self.panes.values().any(Pane::is_drawn_beside)
    }

    pub(super) fn is_converging(&self) -> bool {
        self.panes.values().any(Pane::is_converging)
    }

    /// What the engine is doing, to be asked from any thread.
    pub fn activity(&self) -> Activity {
        self.activity.clone()
    }

    /// Shaders that were replaced, by name.
    pub fn shaders(&self) -> &BTreeMap<String, String> {
        &self.shaders
    }
}
