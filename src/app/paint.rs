//! What is painted in the viewport: pictures, names, legend, messages.

use super::App;
use super::settings::Show;
use super::widgets::significant;
use crate::present::{DIFFERENCE_FULL_SCALE, Map};
use eframe::egui::{
    self, Align2, Color32, CornerRadius, FontId, Galley, Painter, Pos2, Rect, Stroke, StrokeKind, Ui, pos2, vec2,
};
use std::sync::Arc;

const WHOLE: Rect = Rect { min: pos2(0.0, 0.0), max: pos2(1.0, 1.0) };

/// Behind text over a picture: dark enough for white letters on any picture.
const SHADE: Color32 = Color32::from_black_alpha(170);

/// Distance of what is painted over the picture from its border, points.
const INSET: f32 = 10.0;

/// What shows around a picture that does not fill the viewport.
pub fn background(ui: &Ui, area: Rect) {
    ui.painter().rect_filled(area, CornerRadius::ZERO, ui.visuals().extreme_bg_color);
}

/// The methods' pictures, their names, and the divider between two.
pub fn panes(app: &App, ui: &Ui, picture: Rect) {
    let panes = app.engine.panes();
    let wiping = app.is_wiping() && panes.len() == 2;
    let x = picture.left() + app.settings.divider * picture.width();
    for (index, pane) in panes.iter().enumerate() {
        let part = match (wiping, index) {
            (true, 0) => Rect::from_min_max(picture.min, pos2(x, picture.bottom())),
            (true, _) => Rect::from_min_max(pos2(x, picture.top()), picture.max),
            // Overlays are the same for both; the first stands for them.
            (false, 0) => picture,
            (false, _) => continue,
        };
        let painter = ui.painter_at(part);
        if let Some(texture) = app.textures.get(index).and_then(|t| t.as_ref()) {
            painter.image(texture.id, picture, WHOLE, Color32::WHITE);
        }
        if let Some(error) = &pane.error {
            painter.rect_filled(part, CornerRadius::ZERO, Color32::from_black_alpha(140));
            let text = wrapped(&painter, error, part.width() - 4.0 * INSET);
            label(&painter, part.center(), Align2::CENTER_CENTER, text);
        }
        if app.settings.show != Show::Difference {
            name(app, &painter, part, index, wiping);
        }
    }
    if app.settings.show == Show::Difference && panes.len() == 2 {
        let title = |index| app.title(index);
        let text = format!("Difference of {} and {}", title(0), title(1));
        let painter = ui.painter_at(picture);
        let text = wrapped(&painter, &text, picture.width() - 2.0 * INSET);
        label(&painter, picture.min + vec2(INSET, INSET), Align2::LEFT_TOP, text);
    }
    if wiping {
        divider(&ui.painter_at(picture), picture, x);
    }
}

fn name(app: &App, painter: &Painter, part: Rect, index: usize, wiping: bool) {
    let mut text = app.title(index);
    if let Some((count, samples)) = app.engine.progress(index) {
        text = format!("{text} · {count} of {samples} lens points");
    }
    // A narrow part has no room for a name, and a cut one says nothing.
    let galley = wrapped(painter, &text, f32::INFINITY);
    if galley.size().x + 2.0 * INSET + 12.0 > part.width() {
        return;
    }
    if wiping && index == 1 {
        label(painter, part.right_top() + vec2(-INSET, INSET), Align2::RIGHT_TOP, galley);
    } else {
        label(painter, part.min + vec2(INSET, INSET), Align2::LEFT_TOP, galley);
    }
}

fn divider(painter: &Painter, picture: Rect, x: f32) {
    painter.vline(x, picture.y_range(), Stroke::new(3.0, Color32::from_black_alpha(110)));
    painter.vline(x, picture.y_range(), Stroke::new(1.5, Color32::WHITE));
    let grip = Rect::from_center_size(pos2(x, picture.center().y), vec2(10.0, 34.0));
    painter.rect(grip, CornerRadius::same(5), Color32::WHITE, Stroke::new(1.0, SHADE), StrokeKind::Outside);
    for offset in [-2.0, 2.0] {
        painter.vline(x + offset, grip.shrink(10.0).y_range(), Stroke::new(1.0, Color32::from_gray(120)));
    }
}

