//! The picture in a pane: navigation, click to focus, magnification, the divider.

use super::engine::Request;
use super::model::Navigation;
use super::model::PictureSize;
use super::model::numbers::round_above;
use super::model::{Arrangement, Document, Edit, PaneId, Zoom};
use super::viewport_state::REST_SECONDS;
use super::{App, navigation, paint};
use defocus::methods::MethodError;
use eframe::egui::{
    Context, CursorIcon, Key, PointerButton, Pos2, Rect, Response, Role, Sense, Ui, Vec2, WidgetInfo, pos2, vec2,
};
use glam::{DVec2, DVec3, dvec2};
use std::time::Duration;

/// How long mouse and keys must rest before slow steps of a reference go on, seconds: longer
/// than between two letters that are typed.
const HOLD_SECONDS: f64 = 0.5;

/// A picture with a shorter side than this, px, shows nothing worth drawing.
const LEAST_SIDE_PX: u32 = 16;

/// Zoom for a point of scrolling, as an exponent: a notch of 50 points is 13 %.
const ZOOM_PER_POINT: f64 = 0.0025;

/// Panes that differ from the picture's size by less than this share show it pixel for
/// pixel all the same: a hair's breadth is cut off rather than everything blurred.
const SNAP: f32 = 0.03;

/// Where a picture of `size` points at its own scale lies around an `area`.
pub fn placed(area: Rect, size: Vec2, zoom: Zoom, ppp: f32) -> Rect {
    let fit = (area.width() / size.x).min(area.height() / size.y);
    let fit = if (fit - 1.0).abs() < SNAP { 1.0 } else { fit };
    let (scale, centre) = match zoom.scale {
        None => (fit, [0.5, 0.5]),
        Some(scale) => (scale, zoom.centre),
    };
    let shown = size * scale;
    let min = area.center() - vec2(centre[0], centre[1]) * shown;
    // On whole pixels of the display, so that texels and pixels coincide.
    let snapped = pos2((min.x * ppp).round() / ppp, (min.y * ppp).round() / ppp);
    Rect::from_min_size(snapped, shown)
}

