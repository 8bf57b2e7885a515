//! The system's own file dialog: on a thread, since it may take as long as it likes, and with
//! a word for where it does not come.

use eframe::egui::Context;
use std::path::PathBuf;
use std::pin::Pin;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

/// A dialog that is gone sooner was never there: nobody closes one so fast.
const NEVER_THERE: Duration = Duration::from_millis(400);

/// What is told where it did not come.
pub const NO_DIALOG: &str =
    "The system's file dialog did not open: it needs a desktop portal or zenity. Type the name here.";

/// What is told while it is awaited or open.
pub const WAITING: &str = "The system's file dialog is asked for. If it does not come, type the name here.";

type Dialog = Pin<Box<dyn Future<Output = Option<rfd::FileHandle>> + Send>>;

/// A dialog that was asked for.
pub struct Browsing {
    answer: Receiver<Option<PathBuf>>,
    since: Instant,
    /// Whether the window lost the keys to something, as to a dialog that opened.
    lost_focus: bool,
}

/// How it ended.
#[derive(Debug, PartialEq)]
pub enum Browsed {
    /// With a file.
    File(PathBuf),
    /// Without.
    Closed,
    /// It never was there.
    NeverThere,
}

impl Browsing {
    /// Asks for a file to read, or for one to write.
    pub fn start(ctx: &Context, title: &str, extensions: &[&str], saving: bool) -> Self {
        // Made here: some systems want dialogs to come from the main thread.
        let dialog = rfd::AsyncFileDialog::new().set_title(title).add_filter("Files", extensions);
        let future: Dialog = if saving { Box::pin(dialog.save_file()) } else { Box::pin(dialog.pick_file()) };
        let (sender, answer) = channel();
        let ctx = ctx.clone();
        std::thread::spawn(move || {
            let file = pollster::block_on(future);
            // Nobody listens any more where the field was closed meanwhile.
            let _ = sender.send(file.map(|file| file.path().to_owned()));
            ctx.request_repaint();
        });
        Self { answer, since: Instant::now(), lost_focus: false }
    }

    /// The end, once. `has_focus`: whether the window has the keys now.
    pub fn poll(&mut self, has_focus: bool) -> Option<Browsed> {
        self.lost_focus |= !has_focus;
        match self.answer.try_recv() {
            Err(TryRecvError::Empty) => None,
            Ok(Some(file)) => Some(Browsed::File(file)),
            // One that needs long to fail, as where a service has to start, takes no keys.
            Ok(None) if self.lost_focus && self.since.elapsed() >= NEVER_THERE => Some(Browsed::Closed),
            Ok(None) | Err(TryRecvError::Disconnected) => Some(Browsed::NeverThere),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answered(answer: Option<PathBuf>, after: Duration) -> Browsing {
        let (sender, receiver) = channel();
        sender.send(answer).expect("someone listens");
        let since = Instant::now().checked_sub(after).expect("the clock has run longer");
        Browsing { answer: receiver, since, lost_focus: false }
    }

    #[test]
    fn a_dialog_that_does_not_come_is_told_from_one_that_is_closed() {
        let long = Duration::from_secs(30);
        let mut closed = answered(None, long);
        closed.lost_focus = true;
        assert_eq!(closed.poll(true), Some(Browsed::Closed));
        assert_eq!(answered(None, long).poll(false), Some(Browsed::Closed));
        assert_eq!(answered(None, long).poll(true), Some(Browsed::NeverThere), "a service that did not start");
        assert_eq!(answered(None, Duration::ZERO).poll(false), Some(Browsed::NeverThere), "no service at all");
        let file = PathBuf::from("scene.glb");
        assert_eq!(answered(Some(file.clone()), Duration::ZERO).poll(true), Some(Browsed::File(file)));
    }

    #[test]
    fn one_that_is_awaited_has_not_ended_and_one_that_broke_was_never_there() {
        let (sender, answer) = channel();
        let mut browsing = Browsing { answer, since: Instant::now(), lost_focus: false };
        assert_eq!(browsing.poll(true), None);
        drop(sender);
        assert_eq!(browsing.poll(true), Some(Browsed::NeverThere));
    }
}
