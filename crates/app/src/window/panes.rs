//! The panes: how they lie, and the head and foot of each.

use super::engine::{Figures, FrameTime, Measured, PaneMetrics};
use super::model::numbers::significant;
use super::model::{Arrangement, Edit, Inside, PaneId, Show, tree_of};
use super::model::{aperture_limit, astigmatism_limit};
use super::ui::details::Exposed;
use super::ui::groups::{difference_edit, inside_edits};
use super::ui::widgets::combo;
use super::{App, action::Action, ui::style};
use defocus::gpu::Texture;
use defocus::methods;
use defocus_study::metrics::Visibility;
use eframe::egui::{
    self, Align, Button, Color32, CornerRadius, Label, Layout, Rect, RichText, Role, Sense, Stroke, Ui, UiBuilder,
    WidgetInfo, WidgetText, pos2, vec2,
};
use egui_tiles::{Behavior, EditAction, SimplificationOptions, TileId, UiResponse};

/// Height of a pane's head, and of each row of it, points.
const HEAD: f32 = 30.0;

/// Height of a pane's foot, points.
const FOOT: f32 = 22.0;

/// Greatest width of the list of methods in a head, points: the longest name has room.
const METHOD_WIDTH: f32 = 200.0;

/// Greatest width of the list of what is shown, points.
const SHOWN_WIDTH: f32 = 165.0;

/// A pane with less room than this has no head and no foot, points.
const LEAST: f32 = 90.0;

struct Tiles<'a> {
    app: &'a mut App,
    edited: bool,
}

impl Behavior<PaneId> for Tiles<'_> {
    fn pane_ui(&mut self, ui: &mut Ui, _: TileId, pane: &mut PaneId) -> UiResponse {
        match self.app.pane_ui(ui, &[*pane]) {
            true => UiResponse::DragStarted,
            false => UiResponse::None,
        }
    }

    fn tab_title_for_pane(&mut self, pane: &PaneId) -> WidgetText {
        let title = self.app.document.pane(*pane).map_or_else(String::new, |p| p.method.title());
        format!("{pane}: {title}").into()
    }

    fn gap_width(&self, _: &egui::Style) -> f32 {
        3.0
    }

    fn min_size(&self) -> f32 {
        64.0
    }

    fn simplification_options(&self) -> SimplificationOptions {
        SimplificationOptions { all_panes_must_have_tabs: false, ..Default::default() }
    }

    fn retain_pane(&mut self, pane: &PaneId) -> bool {
        self.app.document.pane(*pane).is_some()
    }

    fn on_edit(&mut self, _: EditAction) {
        self.edited = true;
    }
}

impl App {
    /// All panes in the area that is left.
    pub(super) fn show_panes(&mut self, ui: &mut Ui) {
        self.viewport.areas.clear();
        self.viewport.feet.clear();
        let a = self.document.a;
        match self.document.arrangement {
            Arrangement::Wipe if self.document.is_wiping() => {
                let b = self.document.b;
                self.pane_ui(ui, &[a, b]);
            }
            Arrangement::Tiles if self.document.panes.len() > 1 => self.show_tiles(ui),
            _ => {
                self.pane_ui(ui, &[a]);
            }
        }
    }

    fn show_tiles(&mut self, ui: &mut Ui) {
        let mut tree = tree_of(&self.document);
        let mut tiles = Tiles { app: self, edited: false };
        tree.ui(&mut tiles, ui);
        // An even arrangement stays one while panes are added.
        if tiles.edited {
            self.edit(Edit::Tiles(tree));
        }
    }

