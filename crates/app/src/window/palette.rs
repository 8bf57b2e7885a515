//! The command palette: type a few letters of what is to be done.

use super::App;
use super::action::Command;
use eframe::egui::{self, Context, Id, Key, Modal, RichText, ScrollArea, TextEdit, Ui};

/// Height of the list, points.
const HEIGHT: f32 = 320.0;

/// The palette's own state.
#[derive(Default)]
pub struct Palette {
    open: bool,
    text: String,
    chosen: usize,
}

impl Palette {
    /// Whether it is shown.
    pub fn is_open(&self) -> bool {
        self.open
    }

    /// Shows it, or hides it.
    pub fn toggle(&mut self) {
        *self = Self { open: !self.open, ..Self::default() };
    }
}

/// How well `name` answers to the typed `text`: all its words must occur; starts of words
/// count more. `None` if it does not.
fn score(name: &str, text: &str) -> Option<i32> {
    let name = name.to_lowercase();
    let mut total = 0;
    for word in text.to_lowercase().split_whitespace() {
        let at = name.find(word)?;
        let at_start = at == 0 || !name[..at].ends_with(char::is_alphanumeric);
        total += if at_start { 20 } else { 5 } - (at as i32).min(15) / 5;
    }
    Some(total)
}

impl App {
    /// Shows the palette while it is open, and does what is chosen.
    pub(super) fn show_palette(&mut self, ctx: &Context) {
        if !self.palette.open {
            return;
        }
        let mut found: Vec<(i32, Command)> = Vec::new();
        for command in self.commands() {
            found.extend(score(&command.name, &self.palette.text).map(|score| (score, command)));
        }
        found.sort_by_key(|(score, _)| -score);
        let commands: Vec<Command> = found.into_iter().map(|(_, command)| command).collect();
        let palette = &mut self.palette;
        let mut done = None;
        let modal = Modal::new(Id::unique("palette")).show(ctx, |ui| {
            ui.set_width(460.0);
            done = palette.ui(ui, &commands);
        });
        if modal.should_close() || done.is_some() {
            self.palette = Palette::default();
        }
        if let Some(index) = done {
            self.perform(ctx, commands[index].action.clone());
        }
    }
}

impl Palette {
    /// The field and the list; the index of the chosen command.
    fn ui(&mut self, ui: &mut Ui, commands: &[Command]) -> Option<usize> {
        let last = commands.len().saturating_sub(1);
        let moved = ui.input_mut(|i| {
            let down = i.count_and_consume_key(egui::Modifiers::NONE, Key::ArrowDown);
            let up = i.count_and_consume_key(egui::Modifiers::NONE, Key::ArrowUp);
            self.chosen = (self.chosen + down).saturating_sub(up).min(last);
            down + up > 0
        });
        let field = TextEdit::singleline(&mut self.text).hint_text("What to do …").desired_width(f32::INFINITY);
        let field = ui.add(field);
        let field = field.accessible_name("Command");
        if field.changed() {
            self.chosen = 0;
        }
        let entered = field.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
        if !field.has_focus() && !entered {
            field.request_focus();
        }
        if commands.is_empty() {
            ui.weak("Nothing is called so.");
            // As high as with a list: what shrank would stay small.
            ui.allocate_space(egui::vec2(0.0, HEIGHT));
            return None;
        }
        let mut done = entered.then_some(self.chosen.min(last));
        ScrollArea::vertical().max_height(HEIGHT).min_scrolled_height(HEIGHT).auto_shrink(false).show(ui, |ui| {
            for (index, command) in commands.iter().enumerate() {
                let keys = command.keys.map(|keys| ui.ctx().format_shortcut(&keys)).unwrap_or_default();
                let entry = egui::Button::selectable(index == self.chosen, command.name.as_str())
                    .right_text(RichText::new(keys).weak())
                    .min_size(egui::vec2(ui.available_width(), 0.0));
                let response = ui.add(entry);
                if response.clicked() {
                    done = Some(index);
                }
                if moved && index == self.chosen {
                    response.scroll_to_me(None);
                }
            }
        });
        done
    }
}

#[cfg(test)]
mod tests {
    use super::score;

    #[test]
    fn all_typed_words_must_occur_and_starts_of_words_come_first() {
        assert_eq!(score("Save state…", "open"), None);
        assert!(score("Save state…", "st sa").is_some());
        assert!(score("Scene: atrium", "scene").unwrap() > score("Lens that suits the scene", "cene").unwrap());
    }
}
