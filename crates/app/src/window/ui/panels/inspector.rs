//! What lies under the pointer, in numbers, and how often values occur.

use super::fields::distance_text;
use crate::window::model::numbers::significant;
use defocus::display::{Display, LUMINANCE};
use defocus::histogram::Histogram;
use defocus::image::{ColorImage, Image};
use defocus::lens::Lens;
use eframe::egui::{
    self, Align2, Color32, Context, FontId, Grid, Id, Rect, RichText, Role, Sense, Stroke, StrokeKind, TextureHandle,
    TextureOptions, Ui, WidgetInfo, pos2, vec2,
};
use glam::{UVec2, Vec3};

/// Side of the magnified neighbourhood, points.
const MAGNIFIED: f32 = 135.0;

/// Height of a histogram, points.
const BARS_HEIGHT: f32 = 48.0;

/// Bins of a histogram.
const BINS: usize = 64;

/// The value of a pane under the pointer.
#[derive(Clone, Debug, PartialEq)]
pub struct PaneValue {
    /// Name of the pane.
    pub name: String,
    /// Linear scene-referred colour.
    pub color: Vec3,
    /// What the method did there, and what the pane shows from inside it: names and values
    /// with their units.
    pub numbers: Vec<(String, String)>,
    /// How many times smaller than in full the picture is that they are of: lengths in pixels
    /// are those of that picture.
    pub divisor: u32,
}

/// Everything that is known of a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Inspection {
    /// The pixel, from the top left.
    pub pixel: UVec2,
    /// Depth there, metres.
    pub depth_m: f64,
    /// The value in every pane.
    pub panes: Vec<PaneValue>,
    /// Linear colours around the pixel, which is in the middle.
    pub neighbourhood: ColorImage,
}

/// Shows what is known of the pixel under the pointer, and the histograms of the picture
/// (of its display values) and of the CoC over `depths_m`.
pub fn inspector_panel(
    ui: &mut Ui,
    inspection: Option<&Inspection>,
    lens: &Lens,
    display: &Display,
    picture: Option<&Histogram>,
    depths_m: Option<&[f32]>,
) {
    match inspection {
        Some(inspection) => {
            ui.horizontal_top(|ui| {
                magnified(ui, inspection, display);
                numbers(ui, inspection, lens);
            });
            values(ui, inspection, display);
        }
        None => {
            ui.weak("Point at the picture.");
        }
    }
    if let Some(histogram) = picture {
        let lit = format!("{} % clipped", significant(100.0 * clipped_share(histogram)));
        bars(ui, "Luminance histogram", histogram, ["0".into(), lit, "1".into()]);
    }
    if let (Some(depths_m), Ok(())) = (depths_m, lens.check()) {
        let histogram = coc_histogram(lens, depths_m);
        let range = histogram.range();
        let ends = [*range.start(), *range.end()].map(|c| format!("{} px", significant_signed(c)));
        let [low, high] = ends;
        bars(ui, "CoC histogram", &histogram, [low, "signed CoC".into(), high]);
    }
}

/// The neighbourhood, one square a pixel, the inspected one framed.
fn magnified(ui: &mut Ui, inspection: &Inspection, display: &Display) {
    let (rect, response) = ui.allocate_exact_size(vec2(MAGNIFIED, MAGNIFIED), Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "Neighbourhood"));
    response.on_hover_text("The pixels around the pointer.");
    let size = inspection.neighbourhood.size;
    let texture = magnified_texture(ui.ctx(), &inspection.neighbourhood, display);
    let painter = ui.painter_at(rect);
    let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    painter.image(texture.id(), rect, whole, Color32::WHITE);
    let cell = rect.size() / vec2(size.x.max(1) as f32, size.y.max(1) as f32);
    let middle = Rect::from_center_size(rect.center(), cell);
    painter.rect_stroke(middle, 0.0, Stroke::new(1.0, Color32::BLACK), StrokeKind::Outside);
    painter.rect_stroke(middle.expand(1.0), 0.0, Stroke::new(1.0, Color32::WHITE), StrokeKind::Outside);
}

