//! The lens: its numbers in the papers' symbols and in those of photographers and of
//! opticians, all views of one [`Lens`].

use super::fields::{Field, distance_text, named_row};
use super::plot::{PlotReadings, coc_plot};
use super::presets::{PresetChoice, PresetList};
use crate::window::model::numbers::{OtherUnit, significant};
use crate::window::model::{DistanceUnit, same_but_focus};
use crate::window::ui::widgets::group;
use defocus::focus::dioptres;
use defocus::lens::Lens;
use defocus::presets::LensPreset;
use eframe::egui::{Align, Layout, RichText, Ui, vec2};
use glam::UVec2;

/// The part of the panel with what is rarely changed.
pub const OPTICS: &str = "Optics and display";

/// Greatest mean CoC on the slider, px.
const MAX_MEAN_COC_PX: f64 = 40.0;

/// Relative difference of two fields of view that nobody sees, and that rounding of typed
/// numbers makes.
const SAME_VIEW: f64 = 0.01;

/// Display fields of view, degrees, that a number may have: a plane has less than 180.
const FOV_DEG: (f64, f64) = (0.1, 175.0);

/// Millimetres in an inch.
const MM_PER_INCH: f64 = 25.4;

/// What the panel is told about what is shown.
#[derive(Clone, Copy, Debug)]
pub struct LensReadings<'a> {
    /// A sample of the depths in view, metres, if they are known.
    pub depths_m: Option<&'a [f32]>,
    /// |c| up to which a point counts as sharp, px.
    pub acceptable_px: f64,
    /// Size of the picture, px.
    pub size_px: UVec2,
    /// Horizontal field of view of the picture, radians, if there is one.
    pub fov_x: Option<f64>,
    /// Whether there is a camera whose field of view can be changed.
    pub has_camera: bool,
}

/// What the user did in the panel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LensChanges {
    /// The lens was changed, other than in its focus distance.
    pub lens: bool,
    /// The focus distance was changed.
    pub focus: bool,
    /// The lens is to suit the scene again.
    pub suit_scene: bool,
    /// The camera is to have this horizontal field of view, radians.
    pub camera_fov_x: Option<f64>,
}

/// State of the panel itself.
#[derive(Clone, Debug, Default)]
pub struct LensPanel {
    presets: PresetList,
    /// Unit of the focus distance.
    pub unit: DistanceUnit,
    /// Whether the display is given by field of view and resolution instead of DPI.
    pub display_by_view: bool,
    /// Whether what is rarely changed is folded at first.
    pub optics_folded: bool,
    /// What fields are reset to: the preset chosen last, or the lens that suits the scene.
    base: Option<Lens>,
    /// Resolution of the display, px, where it is given so; that of the picture without.
    display_width_px: Option<f64>,
}

