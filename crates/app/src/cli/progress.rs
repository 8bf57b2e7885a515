//! Progress bars, and interruptions.

use anyhow::Context;
use defocus_study::Step;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Within this time a second signal is the same interruption, sent to the program and to its
/// process group: `timeout` does so.
const ONE_INTERRUPTION: Duration = Duration::from_millis(500);

/// What a shell expects of a program that was interrupted: 128 + SIGINT.
pub const EXIT_INTERRUPTED: u8 = 130;

/// From now on Ctrl-C is noted instead of ending the program: work stops at its next step,
/// and what was being written is removed. A second Ctrl-C ends the program at once.
pub fn catch_interrupts() -> anyhow::Result<()> {
    let mut first: Option<Instant> = None;
    let handler = move || {
        INTERRUPTED.store(true, Ordering::SeqCst);
        if first.get_or_insert_with(Instant::now).elapsed() > ONE_INTERRUPTION {
            std::process::exit(EXIT_INTERRUPTED.into());
        }
    };
    ctrlc::set_handler(handler).context("cannot listen for Ctrl-C")
}

/// Whether Ctrl-C was pressed.
pub fn interrupted() -> bool {
    INTERRUPTED.load(Ordering::SeqCst)
}

/// An error once Ctrl-C was pressed: asked before anything is written.
pub fn check_interrupt() -> anyhow::Result<()> {
    anyhow::ensure!(!interrupted(), "interrupted");
    Ok(())
}

/// A bar on standard error; none if that is no terminal.
pub struct Bar(ProgressBar);

impl Bar {
    /// A bar, unless `quiet`.
    pub fn new(quiet: bool) -> Self {
        let hidden = quiet || !std::io::stderr().is_terminal();
        let target = if hidden { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(Some(0), target);
        let style = ProgressStyle::with_template("{msg:14} {wide_bar} {pos}/{len}  {eta} left");
        Self(bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar())))
    }

    /// Shows a step; stops the work once Ctrl-C was pressed.
    pub fn step(&self, step: Step<'_>) -> ControlFlow<()> {
        if self.0.message() != step.what {
            self.0.set_message(step.what.to_owned());
            self.0.reset_eta();
        }
        self.0.set_length(step.of.into());
        self.0.set_position(step.done.into());
        if interrupted() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
