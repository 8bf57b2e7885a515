//! A frame: passes recorded in order, timed, counted, then submitted.

use super::kernel::{Kernel, Pipeline, Resource, SamplerKind};
use super::wgsl::{Precision, Shader, Uniform};
use super::{Gpu, Texture};
use glam::UVec2;
use std::collections::BTreeMap;
use std::sync::Arc;
use wgpu::util::DeviceExt;

/// Timestamps that the query set holds: two a pass. Passes beyond are not timed.
pub(super) const MAX_TIMESTAMPS: u32 = wgpu::QUERY_SET_MAX_QUERIES;

/// What a frame did and what it did not need to do.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct FrameStats {
    /// Triangles sent to the rasteriser for scene views.
    pub triangles: u64,
    /// Scene views drawn.
    pub views: u64,
    /// Passes recorded.
    pub passes: u64,
    /// Work that was not needed, by name, with how often.
    pub skipped: BTreeMap<String, u64>,
    /// Most bytes of pooled textures in use at once.
    pub peak_texture_bytes: u64,
}

/// Commands under construction.
pub struct Frame<'g> {
    gpu: &'g Gpu,
    encoder: wgpu::CommandEncoder,
    queries: Option<wgpu::QuerySet>,
    labels: Vec<String>,
    prefix: String,
    /// Counters; methods add what they skipped.
    pub stats: FrameStats,
    /// Format of intermediate colour images.
    pub precision: Precision,
    exposed: Option<Vec<(String, Texture)>>,
}

impl<'g> Frame<'g> {
    pub(super) fn new(gpu: &'g Gpu) -> Self {
        gpu.0.pool.start_frame();
        Self {
            gpu,
            encoder: gpu.device().create_command_encoder(&Default::default()),
            queries: gpu.0.queries.clone(),
            labels: Vec::new(),
            prefix: String::new(),
            stats: FrameStats::default(),
            precision: Precision::Half,
            exposed: None,
        }
    }

