//! What decides where the lens is focused, and the eye that follows it.

use super::fields::Field;
use crate::window::model::{FocusMode, FocusSettings};
use crate::window::ui::widgets::choice;
use defocus::focus::{ACCOMMODATION_SECONDS, Accommodation};
use eframe::egui::Ui;
use glam::DVec3;

/// Where a following focus is and whether it still moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Follow {
    /// Focus distance now, metres.
    pub focus_m: f64,
    /// Whether it goes on without the target moving.
    pub moving: bool,
}

/// A focus that follows something; not saved.
#[derive(Clone, Debug, Default)]
pub struct Focusing {
    eye: Option<Accommodation>,
    /// The point in world space, metres, that stays in focus.
    pub anchor: Option<DVec3>,
}

impl Focusing {
    /// Goes on for `dt_s` seconds from `current_m` towards `target_m`. Something else may
    /// have moved the focus in between: then the eye starts from there.
    pub fn follow(&mut self, target_m: f64, current_m: f64, time_constant_s: f64, dt_s: f64) -> Follow {
        let known = self.eye.filter(|eye| eye.distance_m() == current_m);
        let mut eye = known.unwrap_or_else(|| Accommodation::at(current_m));
        let arrived = eye.advance(target_m, time_constant_s, dt_s);
        self.eye = Some(eye);
        Follow { focus_m: eye.distance_m(), moving: !arrived }
    }
}

/// Edits how focus is chosen; true if something changed.
pub fn focus_panel(ui: &mut Ui, settings: &mut FocusSettings, anchored: bool) -> bool {
    let before = *settings;
    let names = FocusMode::ALL.map(|(_, name, _)| name);
    let mut chosen = FocusMode::ALL.iter().position(|(mode, ..)| *mode == settings.mode).unwrap_or(0);
    let help = match FocusMode::ALL[chosen] {
        (FocusMode::Object, ..) if anchored => "This object stays sharp while the camera moves. Click another one.",
        (.., help) => help,
    };
    let help = format!("What decides where the lens is focused. {help}");
    choice(ui, "Focus on", &help, &mut chosen, &names);
    let (mode, ..) = FocusMode::ALL[chosen.min(FocusMode::ALL.len() - 1)];
    settings.mode = mode;
    if mode != FocusMode::Point {
        let mut side_px = f64::from(2 * settings.area_radius_px + 1);
        let field = Field {
            name: "Area",
            help: "Side of the square whose median depth counts: leaves and wires before it do not decide.",
            unit: " px",
            range: 1.0..=65.0,
            log: None,
            reset: Some(9.0),
        };
        if field.show(ui, &mut side_px) {
            settings.area_radius_px = (0.5 * (side_px.clamp(1.0, 1e4) - 1.0)).round() as u32;
        }
    }
    if mode.follows() {
        let field = Field {
            name: "Eye's lag",
            help: "Time constant of the accommodation, dD/dt = (target - D) / T in dioptres: after T, 63 % of the way is done. 0.3 s is a young adult's (Campbell and Westheimer 1960; Kasthurirangan and Glasser 2005).",
            unit: " s",
            range: 0.0..=2.0,
            log: None,
            reset: Some(ACCOMMODATION_SECONDS),
        };
        field.show(ui, &mut settings.time_constant_s);
    }
    *settings = settings.repaired();
    *settings != before
}