fn magnified_texture(ctx: &Context, pixels: &ColorImage, display: &Display) -> TextureHandle {
    let id = Id::unique("neighbourhood");
    let shade = |c: &Vec3| {
        let [r, g, b] = display.encoded(*c).to_array().map(|v| (v * 255.0).round() as u8);
        Color32::from_rgb(r, g, b)
    };
    let size = [pixels.size.x as usize, pixels.size.y as usize];
    let image = egui::ColorImage::new(size, pixels.pixels.iter().map(shade).collect());
    let kept: Option<TextureHandle> = ctx.data(|d| d.get_temp(id));
    match kept {
        Some(mut texture) => {
            texture.set(image, TextureOptions::NEAREST);
            texture
        }
        None => {
            let texture = ctx.load_texture("neighbourhood", image, TextureOptions::NEAREST);
            ctx.data_mut(|d| d.insert_temp(id, texture.clone()));
            texture
        }
    }
}

fn numbers(ui: &mut Ui, inspection: &Inspection, lens: &Lens) {
    Grid::new("pixel").num_columns(2).spacing([12.0, 2.0]).show(ui, |ui| {
        let mut line = |name: &str, value: String, help: &str| {
            ui.weak(name).on_hover_text(help);
            ui.label(RichText::new(value).monospace()).on_hover_text(help);
            ui.end_row();
        };
        let UVec2 { x, y } = inspection.pixel;
        line("pixel", format!("{x}, {y}"), "From the top left corner of the picture.");
        line("depth", distance_text(inspection.depth_m), "Along the optical axis.");
        if lens.check().is_err() {
            return;
        }
        let c = lens.coc_diameter_px(inspection.depth_m);
        line(
            "CoC",
            format!("{} px", significant_signed(c)),
            "Diameter on the display, negative in front of the focus.",
        );
        let mm = lens.on_image_plane_mm(c.abs());
        line("", format!("{} mm", scientific(mm)), "Diameter on the image plane: the retina, the sensor.");
        let minutes = lens.arc_minutes(c.abs());
        line(
            "",
            format!("{}′", significant(minutes)),
            "Angle under which the eye sees it, in arc minutes; a good eye resolves one.",
        );
        let dob = format!("{} px", significant(0.5 * c.abs()));
        line("DoB", dob, "Degree of blur of the papers: sigma = C / 2.");
    });
}

/// Every pane's value: linear, then as displayed.
fn values(ui: &mut Ui, inspection: &Inspection, display: &Display) {
    for PaneValue { name, color, numbers, divisor } in &inspection.panes {
        ui.add(egui::Label::new(RichText::new(name).small().weak()).truncate());
        ui.horizontal(|ui| {
            let rgb = color.to_array().map(|v| significant(f64::from(v))).join(" ");
            ui.label(RichText::new(rgb).monospace()).on_hover_text("Linear red, green and blue.");
            let [r, g, b] = display.encoded(*color).to_array().map(|v| (v * 255.0).round() as u8);
            let (swatch, _) = ui.allocate_exact_size(vec2(12.0, 12.0), Sense::hover());
            ui.painter().rect_filled(swatch, 2.0, Color32::from_rgb(r, g, b));
            let encoded = RichText::new(format!("{r} {g} {b}")).monospace();
            ui.label(encoded).on_hover_text("As displayed, with exposure and tone map.");
        });
        ui.horizontal_wrapped(|ui| {
            if *divisor > 1 && !numbers.is_empty() {
                let text = RichText::new(format!("in the picture at 1/{divisor}:")).small();
                let help = "The full picture was drawn beside the interface, on a device that keeps nothing of what is inside the method.";
                ui.label(text.color(ui.visuals().warn_fg_color)).on_hover_text(help);
            }
            for (name, value) in numbers {
                ui.weak(name);
                let value = ui.label(RichText::new(value).monospace());
                value.on_hover_text("From inside the method, of this pixel.");
                ui.add_space(6.0);
            }
        });
    }
}

