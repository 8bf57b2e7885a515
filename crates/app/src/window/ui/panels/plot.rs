//! The CoC against depth, over the depths of the scene; the focus can be dragged in it.

use super::fields::distance_text;
use crate::window::model::numbers::{round_above, significant};
use defocus::eye::{BLUR_DETECTION_D, ComfortZone};
use defocus::histogram::Histogram;
use defocus::lens::{CocOfDepth, Lens, MM_PER_M};
use defocus::present::Map;
use eframe::egui::{
    Align2, Color32, CursorIcon, FontId, Painter, Pos2, Rect, Sense, Stroke, Ui, WidgetInfo, pos2, vec2,
};

/// Height of the plot with its axis, points.
const HEIGHT: f32 = 126.0;

/// Height of the axis below it, points.
const AXIS_HEIGHT: f32 = 18.0;

/// Height of the line above the curve, points.
const CAPTION_HEIGHT: f32 = 15.0;

/// Height of the histogram at the bottom of the plot, points.
const HISTOGRAM_HEIGHT: f32 = 44.0;

/// Bins of the histogram.
const BINS: usize = 64;

/// Depths, metres, where nothing is known of the scene: an arm's length to a street's.
const UNKNOWN_M: (f64, f64) = (0.25, 25.0);

/// What the plot is drawn over.
#[derive(Clone, Copy, Debug)]
pub struct PlotReadings<'a> {
    /// A sample of the depths in view, metres, if they are known.
    pub depths_m: Option<&'a [f32]>,
    /// |c| up to which a point counts as sharp, px.
    pub acceptable_px: f64,
}

/// Axes: depth on a logarithmic scale, |c| on a linear one.
struct Scale {
    area: Rect,
    low_m: f64,
    high_m: f64,
    top_px: f64,
}

impl Scale {
    fn of(area: Rect, lens: &Lens, depths_m: Option<&[f32]>) -> Self {
        let (low_m, high_m) = depth_range_m(depths_m.unwrap_or_default(), lens.focus_distance_m);
        let coc = lens.coc();
        let ends = coc.at_depth(low_m).abs().max(coc.at_depth(high_m).abs());
        // What 95 % of the picture have fills the plot; a leaf before the lens may leave it.
        let known = depths_m.and_then(|d| lens.coc_statistics(d.iter().copied()));
        let wanted = known.map_or(ends, |s| (1.5 * s.p95_px).min(ends));
        let top_px = if wanted.is_finite() { wanted.max(1.0) } else { 1.0 };
        Self { area, low_m, high_m, top_px }
    }

    fn x(&self, depth_m: f64) -> f32 {
        let share = ((depth_m / self.low_m).ln() / (self.high_m / self.low_m).ln()).clamp(0.0, 1.0);
        self.area.left() + share as f32 * self.area.width()
    }

    fn depth_m(&self, x: f32) -> f64 {
        let share = f64::from((x - self.area.left()) / self.area.width()).clamp(0.0, 1.0);
        self.low_m * (self.high_m / self.low_m).powf(share)
    }

    fn y(&self, c_px: f64) -> f32 {
        let share = (c_px.abs() / self.top_px).min(1.0) as f32;
        self.area.bottom() - share * self.area.height()
    }
}

/// Depths to show, metres: all that are in view and the focus, with a margin.
fn depth_range_m(depths_m: &[f32], focus_m: f64) -> (f64, f64) {
    let finite = depths_m.iter().map(|d| f64::from(*d)).filter(|d| d.is_finite() && *d > 0.0);
    let (mut low, mut high) = finite.fold((f64::INFINITY, 0.0_f64), |(low, high), d| (low.min(d), high.max(d)));
    if high == 0.0 {
        (low, high) = UNKNOWN_M;
    }
    if focus_m.is_finite() && focus_m > 0.0 {
        (low, high) = (low.min(focus_m), high.max(focus_m));
    }
    // A factor of 1.25 around, and never less than a factor of 2 between the ends.
    let middle = (low * high).sqrt();
    let low = (low / 1.25).min(middle / std::f64::consts::SQRT_2).max(1e-6);
    (low, (high * 1.25).max(middle * std::f64::consts::SQRT_2).clamp(2.0 * low, 1e12))
}