impl LensPanel {
    /// Shows the panel and changes the lens. `automatic`: the lens follows the scene.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        lens: &mut Lens,
        automatic: bool,
        own: &mut Vec<LensPreset>,
        readings: LensReadings<'_>,
    ) -> LensChanges {
        self.show_around(ui, lens, automatic, own, readings, &mut |_| {})
    }

    /// The same with what `below_focus` adds below the focus distance.
    pub fn show_around(
        &mut self,
        ui: &mut Ui,
        lens: &mut Lens,
        automatic: bool,
        own: &mut Vec<LensPreset>,
        readings: LensReadings<'_>,
        below_focus: &mut dyn FnMut(&mut Ui),
    ) -> LensChanges {
        let mut changes = LensChanges::default();
        match self.presets.show(ui, lens, automatic, own) {
            Some(PresetChoice::Automatic) => changes.suit_scene = true,
            Some(PresetChoice::Lens(chosen)) => {
                self.base = Some(chosen.clone());
                *lens = chosen;
                (changes.lens, self.display_width_px) = (true, None);
            }
            None => {}
        }
        // A lens that follows the scene is its own base; the focus alone may be moved.
        let base = match self.base.take() {
            Some(base) if !automatic || same_but_focus(&base, lens) => base,
            _ => lens.clone(),
        };
        changes.focus |= self.focus(ui, lens, &base);
        below_focus(ui);
        let plot = PlotReadings { depths_m: readings.depths_m, acceptable_px: readings.acceptable_px };
        if let Some(asked_m) = coc_plot(ui, lens, plot) {
            lens.focus_distance_m = asked_m;
            changes.focus = true;
        }
        limits(ui, lens, readings.acceptable_px);
        changes.lens |= mean_coc(ui, lens, readings.depths_m);
        changes.lens |= aperture(ui, lens, &base);
        changes.camera_fov_x = true_view(ui, lens, readings, &mut changes.lens);
        group(ui, OPTICS, !self.optics_folded, |ui| {
            self.unit_row(ui);
            changes.lens |= optics(ui, lens, &base);
            ui.separator();
            changes.lens |= self.display(ui, lens, &base, readings.size_px.x.max(1));
        });
        self.base = Some(base);
        changes
    }

    fn unit_row(&mut self, ui: &mut Ui) {
        named_row(ui, "Distance in", |ui| {
            ui.horizontal(|ui| {
                for (unit, symbol) in DistanceUnit::ALL {
                    ui.selectable_value(&mut self.unit, unit, symbol);
                }
            })
            .response
        });
    }

    fn focus(&mut self, ui: &mut Ui, lens: &mut Lens, base: &Lens) -> bool {
        let unit = self.unit;
        let nearest_m = 0.05;
        let (range, log) = match unit {
            DistanceUnit::Dioptres => (0.0..=dioptres(nearest_m), None),
            _ => (unit.of_metres(nearest_m)..=f64::INFINITY, Some(unit.of_metres(nearest_m))),
        };
        let symbol = DistanceUnit::ALL.iter().find(|(u, _)| *u == unit).map_or("", |(_, symbol)| *symbol);
        let help = "df: distance of what is sharp. c(d) = K (1 - df / d) is 0 there. Or click it in the picture. A dioptre is a reciprocal metre: 0 is infinity.";
        let field = Field {
            name: "Focus distance",
            help,
            unit: &format!(" {symbol}"),
            range,
            log,
            reset: Some(unit.of_metres(base.focus_distance_m)),
        };
        let mut value = unit.of_metres(lens.focus_distance_m);
        let changed = field.show(ui, &mut value);
        if changed {
            lens.focus_distance_m = unit.to_metres(value);
        }
        changed
    }

    /// The display by distance and density, or by field of view and resolution.
    fn display(&mut self, ui: &mut Ui, lens: &mut Lens, base: &Lens, picture_px: u32) -> bool {
        named_row(ui, "Display by", |ui| {
            ui.horizontal(|ui| {
                ui.selectable_value(&mut self.display_by_view, false, "pixel density");
                ui.selectable_value(&mut self.display_by_view, true, "field of view");
            })
            .response
        });
        let ds = Field {
            name: "Screen at ds",
            help: "ds: distance from the lens to the screen on which the image is shown. K = DPI ds/dr E F / (df - F): only DPI ds counts.",
            unit: " mm",
            range: 10.0..=10_000.0,
            log: Some(10.0),
            reset: Some(base.screen_distance_mm),
        };
        let mut changed = ds.show(ui, &mut lens.screen_distance_mm);
        if self.display_by_view {
            changed |= self.display_by_view(ui, lens, picture_px);
        } else {
            let dpi = Field {
                name: "Screen DPI",
                help: "DPI: pixels of that screen in a millimetre. K = DPI ds/dr E F / (df - F). Or type pixels per degree (25 px/deg) or per inch (96 px/in).",
                unit: " px/mm",
                range: 0.01..=100.0,
                log: Some(0.01),
                reset: Some(base.density_px_per_mm),
            };
            // Pixels in a degree at the middle of the screen: DPI ds pi / 180.
            let mm_per_degree = lens.screen_distance_mm * 1_f64.to_radians();
            let by_degree = OtherUnit { name: "px/deg", converted: &|density| density / mm_per_degree };
            let by_inch = OtherUnit { name: "px/in", converted: &|density| density / MM_PER_INCH };
            changed |= dpi.show_with(ui, &mut lens.density_px_per_mm, &[by_degree, by_inch]);
        }
        let density = lens.px_per_degree();
        let text = format!("{} pixels per degree at the middle of the screen", significant(density));
        ui.label(RichText::new(text).small().weak());
        changed
    }

    fn display_by_view(&mut self, ui: &mut Ui, lens: &mut Lens, picture_px: u32) -> bool {
        let picture_px = f64::from(picture_px);
        let mut width_px = self.display_width_px.unwrap_or(picture_px);
        let px = |width: f64| width.round().clamp(1.0, 65_536.0) as u32;
        let mut fov_deg = lens.display_fov_x(px(width_px)).to_degrees();
        let resolution = Field {
            name: "Resolution",
            help: "Pixels of the display from left to right. With the field of view it gives DPI = W / (2 ds tan(fov / 2)).",
            unit: " px",
            range: 320.0..=8192.0,
            log: Some(320.0),
            reset: Some(picture_px),
        };
        let mut changed = false;
        if resolution.show(ui, &mut width_px) {
            self.display_width_px = Some(f64::from(px(width_px)));
            changed = true;
        }
        let view = Field {
            name: "Field of view",
            help: "Horizontal angle under which the eye sees the display: 2 atan(W / (2 DPI ds)).",
            unit: " °",
            range: 1.0..=150.0,
            log: None,
            reset: None,
        };
        changed |= view.show(ui, &mut fov_deg);
        if changed {
            let fov_x = fov_deg.clamp(FOV_DEG.0, FOV_DEG.1).to_radians();
            *lens = lens.with_display_fov_x(px(width_px), fov_x);
        }
        changed
    }
}

