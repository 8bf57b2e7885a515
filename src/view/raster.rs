//! Drawing layers of a scene.

use super::pipelines::{DEPTH_BUFFER, LayerKind, LightElement, ViewUniform};
use super::upload::{DrawItem, GpuScene};
use super::{Layer, LayerQuery};
use crate::camera::{Camera, Projection};
use crate::gpu::{Frame, Gpu, Texture};
use crate::scene::{Environment, LightKind};
use glam::{DAffine3, DVec2, Mat4, Vec3, Vec4};
use std::sync::Arc;
use wgpu::util::DeviceExt;

/// A scene seen from one camera: what changes only when the camera moves.
pub(super) struct SceneSource {
    pub scene: Arc<GpuScene>,
    pub camera: Camera,
    transforms: wgpu::Buffer,
    lights: wgpu::Buffer,
    /// View-space bounding spheres of the instances: centre and radius.
    spheres: Vec<Vec4>,
    /// Bound where a layer has no per-pixel limit: everything is farther.
    unlimited: Texture,
}

/// From where, and which surfaces.
pub(super) struct Shot<'a> {
    pub projection: &'a Projection,
    pub clip_from_view: Mat4,
    /// Lens position that shading looks from, metres in view space.
    pub shading_eye_m: DVec2,
    pub query: LayerQuery<'a>,
}

impl SceneSource {
    pub(super) fn new(scene: Arc<GpuScene>, camera: Camera) -> Self {
        let gpu = scene.gpu.clone();
        let view_from_world = camera.view_from_world();
        let view_from_object: Vec<DAffine3> =
            scene.instances.iter().map(|i| view_from_world * i.world_from_object).collect();
        let rows: Vec<[[f32; 4]; 3]> = view_from_object.iter().map(rows).collect();
        let spheres = scene.instances.iter().zip(&view_from_object).map(|(instance, m)| {
            let stretch = m.matrix3.x_axis.length().max(m.matrix3.y_axis.length()).max(m.matrix3.z_axis.length());
            m.transform_point3(instance.centre).as_vec3().extend((instance.radius * stretch) as f32)
        });
        let lights: Vec<LightElement> = scene.lights.iter().map(|l| light(l, &view_from_world)).collect();
        Self {
            spheres: spheres.collect(),
            transforms: storage(&gpu, bytemuck::cast_slice(&rows)),
            lights: storage(&gpu, bytemuck::cast_slice(&lights)),
            unlimited: crate::gpu::upload_scalar(
                &gpu,
                "unlimited",
                &crate::image::Image::filled(glam::UVec2::ONE, f32::INFINITY),
            ),
            scene,
            camera,
        }
    }

