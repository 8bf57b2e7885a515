//! Animations of a scene's file: played, stopped and scrubbed. A thread poses the scene and uploads
//! what changes; the newest moment that is asked for comes next, and none is waited for.

use super::App;
use super::model::{Edit, Moment};
use super::ui::panels::{AnimationAction, AnimationView, animation_bar};
use defocus::scene::Scene;
use defocus_study::source::Posable;
use defocus_study::{DepthArgs, GpuSource, Source};
use eframe::egui::{Context, Frame, Margin, Panel, Ui};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

/// What a played animation goes on by at most in a frame, seconds: after a pause it does not jump.
const LONGEST_STEP_S: f64 = 0.25;

/// A scene at a moment, or why there is none.
type Posed = (Option<Moment>, Result<GpuSource, String>);

/// A moment that is asked for, and the source to be posed.
type Asked = (Option<Moment>, GpuSource);

/// Poses one file until it is dropped.
struct Poser {
    ask: Sender<Asked>,
    posed: Receiver<Posed>,
}

impl Poser {
    fn start(spec: String, depth: DepthArgs, ctx: &Context) -> Self {
        let (ask, asked) = channel::<Asked>();
        let (tell, posed) = channel();
        let ctx = ctx.clone();
        std::thread::spawn(move || {
            let mut file: Option<Result<Posable, String>> = None;
            while let Ok(first) = asked.recv() {
                // Of several only the last is still wanted.
                let (moment, source) = asked.try_iter().last().unwrap_or(first);
                let file = file.get_or_insert_with(|| Posable::open(&spec, &depth).map_err(|e| e.to_string()));
                let scene: Result<Scene, String> = match (&*file, &moment) {
                    (Err(error), _) => Err(error.clone()),
                    (Ok(file), Some(moment)) => file.at(&moment.into()).map_err(|e| e.to_string()),
                    (Ok(file), None) => Ok(file.at_rest()),
                };
                let result = scene.map(|scene| source.posed(Arc::new(scene)));
                if tell.send((moment, result)).is_err() {
                    return;
                }
                ctx.request_repaint();
            }
        });
        Self { ask, posed }
    }
}

/// What plays.
#[derive(Default)]
pub struct Animating {
    poser: Option<Poser>,
    is_playing: bool,
    /// What was asked for last, and what is shown.
    asked: Option<Moment>,
    shown: Option<Moment>,
}

impl Animating {
    /// Whether what is shown is what is asked for, and stays so.
    pub fn is_at_rest(&self) -> bool {
        !self.is_playing && self.asked == self.shown
    }
}

impl App {
    /// Starts anew, as with another scene, which is at rest.
    pub(super) fn forget_animation(&mut self) {
        self.animating = Animating::default();
    }

    /// Plays the animation, or stops it.
    pub(super) fn toggle_animation(&mut self) {
        let Some((moment, _)) = self.moment_shown() else { return };
        self.animating.is_playing = !self.animating.is_playing;
        if self.document.moment.is_none() {
            self.edit(Edit::Moment(Some(moment)));
        }
    }

    /// The moment that the document names, or the beginning of the first animation, with the length
    /// of that animation, seconds; none of what has no animation.
    fn moment_shown(&self) -> Option<(Moment, f64)> {
        let Source::Scene(scene) = self.engine.source()?.source() else { return None };
        let first = scene.animations.first()?;
        let moment = self.document.moment.clone();
        let moment = moment.unwrap_or_else(|| Moment { animation: first.name.clone(), time_s: 0.0 });
        let known = scene.animations.iter().find(|animation| animation.name == moment.animation);
        Some((moment, known.unwrap_or(first).duration_s))
    }

    /// Goes on with what plays, has the scene posed as the document says, and takes in what was.
    pub(super) fn animate(&mut self, ctx: &Context) {
        self.take_in_posed(ctx);
        let Some((moment, duration_s)) = self.moment_shown().filter(|_| self.shows_what_is_named()) else { return };
        if self.animating.is_playing {
            // Not while the last step is still drawn: a slow adapter shows fewer moments, each in full.
            if self.animating.asked == self.animating.shown {
                let by_s = ctx.input(|i| f64::from(i.stable_dt)).min(LONGEST_STEP_S);
                self.edit(Edit::Moment(Some(moment.later(by_s, duration_s))));
            }
            ctx.request_repaint();
        }
        let wanted = self.document.moment.clone();
        if wanted != self.animating.asked
            && let Some(source) = self.engine.source().cloned()
        {
            let (scene, depth) = (&self.document.scene, &self.document.depth);
            let poser = self.animating.poser.get_or_insert_with(|| Poser::start(scene.clone(), depth.clone(), ctx));
            // A thread that stopped tells nothing: then the scene stays as it is.
            let _ = poser.ask.send((wanted.clone(), source));
            self.animating.asked = wanted;
        }
    }

    fn take_in_posed(&mut self, ctx: &Context) {
        let Some((moment, result)) = self.animating.poser.as_ref().and_then(|poser| poser.posed.try_iter().last())
        else {
            return;
        };
        match result {
            Ok(source) => {
                let followed = self.camera_of_file().filter(|camera| self.document.camera == Some(*camera));
                self.engine.pose_source(source);
                self.eyes.forget();
                // A camera that the person has not moved goes where the file moves it.
                if followed.is_some() {
                    self.document.camera = self.camera_of_file();
                }
                self.animating.shown = moment;
            }
            Err(error) => {
                self.messages.error(ctx, &error);
                self.animating.is_playing = false;
                let shown = self.animating.shown.clone();
                (self.animating.asked, self.document.moment) = (shown.clone(), shown);
            }
        }
    }

    /// Where the file has the chosen camera at the moment that is shown.
    fn camera_of_file(&self) -> Option<defocus::camera::Camera> {
        let Source::Scene(scene) = self.engine.source()?.source() else { return None };
        Some(scene.cameras.get(self.document.camera_index)?.camera)
    }

    /// The bar below the panes of a scene with animations.
    pub(super) fn animation_bar(&mut self, ui: &mut Ui) {
        let Some((moment, duration_s)) = self.moment_shown() else { return };
        let Some(source) = self.engine.source().map(|source| source.source().clone()) else { return };
        let Source::Scene(scene) = source else { return };
        let names: Vec<&str> = scene.animations.iter().map(|animation| animation.name.as_str()).collect();
        let view = AnimationView {
            names: &names,
            chosen: &moment.animation,
            time_s: moment.time_s,
            duration_s,
            is_playing: self.animating.is_playing,
            is_at_rest: self.document.moment.is_none(),
        };
        let frame = Frame::side_top_panel(ui.style()).inner_margin(Margin::symmetric(8, 4));
        let shown = Panel::bottom("animation").frame(frame).show(ui, |ui| animation_bar(ui, &view));
        match shown.inner {
            Some(AnimationAction::PlayOrStop) => self.toggle_animation(),
            Some(AnimationAction::Choose(animation)) => {
                self.edit(Edit::Moment(Some(Moment { animation, time_s: 0.0 })));
            }
            Some(AnimationAction::Scrub(time_s)) => {
                self.animating.is_playing = false;
                self.edit(Edit::Moment(Some(Moment { time_s, ..moment })));
            }
            Some(AnimationAction::Rest) => {
                self.animating.is_playing = false;
                self.edit(Edit::Moment(None));
            }
            None => {}
        }
    }
}
