//! Keys and mouse on one sheet: the keys as the commands have them.

use super::App;
use eframe::egui::{Align2, Context, Grid, RichText, ScrollArea, Ui, Window, vec2};

/// What the mouse does, and keys that are held.
const MOUSE: &[(&str, &str)] = &[
    ("Click", "Focus on what lies there"),
    ("Alt-drag", "Focus follows the pointer"),
    ("Ctrl-drag", "Open the aperture to the right, close it to the left"),
    ("Drag", "Orbit; turn on the spot while flying"),
    ("Right-drag, shift-drag", "Move across"),
    ("Scroll", "Nearer and farther"),
    ("Ctrl-scroll, pinch", "Magnify the picture"),
    ("Middle-drag", "Move the magnified picture"),
    ("W A S D, Q E", "Fly; faster with shift"),
    ("B, held", "Blink: pane B in place of A"),
    ("Ctrl and +, −, 0", "Size of the interface"),
    ("Escape", "Take messages away"),
    ("?", "This sheet"),
];

impl App {
    /// Shows the sheet while it is open.
    pub(super) fn show_help(&mut self, ctx: &Context) {
        let mut open = self.help;
        let window = Window::new("Keys and mouse").open(&mut open).anchor(Align2::CENTER_CENTER, vec2(0.0, 0.0));
        window.collapsible(false).resizable(false).show(ctx, |ui| {
            let height = ui.ctx().content_rect().height() - 140.0;
            ScrollArea::vertical().max_height(height).min_scrolled_height(height).show(ui, |ui| {
                ui.horizontal_top(|ui| {
                    table(ui, "mouse", MOUSE.iter().map(|(keys, what)| ((*keys).to_owned(), (*what).to_owned())));
                    ui.add_space(24.0);
                    let commands = self.commands().into_iter();
                    let keys = commands.filter(|c| !c.name.starts_with("Pane ")).filter_map(|c| {
                        let keys = ctx.format_shortcut(&c.keys?);
                        Some((keys, c.name))
                    });
                    let numbers = [
                        ("1 … 6".to_owned(), "Pane of that number as A".to_owned()),
                        ("Shift and 1 … 6".to_owned(), "Pane of that number as B".to_owned()),
                    ];
                    table(ui, "keys", keys.chain(numbers));
                });
            });
        });
        self.help = open;
    }
}

fn table(ui: &mut Ui, salt: &str, rows: impl Iterator<Item = (String, String)>) {
    Grid::new(salt).num_columns(2).spacing([16.0, 5.0]).show(ui, |ui| {
        for (keys, what) in rows {
            ui.label(RichText::new(keys).strong());
            ui.label(what);
            ui.end_row();
        }
    });
}
