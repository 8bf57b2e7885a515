//! Rows of a name and an input, the one labelled by the other.

use super::named::named;
use super::panels::Field;
use defocus::methods::{Param, Value};
use eframe::egui::{Align, CollapsingHeader, ComboBox, Label, Response, RichText, Ui};

/// Height of an open list, points: all methods are in sight.
const LIST_HEIGHT: f32 = 460.0;

/// A part of a panel that can be folded; `open`: whether it is unfolded at first. What stands
/// after a colon in the title may change: it is the same part.
pub fn group<R>(ui: &mut Ui, title: &str, open: bool, add: impl FnOnce(&mut Ui) -> R) {
    revealed(ui, title, open, false, add);
}

/// The same with what it is about, told where its title is pointed at.
pub fn group_about<R>(ui: &mut Ui, title: &str, help: &str, open: bool, add: impl FnOnce(&mut Ui) -> R) {
    shown(ui, title, open, false, add).on_hover_text(help);
}

/// The same; `reveal`: it is unfolded now, and brought into sight.
pub fn revealed<R>(ui: &mut Ui, title: &str, open: bool, reveal: bool, add: impl FnOnce(&mut Ui) -> R) {
    shown(ui, title, open, reveal, add);
}

fn shown<R>(ui: &mut Ui, title: &str, open: bool, reveal: bool, add: impl FnOnce(&mut Ui) -> R) -> Response {
    let id = title.split(':').next().unwrap_or(title).to_owned();
    let header = CollapsingHeader::new(RichText::new(title).strong()).id_salt(id).default_open(open);
    let shown = header.open(reveal.then_some(true)).show_unindented(ui, |ui| {
        add(ui);
        ui.add_space(4.0);
    });
    if reveal {
        shown.header_response.scroll_to_me(Some(Align::TOP));
    }
    shown.header_response
}

/// A name, then whatever `add` adds, labelled by it.
pub fn row(ui: &mut Ui, name: &str, help: &str, add: impl FnOnce(&mut Ui) -> Response) -> Response {
    let (label, response) = named(ui, Label::new(name), name, |ui, label| add(ui).labelled_by(label));
    if help.is_empty() {
        return response;
    }
    label.on_hover_text(help);
    response.on_hover_text(help)
}

/// A choice from a list of names; true if another one was chosen.
pub fn choice(ui: &mut Ui, name: &str, help: &str, chosen: &mut usize, names: &[&str]) -> bool {
    let before = *chosen;
    row(ui, name, help, |ui| combo(ui, name, chosen, names, ui.available_width()));
    *chosen != before
}

/// The list alone, `width` points wide.
pub fn combo(ui: &mut Ui, salt: &str, chosen: &mut usize, names: &[&str], width: f32) -> Response {
    let selected = names.get(*chosen).copied().unwrap_or("–");
    let list = ComboBox::from_id_salt(salt).width(width).height(LIST_HEIGHT).selected_text(selected).truncate();
    // A long name is cut off at the end of the room there is, not at that of the list.
    ui.scope(|ui| {
        ui.set_max_width(width);
        list.show_ui(ui, |ui| {
            for (index, name) in names.iter().enumerate() {
                ui.selectable_value(chosen, index, *name);
            }
        })
        .response
    })
    .inner
}

/// The input of a method's parameter, which a double-click on its name sets back to
/// `default`; true if it changed.
pub fn param(ui: &mut Ui, param: Param<'_>, default: Option<f64>) -> bool {
    let help = param.full_help();
    let (name, help) = (param.label, help.as_str());
    let with_space = |unit: &str| if unit.is_empty() { String::new() } else { format!(" {unit}") };
    match param.value {
        Value::Float { value, range, unit } => {
            let (low, high) = (f64::from(range.0), f64::from(range.1));
            let unit = with_space(unit);
            let mut wide = f64::from(*value);
            let field = Field { name, help, unit: &unit, range: low..=high, log: None, reset: default };
            let changed = field.show(ui, &mut wide);
            if changed {
                *value = wide.clamp(low, high) as f32;
            }
            changed
        }
        Value::Int { value, range, unit } => {
            let (low, high) = (f64::from(range.0), f64::from(range.1));
            let unit = with_space(unit);
            let (before, mut wide) = (*value, f64::from(*value));
            // Counts over several powers of two are felt in ratios.
            let log = (range.1 / range.0.max(1) > 64).then_some(low.max(1.0));
            Field { name, help, unit: &unit, range: low..=high, log, reset: default }.show(ui, &mut wide);
            *value = wide.round().clamp(low, high) as u32;
            *value != before
        }
        Value::Switch(on) => row(ui, name, help, |ui| ui.checkbox(on, "")).changed(),
        Value::Choice { value, names } => choice(ui, name, help, value, names),
    }
}

/// A parameter as a number, if it is one.
pub fn number_of(param: &Param<'_>) -> Option<f64> {
    match &param.value {
        Value::Float { value, .. } => Some(f64::from(**value)),
        Value::Int { value, .. } => Some(f64::from(**value)),
        Value::Switch(_) | Value::Choice { .. } => None,
    }
}
