//! The panel with what can be set: gathers what its groups are told, and does what they return.

use super::App;
use super::action::Action;
use super::engine::PassTimes;
use super::ui::groups::{
    ApertureView, LensView, PanelView, aperture_group, eye_group, lens_group, method_group, stereo_group, view_group,
};
use super::ui::panels::{LensReadings, OPTICS, VrReadings};
use super::ui::widgets::{group, group_about, revealed};
use super::ui::{style, timing};
use defocus::methods;
use eframe::egui::{Panel, RichText, ScrollArea, Ui, UiBuilder, vec2};
use glam::UVec2;

impl App {
    /// The panel on the right.
    pub(super) fn controls(&mut self, ui: &mut Ui) {
        let widths = style::PANEL_WIDTH..=440.0;
        Panel::right("controls").default_size(style::PANEL_WIDTH).size_range(widths).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                // What is wider than the panel is cut off: it would make the panel grow from
                // frame to frame, as sliders take what width there is.
                let outside = ui;
                let ui = &mut outside.new_child(UiBuilder::new());
                ui.spacing_mut().item_spacing.y = style::PANEL_SPACING;
                self.groups(ui);
                let height = ui.min_rect().height();
                outside.allocate_space(vec2(outside.available_width(), height));
            });
        });
    }

    /// What is always used, then the rest, which is folded until somebody unfolds it.
    fn groups(&mut self, ui: &mut Ui) {
        ui.add_space(2.0);
        self.lens_group(ui);
        self.method_group(ui);
        self.aperture_group(ui);
        self.eye_group(ui);
        self.view_group(ui);
        self.inspector.close();
        let reveal = self.inspector.take_reveal();
        revealed(ui, "Inspector", false, reveal, |ui| self.inspector(ui));
        self.stereo_group(ui);
        group(ui, "Timing", self.is_open_at_first("Timing"), |ui| self.timing_group(ui));
        // Below what one screen of 720 points has room for.
        self.kernel_group(ui);
        ui.add_space(2.0);
    }

    /// Whether a part of the panel is unfolded until somebody folds it, which is remembered.
    fn is_open_at_first(&self, title: &str) -> bool {
        self.preferences.open_groups.iter().any(|open| open == title)
    }

    fn lens_group(&mut self, ui: &mut Ui) {
        let is_scene = self.engine.source().is_some_and(|s| s.source().is_scene());
        self.lens_panel.optics_folded = !self.is_open_at_first(OPTICS);
        let readings = LensReadings {
            acceptable_px: f64::from(self.document.acceptable_coc_px),
            size_px: self.eye_size_px(),
            fov_x: self.engine.view().map(|view| view.projection().fov_x()),
            has_camera: is_scene,
            depths_m: self.engine.depths_m(false),
        };
        let view = LensView {
            lens: &self.document.lens,
            is_automatic: self.document.automatic_lens,
            focus: self.document.focus,
            is_anchored: self.focus_motion.is_anchored(),
            preferences: &self.preferences,
            readings,
        };
        let mut actions = Vec::new();
        let panel = &mut self.lens_panel;
        group(ui, "Lens", true, |ui| actions = lens_group(ui, &view, panel));
        self.perform_all(ui.ctx(), actions);
    }

    fn aperture_group(&mut self, ui: &mut Ui) {
        let view = ApertureView { aperture: &self.document.lens.aperture, panes: &self.document.panes };
        let mut actions = Vec::new();
        group(ui, "Aperture", self.is_open_at_first("Aperture"), |ui| actions = aperture_group(ui, &view));
        self.perform_all(ui.ctx(), actions);
    }

    fn eye_group(&mut self, ui: &mut Ui) {
        let title = "Eye and display";
        let settings = self.document.eye_settings();
        let mut action = None;
        group(ui, title, self.is_open_at_first(title), |ui| action = eye_group(ui, &settings));
        self.perform_all(ui.ctx(), action);
    }

    fn view_group(&mut self, ui: &mut Ui) {
        let size_px = self.eye_size_px();
        let view = PanelView {
            document: &self.document,
            preferences: &self.preferences,
            size_px,
            metered_ev: self.metered_ev,
        };
        let mut actions = Vec::new();
        group(ui, "View", self.is_open_at_first("View"), |ui| actions = view_group(ui, &view));
        self.perform_all(ui.ctx(), actions);
    }

    fn stereo_group(&mut self, ui: &mut Ui) {
        let readings = VrReadings {
            is_scene: self.engine.source().is_some_and(|s| s.source().is_scene()),
            focal_px: self.engine.view().map(|view| view.projection().focal_px),
            focus_m: self.document.lens.focus_distance_m,
            size_px: self.eye_size_px(),
        };
        let (stereo, lens) = (self.document.stereo, &self.document.lens);
        let mut actions = Vec::new();
        group(ui, "Stereo and headsets", false, |ui| actions = stereo_group(ui, stereo, lens, readings));
        self.perform_all(ui.ctx(), actions);
    }

    /// The parameters of pane A's method.
    fn method_group(&mut self, ui: &mut Ui) {
        let a = self.document.a;
        let number = self.document.index_of(a).map_or(1, |i| i + 1);
        let Some(pane) = self.document.pane(a) else { return };
        let Ok(about) = methods::by_id(&pane.method.id).map(|method| method.about()) else { return };
        let (title, help) =
            (format!("Pane {number}: {}", about.title), format!("{}\n\n{}", about.summary, about.limits));
        let mut action = None;
        group_about(ui, &title, &help, true, |ui| action = method_group(ui, pane));
        self.perform_all(ui.ctx(), action);
    }

    fn timing_group(&mut self, ui: &mut Ui) {
        let software = self.engine.gpu().is_software();
        let what = if software { "the processor's time" } else { "GPU time" };
        let help = format!("Draws pane A's picture six times beside the interface: medians of {what} of each pass.");
        if ui.button("Time passes").on_hover_text(help).clicked() {
            self.perform(ui.ctx(), Action::TimePasses);
        }
        if let Some(PassTimes { of, times, .. }) = self.engine.pass_times() {
            let UVec2 { x, y } = of.render.size;
            ui.label(RichText::new(format!("{}, {x} x {y} px: {what}", of.method.title())).small().weak());
            timing::show_passes(ui, times.as_ref());
        }
        timing::show(ui, &self.engine.history, self.engine.stats());
    }
}
