//! The second eye: an engine of its own for the right view, and both pictures in one.
//!
//! The window's engine draws the left eye's view, so that everything else (figures, depths,
//! intermediate textures) is the left eye's.

use super::model::PaneId;
use super::{App, Engine, Request};
use defocus::camera::Camera;
use defocus::combine;
use defocus::gpu::Texture;
use defocus::methods::MethodError;
use defocus::stereo::{Layout, Stereo};
use glam::{DVec2, UVec2, dvec2};
use std::collections::BTreeMap;
use std::time::Duration;

/// What the right eye sees.
#[derive(Default)]
pub struct Eyes {
    right: Option<Engine>,
    combined: BTreeMap<PaneId, Combined>,
}

/// Both eyes' pictures of a pane in one, and what it was made of.
struct Combined {
    of: [Texture; 2],
    layout: Layout,
    texture: Texture,
}

impl Eyes {
    /// Starts anew, as with another scene.
    pub fn forget(&mut self) {
        *self = Self::default();
    }

    /// When the right eye should be looked after although nothing was changed.
    pub fn wants_update_in(&self) -> Option<Duration> {
        self.right.as_ref()?.wants_update_in()
    }

    /// The engine of the right eye, while there is one.
    pub fn right(&mut self) -> Option<&mut Engine> {
        self.right.as_mut()
    }

    /// Both eyes' pictures of a pane in one.
    pub fn shown(&self, id: PaneId) -> Option<&Texture> {
        self.combined.get(&id).map(|c| &c.texture)
    }

    /// Time of the right eye's last frame of a pane, ms.
    pub fn ms(&self, id: PaneId) -> Option<f64> {
        self.right.as_ref()?.pane(id)?.ms()
    }

    /// Brings the right eye's view up to date with that of the left; true if something was
    /// rendered. `request` is the left eye's.
    pub fn update(&mut self, left: &Engine, request: &Request, camera: Camera) -> Result<bool, MethodError> {
        if left.source().is_none() {
            return Ok(false);
        }
        let right = self.right.get_or_insert_with(|| left.sibling());
        let mut request = request.clone();
        request.render.camera = Some(camera);
        // What differs from the truth is measured for one eye.
        request.reference = None;
        request.panes.retain(|pane| pane.id != PaneId::HIDDEN);
        right.update(&request)
    }

    /// Puts the pictures together where either of them is new.
    pub fn combine(&mut self, left: &Engine, layout: Layout, ids: &[PaneId]) {
        let Some(right) = &self.right else { return };
        self.combined.retain(|id, _| ids.contains(id));
        let mut frame = left.gpu().frame();
        let mut news = false;
        for id in ids {
            let shown = |engine: &Engine| engine.pane(*id).and_then(|p| p.shown()).cloned();
            let (Some(l), Some(r)) = (shown(left), shown(right)) else { continue };
            let is_new = |c: &Combined| c.layout != layout || !c.of[0].same(&l) || !c.of[1].same(&r);
            if l.size() == r.size() && self.combined.get(id).is_none_or(is_new) {
                let texture = combine::stereo(&mut frame, &l, &r, layout);
                self.combined.insert(*id, Combined { of: [l, r], layout, texture });
                news = true;
            }
        }
        if news {
            frame.finish();
        }
    }
}

impl App {
    /// How the scene is seen with two eyes, if it is.
    pub(super) fn stereo(&self) -> Option<Stereo> {
        let is_scene = self.engine.source().is_some_and(|s| s.source().is_scene());
        self.document.stereo.filter(|_| is_scene && self.document.camera.is_some())
    }

    /// Size of the picture that one eye sees, px; zero before there is anything to see.
    pub(super) fn eye_size_px(&self) -> UVec2 {
        let Some(source) = self.engine.source() else { return UVec2::ZERO };
        // Side by side, two pictures share the window's room.
        let window = self.viewport.window_px();
        let window = self.stereo().map_or(window, |stereo| stereo.layout.eye_size(window));
        self.document.size.resolved(source.source(), self.document.camera_index, window)
    }

    /// Size of what a pane shows, px: of one eye's picture, or of two beside each other.
    pub(super) fn whole_size_px(&self) -> UVec2 {
        let eye = self.eye_size_px();
        self.stereo().map_or(eye, |stereo| stereo.layout.whole_size(eye))
    }

    /// Where a point of the picture lies in the picture of the eye that sees it there, and
    /// whether that is the right eye.
    pub(super) fn in_eye(&self, at: DVec2) -> (DVec2, bool) {
        match self.stereo() {
            Some(Stereo { layout, .. }) if layout.is_side_by_side() => {
                let second = at.x >= 0.5;
                let own = dvec2(2.0 * at.x - f64::from(u8::from(second)), at.y);
                (own, second != (layout == Layout::Crossed))
            }
            _ => (at, false),
        }
    }

    /// The engine of the eye that sees a point of the picture, and where it sees it.
    pub(super) fn eye_of(&mut self, at: DVec2) -> (&mut Engine, DVec2) {
        let (own, is_right) = self.in_eye(at);
        match self.eyes.right().filter(|_| is_right) {
            Some(right) => (right, own),
            None => (&mut self.engine, own),
        }
    }

    /// What a pane shows, of one eye or both.
    pub(super) fn shown(&self, id: PaneId) -> Option<&Texture> {
        let left = self.engine.pane(id)?.shown();
        if self.stereo().is_some() { self.eyes.shown(id).or(left) } else { left }
    }

    /// GPU time, ms, of pane A's method for both eyes of a headset; `None` of a software
    /// adapter, whose times say nothing about one.
    pub(super) fn both_eyes_ms(&self) -> Option<f64> {
        if self.engine.gpu().is_software() {
            return None;
        }
        let a = self.document.a;
        let left = self.engine.pane(a)?.ms()?;
        let right = self.stereo().and_then(|_| self.eyes.ms(a));
        Some(left + right.unwrap_or(left))
    }
}