/// E.
fn aperture(ui: &mut Ui, lens: &mut Lens, base: &Lens) -> bool {
    let field = Field {
        name: "Aperture E",
        help: "E: effective diameter of the aperture, the pupil; 0 is a pinhole. All blur is proportional to it: K = DPI ds/dr E F / (df - F).",
        unit: " mm",
        range: 0.0..=200.0,
        log: Some(0.01),
        reset: Some(base.aperture_diameter_mm),
    };
    field.show(ui, &mut lens.aperture_diameter_mm)
}

/// N, F and dr.
fn optics(ui: &mut Ui, lens: &mut Lens, base: &Lens) -> bool {
    let field = |name, help, unit, range, log, reset| Field { name, help, unit, range, log, reset };
    let mut changed = false;
    let help = "N = F / E: the same aperture as photographers write it, f/N. Infinite for a pinhole.";
    let mut f_number = lens.f_number();
    let reset = Some(base.f_number()).filter(|n| n.is_finite());
    if field("f-number", help, "", 0.5..=f64::INFINITY, Some(0.5), reset).show(ui, &mut f_number) && f_number > 0.0 {
        *lens = lens.with_f_number(f_number);
        changed = true;
    }
    let help = "F: focal length of the lens. The focus distance must exceed it, or no image forms.";
    let reset = Some(base.focal_length_mm);
    changed |= field("Focal length F", help, " mm", 1.0..=300.0, Some(1.0), reset).show(ui, &mut lens.focal_length_mm);
    let help = "dr: distance from the lens to the image plane, the retina or the sensor. The screen at ds is ds/dr times as large.";
    let reset = Some(base.image_distance_mm);
    changed | field("Image at dr", help, " mm", 1.0..=300.0, Some(1.0), reset).show(ui, &mut lens.image_distance_mm)
}

