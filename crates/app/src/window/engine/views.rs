//! The scene as it is seen in full, and as it is seen smaller while something moves.

use super::request::RenderRequest;
use defocus::camera::Camera;
use defocus::view::{View, ViewError};
use defocus_study::GpuSource;
use glam::UVec2;

/// A view with what it was asked for.
struct Seen {
    view: View,
    camera: Option<Camera>,
    size: UVec2,
    overscan_px: u32,
}

impl Seen {
    fn is_of(&self, render: &RenderRequest) -> bool {
        (self.camera, self.size, self.overscan_px) == (render.camera, render.size, render.overscan_px)
    }
}

/// Two views of a source: each keeps what was drawn while the other is used.
#[derive(Default)]
pub(super) struct Views {
    full: Option<Seen>,
    coarse: Option<Seen>,
}

/// Which of the two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Which {
    Full,
    Coarse,
}

impl Views {
    /// Brings one of them where `render` asks for; true if it was elsewhere.
    pub fn prepare(&mut self, source: &GpuSource, render: &RenderRequest, which: Which) -> Result<bool, ViewError> {
        let slot = match which {
            Which::Full => &mut self.full,
            Which::Coarse => &mut self.coarse,
        };
        if let Some(seen) = slot.as_mut().filter(|seen| seen.is_of(render)) {
            seen.view.set_draft(render.draft);
            return Ok(false);
        }
        let RenderRequest { camera, size, overscan_px, .. } = *render;
        let known = slot.take().filter(|_| source.source().is_scene());
        let mut view = match known {
            Some(Seen { mut view, .. }) => {
                view.set_size(source.gpu(), size, overscan_px)?;
                view
            }
            None => source.view(0, size, overscan_px, None)?,
        };
        if let Some(camera) = camera {
            view.set_camera(camera);
        }
        view.set_draft(render.draft);
        *slot = Some(Seen { view, camera, size, overscan_px });
        Ok(true)
    }

    /// Gives back what the smaller view holds.
    pub fn forget_coarse(&mut self) {
        self.coarse = None;
    }

    /// The view that `render` asks for, if it is prepared.
    pub fn of(&mut self, render: &RenderRequest) -> Option<&mut View> {
        let mut both = self.full.iter_mut().chain(&mut self.coarse);
        both.find(|seen| seen.is_of(render)).map(|seen| &mut seen.view)
    }

    /// The view from the camera of `render`: in full if that is prepared, else smaller.
    pub fn where_taken(&mut self, render: &RenderRequest) -> Option<&mut View> {
        let mut both = self.full.iter_mut().filter(|seen| seen.is_of(render)).chain(&mut self.coarse);
        both.find(|seen| seen.camera == render.camera).map(|seen| &mut seen.view)
    }
}