    /// The GPU this frame runs on.
    pub fn gpu(&self) -> &'g Gpu {
        self.gpu
    }

    /// A pooled texture of this frame; its content is undefined until a pass writes it.
    pub fn texture(&self, label: &str, size: UVec2, format: wgpu::TextureFormat) -> Texture {
        self.gpu.texture(label, size, format)
    }

    /// A pooled texture in the format that shaders call `COLOR_FORMAT`.
    pub fn color_texture(&self, label: &str, size: UVec2) -> Texture {
        self.texture(label, size, self.precision.format())
    }

    /// Starts a compute pass with the entry point `entry`, labelled with its name.
    pub fn pass<'f>(&'f mut self, shader: &Shader, entry: &str) -> Pass<'f, 'g> {
        let kernel = self.gpu.0.kernels.compute(shader, entry, self.precision);
        let label = format!("{}{entry}", self.prefix);
        Pass { frame: self, label, kernel, bound: Vec::new() }
    }

    /// Starts a draw with vertex and fragment entry points; vertices come from storage
    /// buffers or from the vertex index. Labelled with the fragment entry's name.
    pub fn draw<'f>(&'f mut self, shader: &'f Shader, vertex: &'f str, fragment: &'f str) -> Draw<'f, 'g> {
        let topology = wgpu::PrimitiveTopology::TriangleList;
        Draw {
            frame: self,
            shader,
            entries: [vertex, fragment],
            topology,
            bound: Vec::new(),
            uniform_checks: Vec::new(),
            targets: Vec::new(),
        }
    }

    /// Labels of the passes that follow start with `prefix`.
    pub fn set_prefix(&mut self, prefix: impl Into<String>) {
        self.prefix = prefix.into();
    }

    /// Notes that a piece of work was not needed.
    pub fn skip(&mut self, what: &str) {
        *self.stats.skipped.entry(what.to_owned()).or_default() += 1;
    }

    /// From now on keeps what methods [`Frame::expose`].
    pub fn keep_intermediates(&mut self) {
        self.exposed.get_or_insert_default();
    }

    /// Whether someone wants to look: then a method may write more than it needs itself.
    pub fn keeps_intermediates(&self) -> bool {
        self.exposed.is_some()
    }

    /// What was exposed since [`Frame::keep_intermediates`]; from now on nothing is kept.
    pub fn take_intermediates(&mut self) -> Vec<(String, Texture)> {
        self.exposed.take().unwrap_or_default()
    }

    /// Offers an intermediate texture to whoever wants to look at it; free if no one does.
    pub fn expose(&mut self, name: impl Into<String>, texture: &Texture) {
        if let Some(exposed) = &mut self.exposed {
            exposed.push((name.into(), texture.clone()));
        }
    }

    /// The raw encoder, with the timestamps for a pass called `label`: for what the
    /// builders do not cover.
    pub(crate) fn raw_pass(&mut self, label: &str) -> (&mut wgpu::CommandEncoder, Option<(wgpu::QuerySet, u32)>) {
        let slot = self.timed(&format!("{}{label}", self.prefix));
        (&mut self.encoder, slot)
    }

    /// The encoder, for copies.
    pub fn encoder(&mut self) -> &mut wgpu::CommandEncoder {
        &mut self.encoder
    }

    /// Copies the part of `from` that starts at `origin` over all of `to`, level 0, same
    /// format.
    pub fn copy_part(&mut self, from: &Texture, origin: UVec2, to: &Texture) {
        let size = wgpu::Extent3d { width: to.size().x, height: to.size().y, depth_or_array_layers: 1 };
        let mut source = from.raw().as_image_copy();
        source.origin = wgpu::Origin3d { x: origin.x, y: origin.y, z: 0 };
        self.encoder.copy_texture_to_texture(source, to.raw().as_image_copy(), size);
    }

    fn timed(&mut self, label: &str) -> Option<(wgpu::QuerySet, u32)> {
        self.stats.passes += 1;
        let first = 2 * self.labels.len() as u32;
        let queries = self.queries.clone().filter(|_| first + 1 < MAX_TIMESTAMPS)?;
        self.labels.push(label.to_owned());
        Some((queries, first))
    }

    /// Submits what was recorded so far and goes on with an empty encoder.
    pub fn flush(&mut self) {
        let next = self.gpu.device().create_command_encoder(&Default::default());
        let encoder = std::mem::replace(&mut self.encoder, next);
        self.gpu.queue().submit([encoder.finish()]);
    }

    /// Submits the frame.
    pub fn finish(mut self) -> Submitted {
        let device = self.gpu.device();
        let count = 2 * self.labels.len() as u32;
        let buffer = self.queries.as_ref().filter(|_| count > 0).map(|queries| {
            use wgpu::BufferUsages as Usage;
            let buffer = |usage| {
                let size = u64::from(count) * 8;
                device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
            };
            let resolved = buffer(Usage::QUERY_RESOLVE | Usage::COPY_SRC);
            let mapped = buffer(Usage::MAP_READ | Usage::COPY_DST);
            self.encoder.resolve_query_set(queries, 0..count, &resolved, 0);
            self.encoder.copy_buffer_to_buffer(&resolved, 0, &mapped, 0, resolved.size());
            mapped
        });
        self.stats.peak_texture_bytes = self.gpu.0.pool.peak_bytes();
        self.gpu.queue().submit([self.encoder.finish()]);
        let ready = Arc::new(std::sync::atomic::AtomicBool::new(false));
        if let Some(buffer) = &buffer {
            let ready = ready.clone();
            buffer.map_async(wgpu::MapMode::Read, .., move |result| {
                ready.store(result.is_ok(), std::sync::atomic::Ordering::Release);
            });
        }
        Submitted {
            stats: self.stats,
            exposed: self.exposed.unwrap_or_default(),
            timings: Timings { gpu: self.gpu.clone(), labels: self.labels, buffer, ready },
        }
    }
}

/// A submitted frame.
pub struct Submitted {
    /// Counters.
    pub stats: FrameStats,
    /// Intermediate textures by name, if they were asked for.
    pub exposed: Vec<(String, Texture)>,
    /// GPU times, once they are there.
    pub timings: Timings,
}

/// GPU time of a pass.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct PassTime {
    /// The pass's label.
    pub label: String,
    /// Duration on the GPU, milliseconds.
    pub ms: f64,
}

/// Times that arrive when the GPU is done.
pub struct Timings {
    gpu: Gpu,
    labels: Vec<String>,
    buffer: Option<wgpu::Buffer>,
    ready: Arc<std::sync::atomic::AtomicBool>,
}

impl Timings {
    /// The times if they are there by now; `None` if not yet, empty if the adapter has no
    /// timestamps.
    pub fn poll(&self) -> Option<Vec<PassTime>> {
        let Some(buffer) = &self.buffer else { return Some(Vec::new()) };
        // A lost device answers with an error; then the times simply never arrive.
        let _ = self.gpu.device().poll(wgpu::PollType::Poll);
        if !self.ready.load(std::sync::atomic::Ordering::Acquire) {
            return None;
        }
        let bytes = buffer.get_mapped_range(..).ok()?;
        let stamps: &[u64] = bytemuck::try_cast_slice(&bytes).ok()?;
        let ns_per_tick = f64::from(self.gpu.queue().get_timestamp_period());
        let ms = |pair: &[u64]| pair[1].saturating_sub(pair[0]) as f64 * ns_per_tick * 1e-6;
        let pass = |(label, pair): (&String, &[u64])| PassTime { label: label.clone(), ms: ms(pair) };
        Some(self.labels.iter().zip(stamps.chunks_exact(2)).map(pass).collect())
    }

