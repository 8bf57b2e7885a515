//! Opening and saving.

use super::dialogs::{Answer, Purpose};
use super::document::{Document, PaneId};
use super::tasks::Task;
use super::{App, report, state};
use crate::aperture::{Aperture, ApertureImage};
use crate::gpu::download_rgba8;
use crate::image_io;
use eframe::egui::{ColorImage, Context};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What is told where a picture is wanted of a device that is lost.
const GONE: &str = "the picture went with the graphics device; save the state and start the program again";

/// Ways to keep a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureKind {
    /// As it is shown: 8 bits, sRGB.
    Png,
    /// The method's own values: linear, 32 bits, with depth and CoC where they fit.
    Exr,
}

impl PictureKind {
    /// What the file's name ends with.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Exr => "exr",
        }
    }
}

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
        let Answer { purpose, file, depth } = answer;
        let name = file.to_string_lossy().into_owned();
        let done = match purpose {
            Purpose::Open if state::is_state(&name) => return self.open_state(ctx, &file),
            Purpose::Open => return self.loader.start(&name, &depth, true, self.engine.gpu(), ctx),
            Purpose::State => state::write(&file, &self.document).map_err(|e| e.to_string()),
            Purpose::Picture(id, kind) => self.save_picture(id, kind, &file),
            Purpose::Aperture => return self.take_aperture(ctx, &file),
            Purpose::Report => {
                self.start_report(ctx, file);
                return;
            }
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
            Ok(image) => self.document.lens.aperture = Aperture::Image(Arc::new(image)),
            Err(error) => self.messages.error(ctx, &error.to_string()),
        }
    }

    fn save_picture(&mut self, id: PaneId, kind: PictureKind, file: &Path) -> Result<(), String> {
        let none = || "there is no picture to save yet: wait for it, or choose another method".to_owned();
        if self.engine.is_lost() {
            return Err(GONE.into());
        }
        match kind {
            PictureKind::Png => {
                let shown = self.shown(id).ok_or_else(none)?;
                image_io::write_png(file, &download_rgba8(self.engine.gpu(), shown)).map_err(|e| e.to_string())
            }
            PictureKind::Exr => {
                let color = self.engine.color(id).ok_or_else(none)?;
                let gpu = self.engine.gpu().clone();
                let depth = self.engine.view().map(|view| view.depth_m(&gpu)).filter(|d| d.size == color.size);
                let coc = self.document.lens.coc();
                let coc_px = depth.as_ref().map(|d| d.map(|d| coc.at_depth(f64::from(d)) as f32));
                image_io::write_exr(file, &color, depth.as_deref(), coc_px.as_ref()).map_err(|e| e.to_string())
            }
        }
    }

    /// A pane's picture, as it is shown, to the clipboard.
    pub(super) fn copy_image(&mut self, ctx: &Context, id: PaneId) {
        if self.engine.is_lost() {
            return self.messages.error(ctx, GONE);
        }
        let Some(shown) = self.shown(id) else { return };
        let image = download_rgba8(self.engine.gpu(), shown);
        let size = [image.size.x as usize, image.size.y as usize];
        ctx.copy_image(ColorImage::from_rgba_unmultiplied(size, image.pixels.as_flattened()));
        self.messages.note(ctx, "The picture is on the clipboard.");
    }

    fn start_report(&mut self, ctx: &Context, file: PathBuf) {
        if self.engine.is_lost() {
            return self.messages.error(ctx, GONE);
        }
        if self.task.is_some() {
            self.messages.error(ctx, "a comparison is being made already: wait for it or cancel it");
            return;
        }
        let Some(source) = self.engine.source().cloned() else { return };
        let (document, size) = (self.document.clone(), self.viewport.size_px());
        let name = format!("Comparison for {}", file.display());
        self.task = Some(Task::start(name, ctx, move |progress| {
            let gpu = source.gpu().clone();
            report::write(&gpu, &source, &document, size, &file, progress).map(|()| format!("Saved {}", file.display()))
        }));
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
                self.document.scene.clone_from(&loaded.spec);
                self.document.depth.clone_from(&loaded.depth);
                if Path::new(&loaded.spec).is_file() {
                    self.preferences.remember(Path::new(&loaded.spec));
                }
                self.watched.follow(&loaded.spec, &loaded.depth, ctx);
                self.loaded = Some((loaded.spec, loaded.depth));
                if loaded.fresh {
                    self.choose_camera(0);
                    self.refocus();
                }
            }
            Err(error) => {
                if loaded.lacks_depth {
                    self.dialogs.open_with_depth(ctx, Path::new(&loaded.spec));
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
