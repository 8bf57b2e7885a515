//! The question in which unit a scene's file is.

use super::fields::distance_text;
use eframe::egui::Ui;

/// What the question is about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScaleView {
    /// Distance of the nearest things in view, metres.
    pub nearest_m: f64,
}

/// The answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ScaleAction {
    /// Read the file with so many metres a unit.
    Read(f64),
    /// Leave it.
    Keep,
}

/// Asks; the answer, if one is given.
pub fn scale_offer(ui: &mut Ui, view: ScaleView) -> Option<ScaleAction> {
    let mut action = None;
    ui.horizontal_wrapped(|ui| {
        let far = distance_text(view.nearest_m);
        ui.label(format!(
            "Nothing in view is nearer than {far}, where no eye blurs much. Is the file in another unit?"
        ));
        for (name, metres) in [("Centimetres", 0.01), ("Millimetres", 0.001), ("Inches", 0.0254)] {
            if ui.button(name).on_hover_text(format!("{metres} m a unit")).clicked() {
                action = Some(ScaleAction::Read(metres));
            }
        }
        if ui.button("Metres").on_hover_text("As glTF says: nothing changes").clicked() {
            action = Some(ScaleAction::Keep);
        }
    });
    action
}
