//! Drawing layers of a scene.

use super::eyes::Eyes;
use super::layers::{Layer, LayerQuery, Shading, SurfaceLayer};
use super::pipelines::{
    COLOR, DEPTH_BUFFER, Drawn, EnvironmentUniform, LayerKind, LightElement, STORED_DEPTH, Variant, ViewUniform,
};
use super::tone::Tone;
use super::upload::{DrawItem, GpuScene};
use crate::camera::{Camera, Projection};
use crate::gpu::{Buffer, Frame, Resource, Texture};
use crate::scene::{Environment, LightKind};
use glam::{DAffine3, DVec2, Mat4, UVec2, Vec3, Vec4};
use std::sync::{Arc, Mutex};
use wgpu::util::RenderEncoder;

/// A scene seen from one camera: what changes only when the camera moves.
pub(super) struct SceneSource {
    pub scene: Arc<GpuScene>,
    pub camera: Camera,
    /// What becomes of colours as they are drawn.
    pub(super) tone: Tone,
    /// Rows that take object space to view space, by instance.
    rows: Vec<Rows>,
    lights: Buffer,
    /// View-space bounding spheres of the instances: centre and radius.
    spheres: Vec<Vec4>,
    /// What the last views from a lens have in common.
    pub(super) lens_views: Mutex<Option<Arc<LensViews>>>,
}

/// What the views from a lens have in common.
pub(super) struct LensViews {
    pub(super) projection: Projection,
    pub(super) eyes: Eyes,
    pub(super) drawn: Visible,
    pub(super) bind_group: wgpu::BindGroup,
    pub(super) instances: wgpu::Buffer,
    /// A [`ViewUniform`]: that of the view which is drawn next.
    pub(super) view: wgpu::Buffer,
}

/// From where, and which surfaces.
pub(super) struct Shot<'a> {
    pub projection: &'a Projection,
    pub clip_from_view: Mat4,
    /// Lens position that shading looks from, metres in view space.
    pub shading_eye_m: DVec2,
    pub query: LayerQuery<'a>,
    /// Texels of the targets a pixel on each side; textures are read over a pixel's footprint.
    pub texels_a_side: u32,
    /// Texels of `query.below` a texel of the targets on each side, and which of them limits this
    /// shot.
    pub below_texels: u32,
    pub below_part: UVec2,
    /// Whether and which sheets are drawn with the solid surfaces, as far as they cover.
    pub sheets: Option<LensPoint>,
}

/// The number of a lens point, which decides what parts of sheets are seen from it.
#[derive(Clone, Copy)]
pub(super) struct LensPoint(pub u32);

impl<'a> Shot<'a> {
    /// A shot with a texel a pixel.
    pub(super) fn new(
        projection: &'a Projection,
        clip_from_view: Mat4,
        shading_eye_m: DVec2,
        query: LayerQuery<'a>,
    ) -> Self {
        Self {
            projection,
            clip_from_view,
            shading_eye_m,
            query,
            texels_a_side: 1,
            below_texels: 1,
            below_part: UVec2::ZERO,
            sheets: None,
        }
    }
}

impl SceneSource {
    /// The same, with another tone.
    pub(super) fn toned(self, tone: Tone) -> Self {
        Self { tone, ..self }
    }

    pub(super) fn new(scene: Arc<GpuScene>, camera: Camera) -> Self {
        let gpu = scene.gpu.clone();
        let view_from_world = camera.view_from_world();
        let view_from_object: Vec<DAffine3> =
            scene.instances.iter().map(|i| view_from_world * i.world_from_object).collect();
        let spheres = scene.instances.iter().zip(&view_from_object).map(|(instance, m)| {
            let stretch = m.matrix3.x_axis.length().max(m.matrix3.y_axis.length()).max(m.matrix3.z_axis.length());
            m.transform_point3(instance.centre).as_vec3().extend((instance.radius * stretch) as f32)
        });
        let lights: Vec<LightElement> = scene.lights.iter().map(|l| light(l, &view_from_world)).collect();
        Self {
            spheres: spheres.collect(),
            rows: view_from_object.iter().map(rows).collect(),
            lights: gpu.buffer_of("lights", if lights.is_empty() { &NO_LIGHT } else { &lights }),
            lens_views: Mutex::default(),
            tone: Tone::Linear,
            scene,
            camera,
        }
    }

