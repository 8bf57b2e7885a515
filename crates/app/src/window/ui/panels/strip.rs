//! The strip that stays when the panels are hidden: aperture and focus.

use super::fields::{Field, distance_text};
use crate::window::model::numbers::significant;
use eframe::egui::{Button, Ui, vec2};

/// Width of each of the two fields, points.
const FIELD_WIDTH: f32 = 330.0;

/// Distances that the slider reaches, metres.
const NEAREST_M: f64 = 0.05;

/// What the strip is told.
#[derive(Clone, Copy, Debug)]
pub struct StripView {
    /// E, mm.
    pub aperture_mm: f64,
    /// Focus distance, metres.
    pub focus_m: f64,
    /// Mean CoC over the picture, px, where it is known.
    pub mean_coc_px: Option<f64>,
    /// Depths that are sharp, metres, where an image forms.
    pub sharp_m: Option<(f64, f64)>,
}

/// What is to be done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StripAction {
    /// This E, mm.
    Aperture(f64),
    /// This focus distance, metres.
    Focus(f64),
    /// The panels are to come back.
    ShowPanels,
}

/// Shows the strip; what is to be done, if something is.
pub fn strip(ui: &mut Ui, view: StripView) -> Option<StripAction> {
    let mut action = None;
    ui.horizontal_wrapped(|ui| {
        let mut field = |ui: &mut Ui, field: Field<'_>, value: f64, changed: fn(f64) -> StripAction| {
            ui.allocate_ui(vec2(FIELD_WIDTH, ui.spacing().interact_size.y), |ui| {
                ui.set_max_width(FIELD_WIDTH);
                let mut new = value;
                if field.show(ui, &mut new) {
                    action = Some(changed(new));
                }
            });
        };
        let help = "E: diameter of the aperture, the pupil. All blur is proportional to it. Keys: comma and point.";
        let aperture = Field { name: "Opening E", help, unit: " mm", range: 0.0..=200.0, log: Some(0.01), reset: None };
        field(ui, aperture, view.aperture_mm, |mm| StripAction::Aperture(mm.max(0.0)));
        let help = "Distance of what is sharp. Or click it in the picture. Keys: K nearer, L farther.";
        let focus = Field {
            name: "Focus at",
            help,
            unit: " m",
            range: NEAREST_M..=f64::INFINITY,
            log: Some(NEAREST_M),
            reset: None,
        };
        field(ui, focus, view.focus_m, StripAction::Focus);
        if let Some(mean_px) = view.mean_coc_px {
            ui.label(format!("mean CoC {} px", significant(mean_px)));
        }
        if let Some((near_m, far_m)) = view.sharp_m {
            ui.label(format!("sharp {} – {}", distance_text(near_m), distance_text(far_m)));
        }
        if ui.add(Button::new("Panels")).on_hover_text("Shows the panels again (Tab)").clicked() {
            action = Some(StripAction::ShowPanels);
        }
    });
    action
}
