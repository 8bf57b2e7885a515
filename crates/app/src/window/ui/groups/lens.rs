//! The lens, with what decides where it is focused.

use crate::window::action::Action;
use crate::window::model::{Edit, FocusSettings, Preference, Preferences};
use crate::window::ui::panels::{LensChanges, LensPanel, LensReadings, focus_panel};
use defocus::lens::Lens;
use eframe::egui::Ui;

/// What the group is told.
pub struct LensView<'a> {
    /// The lens.
    pub lens: &'a Lens,
    /// Whether it follows the scene.
    pub is_automatic: bool,
    /// How focus is chosen.
    pub focus: FocusSettings,
    /// Whether an object is kept in focus.
    pub is_anchored: bool,
    /// Units and lenses of the person.
    pub preferences: &'a Preferences,
    /// What is known of what is shown.
    pub readings: LensReadings<'a>,
}

/// Shows the group; what is to be done.
pub fn lens_group(ui: &mut Ui, view: &LensView<'_>, panel: &mut LensPanel) -> Vec<Action> {
    let LensView { preferences, readings, .. } = view;
    (panel.unit, panel.display_by_view) = (preferences.distance_unit, preferences.display_by_view);
    let (mut lens, mut own, mut focus) = (view.lens.clone(), preferences.own_lenses.clone(), view.focus);
    let is_automatic = view.is_automatic;
    let mut between = |ui: &mut Ui| {
        focus_panel(ui, &mut focus, view.is_anchored);
    };
    let changes = panel.show_around(ui, &mut lens, is_automatic, &mut own, *readings, &mut between);
    let LensChanges { lens: is_other, focus: is_refocused, suit_scene, camera_fov_x } = changes;
    let focus_m = lens.focus_distance_m;
    let mut actions = Vec::new();
    if is_other {
        actions.push(Edit::Lens(lens).into());
    }
    if is_refocused {
        actions.push(Edit::FocusDistance(focus_m).into());
    }
    if focus != view.focus {
        actions.push(Edit::Focus(focus).into());
    }
    if let Some(fov_x) = camera_fov_x {
        actions.push(Edit::FieldOfView(readings.size_px, fov_x).into());
    }
    if suit_scene {
        actions.push(Action::SuitLens);
    }
    let preferred = [
        (panel.unit != preferences.distance_unit).then_some(Preference::DistanceUnit(panel.unit)),
        (panel.display_by_view != preferences.display_by_view)
            .then_some(Preference::DisplayByView(panel.display_by_view)),
        (own != preferences.own_lenses).then_some(Preference::OwnLenses(own)),
    ];
    actions.extend(preferred.into_iter().flatten().map(Action::Prefer));
    actions
}
