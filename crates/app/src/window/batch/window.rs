//! The batch's window, what it was asked to do, and what has come of it.

use super::run::{Outcome, run};
use crate::window::App;
use crate::window::action::Action;
use crate::window::engine::{Identity, RenderRequest};
use crate::window::model::{BatchRow, Edit, MethodChoice, Numbers};
use crate::window::tasks::Task;
use crate::window::ui::panels::{BatchAction, BatchCells, BatchView, batch_panel};
use defocus::display::Display;
use defocus::viewing::Viewing;
use defocus_study::results::CompareJson;
use defocus_study::table;
use eframe::egui::{Context, Window};
use std::sync::mpsc::{Receiver, channel};

/// What the task is called; there is one at a time.
const TASK: &str = "Batch";

/// All that an outcome depends on.
#[derive(Clone, PartialEq)]
struct Key {
    of: Identity,
    display: Display,
    viewing: Viewing,
}

/// Outcomes on their way, with what each is to depend on, by the rows' places.
struct Arriving {
    keys: Vec<Key>,
    outcomes: Receiver<(usize, Outcome)>,
}

/// The batch as it runs.
#[derive(Default)]
pub struct Batch {
    is_open: bool,
    arriving: Option<Arriving>,
    known: Vec<(Key, Outcome)>,
}

impl Batch {
    fn outcome(&self, key: &Key) -> Option<&Outcome> {
        self.known.iter().find(|(known, _)| known == key).map(|(_, outcome)| outcome)
    }
}

impl App {
    /// Opens the batch's window, or closes it.
    pub(in crate::window) fn toggle_batch(&mut self) {
        self.batch.is_open = !self.batch.is_open;
    }

    /// What an outcome of a row depends on, as everything is now.
    fn batch_key(&self, row: &BatchRow) -> Key {
        let render = RenderRequest::of(&self.document, self.eye_size_px(), row.lens(&self.document.lens));
        let of = Identity { world: self.engine.world(), method: row.method.clone(), render, samples: None };
        Key { of, display: self.document.display, viewing: self.document.viewing() }
    }

    /// Comparisons of the rows that were run and still hold, in the order of the rows.
    pub fn batch_results(&self) -> Vec<&CompareJson> {
        let keys = self.document.batch.iter().map(|row| self.batch_key(row));
        keys.filter_map(|key| self.batch.outcome(&key)?.as_ref().ok()).map(Box::as_ref).collect()
    }

    /// The batch's results as CSV.
    ///
    /// # Errors
    ///
    /// In a sentence, where no row was run.
    pub(in crate::window) fn batch_csv(&self) -> Result<String, String> {
        let results = self.batch_results();
        if results.is_empty() {
            return Err("no row of the batch was run yet: run it, then save its table".into());
        }
        table::csv(results).map_err(|e| e.to_string())
    }

    /// Takes in what has arrived, and shows the window while it is open.
    pub(in crate::window) fn show_batch(&mut self, ctx: &Context) {
        self.take_batch();
        if !self.batch.is_open {
            return;
        }
        let cells: Vec<BatchCells> = self.document.batch.iter().map(|row| self.batch_cells(row)).collect();
        let is_running = self.tasks.iter().any(|task| task.name() == TASK);
        let view = BatchView { rows: &self.document.batch, cells: &cells, is_running };
        let mut is_open = true;
        let window =
            Window::new("Batch").open(&mut is_open).default_width(700.0).default_pos([60.0, 110.0]).vscroll(false);
        let shown = window.show(ctx, |ui| batch_panel(ui, &view));
        self.batch.is_open = is_open;
        if let Some(action) = shown.and_then(|shown| shown.inner).flatten() {
            self.take_batch_action(ctx, action);
        }
    }

    fn batch_cells(&self, row: &BatchRow) -> BatchCells {
        match self.batch.outcome(&self.batch_key(row)) {
            None => BatchCells::NotRun,
            Some(Err(error)) => BatchCells::Failed(error.clone()),
            Some(Ok(json)) => {
                let result = json.results.first();
                let metrics = result.map(|r| r.metrics.clone()).unwrap_or_default();
                BatchCells::Known {
                    mean_coc_px: json.setting.coc.map(|coc| coc.mean_px),
                    psnr_db: metrics.psnr_db,
                    jod: metrics.jod,
                    flip: metrics.flip,
                    ms: result.and_then(|r| r.gpu_ms).map(|t| t.median),
                }
            }
        }
    }

    fn take_batch(&mut self) {
        let Some(Arriving { keys, outcomes }) = &self.batch.arriving else { return };
        for (index, outcome) in outcomes.try_iter() {
            if let Some(key) = keys.get(index) {
                self.batch.known.retain(|(known, _)| known != key);
                self.batch.known.push((key.clone(), outcome));
            }
        }
    }

    fn take_batch_action(&mut self, ctx: &Context, action: BatchAction) {
        match action {
            BatchAction::AddPanes => {
                let reference = self.document.reference();
                let panes = self.document.panes.iter().filter(|pane| Some(pane.id) != reference);
                let methods = panes.map(|pane| pane.method.clone()).collect();
                self.edit(Edit::AddToBatch(methods));
            }
            BatchAction::AddAll => {
                let about = defocus::methods::all().into_iter().map(|method| method.about());
                let real_time = about.filter(|about| !["accumulation", "raytrace"].contains(&about.id));
                self.edit(Edit::AddToBatch(real_time.map(|about| MethodChoice::new(about.id)).collect()));
            }
            BatchAction::Change(index, row) => self.edit(Edit::BatchRow(index, row)),
            BatchAction::Remove(index) => self.edit(Edit::RemoveBatchRow(index)),
            BatchAction::Show(index) => self.show_row(index),
            BatchAction::Clear => self.edit(Edit::ClearBatch),
            BatchAction::Run => self.run_batch(ctx),
            BatchAction::Save => self.perform(ctx, Action::SaveNumbers(Numbers::Batch)),
        }
    }

    /// Shows a row's state in pane A.
    fn show_row(&mut self, index: usize) {
        let Some(row) = self.document.batch.get(index).cloned() else { return };
        self.focus_motion.stop();
        self.edit(Edit::Lens(row.lens(&self.document.lens)));
        self.edit(Edit::Method(self.document.a, row.method));
    }

    fn run_batch(&mut self, ctx: &Context) {
        let rows = self.document.batch.clone();
        if rows.is_empty() || self.tasks.iter().any(|task| task.name() == TASK) {
            return;
        }
        let keys: Vec<Key> = rows.iter().map(|row| self.batch_key(row)).collect();
        // Each lens has a reference of its own.
        let Some(order) = self.order_without_truth() else { return };
        let (tell, outcomes) = channel();
        self.batch.arriving = Some(Arriving { keys, outcomes });
        let count = rows.len();
        self.tasks.push(Task::start(TASK.into(), ctx, move |progress| {
            run(&order, &rows, &tell, progress).map(|()| format!("The batch of {count} rows is done."))
        }));
    }
}
