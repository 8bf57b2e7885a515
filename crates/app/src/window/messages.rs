//! What went wrong, as toasts: the cause and what to do about it.

use eframe::egui;
use egui_notify::{Anchor, Toast, ToastLevel, Toasts};
use std::collections::VecDeque;
use std::time::Duration;

/// Columns of a toast's text: a toast does not wrap by itself.
const COLUMNS: usize = 64;

/// Time for two or three sentences, which is what an error is.
const SHOWN_FOR: Duration = Duration::from_secs(15);

/// Time for a line that confirms what one did.
const NOTE_FOR: Duration = Duration::from_secs(4);

/// Messages that can be read again.
const MOST_KEPT: usize = 20;

/// Messages for the user.
pub struct Messages {
    toasts: Toasts,
    last: Option<String>,
    /// What was told, the newest first.
    told: VecDeque<String>,
    later: Option<String>,
}

impl Default for Messages {
    fn default() -> Self {
        let toasts = Toasts::default().with_anchor(Anchor::BottomLeft).with_margin(egui::vec2(16.0, 56.0));
        Self { toasts, last: None, told: VecDeque::new(), later: None }
    }
}

impl Messages {
    /// Shows an error long enough to be read; the same one is not piled up.
    pub fn error(&mut self, ctx: &egui::Context, text: &str) {
        if self.last.as_deref() == Some(text) && !self.toasts.is_empty() {
            return;
        }
        log::error!("{text}");
        let color = ctx.global_style().visuals.error_fg_color;
        // Own symbol, and no cross to close it: the library's are not in egui's fonts.
        let mut toast = Toast::custom(wrapped(text), ToastLevel::Custom("!".into(), color));
        toast.duration(SHOWN_FOR).closable(false).show_progress_bar(false);
        self.toasts.add(toast);
        self.keep(text);
        self.last = Some(text.into());
    }

    fn keep(&mut self, text: &str) {
        self.told.push_front(text.into());
        self.told.truncate(MOST_KEPT);
    }

    /// What was told, the newest first.
    pub fn told(&self) -> impl Iterator<Item = &str> {
        self.told.iter().map(String::as_str)
    }

    /// Shows an error as soon as there is a window to show it in.
    pub fn error_later(&mut self, text: String) {
        self.later = Some(text);
    }

    /// Tells that something was done.
    pub fn note(&mut self, ctx: &egui::Context, text: &str) {
        let color = ctx.global_style().visuals.text_color();
        let mut toast = Toast::custom(wrapped(text), ToastLevel::Custom("·".into(), color));
        toast.duration(NOTE_FOR).closable(false).show_progress_bar(false);
        self.toasts.add(toast);
        self.keep(text);
    }

    /// The last error.
    pub fn last_error(&self) -> Option<&str> {
        self.last.as_deref()
    }

    /// Whether one is to be seen.
    pub fn has_any(&self) -> bool {
        !self.toasts.is_empty()
    }

    /// Takes them all away.
    pub fn dismiss(&mut self) {
        self.toasts.dismiss_all_toasts();
    }

    /// Draws what is to be seen.
    pub fn show(&mut self, ctx: &egui::Context) {
        if let Some(text) = self.later.take() {
            self.error(ctx, &text);
        }
        self.toasts.show(ctx);
    }
}

/// The text in lines of at most [`COLUMNS`] characters, longer words cut. The frames that
/// a shader compiler draws around lines go: the interface's font has no such letters.
fn wrapped(text: &str) -> String {
    let mut lines = vec![String::new()];
    let text: String = text.chars().map(|c| if ('\u{2500}'..='\u{257f}').contains(&c) { ' ' } else { c }).collect();
    for word in text.split_whitespace() {
        let letters: Vec<char> = word.chars().collect();
        for piece in letters.chunks(COLUMNS) {
            let piece: String = piece.iter().collect();
            let line = lines.last_mut().expect("there is always a line");
            if line.is_empty() {
                *line = piece;
            } else if line.chars().count() + 1 + piece.chars().count() <= COLUMNS {
                line.push(' ');
                line.push_str(&piece);
            } else {
                lines.push(piece);
            }
        }
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_hold_every_letter_and_none_is_too_long() {
        let text = format!("a file {} is damaged: {}", "x".repeat(150), "use another one ".repeat(12));
        let lines = wrapped(&text);
        assert!(lines.lines().all(|line| line.chars().count() <= COLUMNS));
        let letters = |s: &str| s.chars().filter(|c| !c.is_whitespace()).collect::<String>();
        assert_eq!(letters(&lines), letters(&text));
    }
}
