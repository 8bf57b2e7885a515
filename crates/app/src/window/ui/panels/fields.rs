//! Rows of a name, a slider and an exact number, which a double-click on the name resets.

use crate::window::model::numbers::{OtherUnit, exact, parsed, significant};
use crate::window::ui::named::named;
use eframe::egui::{
    Color32, DragValue, Id, Label, Response, RichText, Sense, Slider, SliderClamping, TextStyle, Ui, UiBuilder,
};
use std::cell::RefCell;
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

/// Width of the number beside a slider, points.
pub(super) const NUMBER_WIDTH: f32 = 90.0;

/// How much finer a slider moves while shift is held.
const FINE: f64 = 0.1;

/// Greatest finite value of a logarithmic slider that reaches to infinity.
const LARGEST_FINITE: f64 = 1000.0;

impl Field<'_> {
    /// Shows it; true if the value changed.
    pub fn show(self, ui: &mut Ui, value: &mut f64) -> bool {
        self.show_with(ui, value, &[])
    }

    /// The same for a field that understands further units.
    pub fn show_with(self, ui: &mut Ui, value: &mut f64, others: &[OtherUnit<'_>]) -> bool {
        let Self { name, help, unit, reset, .. } = self;
        let before = *value;
        let problem = ui.scope_id().with((name, "what was typed"));
        let mut told = None;
        let name_response = labelled_row(ui, name, |ui, label| {
            fit_slider(ui);
            self.slider(ui, value).labelled_by(label).on_hover_text(help);
            let (number, error) = self.number(ui, value, others);
            number.labelled_by(label).on_hover_text(help);
            told = error;
        });
        if let Some(told) = told {
            ui.data_mut(|data| data.insert_temp(problem, told));
        }
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
        if *value != before {
            ui.data_mut(|data| data.remove::<String>(problem));
        } else if let Some(told) = ui.data(|data| data.get_temp::<String>(problem)) {
            ui.label(RichText::new(told).small().color(ui.visuals().error_fg_color));
        }
        *value != before
    }

    fn slider(&self, ui: &mut Ui, value: &mut f64) -> Response {
        let before = *value;
        let mut slider = Slider::new(value, self.range.clone()).clamping(SliderClamping::Never).show_value(false);
        if let Some(least) = self.log {
            slider = slider.logarithmic(true).smallest_positive(least).largest_finite(LARGEST_FINITE);
        }
        let response = ui.add(slider);
        if response.dragged() && ui.input(|i| i.modifiers.shift) {
            let moved = f64::from(response.drag_delta().x / response.rect.width().max(1.0));
            *value = self.moved(before, FINE * moved);
        }
        response
    }

    /// A value moved by a share of the slider.
    fn moved(&self, value: f64, share: f64) -> f64 {
        let (low, high) = (*self.range.start(), *self.range.end());
        let moved = match self.log {
            Some(least) if value.is_finite() => {
                let reach = high.min(LARGEST_FINITE) / least;
                value.max(least) * reach.powf(share)
            }
            Some(_) => value,
            None => value + share * (high - low),
        };
        // What was typed beyond the slider's reach stays there until it is moved back.
        moved.clamp(low.min(value), high.max(value))
    }

    /// The number; what is wrong with what was typed, if something is.
    fn number(&self, ui: &mut Ui, value: &mut f64, others: &[OtherUnit<'_>]) -> (Response, Option<String>) {
        let before = *value;
        let error = RefCell::new(None);
        // All digits are there to be edited; to be read, three do.
        let is_edited = ui.memory(|memory| memory.has_focus(ui.next_auto_id()));
        let speed = match self.log {
            Some(least) => 0.01 * before.abs().clamp(least, LARGEST_FINITE),
            None => (self.range.end() - self.range.start()) / 300.0,
        };
        // A unit that has no room beside the number is told with the help: a wider field would push
        // everything below it out of the panel.
        let font = TextStyle::Button.resolve(ui.style());
        let text = format!("{}{}", significant(before), self.unit);
        let width = ui.fonts_mut(|fonts| fonts.layout_no_wrap(text, font, Color32::PLACEHOLDER).size().x);
        let has_room = width + 2.0 * ui.spacing().button_padding.x <= NUMBER_WIDTH;
        let drag = DragValue::new(value)
            .speed(speed)
            .suffix(if has_room { self.unit } else { "" })
            .update_while_editing(false)
            .custom_formatter(move |v, _| if is_edited { exact(v) } else { significant(v) })
            .custom_parser(|text| match parsed(text, self.unit, others) {
                // Left as it was read, it is as it was.
                Ok(_) if text.trim() == significant(before) => Some(before),
                Ok(value) => Some(value),
                Err(told) => {
                    *error.borrow_mut() = Some(told);
                    None
                }
            });
        let response = ui.add(drag);
        let response = if has_room { response } else { response.on_hover_text(format!("In{}.", self.unit)) };
        (response, error.into_inner())
    }
}

/// A name, then what `add` adds, which it labels by the name's id; the name's response.
fn labelled_row(ui: &mut Ui, name: &str, add: impl FnOnce(&mut Ui, Id)) -> Response {
    let text = RichText::new(name).color(ui.visuals().text_color());
    // Its own identity: a drag goes on where a line comes or goes above it.
    let scope = UiBuilder::new().scope_id(ui.scope_id().with((name, "row")));
    ui.scope_builder(scope, |ui| named(ui, Label::new(text).selectable(false).sense(Sense::click()), name, add).0).inner
}

/// A name, then whatever `add` adds, labelled by it; the name's response.
pub fn named_row(ui: &mut Ui, name: &str, add: impl FnOnce(&mut Ui) -> Response) -> Response {
    labelled_row(ui, name, |ui, label| {
        add(ui).labelled_by(label);
    })
}

/// Gives a slider what a row has left beside its number.
pub fn fit_slider(ui: &mut Ui) {
    let spacing = ui.spacing().item_spacing.x;
    // Numbers of one width, so that sliders and numbers stand in columns.
    ui.spacing_mut().interact_size.x = NUMBER_WIDTH;
    ui.spacing_mut().slider_width = (ui.available_width() - NUMBER_WIDTH - spacing).max(40.0);
}

/// A distance in metres with its unit; in centimetres only what is nearer than a hand's breadth, so
/// that the same distance reads the same everywhere.
pub fn distance_text(distance_m: f64) -> String {
    match distance_m {
        d if d.is_infinite() => "∞".into(),
        d if d.abs() < 0.0995 => format!("{} cm", significant(d * 100.0)),
        d => format!("{} m", significant(d)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field(range: RangeInclusive<f64>, log: Option<f64>) -> Field<'static> {
        Field { name: "x", help: "", unit: "", range, log, reset: None }
    }

    #[test]
    fn a_fine_drag_moves_by_a_share_of_the_slider() {
        assert_eq!(field(0.0..=10.0, None).moved(5.0, 0.1), 6.0);
        let log = field(0.1..=f64::INFINITY, Some(0.1));
        assert!((log.moved(1.0, 0.5) - 100.0).abs() < 1e-9, "half of four powers of ten");
        assert_eq!(log.moved(f64::INFINITY, 0.1), f64::INFINITY);
        assert_eq!(field(0.0..=10.0, None).moved(20.0, 0.1), 20.0, "what was typed beyond the end stays");
        assert_eq!(field(0.0..=10.0, None).moved(9.9, 0.1), 10.0);
    }
}
