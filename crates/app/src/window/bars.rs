//! The bar above the panes and the line below them.

use super::action::Action;
use super::model::Arrangement;
use super::model::Numbers;
use super::model::PictureKind;
use super::model::Theme;
use super::model::numbers::significant;
use super::model::{LESSONS, UI_SCALES, scale_name};
use super::ui::panels::{distance_text, refresh_text};
use super::ui::widgets::combo;
use super::{App, MAX_PANES};
use defocus_study::builtin;
use eframe::egui::{self, Align, Button, Label, Layout, Panel, RichText, Ui};

/// Width from which the bar fits into one row, points; two rows fit into the least width of
/// the window.
const ONE_ROW: f32 = 1030.0;

/// Width of the lists of scenes and cameras, points: the built-in names have room.
const SCENES: f32 = 104.0;

/// Width of the list of cameras with its name, points.
const CAMERAS: f32 = 180.0;

impl App {
    /// File, scene and camera; the panes; undo; what is rarely needed at the right.
    pub(super) fn top_bar(&mut self, ui: &mut Ui) {
        let frame = egui::Frame::side_top_panel(ui.style()).inner_margin(egui::Margin::symmetric(8, 6));
        Panel::top("top").frame(frame).show(ui, |ui| {
            let cameras = self.engine.source().map_or(0, |s| s.source().cameras().len());
            let one_row = if cameras > 1 { ONE_ROW + CAMERAS } else { ONE_ROW };
            if ui.available_width() >= one_row {
                ui.horizontal(|ui| {
                    self.left_end(ui);
                    ui.separator();
                    self.middle(ui);
                    ui.with_layout(Layout::right_to_left(Align::Center), |ui| self.right_end(ui));
                });
            } else {
                ui.horizontal(|ui| {
                    self.left_end(ui);
                    ui.with_layout(Layout::right_to_left(Align::Center), |ui| self.right_end(ui));
                });
                ui.horizontal(|ui| self.middle(ui));
            }
        });
    }

    fn left_end(&mut self, ui: &mut Ui) {
        ui.menu_button("File", |ui| self.file_menu(ui)).response.on_hover_text("Open and save");
        let help = "Full screen, the picture alone, size of the interface";
        ui.menu_button("View", |ui| self.view_menu(ui)).response.on_hover_text(help);
        ui.menu_button("Lessons", |ui| self.lessons_menu(ui)).response.on_hover_text("The findings, one by one");
        self.scene_list(ui);
        self.camera_list(ui);
    }

    fn middle(&mut self, ui: &mut Ui) {
        self.pane_buttons(ui);
        ui.separator();
        self.undo_buttons(ui);
    }

    fn right_end(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        let help = ui.add(Button::new("?").frame(false));
        if help.accessible_name("Keys and mouse").on_hover_text("Keys and mouse (?)").clicked() {
            self.perform(&ctx, Action::Help);
        }
        self.theme_button(ui);
        if ui.button("Commands").on_hover_text("Find anything by its name (Ctrl+P)").clicked() {
            self.perform(&ctx, Action::Palette);
        }
    }

    fn file_menu(&mut self, ui: &mut Ui) {
        let a = self.document.a;
        self.entry(ui, "Open…", Action::Open);
        let recent: Vec<String> =
            self.preferences.recent.iter().map(|file| file.to_string_lossy().into_owned()).collect();
        ui.add_enabled_ui(!recent.is_empty(), |ui| {
            ui.menu_button("Recent", |ui| {
                for file in &recent {
                    self.entry(ui, file, Action::OpenNamed(file.clone()));
                }
            });
        });
        ui.separator();
        self.entry(ui, "Save state…", Action::SaveState);
        self.entry(ui, "Save picture as PNG…", Action::SavePicture(a, PictureKind::Png));
        self.entry(ui, "Save picture as EXR…", Action::SavePicture(a, PictureKind::Exr));
        self.entry(ui, "Save comparison as HTML…", Action::SaveReport);
        self.entry(ui, "Figures for a paper…", Action::FiguresForPaper);
        ui.menu_button("Save numbers", |ui| {
            self.entry(ui, "Figures as CSV…", Action::SaveNumbers(Numbers::FiguresCsv));
            self.entry(ui, "Figures as JSON with the state…", Action::SaveNumbers(Numbers::FiguresJson));
            self.entry(ui, "CoC against depth as CSV…", Action::SaveNumbers(Numbers::Coc));
        });
        self.entry(ui, "Batch…", Action::Batch);
        ui.separator();
        self.entry(ui, "Copy image", Action::CopyImage(a));
        self.entry(ui, "Copy as command", Action::CopyCommand);
    }

