//! What the pictures hold in numbers, read back when someone asks for it.

use super::renderer::Engine;
use crate::window::model::PaneId;
use defocus::camera::Camera;
use defocus::gpu::download;
use defocus::image::ColorImage;
use defocus::lens::Lens;
use defocus::methods::MethodError;
use defocus::view::View;
use glam::{DVec2, UVec2};
use std::sync::Arc;

/// Depths that the CoC statistics are taken over, at most: their 95th percentile then has
/// a standard error of 0.2 % in rank, and a lens slider costs under a millisecond.
const DEPTH_SAMPLES: usize = 16_384;

impl Engine {
    /// Depth, metres, at a point of the picture given from (0, 0) top left to (1, 1).
    /// Reads the depth back if that was not done since the view was last drawn.
    pub fn depth_at_m(&mut self, at: DVec2) -> Option<f64> {
        if self.device_errors.is_lost() {
            return None;
        }
        let gpu = self.gpu.clone();
        let depth = self.view()?.depth_m(&gpu);
        let texel = (at.clamp(DVec2::ZERO, DVec2::ONE) * depth.size.as_dvec2()).as_uvec2();
        let texel = texel.min(depth.size - 1);
        Some(f64::from(depth.at(texel.x, texel.y)))
    }

    /// A regular sample of the depths in view, metres, read back at most once a redraw;
    /// `None` before there is a view, and where nothing is known yet and `read` is false.
    pub fn depths_m(&mut self, read: bool) -> Option<&[f32]> {
        if self.depths_m.is_none() && read && !self.device_errors.is_lost() {
            let gpu = self.gpu.clone();
            let depth = self.view()?.depth_m(&gpu);
            let stride = depth.pixels.len().div_ceil(DEPTH_SAMPLES).max(1);
            self.depths_m = Some(depth.pixels.iter().step_by(stride).copied().collect());
        }
        self.depths_m.as_deref()
    }

    /// The view that is shown, for whoever needs more of it than the depths; a smaller one
    /// while something moves and there is no time for that. `None` once the device is lost.
    pub fn view(&mut self) -> Option<&mut View> {
        let asked = self.asked.as_ref().filter(|_| !self.device_errors.is_lost())?;
        self.views.where_taken(&asked.render)
    }

    /// A pane's picture, linear, on the CPU: read back at most once for each picture, which
    /// waits for the GPU.
    pub fn color(&mut self, id: PaneId) -> Option<Arc<ColorImage>> {
        let pane = self.panes.get(&id)?;
        let linear = pane.linear.as_ref().filter(|_| !self.device_errors.is_lost())?;
        match self.colors.get(&id) {
            Some((revision, color)) if *revision == pane.revision => Some(color.clone()),
            _ => {
                let color = Arc::new(download(&self.gpu, linear));
                self.colors.insert(id, (pane.revision, color.clone()));
                Some(color)
            }
        }
    }

    /// [`Engine::color`] where it was read back already.
    pub fn known_color(&self, id: PaneId) -> Option<&ColorImage> {
        let revision = self.panes.get(&id)?.revision;
        self.colors.get(&id).filter(|(of, _)| *of == revision).map(|(_, color)| color.as_ref())
    }

    /// `lens`, opened so far that the picture from `camera` in a frame of `size` has a mean CoC
    /// of `mean_px`; `None` where nothing is blurred whatever E is.
    pub fn lens_with_mean_coc(&self, camera: Option<Camera>, size: UVec2, lens: &Lens, mean_px: f64) -> Option<Lens> {
        let mut view = self.source.as_ref()?.view(0, size, 0, None).ok()?;
        if let Some(camera) = camera {
            view.set_camera(camera);
        }
        lens.with_mean_coc(mean_px, view.depth_m(&self.gpu).pixels.iter().copied())
    }

    /// A lens that suits the source seen by `camera` in a frame of `size`, on a display that
    /// shows it under the angle under which it was taken.
    ///
    /// # Errors
    ///
    /// A view that cannot be drawn.
    pub fn default_lens(&mut self, camera: Option<Camera>, size: UVec2) -> Result<Lens, MethodError> {
        let Some(source) = &self.source else { return Ok(Lens::PINHOLE) };
        let mut view = source.view(0, size, 0, None)?;
        if let Some(camera) = camera {
            view.set_camera(camera);
        }
        let lens = source.source().default_lens(&view.depth_m(&self.gpu));
        let fitted = lens.with_display_fov_x(view.size().x, view.projection().fov_x());
        // The CoC in pixels is proportional to both.
        let as_wide = lens.density_px_per_mm / fitted.density_px_per_mm;
        Ok(Lens { aperture_diameter_mm: lens.aperture_diameter_mm * as_wide, ..fitted })
    }
}
