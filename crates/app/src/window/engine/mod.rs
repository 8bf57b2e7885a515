//! What the window shows, kept up to date: renders when something it depends on changed
//! and does nothing when nothing did. Knows the library, not the user interface.

mod activity;
mod beside;
mod figures;
mod flights;
mod identity;
mod inside;
mod lane;
mod milestone;
mod pace;
mod pane;
mod progress;
mod request;
mod troubles;
mod values;
mod views;
mod wake;

pub use activity::Activity;
pub use beside::PassTimes;
pub use figures::{Figures, Measured, Verdict};
pub use identity::{Identity, Pairing};
pub use inside::Reading;
pub(super) use inside::channel_of;
pub use pane::Pane;
pub use request::{Development, Exposure, Request};
pub use wake::Wake;

use super::document::{PaneId, Show};
use super::timing::History;
use defocus::gpu::{Frame, FrameStats, Gpu, ShaderError};
use defocus::image::ColorImage;
use defocus::methods::MethodError;
use defocus_study::GpuSource;
use figures::{Judge, Purpose};
use flights::{InFlight, Part};
use glam::UVec2;
use lane::Lane;
use milestone::Milestone;
use pace::Limits;
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use std::time::{Duration, Instant};
use troubles::Troubles;
use views::{Views, Which};

/// GPU time that a step of a progressive reference may take, ms: at 60 Hz two refreshes,
/// so that the interface stays smooth beside it.
const STEP_BUDGET_MS: f64 = 30.0;

/// Views of a step at most, however fast they are.
const MAX_STEP_VIEWS: u32 = 32;

/// What all panes together may take in a frame before those not under the pointer are
/// rendered less often, ms: the refresh interval of a display of 60 Hz.
pub const DISPLAY_INTERVAL_MS: f64 = 1000.0 / 60.0;

/// Frames of the first pane for one of another, where not all can be rendered in each.
const FRAMES_PER_OTHER: u32 = 4;

/// Submitted and unfinished frames beyond which nothing is added: a slow GPU would be
/// asked for pictures that nobody wants any more.
const MAX_IN_FLIGHT: usize = 2;

/// The same where a program draws the frames, and the interface's own after them.
const MAX_IN_FLIGHT_SOFTWARE: usize = 1;

/// How soon to look whether something has arrived that wakes the interface by itself.
const WAKEN: Duration = Duration::from_millis(100);

/// How long pictures must rest before they are measured, which takes all cores.
const REST: Duration = Duration::from_millis(250);

/// How soon to look again whether a held reference may go on.
const HOLD: Duration = Duration::from_millis(100);

/// How the engine shares time with the interface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tempo {
    /// What a frame may take for pictures, ms: what takes longer is drawn smaller at first,
    /// and in full beside the interface.
    pub budget_ms: f64,
    /// How long pictures must rest before they are measured, which takes all cores.
    pub rest: Duration,
}

impl Default for Tempo {
    fn default() -> Self {
        Self { budget_ms: pace::BUDGET_MS, rest: REST }
    }
}

/// What is to be drawn for a pane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Plan {
    /// Its picture, so many times smaller than in full, in the next frame.
    Here(u32),
    /// Its full picture, beside the interface.
    Beside,
}