impl App {
    /// The picture of one pane, or of two that lie over each other.
    pub(super) fn picture(&mut self, ui: &mut Ui, area: Rect, ids: &[PaneId]) {
        let Some(id) = ids.first().copied() else { return };
        for id in ids {
            self.viewport.areas.insert(*id, area);
        }
        let ppp = ui.ctx().pixels_per_point();
        paint::background(ui, area);
        if (area.size() * ppp).min_elem() < LEAST_SIDE_PX as f32 {
            return;
        }
        let picture = placed(area, self.natural_size(ppp), self.document.zoom, ppp);
        for id in ids {
            self.viewport.pictures.insert(*id, picture);
        }
        let now_s = ui.input(|i| i.time);
        let response = ui.interact(area, ui.scope_id().with(("picture", id)), Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, format!("Picture of pane {id}")));
        self.follow_pointer(&response, picture, id);
        self.magnify(ui, &response, area, picture);
        let pressed_at = response.interact_pointer_pos().filter(|at| picture.contains(*at));
        let pressed_at = pressed_at.map(|at| within(picture, at));
        if !self.drag_divider(ui, &response, area, picture, ids) && !self.drag_lens(ui, &response, pressed_at) {
            self.navigate(ui, &response);
        }
        if let (true, Some(at)) = (response.clicked(), pressed_at) {
            self.focus_on(at, now_s);
        }
        if response.clicked() && self.document.arrangement == Arrangement::Tiles && self.document.a != id {
            self.perform(ui.ctx(), super::Action::ChooseA(id));
        }
        paint::panes(self, ui, area, picture, ids);
        if ids.len() > 1 {
            self.divider(ui, area, picture);
        }
        paint::over(self, ui, area, id);
    }

    /// Size of the picture at its own scale, points.
    fn natural_size(&self, ppp: f32) -> Vec2 {
        let size = self.whole_size_px();
        vec2(size.x as f32, size.y as f32).max(Vec2::splat(1.0)) / ppp
    }

    fn follow_pointer(&mut self, response: &Response, picture: Rect, id: PaneId) {
        if let Some(at) = response.hover_pos().filter(|at| response.contains_pointer() && picture.contains(*at)) {
            self.viewport.cursor = Some(within(picture, at));
            self.viewport.hovered = Some(id);
        }
    }

    /// Magnifies about the pointer; moves what is magnified.
    fn magnify(&mut self, ui: &Ui, response: &Response, area: Rect, picture: Rect) {
        let width_px = self.whole_size_px().x.max(1) as f32;
        let mut zoom = self.document.zoom;
        let factor = ui.input(|i| i.zoom_delta());
        if let Some(at) = response.hover_pos().filter(|_| response.contains_pointer() && factor != 1.0) {
            let own = picture.width() / width_px * ui.ctx().pixels_per_point();
            let scale = (zoom.scale.unwrap_or(own) * factor).clamp(*Zoom::RANGE.start(), *Zoom::RANGE.end());
            let grown = picture.size() * (scale / zoom.scale.unwrap_or(own));
            let under = (at - picture.min) / picture.size();
            let centre = under - (at - area.center()) / grown;
            zoom = Zoom { scale: Some(scale), centre: [centre.x, centre.y].map(|c| c.clamp(0.0, 1.0)) };
        }
        if zoom.scale.is_some() && response.dragged_by(PointerButton::Middle) {
            let moved = response.drag_delta() / picture.size();
            let [x, y] = zoom.centre;
            zoom.centre = [x - moved.x, y - moved.y].map(|c| c.clamp(0.0, 1.0));
        }
        if zoom != self.document.zoom {
            self.edit(Edit::Zoom(zoom));
        }
    }

    fn navigate(&mut self, ui: &Ui, response: &Response) {
        let size = self.eye_size_px();
        let magnified = self.document.zoom.scale.is_some();
        let Document { camera: Some(before), pivot_m: pivot_before_m, .. } = &self.document else { return };
        let (mut moved, mut pivot_m) = (*before, *pivot_before_m);
        let camera = &mut moved;
        let delta = response.drag_delta();
        let height = f64::from(response.rect.height());
        let drag = dvec2(f64::from(delta.x), f64::from(delta.y)) / height;
        let shift = ui.input(|i| i.modifiers.shift);
        let middle = response.dragged_by(PointerButton::Middle) && !magnified;
        let panning = response.dragged_by(PointerButton::Secondary) || middle;
        if panning || (shift && response.dragged_by(PointerButton::Primary)) {
            navigation::pan(camera, pivot_m, drag * f64::from(size.y), size);
        } else if response.dragged_by(PointerButton::Primary) {
            match self.preferences.navigation {
                Navigation::Orbit => navigation::orbit(camera, pivot_m, drag),
                Navigation::Fly => navigation::look(camera, drag),
            }
        }
        if response.contains_pointer() {
            let scroll = ui.input(|i| f64::from(i.smooth_scroll_delta().y));
            if scroll != 0.0 {
                pivot_m = navigation::zoom(camera, pivot_m, (-scroll * ZOOM_PER_POINT).exp());
            }
            if let Some(along) = flight(ui) {
                navigation::fly(camera, along * pivot_m);
                ui.ctx().request_repaint();
            }
        }
        if (moved, pivot_m) != (*before, *pivot_before_m) {
            self.edit(Edit::Camera(moved, pivot_m));
        }
    }

    /// Has the engine draw what the document asks for in the panes as they lie now.
    pub(super) fn update_engine(&mut self, ui: &Ui) {
        let now_s = ui.input(|i| i.time);
        self.move_focus(ui);
        let ctx = ui.ctx();
        let before = self.viewport.window_px;
        self.viewport.measure(ctx.pixels_per_point());
        if self.viewport.window_px != before && self.document.size == PictureSize::Window {
            // The panes were laid out for the size before.
            ctx.request_repaint();
        }
        if self.viewport.window_px.min_element() < LEAST_SIDE_PX {
            return;
        }
        if ctx.input(|i| i.pointer.hover_pos().is_none()) {
            (self.viewport.cursor, self.viewport.hovered) = (None, None);
        }
        let first = self.viewport.hovered.filter(|id| self.viewport.areas.contains_key(id)).unwrap_or(self.document.a);
        let mut request = Request::new(&self.document, self.eye_size_px(), first);
        request.visible = self.visible_panes();
        if ui.input(|i| !i.events.is_empty()) {
            self.viewport.last_input_s = now_s;
        }
        request.held = now_s - self.viewport.last_input_s < HOLD_SECONDS;
        request.explain = self.inspector.is_open();
        request.story = self.inspector.story_of();
        request.display_settings.coc_scale_px = self.choose_coc_scale();
        self.viewport.watch_motion(now_s, &request);
        request.is_moving = self.viewport.is_moving;
        request.render.draft = self.viewport.is_camera_moving;
        self.viewport.filter = self.chosen_filter(ctx.pixels_per_point());
        match self.update_eyes(&mut request) {
            Ok(news) => {
                self.viewport.problem = None;
                if news {
                    // Names, numbers and legends follow the picture.
                    ctx.request_repaint();
                }
            }
            Err(error) => self.viewport.problem = Some(error.to_string()),
        }
        // Statistics need the depths on the CPU: once everything rests, not in every frame.
        if self.viewport.is_moving {
            ctx.request_repaint_after(Duration::from_secs_f64(REST_SECONDS));
        } else {
            self.engine.depths_m(true);
            self.read_magnified(ctx);
        }
    }

    /// Reads the pictures back whose pixels are large enough to show their values.
    fn read_magnified(&mut self, ctx: &Context) {
        let width_px = self.whole_size_px().x.max(1) as f32;
        let is_large = |picture: &Rect| picture.width() / width_px >= paint::VALUES_FROM;
        let large = self
            .viewport
            .pictures
            .iter()
            .filter(|(id, picture)| is_large(picture) && self.viewport.areas.contains_key(id));
        let large: Vec<PaneId> = large.map(|(id, _)| *id).collect();
        for id in large {
            if self.engine.known_color(id).is_none() && self.engine.color(id).is_some() {
                ctx.request_repaint();
            }
        }
    }

    /// Has one engine, or that of each eye, draw what is asked for; true if something was
    /// rendered.
    fn update_eyes(&mut self, request: &mut Request) -> Result<bool, MethodError> {
        let (Some(stereo), Some(camera)) = (self.stereo(), request.render.camera) else {
            self.eyes.forget();
            return self.engine.update(request);
        };
        let [left, right] = stereo.eyes(&camera);
        request.render.camera = Some(left);
        let news = self.engine.update(request)? | self.eyes.update(&self.engine, request, right)?;
        self.eyes.combine(&self.engine, stereo.layout, &request.visible);
        Ok(news)
    }

    /// |c| at the ends of the CoC's colour map, px: the greatest of the picture, rounded up,
    /// or what is set.
    pub(super) fn choose_coc_scale(&mut self) -> f32 {
        let lens = self.document.lens.clone();
        let depths = self.engine.depths_m(false).filter(|_| self.document.coc_scale_fits);
        let greatest = depths.and_then(|depths| lens.coc_statistics(depths.iter().copied()));
        let scale = greatest.map(|coc| round_above(coc.greatest_px()) as f32).filter(|px| px.is_finite());
        self.viewport.coc_scale_px = scale.unwrap_or(self.document.coc_scale_px);
        self.viewport.coc_scale_px
    }

    /// Pixels of the display for one of the picture in a pane.
    pub(super) fn magnification(&self, id: PaneId, ppp: f32) -> Option<f32> {
        let shown = self.viewport.pictures.get(&id)?;
        let width_px = Some(self.whole_size_px().x).filter(|px| *px > 0)?;
        Some(shown.width() * ppp / width_px as f32)
    }

    /// The panes that were laid out, and the one that blinks.
    fn visible_panes(&self) -> Vec<PaneId> {
        let laid_out = |id: &PaneId| self.viewport.areas.contains_key(id);
        let blinks = |id: &PaneId| self.viewport.blinking && *id == self.document.b;
        self.document.panes.iter().map(|p| p.id).filter(|id| laid_out(id) || blinks(id)).collect()
    }

    /// Magnified pixels have edges; what is drawn smaller for the sake of speed, or shrunk,
    /// is smooth.
    fn chosen_filter(&self, ppp: f32) -> wgpu::FilterMode {
        let magnified = self.magnification(self.document.a, ppp).is_some_and(|scale| match self.document.zoom.scale {
            None => scale > 1.5,
            Some(_) => scale >= 1.0,
        });
        match magnified {
            true => wgpu::FilterMode::Nearest,
            false => wgpu::FilterMode::Linear,
        }
    }

    /// Moves the divider where the drag began on it; true if it did. Where the pointer is
    /// when a slow frame comes to see the press may be far from it by then.
    fn drag_divider(&mut self, ui: &Ui, response: &Response, area: Rect, picture: Rect, ids: &[PaneId]) -> bool {
        let part = picture.intersect(area);
        if response.drag_started_by(PointerButton::Primary) {
            let from = ui.input(|i| i.pointer.press_origin());
            let handle = handle(part, self.document.divider);
            self.viewport.dividing = ids.len() > 1 && from.is_some_and(|from| handle.contains(from));
        }
        let dividing = self.viewport.dividing && response.dragged_by(PointerButton::Primary);
        if dividing {
            self.move_divider(part, response);
        }
        dividing
    }

    fn move_divider(&mut self, part: Rect, response: &Response) {
        if let Some(at) = response.interact_pointer_pos() {
            self.edit(Edit::Divider((at.x - part.left()) / part.width()));
        }
    }

    fn divider(&mut self, ui: &mut Ui, area: Rect, picture: Rect) {
        let part = picture.intersect(area);
        let handle = handle(part, self.document.divider);
        let response = ui.interact(handle, ui.scope_id().with("divider"), Sense::drag());
        let response = response.on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal);
        if response.dragged() {
            self.move_divider(part, &response);
        }
        let share = f64::from(self.document.divider);
        response.widget_info(|| WidgetInfo::slider(true, share, "Divider"));
    }
}

