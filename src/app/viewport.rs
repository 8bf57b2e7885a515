//! The picture: navigation, click to focus, the divider, and what is painted over it.

use super::App;
use super::engine::Request;
use super::paint;
use super::settings::{Navigation, Show};
use super::{navigation, settings::Settings};
use crate::lens::Lens;
use eframe::egui::{CursorIcon, Key, PointerButton, Pos2, Rect, Response, Role, Sense, Ui, WidgetInfo, vec2};
use glam::{DVec2, DVec3, UVec2, dvec2, uvec2};

/// How long focus takes to where one clicked, seconds: long enough to be seen, too short
/// to wait for.
const FOCUS_SECONDS: f64 = 0.25;

/// A frame that takes longer, ms, makes the camera feel stuck: it is drawn smaller.
const SLOW_FRAME_MS: f64 = 60.0;

/// How long the camera must rest before a reduced picture is refined, seconds.
const REST_SECONDS: f64 = 0.2;

/// A picture with a shorter side than this, px, shows nothing worth drawing.
const LEAST_SIDE_PX: u32 = 16;

/// Zoom for a point of scrolling, as an exponent: a notch of 50 points is 13 %.
const ZOOM_PER_POINT: f64 = 0.0025;

/// The viewport's own state: nothing that would be saved.
pub struct Viewport {
    /// Where the picture is, points.
    picture: Rect,
    /// Size of the area for it, px.
    area_px: UVec2,
    last_motion_s: f64,
    /// Time of a frame at full size, ms.
    full_ms: f64,
    scale: f64,
    focusing: Option<Focusing>,
    /// Whether the hint how to begin is still of use.
    hint: bool,
    /// Why the picture is not up to date.
    problem: Option<String>,
}

/// Focus on its way, in dioptres: equal steps look equal.
struct Focusing {
    from_dpt: f64,
    to_m: f64,
    start_s: f64,
    at: Pos2,
}

impl Default for Viewport {
    fn default() -> Self {
        Self {
            picture: Rect::NOTHING,
            area_px: UVec2::ZERO,
            last_motion_s: f64::NEG_INFINITY,
            full_ms: 0.0,
            scale: 1.0,
            focusing: None,
            hint: true,
            problem: None,
        }
    }
}

impl Viewport {
    /// Where the picture is, points.
    pub fn picture(&self) -> Rect {
        self.picture
    }

    /// Size of the area for the picture, px; zero before the first frame.
    pub fn area_px(&self) -> UVec2 {
        self.area_px
    }

    /// Leaves the focus where it is.
    pub fn stop_focusing(&mut self) {
        self.focusing = None;
    }

    /// Whether nothing moves by itself and the picture has its full size.
    pub fn is_at_rest(&self) -> bool {
        self.focusing.is_none() && self.scale >= 1.0
    }

    /// Why the picture is not up to date.
    pub fn problem(&self) -> Option<&str> {
        self.problem.as_deref()
    }

    fn moved(&mut self, now_s: f64) {
        self.last_motion_s = now_s;
    }

    /// How much smaller than the viewport to draw while the camera moves.
    fn choose_scale(&mut self, now_s: f64, last_ms: Option<f64>) {
        if self.scale >= 1.0 {
            self.full_ms = last_ms.unwrap_or(0.0);
        }
        let moving = now_s - self.last_motion_s < REST_SECONDS;
        self.scale = match self.full_ms {
            ms if !moving || ms <= SLOW_FRAME_MS => 1.0,
            ms if ms <= 4.0 * SLOW_FRAME_MS => 0.5,
            _ => 0.25,
        };
    }
}