    /// Draws one layer as seen in `shot`.
    pub(super) fn draw(&self, frame: &mut Frame<'_>, label: &str, shot: &Shot<'_>) -> Layer {
        let size = shot.projection.outer_size() * shot.texels_a_side;
        let layer = Layer {
            color: frame.texture("layer colour", size, COLOR),
            depth: frame.texture("layer depth", size, STORED_DEPTH),
        };
        let kind = if shot.query.is_nearest() { LayerKind::Nearest } else { LayerKind::Farther };
        self.draw_into(frame, label, shot, kind, &[&layer.color, &layer.depth], None);
        layer
    }

    /// Draws the nearest sheets below the query's bound; alpha is their coverage.
    pub(super) fn draw_sheets(&self, frame: &mut Frame<'_>, label: &str, shot: &Shot<'_>) -> Layer {
        let size = shot.projection.outer_size() * shot.texels_a_side;
        let layer = Layer {
            color: frame.texture("sheet colour", size, COLOR),
            depth: frame.texture("sheet depth", size, STORED_DEPTH),
        };
        self.draw_into(frame, label, shot, LayerKind::Sheets, &[&layer.color, &layer.depth], None);
        layer
    }

    /// How many sheets can lie behind one another in a shot, at most; 0 where there is none.
    pub(super) fn most_sheets(&self, shot: &Shot<'_>) -> u64 {
        if !self.scene.has_sheets() {
            return 0;
        }
        let drawn = self.visible(shot, LayerKind::Sheets, None);
        drawn.items.iter().map(|v| v.instances.len() as u64 * self.scene.draws[v.index].most_layers).sum()
    }

    /// Draws what the surfaces of one layer are made of.
    pub(super) fn draw_surfaces(&self, frame: &mut Frame<'_>, label: &str, shot: &Shot<'_>) -> SurfaceLayer {
        let size = shot.projection.outer_size() * shot.texels_a_side;
        let layer = SurfaceLayer {
            color: frame.texture("layer colour", size, COLOR),
            depth: frame.texture("layer depth", size, STORED_DEPTH),
            base_roughness: frame.texture("layer base colour", size, COLOR),
            normal_metallic: frame.texture("layer normal", size, COLOR),
        };
        let targets = [&layer.color, &layer.depth, &layer.base_roughness, &layer.normal_metallic];
        self.draw_into(frame, label, shot, LayerKind::Attributes, &targets, None);
        layer
    }

    /// Draws all slabs at once into what `bound` holds, in the order of `kind`: a uniform
    /// with an offset, then the rest.
    pub(super) fn draw_slabs(
        &self,
        frame: &mut Frame<'_>,
        label: &str,
        shot: &Shot<'_>,
        kind: LayerKind,
        bound: &[Resource],
    ) {
        let group = self.scene.pipelines.bind_slabs(frame, kind, bound);
        self.draw_into(frame, label, shot, kind, &[], Some((&group, bound[0].offset())));
    }

    /// Draws a layer into targets, or slabs into a bind group with its offset.
    fn draw_into(
        &self,
        frame: &mut Frame<'_>,
        label: &str,
        shot: &Shot<'_>,
        kind: LayerKind,
        targets: &[&Texture],
        slabs: Option<(&wgpu::BindGroup, u32)>,
    ) {
        let depth_buffer =
            frame.texture("depth buffer", shot.projection.outer_size() * shot.texels_a_side, DEPTH_BUFFER);
        let drawn = self.visible(shot, kind, None);
        frame.stats.triangles += drawn.triangles(&self.scene);
        frame.stats.views += 1;
        let instances = frame.data(bytemuck::cast_slice(&drawn.rows));
        let view = frame.uniform(&self.uniform(shot));
        let offset = view.offset();
        let bind_group = self.bind_frame(frame, view, shot.query.below);
        let mut pass = begin_pass(frame, label, targets, &depth_buffer);
        pass.set_bind_group(0, &bind_group, &[offset]);
        if let Some((group, offset)) = slabs {
            pass.set_bind_group(2, group, &[offset]);
        }
        if let (Some(_), Some(any)) = (shot.query.below, self.scene.materials.first()) {
            pass.set_pipeline(&self.scene.pipelines.get(kind, Drawn::Closed));
            pass.set_bind_group(1, any, &[]);
            pass.draw(0..3, 0..1);
        }
        drawn.encode(&mut pass, &self.scene, instances.buffer.slice(u64::from(instances.offset)..));
    }

    /// Binds a view, with an offset, and what it has to lie below.
    pub(super) fn bind_frame(&self, frame: &Frame<'_>, view: Resource, below: Option<&Texture>) -> wgpu::BindGroup {
        let below = below.unwrap_or(&self.scene.unlimited).view().clone();
        let bound = [view, Resource::Buffer(self.lights.raw().clone()), Resource::View(below)];
        self.scene.pipelines.bind_frame(frame, &bound)
    }

