//! Two eyes, and headsets.

use crate::window::action::Action;
use crate::window::model::{Edit, PictureSize};
use crate::window::ui::panels::{VrAction, VrReadings, vr_panel};
use defocus::lens::Lens;
use defocus::stereo::Stereo;
use eframe::egui::Ui;

/// Shows the group; what is to be done.
pub fn stereo_group(ui: &mut Ui, stereo: Option<Stereo>, lens: &Lens, readings: VrReadings) -> Vec<Action> {
    let mut changed = stereo;
    let asked = vr_panel(ui, &mut changed, lens, readings);
    let edit = (changed != stereo).then(|| Edit::Stereo(changed).into());
    let size = asked.map(|VrAction::PictureSize(width, height)| Action::SetSize(PictureSize::Pixels(width, height)));
    edit.into_iter().chain(size).collect()
}
