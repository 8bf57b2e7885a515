//! Keeping pictures and comparisons: written beside the interface, which goes on.

use super::compared::{AwaitedTruth, Order};
use super::enlarged::{self, enlarged};
use super::model::{PaneId, PictureKind, Show};
use super::report;
use super::tasks::Task;
use super::{App, Engine, Identity};
use defocus::gpu::download_rgba8;
use defocus::image::{ColorImage, DepthImage};
use defocus::image_io::{self, ImageError};
use defocus_study::Truth;
use eframe::egui::{self, Context};
use glam::UVec2;
use std::path::PathBuf;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex};

/// What is told where a picture is wanted of a device that is lost.
const GONE: &str = "the picture went with the graphics device; save the state and start the program again";

/// What is told where there is no picture.
const NONE: &str = "there is no picture to save yet: wait for it, or choose another method";

/// What is told where linear light is wanted of an anaglyph.
const ANAGLYPH: &str = "an anaglyph is made of what a display shows, and EXR holds linear light: save it as PNG, or show the eyes side by side";

/// Writes a file; on a thread.
type Write = Box<dyn FnOnce() -> Result<(), ImageError> + Send>;

/// Linear colours with their depths, where these have the same size.
type Linear = (Arc<ColorImage>, Option<Arc<DepthImage>>);

/// A reference that a report waits for.
pub struct WantedTruth {
    of: Identity,
    sender: Sender<Truth>,
    progress: Arc<Mutex<(u32, u32)>>,
}

impl App {
    /// Saves a pane's picture.
    pub(super) fn save_picture(&mut self, ctx: &Context, id: PaneId, kind: PictureKind, file: PathBuf) {
        if self.engine.is_lost() {
            return self.messages.error(ctx, GONE);
        }
        let name = file.display().to_string();
        let writing = match kind {
            PictureKind::Png => self.writing_png(id, file),
            PictureKind::Exr => self.writing_exr(id, file),
        };
        match writing {
            Ok(write) => {
                let work = move |saved: String| write().map(|()| saved).map_err(|e| e.to_string());
                let (title, saved) = (format!("Saving {name}"), format!("Saved {name}"));
                self.tasks.push(Task::start(title, ctx, move |_| work(saved)));
            }
            Err(error) => self.messages.error(ctx, error),
        }
    }

    /// Size of a pane's picture, px, where it can be drawn with more pixels: a picture of one eye,
    /// of a scene, as the method draws it.
    pub(super) fn size_to_enlarge(&self, id: PaneId) -> Option<UVec2> {
        let is_scene = self.engine.source().is_some_and(|source| source.source().is_scene());
        let is_picture = self.document.pane(id).is_some_and(|pane| pane.show == Show::Picture);
        (is_scene && is_picture && self.stereo().is_none()).then(|| self.eye_size_px())
    }

    /// Draws a pane's picture with more pixels, and saves it.
    pub(super) fn save_enlarged(
        &mut self,
        ctx: &Context,
        (id, kind): (PaneId, PictureKind),
        times: u32,
        file: PathBuf,
    ) {
        let Some(method) = self.document.pane(id).map(|pane| pane.method.clone()) else { return };
        let Some(order) = self.order_without_truth() else { return };
        let name = file.display().to_string();
        self.tasks.push(Task::start(format!("Drawing {name}"), ctx, move |progress| {
            let order = enlarged(order, times);
            enlarged::write(&order, &method, kind, &file, progress).map(|()| format!("Saved {name}"))
        }));
    }

