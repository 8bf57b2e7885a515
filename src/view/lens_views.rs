//! Views from many points of a lens at little cost to the CPU: what may be in any of them is
//! found, sorted and uploaded once; a view then draws that with its own eye. It is not a render
//! bundle: finishing one on a lost device panics (wgpu 30).

use super::eyes::Eyes;
use super::layers::Layer;
use super::pipelines::{COLOR, DEPTH_BUFFER, LayerKind, STORED_DEPTH};
use super::raster::{LensViews, SceneSource, Shot, begin_pass};
use crate::gpu::{Frame, Piece, Resource};
use std::sync::{Arc, PoisonError};

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

    /// Those of the last call if eyes and projection are the same.
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