/// Shows the plot; the focus distance, metres, that the pointer asks for, if it does.
pub fn coc_plot(ui: &mut Ui, lens: &Lens, readings: PlotReadings<'_>) -> Option<f64> {
    let size = vec2(ui.available_width(), HEIGHT);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    let area = Rect::from_min_max(rect.min, pos2(rect.right(), rect.bottom() - AXIS_HEIGHT));
    let focus_m = lens.focus_distance_m;
    response.widget_info(|| WidgetInfo::slider(true, focus_m, "Focus in the plot"));
    if lens.check().is_err() {
        let painter = ui.painter_at(rect);
        painter.rect_filled(area, 3.0, ui.visuals().extreme_bg_color);
        let font = FontId::proportional(11.0);
        let text = "This lens forms no image.";
        painter.text(area.center(), Align2::CENTER_CENTER, text, font, ui.visuals().weak_text_color());
        return None;
    }
    let drawn = Rect::from_min_max(area.min + vec2(4.0, CAPTION_HEIGHT), area.max - vec2(4.0, 0.0));
    let scale = Scale::of(drawn, lens, readings.depths_m);
    let asked = (response.dragged() || response.clicked())
        .then(|| response.interact_pointer_pos())
        .flatten()
        .map(|at| scale.depth_m(at.x));
    let hovered = response.hover_pos().map(|at| scale.depth_m(at.x));
    if ui.is_rect_visible(rect) {
        paint(ui, rect, &scale, lens, readings);
    }
    let response = response.on_hover_cursor(CursorIcon::ResizeHorizontal);
    if let Some(depth_m) = hovered {
        let c = lens.coc_diameter_px(depth_m);
        response.on_hover_text_at_pointer(format!(
            "{}: CoC {} px, {} D\nClick or drag to focus there. Blur is seen from the band on; the bar at the top is the zone of comfort before the screen.",
            distance_text(depth_m),
            significant(c),
            significant(lens.focus_d() - 1.0 / depth_m)
        ));
    }
    asked
}

fn paint(ui: &Ui, rect: Rect, scale: &Scale, lens: &Lens, readings: PlotReadings<'_>) {
    let painter = ui.painter_at(rect);
    let visuals = ui.visuals();
    let background = Rect::from_min_max(rect.min, pos2(rect.right(), scale.area.bottom()));
    painter.rect_filled(background, 3.0, visuals.extreme_bg_color);
    sharp_zone(&painter, scale, lens, readings.acceptable_px, visuals.selection.bg_fill.gamma_multiply(0.35));
    blur_band(&painter, scale, lens, visuals.warn_fg_color.gamma_multiply(0.25));
    comfort_bar(&painter, scale, lens, visuals.hyperlink_color.gamma_multiply(0.6));
    if let Some(depths_m) = readings.depths_m {
        histogram(&painter, scale, depths_m, visuals.weak_text_color().gamma_multiply(0.8));
    }
    ticks(&painter, scale, visuals.weak_text_color());
    coc_ticks(&painter, scale, visuals.weak_text_color());
    hyperfocal(&painter, scale, lens.hyperfocal_m(readings.acceptable_px), visuals.weak_text_color());
    curve(&painter, scale, &lens.coc());
    focus_line(&painter, scale, lens.focus_distance_m, visuals.strong_text_color());
    let top = format!("|CoC| up to {} px", significant(scale.top_px));
    let at = background.right_top() + vec2(-5.0, 2.0);
    small(&painter, at, Align2::RIGHT_TOP, &top, visuals.weak_text_color());
}

fn small(painter: &Painter, at: Pos2, align: Align2, text: &str, color: Color32) -> Rect {
    painter.text(at, align, text, FontId::proportional(10.0), color)
}