    /// Heads, picture and feet of one pane, or of two that lie over each other. True if
    /// the first starts to be dragged elsewhere.
    fn pane_ui(&mut self, ui: &mut Ui, ids: &[PaneId]) -> bool {
        let whole = ui.available_rect_before_wrap();
        if whole.width() < LEAST || whole.height() < LEAST || self.preferences.panels_hidden {
            self.picture(ui, whole, ids);
            return false;
        }
        let details = ids.iter().any(|id| self.document.pane(*id).is_some_and(|p| has_details(&p.show)));
        let head = if details { 2.0 * HEAD } else { HEAD };
        let area = Rect::from_min_max(whole.min + vec2(0.0, head), whole.max - vec2(0.0, FOOT));
        let mut dragged = false;
        for (i, id) in ids.iter().enumerate() {
            let part = |y: egui::Rangef| {
                let width = whole.width() / ids.len() as f32;
                let left = whole.left() + width * i as f32;
                Rect::from_x_y_ranges(left..=left + width, y)
            };
            let row = part(egui::Rangef::new(whole.top(), whole.top() + HEAD));
            self.background(ui, part(egui::Rangef::new(whole.top(), area.top())), *id);
            dragged |= row_ui(ui, row, ("head", *id), |ui| self.head(ui, *id));
            if details {
                let row = row.translate(vec2(0.0, HEAD));
                row_ui(ui, row, ("details", *id), |ui| self.details(ui, *id));
            }
            let foot = part(egui::Rangef::new(area.bottom(), whole.bottom()));
            self.viewport.feet.push((*id, foot));
        }
        self.picture(ui, area, ids);
        dragged
    }

    fn background(&self, ui: &Ui, rect: Rect, id: PaneId) {
        let visuals = ui.visuals();
        let painter = ui.painter();
        painter.rect_filled(rect, CornerRadius::ZERO, visuals.panel_fill);
        if self.document.panes.len() > 1 && id == self.document.a {
            let line = [pos2(rect.left(), rect.top() + 1.0), pos2(rect.right(), rect.top() + 1.0)];
            painter.line_segment(line, Stroke::new(2.0, visuals.selection.bg_fill));
        }
    }

