//! The eye and the display before it, and what follows from them.

use super::fields::{Field, distance_text, named_row};
use crate::window::model::EyeSettings;
use crate::window::model::numbers::significant;
use crate::window::ui::widgets::choice;
use defocus::eye::{
    BLUR_DETECTION_D, Comfort, ComfortZone, Eye, Pupil, Refraction, amplitude_d, conflict_d, eye_presets,
};
use defocus::lens::{Lens, MM_PER_M};
use defocus::viewing::{PEAK_CD_M2, PX_PER_DEGREE, Screen, Viewing};
use eframe::egui::{RichText, Ui};

/// Shows the panel, which changes the settings.
pub fn eye_panel(ui: &mut Ui, settings: &mut EyeSettings) {
    let EyeSettings { lens, pupil, age_years, screen, ppd } = settings;
    named_eye(ui, lens, age_years);
    pupil_rows(ui, lens, pupil, age_years, screen);
    refraction_rows(ui, &mut lens.eye, age_years);
    chromatic_row(ui, &mut lens.eye, screen);
    ui.separator();
    display_rows(ui, lens, screen, ppd);
    ui.separator();
    consequences(ui, lens, screen, *ppd);
}

/// Eyes by name.
fn named_eye(ui: &mut Ui, lens: &mut Lens, age_years: &mut Option<f64>) {
    let all = eye_presets();
    let is_it = |preset: &defocus::eye::EyePreset| {
        preset.refraction == lens.eye.refraction && *age_years == Some(preset.age_years)
    };
    let mut names: Vec<&str> = all.iter().map(|preset| preset.title).collect();
    let before = all.iter().position(is_it).unwrap_or(all.len());
    names.push("Own");
    let mut chosen = before;
    let help = "Eyes to start from. They wear no glasses.";
    if choice(ui, "Eye", help, &mut chosen, &names)
        && let Some(preset) = all.get(chosen)
    {
        lens.eye.refraction = preset.refraction;
        *age_years = Some(preset.age_years);
        lens.eye.accommodation_d = Some(amplitude_d(preset.age_years));
    }
}

fn pupil_rows(ui: &mut Ui, lens: &mut Lens, pupil: &mut Option<Pupil>, age_years: &Option<f64>, screen: &Screen) {
    let mut follows = pupil.is_some();
    let help = "E follows light and age: Watson and Yellott, A Unified Formula for Light-Adapted Pupil Size (2012), for a field of 60 degrees and both eyes.";
    named_row(ui, "Pupil", |ui| ui.checkbox(&mut follows, "by light and age").on_hover_text(help));
    if follows != pupil.is_some() {
        let luminance_cd_m2 = screen.adapting_cd_m2();
        *pupil = follows.then(|| Pupil { luminance_cd_m2, ..Pupil::default() });
    }
    let Some(pupil) = pupil else { return };
    let luminance = Field {
        name: "Adapted to",
        help: "Luminance that the eye is adapted to. The display's: 18 % of its white, and what it reflects.",
        unit: " cd/m²",
        range: 0.01..=10_000.0,
        log: Some(0.01),
        reset: Some(screen.adapting_cd_m2()),
    };
    luminance.show(ui, &mut pupil.luminance_cd_m2);
    pupil.age_years = age_years.unwrap_or(Pupil::default().age_years).clamp(20.0, 83.0);
    *pupil = pupil.repaired();
    lens.aperture_diameter_mm = pupil.diameter_mm();
}

fn refraction_rows(ui: &mut Ui, eye: &mut Eye, age_years: &mut Option<f64>) {
    let mut limited = age_years.is_some();
    let help = "How near the eye can focus falls with age: 18.5 - 0.3 age dioptres, Hofstetter (1950). Without it the eye focuses as near as is asked.";
    named_row(ui, "Accommodation", |ui| ui.checkbox(&mut limited, "limited by age").on_hover_text(help));
    if limited != age_years.is_some() {
        *age_years = limited.then_some(30.0);
        eye.accommodation_d = age_years.map(amplitude_d);
    }
    if let Some(age) = age_years {
        let field = Field { name: "Age", help, unit: " years", range: 8.0..=83.0, log: None, reset: Some(30.0) };
        if field.show(ui, age) {
            *age = age.clamp(0.0, 120.0);
            eye.accommodation_d = Some(amplitude_d(*age).min(Eye::MOST_ACCOMMODATION_D));
        }
    }
    let field = |name, help, unit, range, reset| Field { name, help, unit, range, log: None, reset: Some(reset) };
    let mut refraction = eye.refraction;
    let help = "Sphere of the glasses that the eye needs and does not wear: negative for the short-sighted.";
    field("Sphere", help, " D", -10.0..=10.0, 0.0).show(ui, &mut refraction.sphere_d);
    let help = "Cylinder of those glasses: an elliptical blur that turns with depth. Methods that cannot render it say so and blur as the mean meridian does.";
    field("Cylinder", help, " D", -6.0..=6.0, 0.0).show(ui, &mut refraction.cylinder_d);
    if refraction.cylinder_d != 0.0 {
        let help = "Axis of the cylinder, counterclockwise for whoever faces the eye (ISO 8429).";
        field("Axis", help, "°", 0.0..=180.0, 90.0).show(ui, &mut refraction.axis_deg);
    }
    let most = |value: f64, most: f64| value.clamp(-most, most);
    eye.refraction = Refraction {
        sphere_d: most(refraction.sphere_d, Refraction::MOST_SPHERE_D),
        cylinder_d: most(refraction.cylinder_d, Refraction::MOST_CYLINDER_D),
        axis_deg: refraction.axis_deg.clamp(0.0, 180.0),
    };
}

