//! A method's point spread function beside the lens's own: pictures, numbers and MTF.

use super::fields::Field;
use crate::window::engine::MeasuredKernel;
use crate::window::model::KernelChoice;
use crate::window::model::numbers::significant;
use crate::window::ui::widgets::choice;
use defocus::colormap::ColorMap;
use defocus::image::{ColorImage, Image};
use eframe::egui::{
    self, Color32, Grid, Id, Rect, RichText, Role, Sense, TextureHandle, TextureOptions, Ui, WidgetInfo, pos2, vec2,
};
use egui_plot::{Legend, Line, Plot};

/// Height of the plot, points.
const PLOT_HEIGHT: f32 = 130.0;

/// Brightness of the mean of a disc in the pictures: brighter parts have room above it.
const DISC_SHOWN: f64 = 1.0 / 1.5;

/// What the panel shows.
pub struct KernelView<'a> {
    /// The method's name.
    pub title: &'a str,
    /// What was measured; `None` while it is.
    pub measured: Option<&'a Result<MeasuredKernel, String>>,
}

/// Shows the panel over the CoC and side that are chosen.
pub fn kernel_panel(ui: &mut Ui, chosen: &mut KernelChoice, view: &KernelView<'_>) {
    let coc = Field {
        name: "Point's CoC",
        help: "Diameter of the circle of confusion of the point that is measured, whatever the scene and its lens. The aperture's shape is that of the lens.",
        unit: " px",
        range: KernelChoice::COC_PX,
        log: Some(0.5),
        reset: Some(KernelChoice::default().coc_px),
    };
    if coc.show(ui, &mut chosen.coc_px) {
        chosen.coc_px = chosen.coc_px.clamp(*KernelChoice::COC_PX.start(), *KernelChoice::COC_PX.end());
    }
    let mut side = usize::from(chosen.in_front);
    let help = "Whether the point lies behind the focus or in front of it, where the aperture's shape is turned about.";
    choice(ui, "Point lies", help, &mut side, &["behind the focus", "in front of it"]);
    chosen.in_front = side == 1;
    match view.measured {
        None => {
            ui.weak("being measured \u{2026}");
        }
        Some(Err(error)) => {
            ui.label(RichText::new(error).small().color(ui.visuals().error_fg_color));
        }
        Some(Ok(measured)) => {
            pictures(ui, view.title, measured);
            numbers(ui, measured);
            mtf(ui, view.title, measured);
        }
    }
}

/// Both functions on one scale.
fn pictures(ui: &mut Ui, title: &str, measured: &MeasuredKernel) {
    let MeasuredKernel { psf, lens } = measured;
    let side = (0.5 * (ui.available_width() - ui.spacing().item_spacing.x)).floor();
    let mean_of_disc = 4.0 / (std::f64::consts::PI * psf.coc_px.max(1.0).powi(2));
    let scale = (DISC_SHOWN / mean_of_disc) as f32;
    ui.horizontal_top(|ui| {
        for (name, image) in [(title, &psf.image), ("lens", lens)] {
            ui.vertical(|ui| {
                ui.set_width(side);
                ui.add(egui::Label::new(RichText::new(name).small().weak()).truncate());
                let (rect, response) = ui.allocate_exact_size(vec2(side, side), Sense::hover());
                let label = format!("Point spread function: {name}");
                response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &label));
                response.on_hover_text("Light of one point, linear; both on one scale, which ends at one and a half times the mean of a disc of that CoC.");
                let texture = kernel_texture(ui, &label, image, scale);
                let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
                ui.painter_at(rect).image(texture.id(), rect, whole, Color32::WHITE);
            });
        }
    });
}

/// The picture as a texture, which is made anew only where it has changed.
fn kernel_texture(ui: &Ui, name: &str, image: &ColorImage, scale: f32) -> TextureHandle {
    let shown: Image<[u8; 3]> = ColorMap::Magma.apply(&image.map(|p| scale * p.y), 1.0);
    let size = [shown.size.x as usize, shown.size.y as usize];
    let pixels = shown.pixels.iter().map(|[r, g, b]| Color32::from_rgb(*r, *g, *b)).collect();
    let picture = egui::ColorImage::new(size, pixels);
    let id = Id::unique(name);
    let known: Option<(egui::ColorImage, TextureHandle)> = ui.data(|data| data.get_temp(id));
    if let Some((of, texture)) = known
        && of == picture
    {
        return texture;
    }
    let texture = ui.ctx().load_texture(name, picture.clone(), TextureOptions::NEAREST);
    ui.data_mut(|data| data.insert_temp(id, (picture, texture.clone())));
    texture
}

fn numbers(ui: &mut Ui, measured: &MeasuredKernel) {
    let psf = &measured.psf;
    let [x, y] = psf.centroid_px;
    let rows = [
        ("Energy", format!("{:.4}", psf.energy), "Light in it over that of the point: 1 where light is kept."),
        (
            "Width",
            format!("{} px, lens {} px", significant(psf.sigma_px), significant(psf.lens_sigma_px)),
            "Standard deviation on an axis, without that of the pixel itself, beside that of the lens.",
        ),
        ("Centroid", format!("{x:+.3}, {y:+.3} px"), "Where its centroid lies from the point, right and down."),
        ("Symmetry", format!("{:.3}", psf.symmetry), "How equal it is to its mirror images: 1 for equal."),
        (
            "MTF error",
            format!("{:.3}", psf.mtf_error),
            "Greatest difference of its MTF from the lens's, up to three cycles in a disc or half a cycle in a pixel.",
        ),
    ];
    Grid::new("kernel numbers").num_columns(2).spacing([8.0, 2.0]).show(ui, |ui| {
        for (name, value, help) in rows {
            ui.label(RichText::new(name).small().weak()).on_hover_text(help);
            ui.label(RichText::new(value).small().monospace()).on_hover_text(help);
            ui.end_row();
        }
    });
}

/// Its MTF beside the lens's in closed form.
fn mtf(ui: &mut Ui, title: &str, measured: &MeasuredKernel) {
    let psf = &measured.psf;
    let line =
        |values: &[f64]| -> Vec<[f64; 2]> { psf.frequencies.iter().zip(values).map(|(f, m)| [*f, *m]).collect() };
    let color = ui.visuals().text_color();
    let plot = Plot::new("MTF")
        .height(PLOT_HEIGHT)
        .allow_zoom(false)
        .allow_drag(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .include_y(0.0)
        .include_y(1.0)
        .x_axis_label("cycles per px")
        .legend(Legend::default().background_alpha(0.6))
        .show(ui, |plot| {
            plot.line(Line::new("lens, closed form", line(&psf.lens_mtf)).color(color).width(1.0));
            plot.line(Line::new(title, line(&psf.mtf)).width(2.0));
        });
    plot.response.accessible_name("Modulation transfer function");
}
