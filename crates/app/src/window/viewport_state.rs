//! What is known of the panes' pictures from frame to frame: where they lie, where the pointer
//! is in them, and whether something moves.

use super::engine::{RenderRequest, Request};
use super::model::{MethodChoice, PaneId};
use eframe::egui::Rect;
use glam::{DVec2, UVec2, uvec2};
use std::collections::BTreeMap;

/// How long all that pictures depend on must rest before what was drawn smaller is drawn in
/// full, seconds.
pub(super) const REST_SECONDS: f64 = 0.2;

/// The viewport's own state: nothing that would be saved.
pub struct Viewport {
    /// Where there is room for a pane's picture, points.
    pub(super) areas: BTreeMap<PaneId, Rect>,
    /// Where the feet of panes go, points, until they are drawn.
    pub(super) feet: Vec<(PaneId, Rect)>,
    /// Where the whole picture lies in it, points.
    pub(super) pictures: BTreeMap<PaneId, Rect>,
    /// Room that the largest pane has for a picture, px.
    pub(super) window_px: UVec2,
    /// Where the pointer is in the picture.
    pub(super) cursor: Option<DVec2>,
    pub(super) hovered: Option<PaneId>,
    pub(super) blinking: bool,
    pub(super) last_motion_s: f64,
    pub(super) last_camera_motion_s: f64,
    pub(super) last_input_s: f64,
    /// Whether what is dragged is the divider.
    pub(super) dividing: bool,
    /// What pictures depended on in the frame before.
    pub(super) depended_on: Option<(RenderRequest, Vec<MethodChoice>)>,
    pub(super) is_moving: bool,
    pub(super) is_camera_moving: bool,
    pub(super) filter: wgpu::FilterMode,
    /// |c| at the ends of the CoC's colour map, px.
    pub(super) coc_scale_px: f32,
    /// Whether the hint how to begin is still of use.
    pub(super) hint: bool,
    /// Why the picture is not up to date.
    pub(super) problem: Option<String>,
}

impl Default for Viewport {
    fn default() -> Self {
        Self {
            areas: BTreeMap::new(),
            feet: Vec::new(),
            pictures: BTreeMap::new(),
            window_px: UVec2::ZERO,
            cursor: None,
            hovered: None,
            blinking: false,
            last_motion_s: f64::NEG_INFINITY,
            last_camera_motion_s: f64::NEG_INFINITY,
            last_input_s: f64::NEG_INFINITY,
            dividing: false,
            depended_on: None,
            is_moving: false,
            is_camera_moving: false,
            filter: wgpu::FilterMode::Linear,
            coc_scale_px: 1.0,
            hint: true,
            problem: None,
        }
    }
}

impl Viewport {
    /// Where the whole picture of a pane is, points.
    pub fn picture(&self, pane: PaneId) -> Option<Rect> {
        self.pictures.get(&pane).copied()
    }

    /// Where the pointer is in the picture, from (0, 0) to (1, 1).
    pub fn cursor(&self) -> Option<DVec2> {
        self.cursor
    }

    /// The pane under the pointer.
    pub fn hovered(&self) -> Option<PaneId> {
        self.hovered
    }

    /// Room that the largest pane has for a picture, px; zero before the first frame.
    pub fn window_px(&self) -> UVec2 {
        self.window_px
    }

    /// Whether pane B is shown in place of A.
    pub fn is_blinking(&self) -> bool {
        self.blinking
    }

    /// Shows pane B in place of A, or stops that.
    pub fn set_blinking(&mut self, blinking: bool) {
        self.blinking = blinking;
    }

    /// How textures are magnified.
    pub fn filter(&self) -> wgpu::FilterMode {
        self.filter
    }

    /// Whether nothing that pictures depend on was changed just now.
    pub fn is_at_rest(&self) -> bool {
        !self.is_moving
    }

    /// Why the picture is not up to date.
    pub fn problem(&self) -> Option<&str> {
        self.problem.as_deref()
    }

    /// Sees whether something changed that pictures depend on: the camera, the lens, a
    /// parameter, by whatever it is moved.
    pub(super) fn watch_motion(&mut self, now_s: f64, request: &Request) {
        let methods = request.panes.iter().map(|pane| pane.method.clone()).collect();
        let now = (request.render.clone(), methods);
        if self.depended_on.as_ref().is_some_and(|(before, _)| before.camera != request.render.camera) {
            self.last_camera_motion_s = now_s;
        }
        if self.depended_on.as_ref().is_some_and(|before| *before != now) {
            self.last_motion_s = now_s;
        }
        self.depended_on = Some(now);
        self.is_moving = now_s - self.last_motion_s < REST_SECONDS;
        self.is_camera_moving = now_s - self.last_camera_motion_s < REST_SECONDS;
    }

    /// Takes the room that there is: that of the largest area, so that a picture as large as
    /// the window is the same in all panes and they can be compared.
    pub(super) fn measure(&mut self, ppp: f32) {
        let px = |points: f32| (points.max(0.0) * ppp).round() as u32;
        let sizes = self.areas.values().map(|area| uvec2(px(area.width()), px(area.height())));
        self.window_px = sizes.max_by_key(|size| u64::from(size.x) * u64::from(size.y)).unwrap_or(UVec2::ZERO);
    }
}