/// What is sharp: depths between the limits, below the acceptable CoC.
fn sharp_zone(painter: &Painter, scale: &Scale, lens: &Lens, acceptable_px: f64, color: Color32) {
    let (near_m, far_m) = lens.depth_of_field_m(acceptable_px);
    let right = if far_m.is_infinite() { scale.area.right() } else { scale.x(far_m) };
    let zone = Rect::from_min_max(pos2(scale.x(near_m), scale.area.top()), pos2(right, scale.area.bottom()));
    painter.rect_filled(zone, 0.0, color);
}

/// Where blur begins to be seen: the CoC of the least to the greatest threshold of detection.
fn blur_band(painter: &Painter, scale: &Scale, lens: &Lens, color: Color32) {
    let px_per_d = lens.px_per_dioptre();
    let [top, bottom] = [BLUR_DETECTION_D.end(), BLUR_DETECTION_D.start()].map(|d| scale.y(d * px_per_d));
    let (left, right) = (scale.area.left(), scale.area.right());
    painter.rect_filled(Rect::from_min_max(pos2(left, top), pos2(right, bottom)), 0.0, color);
}

/// Distances at which it is comfortable to look before a screen at ds, as a bar at the top.
fn comfort_bar(painter: &Painter, scale: &Scale, lens: &Lens, color: Color32) {
    let [near_m, far_m] = ComfortZone::default().distances_m(lens.screen_distance_mm / MM_PER_M);
    let within = |m: f64| scale.x(m.clamp(scale.low_m, scale.high_m));
    let right = if far_m.is_infinite() { scale.area.right() } else { within(far_m) };
    let bar = Rect::from_min_max(pos2(within(near_m), scale.area.top()), pos2(right, scale.area.top() + 3.0));
    painter.rect_filled(bar, 1.0, color);
}

fn histogram(painter: &Painter, scale: &Scale, depths_m: &[f32], color: Color32) {
    let values = depths_m.iter().map(|d| f64::from(*d).ln());
    let heights = Histogram::of(values, scale.low_m.ln()..=scale.high_m.ln(), BINS).heights();
    let width = scale.area.width() / BINS as f32;
    for (i, height) in heights.iter().enumerate().filter(|(_, h)| **h > 0.0) {
        let left = scale.area.left() + i as f32 * width;
        let top = scale.area.bottom() - (height * HISTOGRAM_HEIGHT).max(1.0);
        painter.rect_filled(Rect::from_min_max(pos2(left, top), pos2(left + width, scale.area.bottom())), 0.0, color);
    }
}

/// Depths 1, 2 and 5 of each power of ten, as far as their numbers have room.
fn ticks(painter: &Painter, scale: &Scale, color: Color32) {
    let mut free_from = f32::NEG_INFINITY;
    let powers = (scale.low_m.log10().floor() as i32)..=(scale.high_m.log10().ceil() as i32);
    for depth_m in powers.flat_map(|p| [1.0, 2.0, 5.0].map(|m| m * 10_f64.powi(p))) {
        if depth_m < scale.low_m || depth_m > scale.high_m {
            continue;
        }
        let x = scale.x(depth_m);
        let bottom = scale.area.bottom();
        painter.line_segment([pos2(x, bottom - 3.0), pos2(x, bottom)], Stroke::new(1.0, color));
        let text = painter.layout_no_wrap(distance_text(depth_m), FontId::proportional(10.0), color);
        let left = (x - 0.5 * text.size().x).clamp(scale.area.left(), scale.area.right() - text.size().x);
        if left > free_from {
            free_from = left + text.size().x + 8.0;
            painter.galley(pos2(left, bottom + 3.0), text, color);
        }
    }
}

/// Round diameters at the left, three or so.
fn coc_ticks(painter: &Painter, scale: &Scale, color: Color32) {
    let step_px = round_above(scale.top_px / 4.0);
    let steps = (scale.top_px / step_px).floor().clamp(0.0, 10.0) as u32;
    for c_px in (1..=steps).map(|i| f64::from(i) * step_px) {
        let (y, left) = (scale.y(c_px), scale.area.left());
        painter.line_segment([pos2(left, y), pos2(left + 4.0, y)], Stroke::new(1.0, color));
        // The uppermost would run into the line above the curve.
        if y > scale.area.top() + 6.0 {
            let at = pos2(left + 6.0, y);
            small(painter, at, Align2::LEFT_CENTER, &format!("{} px", significant(c_px)), color);
        }
    }
}

