//! The panel with what can be set.

use super::App;
use super::action::Action;
use super::engine::PassTimes;
use super::model::Navigation;
use super::model::aperture_limit;
use super::model::{DEFAULT_OPACITY, Document, MethodChoice, Show};
use super::model::{GREATEST_SIDE_PX, LEAST_SIDE_PX, PictureSize};
use super::ui::panels::fit_slider;
use super::ui::panels::{
    ApertureChange, EyeSettings, Field, LensChanges, LensReadings, OPTICS, VrAction, VrReadings, aperture_panel,
    eye_panel, focus_panel, same_but_focus, vr_panel,
};
use super::ui::style::NAME_WIDTH;
use super::ui::widgets::{self, choice, group, number_of, revealed};
use super::ui::{style, timing};
use defocus::combine;
use defocus::display::ToneMap;
use defocus::methods::{self, Method};
use defocus::presets::presets;
use eframe::egui::{self, Panel, RichText, ScrollArea, Ui, UiBuilder, vec2};
use glam::UVec2;
use std::ops::RangeInclusive;

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
                ui.add_space(4.0);
                self.lens_group(ui);
                self.eye_group(ui);
                self.focus_group(ui);
                self.method_group(ui);
                group(ui, "View", self.is_open_at_first("View"), |ui| {
                    self.size_rows(ui);
                    self.view_group(ui);
                });
                self.inspector.close();
                let reveal = self.inspector.take_reveal();
                revealed(ui, "Inspector", false, reveal, |ui| self.inspector(ui));
                self.kernel_group(ui);
                self.vr_group(ui);
                group(ui, "Timing", self.is_open_at_first("Timing"), |ui| self.timing_group(ui));
                ui.add_space(8.0);
                let height = ui.min_rect().height();
                outside.allocate_space(vec2(outside.available_width(), height));
            });
        });
    }

    /// Whether a part of the panel is unfolded until somebody folds it, which is remembered.
    fn is_open_at_first(&self, title: &str) -> bool {
        self.preferences.open_groups.iter().any(|open| open == title)
    }

    fn lens_group(&mut self, ui: &mut Ui) {
        let size_px = self.eye_size_px();
        let is_scene = self.engine.source().is_some_and(|s| s.source().is_scene());
        let fov_x = self.engine.view().map(|view| view.projection().fov_x());
        let acceptable_px = f64::from(self.document.acceptable_coc_px);
        self.lens_panel.optics_folded = !self.is_open_at_first(OPTICS);
        let (lens, automatic) = (&mut self.document.lens, self.document.automatic_lens);
        let (panel, preferences) = (&mut self.lens_panel, &mut self.preferences);
        (panel.unit, panel.display_by_view) = (preferences.distance_unit, preferences.display_by_view);
        let depths_m = self.engine.depths_m(false);
        let mut changes = LensChanges::default();
        group(ui, "Lens", true, |ui| {
            let readings = LensReadings { depths_m, acceptable_px, size_px, fov_x, has_camera: is_scene };
            changes = panel.show(ui, lens, automatic, &mut preferences.own_lenses, readings);
        });
        (preferences.distance_unit, preferences.display_by_view) = (panel.unit, panel.display_by_view);
        self.take_lens_changes(changes);
        self.take_display_of(changes);
        let limits: Vec<String> = self.aperture_limits();
        let aperture = &mut self.document.lens.aperture;
        let mut change = ApertureChange::default();
        group(ui, "Aperture", false, |ui| {
            change = aperture_panel(ui, aperture);
            for limit in limits {
                ui.label(RichText::new(limit).small().color(ui.visuals().warn_fg_color));
            }
        });
        if change.wants_image {
            self.dialogs.open_aperture(ui.ctx());
        }
    }

    /// A lens that is a preset's brings its display's light with it.
    fn take_display_of(&mut self, changes: LensChanges) {
        if !changes.lens {
            return;
        }
        let lens = &self.document.lens;
        let shown = presets().into_iter().find(|preset| same_but_focus(&preset.lens, lens));
        let screen = shown.and_then(|preset| preset.screen);
        let document = &mut self.document;
        document.screen = screen.unwrap_or(document.screen);
        match &mut document.pupil {
            // A pupil that follows the light follows that of another display.
            Some(pupil) if screen.is_some() => {
                pupil.luminance_cd_m2 = document.screen.adapting_cd_m2();
                document.lens.aperture_diameter_mm = pupil.diameter_mm();
            }
            // An E that is set by hand does not follow any more.
            Some(pupil) if pupil.diameter_mm() != document.lens.aperture_diameter_mm => document.pupil = None,
            _ => {}
        }
    }

    fn eye_group(&mut self, ui: &mut Ui) {
        let document = &mut self.document;
        let settings = EyeSettings {
            lens: &mut document.lens,
            pupil: &mut document.pupil,
            age_years: &mut document.age_years,
            screen: &mut document.screen,
            ppd: &mut document.ppd,
        };
        let mut changed = false;
        group(ui, "Eye and display", false, |ui| changed = eye_panel(ui, settings));
        if changed {
            self.document.automatic_lens = false;
        }
    }

    fn timing_group(&mut self, ui: &mut Ui) {
        let software = self.engine.gpu().is_software();
        let what = if software { "the processor's time" } else { "GPU time" };
        let help = format!("Draws pane A's picture six times beside the interface: medians of {what} of each pass.");
        if ui.button("Time passes").on_hover_text(help).clicked() {
            self.perform(ui.ctx(), Action::TimePasses);
        }
        if let Some(PassTimes { of, times, .. }) = self.engine.pass_times() {
            let UVec2 { x, y } = of.exposure.size;
            ui.label(RichText::new(format!("{}, {x} x {y} px: {what}", of.method.title())).small().weak());
            timing::show_passes(ui, times.as_ref());
        }
        timing::show(ui, &self.engine.history, self.engine.stats());
    }

    /// What the panes' methods cannot show of the aperture, each method once.
    fn aperture_limits(&self) -> Vec<String> {
        let panes = self.document.panes.iter();
        let mut limits: Vec<String> =
            panes.filter_map(|pane| aperture_limit(&pane.method, &self.document.lens.aperture)).collect();
        limits.dedup();
        limits
    }

    fn take_lens_changes(&mut self, changes: LensChanges) {
        if changes.lens {
            self.document.automatic_lens = false;
        }
        if changes.focus {
            self.focus_motion.stop();
        }
        if changes.suit_scene {
            self.suit_lens();
        }
        let size_px = self.eye_size_px();
        if let (Some(fov_x), Some(camera)) = (changes.camera_fov_x, &mut self.document.camera) {
            *camera = camera.with_fov_x(size_px, fov_x);
        }
    }

    fn focus_group(&mut self, ui: &mut Ui) {
        let anchored = self.focus_motion.is_anchored();
        let before = self.document.focus.mode;
        group(ui, "Focus", true, |ui| focus_panel(ui, &mut self.document.focus, anchored));
        if self.document.focus.mode != before {
            self.focus_motion.stop();
        }
    }

    fn vr_group(&mut self, ui: &mut Ui) {
        let readings = VrReadings {
            is_scene: self.engine.source().is_some_and(|s| s.source().is_scene()),
            focal_px: self.engine.view().map(|view| view.projection().focal_px),
            focus_m: self.document.lens.focus_distance_m,
            size_px: self.eye_size_px(),
        };
        let mut action = None;
        group(ui, "Stereo and headsets", false, |ui| {
            action = vr_panel(ui, &mut self.document.stereo, &self.document.lens, readings);
        });
        if let Some(VrAction::PictureSize(width, height)) = action {
            self.resize_picture(PictureSize::Pixels(width, height));
        }
    }

    /// The parameters of pane A's method.
    fn method_group(&mut self, ui: &mut Ui) {
        let a = self.document.a;
        let number = self.document.index_of(a).map_or(1, |i| i + 1);
        let Some(pane) = self.document.pane_mut(a) else { return };
        let choice = &mut pane.method;
        let Ok(mut method) = choice.build() else { return };
        let about = method.about();
        group(ui, &format!("Pane {number}: {}", about.title), true, |ui| {
            ui.label(RichText::new(about.summary).small().weak());
            if as_published_row(ui, method.as_ref(), choice) {
                return;
            }
            let mut changes = Vec::new();
            let mut plain = methods::by_id(about.id).ok();
            let defaults = plain.iter_mut().flat_map(|plain| plain.params());
            let defaults: Vec<Option<f64>> = defaults.map(|param| number_of(&param)).collect();
            for (param, default) in method.params().into_iter().zip(defaults) {
                ui.push_id(param.key, |ui| {
                    let key = param.key;
                    if widgets::param(ui, param, default) {
                        changes.push(key);
                    }
                });
            }
            for param in method.params().iter().filter(|p| changes.contains(&p.key)) {
                choice.params.insert(param.key.into(), param.text());
            }
            if !choice.params.is_empty() && ui.button("Defaults").on_hover_text("All parameters as they were").clicked()
            {
                *choice = MethodChoice::new(about.id);
            }
        });
    }

    /// How large the picture is.
    fn size_rows(&mut self, ui: &mut Ui) {
        let size = self.document.size;
        let px = self.eye_size_px();
        // Before there is something to see it has no size.
        if px.min_element() == 0 {
            return;
        }
        if let Some(chosen) = size_rows(ui, size, px) {
            self.resize_picture(chosen);
        }
    }

    fn view_group(&mut self, ui: &mut Ui) {
        let (document, preferences) = (&mut self.document, &mut self.preferences);
        let mut tone_map = ToneMap::ALL.iter().position(|t| *t == document.display.tone_map).unwrap_or(0);
        let mut exposure = f64::from(document.display.exposure_ev);
        let field = Field {
            name: "Exposure",
            help: "Brightness, as a power of two.",
            unit: " EV",
            range: -6.0..=6.0,
            log: None,
            reset: Some(0.0),
        };
        if field.show(ui, &mut exposure) {
            document.display.exposure_ev = exposure.clamp(-20.0, 20.0) as f32;
        }
        let names = ["None", "Reinhard", "AgX"];
        if choice(ui, "Tone map", "How bright light is brought into the display's range.", &mut tone_map, &names) {
            document.display.tone_map = ToneMap::ALL[tone_map];
        }
        let names = combine::Channel::ALL.map(|(_, name)| name);
        let mut channel = combine::Channel::ALL.iter().position(|(c, _)| *c == document.channel).unwrap_or(0);
        if choice(ui, "Channel", "Which channels of pictures are shown, each as grey.", &mut channel, &names) {
            document.channel = combine::Channel::ALL[channel].0;
        }
        let usual = Document::default();
        let px = |name, help, range: RangeInclusive<f64>, reset: f32| {
            let (log, reset) = (Some(*range.start()), Some(f64::from(reset)));
            Field { name, help, unit: " px", range, log, reset }
        };
        let mut acceptable = f64::from(document.acceptable_coc_px);
        let help = "Greatest circle of confusion that counts as sharp: decides where the depth of field ends.";
        if px("Sharp up to", help, 0.25..=16.0, usual.acceptable_coc_px).show(ui, &mut acceptable) {
            document.acceptable_coc_px = acceptable.clamp(0.01, 1000.0) as f32;
        }
        if document.panes.iter().any(|p| p.show == Show::Coc) {
            let help =
                "The colour map reaches as far as the circle of confusion of the picture; off, as far as is set.";
            widgets::row(ui, "CoC scale fits", help, |ui| ui.checkbox(&mut document.coc_scale_fits, ""));
        }
        if document.panes.iter().any(|p| p.show == Show::Coc) && !document.coc_scale_fits {
            let mut scale = f64::from(document.coc_scale_px);
            let help = "Circle of confusion at the ends of the colour map.";
            if px("CoC scale", help, 1.0..=128.0, usual.coc_scale_px).show(ui, &mut scale) {
                document.coc_scale_px = scale.clamp(0.01, 10_000.0) as f32;
            }
        }
        let a = document.a;
        if let Some(pane) = document.pane_mut(a).filter(|p| matches!(p.show, Show::Coc | Show::Depth | Show::Inside(_)))
        {
            overlay_opacity(ui, &mut pane.opacity);
        }
        let mut navigation = usize::from(preferences.navigation == Navigation::Fly);
        let help =
            "Orbit: dragging moves around what is seen. Fly: dragging turns on the spot. W A S D Q E fly in both.";
        if choice(ui, "Navigation", help, &mut navigation, &["Orbit", "Fly"]) {
            preferences.navigation = if navigation == 1 { Navigation::Fly } else { Navigation::Orbit };
        }
        let help = "Focus moves to where one clicks in a quarter of a second, instead of at once.";
        widgets::row(ui, "Smooth focus", help, |ui| ui.checkbox(&mut preferences.smooth_focus, ""));
        let help = "Margin drawn around the picture, from which blur comes in over the border.";
        widgets::row(ui, "Overscan", help, |ui| {
            fit_slider(ui);
            ui.add(egui::Slider::new(&mut document.overscan_px, 0..=96).suffix(" px"))
        });
    }
}