/// The papers' control variable: sets E. The row has its place also before the depths are known.
fn mean_coc(ui: &mut Ui, lens: &mut Lens, depths_m: Option<&[f32]>) -> bool {
    let statistics = depths_m.and_then(|depths| lens.coc_statistics(depths.iter().copied()));
    let field = Field {
        name: "Mean blur",
        help: "Mean diameter of the circle of confusion over the picture, the papers' control variable: sets E.",
        unit: " px",
        range: 0.0..=MAX_MEAN_COC_PX,
        log: None,
        reset: None,
    };
    let mut mean_px = statistics.map_or(0.0, |coc| coc.mean_px);
    let changed = ui.add_enabled_ui(statistics.is_some(), |ui| field.show(ui, &mut mean_px)).inner;
    let scaled =
        depths_m.filter(|_| changed).and_then(|depths| lens.with_mean_coc(mean_px.max(0.0), depths.iter().copied()));
    let is_scaled = scaled.is_some();
    if let Some(scaled) = scaled {
        *lens = scaled;
    }
    is_scaled
}

/// Where the depth of field begins and ends, and the hyperfocal distance; a lens that forms no
/// image has neither, and says so in the same place.
fn limits(ui: &mut Ui, lens: &Lens, acceptable_px: f64) {
    if let Err(error) = lens.check() {
        let text = RichText::new("no image forms").small().color(ui.visuals().warn_fg_color);
        ui.label(text).on_hover_text(error.to_string());
        return;
    }
    let (near_m, far_m) = lens.depth_of_field_m(acceptable_px);
    let text = format!(
        "sharp {} – {} · hyperfocal {}",
        distance_text(near_m),
        distance_text(far_m),
        distance_text(lens.hyperfocal_m(acceptable_px))
    );
    let help = format!(
        "Depths with a circle of confusion up to {} px. Focused at the hyperfocal distance, everything from half of it to infinity is that sharp.",
        significant(acceptable_px)
    );
    ui.label(RichText::new(text).small()).on_hover_text(help);
}

/// Warns where the display shows the picture under another angle than the camera took it,
/// and offers to make either true. The camera's new field of view, radians. The line has its
/// place also where there is nothing to warn of: what stands below does not move.
fn true_view(ui: &mut Ui, lens: &mut Lens, readings: LensReadings<'_>, changed: &mut bool) -> Option<f64> {
    let size = vec2(ui.available_width(), ui.spacing().interact_size.y);
    let layout = Layout::left_to_right(Align::Center);
    ui.allocate_ui_with_layout(size, layout, |ui| {
        ui.set_min_size(size);
        view_warning(ui, lens, readings, changed)
    })
    .inner
}

fn view_warning(ui: &mut Ui, lens: &mut Lens, readings: LensReadings<'_>, changed: &mut bool) -> Option<f64> {
    let camera_fov = readings.fov_x?;
    let display_fov = lens.display_fov_x(readings.size_px.x.max(1));
    let different = ((camera_fov - display_fov) / camera_fov).abs() > SAME_VIEW;
    if !different || !display_fov.is_finite() || display_fov <= 0.0 {
        return None;
    }
    let angle = |radians: f64| format!("{}°", significant(radians.to_degrees()));
    let (seen, shown) = (angle(camera_fov), angle(display_fov));
    let help = format!(
        "The camera sees {seen}, but on this display the picture spans {shown}: blur and perspective are not those of one eye."
    );
    let text = RichText::new(format!("{seen} shown as {shown}")).small().color(ui.visuals().warn_fg_color);
    ui.label(text).on_hover_text(help);
    let mut wanted = None;
    if readings.has_camera {
        let help = "Gives the camera the field of view under which the display shows the picture.";
        if ui.small_button("Fit the camera").on_hover_text(help).clicked() {
            let (low, high) = (FOV_DEG.0.to_radians(), FOV_DEG.1.to_radians());
            wanted = Some(display_fov.clamp(low, high));
        }
    }
    let help = "Gives the display the density at which the picture spans the camera's field of view.";
    if ui.small_button("Fit the display").on_hover_text(help).clicked() {
        *lens = lens.with_display_fov_x(readings.size_px.x.max(1), camera_fov);
        *changed = true;
    }
    wanted
}