    /// What is drawn in `shot`, or from all `eyes` on a lens whose centre sees it.
    pub(super) fn visible(&self, shot: &Shot<'_>, kind: LayerKind, eyes: Option<&Eyes>) -> Visible {
        let is_wanted = |sheet: bool| if kind == LayerKind::Sheets { sheet } else { !sheet || shot.sheets.is_some() };
        let mut items = self.cull(&shot.clip_from_view, &shot.query, eyes);
        items.retain(|v| is_wanted(self.scene.draws[v.index].variant.sheet));
        let rows = items.iter().flat_map(|v| &v.instances).map(|&(_, i)| self.rows[i as usize]).collect();
        let pipelines = &self.scene.pipelines;
        let of_item = |v: &VisibleItem| {
            let variant = Variant { fine: shot.texels_a_side > 1, ..self.scene.draws[v.index].variant };
            pipelines.get(kind, Drawn::Surfaces(variant))
        };
        // The background lies at z = 0 and belongs to layers that reach infinity.
        let has_sky = kind != LayerKind::Sheets && shot.query.z_far <= 0.0 && !self.scene.materials.is_empty();
        Visible {
            pipelines: items.iter().map(of_item).collect(),
            sky: has_sky.then(|| pipelines.get(kind, Drawn::Sky)),
            items,
            rows,
        }
    }

    /// What shades a point as the rasteriser does.
    pub(super) fn shading(&self) -> Shading {
        Shading { environment: self.environment(), lights: self.lights.clone() }
    }

    /// Whether a layer may hold anything: `false` only where it certainly is empty.
    pub(super) fn may_hold(&self, shot: &Shot<'_>) -> bool {
        let is_solid = |v: &VisibleItem| !self.scene.draws[v.index].variant.sheet;
        shot.query.z_far <= 0.0 || self.cull(&shot.clip_from_view, &shot.query, None).iter().any(is_solid)
    }

    /// What may touch the layer's part of the frustum, or of those of all `eyes` around its
    /// own, opaque before masked before sheets, nearest first: hidden fragments then fail the depth test
    /// before they are shaded.
    fn cull(&self, clip_from_view: &Mat4, query: &LayerQuery<'_>, eyes: Option<&Eyes>) -> Vec<VisibleItem> {
        let planes = frustum(clip_from_view, query);
        let nearest_first = |a: &(f32, u32), b: &(f32, u32)| a.0.total_cmp(&b.0);
        let shift_m = |sphere: Vec4| eyes.map_or(0.0, |eyes| eyes.shift_m(sphere));
        let visible = |(index, item): (usize, &DrawItem)| {
            let spheres = item.instances.iter().map(|&i| (self.spheres[i as usize], i));
            let spheres = spheres.filter(|s| inside(&planes, s.0, shift_m(s.0)));
            let mut instances: Vec<_> = spheres.map(|(s, i)| (s.truncate().length() - s.w, i)).collect();
            instances.sort_by(nearest_first);
            VisibleItem { index, instances }
        };
        let mut items: Vec<_> =
            self.scene.draws.iter().enumerate().map(visible).filter(|v| !v.instances.is_empty()).collect();
        items.sort_by(|a, b| {
            let rank = |v: &VisibleItem| {
                let variant = self.scene.draws[v.index].variant;
                (variant.sheet, variant.masked)
            };
            rank(a).cmp(&rank(b)).then(nearest_first(&a.instances[0], &b.instances[0]))
        });
        items
    }

    pub(super) fn uniform(&self, shot: &Shot<'_>) -> ViewUniform {
        let (tone, tone_scale) = self.tone.uniform();
        ViewUniform {
            tone,
            tone_scale,
            clip_from_view: shot.clip_from_view.to_cols_array_2d(),
            environment: self.environment(),
            shading_eye: shot.shading_eye_m.as_vec2().extend(0.0).to_array(),
            z_near: shot.query.z_near,
            z_far: shot.query.z_far,
            texels_a_side: shot.texels_a_side as f32,
            below_part: shot.below_part.to_array(),
            below_texels: shot.below_texels,
            lens_point: shot.sheets.map_or(0, |LensPoint(number)| number),
        }
    }

