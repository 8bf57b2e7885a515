//! Records a frame: new pictures, further lens points, and what is seen of both.

use super::flight::{InFlight, Part};
use super::milestone::Milestone;
use super::pane::Pane;
use super::renderer::Engine;
use super::request::Request;
use super::tempo::STEP_BUDGET_MS;
use crate::window::model::{PaneId, Show};
use defocus::gpu::Frame;
use std::time::Instant;

/// Views of a step at most, however fast they are.
const MAX_STEP_VIEWS: u32 = 32;

impl Engine {
    /// Renders `chosen` anew, the slow ones `divisor` times smaller, adds lens points to
    /// `converging` and presents what changed.
    pub(super) fn submit(&mut self, request: &Request, (chosen, divisor): (&[PaneId], u32), converging: &[PaneId]) {
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
            if let Some(view) = self.views.of(&request.render.coarser(divisor)) {
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
        let render = request.render.coarser(divisor);
        let (view, pane) = (self.views.of(&render)?, self.panes.get_mut(&id)?);
        if pane.made_for.as_ref() != Some(&render) {
            pane.restart(&render, divisor);
        }
        self.revisions += 1;
        let stamp = (self.revisions, self.world);
        let counted = pane.progress().map_or(0, |(count, _)| count);
        let first = frame.stats.passes as usize;
        if pane.wants_intermediates() {
            frame.keep_intermediates();
        }
        if let Err(error) = pane.record(frame, view, &render, views, stamp) {
            pane.fail(error, &render);
        }
        pane.keep_of(frame.take_intermediates(), view.size(), view.overscan_px());
        let views = pane.progress().map_or(0, |(count, _)| count.saturating_sub(counted));
        Some(Part { pane: id, divisor, views, passes: first..frame.stats.passes as usize })
    }

    pub(super) fn wants_presenting(&mut self, request: &Request) -> bool {
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
}
