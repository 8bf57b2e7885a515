//! The aperture editor: kind, parameters, and the shape itself.

use super::fields::Field;
use crate::window::ui::widgets::choice;
use defocus::aperture::{Aperture, BLADES, DEFAULT_SIGMA_PER_COC, MAX_SIGMA_PER_COC};
use eframe::egui::{
    Color32, ColorImage, Context, Id, Rect, Role, Sense, TextureHandle, TextureOptions, Ui, WidgetInfo, pos2, vec2,
};
use glam::dvec2;

/// Side of the drawing, points.
const SIDE: f32 = 96.0;

/// Cells of the drawing along a side.
const CELLS: usize = 64;

/// What the aperture editor did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ApertureChange {
    /// The aperture was changed.
    pub changed: bool,
    /// An image is to be chosen.
    pub wants_image: bool,
}

/// Edits the aperture.
pub fn aperture_panel(ui: &mut Ui, aperture: &mut Aperture) -> ApertureChange {
    let mut change = ApertureChange::default();
    let names = ["Disc", "Polygon", "Gaussian", "Image"];
    let before = match aperture {
        Aperture::Disc => 0,
        Aperture::Polygon { .. } => 1,
        Aperture::Gaussian { .. } => 2,
        Aperture::Image(_) => 3,
    };
    let mut chosen = before;
    let help = "Intensity distribution over the aperture: the shape of a blurred point of light.";
    if choice(ui, "Aperture shape", help, &mut chosen, &names) && chosen != before {
        match chosen {
            0 => *aperture = Aperture::Disc,
            1 => *aperture = Aperture::polygon(6),
            2 => *aperture = Aperture::Gaussian { sigma_per_coc: DEFAULT_SIGMA_PER_COC },
            _ => change.wants_image = true,
        }
        change.changed = chosen != 3;
    }
    match aperture {
        Aperture::Polygon { blades, rotation_deg, roundness } => {
            change.changed |= polygon(ui, blades, rotation_deg, roundness);
        }
        Aperture::Gaussian { sigma_per_coc } => change.changed |= gaussian(ui, sigma_per_coc),
        Aperture::Image(image) => {
            ui.horizontal(|ui| {
                ui.weak(image.name());
                change.wants_image |= ui.button("Other image…").clicked();
            });
        }
        Aperture::Disc => {}
    }
    drawing(ui, aperture);
    change
}

fn polygon(ui: &mut Ui, blades: &mut u32, rotation_deg: &mut f64, roundness: &mut f64) -> bool {
    let (least, most) = (f64::from(*BLADES.start()), f64::from(*BLADES.end()));
    let mut count = f64::from(*blades);
    let field = |name, help, unit, range, reset| Field { name, help, unit, range, log: None, reset: Some(reset) };
    let help = "Blades of the diaphragm: corners of the polygon.";
    let mut changed = field("Blades", help, "", least..=most, 6.0).show(ui, &mut count);
    *blades = count.round().clamp(least, most) as u32;
    let help = "Distance of the edge from the centre, from straight blades (0) to the disc (1).";
    changed |= field("Roundness", help, "", 0.0..=1.0, 0.0).show(ui, roundness);
    *roundness = roundness.clamp(0.0, 1.0);
    let help = "Clockwise on the image; at 0 a corner points up.";
    changed |= field("Rotation", help, " °", -180.0..=180.0, 0.0).show(ui, rotation_deg);
    if !rotation_deg.is_finite() {
        *rotation_deg = 0.0;
    }
    changed
}

fn gaussian(ui: &mut Ui, sigma_per_coc: &mut f64) -> bool {
    let help = "Standard deviation of the blur over the diameter C of the circle of confusion; TVCG 2009 has sigma = C / 2, a disc C / 4.";
    let range = 0.05..=MAX_SIGMA_PER_COC;
    let field = Field { name: "Sigma / C", help, unit: "", range, log: None, reset: Some(DEFAULT_SIGMA_PER_COC) };
    let changed = field.show(ui, sigma_per_coc);
    *sigma_per_coc = sigma_per_coc.clamp(0.01, MAX_SIGMA_PER_COC);
    changed
}

/// The aperture as a bright shape, as a blurred point of light shows it; the ring is the
/// circle of confusion.
fn drawing(ui: &mut Ui, aperture: &Aperture) {
    if aperture.check().is_err() {
        return;
    }
    ui.vertical_centered(|ui| {
        let (rect, response) = ui.allocate_exact_size(vec2(SIDE, SIDE), Sense::hover());
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "Aperture drawing"));
        response.on_hover_text("A blurred point of light. The ring is the circle of confusion.");
        let texture = shape(ui.ctx(), aperture);
        let painter = ui.painter_at(rect);
        let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        painter.image(texture.id(), rect, whole, Color32::WHITE);
        let ring = (1.0, Color32::from_rgb(214, 94, 10));
        painter.circle_stroke(rect.center(), (0.5 * f64::from(SIDE) / reach(aperture)) as f32, ring);
    });
}

/// Half a side of the drawing in units of the CoC's radius.
fn reach(aperture: &Aperture) -> f64 {
    aperture.radius().max(1.0) * 1.06
}

/// The drawing, computed when the aperture changes.
fn shape(ctx: &Context, aperture: &Aperture) -> TextureHandle {
    let id = Id::unique("aperture drawing");
    let kept: Option<(Aperture, TextureHandle)> = ctx.data(|d| d.get_temp(id));
    if let Some((_, texture)) = kept.filter(|(of, _)| of == aperture) {
        return texture;
    }
    let cells = intensities(aperture, reach(aperture));
    let greatest = cells.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let shade = |value: &f64| Color32::from_gray((255.0 * (value / greatest).powf(1.0 / 2.2)).round() as u8);
    let image = ColorImage::new([CELLS, CELLS], cells.iter().map(shade).collect());
    let texture = ctx.load_texture("aperture drawing", image, TextureOptions::LINEAR);
    ctx.data_mut(|d| d.insert_temp(id, (aperture.clone(), texture.clone())));
    texture
}

/// Mean intensity in each cell of a square that reaches `reach` from the centre, row by row.
fn intensities(aperture: &Aperture, reach: f64) -> Vec<f64> {
    // 3 x 3 points a cell, so that edges are smooth.
    const POINTS: usize = 3;
    let at = |i: usize| (2.0 * (i as f64 + 0.5) / (CELLS * POINTS) as f64 - 1.0) * reach;
    let cell = |i: usize| {
        let (x, y) = (i % CELLS * POINTS, i / CELLS * POINTS);
        let points = (0..POINTS * POINTS).map(|p| dvec2(at(x + p % POINTS), at(y + p / POINTS)));
        points.map(|v| aperture.intensity(v)).sum::<f64>() / (POINTS * POINTS) as f64
    };
    (0..CELLS * CELLS).map(cell).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_drawing_holds_all_of_the_light() {
        for aperture in [Aperture::Disc, Aperture::polygon(3), Aperture::Gaussian { sigma_per_coc: 0.5 }] {
            let reach = aperture.radius() * 1.06;
            let cell = (2.0 * reach / CELLS as f64).powi(2);
            let light: f64 = intensities(&aperture, reach).iter().sum::<f64>() * cell;
            // The edge cuts 144 points a side: some 0.5 % of the area at most.
            assert!((light - 1.0).abs() < 0.01, "{aperture}: {light}");
        }
    }
}