    fn environment(&self) -> EnvironmentUniform {
        let axes = self.camera.view_from_world().matrix3;
        let axis = |v: glam::DVec3| v.as_vec3().extend(0.0).to_array();
        let rgb = |v: Vec3| v.extend(0.0).to_array();
        let (zenith, horizon, ground, softbox) = match self.scene.environment {
            Environment::Black => (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO, 0.0),
            Environment::Studio { zenith, horizon, ground, softbox } => (zenith, horizon, ground, softbox),
        };
        EnvironmentUniform {
            view_from_world_x: axis(axes.x_axis),
            view_from_world_y: axis(axes.y_axis),
            view_from_world_z: axis(axes.z_axis),
            zenith: rgb(zenith),
            horizon: rgb(horizon),
            ground: rgb(ground),
            softbox,
            light_count: self.scene.lights.len() as u32,
            ..Default::default()
        }
    }
}

/// Begins a pass that draws over cleared targets.
pub(super) fn begin_pass<'f>(
    frame: &'f mut Frame<'_>,
    label: &str,
    targets: &[&Texture],
    depth_buffer: &Texture,
) -> wgpu::RenderPass<'f> {
    let (encoder, slot) = frame.raw_pass(label);
    let timestamp_writes = slot.as_ref().map(|(query_set, first)| wgpu::RenderPassTimestampWrites {
        query_set,
        beginning_of_pass_write_index: Some(*first),
        end_of_pass_write_index: Some(first + 1),
    });
    let clear = wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT);
    let attachments: Vec<_> = targets.iter().map(|t| Some(crate::gpu::attachment(t.view(), clear))).collect();
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments: &attachments,
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: depth_buffer.view(),
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard }),
            stencil_ops: None,
        }),
        timestamp_writes,
        ..Default::default()
    })
}

type Rows = [[f32; 4]; 3];

/// What a layer is drawn from, in order.
pub(super) struct Visible {
    items: Vec<VisibleItem>,
    /// Of each item.
    pipelines: Vec<wgpu::RenderPipeline>,
    sky: Option<wgpu::RenderPipeline>,
    /// Of all instances.
    pub rows: Vec<Rows>,
}

impl Visible {
    pub(super) fn triangles(&self, scene: &GpuScene) -> u64 {
        let of_item = |v: &VisibleItem| v.instances.len() as u64 * scene.draws[v.index].triangles();
        self.items.iter().map(of_item).sum()
    }

    /// Draws it, where group 0 is bound already; `instances` hold the rows.
    pub(super) fn encode<'p>(
        &'p self,
        pass: &mut impl RenderEncoder<'p>,
        scene: &'p GpuScene,
        instances: wgpu::BufferSlice<'p>,
    ) {
        pass.set_vertex_buffer(0, Some(scene.vertices.slice(..)));
        pass.set_vertex_buffer(1, Some(instances));
        pass.set_index_buffer(scene.indices.slice(..), wgpu::IndexFormat::Uint32);
        let mut first = 0;
        for (VisibleItem { index, instances }, pipeline) in self.items.iter().zip(&self.pipelines) {
            let item = &scene.draws[*index];
            let end = first + instances.len() as u32;
            pass.set_pipeline(pipeline);
            pass.set_bind_group(1, Some(&scene.materials[item.material]), &[]);
            pass.draw_indexed(item.indices.clone(), item.base_vertex, first..end);
            first = end;
        }
        if let Some(sky) = &self.sky {
            pass.set_pipeline(sky);
            pass.set_bind_group(1, Some(&scene.materials[0]), &[]);
            pass.draw(0..3, 0..1);
        }
    }
}

/// The instances of one draw item that are in view, with their distances.
struct VisibleItem {
    /// Of the scene's draws.
    index: usize,
    instances: Vec<(f32, u32)>,
}

/// Bound where there are no lights: an empty binding is not allowed.
const NO_LIGHT: [LightElement; 1] = [LightElement::NONE];

fn rows(m: &DAffine3) -> Rows {
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

/// Planes (unit normal, offset) with the layer on the positive side: left, right, bottom,
/// top, its near bound, and its far bound where it ends before infinity.
fn frustum(clip_from_view: &Mat4, query: &LayerQuery<'_>) -> Vec<Vec4> {
    let z_far = query.z_far;
    let row = |i| clip_from_view.row(i);
    let (x, y, z, w) = (row(0), row(1), row(2), row(3));
    let mut planes = vec![w + x, w - x, w + y, w - y, w * query.z_near - z];
    if z_far > 0.0 {
        planes.push(z - w * z_far);
    }
    planes.iter().map(|p| *p / p.truncate().length().max(f32::MIN_POSITIVE)).collect()
}

/// Whether a sphere touches what lies within `margin` of the planes' positive side.
fn inside(planes: &[Vec4], sphere: Vec4, margin: f32) -> bool {
    planes.iter().all(|plane| plane.truncate().dot(sphere.truncate()) + plane.w >= -(sphere.w + margin))
}
