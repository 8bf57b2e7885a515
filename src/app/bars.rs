//! The bar above the picture and the line below it.

use super::App;
use super::settings::{MethodChoice, Show, Theme};
use super::widgets::{combo, significant};
use crate::methods;
use crate::scene::builtin;
use eframe::egui::{self, Align, Button, Label, Layout, Panel, RichText, Ui};

impl App {
    /// Scene, camera, methods, and what is shown.
    pub(super) fn top_bar(&mut self, ui: &mut Ui) {
        let frame = egui::Frame::side_top_panel(ui.style()).inner_margin(egui::Margin::symmetric(8, 6));
        Panel::top("top").frame(frame).show(ui, |ui| {
            ui.horizontal(|ui| {
                self.scene_list(ui);
                ui.separator();
                self.method_lists(ui);
                ui.separator();
                self.show_list(ui);
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    if ui.add(Button::new("?").frame(false)).on_hover_text("Keys and mouse").clicked() {
                        self.help = !self.help;
                    }
                    self.theme_button(ui);
                });
            });
        });
    }

    fn scene_list(&mut self, ui: &mut Ui) {
        let builtins = builtin::all();
        let mut names: Vec<&str> = builtins.iter().map(|b| b.name).collect();
        let spec = self.loader.loading().unwrap_or(&self.settings.scene).to_owned();
        let file = std::path::Path::new(&spec).file_name().map(|f| f.to_string_lossy().into_owned());
        let mut chosen = names.iter().position(|name| *name == spec).unwrap_or(names.len());
        if let (true, Some(file)) = (chosen == names.len(), &file) {
            names.push(file);
        }
        let before = chosen;
        let label = ui.label("Scene");
        let notes = self.engine.source().map(|s| s.source().notes().join("\n\n")).filter(|n| !n.is_empty());
        let list = combo(ui, "scene", &mut chosen, &names, 84.0).labelled_by(label.id);
        if let Some(notes) = notes {
            list.on_hover_text(notes);
        }
        if let (true, Some(builtin)) = (chosen != before, builtins.get(chosen)) {
            self.open(ui.ctx(), builtin.name);
        }
        let help = "A glTF scene (.glb, .gltf) or an image with depth (.exr). Files can be dropped on the window too.";
        if ui.button("Open…").on_hover_text(help).clicked() {
            self.dialog.show(ui.ctx());
        }
        self.camera_list(ui);
    }

    fn camera_list(&mut self, ui: &mut Ui) {
        let Some(source) = self.engine.source().map(|s| s.source().clone()) else { return };
        if !source.is_scene() {
            return;
        }
        let names = source.cameras();
        let mut chosen = self.settings.camera_index.min(names.len() - 1);
        if names.len() > 1 {
            let before = chosen;
            let label = ui.label("Camera");
            combo(ui, "camera", &mut chosen, &names, 84.0).labelled_by(label.id);
            if chosen != before {
                self.choose_camera(chosen);
            }
        }
        if ui.button("Reset").on_hover_text("The camera as the scene has it (R)").clicked() {
            self.choose_camera(chosen);
        }
    }

    fn method_lists(&mut self, ui: &mut Ui) {
        let about: Vec<_> = methods::all().iter().map(|m| m.about()).collect();
        let titles: Vec<&str> = about.iter().map(|a| a.title).collect();
        for pane in 0..self.settings.methods.len() {
            let id = &self.settings.methods[pane].id;
            let before = about.iter().position(|a| a.id == id).unwrap_or(about.len());
            let mut chosen = before;
            let name = if pane == 0 { "Method" } else { "B" };
            let label = ui.label(name);
            let help =
                about.get(chosen).map_or_else(String::new, |a| format!("{}\n\n{}\n\n{}", a.summary, a.limits, a.paper));
            combo(ui, name, &mut chosen, &titles, 136.0).labelled_by(label.id).on_hover_text(help);
            if let (true, Some(about)) = (chosen != before, about.get(chosen)) {
                self.settings.methods[pane] = MethodChoice::new(about.id);
            }
        }
        let mut compare = self.settings.methods.len() > 1;
        let help = "Two methods side by side; the divider can be dragged.";
        if ui.toggle_value(&mut compare, "Compare").on_hover_text(help).changed() {
            self.set_comparing(compare);
        }
    }

    fn show_list(&mut self, ui: &mut Ui) {
        let names: Vec<&str> = Show::ALL.iter().map(|(_, name)| *name).collect();
        let before = Show::ALL.iter().position(|(show, _)| *show == self.settings.show).unwrap_or(0);
        let mut chosen = before;
        let label = ui.label("Show");
        combo(ui, "show", &mut chosen, &names, 120.0).labelled_by(label.id);
        if chosen != before {
            self.settings.show = Show::ALL[chosen].0;
            if self.settings.show == Show::Difference {
                self.set_comparing(true);
            }
        }
    }

    /// Shows two methods, the second at first the truth where the scene has one; or one.
    pub(super) fn set_comparing(&mut self, compare: bool) {
        let methods = &mut self.settings.methods;
        if compare && methods.len() == 1 {
            let is_scene = self.engine.source().is_some_and(|s| s.source().is_scene());
            methods.push(MethodChoice::new(if is_scene { "accumulation" } else { "pinhole" }));
        } else if !compare {
            methods.truncate(1);
            if self.settings.show == Show::Difference {
                self.settings.show = Show::Picture;
            }
        }
    }

    fn theme_button(&mut self, ui: &mut Ui) {
        let (next, symbol, name) = match self.settings.theme {
            Theme::System => (Theme::Light, "Auto", "Theme: as the system has it"),
            Theme::Light => (Theme::Dark, "Light", "Theme: light"),
            Theme::Dark => (Theme::System, "Dark", "Theme: dark"),
        };
        let response = ui.add(Button::new(symbol));
        if response.accessible_name("Theme").on_hover_text(name).clicked() {
            self.settings.theme = next;
        }
    }

    /// What the lens does to this view, what it costs and where it runs.
    pub(super) fn status_bar(&mut self, ui: &mut Ui) {
        let frame = egui::Frame::side_top_panel(ui.style()).inner_margin(egui::Margin::symmetric(8, 4));
        Panel::bottom("status").frame(frame).show(ui, |ui| {
            ui.horizontal(|ui| {
                let lens = self.settings.lens.clone();
                let px = |v: f64| format!("{} px", significant(v));
                item(ui, "K", &px(lens.k_px()), "Circle of confusion of what is infinitely far away");
                let depths = self.engine.depths_m(false);
                if let Some(coc) = depths.and_then(|d| lens.coc_statistics(d.iter().copied())) {
                    item(ui, "CoC mean", &px(coc.mean_px), "Mean diameter of the circle of confusion over the picture");
                    item(ui, "95 %", &px(coc.p95_px), "95 % of the picture have a smaller circle of confusion");
                }
                if lens.check().is_ok() {
                    let (near, far) = lens.depth_of_field_m(f64::from(self.settings.acceptable_coc_px));
                    let range = format!("{} – {} m", significant(near), significant(far));
                    let help =
                        format!("Depths with a circle of confusion up to {} px", self.settings.acceptable_coc_px);
                    item(ui, "sharp", &range, &help);
                }
                let stats = self.engine.stats();
                let drawn = format!("{} triangles, {} passes", stats.triangles, stats.passes);
                item(ui, "last frame", &drawn, &skipped(stats));
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    let adapter = self.engine.gpu().adapter();
                    let help = format!("{} ({}, {})", adapter.name, adapter.backend, adapter.driver);
                    let name = RichText::new(&adapter.name).small().weak();
                    ui.add(Label::new(name).truncate()).on_hover_text(help);
                });
            });
        });
    }
}

fn item(ui: &mut Ui, name: &str, value: &str, help: &str) {
    ui.spacing_mut().item_spacing.x = 4.0;
    ui.label(RichText::new(name).small().weak());
    ui.label(RichText::new(value).small()).on_hover_text(help);
    ui.add_space(10.0);
}

fn skipped(stats: &crate::gpu::FrameStats) -> String {
    if stats.skipped.is_empty() {
        return "Nothing could be skipped".into();
    }
    let skipped: Vec<_> = stats.skipped.iter().map(|(what, times)| format!("{what} ({times})")).collect();
    format!("Skipped: {}", skipped.join(", "))
}
