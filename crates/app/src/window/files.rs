//! Opening files, and what is done with those that were named.

use super::App;
use super::dialogs::{Answer, Purpose};
use super::model::state;
use super::model::{Document, Edit};
use defocus::aperture::{Aperture, ApertureImage};
use eframe::egui::Context;
use std::path::Path;
use std::sync::Arc;

impl App {
    /// Opens a built-in scene, a file, or a state.
    pub fn open_anything(&mut self, ctx: &Context, spec: &str) {
        if state::is_state(spec) {
            return self.open_state(ctx, Path::new(spec));
        }
        self.loader.start(spec, &Default::default(), true, self.engine.gpu(), ctx);
    }

    fn open_state(&mut self, ctx: &Context, file: &Path) {
        match state::read(file) {
            Ok(document) => {
                self.preferences.remember(file);
                self.document = document;
                self.focus_motion.stop();
            }
            Err(error) => self.messages.error(ctx, &error.to_string()),
        }
    }

    /// Does what a file was asked for.
    pub fn answer(&mut self, ctx: &Context, answer: Answer) {
        let Answer { purpose, file, depth, times } = answer;
        let name = file.to_string_lossy().into_owned();
        let done = match purpose {
            Purpose::Open if state::is_state(&name) => return self.open_state(ctx, &file),
            Purpose::Open => return self.loader.start(&name, &depth, true, self.engine.gpu(), ctx),
            Purpose::State => state::write(&file, &self.document).map_err(|e| e.to_string()),
            Purpose::Picture(id, kind) if times > 1 => return self.save_enlarged(ctx, (id, kind), times, file),
            Purpose::Picture(id, kind) => return self.save_picture(ctx, id, kind, file),
            Purpose::Aperture => return self.take_aperture(ctx, &file),
            Purpose::Report => return self.start_report(ctx, file),
            Purpose::Numbers(numbers) => self.save_numbers(numbers, &file),
        };
        match done {
            Ok(()) => {
                if purpose == Purpose::State {
                    self.preferences.remember(&file);
                }
                self.messages.note(ctx, &format!("Saved {name}"));
            }
            Err(error) => self.messages.error(ctx, &error),
        }
    }

    /// Gives the lens an image as its aperture.
    fn take_aperture(&mut self, ctx: &Context, file: &Path) {
        match ApertureImage::load(file) {
            Ok(image) => self.edit(Edit::Aperture(Aperture::Image(Arc::new(image)))),
            Err(error) => self.messages.error(ctx, &error.to_string()),
        }
    }

    /// Starts to load what the document names where that is not there yet: after undo, and
    /// when a state was opened.
    pub(super) fn load_what_is_named(&mut self, ctx: &Context) {
        let named = (self.document.scene.clone(), self.document.depth.clone());
        if self.loader.loading().is_some() || self.loaded.as_ref() == Some(&named) {
            return;
        }
        let fresh = self.document.is_fresh();
        self.loader.start(&named.0, &named.1, fresh, self.engine.gpu(), ctx);
    }

    /// Takes in what was loaded, or says why it was not.
    pub(super) fn take_in_loaded(&mut self, ctx: &Context) {
        let Some(loaded) = self.loader.poll() else { return };
        match loaded.result {
            Ok(source) => {
                self.engine.set_source(source);
                self.eyes.forget();
                self.forget_scale_offer();
                self.forget_animation();
                self.document.scene.clone_from(&loaded.spec);
                self.document.depth.clone_from(&loaded.depth);
                if Path::new(&loaded.spec).is_file() {
                    self.preferences.remember(Path::new(&loaded.spec));
                }
                self.watched.follow(&loaded.spec, &loaded.depth, ctx);
                self.loaded = Some((loaded.spec, loaded.depth));
                let was_metered = std::mem::replace(&mut self.metered_ev, loaded.metered_ev).is_some();
                if loaded.fresh && self.document.automatic_exposure && (was_metered || self.metered_ev.is_some()) {
                    self.edit(Edit::MeteredExposure(loaded.metered_ev.unwrap_or(0.0)));
                }
                if loaded.fresh {
                    self.document.moment = None;
                    self.choose_camera(0);
                    self.refocus();
                }
            }
            Err(error) => {
                // The error says what is missing.
                if loaded.is_incomplete {
                    self.dialogs.complete(ctx, Path::new(&loaded.spec), Some(error));
                } else {
                    self.messages.error(ctx, &error);
                }
                self.back_to_what_is_loaded();
            }
        }
    }

    /// Goes on with what is there instead of what is being opened.
    pub(super) fn give_up_loading(&mut self) {
        if self.loader.loading().is_some() && self.loaded.is_some() {
            self.loader.cancel();
            self.back_to_what_is_loaded();
        }
    }

    /// After something could not be opened: what is there stays.
    fn back_to_what_is_loaded(&mut self) {
        let (scene, depth) = self.loaded.clone().unwrap_or_else(|| ("cans".into(), Default::default()));
        if (&self.document.scene, &self.document.depth) != (&scene, &depth) {
            let Document { panes, arrangement, tiles, a, b, .. } = self.document.clone();
            self.document = Document { scene, depth, panes, arrangement, tiles, a, b, ..Document::default() };
            if self.loaded.is_some() {
                self.choose_camera(0);
                self.refocus();
            }
        }
    }
}
