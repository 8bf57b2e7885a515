//! The panel with what can be set.

use super::App;
use super::document::{MethodChoice, Show};
use super::preferences::Navigation;
use super::widgets::{self, Real, choice};
use super::{style, timing};
use crate::aperture::{Aperture, BLADES, DEFAULT_SIGMA_PER_COC, MAX_SIGMA_PER_COC};
use crate::display::ToneMap;
use crate::lens::Lens;
use crate::presets::{LensPreset, presets};
use eframe::egui::{self, CollapsingHeader, Panel, RichText, ScrollArea, Ui};

/// First entry of the list of lenses.
const AUTOMATIC: &str = "Suits the scene";

/// Greatest mean CoC on the slider, px.
const MAX_MEAN_COC_PX: f64 = 40.0;

impl App {
    /// The panel on the right.
    pub(super) fn controls(&mut self, ui: &mut Ui) {
        Panel::right("controls").default_size(style::PANEL_WIDTH).size_range(280.0..=440.0).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                ui.add_space(4.0);
                self.lens_group(ui);
                self.method_group(ui);
                group(ui, "View", true, |ui| self.view_group(ui));
                group(ui, "Timing", true, |ui| timing::show(ui, &self.engine.history));
                ui.add_space(8.0);
            });
        });
    }

    fn lens_group(&mut self, ui: &mut Ui) {
        group(ui, "Lens", true, |ui| {
            self.preset(ui);
            self.focus(ui);
            self.mean_coc(ui);
            let lens = &mut self.document.lens;
            let mut set = false;
            let mut row = |name, help, unit, range, log, value: &mut f64| {
                set |= Real { name, help, unit, range, log }.show(ui, value);
            };
            row(
                "Aperture E",
                "Effective diameter of the aperture, the pupil; 0 is a pinhole.",
                " mm",
                0.0..=200.0,
                Some(0.01),
                &mut lens.aperture_diameter_mm,
            );
            row(
                "Focal length F",
                "Focal length of the lens. The focus distance must exceed it.",
                " mm",
                1.0..=300.0,
                Some(1.0),
                &mut lens.focal_length_mm,
            );
            row(
                "Image at dr",
                "Distance from the lens to the image plane: the retina, the sensor.",
                " mm",
                1.0..=300.0,
                Some(1.0),
                &mut lens.image_distance_mm,
            );
            row(
                "Screen at ds",
                "Distance from the lens to the screen on which the image is shown.",
                " mm",
                10.0..=10_000.0,
                Some(10.0),
                &mut lens.screen_distance_mm,
            );
            row(
                "Screen DPI",
                "Pixel density of that screen.",
                " px/mm",
                0.01..=100.0,
                Some(0.01),
                &mut lens.density_px_per_mm,
            );
            if set {
                self.document.automatic_lens = false;
            }
            aperture(ui, &mut self.document.lens.aperture);
        });
    }

    fn preset(&mut self, ui: &mut Ui) {
        let presets = presets();
        let mut names = vec![AUTOMATIC];
        names.extend(presets.iter().map(|p| p.name.as_str()));
        let lens = &self.document.lens;
        let matching = presets.iter().position(|p| same_but_focus(&p.lens, lens)).map(|i| i + 1);
        let before = if self.document.automatic_lens { 0 } else { matching.unwrap_or(names.len()) };
        if before == names.len() {
            names.push("Own");
        }
        let mut chosen = before;
        let help = matching.and_then(|i| presets.get(i - 1)).map_or("Lenses with known numbers.", |p| p.title.as_str());
        choice(ui, "Preset", help, &mut chosen, &names);
        if chosen == before {
            return;
        }
        if chosen == 0 {
            self.suit_lens();
        } else if let Some(LensPreset { lens, .. }) = presets.get(chosen - 1) {
            let focus_distance_m = self.document.lens.focus_distance_m;
            let aperture = self.document.lens.aperture.clone();
            self.document.lens = Lens { focus_distance_m, aperture, ..lens.clone() };
            self.document.automatic_lens = false;
        }
    }

    fn focus(&mut self, ui: &mut Ui) {
        let slider = Real {
            name: "Focus distance",
            help: "Distance of what is sharp. Or click it in the picture.",
            unit: " m",
            range: 0.05..=f64::INFINITY,
            log: Some(0.05),
        };
        if slider.show(ui, &mut self.document.lens.focus_distance_m) {
            self.viewport.stop_focusing();
        }
    }

    /// The papers' control variable: sets E.
    fn mean_coc(&mut self, ui: &mut Ui) {
        let Some(depths) = self.engine.depths_m(false) else { return };
        let lens = &self.document.lens;
        let Some(statistics) = lens.coc_statistics(depths.iter().copied()) else { return };
        let mut mean_px = statistics.mean_px;
        let slider = Real {
            name: "Mean blur",
            help: "Mean diameter of the circle of confusion over the picture: sets E.",
            unit: " px",
            range: 0.0..=MAX_MEAN_COC_PX,
            log: None,
        };
        if slider.show(ui, &mut mean_px)
            && let Some(scaled) = lens.with_mean_coc(mean_px.max(0.0), depths.iter().copied())
        {
            self.document.lens = scaled;
            self.document.automatic_lens = false;
        }
    }

    /// The parameters of pane A's method.
    fn method_group(&mut self, ui: &mut Ui) {
        let a = self.document.a;
        let number = self.document.index_of(a).map_or(1, |i| i + 1);
        let Some(pane) = self.document.pane_mut(a) else { return };
        let choice = &mut pane.method;
        let Ok(mut method) = choice.build() else { return };
        let about = method.about();
        group(ui, &format!("Pane {number}: {}", about.title), true, |ui| {
            ui.label(RichText::new(about.summary).small().weak());
            let mut changes = Vec::new();
            for param in method.params() {
                ui.push_id(param.key, |ui| {
                    let key = param.key;
                    if widgets::param(ui, param) {
                        changes.push(key);
                    }
                });
            }
            for param in method.params().iter().filter(|p| changes.contains(&p.key)) {
                choice.params.insert(param.key.into(), param.text());
            }
            if !choice.params.is_empty() && ui.button("Defaults").on_hover_text("All parameters as they were").clicked()
            {
                *choice = MethodChoice::new(about.id);
            }
        });
    }

    fn view_group(&mut self, ui: &mut Ui) {
        let (document, preferences) = (&mut self.document, &mut self.preferences);
        let mut tone_map = ToneMap::ALL.iter().position(|t| *t == document.display.tone_map).unwrap_or(0);
        let mut exposure = f64::from(document.display.exposure_ev);
        let slider = Real {
            name: "Exposure",
            help: "Brightness, as a power of two.",
            unit: " EV",
            range: -6.0..=6.0,
            log: None,
        };
        if slider.show(ui, &mut exposure) {
            document.display.exposure_ev = exposure.clamp(-20.0, 20.0) as f32;
        }
        let names = ["None", "Reinhard", "AgX"];
        if choice(ui, "Tone map", "How bright light is brought into the display's range.", &mut tone_map, &names) {
            document.display.tone_map = ToneMap::ALL[tone_map];
        }
        let px = |name, help, range, log| Real { name, help, unit: " px", range, log };
        let mut acceptable = f64::from(document.acceptable_coc_px);
        let help = "Greatest circle of confusion that counts as sharp: decides where the depth of field ends.";
        if px("Sharp up to", help, 0.25..=16.0, Some(0.25)).show(ui, &mut acceptable) {
            document.acceptable_coc_px = acceptable.clamp(0.01, 1000.0) as f32;
        }
        if document.panes.iter().any(|p| p.show == Show::Coc) {
            let mut scale = f64::from(document.coc_scale_px);
            let help = "Circle of confusion at the ends of the colour map.";
            if px("CoC scale", help, 1.0..=128.0, Some(1.0)).show(ui, &mut scale) {
                document.coc_scale_px = scale.clamp(0.01, 10_000.0) as f32;
            }
        }
        let mut navigation = usize::from(preferences.navigation == Navigation::Fly);
        let help =
            "Orbit: dragging moves around what is seen. Fly: dragging turns on the spot. W A S D Q E fly in both.";
        if choice(ui, "Navigation", help, &mut navigation, &["Orbit", "Fly"]) {
            preferences.navigation = if navigation == 1 { Navigation::Fly } else { Navigation::Orbit };
        }
        let help = "Focus moves to where one clicks in a quarter of a second, instead of at once.";
        widgets::row(ui, "Smooth focus", help, |ui| ui.checkbox(&mut preferences.smooth_focus, ""));
        let help = "Margin drawn around the picture, from which blur comes in over the border.";
        widgets::row(ui, "Overscan", help, |ui| {
            widgets::fit_slider(ui);
            ui.add(egui::Slider::new(&mut document.overscan_px, 0..=96).suffix(" px"))
        });
    }
}

