//! The parameters of a pane's method.

use crate::window::action::Action;
use crate::window::model::{Edit, MethodChoice, PaneState};
use crate::window::ui::named::is_wide;
use crate::window::ui::widgets::{self, group, number_of};
use defocus::methods::{self, Method, Param};
use eframe::egui::Ui;

/// Lines of parameters that are always in sight: with those of the lens they fill one screen of 720
/// points. What has no room in them is folded.
const IN_SIGHT: usize = 2;

/// Shows the parameters; what is to be done.
pub fn method_group(ui: &mut Ui, pane: &PaneState) -> Option<Action> {
    let Ok(mut method) = pane.method.build() else { return None };
    let id = method.about().id;
    let mut choice = pane.method.clone();
    if !as_published_row(ui, method.as_ref(), &mut choice) {
        let mut plain = methods::by_id(id).ok();
        let defaults = plain.iter_mut().flat_map(|plain| plain.params());
        let defaults: Vec<Option<f64>> = defaults.map(|param| number_of(&param)).collect();
        let mut params: Vec<(Param<'_>, Option<f64>)> = method.params().into_iter().zip(defaults).collect();
        let further = params.split_off(in_sight(ui, &params));
        let mut changes = rows(ui, params);
        if !further.is_empty() {
            let is_changed = further.iter().any(|(param, _)| choice.params.contains_key(param.key));
            let title = format!("More of the method: {}{}", further.len(), if is_changed { ", changed" } else { "" });
            group(ui, &title, false, |ui| changes.extend(rows(ui, further)));
        }
        for param in method.params().iter().filter(|p| changes.contains(&p.key)) {
            choice.params.insert(param.key.into(), param.text());
        }
        if !choice.params.is_empty() && ui.button("Defaults").on_hover_text("All parameters as they were").clicked() {
            choice = MethodChoice { as_built: choice.as_built, ..MethodChoice::new(id) };
        }
    }
    (choice != pane.method).then(|| Edit::Method(pane.id, choice).into())
}

/// How many of the parameters are in sight.
fn in_sight(ui: &Ui, params: &[(Param<'_>, Option<f64>)]) -> usize {
    let mut lines = 0;
    let ends = params.iter().map(|(param, _)| {
        lines += if is_wide(ui, param.label) { 2 } else { 1 };
        lines
    });
    let ends: Vec<usize> = ends.collect();
    // The fold has a line too, which a single one may take instead.
    if ends.last().is_none_or(|all| *all <= IN_SIGHT + 1) {
        return params.len();
    }
    ends.iter().take_while(|end| **end <= IN_SIGHT).count()
}

/// A row for each parameter with its default; the keys of those that were changed.
fn rows(ui: &mut Ui, params: Vec<(Param<'_>, Option<f64>)>) -> Vec<&'static str> {
    let mut changes = Vec::new();
    for (param, default) in params {
        let key = param.key;
        ui.push_id(key, |ui| {
            if widgets::param(ui, param, default) {
                changes.push(key);
            }
        });
    }
    changes
}

/// The switch of a method whose defaults go beyond what its source published: on, it is exactly
/// that, and off, those parameters are at their defaults. True if it was changed.
fn as_published_row(ui: &mut Ui, method: &dyn Method, choice: &mut MethodChoice) -> bool {
    let Some(mut is_on) = methods::is_as_published(method) else { return false };
    let help = "What was published, with its constants and choices, instead of what does better since";
    let changed = ui.checkbox(&mut is_on, "As published").on_hover_text(help).changed();
    if changed {
        for param in method.boxed().params() {
            match param.published {
                Some(value) if is_on => drop(choice.params.insert(param.key.into(), value.into())),
                Some(_) => drop(choice.params.remove(param.key)),
                None => {}
            }
        }
    }
    changed
}