    /// Waits for the GPU and returns the times; empty if the adapter has no timestamps.
    pub fn wait(&self) -> Vec<PassTime> {
        // As in `poll`: a lost device leaves the times empty.
        let _ = self.gpu.device().poll(wgpu::PollType::wait_indefinitely());
        self.poll().unwrap_or_default()
    }
}

/// A compute pass being described.
#[must_use = "a pass does nothing until it is dispatched"]
pub struct Pass<'f, 'g> {
    frame: &'f mut Frame<'g>,
    label: String,
    kernel: Arc<Kernel>,
    bound: Vec<(&'static str, Resource)>,
}

macro_rules! binders {
    () => {
        /// Binds all levels and layers of a texture, to be read or (storage) written.
        pub fn texture(mut self, name: &'static str, texture: &Texture) -> Self {
            self.bound.push((name, Resource::View(texture.view().clone())));
            self
        }

        /// Binds one mipmap level of a texture, to be read or (storage) written.
        pub fn level(mut self, name: &'static str, texture: &Texture, level: u32) -> Self {
            self.bound.push((name, Resource::View(texture.level_view(level).clone())));
            self
        }

        /// Binds one mipmap level of one array layer as a plain texture, to be read or
        /// (storage) written.
        pub fn slice(mut self, name: &'static str, texture: &Texture, level: u32, layer: u32) -> Self {
            self.bound.push((name, Resource::View(texture.slice_view(level, layer))));
            self
        }

        /// Binds a storage buffer.
        pub fn buffer(mut self, name: &'static str, buffer: &wgpu::Buffer) -> Self {
            self.bound.push((name, Resource::Buffer(buffer.clone())));
            self
        }

        /// Binds a sampler.
        pub fn sampler(mut self, name: &'static str, kind: SamplerKind) -> Self {
            self.bound.push((name, Resource::Sampler(self.frame.gpu.0.kernels.sampler(kind))));
            self
        }
    };
}

fn uniform_buffer<U: Uniform>(gpu: &Gpu, name: &str, value: &U) -> Resource {
    // The uniform address space wants multiples of 16 bytes on some back ends.
    let mut bytes = bytemuck::bytes_of(value).to_vec();
    bytes.resize(bytes.len().next_multiple_of(16), 0);
    let usage = wgpu::BufferUsages::UNIFORM;
    let descriptor = wgpu::util::BufferInitDescriptor { label: Some(name), contents: &bytes, usage };
    Resource::Buffer(gpu.device().create_buffer_init(&descriptor))
}

impl Pass<'_, '_> {
    binders!();

    /// Replaces the pass's label.
    pub fn label(mut self, label: impl Into<String>) -> Self {
        self.label = format!("{}{}", self.frame.prefix, label.into());
        self
    }

    /// Uploads and binds a uniform. Panics if its layout differs from the shader's.
    pub fn uniform<U: Uniform>(mut self, name: &'static str, value: &U) -> Self {
        self.kernel.check_uniform::<U>(name).unwrap_or_else(|e| panic!("{e}"));
        self.bound.push((name, uniform_buffer(self.frame.gpu, name, value)));
        self
    }

    /// Runs one invocation for each element of `size` (and a few beyond: shaders check).
    pub fn dispatch(self, size: UVec2) {
        let [x, y, _] = self.kernel.workgroup_size;
        self.dispatch_groups(size.x.div_ceil(x), size.y.div_ceil(y), 1);
    }

    /// As [`Pass::dispatch`], once for each of `layers`: z of the grid is the layer.
    pub fn dispatch_layers(self, size: UVec2, layers: u32) {
        let [x, y, _] = self.kernel.workgroup_size;
        self.dispatch_groups(size.x.div_ceil(x), size.y.div_ceil(y), layers);
    }

    /// Runs a grid of workgroups.
    pub fn dispatch_groups(self, x: u32, y: u32, z: u32) {
        self.run(|pass| pass.dispatch_workgroups(x, y, z));
    }

    /// Runs the grid of workgroups whose three u32 lie at byte `offset` of `counts`.
    pub fn dispatch_indirect(self, counts: &wgpu::Buffer, offset: u64) {
        self.run(|pass| pass.dispatch_workgroups_indirect(counts, offset));
    }

