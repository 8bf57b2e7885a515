//! What is drawn next: which panes, how large, in this frame or beside the interface.

use super::pace::Limits;
use super::pane::{Pane, Told};
use super::renderer::Engine;
use super::request::Request;
use super::tempo::{DISPLAY_INTERVAL_MS, STEP_BUDGET_MS};
use super::views::Which;
use crate::window::model::{MethodChoice, PaneId};
use defocus::methods::MethodError;
use std::collections::BTreeMap;
use std::time::Instant;

/// Frames of the first pane for one of another, where not all can be rendered in each.
const FRAMES_PER_OTHER: u32 = 4;

/// Submitted and unfinished frames beyond which nothing is added: a slow GPU would be
/// asked for pictures that nobody wants any more.
const MAX_IN_FLIGHT: usize = 2;

/// The same where a program draws the frames, and the interface's own after them.
const MAX_IN_FLIGHT_SOFTWARE: usize = 1;

/// What is to be drawn for a pane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Plan {
    /// Its picture, so many times smaller than in full, in the next frame.
    Here(u32),
    /// Its full picture, beside the interface.
    Beside,
}

/// Whether a method is to be drawn with other shaders than this engine's, which only the device
/// beside has.
pub(super) fn is_built_elsewhere(method: &MethodChoice, replaced: &BTreeMap<String, String>) -> bool {
    method.as_built && !replaced.is_empty()
}

impl Engine {
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

    fn bring_up_to_date(&mut self, request: &Request) -> Result<bool, MethodError> {
        self.poll();
        let answered = self.take_answers() | self.take_from_beside();
        self.asked = Some(request.clone());
        if self.source.is_none() || self.device_errors.is_lost() {
            self.waiting.clear();
            return Ok(answered);
        }
        request.render.lens.check()?;
        let needed = self.follow(request);
        self.call_back(request, &needed);
        self.blur_px = self.mean_blur_px(&request.render.lens);
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
        self.measure_panes(request);
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

    pub(super) fn limits(&self) -> Limits {
        Limits { budget_ms: self.tempo.budget_ms, is_software: self.gpu.is_software() }
    }

    /// What is to be drawn for a pane; nothing where it has what is asked for.
    fn plan(&mut self, id: PaneId, request: &Request) -> Option<Plan> {
        let (limits, blur_px) = (self.limits(), self.blur_px);
        let pane = self.panes.get_mut(&id)?;
        if pane.made_for.as_ref() == Some(&request.render) {
            return None;
        }
        if is_built_elsewhere(&pane.state.method, &self.shaders) {
            // Drawn once nothing moves: each picture waits for another device.
            return (!request.is_moving).then_some(Plan::Beside);
        }
        if !pane.pace.is_slow(blur_px, limits) {
            return Some(Plan::Here(1));
        }
        let is_there = pane.made_for.is_some() && pane.made_for == Some(request.render.coarser(pane.divisor));
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
            is_elsewhere |= self.views.prepare(source, &request.render, Which::Full)?;
        }
        if coarsest > 1 {
            is_elsewhere |= self.views.prepare(source, &request.render.coarser(coarsest), Which::Coarse)?;
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

    /// Makes the engine's panes those of the request; returns the needed ones.
    fn follow(&mut self, request: &Request) -> Vec<PaneId> {
        let needed = request.needed();
        // A pane that is not on the screen keeps its picture for when it comes back.
        self.panes.retain(|id, _| request.pane(*id).is_some());
        self.colors.retain(|id, _| request.pane(*id).is_some());
        for state in &request.panes {
            let told = Told { explained: request.explain, everything: request.story == Some(state.id) };
            let pane = self.panes.entry(state.id).or_insert_with(|| Pane::new(state));
            pane.follow(state, told, request.render.size);
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
}