    fn view_menu(&mut self, ui: &mut Ui) {
        self.entry(ui, "Full screen", Action::ToggleFullScreen);
        self.entry(ui, "Hide the panels", Action::TogglePanels);
        ui.separator();
        let has_messages = self.messages.told().next().is_some();
        ui.add_enabled_ui(has_messages, |ui| {
            ui.menu_button("Messages", |ui| self.messages_menu(ui));
        });
        ui.separator();
        let now = ui.ctx().zoom_factor();
        for scale in UI_SCALES {
            let name = scale_name(scale);
            if ui.selectable_label((now - scale).abs() < 0.01, name).clicked() {
                self.perform(ui.ctx(), Action::ScaleInterface(scale));
                ui.close();
            }
        }
    }

    /// What was approximated or left out of the file, to be read at a click.
    fn notes_menu(&self, ui: &mut Ui) {
        let notes = self.engine.source().map(|s| s.source().notes().to_vec()).unwrap_or_default();
        if notes.is_empty() {
            return;
        }
        let title = if notes.len() == 1 { "1 note".to_owned() } else { format!("{} notes", notes.len()) };
        let button = ui.menu_button(RichText::new(title).small(), |ui| {
            ui.set_max_width(420.0);
            for note in &notes {
                ui.label(note);
            }
        });
        button.response.on_hover_text("What was approximated or left out of the file");
    }

    /// What was told before: a message that has gone can be read again, and copied.
    fn messages_menu(&mut self, ui: &mut Ui) {
        ui.set_max_width(420.0);
        for text in self.messages.told() {
            let button = ui.add(Button::new(text).wrap());
            if button.on_hover_text("Copies it").clicked() {
                ui.ctx().copy_text(text.to_owned());
                ui.close();
            }
        }
    }

    fn lessons_menu(&mut self, ui: &mut Ui) {
        for (index, lesson) in LESSONS.iter().enumerate() {
            self.entry(ui, &format!("{}: {}", index + 1, lesson.title), Action::Lesson(index));
        }
    }

    fn entry(&mut self, ui: &mut Ui, name: &str, action: Action) {
        let keys = self.commands().into_iter().find(|c| c.action == action).and_then(|c| c.keys);
        let mut button = Button::new(name);
        if let Some(keys) = keys {
            button = button.shortcut_text(ui.ctx().format_shortcut(&keys));
        }
        if ui.add(button).clicked() {
            self.perform(ui.ctx(), action);
            ui.close();
        }
    }

    fn scene_list(&mut self, ui: &mut Ui) {
        let mut names: Vec<&str> = builtin::all().iter().map(|b| b.name).collect();
        names.extend(builtin::pictures().iter().map(|p| p.name));
        let known = names.len();
        let spec = self.loader.loading().unwrap_or(&self.document.scene).to_owned();
        let file = std::path::Path::new(&spec).file_name().map(|f| f.to_string_lossy().into_owned());
        let mut chosen = names.iter().position(|name| *name == spec).unwrap_or(known);
        if let (true, Some(file)) = (chosen == known, &file) {
            names.push(file);
        }
        let before = chosen;
        let label = ui.label("Scene");
        let notes = self.engine.source().map(|s| s.source().notes().join("\n\n")).filter(|n| !n.is_empty());
        let list = combo(ui, "scene", &mut chosen, &names, SCENES).labelled_by(label.id);
        if let Some(notes) = notes {
            list.on_hover_text(notes);
        }
        if chosen != before && chosen < known {
            let name = names[chosen].to_owned();
            self.perform(ui.ctx(), Action::OpenNamed(name));
        }
    }

    fn camera_list(&mut self, ui: &mut Ui) {
        let Some(source) = self.engine.source().map(|s| s.source().clone()) else { return };
        if !source.is_scene() {
            return;
        }
        let names = source.cameras();
        let mut chosen = self.document.camera_index.min(names.len() - 1);
        if names.len() > 1 {
            let before = chosen;
            let label = ui.label("Camera");
            combo(ui, "camera", &mut chosen, &names, SCENES).labelled_by(label.id);
            if chosen != before {
                self.choose_camera(chosen);
            }
        }
        if ui.button("Reset").on_hover_text("The camera as the scene has it (R)").clicked() {
            self.choose_camera(chosen);
        }
    }