fn hyperfocal(painter: &Painter, scale: &Scale, hyperfocal_m: f64, color: Color32) {
    if !(scale.low_m..=scale.high_m).contains(&hyperfocal_m) {
        return;
    }
    let x = scale.x(hyperfocal_m);
    let from_top = |share: f32| scale.area.top() + share * scale.area.height();
    for dash in 0..12 {
        let share = dash as f32 / 12.0;
        let ends = [pos2(x, from_top(share)), pos2(x, from_top(share + 0.04))];
        painter.line_segment(ends, Stroke::new(1.0, color));
    }
    let (align, offset) = if x > scale.area.center().x { (Align2::RIGHT_TOP, -3.0) } else { (Align2::LEFT_TOP, 3.0) };
    small(painter, pos2(x + offset, scale.area.top() + 14.0), align, "hyperfocal", color);
}

/// |c| in the colours of the CoC overlay: in front of the focus distance and behind it.
fn curve(painter: &Painter, scale: &Scale, coc: &CocOfDepth) {
    const STEPS: usize = 160;
    let of = |t: f32| {
        let [r, g, b] = Map::Diverging.srgb8(t);
        Stroke::new(2.0, Color32::from_rgb(r, g, b))
    };
    let (front, behind) = (of(0.1), of(0.9));
    let point = |i: usize| {
        let x = scale.area.left() + scale.area.width() * i as f32 / STEPS as f32;
        let c = coc.at_depth(scale.depth_m(x));
        (pos2(x, scale.y(c)), c)
    };
    for i in 0..STEPS {
        let ((a, c_a), (b, c_b)) = (point(i), point(i + 1));
        let outside = c_a.abs() > scale.top_px && c_b.abs() > scale.top_px;
        if !outside {
            painter.line_segment([a, b], if c_a + c_b < 0.0 { front } else { behind });
        }
    }
}

fn focus_line(painter: &Painter, scale: &Scale, focus_m: f64, color: Color32) {
    let x = if focus_m.is_infinite() { scale.area.right() } else { scale.x(focus_m) };
    painter.line_segment([pos2(x, scale.area.top()), pos2(x, scale.area.bottom())], Stroke::new(1.5, color));
    painter.circle_filled(pos2(x, scale.area.bottom()), 5.0, color);
    let (align, offset) = if x > scale.area.center().x { (Align2::RIGHT_TOP, -4.0) } else { (Align2::LEFT_TOP, 4.0) };
    small(painter, pos2(x + offset, scale.area.top() + 1.0), align, &distance_text(focus_m), color);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axis_covers_scene_and_focus_whatever_they_are() {
        let covers = |depths: &[f32], focus: f64| {
            let (low, high) = depth_range_m(depths, focus);
            assert!(low > 0.0 && high.is_finite() && high >= 2.0 * low, "{depths:?}, {focus}: {low} to {high}");
            if focus.is_finite() && focus > 0.0 {
                assert!(low <= focus && focus <= high);
            }
            (low, high)
        };
        let (low, high) = covers(&[0.5, 2.0, f32::INFINITY], 1.0);
        assert!(low < 0.5 && high > 2.0);
        covers(&[], f64::INFINITY);
        covers(&[3.0; 4], 3.0);
        covers(&[f32::INFINITY], 0.02);
        covers(&[f32::NAN, -1.0, 0.0], f64::NAN);
        covers(&[1e-6, 1e6], 1e9);
    }

    #[test]
    fn positions_and_depths_are_inverse() {
        let area = Rect::from_min_max(pos2(10.0, 0.0), pos2(310.0, 150.0));
        let scale = Scale::of(area, &Lens { aperture_diameter_mm: 4.0, ..Lens::PINHOLE }, Some(&[0.5, 8.0]));
        for depth_m in [0.5, 1.0, 3.0, 8.0] {
            // f32 points: 3e-5 of 300 in ln(25) of depth.
            assert!((scale.depth_m(scale.x(depth_m)) / depth_m - 1.0).abs() < 1e-5);
        }
    }
}
