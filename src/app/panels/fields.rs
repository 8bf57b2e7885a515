//! Rows of a name, a slider and an exact number, which a double-click on the name resets.

use super::super::numbers::significant;
use super::super::style::NAME_WIDTH;
use super::super::widgets::fit_slider;
use eframe::egui::{Align, Label, Layout, Response, RichText, Sense, Slider, SliderClamping, Ui, vec2};
use std::ops::RangeInclusive;

/// A real number that can be dragged, typed and reset.
pub struct Field<'a> {
    /// Name of the row and accessible name of its inputs.
    pub name: &'a str,
    /// What it is, with its formula, for the tooltip.
    pub help: &'a str,
    /// Unit with its leading space, or nothing.
    pub unit: &'a str,
    /// Reach of the slider; typed numbers may go beyond it.
    pub range: RangeInclusive<f64>,
    /// Least positive value of a logarithmic slider.
    pub log: Option<f64>,
    /// What a double-click on the name sets.
    pub reset: Option<f64>,
}

impl Field<'_> {
    /// Shows it; true if the value changed.
    pub fn show(self, ui: &mut Ui, value: &mut f64) -> bool {
        let Self { name, help, unit, range, log, reset } = self;
        let before = *value;
        let name_response = named_row(ui, name, |ui| {
            fit_slider(ui);
            let mut slider = Slider::new(value, range)
                .suffix(unit)
                .clamping(SliderClamping::Never)
                .custom_formatter(|v, _| significant(v))
                .custom_parser(parsed);
            if let Some(least) = log {
                slider = slider.logarithmic(true).smallest_positive(least).largest_finite(1000.0);
            }
            ui.add(slider).on_hover_text(help)
        });
        let help = match reset {
            Some(reset) => format!("{help}\n\nDouble-click the name to reset to {}{unit}.", significant(reset)),
            None => help.to_owned(),
        };
        if let (true, Some(reset)) = (name_response.on_hover_text(help).double_clicked(), reset) {
            *value = reset;
        }
        // Typing may leave what is no number: then nothing was changed.
        if value.is_nan() {
            *value = before;
        }
        *value != before
    }
}

/// A name, then whatever `add` adds, labelled by it; the name's response.
pub fn named_row(ui: &mut Ui, name: &str, add: impl FnOnce(&mut Ui) -> Response) -> Response {
    ui.horizontal(|ui| {
        let size = vec2(NAME_WIDTH, ui.spacing().interact_size.y);
        let label = ui
            .allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
                ui.set_min_width(NAME_WIDTH);
                let name = RichText::new(name).color(ui.visuals().text_color());
                ui.add(Label::new(name).truncate().selectable(false).sense(Sense::click()))
            })
            .inner;
        add(ui).labelled_by(label.id);
        label
    })
    .inner
}

/// A distance in metres with its unit, in centimetres where that reads better.
pub fn distance_text(distance_m: f64) -> String {
    match distance_m {
        d if d.is_infinite() => "∞".into(),
        d if d.abs() < 0.995 => format!("{} cm", significant(d * 100.0)),
        d => format!("{} m", significant(d)),
    }
}

fn parsed(text: &str) -> Option<f64> {
    let text = text.trim();
    if text == "∞" {
        return Some(f64::INFINITY);
    }
    text.parse().ok().filter(|v: &f64| !v.is_nan())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_shown_can_be_typed() {
        assert_eq!(parsed(&significant(f64::INFINITY)), Some(f64::INFINITY));
        assert_eq!(parsed(&significant(0.012345)), Some(0.0123));
        assert_eq!(parsed("nan"), None);
    }
}