/// Where the divider can be taken hold of.
fn handle(picture: Rect, share: f32) -> Rect {
    let x = picture.left() + share * picture.width();
    Rect::from_x_y_ranges(x - 6.0..=x + 6.0, picture.y_range())
}

/// Flight in view space for this frame, in distances to the pivot, if a key is held.
fn flight(ui: &Ui) -> Option<DVec3> {
    // Half the distance to what one looks at in a second; four times that with shift.
    const SPEED: f64 = 0.5;
    if ui.ctx().egui_wants_keyboard_input() {
        return None;
    }
    ui.input(|i| {
        let axis = |plus, minus| f64::from(i8::from(i.key_down(plus)) - i8::from(i.key_down(minus)));
        let along = DVec3::new(axis(Key::D, Key::A), axis(Key::E, Key::Q), axis(Key::S, Key::W));
        let pressed = !i.modifiers.command && along != DVec3::ZERO;
        let speed = SPEED * if i.modifiers.shift { 4.0 } else { 1.0 } * f64::from(i.stable_dt.min(0.1));
        pressed.then(|| along.normalize_or_zero() * speed)
    })
}

/// Position in the picture, from (0, 0) to (1, 1), of a point of the window.
fn within(picture: Rect, at: Pos2) -> DVec2 {
    let share = (at - picture.min) / picture.size();
    dvec2(f64::from(share.x), f64::from(share.y))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_of_the_panes_size_is_shown_pixel_for_pixel() {
        let area = Rect::from_min_size(pos2(10.3, 20.0), vec2(299.0, 201.0));
        let shown = placed(area, vec2(300.0, 200.0), Zoom::default(), 1.0);
        assert_eq!(shown.size(), vec2(300.0, 200.0));
        assert_eq!(shown.min.x.fract(), 0.0);
    }

    #[test]
    fn what_is_magnified_keeps_its_centre_in_the_middle() {
        let area = Rect::from_min_size(Pos2::ZERO, vec2(400.0, 300.0));
        let zoom = Zoom { scale: Some(8.0), centre: [0.25, 0.75] };
        let shown = placed(area, vec2(400.0, 300.0), zoom, 2.0);
        let middle = shown.min + vec2(0.25, 0.75) * shown.size();
        assert!((middle - area.center()).length() <= 0.5, "{middle:?}");
    }
}
