//! Views from many points of a lens at little cost to the CPU: what may be in any of them is
//! found, sorted and uploaded once; a view then draws that with its own eye. It is not a render
//! bundle: finishing one on a lost device panics (wgpu 30).

use super::Layer;
use super::pipelines::{COLOR, DEPTH_BUFFER, LayerKind, STORED_DEPTH};
use super::raster::{SceneSource, Shot, Visible, begin_pass};
use crate::camera::Projection;
use crate::gpu::{Frame, Piece, Resource};
use glam::Vec4;
use std::sync::{Arc, PoisonError};

/// The eyes on a lens, in view space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Eyes {
    /// How far from the lens's centre they lie at most, m.
    pub radius_m: f32,
    /// Vergence, D, at which all of them see the same frame: that of what is sharp, less than 0 where
    /// nothing is.
    pub focus_d: f32,
    /// By how much astigmatism moves the frame at most, over the distance.
    pub astigmatism_slope: f32,
}

impl Eyes {
    /// How far the sides of a frustum lie from those of the lens's centre at most where this
    /// sphere (centre, radius) is, m: the sides meet in focus and are apart by the eye's
    /// distance at the lens. Astigmatism turns them further.
    pub(super) fn shift_m(&self, sphere: Vec4) -> f32 {
        let at = |d: f32| (1.0 - d * self.focus_d).abs();
        let (near_m, far_m) = (-sphere.z - sphere.w, -sphere.z + sphere.w);
        self.radius_m * at(near_m).max(at(far_m)) + self.astigmatism_slope * far_m.max(0.0)
    }
}

/// What the views from a lens have in common.
pub(super) struct LensViews {
    projection: Projection,
    eyes: Eyes,
    drawn: Visible,
    bind_group: wgpu::BindGroup,
    instances: wgpu::Buffer,
    /// A [`ViewUniform`](super::pipelines::ViewUniform): that of the view which is drawn next.
    view: wgpu::Buffer,
}

impl SceneSource {
    /// Draws the nearest layer as one of `eyes` sees it: all that of a shot differs among them
    /// is the uniform.
    pub(super) fn draw_from_lens(&self, frame: &mut Frame<'_>, label: &str, shot: &Shot<'_>, eyes: Eyes) -> Layer {
        let common = self.lens_views(frame, shot, eyes);
        let size = shot.projection.outer_size();
        let layer = Layer {
            color: frame.texture("layer colour", size, COLOR),
            depth: frame.texture("layer depth", size, STORED_DEPTH),
        };
        let depth_buffer = frame.texture("depth buffer", size, DEPTH_BUFFER);
        frame.stats.triangles += common.drawn.triangles(&self.scene);
        frame.stats.views += 1;
        let uniform = self.uniform(shot);
        let Piece { buffer, offset } = frame.data(bytemuck::bytes_of(&uniform));
        let bytes = common.view.size();
        frame.encoder().copy_buffer_to_buffer(&buffer, u64::from(offset), &common.view, 0, bytes);
        let mut pass = begin_pass(frame, label, &[&layer.color, &layer.depth], &depth_buffer);
        pass.set_bind_group(0, &common.bind_group, &[0]);
        common.drawn.encode(&mut pass, &self.scene, common.instances.slice(..));
        drop(pass);
        layer
    }

    /// The last ones' if they are the same.
    fn lens_views(&self, frame: &mut Frame<'_>, shot: &Shot<'_>, eyes: Eyes) -> Arc<LensViews> {
        let mut kept = self.lens_views.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(common) = kept.as_ref().filter(|c| c.projection == *shot.projection && c.eyes == eyes) {
            return common.clone();
        }
        let common = Arc::new(self.find_common(frame, shot, eyes));
        *kept = Some(common.clone());
        common
    }

    fn find_common(&self, frame: &mut Frame<'_>, shot: &Shot<'_>, eyes: Eyes) -> LensViews {
        let gpu = frame.gpu();
        let centre = Shot {
            clip_from_view: shot.projection.clip_from_view(&crate::lens::Lens::PINHOLE, glam::DVec2::ZERO),
            ..*shot
        };
        let drawn = self.visible(&centre, LayerKind::Nearest, Some(&eyes));
        let uniform = self.uniform(shot);
        let bytes = bytemuck::bytes_of(&uniform);
        let view = gpu.lasting_buffer("view from a lens point", bytes, wgpu::BufferUsages::UNIFORM);
        let rows: &[u8] = bytemuck::cast_slice(&drawn.rows);
        let instances = gpu.lasting_buffer("instances", rows, wgpu::BufferUsages::VERTEX);
        let whole = Resource::Uniform(Piece { buffer: view.clone(), offset: 0 }, bytes.len() as u32);
        let bind_group = self.bind_frame(frame, whole, None);
        LensViews { projection: *shot.projection, eyes, drawn, bind_group, instances, view }
    }
}