    fn pane_buttons(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        let count = self.document.panes.len();
        let help = "Another method beside the truth (V)";
        if ui.button("Compare").on_hover_text(help).clicked() {
            self.perform(&ctx, Action::Compare);
        }
        let add = ui.add_enabled(count < MAX_PANES, Button::new("+ Pane"));
        if add.accessible_name("Add pane").on_hover_text("One more pane, up to six (N)").clicked() {
            self.perform(&ctx, Action::AddPane);
        }
        ui.add_enabled_ui(count > 1, |ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            for (arrangement, name, help) in Arrangement::ALL {
                let chosen = count > 1 && self.document.arrangement == arrangement;
                if ui.selectable_label(chosen, name).on_hover_text(help).clicked() {
                    self.perform(&ctx, Action::Arrange(arrangement));
                }
            }
            if ui.button("Even").on_hover_text("All panes side by side and about the same size").clicked() {
                self.perform(&ctx, Action::ResetPanes);
            }
        });
        let mut measure = self.document.measure;
        let help = "PSNR, SSIM and FLIP against the reference, which converges unseen where no pane shows it (M)";
        if ui.toggle_value(&mut measure, "Figures").on_hover_text(help).changed() {
            self.perform(&ctx, Action::Measure);
        }
    }

    fn undo_buttons(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        let now = self.document.without_gaze();
        let (can_undo, can_redo) = (self.undoer.has_undo(&now), self.undoer.has_redo(&now));
        if ui.add_enabled(can_undo, Button::new("Undo")).on_hover_text("Ctrl+Z").clicked() {
            self.perform(&ctx, Action::Undo);
        }
        if ui.add_enabled(can_redo, Button::new("Redo")).on_hover_text("Ctrl+Shift+Z").clicked() {
            self.perform(&ctx, Action::Redo);
        }
    }

    fn theme_button(&mut self, ui: &mut Ui) {
        let (next, symbol, name) = match self.preferences.theme {
            Theme::System => (Theme::Light, "Auto", "Theme: as the system has it"),
            Theme::Light => (Theme::Dark, "Light", "Theme: light"),
            Theme::Dark => (Theme::System, "Dark", "Theme: dark"),
        };
        let response = ui.add(Button::new(symbol));
        if response.accessible_name("Theme").on_hover_text(name).clicked() {
            self.preferences.theme = next;
        }
    }

    /// What the lens does to this view, what it costs and where it runs.
    pub(super) fn status_bar(&mut self, ui: &mut Ui) {
        let frame = egui::Frame::side_top_panel(ui.style()).inner_margin(egui::Margin::symmetric(8, 4));
        Panel::bottom("status").frame(frame).show(ui, |ui| {
            ui.horizontal(|ui| {
                let size = self.eye_size_px();
                let help = "Size of the picture, of each eye's where there are two; View has others";
                if size.min_element() > 0 {
                    item(ui, "picture", &format!("{} x {} px", size.x, size.y), help);
                }
                let lens = self.document.lens.clone();
                let px = |v: f64| format!("{} px", significant(v));
                let k = if lens.check().is_ok() { px(lens.k_px()) } else { "–".into() };
                item(ui, "K", &k, "Circle of confusion of what is infinitely far away");
                let depths = self.engine.depths_m(false);
                if let Some(coc) = depths.and_then(|d| lens.coc_statistics(d.iter().copied())) {
                    item(ui, "CoC mean", &px(coc.mean_px), "Mean diameter of the circle of confusion over the picture");
                    item(ui, "95 %", &px(coc.p95_px), "95 % of the picture have a smaller circle of confusion");
                }
                if lens.check().is_ok() {
                    let (near, far) = lens.depth_of_field_m(f64::from(self.document.acceptable_coc_px));
                    let range = format!("{} – {}", distance_text(near), distance_text(far));
                    let help =
                        format!("Depths with a circle of confusion up to {} px", self.document.acceptable_coc_px);
                    item(ui, "sharp", &range, &help);
                }
                if let Some(ms) = self.both_eyes_ms() {
                    let each = significant(ms);
                    let (w, h) = (size.x, size.y);
                    let help = format!("Pane A's method takes {each} ms for the two eyes of a headset at {w} x {h} px each; Stereo and headsets gives the picture a headset's size");
                    item(ui, "two eyes", &refresh_text(ms), &help);
                } else if self.engine.gpu().is_software() {
                    let help =
                        "Whether two eyes' frames keep up with a headset is told where a graphics card draws them.";
                    item(ui, "two eyes", "software adapter: not judged", help);
                }
                let stats = self.engine.stats();
                let drawn = format!("{} triangles, {} passes", stats.triangles, stats.passes);
                item(ui, "last frame", &drawn, &skipped(stats));
                self.notes_menu(ui);
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

fn skipped(stats: &defocus::gpu::FrameStats) -> String {
    if stats.skipped.is_empty() {
        return "Nothing could be skipped".into();
    }
    let skipped: Vec<_> = stats.skipped.iter().map(|(what, times)| format!("{what} ({times})")).collect();
    format!("Skipped: {}", skipped.join(", "))
}
