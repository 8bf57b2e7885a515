//! Has pictures that rest compared with the reference.

use super::figures::Purpose;
use super::renderer::Engine;
use super::request::{DisplaySettings, Request};

impl Engine {
    /// Takes in what was measured; true if something was.
    pub(super) fn take_answers(&mut self) -> bool {
        let panes = &mut self.panes;
        self.metrics_worker.poll(&self.gpu, |id| panes.get_mut(&id).map(|p| &mut p.results))
    }

    /// Measures what has come to rest.
    pub(super) fn measure_panes(&mut self, request: &Request) {
        let panes = &mut self.panes;
        self.unmeasured = false;
        let DisplaySettings { display, viewing, .. } = request.display_settings;
        let truth = request.reference.and_then(|id| Some((id, panes.get(&id)?.milestone.clone()?)));
        let rested = self.waiting.is_empty() && self.changed_at.elapsed() >= self.tempo.rest;
        for id in &request.visible {
            let Some(pane) = panes.get(id).filter(|pane| pane.made_for.as_ref() == Some(&request.render)) else {
                continue;
            };
            let truth = truth.as_ref().filter(|(truth, _)| truth != id).map(|(_, milestone)| milestone);
            let (against, kind) = pane.wants_map_against().unzip();
            let against = against.and_then(|other| panes.get(&other)?.milestone.as_ref());
            let map = kind.map(|kind| (against, Purpose::Map(kind)));
            for (other, purpose) in map.into_iter().chain([(truth, Purpose::Figures)]) {
                let (Some(other), Some(own)) = (other, &pane.milestone) else { continue };
                if other.identity.render != own.identity.render {
                    continue;
                }
                self.unmeasured |= match rested {
                    true => {
                        let pane = (*id, &pane.results);
                        self.metrics_worker.measure(
                            &self.gpu,
                            &self.wake,
                            pane,
                            (own, other),
                            (display, viewing),
                            purpose,
                        )
                    }
                    false => true,
                };
            }
        }
        // Without a truth there is nothing that old figures could be about.
        for id in request.visible.iter().filter(|_| request.reference.is_none()) {
            if let Some(pane) = panes.get_mut(id).filter(|p| p.wants_map_against().is_none()) {
                pane.results.forget();
            }
        }
    }
}