    /// Number, method, what is shown, menu. True if dragged by its number.
    fn head(&mut self, ui: &mut Ui, id: PaneId) -> bool {
        let dragged = self.number(ui, id);
        let room = ui.available_width();
        let menu = 66.0;
        // The methods have the longer names.
        let method = ((room - menu) * 0.56 - 8.0).clamp(40.0, METHOD_WIDTH);
        let shown = (room - menu - method - 16.0).clamp(40.0, SHOWN_WIDTH);
        self.method_list(ui, id, method);
        self.show_list(ui, id, shown);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            if self.document.panes.len() > 1 {
                let close = ui.add(Button::new("×").frame(false));
                let name = format!("Close pane {id}");
                if close.accessible_name(&name).on_hover_text(name).clicked() {
                    self.perform(ui.ctx(), Action::ClosePane(id));
                }
            }
            let menu = ui.menu_button("…", |ui| self.pane_menu(ui, id));
            menu.response.accessible_name(format!("Menu of pane {id}")).on_hover_text("Save, copy, duplicate");
        });
        dragged
    }

    fn number(&mut self, ui: &mut Ui, id: PaneId) -> bool {
        let (rect, response) = ui.allocate_exact_size(vec2(20.0, 20.0), Sense::click_and_drag());
        let several = self.document.panes.len() > 1;
        let (is_a, is_b) = (several && id == self.document.a, several && id == self.document.b);
        response.widget_info(|| WidgetInfo::selected(Role::Button, true, is_a, format!("Pane {id}")));
        let visuals = ui.visuals();
        let (fill, text) = match (is_a, is_b) {
            (true, _) => (visuals.selection.bg_fill, visuals.selection.stroke.color),
            (_, true) => (visuals.widgets.inactive.bg_fill, visuals.strong_text_color()),
            _ => (Color32::TRANSPARENT, visuals.text_color()),
        };
        ui.painter().rect_filled(rect, CornerRadius::same(4), fill);
        let slot = if is_a {
            "A"
        } else if is_b {
            "B"
        } else {
            ""
        };
        let number = self.document.index_of(id).map_or(id.0, |i| i as u32 + 1);
        let text_of = if slot.is_empty() { number.to_string() } else { format!("{number}{slot}") };
        let font = egui::FontId::proportional(11.5);
        ui.painter().text(rect.center(), egui::Align2::CENTER_CENTER, text_of, font, text);
        if response.clicked() {
            self.perform(ui.ctx(), Action::ChooseA(id));
        }
        let started = response.drag_started();
        let help = "Drag to rearrange; click, or press its number, to make it pane A (with shift, pane B)";
        response.on_hover_text(help).on_hover_cursor(egui::CursorIcon::Grab);
        started
    }

    fn method_list(&mut self, ui: &mut Ui, id: PaneId, width: f32) {
        let Some(state) = self.document.pane(id) else { return };
        let about: Vec<_> = methods::all().iter().map(|m| m.about()).collect();
        let titles: Vec<&str> = about.iter().map(|a| a.title).collect();
        let before = about.iter().position(|a| a.id == state.method.id).unwrap_or(about.len());
        let mut chosen = before;
        let help =
            about.get(chosen).map_or_else(String::new, |a| format!("{}\n\n{}\n\n{}", a.summary, a.limits, a.paper));
        let list = combo(ui, &format!("method {id}"), &mut chosen, &titles, width);
        list.accessible_name(format!("Method of pane {id}")).on_hover_text(help);
        if let (true, Some(about)) = (chosen != before, about.get(chosen)) {
            self.perform(ui.ctx(), Action::SetMethod(id, about.id.to_owned()));
        }
    }

    fn show_list(&mut self, ui: &mut Ui, id: PaneId, width: f32) {
        let Some(state) = self.document.pane(id) else { return };
        let overlays = Inside::overlays(&state.method);
        let names: Vec<&str> = Show::NAMES.into_iter().chain(overlays.iter().map(|(name, _)| *name)).collect();
        let known = overlays.iter().position(|(_, overlay)| state.show == Show::Inside(overlay.clone()));
        let before = known.map_or(state.show.index(), |i| Show::NAMES.len() + i);
        let mut chosen = before;
        let list = combo(ui, &format!("show {id}"), &mut chosen, &names, width);
        list.accessible_name(format!("Shown in pane {id}"))
            .on_hover_text("The picture, or what is behind it; what the method did at each pixel comes last");
        if chosen != before {
            let action = match chosen.checked_sub(Show::NAMES.len()).and_then(|i| overlays.get(i)) {
                Some((_, overlay)) => Action::LookInside(id, overlay.clone()),
                None => Action::SetShow(id, chosen),
            };
            self.perform(ui.ctx(), action);
        }
    }

    /// The second row of the head: which difference, which texture.
    fn details(&mut self, ui: &mut Ui, id: PaneId) {
        let exposed: Vec<Exposed> = self.engine.pane(id).map_or_else(Vec::new, |pane| {
            let exposed = |(name, t): (&str, &Texture)| Exposed {
                name: name.to_owned(),
                levels: t.levels(),
                layers: t.layers(),
                components: t.format().components(),
                meaning: pane.meaning(name),
            };
            pane.exposed().map(exposed).collect()
        });
        let others: Vec<(PaneId, String)> = (self.document.panes.iter().enumerate())
            .filter(|(_, p)| p.id != id)
            .map(|(i, p)| (p.id, format!("pane {}: {}", i + 1, p.method.title())))
            .collect();
        let Some(state) = self.document.pane(id) else { return };
        let actions = match &state.show {
            Show::Difference(difference) => difference_edit(ui, id, *difference, &others).into_iter().collect(),
            Show::Inside(inside) => inside_edits(ui, id, inside, state.opacity, &exposed),
            _ => Vec::new(),
        };
        self.perform_all(ui.ctx(), actions);
    }

    /// The feet of all panes: what they say is about the pictures that were made in this
    /// frame, so that they come after those.
    pub(super) fn show_feet(&mut self, ui: &mut Ui) {
        for (id, foot) in std::mem::take(&mut self.viewport.feet) {
            ui.painter().rect_filled(foot, CornerRadius::ZERO, ui.visuals().panel_fill);
            row_ui(ui, foot, ("foot", id), |ui| self.foot(ui, id));
        }
    }

    /// Differences from the truth on the left, time on the right.
    fn foot(&self, ui: &mut Ui, id: PaneId) {
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let pane = self.engine.pane(id);
            if let Some(time) = pane.and_then(|p| p.time()) {
                let each = if pane.is_some_and(|p| p.progress().is_some()) { " a view" } else { "" };
                let (text, help) = time_text(time, each, self.engine.gpu().is_software());
                ui.label(RichText::new(text).small()).on_hover_text(help);
            }
            if let Some(scale) = self.magnification(id, ui.ctx().pixels_per_point()) {
                let help = "Pixels of the display for one of the picture; Z toggles between all of it and 100 %";
                let text = RichText::new(format!("{} %", significant(f64::from(100.0 * scale)))).small();
                ui.label(text).on_hover_text(help);
            }
            let method = self.document.pane(id).map(|pane| &pane.method);
            if let Some(limit) = method.and_then(|method| aperture_limit(method, &self.document.lens.aperture)) {
                ui.label(RichText::new("round aperture").small().color(ui.visuals().warn_fg_color))
                    .on_hover_text(limit);
            }
            if let Some(limit) = method.and_then(|method| astigmatism_limit(method, &self.document.lens.eye)) {
                ui.label(RichText::new("no astigmatism").small().color(ui.visuals().warn_fg_color)).on_hover_text(limit);
            }
            if let Some(divisor) = pane.map(|p| p.divisor()).filter(|divisor| *divisor > 1) {
                let follows = pane.is_some_and(|p| p.is_drawn_beside());
                let text = format!("drawn at 1/{divisor}{}", if follows { ", the whole follows" } else { "" });
                let help = "The full picture takes longer than the interface can wait: it is drawn beside it once nothing moves";
                ui.label(RichText::new(text).small().color(ui.visuals().warn_fg_color)).on_hover_text(help);
            }
            if method.is_some_and(|method| method.as_built) {
                let help = "Drawn with the shaders that the program was built with, on a device of its own once nothing moves; other panes with those that were read since";
                ui.label(RichText::new("shaders as built").small().strong()).on_hover_text(help);
            }
            if self.engine.is_behind(id) {
                ui.label(RichText::new("updates slower").small().color(ui.visuals().warn_fg_color))
                    .on_hover_text("A frame of all panes takes longer than the display's interval: the pane under the pointer comes first");
            }
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                let FootText { text, help, is_current, visibility } = self.figures_text(id);
                if let Some(visibility) = visibility {
                    let [r, g, b] = visibility.srgb8();
                    let word = RichText::new(visibility.word()).small().strong().color(style::readable(Color32::from_rgb(r, g, b), ui.visuals().panel_fill));
                    ui.label(word).on_hover_text(format!("On this display: {}.", visibility.why()));
                }
                let text = RichText::new(text).small();
                let text = if is_current { text } else { text.weak() };
                ui.add(Label::new(text).truncate()).on_hover_text(help);
            });
        });
    }

    fn figures_text(&self, id: PaneId) -> FootText {
        let progress = self.engine.pane(id).and_then(|pane| pane.progress());
        if self.engine.reference() == Some(id) {
            let points = progress.map_or_else(String::new, |(count, of)| format!(" · {count} of {of} lens points"));
            let help = "The reference: the mean of this many views over the lens.";
            return FootText::current(format!("reference{points}"), help);
        }
        let truth = self.engine.reference().and_then(|truth| self.engine.pane(truth)?.progress());
        foot_text(&self.engine.pane_metrics(id), truth)
    }

    fn pane_menu(&mut self, ui: &mut Ui, id: PaneId) {
        let mut entry = |ui: &mut Ui, name: &str, action: Action| {
            if ui.button(name).clicked() {
                self.perform(ui.ctx(), action);
                ui.close();
            }
        };
        entry(ui, "Save as PNG…", Action::SavePicture(id, super::model::PictureKind::Png));
        entry(ui, "Save as EXR…", Action::SavePicture(id, super::model::PictureKind::Exr));
        entry(ui, "Copy image", Action::CopyImage(id));
        ui.separator();
        entry(ui, "Duplicate", Action::Duplicate(id));
        entry(ui, "Compare with the shaders as built", Action::CompareBuilds(id));
        entry(ui, "Use as pane B", Action::ChooseB(id));
        entry(ui, "Default parameters", Action::ResetParams(id));
    }
}

