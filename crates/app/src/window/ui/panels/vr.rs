//! Two eyes, and what a head-mounted display asks for.

use super::fields::{Field, distance_text};
use super::presets::preset_label;
use crate::window::model::numbers::significant;
use crate::window::model::same_but_focus;
use crate::window::ui::widgets::choice;
use defocus::lens::Lens;
use defocus::presets::{Headset, LensPreset, presets};
use defocus::stereo::{IPD_MM, Layout, MEAN_IPD_MM, REFRESH_HZ, Stereo, refresh_met};
use eframe::egui::{Button, RichText, Ui};
use glam::UVec2;

/// What the panel is told.
#[derive(Clone, Copy, Debug, Default)]
pub struct VrReadings {
    /// Whether what is shown can be seen from two places: an image cannot.
    pub is_scene: bool,
    /// Focal length of the projection, px, if there is a picture.
    pub focal_px: Option<f64>,
    /// Focus distance, metres.
    pub focus_m: f64,
    /// Size of one eye's picture, px.
    pub size_px: UVec2,
}

/// What is to be done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VrAction {
    /// Pictures of this width and height, px, an eye.
    PictureSize(u32, u32),
}

/// Edits stereo, and tells of the headset; what is to be done, if something is.
pub fn vr_panel(ui: &mut Ui, stereo: &mut Option<Stereo>, lens: &Lens, readings: VrReadings) -> Option<VrAction> {
    let headset = headset(ui, lens, readings.size_px);
    let mut on = stereo.is_some();
    ui.add_enabled_ui(readings.is_scene, |ui| {
        let help = "Two eyes, each with its own view and its own blur.";
        ui.checkbox(&mut on, "Stereo").on_hover_text(help).on_disabled_hover_text("An image has one viewpoint only.");
    });
    if on != stereo.is_some() {
        *stereo = on.then(Stereo::default);
    }
    if let Some(stereo) = stereo {
        eyes(ui, stereo, readings);
    }
    headset
}

fn eyes(ui: &mut Ui, stereo: &mut Stereo, readings: VrReadings) {
    let names = Layout::ALL.map(|(_, name)| name);
    let mut chosen = Layout::ALL.iter().position(|(layout, _)| *layout == stereo.layout).unwrap_or(0);
    let help = "Side by side for parallel or crossed eyes; anaglyphs for red and cyan glasses, red on the left eye.";
    choice(ui, "Eyes", help, &mut chosen, &names);
    stereo.layout = Layout::ALL[chosen.min(Layout::ALL.len() - 1)].0;
    let ipd = Field {
        name: "Eye distance",
        help: "Interpupillary distance. The mean of adults is 63 mm, nearly all have 45 to 80 mm (Dodgson 2004).",
        unit: " mm",
        range: IPD_MM,
        log: None,
        reset: Some(MEAN_IPD_MM),
    };
    ipd.show(ui, &mut stereo.ipd_mm);
    let window = Field {
        name: "Window at",
        help: "Depth of the window that both eyes look through, each by its own asymmetric frustum: what lies there has no disparity. Infinite for a head-mounted display, ds for a screen.",
        unit: " m",
        range: 0.2..=f64::INFINITY,
        log: Some(0.2),
        reset: Some(f64::INFINITY),
    };
    window.show(ui, &mut stereo.window_m);
    *stereo = stereo.repaired();
    if let Some(focal_px) = readings.focal_px {
        let disparity = stereo.disparity_px(focal_px, readings.focus_m);
        let text =
            format!("disparity at the focus, {}: {} px", distance_text(readings.focus_m), significant(disparity));
        ui.label(RichText::new(text).small().weak());
    }
}

/// What is known of the headset whose preset the lens is, and the size of its eye's picture.
fn headset(ui: &mut Ui, lens: &Lens, size_px: UVec2) -> Option<VrAction> {
    let shown = presets().into_iter().find(|preset| preset.headset.is_some() && is_lens_of(preset, lens));
    let Some((preset, Headset { eye_px, refresh_hz })) = shown.and_then(|p| Some((p.clone(), p.headset?))) else {
        ui.label(RichText::new("The lens is no headset's: Preset, under Lens, has some.").small().weak());
        return None;
    };
    let (width, height) = eye_px;
    let text = format!("{}: {width} x {height} px an eye, up to {refresh_hz} Hz", preset_label(&preset));
    ui.label(RichText::new(text).small()).on_hover_text(preset.source);
    let is_as_large = size_px == UVec2::new(width, height);
    let help = "Times and figures are those of pictures of one size: this is the headset's.";
    let button = ui.add_enabled(!is_as_large, Button::new("Picture as large as its eye"));
    button.on_hover_text(help).clicked().then_some(VrAction::PictureSize(width, height))
}

/// Whether a lens is a preset's, whatever its aperture's shape, its eye and its focus.
fn is_lens_of(preset: &LensPreset, lens: &Lens) -> bool {
    let shaped = Lens { aperture: lens.aperture.clone(), eye: lens.eye, ..preset.lens.clone() };
    // The pupil is the eye's and not the display's.
    same_but_focus(&Lens { aperture_diameter_mm: lens.aperture_diameter_mm, ..shaped }, lens)
}

/// Whether frames of `frame_ms` keep up with head-mounted displays, in words.
pub fn refresh_text(frame_ms: f64) -> String {
    let met = refresh_met(frame_ms);
    let fastest = REFRESH_HZ.iter().zip(met).filter(|(_, met)| *met).map(|(hz, _)| *hz).fold(0.0, f64::max);
    let missed = REFRESH_HZ.iter().zip(met).find(|(_, met)| !met).map(|(hz, _)| *hz);
    match (fastest, missed) {
        (0.0, _) => format!("misses {} Hz", REFRESH_HZ[0]),
        (fastest, Some(missed)) => format!("makes {fastest} Hz, not {missed}"),
        (fastest, None) => format!("makes {fastest} Hz"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_times_are_held_against_refresh_rates() {
        let cases = [
            (5.0, "makes 144 Hz"),
            (8.0, "makes 120 Hz, not 144"),
            (9.0, "makes 100 Hz, not 120"),
            (11.0, "makes 90 Hz, not 100"),
            (13.0, "makes 72 Hz, not 90"),
        ];
        for (ms, text) in cases {
            assert_eq!(refresh_text(ms), text);
        }
        assert_eq!(refresh_text(14.0), "misses 72 Hz");
        assert_eq!(refresh_text(f64::INFINITY), "misses 72 Hz");
    }
}
