//! A name left of an input.

use super::style::NAME_WIDTH;
use eframe::egui::{Align, Color32, Id, Label, Layout, Response, TextStyle, Ui, vec2};

/// Whether a name has no room left of an input, and stands in a line of its own.
pub fn is_wide(ui: &Ui, name: &str) -> bool {
    let font = TextStyle::Body.resolve(ui.style());
    let width = ui.fonts_mut(|fonts| fonts.layout_no_wrap(name.to_owned(), font, Color32::PLACEHOLDER).size().x);
    width > NAME_WIDTH
}

/// The label of a name, and right of it what `add` adds, which takes the label's id. A name that
/// has no room there stands in a line of its own, since none is to be cut.
pub fn named<R>(ui: &mut Ui, label: Label, name: &str, add: impl FnOnce(&mut Ui, Id) -> R) -> (Response, R) {
    if is_wide(ui, name) {
        let label = ui.add(label);
        let added = ui.horizontal(|ui| {
            ui.add_space(NAME_WIDTH + ui.spacing().item_spacing.x);
            add(ui, label.id)
        });
        return (label, added.inner);
    }
    ui.horizontal(|ui| {
        let size = vec2(NAME_WIDTH, ui.spacing().interact_size.y);
        let layout = Layout::left_to_right(Align::Center);
        let label = ui.allocate_ui_with_layout(size, layout, |ui| {
            ui.set_min_width(NAME_WIDTH);
            ui.add(label)
        });
        let label = label.inner;
        let added = add(ui, label.id);
        (label, added)
    })
    .inner
}