/// What a foot says of a time, and what that is.
fn time_text(time: FrameTime, each: &str, is_software: bool) -> (String, String) {
    let FrameTime { ms, warm_frames } = time;
    let of = match is_software {
        true => {
            "from the submission of frames in which only this pane was drawn: a software adapter has no times of its own; Time passes has those of each pass"
        }
        false => "GPU time of the method",
    };
    match warm_frames {
        0 => (
            format!("{} ms{each}, cold", significant(ms)),
            format!("Time of the first frame, which also builds pipelines, {of}. Later frames replace it."),
        ),
        n => (format!("{} ms{each}", significant(ms)), format!("Median of the last {n} frames after the first, {of}.")),
    }
}

/// What a foot says of figures.
struct FootText {
    text: String,
    help: String,
    /// Whether it is about what is shown.
    is_current: bool,
    /// How visible the difference is.
    visibility: Option<Visibility>,
}

impl FootText {
    fn current(text: impl Into<String>, help: impl Into<String>) -> Self {
        Self { text: text.into(), help: help.into(), is_current: true, visibility: None }
    }
}

/// A pane_metrics in words. `truth`: lens points that the truth has and will have.
fn foot_text(pane_metrics: &PaneMetrics<'_>, truth: Option<(u32, u32)>) -> FootText {
    let goal = truth.map(|(_, goal)| goal);
    // Where no pane shows it, this is where one sees how far it is.
    let progress = truth.filter(|(count, goal)| count < goal);
    let progress =
        progress.map_or_else(String::new, |(count, goal)| format!(" · reference at {count} of {goal} points"));
    let help = "PSNR of what the display shows, how visible the difference is on it (ColorVideoVDP), SSIM and FLIP, against the reference with so many lens points.";
    match pane_metrics {
        PaneMetrics::Unasked => {
            FootText::current("no reference", "Press Figures to measure, or give a pane the method Accumulation buffer")
        }
        PaneMetrics::Pending => FootText::current(format!("measuring …{progress}"), "As soon as the picture rests"),
        PaneMetrics::Current(Measured { result: Err(problem), .. }) => FootText::current(problem, problem),
        PaneMetrics::Current(Measured { result: Ok(figures), of }) => {
            let points = match (of.truth.samples, goal) {
                (Some(n), Some(goal)) if n < goal => format!(" · at {n} of {goal} points"),
                (Some(n), _) => format!(" · at {n} points"),
                (None, _) => String::new(),
            };
            let visibility = figures.jod.map(Visibility::of_jod);
            FootText { visibility, ..FootText::current(figures_in_words(figures) + &points, help) }
        }
        PaneMetrics::Outdated(Measured { result: Err(_), .. }, _) => FootText::current("measuring …", help),
        PaneMetrics::Outdated(Measured { result: Ok(figures), .. }, departures) => FootText {
            text: format!("before ({}): {}{progress}", departures.join(", "), figures_in_words(figures)),
            help: "These figures are of an earlier picture. Those of the present one follow as soon as it rests."
                .into(),
            is_current: false,
            visibility: None,
        },
    }
}