    /// Draws one layer as seen in `shot`.
    pub(super) fn draw(&self, frame: &mut Frame<'_>, label: &str, shot: &Shot<'_>) -> Layer {
        let gpu = frame.gpu();
        let size = shot.projection.outer_size();
        let layer = Layer {
            color: frame.texture("layer colour", size, super::pipelines::COLOR),
            depth: frame.texture("layer depth", size, super::pipelines::STORED_DEPTH),
        };
        let buffer = frame.texture("depth buffer", size, DEPTH_BUFFER);
        let kind = if shot.query.is_nearest() { LayerKind::Nearest } else { LayerKind::Farther };
        let (visible, ranges, triangles) = self.cull(&shot.clip_from_view, shot.query.z_far);
        frame.stats.triangles += triangles;
        frame.stats.views += 1;

        let bind_group = self.bind(gpu, shot, &visible);
        let (encoder, slot) = frame.raw_pass(label);
        let timestamp_writes = slot.as_ref().map(|(query_set, first)| wgpu::RenderPassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: Some(*first),
            end_of_pass_write_index: Some(first + 1),
        });
        let clear = wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(label),
            color_attachments: &[
                Some(crate::gpu::attachment(layer.color.view(), clear)),
                Some(crate::gpu::attachment(layer.depth.view(), clear)),
            ],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: buffer.view(),
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard }),
                stencil_ops: None,
            }),
            timestamp_writes,
            ..Default::default()
        });
        pass.set_bind_group(0, &bind_group, &[]);
        pass.set_vertex_buffer(0, self.scene.vertices.slice(..));
        pass.set_index_buffer(self.scene.indices.slice(..), wgpu::IndexFormat::Uint32);
        for (item, instances) in self.scene.draws.iter().zip(ranges) {
            if instances.is_empty() {
                continue;
            }
            pass.set_pipeline(&self.scene.pipelines.get(kind, Some(item.variant)));
            pass.set_bind_group(1, &self.scene.materials[item.material], &[]);
            pass.draw_indexed(item.indices.clone(), item.base_vertex, instances);
        }
        // The background lies at z = 0 and belongs to layers that reach infinity.
        if shot.query.z_far <= 0.0 && !self.scene.materials.is_empty() {
            pass.set_pipeline(&self.scene.pipelines.get(kind, None));
            pass.set_bind_group(1, &self.scene.materials[0], &[]);
            pass.draw(0..3, 0..1);
        }
        drop(pass);
        layer
    }

    /// Instances that may touch the frustum, packed, with each draw item's share of them.
    fn cull(&self, clip_from_view: &Mat4, z_far: f32) -> (Vec<u32>, Vec<std::ops::Range<u32>>, u64) {
        let planes = frustum(clip_from_view, z_far);
        let mut visible = Vec::new();
        let mut triangles = 0;
        let mut keep = |item: &DrawItem| {
            let first = visible.len() as u32;
            visible.extend(item.instances.iter().filter(|&&i| inside(&planes, self.spheres[i as usize])));
            let range = first..visible.len() as u32;
            triangles += range.len() as u64 * u64::from(item.indices.end - item.indices.start) / 3;
            range
        };
        let ranges = self.scene.draws.iter().map(&mut keep).collect();
        (visible, ranges, triangles)
    }

    fn bind(&self, gpu: &Gpu, shot: &Shot<'_>, visible: &[u32]) -> wgpu::BindGroup {
        let uniform = self.uniform(shot);
        let view = gpu.device().create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("view"),
            contents: bytemuck::bytes_of(&uniform),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let visible = storage(gpu, bytemuck::cast_slice(visible));
        let below = shot.query.below.unwrap_or(&self.unlimited).view();
        self.scene.pipelines.bind_frame(gpu, &view, &self.transforms, &visible, &self.lights, below)
    }

    fn uniform(&self, shot: &Shot<'_>) -> ViewUniform {
        let axes = self.camera.view_from_world().matrix3;
        let axis = |v: glam::DVec3| v.as_vec3().extend(0.0).to_array();
        let rgb = |v: Vec3| v.extend(0.0).to_array();
        let (zenith, horizon, ground, softbox) = match self.scene.environment {
            Environment::Black => (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO, 0.0),
            Environment::Studio { zenith, horizon, ground, softbox } => (zenith, horizon, ground, softbox),
        };
        ViewUniform {
            clip_from_view: shot.clip_from_view.to_cols_array_2d(),
            view_from_world_x: axis(axes.x_axis),
            view_from_world_y: axis(axes.y_axis),
            view_from_world_z: axis(axes.z_axis),
            zenith: rgb(zenith),
            horizon: rgb(horizon),
            ground: rgb(ground),
            shading_eye: shot.shading_eye_m.as_vec2().extend(0.0).to_array(),
            softbox,
            z_near: shot.query.z_near,
            z_far: shot.query.z_far,
            light_count: self.scene.lights.len() as u32,
            unlit: self.scene.options.unlit.into(),
        }
    }
}

fn storage(gpu: &Gpu, bytes: &[u8]) -> wgpu::Buffer {
    // An empty binding is not allowed; 64 bytes hold one element of any of the arrays.
    let contents = if bytes.is_empty() { &[0; 64] } else { bytes };
    let usage = wgpu::BufferUsages::STORAGE;
    gpu.device().create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some("scene"), contents, usage })
}

fn rows(m: &DAffine3) -> [[f32; 4]; 3] {
    let row = |i: usize| [m.matrix3.x_axis[i], m.matrix3.y_axis[i], m.matrix3.z_axis[i], m.translation[i]];
    [0, 1, 2].map(|i| row(i).map(|v| v as f32))
}

fn light(light: &crate::scene::Light, view_from_world: &DAffine3) -> LightElement {
    let position = |p: glam::DVec3| view_from_world.transform_point3(p).as_vec3().to_array();
    let direction = |d: glam::DVec3| view_from_world.transform_vector3(d).normalize_or_zero().as_vec3().to_array();
    let inverse = |range_m: f64| (1.0 / range_m) as f32;
    let intensity = light.intensity.to_array();
    let base = LightElement { intensity, ..Default::default() };
    match light.kind {
        LightKind::Directional { direction: d } => LightElement { kind: 0, direction: direction(d), ..base },
        LightKind::Point { position: p, range_m } => {
            LightElement { kind: 1, position: position(p), inverse_range: inverse(range_m), ..base }
        }
        LightKind::Spot { position: p, range_m, direction: d, cos_inner, cos_outer } => LightElement {
            kind: 2,
            position: position(p),
            inverse_range: inverse(range_m),
            direction: direction(d),
            cos_inner: cos_inner as f32,
            cos_outer: cos_outer as f32,
            ..base
        },
    }
}

/// Planes (unit normal, offset) with the frustum on the positive side: left, right,
/// bottom, top, near, and far where the layer ends before infinity.
fn frustum(clip_from_view: &Mat4, z_far: f32) -> Vec<Vec4> {
    let row = |i| clip_from_view.row(i);
    let (x, y, z, w) = (row(0), row(1), row(2), row(3));
    let mut planes = vec![w + x, w - x, w + y, w - y, w - z];
    if z_far > 0.0 {
        planes.push(z - w * z_far);
    }
    planes.iter().map(|p| *p / p.truncate().length().max(f32::MIN_POSITIVE)).collect()
}

fn inside(planes: &[Vec4], sphere: Vec4) -> bool {
    planes.iter().all(|plane| plane.truncate().dot(sphere.truncate()) + plane.w >= -sphere.w)
}
