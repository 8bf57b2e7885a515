//! The bar of a scene with animations: play, scrub, and back to rest.

use super::fields::NUMBER_WIDTH;
use crate::window::model::numbers::parsed;
use crate::window::ui::widgets::combo;
use eframe::egui::{Button, DragValue, Slider, Ui};

/// Width of the list of animations, points.
const NAMES_WIDTH: f32 = 150.0;

/// What the bar is told.
pub struct AnimationView<'a> {
    /// Names of the animations.
    pub names: &'a [&'a str],
    /// The one that is shown.
    pub chosen: &'a str,
    /// Seconds from its beginning.
    pub time_s: f64,
    /// Its length, seconds.
    pub duration_s: f64,
    /// Whether it plays.
    pub is_playing: bool,
    /// Whether the scene stands as its file has it, without an animation.
    pub is_at_rest: bool,
}

/// What is to be done.
#[derive(Clone, Debug, PartialEq)]
pub enum AnimationAction {
    /// Play, or stop.
    PlayOrStop,
    /// Show another animation from its beginning.
    Choose(String),
    /// Show this time, seconds.
    Scrub(f64),
    /// Show the scene as it is without an animation.
    Rest,
}

/// Shows the bar; what is to be done, if something is.
pub fn animation_bar(ui: &mut Ui, view: &AnimationView<'_>) -> Option<AnimationAction> {
    let mut action = None;
    ui.horizontal(|ui| {
        let name = if view.is_playing { "Pause" } else { "Play" };
        // Of one width, so that what follows stays where it is.
        let play = Button::new(name).min_size([56.0, 0.0].into());
        if ui.add(play).on_hover_text("Plays the animation, or stops it (Space)").clicked() {
            action = Some(AnimationAction::PlayOrStop);
        }
        let rest = ui.add_enabled(!view.is_at_rest, Button::new("Rest pose"));
        if rest.on_hover_text("The scene as its file has it without an animation").clicked() {
            action = Some(AnimationAction::Rest);
        }
        let before = view.names.iter().position(|name| *name == view.chosen).unwrap_or(view.names.len());
        let mut chosen = before;
        let list = combo(ui, "animation", &mut chosen, view.names, NAMES_WIDTH);
        list.accessible_name("Animation").on_hover_text("Animations of the file");
        if let Some(name) = view.names.get(chosen).filter(|_| chosen != before) {
            action = Some(AnimationAction::Choose((*name).to_owned()));
        }
        if let Some(time_s) = time(ui, view) {
            action = Some(AnimationAction::Scrub(time_s));
        }
    });
    action
}

/// The time as a slider as wide as there is room, and as a number.
fn time(ui: &mut Ui, view: &AnimationView<'_>) -> Option<f64> {
    let mut time_s = view.time_s;
    let end_s = view.duration_s.max(1e-3);
    let spacing = ui.spacing().item_spacing.x;
    ui.spacing_mut().interact_size.x = NUMBER_WIDTH;
    ui.spacing_mut().slider_width = (ui.available_width() - NUMBER_WIDTH - 2.0 * spacing).max(60.0);
    let slider = Slider::new(&mut time_s, 0.0..=end_s).show_value(false);
    ui.add(slider).accessible_name("Time").on_hover_text("Moment of the animation");
    let number = DragValue::new(&mut time_s)
        .range(0.0..=end_s)
        .speed(end_s / 300.0)
        .suffix(" s")
        .update_while_editing(false)
        .custom_formatter(|v, _| format!("{v:.3}"))
        .custom_parser(|text| parsed(text, " s", &[]).ok());
    ui.add(number).accessible_name("Time").on_hover_text(format!("Of {:.3} s", view.duration_s));
    (time_s != view.time_s).then_some(time_s)
}
