//! Focusing with the mouse, on objects, by gaze and by itself; the aperture with the mouse.

use super::App;
use super::model::{Edit, FocusMode};
use super::ui::panels::Focusing;
use defocus::focus::{area_depth_m, depth_of_m, dioptres, metres, world_point};
use eframe::egui::{PointerButton, Response, Ui};
use glam::DVec2;

/// How long focus takes to where one clicked, seconds: long enough to be seen, too short
/// to wait for.
const FOCUS_SECONDS: f64 = 0.25;

/// Points of dragging that open the aperture by a factor of e.
const APERTURE_POINTS: f64 = 150.0;

/// A closed aperture is opened from here, mm.
const LEAST_APERTURE_MM: f64 = 0.05;

/// What moves the focus; nothing that would be saved.
#[derive(Default)]
pub struct FocusMotion {
    clicked: Option<Clicked>,
    following: Focusing,
    moving: bool,
}

/// Focus on its way to where one clicked, in dioptres: equal steps look equal.
struct Clicked {
    from_dpt: f64,
    to_m: f64,
    start_s: f64,
    at: DVec2,
}

impl FocusMotion {
    /// Leaves the focus where it is, and any object with it.
    pub fn stop(&mut self) {
        *self = Self::default();
    }

    /// Whether the focus moves by itself.
    pub fn is_moving(&self) -> bool {
        self.clicked.is_some() || self.moving
    }

    /// Whether an object is kept in focus.
    pub fn is_anchored(&self) -> bool {
        self.following.anchor.is_some()
    }

    /// Where one clicked, in the picture, while the focus moves there.
    pub fn clicked_at(&self) -> Option<DVec2> {
        self.clicked.as_ref().map(|clicked| clicked.at)
    }
}

impl App {
    /// Depth, metres, that counts at a point of the picture.
    fn depth_to_focus_m(&mut self, at: DVec2) -> Option<f64> {
        let radius_px = self.document.focus.radius_px();
        let (engine, own) = self.eye_of(at);
        let gpu = engine.gpu().clone();
        area_depth_m(&engine.view()?.depth_m(&gpu), own, radius_px)
    }

    /// The focus goes where one clicked in the picture.
    pub(super) fn focus_on(&mut self, at: DVec2, now_s: f64) {
        let Some(to_m) = self.depth_to_focus_m(at) else { return };
        self.viewport.hint = false;
        self.focus_motion.stop();
        if self.document.focus.mode == FocusMode::Object {
            let (engine, own) = self.eye_of(at);
            let seen = engine.view().and_then(|view| Some((*view.camera()?, *view.projection())));
            self.focus_motion.following.anchor =
                seen.and_then(|(camera, projection)| world_point(&camera, &projection, own, to_m));
        }
        let from_dpt = dioptres(self.document.lens.focus_distance_m);
        self.focus_motion.clicked = Some(Clicked { from_dpt, to_m, start_s: now_s, at });
    }

    /// Alt-drag: the focus is where the pointer is. Ctrl-drag: the aperture opens to the
    /// right. True if the drag was one of these.
    pub(super) fn drag_lens(&mut self, ui: &Ui, response: &Response, at: Option<DVec2>) -> bool {
        let modifiers = ui.input(|i| i.modifiers);
        if !response.dragged_by(PointerButton::Primary) {
            return false;
        }
        if modifiers.command {
            let factor = (f64::from(response.drag_delta().x) / APERTURE_POINTS).exp();
            let opened = self.document.lens.aperture_diameter_mm.max(LEAST_APERTURE_MM) * factor;
            if factor != 1.0 {
                // Closed all the way, it is a pinhole.
                self.edit(Edit::ApertureDiameter(if opened < LEAST_APERTURE_MM { 0.0 } else { opened.min(1e4) }));
            }
        } else if modifiers.alt {
            if let Some(to_m) = at.and_then(|at| self.depth_to_focus_m(at)) {
                self.edit(Edit::FocusDistance(to_m));
            }
        } else {
            return false;
        }
        self.viewport.hint = false;
        true
    }

    /// Moves the focus on, by whatever moves it.
    pub(super) fn move_focus(&mut self, ui: &Ui) {
        let (now_s, dt_s) = ui.input(|i| (i.time, f64::from(i.stable_dt)));
        self.move_to_clicked(now_s);
        match self.document.focus.mode {
            FocusMode::Object => self.keep_object(),
            FocusMode::Gaze => self.follow(self.viewport.cursor(), dt_s),
            FocusMode::Centre => self.follow(Some(DVec2::splat(0.5)), dt_s),
            FocusMode::Point | FocusMode::Area => self.focus_motion.moving = false,
        }
        if self.focus_motion.is_moving() {
            ui.ctx().request_repaint();
        }
    }

    fn move_to_clicked(&mut self, now_s: f64) {
        let Some(Clicked { from_dpt, to_m, start_s, .. }) = self.focus_motion.clicked else { return };
        let smooth = self.preferences.smooth_focus;
        let t = if smooth { ((now_s - start_s) / FOCUS_SECONDS).clamp(0.0, 1.0) } else { 1.0 };
        let eased = t * t * (3.0 - 2.0 * t);
        if t < 1.0 {
            self.document.lens.focus_distance_m = metres(from_dpt + (dioptres(to_m) - from_dpt) * eased);
        } else {
            self.document.lens.focus_distance_m = to_m;
            self.focus_motion.clicked = None;
        }
    }

    /// Keeps the object in focus, wherever the camera is; behind the camera, nothing moves.
    fn keep_object(&mut self) {
        self.focus_motion.moving = false;
        if self.focus_motion.clicked.is_some() {
            return;
        }
        if let (Some(anchor), Some(camera)) = (self.focus_motion.following.anchor, self.document.camera)
            && let Some(depth_m) = depth_of_m(&camera, anchor)
        {
            // The click took the depth of a pixel, whose place is known to 24 bits.
            let focus_m = &mut self.document.lens.focus_distance_m;
            if (*focus_m / depth_m - 1.0).abs() > 1e-6 {
                *focus_m = depth_m;
            }
        }
    }

    fn follow(&mut self, at: Option<DVec2>, dt_s: f64) {
        self.focus_motion.moving = false;
        if self.focus_motion.clicked.is_some() {
            return;
        }
        let Some(target_m) = at.and_then(|at| self.depth_to_focus_m(at)) else { return };
        // What is nearer than an image forms is looked at as near as one does.
        let nearest_m = 1.01 * self.document.lens.focal_length_mm / defocus::lens::MM_PER_M;
        let current_m = self.document.lens.focus_distance_m;
        let time_constant_s = self.document.focus.time_constant_s;
        let step = self.focus_motion.following.follow(target_m.max(nearest_m), current_m, time_constant_s, dt_s);
        self.document.lens.focus_distance_m = step.focus_m;
        self.focus_motion.moving = step.moving;
    }
}
