//! A frame: passes recorded in order, timed, counted, then submitted.

use super::kernel::{Build, Kernel, Pipeline, Resource, SamplerKind};
use super::reads::READS_BINDING;
use super::wgsl::{Precision, Shader, Uniform};
use super::{Gpu, Texture};
use cpu_time::ProcessTime;
use glam::UVec2;
use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};
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
    timer: Timer,
    labels: Vec<String>,
    prefix: String,
    /// Counters; methods add what they skipped.
    pub stats: FrameStats,
    /// Format of intermediate colour images.
    pub precision: Precision,
    exposed: Option<Vec<(String, Texture)>>,
    reads: Option<wgpu::Buffer>,
}

impl<'g> Frame<'g> {
    pub(super) fn new(gpu: &'g Gpu) -> Self {
        gpu.0.pool.start_frame();
        Self {
            gpu,
            encoder: gpu.device().create_command_encoder(&Default::default()),
            timer: gpu.0.queries.clone().map_or(Timer::None, Timer::Stamps),
            labels: Vec::new(),
            prefix: String::new(),
            stats: FrameStats::default(),
            precision: Precision::Half,
            exposed: None,
            reads: None,
        }
    }

    /// As [`Gpu::timed_frame`] says.
    pub(super) fn timed_on_host(gpu: &'g Gpu) -> Self {
        let mut frame = Self::new(gpu);
        if let Timer::None = frame.timer {
            frame.timer = Timer::Host(HostTimer::default());
        }
        frame
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
        let kernel = self.gpu.0.kernels.compute(shader, entry, self.build());
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

    fn build(&self) -> Build {
        Build { precision: self.precision, counts_reads: self.reads.is_some() }
    }

    /// From now on counts every texture read of passes and draws (not of scene views) in
    /// the u32 that is returned; a filtered read counts as one. Such passes take longer:
    /// their times mean nothing.
    pub fn count_texture_reads(&mut self) -> wgpu::Buffer {
        let gpu = self.gpu;
        self.reads.get_or_insert_with(|| gpu.buffer("texture reads", 4)).clone()
    }

    /// `bound` and what counts the kernel's texture reads, if that is wanted.
    fn with_reads(&self, kernel: &Kernel, mut bound: Vec<Bound>) -> Vec<Bound> {
        if let Some(reads) = self.reads.as_ref().filter(|_| kernel.counts_reads()) {
            bound.push((READS_BINDING, Resource::Buffer(reads.clone())));
        }
        bound
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

    fn timed(&mut self, label: &str) -> Option<(wgpu::QuerySet, u32)> {
        self.stats.passes += 1;
        self.close_host_time();
        match &mut self.timer {
            Timer::None => None,
            Timer::Host(host) => {
                host.open = Some(label.to_owned());
                None
            }
            Timer::Stamps(queries) => {
                let first = 2 * self.labels.len() as u32;
                let queries = queries.clone();
                (first + 1 < MAX_TIMESTAMPS).then(|| {
                    self.labels.push(label.to_owned());
                    (queries, first)
                })
            }
        }
    }

    /// Where the host times passes: submits the last one and waits for it.
    fn close_host_time(&mut self) {
        let Timer::Host(host) = &mut self.timer else { return };
        let Some(label) = host.open.take() else { return };
        // A device that is lost answers with an error, and other calls report it.
        let wait = || {
            let _ = self.gpu.device().poll(wgpu::PollType::wait_indefinitely());
        };
        wait();
        let next = self.gpu.device().create_command_encoder(&Default::default());
        let commands = std::mem::replace(&mut self.encoder, next).finish();
        let (start, processor) = (Instant::now(), ProcessTime::now());
        self.gpu.queue().submit([commands]);
        wait();
        let elapsed = if self.gpu.is_software() { processor.elapsed() } else { start.elapsed() };
        host.times.push(PassTime { label, ms: elapsed.as_secs_f64() * 1e3 });
    }

    /// Submits what was recorded so far and goes on with an empty encoder.
    pub fn flush(&mut self) {
        let next = self.gpu.device().create_command_encoder(&Default::default());
        let encoder = std::mem::replace(&mut self.encoder, next);
        self.gpu.queue().submit([encoder.finish()]);
    }

    /// Submits the frame.
    pub fn finish(mut self) -> Submitted {
        self.close_host_time();
        let device = self.gpu.device();
        let count = 2 * self.labels.len() as u32;
        let (queries, host) = match self.timer {
            Timer::None => (None, None),
            Timer::Stamps(queries) => (Some(queries), None),
            Timer::Host(host) => (None, Some(host.times)),
        };
        let buffer = queries.filter(|_| count > 0).map(|queries| {
            use wgpu::BufferUsages as Usage;
            let buffer = |usage| {
                let size = u64::from(count) * 8;
                device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
            };
            let resolved = buffer(Usage::QUERY_RESOLVE | Usage::COPY_SRC);
            let mapped = buffer(Usage::MAP_READ | Usage::COPY_DST);
            self.encoder.resolve_query_set(&queries, 0..count, &resolved, 0);
            self.encoder.copy_buffer_to_buffer(&resolved, 0, &mapped, 0, resolved.size());
            mapped
        });
        self.stats.peak_texture_bytes = self.gpu.0.pool.peak_bytes();
        self.gpu.queue().submit([self.encoder.finish()]);
        let (ready, submitted) = (Arc::new(OnceLock::new()), Instant::now());
        let arrived = ready.clone();
        match &buffer {
            Some(buffer) => buffer.map_async(wgpu::MapMode::Read, .., move |result| {
                // Nothing else sets it.
                let _ = result.is_ok().then(|| arrived.set(submitted.elapsed()));
            }),
            None => self.gpu.queue().on_submitted_work_done(move || {
                let _ = arrived.set(submitted.elapsed());
            }),
        }
        Submitted {
            stats: self.stats,
            exposed: self.exposed.unwrap_or_default(),
            timings: Timings { gpu: self.gpu.clone(), labels: self.labels, buffer, host, ready },
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

/// Label of the one time that is known of a frame without timestamps.
const WHOLE_FRAME: &str = "whole frame";

/// GPU time of a pass.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PassTime {
    /// The pass's label.
    pub label: String,
    /// Duration on the GPU, milliseconds.
    pub ms: f64,
}

/// What times passes.
enum Timer {
    /// Nothing.
    None,
    /// The GPU, by timestamps around each.
    Stamps(wgpu::QuerySet),
    /// The host, by submitting each alone.
    Host(HostTimer),
}

#[derive(Default)]
struct HostTimer {
    /// The pass that is recorded but not submitted.
    open: Option<String>,
    times: Vec<PassTime>,
}

/// Times that arrive when the GPU is done.
pub struct Timings {
    gpu: Gpu,
    labels: Vec<String>,
    buffer: Option<wgpu::Buffer>,
    /// Times of a frame whose passes the host has timed.
    host: Option<Vec<PassTime>>,
    /// How long after its submission the frame was found to be done.
    ready: Arc<OnceLock<Duration>>,
}

impl Timings {
    /// The times if they are there by now; `None` if not yet. Of an adapter without usable
    /// timestamps it is the whole frame's, on the host's clock, unless the frame was one of
    /// [`Gpu::timed_frame`].
    pub fn poll(&self) -> Option<Vec<PassTime>> {
        if let Some(times) = &self.host {
            return Some(times.clone());
        }
        // A lost device answers with an error; then the times simply never arrive.
        let _ = self.gpu.device().poll(wgpu::PollType::Poll);
        let elapsed = self.ready.get()?;
        let Some(buffer) = &self.buffer else {
            return Some(vec![PassTime { label: WHOLE_FRAME.into(), ms: elapsed.as_secs_f64() * 1e3 }]);
        };
        let bytes = buffer.get_mapped_range(..).ok()?;
        let stamps: &[u64] = bytemuck::try_cast_slice(&bytes).ok()?;
        let ns_per_tick = f64::from(self.gpu.queue().get_timestamp_period());
        let ms = |pair: &[u64]| pair[1].saturating_sub(pair[0]) as f64 * ns_per_tick * 1e-6;
        let pass = |(label, pair): (&String, &[u64])| PassTime { label: label.clone(), ms: ms(pair) };
        Some(self.labels.iter().zip(stamps.chunks_exact(2)).map(pass).collect())
    }

    /// Waits for the GPU and returns the times, as [`Timings::poll`]; empty if it is lost.
    pub fn wait(&self) -> Vec<PassTime> {
        // As in `poll`: a lost device leaves the times empty.
        let _ = self.gpu.device().poll(wgpu::PollType::wait_indefinitely());
        self.poll().unwrap_or_default()
    }
}

/// A resource under its name in the shader.
type Bound = (&'static str, Resource);

/// A compute pass being described.
#[must_use = "a pass does nothing until it is dispatched"]
pub struct Pass<'f, 'g> {
    frame: &'f mut Frame<'g>,
    label: String,
    kernel: Arc<Kernel>,
    bound: Vec<Bound>,
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
        let bound = self.frame.with_reads(&self.kernel, self.bound);
        let groups = self.kernel.bind_groups(self.frame.gpu.device(), &bound);
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
    bound: Vec<Bound>,
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
        let kernel = gpu.0.kernels.render(self.shader, self.entries, self.frame.build(), self.topology, &targets);
        for (name, check) in &self.uniform_checks {
            check(&kernel, name).unwrap_or_else(|e| panic!("{e}"));
        }
        let bound = self.frame.with_reads(&kernel, self.bound);
        let groups = kernel.bind_groups(gpu.device(), &bound);
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
