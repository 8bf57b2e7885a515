//! The shape of the aperture, with what methods cannot show of it.

use crate::window::action::Action;
use crate::window::model::{Edit, PaneState, aperture_limit};
use crate::window::ui::panels::aperture_panel;
use defocus::aperture::Aperture;
use eframe::egui::{RichText, Ui};

/// What the group is told.
pub struct ApertureView<'a> {
    /// The shape.
    pub aperture: &'a Aperture,
    /// The panes, whose methods may be unable to show it.
    pub panes: &'a [PaneState],
}

/// Shows the group; what is to be done.
pub fn aperture_group(ui: &mut Ui, view: &ApertureView<'_>) -> Vec<Action> {
    let mut aperture = view.aperture.clone();
    let change = aperture_panel(ui, &mut aperture);
    let mut limits: Vec<String> =
        view.panes.iter().filter_map(|pane| aperture_limit(&pane.method, view.aperture)).collect();
    limits.dedup();
    for limit in limits {
        ui.label(RichText::new(limit).small().color(ui.visuals().warn_fg_color));
    }
    let mut actions = Vec::new();
    if aperture != *view.aperture {
        actions.push(Edit::Aperture(aperture).into());
    }
    if change.wants_image {
        actions.push(Action::OpenAperture);
    }
    actions
}
