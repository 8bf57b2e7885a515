//! What the engine has drawn beside the interface, and what comes of it.

use super::lane::{Drawn, Job, Lane, Subject, Told, upload};
use super::request::Request;
use super::{Engine, Identity, Pane};
use crate::app::document::PaneId;
use crate::methods::Method;
use std::sync::Arc;

/// A picture that is being drawn beside.
pub(super) struct Errand {
    ticket: u64,
    /// What it will be, the lens points aside.
    identity: Identity,
    /// Lens points that it has and will have, of one that converges.
    pub progress: Option<(u32, u32)>,
}

impl Engine {
    /// Has a pane's full picture drawn beside, unless it is already.
    pub(super) fn send_out(&mut self, id: PaneId, request: &Request) {
        let (Some(source), Some(pane)) = (&self.source, self.panes.get_mut(&id)) else { return };
        let (world, method) = (self.world, pane.state.method.clone());
        let identity = Identity { world, method, exposure: request.exposure.clone(), samples: None };
        if pane.errand.as_ref().is_some_and(|errand| errand.identity == identity) {
            return;
        }
        let method: Box<dyn Method> = match identity.method.build() {
            Ok(method) => method,
            Err(error) => return pane.fail(error, &request.exposure),
        };
        self.tickets += 1;
        let subject = Subject {
            world,
            source: source.source().clone(),
            options: source.options(),
            exposure: request.exposure.clone(),
        };
        let job = Job { ticket: self.tickets, subject, method };
        let lane = self.lane.get_or_insert_with(|| {
            let lane = Lane::start(self.gpu.adapter().name.clone(), self.wake.clone());
            self.shaders.iter().for_each(|(name, source)| lane.replace_shader(name, source));
            lane
        });
        if let Some(before) = pane.errand.take() {
            lane.give_up(before.ticket);
        }
        pane.run = None;
        pane.errand = Some(Errand { ticket: job.ticket, identity, progress: None });
        lane.draw(job);
    }

    /// Gives up what is drawn beside for panes that want something else by now.
    pub(super) fn call_back(&mut self, request: &Request, needed: &[PaneId]) {
        let Some(lane) = &self.lane else { return };
        let world = self.world;
        for (id, pane) in &mut self.panes {
            let is_wanted = |errand: &Errand| {
                let Identity { exposure, method, .. } = &errand.identity;
                needed.contains(id)
                    && errand.identity.world == world
                    && *exposure == request.exposure
                    && *method == pane.state.method
            };
            if let Some(errand) = pane.errand.take_if(|errand| !is_wanted(errand)) {
                lane.give_up(errand.ticket);
                // One that was not finished starts again when it is wanted again.
                pane.made_for = None;
            }
        }
    }

    /// Takes in what was drawn beside; true if something was.
    pub(super) fn take_from_beside(&mut self) -> bool {
        let told = self.lane.as_ref().map_or_else(Vec::new, Lane::told);
        let is_news = !told.is_empty();
        for (ticket, told) in told {
            let mut panes = self.panes.iter_mut();
            let Some((id, pane)) = panes.find(|(_, p)| p.errand.as_ref().is_some_and(|e| e.ticket == ticket)) else {
                continue;
            };
            self.revisions += 1;
            match told {
                Told::Progress(count, samples) => {
                    if let Some(errand) = &mut pane.errand {
                        errand.progress = Some((count, samples));
                    }
                }
                Told::Picture(drawn) => {
                    self.colors.insert(*id, (self.revisions, drawn.color.clone()));
                    let texture = upload(&self.gpu, &drawn.color);
                    pane.take_drawn(drawn, texture, self.revisions, self.blur_px);
                }
                Told::Failed(error) => {
                    if let Some(errand) = pane.errand.take() {
                        pane.fail(error, &errand.identity.exposure);
                    }
                }
            }
        }
        is_news
    }
}

impl Pane {
    /// Takes over a picture that was drawn beside.
    fn take_drawn(&mut self, drawn: Drawn, texture: crate::gpu::Texture, revision: u64, blur_px: f64) {
        let Some(Errand { identity, progress, .. }) = &self.errand else { return };
        let (identity, progress) = (identity.clone(), *progress);
        let Drawn { color, samples, is_done, ms, passes } = drawn;
        let identity = Identity { samples, ..identity };
        self.learn(1, ms, ms, blur_px);
        self.passes = passes;
        self.made_for = Some(identity.exposure.clone());
        (self.revision, self.divisor, self.error) = (revision, 1, None);
        self.finished = samples.zip(progress.map(|(_, goal)| goal));
        let is_worth = is_done || samples.is_none_or(|n| n >= super::pane::LEAST_SAMPLES && n.is_power_of_two());
        self.take(texture, identity, is_worth);
        if let Some(milestone) = self.milestone.as_mut().filter(|m| m.revision == revision) {
            milestone.color = Some(Arc::clone(&color));
        }
        if is_done {
            self.errand = None;
        }
    }
}