/// Luminance of the display values of a picture, from 0 to 1.
pub fn image_histogram(picture: &ColorImage, display: &Display) -> Histogram {
    let values = picture.pixels.iter().map(|c| f64::from(display.encoded(*c).dot(LUMINANCE)));
    Histogram::of(values, 0.0..=1.0, BINS)
}

/// Share of the values in the last bin: as bright as the display can.
fn clipped_share(histogram: &Histogram) -> f64 {
    let last = histogram.counts().last().copied().unwrap_or(0);
    last as f64 / histogram.total().max(1) as f64
}

/// The signed CoC over a sample of depths, within the range that 98 % of them have.
fn coc_histogram(lens: &Lens, depths_m: &[f32]) -> Histogram {
    let coc = lens.coc();
    let mut diameters: Vec<f64> =
        depths_m.iter().map(|d| coc.at_depth(f64::from(*d))).filter(|c| c.is_finite()).collect();
    diameters.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let rank = (share * diameters.len().saturating_sub(1) as f64).round() as usize;
        diameters.get(rank).copied().unwrap_or(0.0)
    };
    let (low, high) = (at(0.01).min(0.0), at(0.99).max(0.0));
    // Everything in focus is one bar in the middle.
    let margin = if high - low < 1e-6 { 1.0 } else { 0.0 };
    Histogram::of(diameters.iter().copied(), (low - margin)..=(high + margin), BINS)
}

/// Bars with a text at both ends and in the middle.
fn bars(ui: &mut Ui, name: &str, histogram: &Histogram, texts: [String; 3]) {
    ui.add_space(4.0);
    ui.label(RichText::new(name).small().weak());
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), BARS_HEIGHT + 14.0), Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, name));
    let painter = ui.painter_at(rect);
    let area = Rect::from_min_max(rect.min, pos2(rect.right(), rect.bottom() - 14.0));
    painter.rect_filled(area, 2.0, ui.visuals().extreme_bg_color);
    let color = ui.visuals().text_color().gamma_multiply(0.7);
    let heights = histogram.heights();
    let width = area.width() / heights.len().max(1) as f32;
    for (i, height) in heights.iter().enumerate().filter(|(_, h)| **h > 0.0) {
        let left = area.left() + i as f32 * width;
        // The square root, so that what is rare is seen beside what is common.
        let top = area.bottom() - (height.sqrt() * area.height()).max(1.0);
        let bar = Rect::from_min_max(pos2(left, top), pos2(left + width, area.bottom()));
        painter.rect_filled(bar, 0.0, color);
    }
    let [low, middle, high] = texts;
    let weak = ui.visuals().weak_text_color();
    let y = rect.bottom();
    for (x, align, text) in [
        (rect.left(), Align2::LEFT_BOTTOM, low),
        (rect.center().x, Align2::CENTER_BOTTOM, middle),
        (rect.right(), Align2::RIGHT_BOTTOM, high),
    ] {
        painter.text(pos2(x, y), align, text, FontId::proportional(10.0), weak);
    }
}

/// The pixels around one, as far as `radius` in each direction; those beyond the border
/// repeat it.
pub fn neighbourhood(picture: &ColorImage, pixel: UVec2, radius: u32) -> ColorImage {
    let side = 2 * radius + 1;
    let at = |i: u32, centre: u32| i64::from(centre) + i64::from(i) - i64::from(radius);
    Image::from_fn(UVec2::splat(side), |x, y| picture.at_clamped(at(x, pixel.x), at(y, pixel.y)))
}

fn significant_signed(v: f64) -> String {
    if v < 0.0 { format!("−{}", significant(-v)) } else { significant(v) }
}

/// Three digits also of what is very small.
fn scientific(v: f64) -> String {
    if v != 0.0 && v.abs() < 1e-3 { format!("{v:.2e}") } else { significant(v) }
}
