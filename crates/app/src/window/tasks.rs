//! Work that takes longer than one would wait for: on a thread, with progress, and it can
//! be stopped.

use super::App;
use defocus_study::Step;
use eframe::egui::{Align2, Area, Context, Frame, Id, ProgressBar, vec2};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// What takes no longer is not spoken of while it goes on.
const SPOKEN_OF_AFTER: Duration = Duration::from_millis(500);

/// Height of a task's box with its gap, points.
const BOX: f32 = 66.0;

/// How far it has come.
#[derive(Clone, Debug, Default)]
struct Done {
    what: String,
    share: f32,
}

/// Work under way.
pub struct Task {
    name: String,
    done: Arc<Mutex<Done>>,
    stop: Arc<AtomicBool>,
    answer: Receiver<Result<String, String>>,
    since: Instant,
}

/// How a task ended.
pub enum Ended {
    /// What to tell.
    Well(String),
    /// Why it failed.
    Badly(String),
    /// As it was told to.
    Stopped,
}

impl Task {
    /// Starts `work`, which tells its progress and stops where that says so.
    pub fn start(
        name: String,
        ctx: &Context,
        work: impl FnOnce(&mut dyn FnMut(Step<'_>) -> ControlFlow<()>) -> Result<String, String> + Send + 'static,
    ) -> Self {
        let (sender, answer) = channel();
        let (done, stop) = (Arc::<Mutex<Done>>::default(), Arc::<AtomicBool>::default());
        let (told, asked, ctx) = (done.clone(), stop.clone(), ctx.clone());
        std::thread::spawn(move || {
            let waker = ctx.clone();
            let mut progress = |step: Step<'_>| {
                if let Ok(mut done) = told.lock() {
                    *done = Done { what: step.what.to_owned(), share: step.done as f32 / step.of.max(1) as f32 };
                }
                // A frame for each step and none between: what is timed is not disturbed.
                waker.request_repaint();
                if asked.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            };
            // Nobody listens any more where the window was closed meanwhile.
            let _ = sender.send(work(&mut progress));
            ctx.request_repaint();
        });
        Self { name, done, stop, answer, since: Instant::now() }
    }

    /// What it is called.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Shows how far it has come, with a button that stops it, above `row` others; the end,
    /// once.
    pub fn show(&mut self, ctx: &Context, row: usize) -> Option<Ended> {
        match self.answer.try_recv() {
            Ok(Ok(text)) => return Some(Ended::Well(text)),
            Ok(Err(_)) if self.stop.load(Ordering::Relaxed) => return Some(Ended::Stopped),
            Ok(Err(error)) => return Some(Ended::Badly(error)),
            Err(TryRecvError::Disconnected) => {
                return Some(Ended::Badly("the work stopped unexpectedly: the program's log says more".into()));
            }
            Err(TryRecvError::Empty) => {}
        }
        if let Some(wait) = SPOKEN_OF_AFTER.checked_sub(self.since.elapsed()) {
            ctx.request_repaint_after(wait);
            return None;
        }
        let done = self.done.lock().map(|done| done.clone()).unwrap_or_default();
        let area = Area::new(Id::unique(("progress", row)));
        let area = area.anchor(Align2::CENTER_BOTTOM, vec2(0.0, -60.0 - BOX * row as f32));
        area.show(ctx, |ui| {
            Frame::popup(ui.style()).show(ui, |ui| {
                ui.set_width(360.0);
                ui.label(&self.name);
                ui.horizontal(|ui| {
                    ui.add(ProgressBar::new(done.share).desired_width(280.0).text(done.what.as_str()));
                    // What tells no steps cannot be stopped between them.
                    let steps = done.share > 0.0 || !done.what.is_empty();
                    if steps && ui.button("Cancel").clicked() {
                        self.stop.store(true, Ordering::Relaxed);
                    }
                });
            });
        });
        None
    }
}

impl App {
    /// Shows what is under way, and tells what has ended.
    pub(super) fn show_tasks(&mut self, ctx: &Context) {
        let (mut row, messages) = (0, &mut self.messages);
        self.tasks.retain_mut(|task| {
            row += 1;
            match task.show(ctx, row - 1) {
                None => return true,
                Some(Ended::Well(text)) => messages.note(ctx, &text),
                Some(Ended::Badly(error)) => messages.error(ctx, &error),
                Some(Ended::Stopped) => messages.note(ctx, "Cancelled; nothing was written."),
            }
            false
        });
    }
}
