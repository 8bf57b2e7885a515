//! What a pane shows, in detail.

use crate::window::action::Action;
use crate::window::model::{Difference, Edit, Inside, PaneId, Show};
use crate::window::ui::details::{Exposed, difference_row, inside_row};
use eframe::egui::Ui;

/// Which difference, and from which of the other panes; what is to be done.
pub fn difference_edit(ui: &mut Ui, id: PaneId, difference: Difference, others: &[(PaneId, String)]) -> Option<Action> {
    let mut changed = difference;
    difference_row(ui, id, &mut changed, others);
    (changed != difference).then(|| Edit::Show(id, Show::Difference(changed)).into())
}

/// Which numbers of which texture; what is to be done.
pub fn inside_edits(ui: &mut Ui, id: PaneId, inside: &Inside, opacity: f32, exposed: &[Exposed]) -> Vec<Action> {
    let (mut shown, mut share) = (inside.clone(), opacity);
    inside_row(ui, id, &mut shown, &mut share, exposed);
    let show = (shown != *inside).then(|| Edit::Show(id, Show::Inside(shown)).into());
    let opacity = (share != opacity).then(|| Edit::Opacity(id, share).into());
    show.into_iter().chain(opacity).collect()
}