    fn writing_png(&self, id: PaneId, file: PathBuf) -> Result<Write, &'static str> {
        let image = download_rgba8(self.engine.gpu(), self.shown(id).ok_or(NONE)?);
        Ok(Box::new(move || image_io::write_png(&file, &image)))
    }

    fn writing_exr(&mut self, id: PaneId, file: PathBuf) -> Result<Write, &'static str> {
        let (color, depth_m) = self.linear(id)?;
        let coc = self.document.lens.coc();
        Ok(Box::new(move || {
            let coc_px = depth_m.as_ref().map(|depth_m| depth_m.map(|d| coc.at_depth(f64::from(d)) as f32));
            image_io::write_exr(&file, &color, depth_m.as_deref(), coc_px.as_ref())
        }))
    }

    /// A pane's linear picture as it is laid out: of one eye, or of both side by side.
    fn linear(&mut self, id: PaneId) -> Result<Linear, &'static str> {
        let (left, left_m) = linear_of(&mut self.engine, id).ok_or(NONE)?;
        let Some(layout) = self.stereo().map(|stereo| stereo.layout) else { return Ok((left, left_m)) };
        if !layout.is_side_by_side() {
            return Err(ANAGLYPH);
        }
        let right = self.eyes.right().and_then(|right| linear_of(right, id));
        let (right, right_m) = right.filter(|(right, _)| right.size == left.size).ok_or(NONE)?;
        let depth_m = left_m.zip(right_m).map(|(l, r)| Arc::new(layout.side_by_side(&l, &r)));
        Ok((Arc::new(layout.side_by_side(&left, &right)), depth_m))
    }

    /// A pane's picture, as it is shown, to the clipboard.
    pub(super) fn copy_image(&mut self, ctx: &Context, id: PaneId) {
        if self.engine.is_lost() {
            return self.messages.error(ctx, GONE);
        }
        let Some(shown) = self.shown(id) else { return self.messages.error(ctx, NONE) };
        let image = download_rgba8(self.engine.gpu(), shown);
        let size = [image.size.x as usize, image.size.y as usize];
        ctx.copy_image(egui::ColorImage::from_rgba_unmultiplied(size, image.pixels.as_flattened()));
        self.messages.note(ctx, "The picture is on the clipboard.");
    }

    /// Makes the comparison of all panes.
    pub(super) fn start_report(&mut self, ctx: &Context, file: PathBuf) {
        if self.engine.is_lost() {
            return self.messages.error(ctx, GONE);
        }
        let name = format!("Comparison for {}", file.display());
        if self.tasks.iter().any(|task| task.name() == name) {
            return self.messages.error(ctx, "this comparison is being made already: wait for it or cancel it");
        }
        let Some(order) = self.order() else { return };
        self.tasks.push(Task::start(name, ctx, move |progress| {
            let saved = format!("Saved {}", file.display());
            report::write(&order, &file, progress).map(|()| saved)
        }));
    }

    /// What a comparison of all panes is to be made from; none before there is a source.
    pub(super) fn order(&mut self) -> Option<Order> {
        let order = self.order_without_truth()?;
        Some(Order { truth: self.await_truth(), ..order })
    }

    /// The same for what waits for no reference of the window.
    pub(super) fn order_without_truth(&self) -> Option<Order> {
        let source = self.engine.source().cloned()?;
        Some(Order {
            source: source.source().clone(),
            options: source.options(),
            adapter: self.engine.gpu().adapter().name.clone(),
            shaders: self.engine.shaders().clone(),
            document: self.document.clone(),
            size: self.eye_size_px(),
            truth: None,
            activity: self.engine.activity(),
        })
    }

    /// The window's own reference for a report, which is not drawn a second time; none where
    /// there is none, and of two eyes, whose middle no reference shows.
    fn await_truth(&mut self) -> Option<AwaitedTruth> {
        let of = self.engine.wanted_truth().filter(|_| self.stereo().is_none())?;
        let (sender, arrives) = channel();
        let progress = Arc::<Mutex<(u32, u32)>>::default();
        self.wanted_truths.push(WantedTruth { of, sender, progress: progress.clone() });
        Some(AwaitedTruth { arrives, progress })
    }

    /// Hands the reference to the reports that wait for it, once it has converged; those that
    /// wait for one which the window does not show any more draw their own.
    pub(super) fn hand_out_truths(&mut self) {
        let engine = &self.engine;
        self.wanted_truths.retain(|wanted| match engine.truth(&wanted.of) {
            Some(Ok(truth)) => {
                // Nobody waits any more where the report was cancelled.
                let _ = wanted.sender.send(truth);
                false
            }
            Some(Err(now)) => {
                if let Ok(mut progress) = wanted.progress.lock() {
                    *progress = now;
                }
                true
            }
            None => false,
        });
    }
}

fn linear_of(engine: &mut Engine, id: PaneId) -> Option<Linear> {
    let color = engine.color(id)?;
    let gpu = engine.gpu().clone();
    let depth_m = engine.view().map(|view| view.depth_m(&gpu)).filter(|depth_m| depth_m.size == color.size);
    Some((color, depth_m))
}
