//! What is painted in a pane: pictures, legend, cursor, messages.

use super::App;
use super::legend::{self, Legend};
use super::model::{PaneId, PaneState, Show};
use eframe::egui::{
    self, Align2, Color32, CornerRadius, FontId, Galley, Painter, Pos2, Rect, Stroke, StrokeKind, Ui, pos2, vec2,
};
use glam::DVec2;
use std::sync::Arc;

const WHOLE: Rect = Rect { min: pos2(0.0, 0.0), max: pos2(1.0, 1.0) };

/// Behind text over a picture: dark enough for white letters on any picture.
const SHADE: Color32 = Color32::from_black_alpha(170);

/// Distance of what is painted over the picture from its border, points.
const INSET: f32 = 10.0;

/// Size of a legend, points.
const LEGEND: egui::Vec2 = vec2(270.0, 62.0);

/// Magnification from which on the pixel under the pointer is framed.
const FRAMED_FROM: f32 = 6.0;

/// Width of a pixel from which on its values stand in it, points: three lines of numbers.
pub const VALUES_FROM: f32 = 46.0;

/// What shows around a picture that does not fill its pane.
pub fn background(ui: &Ui, area: Rect) {
    ui.painter().rect_filled(area, CornerRadius::ZERO, ui.visuals().extreme_bg_color);
}

/// The pictures of one pane, or of two with the divider between them.
pub fn panes(app: &App, ui: &Ui, area: Rect, picture: Rect, ids: &[PaneId]) {
    let seen = picture.intersect(area);
    let x = seen.left() + app.document.divider * seen.width();
    let parts = match ids {
        [_, _] => vec![
            Rect::from_min_max(area.min, pos2(x, area.bottom())),
            Rect::from_min_max(pos2(x, area.top()), area.max),
        ],
        _ => vec![area],
    };
    for (id, part) in ids.iter().zip(&parts) {
        pane(app, ui, *part, picture, blinked(app, *id));
    }
    if ids.len() > 1 {
        divider(&ui.painter_at(seen), seen, x);
    }
    cursor(app, ui, area, picture, ids[0]);
}

/// The pane that is seen in place of another while one blinks.
fn blinked(app: &App, id: PaneId) -> PaneId {
    let (a, b) = (app.document.a, app.document.b);
    let here = app.viewport.hovered().is_none_or(|hovered| hovered == id) || id == a;
    match app.viewport.is_blinking() && here {
        true if id == b => a,
        true => b,
        false => id,
    }
}

fn pane(app: &App, ui: &Ui, part: Rect, picture: Rect, id: PaneId) {
    let painter = ui.painter_at(part);
    let engine_pane = app.engine.pane(id);
    if let (Some(texture), Some(shown)) = (app.textures.get(&id), app.shown(id)) {
        painter.image(texture.id, place_of(app, picture, id, shown.size().as_vec2()), WHOLE, Color32::WHITE);
    }
    if let Some(error) = engine_pane.and_then(|p| p.error()) {
        painter.rect_filled(part, CornerRadius::ZERO, Color32::from_black_alpha(140));
        let text = wrapped(&painter, error, part.width() - 4.0 * INSET);
        label(&painter, part.center(), Align2::CENTER_CENTER, text);
    }
    if let Some(legend) = legend::of(app, id) {
        paint_legend(&painter, part, &legend);
    }
    pixel_values(app, &painter, part, picture, id);
    marks(app, &painter, part, picture, id);
}

/// What a pane's method is called; where another pane has the same, with its parameters.
fn name_beside_others(app: &App, pane: &PaneState) -> String {
    let title = pane.method.title();
    let is_alone = app.document.panes.iter().all(|other| other.id == pane.id || other.method.id != pane.method.id);
    if is_alone || pane.method.params.is_empty() {
        return title;
    }
    let params = pane.method.params.iter().map(|(key, value)| format!("{key} {value}"));
    format!("{title}, {}", params.collect::<Vec<_>>().join(", "))
}

/// The display values of every pixel in its place, where pixels are large enough to hold them.
fn pixel_values(app: &App, painter: &Painter, part: Rect, picture: Rect, id: PaneId) {
    let is_picture = app.document.pane(id).is_some_and(|pane| pane.show == Show::Picture);
    let Some(color) = app.engine.known_color(id).filter(|_| is_picture && app.stereo().is_none()) else { return };
    let side = picture.width() / color.size.x.max(1) as f32;
    if side < VALUES_FROM {
        return;
    }
    let seen = picture.intersect(part);
    let [first, last] = [seen.min, seen.max].map(|at| (at - picture.min) / side);
    let range = |from: f32, to: f32, end: u32| (from.floor().max(0.0) as u32)..(to.ceil().max(0.0) as u32).min(end);
    for y in range(first.y, last.y, color.size.y) {
        for x in range(first.x, last.x, color.size.x) {
            let shown = app.document.display.encoded(color.at(x, y));
            let [r, g, b] = shown.to_array().map(|v| (v * 255.0).round() as u8);
            let text_color = if shown.dot(defocus::display::LUMINANCE) > 0.4 { Color32::BLACK } else { Color32::WHITE };
            let middle = picture.min + (vec2(x as f32, y as f32) + vec2(0.5, 0.5)) * side;
            let font = FontId::monospace(11.0);
            painter.text(middle, Align2::CENTER_CENTER, format!("{r}\n{g}\n{b}"), font, text_color);
        }
    }
}