fn figures_in_words(figures: &Figures) -> String {
    let psnr = match figures.psnr_db {
        Some(db) => format!("{db:.1} dB"),
        None => "identical".into(),
    };
    let ssim = figures.ssim.map_or_else(String::new, |s| format!(" · SSIM {s:.3}"));
    let ppd = significant(figures.px_per_degree);
    let jod = figures.jod.map_or_else(String::new, |jod| format!(" · {jod:.2} JOD"));
    format!("{psnr}{jod}{ssim} · FLIP {:.3} at {ppd} px/deg", figures.flip)
}

fn has_details(show: &Show) -> bool {
    matches!(show, Show::Difference(_) | Show::Inside(_))
}

fn row_ui<R>(
    ui: &mut Ui,
    rect: Rect,
    salt: impl std::hash::Hash + std::fmt::Debug,
    add: impl FnOnce(&mut Ui) -> R,
) -> R {
    let inner = rect.shrink2(vec2(style::PANE_MARGIN, 0.0));
    let builder = UiBuilder::new().id_salt(salt).max_rect(inner).layout(Layout::left_to_right(Align::Center));
    let mut row = ui.new_child(builder);
    row.set_clip_rect(rect.intersect(ui.clip_rect()));
    row.spacing_mut().item_spacing.x = 6.0;
    add(&mut row)
}