/// Colour scale of an overlay.
pub fn legend(app: &App, ui: &Ui, area: Rect) {
    let coc = significant(f64::from(app.settings.coc_scale_px));
    let sharp = significant(f64::from(app.settings.acceptable_coc_px));
    let full = f64::from(DIFFERENCE_FULL_SCALE) * 100.0;
    let (map, title, low, high) = match app.settings.show {
        Show::Picture => return,
        Show::Coc => (Map::Diverging, "Signed CoC", format!("−{coc} px, in front"), format!("{coc} px, behind")),
        Show::Depth => (Map::Sequential, "Reciprocal depth", "∞".into(), "nearest".into()),
        Show::Zone => {
            (Map::Diverging, "Depth of field", "in front".into(), format!("behind · colours: CoC ≤ {sharp} px"))
        }
        Show::Difference => (Map::Error, "Difference of display values", "0".into(), format!("{full} % and more")),
    };
    let panel = Rect::from_min_size(area.right_bottom() - vec2(270.0, 62.0) - vec2(INSET, INSET), vec2(270.0, 62.0));
    let painter = ui.painter_at(area);
    painter.rect_filled(panel, CornerRadius::same(5), SHADE);
    let text = |at: Pos2, align: Align2, text: &str| {
        painter.text(at, align, text, FontId::proportional(11.5), Color32::WHITE);
    };
    let inner = panel.shrink2(vec2(10.0, 7.0));
    text(inner.left_top(), Align2::LEFT_TOP, title);
    let bar = Rect::from_min_size(inner.left_top() + vec2(0.0, 18.0), vec2(inner.width(), 10.0));
    // One bar a point: the eye sees no steps.
    let steps = bar.width() as usize;
    for i in 0..steps {
        let t = i as f32 / (steps - 1) as f32;
        let [r, g, b] = map.srgb8(t);
        let slice = Rect::from_min_size(bar.min + vec2(i as f32, 0.0), vec2(1.5, bar.height()));
        painter.rect_filled(slice, CornerRadius::ZERO, Color32::from_rgb(r, g, b));
    }
    text(inner.left_bottom(), Align2::LEFT_BOTTOM, &low);
    text(inner.right_bottom(), Align2::RIGHT_BOTTOM, &high);
}

/// Where one clicked to focus.
pub fn reticle(ui: &Ui, at: Pos2) {
    let painter = ui.painter();
    painter.circle_stroke(at, 13.0, Stroke::new(3.0, Color32::from_black_alpha(120)));
    painter.circle_stroke(at, 13.0, Stroke::new(1.5, Color32::WHITE));
}

/// A line at the lower border: a hint, or what is wrong.
pub fn banner(ui: &Ui, area: Rect, text: &str) {
    let painter = ui.painter_at(area);
    let galley = wrapped(&painter, text, area.width() - 4.0 * INSET);
    label(&painter, area.center_bottom() - vec2(0.0, INSET + 4.0), Align2::CENTER_BOTTOM, galley);
}

/// A turning wheel with what is being opened.
pub fn loading(ui: &Ui, area: Rect, spec: &str) {
    let painter = ui.painter_at(area);
    let text = wrapped(&painter, &format!("Opening {spec} …"), area.width() - 8.0 * INSET);
    let size = text.size();
    let centre = area.center();
    label(&painter, centre + vec2(14.0, 0.0), Align2::CENTER_CENTER, text);
    let wheel = Rect::from_center_size(centre - vec2(size.x * 0.5 + 8.0, 0.0), vec2(16.0, 16.0));
    egui::Spinner::new().color(Color32::WHITE).paint_at(ui, wheel);
}

fn wrapped(painter: &Painter, text: &str, width: f32) -> Arc<Galley> {
    painter.layout(text.to_owned(), FontId::proportional(13.0), Color32::WHITE, width.max(60.0))
}

fn label(painter: &Painter, at: Pos2, align: Align2, galley: Arc<Galley>) {
    let margin = vec2(8.0, 4.0);
    let rect = align.anchor_size(at, galley.size() + 2.0 * margin);
    painter.rect_filled(rect, CornerRadius::same(5), SHADE);
    painter.galley(rect.min + margin, galley, Color32::WHITE);
}
