//! What the engine has drawn beside the interface, and what comes of it.

use super::errand::{Errand, PassTimes};
use super::identity::Identity;
use super::kernel::{Kernel, KernelOf};
use super::lane::{Drawn, Job, Lane, Subject, Told, Work, upload};
use super::milestone::Milestone;
use super::pane::{LEAST_SAMPLES, Pane};
use super::renderer::Engine;
use super::request::Request;
use super::schedule::is_built_elsewhere;
use super::wake::Wake;
use crate::window::model::{KernelChoice, PaneId};
use defocus::display::Display;
use defocus::gpu::{Gpu, download};
use defocus::image::ColorImage;
use defocus::methods::{self, Method};
use defocus_study::Truth;
use defocus_study::reference::{Halves, self_psnr_db};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Runs whose passes are timed.
const TIMED_RUNS: u32 = 5;

/// The lane, which is started with the first picture that takes long.
fn started<'l>(lane: &'l mut Option<Lane>, gpu: &Gpu, wake: &Wake, shaders: &BTreeMap<String, String>) -> &'l Lane {
    lane.get_or_insert_with(|| {
        let lane = Lane::start(gpu.adapter().name.clone(), wake.clone());
        shaders.iter().for_each(|(name, source)| lane.replace_shader(name, source));
        lane
    })
}

impl Engine {
    /// Has a pane's full picture drawn beside, unless it is already.
    pub(super) fn send_out(&mut self, id: PaneId, request: &Request) {
        let (Some(source), Some(pane)) = (&self.source, self.panes.get_mut(&id)) else { return };
        let (world, method) = (self.world, pane.state.method.clone());
        let identity = Identity { world, method, render: request.render.clone(), samples: None };
        if pane.errand.as_ref().is_some_and(|errand| errand.identity == identity) {
            return;
        }
        let method: Box<dyn Method> = match identity.method.build() {
            Ok(method) => method,
            Err(error) => return pane.fail(error, &request.render),
        };
        self.tickets += 1;
        let subject = Subject {
            world,
            source: source.source().clone(),
            options: source.options(),
            render: request.render.clone(),
        };
        let as_built = is_built_elsewhere(&identity.method, &self.shaders);
        let job = Job { ticket: self.tickets, subject, method, as_built, work: Work::Picture };
        let lane = started(&mut self.lane, &self.gpu, &self.wake, &self.shaders);
        if let Some(before) = pane.errand.take() {
            lane.give_up(before.ticket);
        }
        pane.run = None;
        pane.errand = Some(Errand { ticket: job.ticket, identity, progress: None });
        lane.draw(job);
    }

    /// Times the passes of a pane's method beside the interface; [`Engine::pass_times`] has
    /// them once they are there.
    pub fn time_passes(&mut self, id: PaneId) {
        let (Some(source), Some(pane), Some(asked)) = (&self.source, self.panes.get(&id), &self.asked) else { return };
        let Ok(method) = pane.state.method.build() else { return };
        let (world, render) = (self.world, asked.render.clone());
        let identity = Identity { world, method: pane.state.method.clone(), render: render.clone(), samples: None };
        let subject = Subject { world, source: source.source().clone(), options: source.options(), render };
        self.tickets += 1;
        let lane = started(&mut self.lane, &self.gpu, &self.wake, &self.shaders);
        if let Some(PassTimes { ticket, times: None, .. }) = &self.pass_times {
            lane.give_up(*ticket);
        }
        let as_built = is_built_elsewhere(&identity.method, &self.shaders);
        self.pass_times = Some(PassTimes { ticket: self.tickets, of: identity, times: None });
        lane.draw(Job { ticket: self.tickets, subject, method, as_built, work: Work::TimePasses(TIMED_RUNS) });
    }

    /// Has the point spread function of a pane's method measured beside the interface, unless it
    /// is or was; [`Engine::kernel`] has it once it is there.
    pub fn measure_kernel(&mut self, id: PaneId, choice: KernelChoice) {
        let (Some(source), Some(pane), Some(asked)) = (&self.source, self.panes.get(&id), &self.asked) else { return };
        let render = asked.render.clone();
        let (world, aperture) = (self.world, render.lens.aperture.clone());
        let of = KernelOf { world, method: pane.state.method.clone(), aperture, choice };
        if self.kernel.as_ref().is_some_and(|known| known.of == of) {
            return;
        }
        let Ok(method) = of.method.build() else { return };
        self.tickets += 1;
        let subject = Subject { world, source: source.source().clone(), options: source.options(), render };
        let as_built = is_built_elsewhere(&of.method, &self.shaders);
        let lane = started(&mut self.lane, &self.gpu, &self.wake, &self.shaders);
        if let Some(before) = &self.kernel {
            lane.give_up(before.ticket);
        }
        self.kernel = Some(Kernel { ticket: self.tickets, of, psf: None });
        lane.draw(Job { ticket: self.tickets, subject, method, as_built, work: Work::Kernel(choice) });
    }

    /// What was measured last, and of which method.
    pub fn kernel(&self) -> Option<&Kernel> {
        self.kernel.as_ref()
    }

    /// What was timed last, and of which picture.
    pub fn pass_times(&self) -> Option<&PassTimes> {
        self.pass_times.as_ref()
    }

