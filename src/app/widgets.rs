//! Rows of a name and an input, the one labelled by the other.

use super::style::NAME_WIDTH;
use crate::methods::{Param, Value};
use eframe::egui::{Align, ComboBox, Label, Layout, Response, Slider, SliderClamping, Ui, vec2};
use std::ops::RangeInclusive;

/// Width of the number beside a slider, points.
const NUMBER_WIDTH: f32 = 102.0;

/// A name, then whatever `add` adds, labelled by it.
pub fn row(ui: &mut Ui, name: &str, help: &str, add: impl FnOnce(&mut Ui) -> Response) -> Response {
    ui.horizontal(|ui| {
        let size = vec2(NAME_WIDTH, ui.spacing().interact_size.y);
        let label = ui
            .allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
                ui.set_min_width(NAME_WIDTH);
                ui.add(Label::new(name).truncate())
            })
            .inner;
        let response = add(ui).labelled_by(label.id);
        if help.is_empty() {
            return response;
        }
        label.on_hover_text(help);
        response.on_hover_text(help)
    })
    .inner
}

/// Gives a slider what a row has left beside its number.
pub fn fit_slider(ui: &mut Ui) {
    let spacing = ui.spacing().item_spacing.x;
    // Numbers of one width, so that sliders and numbers stand in columns.
    ui.spacing_mut().interact_size.x = NUMBER_WIDTH;
    ui.spacing_mut().slider_width = (ui.available_width() - NUMBER_WIDTH - spacing).max(40.0);
}

/// A slider for a real number; `log` names the least positive value of a logarithmic one.
pub struct Real<'a> {
    /// Name of the row.
    pub name: &'a str,
    /// What it is, for the tooltip.
    pub help: &'a str,
    /// Unit with its leading space, or nothing.
    pub unit: &'a str,
    /// Reach of the slider; typed numbers may go beyond it.
    pub range: RangeInclusive<f64>,
    /// Least positive value of a logarithmic slider.
    pub log: Option<f64>,
}

impl Real<'_> {
    /// Shows it; true if the value changed.
    pub fn show(self, ui: &mut Ui, value: &mut f64) -> bool {
        let Self { name, help, unit, range, log } = self;
        row(ui, name, help, |ui| {
            fit_slider(ui);
            let mut slider = Slider::new(value, range)
                .suffix(unit)
                .clamping(SliderClamping::Never)
                .custom_formatter(|v, _| significant(v))
                .custom_parser(parsed);
            if let Some(least) = log {
                slider = slider.logarithmic(true).smallest_positive(least).largest_finite(1000.0);
            }
            ui.add(slider)
        })
        .changed()
    }
}

/// A number with three significant digits, or more where it is large.
pub fn significant(v: f64) -> String {
    if v.is_infinite() {
        return "∞".into();
    }
    let digits = if v == 0.0 { 0 } else { (2.0 - v.abs().log10().floor()).clamp(0.0, 6.0) as usize };
    let text = format!("{v:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

fn parsed(text: &str) -> Option<f64> {
    let text = text.trim();
    if text == "∞" {
        return Some(f64::INFINITY);
    }
    text.parse().ok().filter(|v: &f64| !v.is_nan())
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
    let list = ComboBox::from_id_salt(salt).width(width).selected_text(selected).truncate();
    list.show_ui(ui, |ui| {
        for (index, name) in names.iter().enumerate() {
            ui.selectable_value(chosen, index, *name);
        }
    })
    .response
}

/// The input of a method's parameter; true if it changed.
pub fn param(ui: &mut Ui, param: Param<'_>) -> bool {
    let (label, help) = (param.label, param.help);
    match param.value {
        Value::Float { value, range, unit } => {
            let mut wide = f64::from(*value);
            let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
            let range = f64::from(range.0)..=f64::from(range.1);
            let slider = Real { name: label, help, unit: &unit, range: range.clone(), log: None };
            let changed = slider.show(ui, &mut wide);
            if changed {
                *value = wide.clamp(*range.start(), *range.end()) as f32;
            }
            changed
        }
        Value::Int { value, range, unit } => {
            let before = *value;
            row(ui, label, help, |ui| {
                fit_slider(ui);
                let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
                // Counts over several powers of two are felt in ratios.
                let wide = range.1 / range.0.max(1) > 64;
                ui.add(Slider::new(value, range.0..=range.1).suffix(unit).logarithmic(wide))
            });
            *value != before
        }
        Value::Switch(on) => row(ui, label, help, |ui| ui.checkbox(on, "")).changed(),
        Value::Choice { value, names } => choice(ui, label, help, value, names),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_significant_digits() {
        let cases = [(0.0, "0"), (0.012345, "0.0123"), (1.5, "1.5"), (2.0, "2"), (17.36, "17.4"), (3000.0, "3000")];
        for (value, text) in cases {
            assert_eq!(significant(value), text);
        }
        assert_eq!(parsed(&significant(f64::INFINITY)), Some(f64::INFINITY));
        assert_eq!(parsed("nan"), None);
    }
}