/// The renderer behind the panes.
pub struct Engine {
    gpu: Gpu,
    source: Option<GpuSource>,
    views: Views,
    panes: BTreeMap<PaneId, Pane>,
    /// Panes that wait for their turn.
    waiting: Vec<PaneId>,
    frames_without_others: u32,
    in_flight: Vec<InFlight>,
    revisions: u64,
    /// Which scene or image and which shaders there are: another number for others.
    world: u64,
    /// What was asked for last.
    asked: Option<Request>,
    wake: Wake,
    tempo: Tempo,
    activity: Activity,
    /// Mean blur of the picture that is asked for, px.
    blur_px: f64,
    lane: Option<Lane>,
    pass_times: Option<PassTimes>,
    tickets: u64,
    /// Shaders that were replaced, by name.
    shaders: BTreeMap<String, String>,
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
            tickets: 0,
            shaders: BTreeMap::new(),
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
    pub fn verdict(&self, id: PaneId) -> Verdict<'_> {
        let (Some(pane), Some(asked)) = (self.panes.get(&id), &self.asked) else { return Verdict::Unasked };
        // An image with depth has no truth, whatever is asked for.
        let is_there = |truth: &PaneId| *truth != id && self.panes.get(truth).is_none_or(|pane| pane.error.is_none());
        let Some(truth) = asked.reference.filter(is_there) else { return Verdict::Unasked };
        let (Some(last), Some(now)) = (pane.judged.last(), self.pair(asked, id, truth)) else {
            return Verdict::Pending;
        };
        if pane.error.is_some() {
            return Verdict::Pending;
        }
        let departures = last.of.departures(&now);
        match departures.is_empty() {
            true if pane.identity.as_ref() == Some(&now.picture) => Verdict::Current(last),
            // What is asked for was measured before, and is not shown yet.
            true => Verdict::Pending,
            false => Verdict::Outdated(last, departures),
        }
    }

    /// The pictures that a pane's figures are to be about.
    fn pair(&self, asked: &Request, id: PaneId, truth: PaneId) -> Option<Pairing> {
        let identity = |id: PaneId, samples| {
            let method = asked.pane(id)?.method.clone();
            Some(Identity { world: self.world, method, exposure: asked.exposure.clone(), samples })
        };
        let samples = |id: PaneId| self.panes.get(&id)?.identity.as_ref()?.samples;
        let (picture, truth) = (identity(id, samples(id))?, identity(truth, samples(truth))?);
        let Development { display, viewing, .. } = asked.development;
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
        Some(self.source.as_ref()?.source().fitted_size(asked.exposure.size))
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
            // What these have wakes the interface; this is for where that fails.
            false if self.judge.is_busy() || self.is_drawing_beside() => Some(WAKEN),
            false if self.unjudged => Some(self.tempo.rest.min(WAKEN)),
            false => None,
        }
    }

    fn is_drawing_beside(&self) -> bool {
        let is_timing = self.pass_times.as_ref().is_some_and(|timed| timed.times.is_none());
        is_timing || self.panes.values().any(Pane::is_drawn_beside)
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
        let news = self.bring_up_to_date(request);
        self.activity.set_busy(self.wants_update_in().is_some());
        news
    }

    /// What the engine is doing, to be asked from any thread.
    pub fn activity(&self) -> Activity {
        self.activity.clone()
    }

    /// Shaders that were replaced, by name.
    pub fn shaders(&self) -> &BTreeMap<String, String> {
        &self.shaders
    }

    fn bring_up_to_date(&mut self, request: &Request) -> Result<bool, MethodError> {
        self.poll();
        let answered = self.take_answers() | self.take_from_beside();
        self.asked = Some(request.clone());
        if self.source.is_none() || self.troubles.is_lost() {
            self.waiting.clear();
            return Ok(answered);
        }
        request.exposure.lens.check()?;
        let needed = self.follow(request);
        self.call_back(request, &needed);
        self.blur_px = self.mean_blur_px(&request.exposure.lens);
        let plans: Vec<(PaneId, Plan)> = needed.iter().filter_map(|id| Some((*id, self.plan(*id, request)?))).collect();
        let divisor = self.prepare_views(request, &plans)?;
        let mut drawn_here = Vec::new();
        for (id, plan) in plans {
            match plan {
                Plan::Here(_) => drawn_here.push(id),
                Plan::Beside => self.send_out(id, request),
            }
        }
        self.waiting = drawn_here;
        let chosen = self.choose(request);
        self.held = request.held && self.ms_per_view > STEP_BUDGET_MS;
        let idle = chosen.is_empty() && self.in_flight.is_empty() && self.waiting.is_empty();
        let converging = match idle && !self.held {
            true => needed.iter().copied().filter(|id| self.panes[id].is_converging()).collect(),
            false => Vec::new(),
        };
        self.judge(request);
        if chosen.is_empty() && converging.is_empty() && !self.wants_presenting(request) {
            return Ok(answered);
        }
        if !chosen.is_empty() {
            self.waiting.retain(|id| !chosen.contains(id));
            self.changed_at = Instant::now();
        }
        self.submit(request, (&chosen, divisor), &converging);
        Ok(true)
    }

    fn limits(&self) -> Limits {
        Limits { budget_ms: self.tempo.budget_ms, is_software: self.gpu.is_software() }
    }

    /// What is to be drawn for a pane; nothing where it has what is asked for.
    fn plan(&mut self, id: PaneId, request: &Request) -> Option<Plan> {
        let (limits, blur_px) = (self.limits(), self.blur_px);
        let pane = self.panes.get_mut(&id)?;
        if pane.made_for.as_ref() == Some(&request.exposure) {
            return None;
        }
        if !pane.pace.is_slow(blur_px, limits) {
            return Some(Plan::Here(1));
        }
        let is_there = pane.made_for.is_some() && pane.made_for == Some(request.exposure.coarser(pane.divisor));
        match is_there {
            false => Some(Plan::Here(pane.pace.divisor(blur_px, limits))),
            // Its textures are not brought from beside: they stay those of the smaller picture.
            true if request.is_moving || pane.wants_everything() => None,
            true => Some(Plan::Beside),
        }
    }

    /// Brings the views where pictures are taken from; how many times smaller than in full
    /// those are drawn that are not.
    fn prepare_views(&mut self, request: &Request, plans: &[(PaneId, Plan)]) -> Result<u32, MethodError> {
        let Some(source) = &self.source else { return Ok(1) };
        let divisors = plans.iter().filter_map(|(_, plan)| match plan {
            Plan::Here(divisor) => Some(*divisor),
            Plan::Beside => None,
        });
        let coarsest = divisors.clone().max().unwrap_or(1);
        let mut is_elsewhere = false;
        if !request.is_moving || divisors.clone().any(|divisor| divisor == 1) {
            is_elsewhere |= self.views.prepare(source, &request.exposure, Which::Full)?;
        }
        if coarsest > 1 {
            is_elsewhere |= self.views.prepare(source, &request.exposure.coarser(coarsest), Which::Coarse)?;
        }
        if !request.is_moving && coarsest == 1 && self.panes.values().all(|pane| pane.divisor == 1) {
            self.views.forget_coarse();
        }
        if is_elsewhere {
            self.depths_m = None;
        }
        Ok(coarsest)
    }

    /// Mean |c| over the picture, px, where depths are known; else that of what is infinitely
    /// far away, which grows with the lens as that does.
    fn mean_blur_px(&self, lens: &defocus::lens::Lens) -> f64 {
        let known = self.depths_m.as_ref().and_then(|depths| lens.coc_statistics(depths.iter().copied()));
        known.map_or(lens.k_px().abs(), |statistics| statistics.mean_px)
    }

    /// Renders `chosen` anew, the slow ones `divisor` times smaller, adds lens points to
    /// `converging` and presents what changed.
    fn submit(&mut self, request: &Request, (chosen, divisor): (&[PaneId], u32), converging: &[PaneId]) {
        let start = Instant::now();
        let gpu = self.gpu.clone();
        let mut frame = gpu.frame();
        // The panes show them, and how much a step of a reference may do follows from them.
        frame.time_passes();
        let (limits, blur_px) = (self.limits(), self.blur_px);
        let divisor_of = |pane: &mut Pane| if pane.pace.is_slow(blur_px, limits) { divisor } else { 1 };
        let mut tasks: Vec<(PaneId, u32, u32)> = Vec::new();
        for id in chosen {
            let Some(pane) = self.panes.get_mut(id) else { continue };
            tasks.push((*id, divisor_of(pane), 1));
        }
        let mut divisors: Vec<u32> = tasks.iter().map(|(_, divisor, _)| *divisor).collect();
        divisors.dedup();
        for divisor in divisors {
            // The pinhole image before all others: no method's time has it.
            if let Some(view) = self.views.of(&request.exposure.coarser(divisor)) {
                frame.set_prefix("view/");
                view.pinhole(&mut frame);
                view.z_bounds(&mut frame);
            }
        }
        let views = (STEP_BUDGET_MS / self.ms_per_view).clamp(1.0, f64::from(MAX_STEP_VIEWS)) as u32;
        tasks.extend(converging.iter().filter_map(|id| Some((*id, self.panes.get(id)?.divisor, views))));
        let mut parts = Vec::new();
        for (id, divisor, views) in tasks {
            parts.extend(self.render(&mut frame, id, request, divisor, views));
        }
        self.present(&mut frame, request);
        let submitted = frame.finish();
        self.rendered_frames += 1;
        self.activity.count();
        self.stats = submitted.stats;
        let cpu_ms = start.elapsed().as_secs_f64() * 1e3;
        self.in_flight.push(InFlight { parts, timings: submitted.timings, cpu_ms, since: start, blur_px });
    }

    /// Makes the engine's panes those of the request; returns the needed ones.
    fn follow(&mut self, request: &Request) -> Vec<PaneId> {
        let needed = request.needed();
        // A pane that is not on the screen keeps its picture for when it comes back.
        self.panes.retain(|id, _| request.pane(*id).is_some());
        self.colors.retain(|id, _| request.pane(*id).is_some());
        for state in &request.panes {
            self.panes.entry(state.id).or_insert_with(|| Pane::new(state)).follow(
                state,
                request.explain,
                request.exposure.size,
            );
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
        let software = self.gpu.is_software();
        let most = if software { MAX_IN_FLIGHT_SOFTWARE } else { MAX_IN_FLIGHT };
        if self.waiting.is_empty() || self.in_flight.len() >= most {
            return Vec::new();
        }
        // A software adapter tells the time of a whole frame only.
        let is_new = |id: &&PaneId| software && self.panes[id].pace.is_unknown();
        if let Some(new) = self.waiting.iter().find(is_new) {
            return vec![*new];
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

    /// Records a pane's picture, `divisor` times smaller than in full, or `views` more lens
    /// points of it.
    fn render(
        &mut self,
        frame: &mut Frame<'_>,
        id: PaneId,
        request: &Request,
        divisor: u32,
        views: u32,
    ) -> Option<Part> {
        let exposure = request.exposure.coarser(divisor);
        let (view, pane) = (self.views.of(&exposure)?, self.panes.get_mut(&id)?);
        if pane.made_for.as_ref() != Some(&exposure) {
            pane.restart(&exposure, divisor);
        }
        self.revisions += 1;
        let stamp = (self.revisions, self.world);
        let counted = pane.progress().map_or(0, |(count, _)| count);
        let first = frame.stats.passes as usize;
        if pane.wants_intermediates() {
            frame.keep_intermediates();
        }
        if let Err(error) = pane.record(frame, view, &exposure, views, stamp) {
            pane.fail(error, &exposure);
        }
        pane.keep_of(frame.take_intermediates(), view.size(), view.overscan_px());
        let views = pane.progress().map_or(0, |(count, _)| count.saturating_sub(counted));
        Some(Part { pane: id, divisor, views, passes: first..frame.stats.passes as usize })
    }

    fn wants_presenting(&mut self, request: &Request) -> bool {
        request.visible.iter().any(|id| {
            let other = self.compared_with(request, *id);
            let Some(pane) = self.panes.get(id) else { return false };
            let has_view = pane.made_for.as_ref().is_some_and(|made_for| self.views.of(made_for).is_some());
            pane.wants_presenting(request, other.as_ref(), has_view)
        })
    }

    /// The picture that the difference which a pane shows is taken from.
    fn compared_with(&self, request: &Request, id: PaneId) -> Option<Milestone> {
        let Show::Difference(difference) = &request.pane(id)?.show else { return None };
        self.panes.get(&difference.against)?.to_compare(difference.kind)
    }

    /// Turns new pictures into what is seen.
    fn present(&mut self, frame: &mut Frame<'_>, request: &Request) {
        for id in &request.visible {
            let other = self.compared_with(request, *id);
            if let Some(pane) = self.panes.get_mut(id) {
                let view = pane.made_for.as_ref().and_then(|made_for| self.views.of(made_for));
                pane.present(frame, view, request, other.as_ref());
            }
        }
    }

    /// Takes in what was measured; true if something was.
    fn take_answers(&mut self) -> bool {
        let panes = &mut self.panes;
        self.judge.poll(&self.gpu, |id| panes.get_mut(&id).map(|p| &mut p.judged))
    }

    /// Measures what has come to rest.
    fn judge(&mut self, request: &Request) {
        let panes = &mut self.panes;
        self.unjudged = false;
        let Development { display, viewing, .. } = request.development;
        let truth = request.reference.and_then(|id| Some((id, panes.get(&id)?.milestone.clone()?)));
        let rested = self.waiting.is_empty() && self.changed_at.elapsed() >= self.tempo.rest;
        for id in &request.visible {
            let Some(pane) = panes.get(id).filter(|pane| pane.made_for.as_ref() == Some(&request.exposure)) else {
                continue;
            };
            let truth = truth.as_ref().filter(|(truth, _)| truth != id).map(|(_, milestone)| milestone);
            let (against, kind) = pane.wants_map_against().unzip();
            let against = against.and_then(|other| panes.get(&other)?.milestone.as_ref());
            let map = kind.map(|kind| (against, Purpose::Map(kind)));
            for (other, purpose) in map.into_iter().chain([(truth, Purpose::Figures)]) {
                let (Some(other), Some(own)) = (other, &pane.milestone) else { continue };
                if other.identity.exposure != own.identity.exposure {
                    continue;
                }
                self.unjudged |= match rested {
                    true => {
                        let pane = (*id, &pane.judged);
                        self.judge.judge(&self.gpu, &self.wake, pane, (own, other), (display, viewing), purpose)
                    }
                    false => true,
                };
            }
        }
        // Without a truth there is nothing that old figures could be about.
        for id in request.visible.iter().filter(|_| request.reference.is_none()) {
            if let Some(pane) = panes.get_mut(id).filter(|p| p.wants_map_against().is_none()) {
                pane.judged.forget();
            }
        }
    }
}