    fn run(self, dispatch: impl FnOnce(&mut wgpu::ComputePass<'_>)) {
        let groups = self.kernel.bind_groups(self.frame.gpu.device(), &self.bound);
        let slot = self.frame.timed(&self.label);
        let timestamp_writes = slot.as_ref().map(|(query_set, first)| wgpu::ComputePassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: Some(*first),
            end_of_pass_write_index: Some(first + 1),
        });
        let descriptor = wgpu::ComputePassDescriptor { label: Some(&self.label), timestamp_writes };
        let mut pass = self.frame.encoder.begin_compute_pass(&descriptor);
        if let Pipeline::Compute(pipeline) = &self.kernel.pipeline {
            pass.set_pipeline(pipeline);
        }
        for (index, group) in &groups {
            pass.set_bind_group(*index, group, &[]);
        }
        dispatch(&mut pass);
    }
}

/// How fragments meet what is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Blend {
    /// They replace it.
    Replace,
    /// They are added to it.
    Add,
    /// Premultiplied "over": `source + (1 - source alpha) * target`.
    Over,
}

/// Format and blending of a render target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Target {
    /// Texel format.
    pub format: wgpu::TextureFormat,
    /// How fragments meet what is there.
    pub blend: Blend,
}

impl Target {
    pub(super) fn state(self) -> wgpu::ColorTargetState {
        let blend = match self.blend {
            Blend::Replace => None,
            Blend::Add => {
                let one = wgpu::BlendFactor::One;
                let operation = wgpu::BlendOperation::Add;
                let add = wgpu::BlendComponent { src_factor: one, dst_factor: one, operation };
                Some(wgpu::BlendState { color: add, alpha: add })
            }
            Blend::Over => Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
        };
        wgpu::ColorTargetState { format: self.format, blend, write_mask: wgpu::ColorWrites::ALL }
    }
}

pub(crate) fn attachment(
    view: &wgpu::TextureView,
    load: wgpu::LoadOp<wgpu::Color>,
) -> wgpu::RenderPassColorAttachment<'_> {
    let ops = wgpu::Operations { load, store: wgpu::StoreOp::Store };
    wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops }
}

type UniformCheck = fn(&Kernel, &str) -> Result<(), String>;

/// A draw being described.
#[must_use = "a draw does nothing until its vertices are named"]
pub struct Draw<'f, 'g> {
    frame: &'f mut Frame<'g>,
    shader: &'f Shader,
    entries: [&'f str; 2],
    topology: wgpu::PrimitiveTopology,
    bound: Vec<(&'static str, Resource)>,
    uniform_checks: Vec<(&'static str, UniformCheck)>,
    targets: Vec<(Target, wgpu::TextureView, wgpu::LoadOp<wgpu::Color>)>,
}

impl Draw<'_, '_> {
    binders!();

    /// Uploads and binds a uniform; its layout is checked when the draw runs.
    pub fn uniform<U: Uniform>(mut self, name: &'static str, value: &U) -> Self {
        self.uniform_checks.push((name, Kernel::check_uniform::<U>));
        self.bound.push((name, uniform_buffer(self.frame.gpu, name, value)));
        self
    }

    /// Draws triangle strips (quads of four vertices) instead of triangle lists.
    pub fn strips(mut self) -> Self {
        self.topology = wgpu::PrimitiveTopology::TriangleStrip;
        self
    }

    /// Adds a target; `clear` sets it before the draw, `None` keeps what is there.
    pub fn target(mut self, texture: &Texture, blend: Blend, clear: Option<[f64; 4]>) -> Self {
        let load = match clear {
            Some([r, g, b, a]) => wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a }),
            None => wgpu::LoadOp::Load,
        };
        let target = Target { format: texture.format(), blend };
        self.targets.push((target, texture.level_view(0).clone(), load));
        self
    }

    /// Draws `instances` copies of `vertices` vertices.
    pub fn vertices(self, vertices: u32, instances: u32) {
        let gpu = self.frame.gpu;
        let targets: Vec<_> = self.targets.iter().map(|t| t.0).collect();
        let kernel = gpu.0.kernels.render(self.shader, self.entries, self.frame.precision, self.topology, &targets);
        for (name, check) in &self.uniform_checks {
            check(&kernel, name).unwrap_or_else(|e| panic!("{e}"));
        }
        let groups = kernel.bind_groups(gpu.device(), &self.bound);
        let label = format!("{}{}", self.frame.prefix, self.entries[1]);
        let slot = self.frame.timed(&label);
        let timestamp_writes = slot.as_ref().map(|(query_set, first)| wgpu::RenderPassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: Some(*first),
            end_of_pass_write_index: Some(first + 1),
        });
        let attachments: Vec<_> = self.targets.iter().map(|(_, view, load)| Some(attachment(view, *load))).collect();
        let mut pass = self.frame.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(&label),
            color_attachments: &attachments,
            timestamp_writes,
            ..Default::default()
        });
        if let Pipeline::Render(pipeline) = &kernel.pipeline {
            pass.set_pipeline(pipeline);
        }
        for (index, group) in &groups {
            pass.set_bind_group(*index, group, &[]);
        }
        pass.draw(0..vertices, 0..instances);
    }
}
