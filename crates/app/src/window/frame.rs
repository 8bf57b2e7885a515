//! One frame of the interface: what arrived, what is shown, what the pictures follow.

use super::App;
use super::engine::Wake;
use super::model::Theme;
use eframe::egui::{self, CentralPanel, ThemePreference, Ui};

impl App {
    /// Whether everything is shown as it will stay until something is changed.
    pub fn is_settled(&self) -> bool {
        self.started
            && self.loader.loading().is_none()
            && self.shows_what_is_named()
            && self.tasks.is_empty()
            && self.engine.wants_update_in().is_none()
            && self.eyes.wants_update_in().is_none()
            && !self.focus_motion.is_moving()
            && self.animating.is_at_rest()
            && self.viewport.is_at_rest()
            && self.engine.source().is_some()
    }

    /// One frame of the interface.
    pub fn show(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        self.take_in(&ctx);
        self.keys(&ctx);
        if !self.preferences.panels_hidden {
            self.top_bar(ui);
            self.status_bar(ui);
        }
        self.show_scale_offer(ui);
        self.animation_bar(ui);
        self.class_bars(ui);
        if !self.preferences.panels_hidden {
            self.controls(ui);
        }
        CentralPanel::no_frame().show(ui, |ui| self.show_panes(ui));
        // After the panels, which tell what the pictures of the last frame are.
        self.animate(&ctx);
        self.update_pictures(ui);
        self.hand_out_truths();
        self.show_feet(ui);
        self.show_help(&ctx);
        self.show_palette(&ctx);
        self.show_paper_form(&ctx);
        self.show_batch(&ctx);
        if let Some(answer) = self.dialogs.show(&ctx) {
            self.answer(&ctx, answer);
        }
        self.show_tasks(&ctx);
        self.messages.show(&ctx);
        self.feed_undo(&ctx);
        self.finish_frame(&ctx);
    }

    /// What arrived since the last frame: files, answers, complaints, a new theme.
    fn take_in(&mut self, ctx: &egui::Context) {
        if !self.started {
            ctx.set_zoom_factor(self.preferences.ui_scale.clamp(0.5, 4.0));
            let ctx = ctx.clone();
            self.engine.set_wake(Wake::with(move || ctx.request_repaint()));
        } else {
            // Ctrl and +, − or 0 change it too.
            self.preferences.ui_scale = ctx.zoom_factor();
        }
        self.started = true;
        let dropped = ctx.input(|i| i.raw.dropped_files.first().map(|f| f.path().to_owned()));
        if let Some(file) = dropped {
            self.open_anything(ctx, &file.to_string_lossy());
        }
        if !self.watched.take().is_empty()
            && let Some((spec, depth)) = self.loaded.clone()
        {
            self.loader.start(&spec, &depth, false, self.engine.gpu(), ctx);
        }
        self.take_in_loaded(ctx);
        self.load_what_is_named(ctx);
        self.prepare_lesson();
        self.reload_shaders(ctx);
        for trouble in self.engine.take_device_errors() {
            self.messages.error(ctx, &trouble);
        }
        if self.preferences.theme != self.applied_theme {
            self.applied_theme = self.preferences.theme;
            ctx.set_theme(match self.preferences.theme {
                Theme::System => ThemePreference::System,
                Theme::Light => ThemePreference::Light,
                Theme::Dark => ThemePreference::Dark,
            });
        }
    }

    /// Brings the pictures up to date with what was changed in this frame. They are
    /// painted after it, so that they follow the mouse without delay.
    pub(super) fn update_pictures(&mut self, ui: &Ui) {
        if self.shows_what_is_named() {
            self.update_engine(ui);
        } else {
            // For the lens that suits what is being opened.
            self.viewport.measure(ui.ctx().pixels_per_point());
        }
        self.register_textures(ui.ctx());
    }

    /// Whether the engine has what the document names.
    pub(super) fn shows_what_is_named(&self) -> bool {
        let wanted = (&self.document.scene, &self.document.depth);
        self.loaded.as_ref().is_some_and(|(scene, depth)| (scene, depth) == wanted)
    }

    /// Asks for another frame only where there is something to do in it.
    fn finish_frame(&mut self, ctx: &egui::Context) {
        let pauses = [self.engine.wants_update_in(), self.eyes.wants_update_in()];
        if let Some(pause) = pauses.into_iter().flatten().min() {
            ctx.request_repaint_after(pause);
        }
        let ready = self.is_settled();
        let failure = self.messages.last_error().or(self.viewport.problem());
        if let Some(screenshot) = &mut self.screenshot {
            screenshot.advance(ctx, ready, failure);
        }
    }
}