    /// Gives up what is drawn beside for panes that want something else by now.
    pub(super) fn call_back(&mut self, request: &Request, needed: &[PaneId]) {
        let Some(lane) = &self.lane else { return };
        let world = self.world;
        for (id, pane) in &mut self.panes {
            let is_wanted = |errand: &Errand| {
                let Identity { render, method, .. } = &errand.identity;
                needed.contains(id)
                    && errand.identity.world == world
                    && *render == request.render
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
            if let Some(timed) = self.pass_times.as_mut().filter(|timed| timed.ticket == ticket) {
                timed.times = Some(match told {
                    Told::Times(times) => Ok(times),
                    Told::Failed(error) => Err(error),
                    Told::Progress(..) | Told::Picture(_) | Told::Kernel(_) => continue,
                });
                continue;
            }
            if let Some(kernel) = self.kernel.as_mut().filter(|kernel| kernel.ticket == ticket) {
                kernel.take(told);
                continue;
            }
            let mut panes = self.panes.iter_mut();
            let Some((id, pane)) = panes.find(|(_, p)| p.errand.as_ref().is_some_and(|e| e.ticket == ticket)) else {
                continue;
            };
            self.revisions += 1;
            self.activity.count();
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
                Told::Times(_) | Told::Kernel(_) => {}
                Told::Failed(error) => {
                    if let Some(errand) = pane.errand.take() {
                        pane.fail(error, &errand.identity.render);
                    }
                }
            }
        }
        is_news
    }

    /// What the pane that shows the truth, or converges to it unseen, is to become.
    pub fn wanted_truth(&self) -> Option<Identity> {
        let asked = self.asked.as_ref()?;
        let method = self.panes.get(&asked.reference?)?.state.method.clone();
        Some(Identity { world: self.world, method, render: asked.render.clone(), samples: None })
    }

    /// The finished picture of the pane that shows the truth, or converges to it unseen.
    ///
    /// # Errors
    ///
    /// While it converges, the lens points that it has and will have.
    pub fn truth(&self, of: &Identity) -> Option<Result<Truth, (u32, u32)>> {
        let asked = self.asked.as_ref()?;
        let pane = self.panes.get(&asked.reference?)?;
        let is_asked = of.world == self.world && of.method == pane.state.method && of.render == asked.render;
        if !is_asked || pane.error.is_some() {
            return None;
        }
        let goal = pane.state.method.count("samples").unwrap_or_else(|| methods::Accumulation::default().samples);
        let Some(done) = pane.milestone.as_ref().filter(|m| m.identity.is_of(of)) else {
            return Some(Err(pane.progress().unwrap_or((0, goal))));
        };
        match done.identity.samples {
            // Without blur it is the pinhole image.
            Some(samples) if samples < goal => Some(Err(pane.progress().unwrap_or((samples, goal)))),
            samples => Some(Ok(self.truth_of(pane, done, samples, asked.display_settings.display))),
        }
    }

    /// A finished reference as the study has it, with how well it has converged.
    fn truth_of(&self, pane: &Pane, done: &Milestone, samples: Option<u32>, display: Display) -> Truth {
        let on_cpu = |milestone: &Milestone| match &milestone.color {
            Some(color) => color.as_ref().clone(),
            None => download(&self.gpu, &milestone.texture),
        };
        let color = on_cpu(done);
        // The points up to the last power of two, and those after it, are two estimates.
        let earlier = pane.earlier.as_ref().filter(|earlier| earlier.identity.is_of(&done.identity));
        let halves = earlier.and_then(|earlier| {
            let (first, all) = (earlier.identity.samples?, samples?);
            let (n1, n2) = (first as f32, all.checked_sub(first).filter(|rest| *rest > 0)? as f32);
            let half = on_cpu(earlier);
            let rest = color.pixels.iter().zip(&half.pixels).map(|(all, half)| (*all * (n1 + n2) - *half * n1) / n2);
            let rest = ColorImage { size: color.size, pixels: rest.collect() };
            Some(Halves { images: [half, rest], counts: [first, all - first] })
        });
        let self_psnr_db = halves.and_then(|halves| self_psnr_db(&halves, display));
        Truth { method: "accumulation", samples: samples.or(Some(1)), color, self_psnr_db }
    }
}

impl Pane {
    /// Takes over a picture that was drawn beside.
    fn take_drawn(&mut self, drawn: Drawn, texture: defocus::gpu::Texture, revision: u64, blur_px: f64) {
        let Some(Errand { identity, progress, .. }) = &self.errand else { return };
        let (identity, progress) = (identity.clone(), *progress);
        let Drawn { color, samples, is_done, ms } = drawn;
        let identity = Identity { samples, ..identity };
        self.learn(1, ms, ms, blur_px);
        self.made_for = Some(identity.render.clone());
        (self.revision, self.divisor, self.error) = (revision, 1, None);
        self.finished = samples.zip(progress.map(|(_, goal)| goal));
        let is_worth = is_done || samples.is_none_or(|n| n >= LEAST_SAMPLES && n.is_power_of_two());
        self.take(texture, identity, is_worth);
        if let Some(milestone) = self.milestone.as_mut().filter(|m| m.revision == revision) {
            milestone.color = Some(Arc::clone(&color));
        }
        if is_done {
            self.errand = None;
        }
    }
}
