//! The table of a batch.

use crate::window::model::numbers::{exact, parsed, significant};
use crate::window::model::{BatchRow, MOST_BATCH_ROWS, MethodChoice};
use crate::window::ui::widgets::combo;
use defocus::methods;
use eframe::egui::{Button, DragValue, Grid, RichText, ScrollArea, Ui};

/// Height of the table, points; longer ones scroll.
const HEIGHT: f32 = 300.0;

/// Width of the list of methods, points: the longest name has room.
const METHOD_WIDTH: f32 = 215.0;

/// What is known of a row.
#[derive(Clone, Debug, PartialEq)]
pub enum BatchCells {
    /// It was not run as everything is now.
    NotRun,
    /// Why it could not be run.
    Failed(String),
    /// What was measured; what does not exist is `None`.
    Known {
        /// Mean CoC, px.
        mean_coc_px: Option<f64>,
        /// PSNR, dB.
        psnr_db: Option<f64>,
        /// Quality as seen, JOD.
        jod: Option<f64>,
        /// Mean FLIP.
        flip: Option<f64>,
        /// GPU time, ms.
        ms: Option<f64>,
    },
}

/// What the table is told.
pub struct BatchView<'a> {
    /// The rows.
    pub rows: &'a [BatchRow],
    /// What is known of each.
    pub cells: &'a [BatchCells],
    /// Whether it runs.
    pub is_running: bool,
}

/// What is to be done.
#[derive(Clone, Debug, PartialEq)]
pub enum BatchAction {
    /// Add the present aperture and focus with the methods of the panes.
    AddPanes,
    /// Add them with every method.
    AddAll,
    /// Give the row of that place other values.
    Change(usize, BatchRow),
    /// Take the row of that place away.
    Remove(usize),
    /// Show the row of that place in pane A.
    Show(usize),
    /// Take all rows away.
    Clear,
    /// Run all.
    Run,
    /// Save the results.
    Save,
}

/// Shows the table; what is to be done, if something is.
pub fn batch_panel(ui: &mut Ui, view: &BatchView<'_>) -> Option<BatchAction> {
    let mut action = buttons(ui, view);
    if view.rows.is_empty() {
        ui.weak("No rows yet. Set aperture, focus and methods, then add what the panes show.");
        return action;
    }
    ScrollArea::vertical().max_height(HEIGHT).auto_shrink([false, true]).show(ui, |ui| {
        Grid::new("batch").num_columns(10).striped(true).spacing([10.0, 4.0]).show(ui, |ui| {
            for name in ["", "E", "focus", "method", "CoC px", "PSNR dB", "JOD", "FLIP", "ms", ""] {
                ui.weak(name);
            }
            ui.end_row();
            for (index, (row, cells)) in view.rows.iter().zip(view.cells).enumerate() {
                if let Some(asked) = table_row(ui, index, row, cells) {
                    action = Some(asked);
                }
                ui.end_row();
            }
        });
    });
    action
}

fn buttons(ui: &mut Ui, view: &BatchView<'_>) -> Option<BatchAction> {
    let mut action = None;
    ui.horizontal(|ui| {
        let has_room = view.rows.len() < MOST_BATCH_ROWS;
        let has_rows = !view.rows.is_empty();
        let has_results = view.cells.iter().any(|cells| matches!(cells, BatchCells::Known { .. }));
        let offered = [
            (
                "Add panes",
                has_room,
                "The present aperture and focus with the method of each pane",
                BatchAction::AddPanes,
            ),
            ("Add all methods", has_room, "The present aperture and focus with every method", BatchAction::AddAll),
            (
                "Run",
                has_rows && !view.is_running,
                "Compares each row with its reference, beside the interface",
                BatchAction::Run,
            ),
            ("Save as CSV…", has_results, "What was measured, a line for each row", BatchAction::Save),
            ("Clear", has_rows && !view.is_running, "Takes all rows away", BatchAction::Clear),
        ];
        for (name, is_enabled, help, what) in offered {
            let button = ui.add_enabled(is_enabled, Button::new(name)).on_hover_text(help);
            if button.accessible_name(format!("Batch: {name}")).clicked() {
                action = Some(what);
            }
        }
    });
    action
}

fn table_row(ui: &mut Ui, index: usize, row: &BatchRow, cells: &BatchCells) -> Option<BatchAction> {
    let mut action = None;
    let number = index + 1;
    let show = ui.add(Button::new(number.to_string()).frame(false)).on_hover_text("Shows this state in pane A");
    if show.accessible_name(format!("Show row {number}")).clicked() {
        action = Some(BatchAction::Show(index));
    }
    let mut changed = row.clone();
    quantity(ui, &format!("E of row {number}"), " mm", &mut changed.aperture_mm);
    quantity(ui, &format!("Focus of row {number}"), " m", &mut changed.focus_m);
    method_list(ui, number, &mut changed.method);
    if changed != *row {
        action = Some(BatchAction::Change(index, changed));
    }
    results(ui, cells);
    let remove = ui.add(Button::new("×").frame(false)).on_hover_text("Takes this row away");
    if remove.accessible_name(format!("Remove row {number}")).clicked() {
        action = Some(BatchAction::Remove(index));
    }
    action
}

fn quantity(ui: &mut Ui, name: &str, unit: &str, value: &mut f64) {
    let before = *value;
    let drag = DragValue::new(value)
        .speed(0.01 * before.abs().clamp(0.01, 1000.0))
        .suffix(unit)
        .update_while_editing(false)
        .custom_formatter(|v, _| significant(v))
        .custom_parser(|text| match parsed(text, unit, &[]) {
            // Left as it was read, it is as it was.
            Ok(_) if text.trim() == significant(before) => Some(before),
            read => read.ok(),
        });
    ui.add(drag).accessible_name(name).on_hover_text(exact(before));
}

fn method_list(ui: &mut Ui, number: usize, method: &mut MethodChoice) {
    let about: Vec<_> = methods::all().iter().map(|m| m.about()).collect();
    let titles: Vec<&str> = about.iter().map(|a| a.title).collect();
    let before = about.iter().position(|a| a.id == method.id).unwrap_or(about.len());
    let mut chosen = before;
    let list = combo(ui, &format!("batch method {number}"), &mut chosen, &titles, METHOD_WIDTH);
    let params: Vec<String> = method.params.iter().map(|(key, value)| format!("{key} = {value}")).collect();
    let help = if params.is_empty() { "Default parameters".to_owned() } else { params.join(", ") };
    list.accessible_name(format!("Method of row {number}")).on_hover_text(help);
    if let Some(about) = about.get(chosen).filter(|_| chosen != before) {
        *method = MethodChoice::new(about.id);
    }
}

fn results(ui: &mut Ui, cells: &BatchCells) {
    let number = |v: &Option<f64>, digits: usize| v.map_or_else(|| "–".to_owned(), |v| format!("{v:.digits$}"));
    let texts = match cells {
        BatchCells::NotRun => ["", "", "", "", ""].map(str::to_owned),
        BatchCells::Failed(error) => {
            let text = RichText::new("cannot").color(ui.visuals().error_fg_color);
            ui.label(text).on_hover_text(error);
            ["", "", "", ""].iter().for_each(|text| drop(ui.label(*text)));
            return;
        }
        BatchCells::Known { mean_coc_px, psnr_db, jod, flip, ms } => {
            [number(mean_coc_px, 2), number(psnr_db, 2), number(jod, 2), number(flip, 4), number(ms, 2)]
        }
    };
    for text in texts {
        ui.label(RichText::new(text).monospace());
    }
}