/// The sizes that are offered, and the pixels of one that is typed; what was chosen.
/// `px`: the size that there is.
fn size_rows(ui: &mut Ui, size: PictureSize, px: UVec2) -> Option<PictureSize> {
    let offered = PictureSize::offered();
    let mut names: Vec<&str> = offered.iter().map(|(name, _)| name.as_str()).collect();
    names.push("Other");
    let before = offered.iter().position(|(_, known)| *known == size).unwrap_or(offered.len());
    let mut chosen = before;
    let help = "Pixels of the picture, of each eye's where there are two. Panes show it fitted in or magnified: how they lie changes neither the picture nor what is measured, unless it is to be as large as the window.";
    choice(ui, "Picture size", help, &mut chosen, &names);
    let (mut width, mut height) = (px.x, px.y);
    let mut is_typed = false;
    ui.horizontal(|ui| {
        let mut side = |ui: &mut Ui, name: &str, side: &mut u32| {
            // What is there stays as it is until it is changed here.
            let drag =
                egui::DragValue::new(side).range(LEAST_SIDE_PX..=GREATEST_SIDE_PX).clamp_existing_to_range(false);
            let drag = ui.add(drag.suffix(" px").update_while_editing(false));
            is_typed |= drag.changed();
            drag.accessible_name(name).on_hover_text(name.to_owned());
        };
        ui.add_space(NAME_WIDTH + ui.spacing().item_spacing.x);
        side(ui, "Picture width", &mut width);
        ui.label("x");
        side(ui, "Picture height", &mut height);
    });
    match offered.get(chosen).filter(|_| chosen != before) {
        Some((_, size)) => Some(*size),
        None if chosen != before || is_typed => Some(PictureSize::Pixels(width, height)),
        None => None,
    }
}

