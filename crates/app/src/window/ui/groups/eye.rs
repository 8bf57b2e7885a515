//! The eye and the display before it.

use crate::window::action::Action;
use crate::window::model::{Edit, EyeSettings};
use crate::window::ui::panels::eye_panel;
use eframe::egui::Ui;

/// Shows the group; what is to be done.
pub fn eye_group(ui: &mut Ui, settings: &EyeSettings) -> Option<Action> {
    let mut changed = settings.clone();
    eye_panel(ui, &mut changed);
    (changed != *settings).then(|| Edit::Eye(Box::new(changed)).into())
}