fn chromatic_row(ui: &mut Ui, eye: &mut Eye, screen: &Screen) {
    let mut is_on = eye.chromatic.is_some();
    let [r, g, b] = screen.primaries_nm;
    let help = format!(
        "Each of the display's primaries ({r}, {g} and {b} nm) has its own focus, green's being the focus distance: Thibos et al., The Chromatic Eye (1992); Cholewiak et al., ChromaBlur (2017)."
    );
    named_row(ui, "Colours", |ui| ui.checkbox(&mut is_on, "chromatic aberration").on_hover_text(help));
    eye.chromatic = is_on.then(|| eye.chromatic.unwrap_or(screen.primaries_nm));
}

fn display_rows(ui: &mut Ui, lens: &Lens, screen: &mut Screen, ppd: &mut Option<f64>) {
    let own = Viewing::of(lens, *screen).px_per_degree;
    let mut value = ppd.unwrap_or(own);
    let field = Field {
        name: "Judged at",
        help: "Pixels per degree at which FLIP and JOD look at pictures: the lens's own, DPI ds pi / 180, unless you set another.",
        unit: " px/deg",
        range: 5.0..=120.0,
        log: None,
        reset: Some(own),
    };
    if field.show(ui, &mut value) {
        let value = value.clamp(*PX_PER_DEGREE.start(), *PX_PER_DEGREE.end());
        *ppd = Some(value).filter(|value| *value != own);
    }
    let (low, high) = (*PEAK_CD_M2.start(), *PEAK_CD_M2.end());
    let usual = Screen::default();
    let contrast = screen.peak_cd_m2 / screen.black_cd_m2.max(1e-9 * screen.peak_cd_m2);
    let peak = Field {
        name: "White",
        help: "Luminance of the display's white. Its contrast stays.",
        unit: " cd/m²",
        range: 10.0..=2000.0,
        log: Some(10.0),
        reset: Some(usual.peak_cd_m2),
    };
    if peak.show(ui, &mut screen.peak_cd_m2) {
        screen.peak_cd_m2 = screen.peak_cd_m2.clamp(low, high);
        screen.black_cd_m2 = screen.peak_cd_m2 / contrast;
    }
    let ambient = Field {
        name: "Light on it",
        help: "Light that falls on the screen: 250 lux in an office, 0 in a head-mounted display.",
        unit: " lux",
        range: 0.0..=1000.0,
        log: None,
        reset: Some(usual.ambient_lux),
    };
    ambient.show(ui, &mut screen.ambient_lux);
    screen.ambient_lux = screen.ambient_lux.clamp(0.0, 100_000.0);
    *screen = screen.repaired();
}

/// What follows from eye and display, in numbers.
fn consequences(ui: &mut Ui, lens: &Lens, screen: &Screen, ppd: Option<f64>) {
    if lens.check().is_err() {
        return;
    }
    let told = |ui: &mut Ui, text: String, help: &str| {
        ui.label(RichText::new(text).small()).on_hover_text(help);
    };
    if let Some(why) = lens.eye.out_of_reach(1.0 / lens.focus_distance_m) {
        ui.label(RichText::new(why).small().color(ui.visuals().warn_fg_color));
    }
    let viewing = Viewing::of(lens, *screen).with_ppd(ppd);
    let px_per_d = lens.px_per_dioptre();
    told(
        ui,
        format!("K {} px · {} px/deg", significant(lens.k_px()), significant(viewing.px_per_degree)),
        "Blur of what is infinitely far, and pixels of the display in a degree.",
    );
    let [least, most] = [*BLUR_DETECTION_D.start(), *BLUR_DETECTION_D.end()];
    told(
        ui,
        format!(
            "blur is seen from {} to {} px ({least} to {most} D; {} px a dioptre)",
            significant(least * px_per_d),
            significant(most * px_per_d),
            significant(px_per_d)
        ),
        "Defocus at which blur begins to be detected in foveal vision: Wang and Ciuffreda (2005), Sebastian, Burge and Geisler (2015).",
    );
    let display_m = lens.screen_distance_mm / MM_PER_M;
    let [near_m, far_m] = ComfortZone::default().distances_m(display_m);
    let comfort = match ComfortZone::default().judge(lens.focus_distance_m, display_m) {
        Comfort::Comfortable => "comfortable",
        Comfort::TooNear => "too near for comfort",
        Comfort::TooFar => "too far for comfort",
    };
    told(
        ui,
        format!(
            "vergence differs from the screen at {} by {} D, {comfort}: comfort {} – {}",
            distance_text(display_m),
            significant(conflict_d(lens.focus_distance_m, display_m)),
            distance_text(near_m),
            distance_text(far_m)
        ),
        "Conflict of vergence and accommodation where the eyes look at the focus distance, and the zone of comfort before a screen at ds: Shibata et al. (2011). For a head-mounted display ds is to be its focal distance.",
    );
}