/// What a picture is, in its corners, where nothing else says so: the method where panes have
/// no heads, and which eye sees it.
fn marks(app: &App, painter: &Painter, part: Rect, picture: Rect, id: PaneId) {
    let seen = picture.intersect(part);
    if app.preferences.panels_hidden && app.document.visible().len() > 1 {
        let title = app.document.pane(id).map_or_else(String::new, |pane| name_beside_others(app, pane));
        let text = wrapped(painter, &title, seen.width() - 4.0 * INSET);
        label(painter, seen.left_top() + vec2(INSET, INSET), Align2::LEFT_TOP, text);
    }
    let Some(layout) = app.stereo().map(|stereo| stereo.layout).filter(|layout| layout.is_side_by_side()) else {
        return;
    };
    let is_crossed = layout == defocus::stereo::Layout::Crossed;
    let marks = if is_crossed { ["R", "L"] } else { ["L", "R"] };
    for (mark, x) in marks.into_iter().zip([picture.left(), picture.center().x]) {
        let at = pos2(x + INSET, seen.bottom() - INSET);
        label(painter, at, Align2::LEFT_BOTTOM, wrapped(painter, mark, 60.0));
    }
}

/// Where a texture lies: on the picture, so that both show the same thing in the same
/// place.
fn place_of(app: &App, picture: Rect, id: PaneId, size: glam::Vec2) -> Rect {
    // Two eyes' textures stand side by side: neither lies where it would alone.
    let place = app.engine.pane(id).and_then(|pane| pane.place()).filter(|_| app.stereo().is_none());
    match (app.engine.size(), place) {
        (Some(inner), Some(place)) => {
            let scale = picture.size() / vec2(inner.x as f32, inner.y as f32);
            let px = |v: glam::Vec2| vec2(v.x, v.y) * scale;
            Rect::from_min_size(picture.min + px(place.min), px(place.size))
        }
        // One that was drawn for panes of another shape, until the next: as high as that,
        // since the field of view is that of the height.
        _ => {
            let width = picture.height() * size.x / size.y;
            let is_new = (width / picture.width() - 1.0).abs() < 0.02;
            if is_new { picture } else { Rect::from_center_size(picture.center(), vec2(width, picture.height())) }
        }
    }
}