/// How much the overlay of pane A hides of the picture.
fn overlay_opacity(ui: &mut Ui, opacity: &mut f32) {
    let field = Field {
        name: "Overlay opacity",
        help: "How much the overlay of pane A hides of the picture, which is grey under it; 100 % is the overlay alone.",
        unit: " %",
        range: 0.0..=100.0,
        log: None,
        reset: Some(100.0 * f64::from(DEFAULT_OPACITY)),
    };
    let mut percent = 100.0 * f64::from(*opacity);
    if field.show(ui, &mut percent) {
        *opacity = (0.01 * percent).clamp(0.0, 1.0) as f32;
    }
}

/// The switch of a method whose defaults go beyond what its source published: on, it is exactly
/// that, and off, those parameters are at their defaults. True if it was changed.
fn as_published_row(ui: &mut Ui, method: &dyn Method, choice: &mut MethodChoice) -> bool {
    let Some(mut is_on) = methods::is_as_published(method) else { return false };
    let help = "What was published, with its constants and choices, instead of what does better since";
    let changed = ui.checkbox(&mut is_on, "As published").on_hover_text(help).changed();
    if changed {
        for param in method.boxed().params() {
            match param.published {
                Some(value) if is_on => drop(choice.params.insert(param.key.into(), value.into())),
                Some(_) => drop(choice.params.remove(param.key)),
                None => {}
            }
        }
    }
    changed
}
