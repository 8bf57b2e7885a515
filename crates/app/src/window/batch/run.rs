//! Runs the rows, those of one lens together: they share its reference.

use crate::window::compared::{Bench, Order, Watched, own_truth, said, setting};
use crate::window::model::BatchRow;
use defocus::lens::Lens;
use defocus::methods::Method;
use defocus_study::compare::{CompareRequest, compare, runnable};
use defocus_study::results::CompareJson;
use defocus_study::timing::Rounds;
use defocus_study::{Progress, Step, StudyError};
use std::sync::mpsc::Sender;

/// Timed runs of each method.
const RUNS: u32 = 5;

/// The outcome of a row: a comparison with one result.
pub type Outcome = Result<Box<CompareJson>, String>;

/// Rows by their places, those of one lens together, in the order of the first of each.
fn by_lens(order: &Order, rows: &[BatchRow]) -> Vec<(Lens, Vec<usize>)> {
    let mut groups: Vec<(Lens, Vec<usize>)> = Vec::new();
    for (index, row) in rows.iter().enumerate() {
        let lens = row.lens(&order.document.lens);
        match groups.iter_mut().find(|(known, _)| *known == lens) {
            Some((_, members)) => members.push(index),
            None => groups.push((lens, vec![index])),
        }
    }
    groups
}

/// Runs `rows` and tells each outcome with the row's place. A row that cannot be run says so and
/// holds up no other.
///
/// # Errors
///
/// In a sentence: a device or view that cannot be had, or that `progress` asked to stop.
pub fn run(
    order: &Order,
    rows: &[BatchRow],
    tell: &Sender<(usize, Outcome)>,
    progress: &mut Progress<'_>,
) -> Result<(), String> {
    let mut bench = Bench::open(order)?;
    let mut watched = Watched::over(&order.activity);
    let groups = by_lens(order, rows);
    let of = groups.len() as u32;
    for (done, (lens, members)) in (0..).zip(groups) {
        let outcome = {
            // Steps within a lens are told as parts of it.
            let mut progress = |step: Step<'_>| {
                let text = format!("lens {} of {of}: {}", done + 1, step.what);
                let parts = 100 * done + 100 * step.done.min(step.of) / step.of.max(1);
                progress(Step { what: &text, done: parts, of: 100 * of })
            };
            run_lens(order, &mut bench, &lens, (rows, &members), &mut watched, &mut progress)
        };
        match outcome {
            Ok(outcomes) => outcomes.into_iter().for_each(|told| {
                // Nobody listens any more where the window was closed meanwhile.
                let _ = tell.send(told);
            }),
            Err(Stop::Asked) => return Err(said(&StudyError::Stopped)),
            Err(Stop::Failed(error)) => members.iter().for_each(|index| {
                let _ = tell.send((*index, Err(error.clone())));
            }),
        }
    }
    Ok(())
}

enum Stop {
    Asked,
    Failed(String),
}

impl From<StudyError> for Stop {
    fn from(error: StudyError) -> Self {
        match error {
            StudyError::Stopped => Self::Asked,
            other => Self::Failed(other.to_string()),
        }
    }
}

fn run_lens(
    order: &Order,
    bench: &mut Bench,
    lens: &Lens,
    (rows, members): (&[BatchRow], &[usize]),
    watched: &mut Watched<'_>,
    progress: &mut Progress<'_>,
) -> Result<Vec<(usize, Outcome)>, Stop> {
    lens.check().map_err(|e| Stop::Failed(said(&e)))?;
    let document = &order.document;
    let stopped = said(&StudyError::Stopped);
    let truth = own_truth(&bench.source, &mut bench.view, document, lens, progress)
        .map_err(|error| if error == stopped { Stop::Asked } else { Stop::Failed(error) })?;
    let depth_m = bench.view.depth_m(&bench.gpu).as_ref().clone();
    let mut outcomes = Vec::new();
    for index in members {
        let built: Box<dyn Method> = match rows[*index].method.build() {
            Ok(method) => method,
            Err(error) => {
                outcomes.push((*index, Err(error)));
                continue;
            }
        };
        let (methods, not_run) = runnable(vec![built], &bench.view);
        if let Some(left) = not_run.into_iter().next() {
            outcomes.push((*index, Err(left.reason)));
            continue;
        }
        let (display, viewing) = (document.display, document.viewing());
        let rounds = Rounds { warmup: 1, runs: RUNS, redraw: false };
        let request = CompareRequest { lens, methods: &methods, truth: truth.as_ref(), display, viewing, rounds };
        let mut step = |step: Step<'_>| watched.step(step, progress);
        let outcome = match compare(&bench.gpu, &mut bench.view, &request, &mut step).map_err(Stop::from) {
            Ok(comparison) => {
                let setting = setting(&bench.gpu, &bench.source, document, &bench.view, lens, &depth_m);
                Ok(Box::new(CompareJson::new(setting, viewing, truth.as_ref(), &comparison, Vec::new())))
            }
            Err(Stop::Failed(error)) => Err(error),
            Err(stop) => return Err(stop),
        };
        outcomes.push((*index, outcome));
    }
    Ok(outcomes)
}