fn same_but_focus(preset: &Lens, lens: &Lens) -> bool {
    let focus_distance_m = lens.focus_distance_m;
    *lens == Lens { focus_distance_m, aperture: lens.aperture.clone(), ..preset.clone() }
}

fn aperture(ui: &mut Ui, aperture: &mut Aperture) {
    let mut kind = match aperture {
        Aperture::Disc => 0,
        Aperture::Polygon { .. } => 1,
        Aperture::Gaussian { .. } => 2,
        Aperture::Image(_) => 3,
    };
    let names = ["Disc", "Polygon", "Gaussian", "Image"];
    // An image is opened from the command line; it can be left here, and kept.
    let names = if kind == 3 { &names[..] } else { &names[..3] };
    if choice(ui, "Aperture", "Shape of the aperture: that of an out-of-focus highlight.", &mut kind, names) {
        *aperture = match kind {
            0 => Aperture::Disc,
            1 => Aperture::Polygon { blades: 6, rotation_deg: 0.0, roundness: 0.0 },
            _ => Aperture::Gaussian { sigma_per_coc: DEFAULT_SIGMA_PER_COC },
        };
    }
    match aperture {
        Aperture::Polygon { blades, rotation_deg, roundness } => {
            widgets::row(ui, "Blades", "Corners of the aperture.", |ui| {
                widgets::fit_slider(ui);
                ui.add(egui::Slider::new(blades, BLADES))
            });
            let help = "Clockwise in the picture; at 0 a corner points up.";
            let mut typed = *rotation_deg;
            if (Real { name: "Rotation", help, unit: "°", range: 0.0..=360.0, log: None }).show(ui, &mut typed) {
                *rotation_deg = typed.clamp(-360.0, 360.0);
            }
            let help = "0 has straight edges, 1 is a disc.";
            let mut typed = *roundness;
            if (Real { name: "Roundness", help, unit: "", range: 0.0..=1.0, log: None }).show(ui, &mut typed) {
                *roundness = typed.clamp(0.0, 1.0);
            }
        }
        Aperture::Gaussian { sigma_per_coc } => {
            let help = "Standard deviation over the diameter of the circle of confusion.";
            let mut typed = *sigma_per_coc;
            let slider = Real { name: "Sigma per CoC", help, unit: "", range: 0.05..=MAX_SIGMA_PER_COC, log: None };
            if slider.show(ui, &mut typed) {
                *sigma_per_coc = typed.clamp(0.01, MAX_SIGMA_PER_COC);
            }
        }
        Aperture::Disc | Aperture::Image(_) => {}
    }
}

fn group(ui: &mut Ui, title: &str, open: bool, add: impl FnOnce(&mut Ui)) {
    let id = title.split(':').next().unwrap_or(title).to_owned();
    CollapsingHeader::new(RichText::new(title).strong()).id_salt(id).default_open(open).show_unindented(ui, |ui| {
        ui.add_space(2.0);
        add(ui);
        ui.add_space(6.0);
    });
}