impl App {
    /// The area in the middle.
    pub(super) fn show_viewport(&mut self, ui: &mut Ui) {
        let area = ui.available_rect_before_wrap();
        let ppp = f64::from(ui.ctx().pixels_per_point());
        let px = |points: f32| (f64::from(points.max(0.0)) * ppp).round() as u32;
        self.viewport.area_px = uvec2(px(area.width()), px(area.height()));
        if self.viewport.area_px.min_element() < LEAST_SIDE_PX {
            return;
        }
        let now_s = ui.input(|i| i.time);
        let response = ui.interact(area, ui.scope_id().with("picture"), Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, "Picture"));
        self.navigate(ui, &response, now_s);
        self.click_to_focus(&response, now_s);
        self.move_focus(ui, now_s);
        self.update_picture(ui, now_s);
        self.viewport.picture = self.fitted(area);
        self.divider(ui);
        self.paint_viewport(ui, area);
    }

    fn navigate(&mut self, ui: &Ui, response: &Response, now_s: f64) {
        let size = self.viewport.area_px;
        let Settings { camera: Some(camera), pivot_m, navigation, .. } = &mut self.settings else { return };
        let before = *camera;
        let delta = response.drag_delta();
        let height = f64::from(response.rect.height());
        let drag = dvec2(f64::from(delta.x), f64::from(delta.y)) / height;
        let shift = ui.input(|i| i.modifiers.shift);
        let panning = response.dragged_by(PointerButton::Secondary) || response.dragged_by(PointerButton::Middle);
        if panning || (shift && response.dragged_by(PointerButton::Primary)) {
            navigation::pan(camera, *pivot_m, drag * f64::from(size.y), size);
        } else if response.dragged_by(PointerButton::Primary) {
            match navigation {
                Navigation::Orbit => navigation::orbit(camera, *pivot_m, drag),
                Navigation::Fly => navigation::look(camera, drag),
            }
        }
        if response.contains_pointer() {
            let (scroll, pinch) = ui.input(|i| (f64::from(i.smooth_scroll_delta().y), f64::from(i.zoom_delta())));
            let factor = (-scroll * ZOOM_PER_POINT).exp() / pinch;
            if factor != 1.0 {
                *pivot_m = navigation::zoom(camera, *pivot_m, factor);
            }
        }
        if let Some(along) = flight(ui) {
            navigation::fly(camera, along * *pivot_m);
            ui.ctx().request_repaint();
        }
        if *camera != before {
            self.viewport.moved(now_s);
        }
    }

    fn click_to_focus(&mut self, response: &Response, now_s: f64) {
        let picture = self.viewport.picture;
        let Some(at) = response.interact_pointer_pos().filter(|at| response.clicked() && picture.contains(*at)) else {
            return;
        };
        let Some(to_m) = self.engine.depth_at_m(within(picture, at)) else { return };
        self.viewport.hint = false;
        let from_dpt = 1.0 / self.settings.lens.focus_distance_m;
        self.viewport.focusing = Some(Focusing { from_dpt, to_m, start_s: now_s, at });
    }

    fn move_focus(&mut self, ui: &Ui, now_s: f64) {
        let Some(Focusing { from_dpt, to_m, start_s, .. }) = self.viewport.focusing else { return };
        let t = if self.settings.smooth_focus { ((now_s - start_s) / FOCUS_SECONDS).clamp(0.0, 1.0) } else { 1.0 };
        let eased = t * t * (3.0 - 2.0 * t);
        if t < 1.0 {
            self.settings.lens.focus_distance_m = 1.0 / (from_dpt + (1.0 / to_m - from_dpt) * eased);
            ui.ctx().request_repaint();
        } else {
            self.settings.lens.focus_distance_m = to_m;
            self.viewport.focusing = None;
        }
    }

    fn update_picture(&mut self, ui: &Ui, now_s: f64) {
        self.viewport.choose_scale(now_s, self.engine.history.last_ms());
        if self.viewport.scale < 1.0 {
            ui.ctx().request_repaint_after(std::time::Duration::from_secs_f64(REST_SECONDS));
        }
        let request = request(&self.settings, self.viewport.area_px, self.viewport.scale);
        self.viewport.problem = match self.engine.update(&request) {
            Ok(_) => None,
            Err(error) => Some(error.to_string()),
        };
        self.register_textures();
        // Statistics need the depths on the CPU: once the camera rests, not in every frame.
        if now_s - self.viewport.last_motion_s >= REST_SECONDS {
            self.engine.depths_m(true);
        } else {
            ui.ctx().request_repaint_after(std::time::Duration::from_secs_f64(REST_SECONDS));
        }
    }

    /// A scene fills the area; an image keeps its shape.
    fn fitted(&self, area: Rect) -> Rect {
        match (self.engine.source(), self.engine.size()) {
            (Some(source), Some(size)) if !source.source().is_scene() => {
                let size = vec2(size.x as f32, size.y as f32);
                let fit = (area.width() / size.x).min(area.height() / size.y);
                Rect::from_center_size(area.center(), size * fit)
            }
            _ => area,
        }
    }

    fn divider(&mut self, ui: &mut Ui) {
        if !self.is_wiping() {
            return;
        }
        let picture = self.viewport.picture;
        let x = picture.left() + self.settings.divider * picture.width();
        let handle = Rect::from_x_y_ranges(x - 6.0..=x + 6.0, picture.y_range());
        let response = ui.interact(handle, ui.scope_id().with("divider"), Sense::drag());
        let response = response.on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal);
        if let (true, Some(at)) = (response.dragged(), response.interact_pointer_pos()) {
            self.settings.divider = ((at.x - picture.left()) / picture.width()).clamp(0.0, 1.0);
        }
        let share = f64::from(self.settings.divider);
        response.widget_info(|| WidgetInfo::slider(true, share, "Divider"));
    }

    /// Whether there are two pictures side by side.
    pub(super) fn is_wiping(&self) -> bool {
        self.settings.methods.len() == 2 && self.settings.show == Show::Picture
    }

    fn paint_viewport(&self, ui: &Ui, area: Rect) {
        paint::background(ui, area);
        paint::panes(self, ui, self.viewport.picture);
        paint::legend(self, ui, area);
        if let Some(focusing) = &self.viewport.focusing {
            paint::reticle(ui, focusing.at);
        }
        match (&self.viewport.problem, self.loader.loading()) {
            (_, Some(spec)) => paint::loading(ui, area, spec),
            (Some(problem), None) => paint::banner(ui, area, problem),
            (None, None) if self.viewport.hint && self.engine.source().is_some() => {
                let hint = "Click what should be sharp · drag to orbit, right-drag to move, scroll to zoom";
                paint::banner(ui, area, hint);
            }
            (None, None) => {}
        }
    }
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

/// What to render for these settings in an area of `area_px`, `scale` times as large.
/// Lengths in pixels shrink with the picture: the blur covers the same part of it.
fn request(settings: &Settings, area_px: UVec2, scale: f64) -> Request {
    let lens = settings.lens.clone();
    Request {
        camera: settings.camera,
        size: (area_px.as_dvec2() * scale).round().as_uvec2().max(UVec2::ONE),
        overscan_px: (f64::from(settings.overscan_px) * scale).round() as u32,
        lens: Lens { density_px_per_mm: lens.density_px_per_mm * scale, ..lens },
        methods: settings.methods.clone(),
        display: settings.display,
        show: settings.show,
        acceptable_coc_px: settings.acceptable_coc_px * scale as f32,
        coc_scale_px: settings.coc_scale_px * scale as f32,
    }
}

/// Position in the picture, from (0, 0) to (1, 1), of a point of the window.
fn within(picture: Rect, at: Pos2) -> DVec2 {
    let share = (at - picture.min) / picture.size();
    dvec2(f64::from(share.x), f64::from(share.y))
}
