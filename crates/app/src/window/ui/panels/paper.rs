//! What goes into figures for a paper.

use crate::window::model::{PaneId, PaperChoice};
use eframe::egui::{Button, RichText, TextEdit, Ui};

/// What the form is told.
pub struct PaperView<'a> {
    /// The panes with their names, the reference aside.
    pub panes: &'a [(PaneId, String)],
    /// What is chosen.
    pub choice: &'a PaperChoice,
    /// Whether there is a reference for maps and figures.
    pub has_truth: bool,
    /// Whether the panes show a magnified part, which is then the detail.
    pub is_magnified: bool,
}

/// What is to be done.
#[derive(Clone, Debug, PartialEq)]
pub enum PaperAction {
    /// Choose this.
    Choose(PaperChoice),
    /// Make them.
    Make,
    /// Make nothing.
    Cancel,
}

/// Shows the form; what is to be done, if something is.
pub fn paper_form(ui: &mut Ui, view: &PaperView<'_>) -> Option<PaperAction> {
    let mut choice = view.choice.clone();
    ui.label("Pictures, maps, plot, table, caption and a README that repeats them, in one folder.");
    ui.add_space(4.0);
    ui.label(RichText::new("Panes").strong());
    for (id, name) in view.panes {
        let mut is_in = !choice.left_out.contains(id);
        if ui.checkbox(&mut is_in, name.as_str()).changed() {
            choice.left_out.retain(|left| left != id);
            if !is_in {
                choice.left_out.push(*id);
            }
        }
    }
    ui.label(RichText::new("Contents").strong());
    let detail = if view.is_magnified { "Details: what the panes show" } else { "Details: around the worst place" };
    ui.checkbox(&mut choice.details, detail)
        .on_hover_text("A part of each picture, three times as large. Magnify the panes to choose it.");
    let maps = ui.add_enabled(view.has_truth, eframe::egui::Checkbox::new(&mut choice.maps, "Error maps"));
    maps.on_hover_text("FLIP, what is visible (ColorVideoVDP), and the absolute error, with their scales");
    ui.checkbox(&mut choice.plots, "Plots")
        .on_hover_text("CoC against depth, quality against time: SVG, and the curve as CSV");
    ui.checkbox(&mut choice.table, "Table").on_hover_text("All figures as CSV and JSON");
    ui.horizontal(|ui| {
        let label = ui.label("Folder");
        ui.add(TextEdit::singleline(&mut choice.folder).desired_width(360.0)).labelled_by(label.id);
    });
    let is_any = view.panes.iter().any(|(id, _)| !choice.left_out.contains(id));
    let missing = match (is_any, choice.folder.trim().is_empty()) {
        (false, _) => Some("Choose a pane."),
        (_, true) => Some("Name a folder."),
        _ => None,
    };
    let note = missing.unwrap_or("Files of these names in it are replaced.");
    ui.label(RichText::new(note).small().weak());
    let mut action = (choice != *view.choice).then_some(PaperAction::Choose(choice));
    ui.horizontal(|ui| {
        if ui.add_enabled(missing.is_none(), Button::new("Make figures")).clicked() {
            action = Some(PaperAction::Make);
        }
        if ui.button("Cancel").clicked() {
            action = Some(PaperAction::Cancel);
        }
    });
    action
}
