//! The form in the window, and what starts the work.

use super::write::write;
use crate::window::App;
use crate::window::model::{Document, PaneId, PaperChoice};
use crate::window::tasks::Task;
use crate::window::ui::panels::{PaperAction, PaperView, paper_form};
use eframe::egui::{Context, Id, Modal, RichText, ScrollArea};

/// Height of the window around the form's content, points.
const FRAME_HEIGHT: f32 = 70.0;

/// The form, if it is open.
#[derive(Default)]
pub struct PaperForm {
    choice: Option<PaperChoice>,
}

impl PaperForm {
    /// Whether it is shown.
    pub fn is_open(&self) -> bool {
        self.choice.is_some()
    }
}

impl App {
    /// Opens the form.
    pub(in crate::window) fn ask_for_paper(&mut self) {
        let folder = self.dialogs.folder().join(format!("{}-figures", self.document.name()));
        self.paper.choice = Some(PaperChoice::into_folder(folder.to_string_lossy().into_owned()));
    }

    /// Shows the form while it is open.
    pub(in crate::window) fn show_paper_form(&mut self, ctx: &Context) {
        let Some(choice) = &self.paper.choice else { return };
        let panes = self.panes_for_paper();
        let is_scene = self.engine.source().is_some_and(|s| s.source().is_scene());
        let is_magnified = self.visible_part().is_some();
        let view = PaperView { panes: &panes, choice, has_truth: is_scene, is_magnified };
        let modal = Modal::new(Id::unique("figures for a paper")).show(ctx, |ui| {
            ui.set_width(460.0);
            ui.label(RichText::new("Figures for a paper").strong());
            // Six panes make it higher than the smallest window.
            let height = (ui.ctx().content_rect().height() - FRAME_HEIGHT).max(80.0);
            ScrollArea::vertical().max_height(height).show(ui, |ui| paper_form(ui, &view)).inner
        });
        let should_close = modal.should_close();
        match modal.inner {
            Some(PaperAction::Choose(choice)) => self.paper.choice = Some(choice),
            Some(PaperAction::Make) => self.make_paper(ctx),
            Some(PaperAction::Cancel) => self.paper.choice = None,
            None if should_close => self.paper.choice = None,
            None => {}
        }
    }

    /// The panes that figures can be made of, with their names.
    fn panes_for_paper(&self) -> Vec<(PaneId, String)> {
        let reference = self.document.reference().filter(|_| self.document.panes.len() > 1);
        let panes = self.document.panes.iter().enumerate().filter(|(_, pane)| Some(pane.id) != reference);
        panes.map(|(i, pane)| (pane.id, format!("{} {}", i + 1, pane.method.title()))).collect()
    }

    /// Corners of the part of the picture that pane A shows, each from (0, 0) to (1, 1), where
    /// it is magnified.
    fn visible_part(&self) -> Option<[[f32; 2]; 2]> {
        self.document.zoom.scale?;
        let (picture, area) = (self.picture_rect(self.document.a)?, self.viewport.areas.get(&self.document.a)?);
        let seen = picture.intersect(*area);
        let is_whole = seen.width() >= picture.width() - 1.0 && seen.height() >= picture.height() - 1.0;
        let share = |at: eframe::egui::Pos2| {
            let share = (at - picture.min) / picture.size();
            [share.x, share.y]
        };
        (!is_whole && seen.is_positive()).then(|| [share(seen.min), share(seen.max)])
    }

    fn make_paper(&mut self, ctx: &Context) {
        let Some(choice) = self.paper.choice.take() else { return };
        let visible = self.visible_part();
        let Some(mut order) = self.order() else { return };
        let reference = order.document.reference();
        let mut document: Document = order.document.clone();
        document.panes.retain(|pane| Some(pane.id) == reference || !choice.left_out.contains(&pane.id));
        order.document = document.repaired();
        let folder = choice.folder.trim().to_owned();
        self.tasks.push(Task::start(format!("Figures for {folder}"), ctx, move |progress| {
            write(&order, &choice, visible, progress).map(|()| format!("Saved the figures in {folder}"))
        }));
    }
}
