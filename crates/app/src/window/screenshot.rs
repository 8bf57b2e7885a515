//! The whole window as a PNG, once there is a picture in it; then the program ends.

use defocus::image::Image;
use defocus::image_io;
use eframe::egui::{self, ColorImage, ViewportCommand};
use glam::UVec2;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// Frames of the interface between the finished picture and the photograph: the status
/// line and the times follow the picture by two.
const SETTLE_FRAMES: u32 = 4;

/// How a photograph ended, for who started the program.
pub type Outcome = Arc<Mutex<Option<Result<(), String>>>>;

/// A photograph to be taken.
pub struct Screenshot {
    path: PathBuf,
    settled: u32,
    taken: Option<Arc<Mutex<Option<Arc<ColorImage>>>>>,
    outcome: Outcome,
}

impl Screenshot {
    /// To be saved to `path`; `outcome` is set when the window closes.
    pub fn new(path: PathBuf, outcome: Outcome) -> Self {
        Self { path, settled: 0, taken: None, outcome }
    }

    /// One frame on: `ready` says that nothing is under way any more, `failure` why there
    /// will never be a picture.
    pub fn advance(&mut self, ctx: &egui::Context, ready: bool, failure: Option<&str>) {
        ctx.request_repaint();
        if let Some(failure) = failure {
            self.finish(ctx, Err(failure.into()));
            return;
        }
        if let Some(taken) = &self.taken {
            let image = taken.lock().expect("the callback does not panic").take();
            if let Some(image) = image {
                self.finish(ctx, save(&self.path, &image));
            }
            return;
        }
        self.settled = if ready { self.settled + 1 } else { 0 };
        if self.settled > SETTLE_FRAMES {
            let slot = Arc::new(Mutex::new(None));
            self.taken = Some(slot.clone());
            ctx.send_viewport_cmd(ViewportCommand::Screenshot(egui::ScreenshotCallback::new(move |image| {
                *slot.lock().expect("nobody panics while looking") = Some(image);
            })));
        }
    }

    fn finish(&self, ctx: &egui::Context, outcome: Result<(), String>) {
        *self.outcome.lock().expect("nobody panics while looking") = Some(outcome);
        ctx.send_viewport_cmd(ViewportCommand::Close);
    }
}

fn save(path: &Path, image: &ColorImage) -> Result<(), String> {
    let size = UVec2::new(image.width() as u32, image.height() as u32);
    // The window is opaque, whatever its surface says about it.
    let opaque = |p: &egui::Color32| [p.r(), p.g(), p.b(), 255];
    let pixels = image.pixels.iter().map(opaque).collect();
    image_io::write_png(path, &Image { size, pixels }).map_err(|e| e.to_string())
}
