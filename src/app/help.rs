//! Keys and mouse on one sheet.

use eframe::egui::{self, Align2, Grid, RichText, Window, vec2};

const SHEET: &[(&str, &str)] = &[
    ("Click", "Focus on what lies there"),
    ("Drag", "Orbit; turn on the spot while flying"),
    ("Right-drag, shift-drag", "Move across"),
    ("Scroll, pinch", "Nearer and farther"),
    ("W A S D, Q E", "Fly forwards, sideways, down and up; faster with shift"),
    ("R", "Camera as the scene has it"),
    ("C", "Circle of confusion"),
    ("B", "Compare two methods"),
    ("X", "Swap them"),
    ("Ctrl and +, −, 0", "Size of the interface"),
    ("Escape", "Take messages away"),
    ("?", "This sheet"),
];

/// Shows the sheet while `open`.
pub fn show(ctx: &egui::Context, open: &mut bool) {
    let window = Window::new("Keys and mouse").open(open).anchor(Align2::CENTER_CENTER, vec2(0.0, 0.0));
    window.collapsible(false).resizable(false).show(ctx, |ui| {
        Grid::new("keys").num_columns(2).spacing([20.0, 6.0]).show(ui, |ui| {
            for (keys, what) in SHEET {
                ui.label(RichText::new(*keys).strong());
                ui.label(*what);
                ui.end_row();
            }
        });
    });
}
