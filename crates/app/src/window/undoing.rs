//! Taking changes back.

use super::App;
use super::model::Document;
use eframe::egui;
use eframe::egui::util::undoer::{self, Undoer};
use std::time::Duration;

/// How long a change must rest before it can be taken back by itself, seconds: less than
/// the pause between two deliberate changes.
const UNDO_REST_S: f32 = 0.5;

/// Where changes are noted.
pub fn undoer() -> Undoer<Document> {
    Undoer::with_settings(undoer::Settings { stable_time: UNDO_REST_S, ..Default::default() })
}

impl App {
    /// Notes what can be taken back.
    pub(super) fn feed_undo(&mut self, ctx: &egui::Context) {
        if self.loader.loading().is_some() || self.engine.source().is_none() {
            return;
        }
        self.undoer.feed_state(ctx.input(|i| i.time), &self.document.without_gaze());
        if self.undoer.is_in_flux() {
            ctx.request_repaint_after(Duration::from_secs_f32(UNDO_REST_S));
        }
    }

    pub(super) fn undo(&mut self) {
        if let Some(earlier) = self.undoer.undo(&self.document.without_gaze()).cloned() {
            self.restore(earlier);
        }
    }

    pub(super) fn redo(&mut self) {
        if let Some(later) = self.undoer.redo(&self.document.without_gaze()).cloned() {
            self.restore(later);
        }
    }

    pub(super) fn restore(&mut self, document: Document) {
        let Document { zoom, divider, ref scene, ref moment, .. } = self.document;
        // Another scene has other animations.
        let moment = moment.clone().filter(|_| *scene == document.scene);
        let focus_m = self.document.lens.focus_distance_m;
        self.document = Document { zoom, divider, moment, ..document };
        if self.document.focus.mode.follows() {
            self.document.lens.focus_distance_m = focus_m;
        }
        self.focus_motion.stop();
    }
}
