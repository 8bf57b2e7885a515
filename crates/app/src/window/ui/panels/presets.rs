//! The list of lenses, those of the program and one's own.

use crate::window::model::same_but_focus;
use crate::window::ui::widgets::{combo, row};
use defocus::lens::Lens;
use defocus::presets::{LensPreset, presets};
use eframe::egui::PopupCloseBehavior::CloseOnClickOutside;
use eframe::egui::containers::menu::{MenuButton, MenuConfig};
use eframe::egui::{TextEdit, Ui};

/// First entry of the list: the lens follows the scene.
const AUTOMATIC: &str = "Suits the scene";

/// Room for the button beside the list, points.
const SAVE_WIDTH: f32 = 58.0;

/// What was chosen.
#[derive(Clone, Debug, PartialEq)]
pub enum PresetChoice {
    /// A lens that suits what is shown.
    Automatic,
    /// This one, with the focus where it is.
    Lens(Lens),
}

/// The list and the name under which the present lens is to be saved.
#[derive(Clone, Debug, Default)]
pub struct PresetList {
    new_name: String,
}

impl PresetList {
    /// Shows the list; what was chosen, if anything. Saving adds to `own`.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        lens: &Lens,
        automatic: bool,
        own: &mut Vec<LensPreset>,
    ) -> Option<PresetChoice> {
        let mut known = presets();
        let built_in = known.len();
        known.extend(own.iter().cloned());
        // The built-in ones say nothing about the aperture's shape.
        let shaped = |i: usize, p: &LensPreset| {
            let aperture = if i < built_in { lens.aperture.clone() } else { p.lens.aperture.clone() };
            Lens { aperture, eye: lens.eye, ..p.lens.clone() }
        };
        let matching = known.iter().enumerate().position(|(i, p)| same_but_focus(&shaped(i, p), lens));
        let labels: Vec<String> = known.iter().map(preset_label).collect();
        let mut names = vec![AUTOMATIC];
        names.extend(labels.iter().map(String::as_str));
        let before = if automatic { 0 } else { matching.map_or(names.len(), |i| i + 1) };
        if before == names.len() {
            names.push("Own");
        }
        let mut chosen = before;
        let shown = matching.filter(|_| !automatic).and_then(|i| known.get(i));
        let help = shown.map_or("Lenses with known numbers.".to_owned(), |p| format!("{}\n\n{}", p.title, p.source));
        row(ui, "Preset", "", |ui| {
            let width = ui.available_width() - SAVE_WIDTH;
            let list = combo(ui, "preset", &mut chosen, &names, width).on_hover_text(help);
            let menu = MenuButton::new("Save").config(MenuConfig::new().close_behavior(CloseOnClickOutside));
            let (save, _) = menu.ui(ui, |ui| self.save_menu(ui, lens, &known[..built_in], own, matching));
            save.on_hover_text("Save this lens as a preset, or forget one");
            list
        });
        let changed = chosen != before;
        match (changed, chosen) {
            (false, _) => None,
            (true, 0) => Some(PresetChoice::Automatic),
            (true, i) => known.get(i - 1).map(|preset| PresetChoice::Lens(with_focus(shaped(i - 1, preset), lens))),
        }
    }

    /// Saves the present lens under a name, or forgets the one that is chosen.
    fn save_menu(
        &mut self,
        ui: &mut Ui,
        lens: &Lens,
        built_in: &[LensPreset],
        own: &mut Vec<LensPreset>,
        matching: Option<usize>,
    ) {
        let own_index = matching.and_then(|i| i.checked_sub(built_in.len()));
        ui.horizontal(|ui| {
            let label = ui.label("Save as");
            let name = TextEdit::singleline(&mut self.new_name).hint_text("name").desired_width(120.0);
            ui.add(name).labelled_by(label.id);
            let name = self.new_name.trim().to_owned();
            let taken = built_in.iter().any(|p| p.name == name);
            let usable = !name.is_empty() && !taken && lens.check().is_ok();
            let save = ui.add_enabled(usable, eframe::egui::Button::new("Save preset"));
            let why = if taken { "A built-in preset has this name." } else { "Give it a name first." };
            if save.on_hover_text("Adds this lens to the list.").on_disabled_hover_text(why).clicked() {
                own.retain(|p| p.name != name);
                let (title, source) = ("Saved in the window".into(), "Saved in the window.".into());
                own.push(LensPreset { name, title, source, lens: lens.clone(), headset: None, screen: None });
                self.new_name.clear();
                ui.close();
            }
            if let Some(index) = own_index.filter(|i| *i < own.len())
                && ui.button("Forget").on_hover_text("Takes this preset off the list.").clicked()
            {
                own.remove(index);
                ui.close();
            }
        });
    }
}

/// What a preset is called in a list: a headset by its maker's name, others by their own.
pub fn preset_label(preset: &LensPreset) -> String {
    let product = preset.headset.and(preset.title.rsplit_once('(')).and_then(|(_, rest)| rest.strip_suffix(')'));
    product.unwrap_or(&preset.name).to_owned()
}

/// A preset's lens focused where the present one is; farther, if no image forms there.
fn with_focus(preset: Lens, present: &Lens) -> Lens {
    let focused = Lens { focus_distance_m: present.focus_distance_m, ..preset.clone() };
    if focused.check().is_ok() { focused } else { preset }
}
