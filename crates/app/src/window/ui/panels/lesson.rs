//! The card of a lesson: its sentence, what to drag, and the way on.

use super::fields::Field;
use crate::window::model::Lesson;
use eframe::egui::{Align, Button, Layout, RichText, Ui};

/// Text that is read from the last row, points.
const SENTENCE: f32 = 18.0;

/// The task below it, points.
const TASK: f32 = 15.0;

/// What the card is told.
pub struct LessonView<'a> {
    /// The lesson.
    pub lesson: &'a Lesson,
    /// Its place, from 0.
    pub index: usize,
    /// How many there are.
    pub of: usize,
    /// The one thing to drag, as it is.
    pub value: f64,
}

/// What is to be done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LessonAction {
    /// Go to the lesson of that place, from 0.
    Go(usize),
    /// Go back to what was shown before the first one.
    End,
    /// Give the one thing to drag this value.
    Drag(f64),
}

/// Shows the card; what is to be done, if something is.
pub fn lesson_card(ui: &mut Ui, view: &LessonView<'_>) -> Option<LessonAction> {
    let LessonView { lesson, index, of, value } = view;
    let mut action = None;
    ui.horizontal(|ui| {
        ui.label(RichText::new(format!("{} of {of}: {}", index + 1, lesson.title)).size(TASK).strong());
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if ui.button("End lesson").on_hover_text("Back to what was shown before (Escape)").clicked() {
                action = Some(LessonAction::End);
            }
            let next = ui.add_enabled(index + 1 < *of, Button::new("Next"));
            if next.accessible_name("Next lesson").on_hover_text("Next lesson (Page down)").clicked() {
                action = Some(LessonAction::Go(index + 1));
            }
            let back = ui.add_enabled(*index > 0, Button::new("Back"));
            if back.accessible_name("Lesson before").on_hover_text("Lesson before (Page up)").clicked() {
                action = Some(LessonAction::Go(index - 1));
            }
            if ui.button("Again").on_hover_text("This lesson as it began").clicked() {
                action = Some(LessonAction::Go(*index));
            }
        });
    });
    ui.label(RichText::new(lesson.sentence).size(SENTENCE).color(ui.visuals().strong_text_color()));
    ui.label(RichText::new(lesson.task).size(TASK));
    let (name, unit, range) = lesson.dragged.about();
    let name = format!("Drag: {name}");
    let field = Field { name: &name, help: lesson.task, unit, range, log: None, reset: None };
    let mut dragged = *value;
    if field.show(ui, &mut dragged) {
        action = Some(LessonAction::Drag(dragged));
    }
    action
}