/// The pointer's place in the panes that it is not in, and the pixel under it where pixels
/// are large.
fn cursor(app: &App, ui: &Ui, area: Rect, picture: Rect, id: PaneId) {
    let (Some(at), Some(size)) = (app.viewport.cursor(), app.engine.size()) else { return };
    let painter = ui.painter_at(area);
    let point = |at: DVec2| picture.min + vec2(at.x as f32, at.y as f32) * picture.size();
    if app.viewport.hovered() != Some(id) {
        let centre = point(at);
        for (width, color) in [(3.0, Color32::from_black_alpha(140)), (1.0, Color32::WHITE)] {
            for arm in [vec2(1.0, 0.0), vec2(0.0, 1.0), vec2(-1.0, 0.0), vec2(0.0, -1.0)] {
                painter.line_segment([centre + arm * 4.0, centre + arm * 10.0], Stroke::new(width, color));
            }
        }
    }
    let pixel = picture.width() / size.x as f32;
    // Side by side, every pixel of an eye's picture is half as wide as its share.
    if pixel >= FRAMED_FROM && !app.stereo().is_some_and(|s| s.layout.is_side_by_side()) {
        let texel = (at * size.as_dvec2()).floor() / size.as_dvec2();
        let frame = Rect::from_min_size(point(texel), vec2(pixel, pixel));
        painter.rect_stroke(frame, CornerRadius::ZERO, Stroke::new(3.0, Color32::BLACK), StrokeKind::Outside);
        painter.rect_stroke(frame, CornerRadius::ZERO, Stroke::new(1.0, Color32::WHITE), StrokeKind::Outside);
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

fn paint_legend(painter: &Painter, area: Rect, legend: &Legend) {
    if !legend.names.is_empty() {
        return paint_names(painter, area, legend);
    }
    let size = vec2(LEGEND.x.min(area.width() - 2.0 * INSET), LEGEND.y);
    if size.x < 80.0 || area.height() < 2.0 * size.y {
        return;
    }
    let panel = Rect::from_min_size(area.right_bottom() - size - vec2(INSET, INSET), size);
    painter.rect_filled(panel, CornerRadius::same(5), SHADE);
    let inner = panel.shrink2(vec2(10.0, 7.0));
    let text = |at: Pos2, align: Align2, text: &str| {
        painter.text(at, align, text, FontId::proportional(11.5), Color32::WHITE);
    };
    text(inner.left_top(), Align2::LEFT_TOP, &legend.title);
    let bar = Rect::from_min_size(inner.left_top() + vec2(0.0, 18.0), vec2(inner.width(), 10.0));
    // One bar a point: the eye sees no steps.
    let steps = bar.width() as usize;
    for i in 0..steps {
        let t = i as f32 / (steps - 1) as f32;
        let [r, g, b] = legend.map.srgb8(t);
        let slice = Rect::from_min_size(bar.min + vec2(i as f32, 0.0), vec2(1.5, bar.height()));
        painter.rect_filled(slice, CornerRadius::ZERO, Color32::from_rgb(r, g, b));
    }
    text(inner.left_bottom(), Align2::LEFT_BOTTOM, &legend.low);
    text(inner.right_bottom(), Align2::RIGHT_BOTTOM, &legend.high);
}

/// A legend of colours with a name each, in as many rows as they take.
fn paint_names(painter: &Painter, area: Rect, legend: &Legend) {
    const ROW: f32 = 17.0;
    const SWATCH: f32 = 11.0;
    let width = LEGEND.x.min(area.width() - 2.0 * INSET) - 20.0;
    if width < 60.0 {
        return;
    }
    let font = FontId::proportional(11.5);
    let mut at = vec2(0.0, ROW);
    let mut placed = Vec::new();
    for (place, name) in &legend.names {
        let text = painter.layout_no_wrap(name.clone(), font.clone(), Color32::WHITE);
        let needed = SWATCH + 4.0 + text.size().x;
        if at.x > 0.0 && at.x + needed > width {
            at = vec2(0.0, at.y + ROW);
        }
        placed.push((at, *place, text));
        at.x += needed + 10.0;
    }
    let size = vec2(width + 20.0, at.y + ROW + 14.0);
    if area.height() < size.y + INSET {
        return;
    }
    let panel = Rect::from_min_size(area.right_bottom() - size - vec2(INSET, INSET), size);
    painter.rect_filled(panel, CornerRadius::same(5), SHADE);
    let corner = panel.min + vec2(10.0, 7.0);
    painter.text(corner, Align2::LEFT_TOP, &legend.title, font, Color32::WHITE);
    for (offset, place, text) in placed {
        let [r, g, b] = legend.map.srgb8(place);
        let swatch = Rect::from_min_size(corner + offset + vec2(0.0, 2.0), vec2(SWATCH, SWATCH));
        painter.rect_filled(swatch, CornerRadius::same(2), Color32::from_rgb(r, g, b));
        painter.galley(corner + offset + vec2(SWATCH + 4.0, 0.0), text, Color32::WHITE);
    }
}

/// Reticle, messages and hint of a pane.
pub fn over(app: &App, ui: &Ui, area: Rect, id: PaneId) {
    if let (Some(at), Some(picture)) = (app.focus_motion.clicked_at(), app.viewport.picture(id)) {
        let at = picture.min + vec2(at.x as f32, at.y as f32) * picture.size();
        reticle(&ui.painter_at(area), at);
    }
    let is_first = id == app.document.a;
    match (app.viewport.problem(), app.loader.loading()) {
        (_, Some(spec)) if is_first => loading(ui, area, spec),
        (Some(problem), None) if is_first => banner(ui, area, problem),
        (None, None) if is_first && app.viewport.hint && app.engine.source().is_some() => {
            let next = if app.document.panes.len() > 1 { "" } else { " · press V to compare with the truth" };
            hint(ui, area, &format!("Click what should be sharp · drag to look around{next}"));
        }
        _ => {}
    }
}

/// Where one clicked to focus.
fn reticle(painter: &Painter, at: Pos2) {
    painter.circle_stroke(at, 13.0, Stroke::new(3.0, Color32::from_black_alpha(120)));
    painter.circle_stroke(at, 13.0, Stroke::new(1.5, Color32::WHITE));
}

/// A line at the upper border, where no legend is.
fn hint(ui: &Ui, area: Rect, text: &str) {
    let painter = ui.painter_at(area);
    let galley = wrapped(&painter, text, area.width() - 4.0 * INSET);
    label(&painter, area.center_top() + vec2(0.0, INSET), Align2::CENTER_TOP, galley);
}

/// A line at the lower border: what is wrong.
fn banner(ui: &Ui, area: Rect, text: &str) {
    let painter = ui.painter_at(area);
    let galley = wrapped(&painter, text, area.width() - 4.0 * INSET);
    label(&painter, area.center_bottom() - vec2(0.0, INSET + 4.0), Align2::CENTER_BOTTOM, galley);
}

/// A turning wheel with what is being opened.
fn loading(ui: &Ui, area: Rect, spec: &str) {
    let painter = ui.painter_at(area);
    let text = wrapped(&painter, &format!("Opening {spec} … Escape gives up"), area.width() - 8.0 * INSET);
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
