//! A frame: passes recorded in order, timed, counted, then submitted.

mod passes;
mod targets;
mod timing;

pub use passes::{Draw, Pass};
pub(crate) use targets::attachment;
pub use targets::{Blend, Target};
pub(super) use timing::MAX_TIMESTAMPS;
pub use timing::{PassTime, Timings, WHOLE_FRAME};

use super::arena::{Arena, Piece};
use super::bind_groups::Resource;
use super::kernel::{Build, Kernel};
use super::reads::READS_BINDING;
use super::wgsl::{Precision, Uniform};
use super::{Buffer, Gpu, Texture};
use cpu_time::ProcessTime;
use glam::UVec2;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};
use timing::{HostTimer, Timer, resolve};

/// What a frame did and what it did not need to do.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct FrameStats {
    /// Triangles sent to the rasteriser for scene views.
    pub triangles: u64,
    /// Scene views drawn.
    pub views: u64,
    /// Passes recorded: dispatches, draws and scene views.
    pub passes: u64,
    /// Dispatches among them, indirect ones included.
    pub dispatches: u64,
    /// Dispatches whose grid the GPU decides.
    pub indirect_dispatches: u64,
    /// Work that was not needed, by name, with how often.
    pub skipped: BTreeMap<String, u64>,
    /// Most bytes of pooled textures in use at once.
    pub peak_texture_bytes: u64,
    /// Most bytes of pooled buffers in use at once, uniforms included.
    pub peak_buffer_bytes: u64,
}

impl FrameStats {
    /// Most bytes of pooled textures and buffers in use at once, at most: the two peaks may
    /// lie at different times.
    pub fn peak_bytes(&self) -> u64 {
        self.peak_texture_bytes + self.peak_buffer_bytes
    }
}

/// Where commands go.
enum Encoder<'g> {
    /// The frame submits it.
    Own(wgpu::CommandEncoder),
    /// Of another program, which submits it.
    Host(&'g mut wgpu::CommandEncoder),
    /// It was submitted: the frame ends.
    Gone,
}

impl Encoder<'_> {
    fn get(&mut self) -> &mut wgpu::CommandEncoder {
        match self {
            Self::Own(encoder) => encoder,
            Self::Host(encoder) => encoder,
            Self::Gone => unreachable!("nothing is recorded once a frame has ended"),
        }
    }
}

/// A compute pass that is kept open from one dispatch to the next.
struct OpenPass {
    pass: wgpu::ComputePass<'static>,
    /// The kernel whose pipeline is set.
    kernel: Arc<Kernel>,
}

type PassHook<'g> = Box<dyn FnMut(&str) + 'g>;

/// Commands under construction.
pub struct Frame<'g> {
    /// Ends before anything else is done with the encoder.
    open: Option<OpenPass>,
    encoder: Encoder<'g>,
    gpu: &'g Gpu,
    /// Counts the frames of a [`Gpu`].
    number: u64,
    arena: Arena,
    timer: Timer,
    labels: Vec<String>,
    prefix: String,
    before_pass: Option<PassHook<'g>>,
    /// Counters; methods add what they skipped.
    pub stats: FrameStats,
    /// Format of intermediate colour images.
    pub precision: Precision,
    exposed: Option<Vec<(String, Texture)>>,
    reads: Option<Buffer>,
}

impl<'g> Frame<'g> {
    pub(super) fn new(gpu: &'g Gpu) -> Self {
        let encoder = gpu.device().create_command_encoder(&Default::default());
        Self::recording(gpu, Encoder::Own(encoder))
    }

    fn recording(gpu: &'g Gpu, encoder: Encoder<'g>) -> Self {
        Self {
            open: None,
            encoder,
            gpu,
            number: gpu.start_frame(),
            arena: Arena::new(gpu.device(), gpu.0.uniform_alignment, &gpu.0.chunks),
            timer: Timer::None,
            labels: Vec::new(),
            prefix: String::new(),
            before_pass: None,
            stats: FrameStats::default(),
            precision: Precision::Half,
            exposed: None,
            reads: None,
        }
    }

    /// As [`Gpu::timed_frame`] says.
    pub(super) fn timed_on_host(gpu: &'g Gpu) -> Self {
        let mut frame = Self::new(gpu);
        frame.time_passes();
        if let Timer::None = frame.timer {
            frame.timer = Timer::Host(HostTimer::default());
        }
        frame
    }

    /// The GPU this frame runs on.
    pub fn gpu(&self) -> &'g Gpu {
        self.gpu
    }

    /// From now on takes the GPU's times of each pass, where the adapter has usable
    /// timestamps. The GPU then finishes each pass before it starts the next: ask only where the
    /// times are read.
    pub fn time_passes(&mut self) {
        if let Timer::None = self.timer
            && let Some(queries) = self.gpu.take_queries()
        {
            self.timer = Timer::Stamps(queries);
        }
    }

    /// Whether the frame may submit what it has recorded and wait for it; one that records
    /// into another program's encoder ([`Recorder`]) may not.
    pub fn may_wait(&self) -> bool {
        matches!(self.encoder, Encoder::Own(_))
    }

    /// Has `hook` called with each pass's label before it is recorded.
    pub fn before_each_pass(&mut self, hook: impl FnMut(&str) + 'g) {
        self.before_pass = Some(Box::new(hook));
    }

    /// A pooled texture of this frame; its content is undefined until a pass writes it.
    pub fn texture(&self, label: &str, size: UVec2, format: wgpu::TextureFormat) -> Texture {
        self.gpu.texture(label, size, format)
    }

    /// A pooled texture in the format that shaders call `COLOR_FORMAT`.
    pub fn color_texture(&self, label: &str, size: UVec2) -> Texture {
        self.texture(label, size, self.precision.format())
    }

    fn build(&self) -> Build {
        Build { precision: self.precision, counts_reads: self.reads.is_some() }
    }

    /// From now on counts every texture read of passes and draws (not of scene views) in
    /// the u64 that is returned; a filtered read counts as one. Such passes take longer:
    /// their times mean nothing.
    pub fn count_texture_reads(&mut self) -> Buffer {
        let gpu = self.gpu;
        self.reads.get_or_insert_with(|| gpu.buffer("texture reads", 8)).clone()
    }

    /// What a kernel binds: `bound`, and what counts its texture reads, if that is wanted.
    fn with_reads(&mut self, kernel: &Kernel, mut bound: Vec<passes::Bound>) -> Vec<passes::Bound> {
        if let Some(reads) = self.reads.clone().filter(|_| kernel.counts_reads()) {
            bound.push((READS_BINDING, self.used(&reads)));
        }
        bound
    }

    /// A buffer as a resource, cleared first where that is due.
    pub(crate) fn used(&mut self, buffer: &Buffer) -> Resource {
        self.clear_unclean(buffer);
        Resource::Buffer(buffer.raw().clone())
    }

    pub(super) fn clear_unclean(&mut self, buffer: &Buffer) {
        if buffer.take_unclean() {
            self.encoder().clear_buffer(buffer.raw(), 0, None);
        }
    }

    /// Data for the commands of this frame, to be bound as a uniform or read as vertices.
    pub(crate) fn data(&mut self, bytes: &[u8]) -> Piece {
        self.arena.push(bytes)
    }

    /// A uniform of this frame.
    pub(crate) fn uniform<U: Uniform>(&mut self, value: &U) -> Resource {
        let bytes = bytemuck::bytes_of(value);
        // The uniform address space wants multiples of 16 bytes on some back ends.
        Resource::Uniform(self.data(bytes), bytes.len().next_multiple_of(16) as u32)
    }

    /// The group of `layout` that binds these to 0, 1, 2 ... , kept while frames use it.
    pub(crate) fn bind_group(&self, layout: &wgpu::BindGroupLayout, resources: &[Resource]) -> wgpu::BindGroup {
        self.gpu.0.bind_groups.get(self.gpu.device(), layout, (0..).zip(resources), self.number)
    }

    /// Labels of the passes that follow start with `prefix`.
    pub fn set_prefix(&mut self, prefix: impl Into<String>) {
        self.prefix = prefix.into();
    }

    /// Notes that a piece of work was not needed.
    pub fn skip(&mut self, what: &str) {
        match self.stats.skipped.get_mut(what) {
            Some(count) => *count += 1,
            None => {
                self.stats.skipped.insert(what.to_owned(), 1);
            }
        }
    }

    /// From now on keeps what methods [`Frame::expose`].
    pub fn keep_intermediates(&mut self) {
        self.exposed.get_or_insert_default();
    }

    /// Whether intermediate textures are asked for: then a method may write more than it needs itself.
    pub fn keeps_intermediates(&self) -> bool {
        self.exposed.is_some()
    }

    /// What was exposed since [`Frame::keep_intermediates`]; from now on nothing is kept.
    pub fn take_intermediates(&mut self) -> Vec<(String, Texture)> {
        self.exposed.take().unwrap_or_default()
    }

    /// Offers an intermediate texture for display; costs nothing where none is asked for.
    /// The name is only written out then: `format_args!` costs nothing.
    pub fn expose(&mut self, name: impl Display, texture: &Texture) {
        if let Some(exposed) = &mut self.exposed {
            exposed.push((name.to_string(), texture.clone()));
        }
    }

    /// The raw encoder, with the timestamps for a pass called `label`: for what the
    /// builders do not cover.
    pub(crate) fn raw_pass(&mut self, label: &str) -> (&mut wgpu::CommandEncoder, Option<(wgpu::QuerySet, u32)>) {
        let slot = self.timed(label, true);
        (self.encoder(), slot)
    }

    /// The encoder, for copies.
    pub fn encoder(&mut self) -> &mut wgpu::CommandEncoder {
        self.open = None;
        self.encoder.get()
    }

    /// Whether anyone reads the labels of passes.
    fn wants_labels(&self) -> bool {
        self.before_pass.is_some() || !matches!(self.timer, Timer::None)
    }

    /// Counts a pass that is to be recorded. `label` is without the prefix unless
    /// `is_short` is false.
    fn timed(&mut self, label: &str, is_short: bool) -> Option<(wgpu::QuerySet, u32)> {
        self.stats.passes += 1;
        if !self.wants_labels() {
            return None;
        }
        let label = if is_short { format!("{}{label}", self.prefix) } else { label.to_owned() };
        if let Some(hook) = &mut self.before_pass {
            hook(&label);
        }
        self.close_host_time();
        match &mut self.timer {
            Timer::None => None,
            Timer::Host(host) => {
                host.open = Some(label);
                None
            }
            Timer::Stamps(queries) => {
                let first = 2 * self.labels.len() as u32;
                let queries = queries.clone();
                (first + 1 < MAX_TIMESTAMPS).then(|| {
                    self.labels.push(label);
                    (queries, first)
                })
            }
        }
    }

    /// Where the host times passes: submits the last one and waits for it.
    fn close_host_time(&mut self) {
        let Timer::Host(host) = &mut self.timer else { return };
        let Some(label) = host.open.take() else { return };
        let gpu = self.gpu;
        // A device that is lost answers with an error, and other calls report it.
        let wait = || {
            let _ = gpu.device().poll(wgpu::PollType::wait_indefinitely());
        };
        wait();
        let commands = self.take_commands();
        let (start, processor) = (Instant::now(), ProcessTime::now());
        gpu.queue().submit(commands);
        wait();
        let elapsed = if gpu.is_software() { processor.elapsed() } else { start.elapsed() };
        if let Timer::Host(host) = &mut self.timer {
            host.times.push(PassTime { label, ms: elapsed.as_secs_f64() * 1e3 });
        }
    }

    /// What was recorded so far, ready to be submitted; `None` of another program's encoder.
    fn take_commands(&mut self) -> Option<wgpu::CommandBuffer> {
        self.open = None;
        self.arena.write(self.gpu.queue());
        let Encoder::Own(encoder) = &mut self.encoder else { return None };
        let next = self.gpu.device().create_command_encoder(&Default::default());
        Some(std::mem::replace(encoder, next).finish())
    }

    /// Submits what was recorded so far and goes on with an empty encoder. Does nothing
    /// where another program submits ([`Frame::may_wait`]).
    pub fn flush(&mut self) {
        self.close_host_time();
        let commands = self.take_commands();
        self.gpu.queue().submit(commands);
    }

    /// Submits the frame.
    pub fn finish(mut self) -> Submitted {
        self.close_host_time();
        self.end()
    }

    /// Ends the frame: submits it, unless another program does.
    fn end(&mut self) -> Submitted {
        self.open = None;
        let gpu = self.gpu;
        let labels = std::mem::take(&mut self.labels);
        let (queries, host) = match std::mem::replace(&mut self.timer, Timer::None) {
            Timer::None => (None, None),
            Timer::Stamps(queries) => (Some(queries), None),
            Timer::Host(host) => (None, Some(host.times)),
        };
        let buffer = queries
            .as_ref()
            .filter(|_| !labels.is_empty())
            .map(|queries| resolve(gpu.device(), self.encoder.get(), queries, 2 * labels.len() as u32));
        self.stats.peak_texture_bytes = gpu.0.pool.peak_texture_bytes();
        self.stats.peak_buffer_bytes = gpu.0.pool.peak_buffer_bytes() + self.arena.bytes();
        let ready: Arc<OnceLock<Duration>> = Arc::default();
        self.submit(buffer.as_ref(), &ready);
        Submitted {
            stats: std::mem::take(&mut self.stats),
            exposed: self.exposed.take().unwrap_or_default(),
            timings: Timings { gpu: gpu.clone(), labels, queries, buffer, host, ready },
        }
    }

    /// Submits the commands, or leaves that to the owner of the encoder, and has `ready` set
    /// when they are done and `times` can be read.
    fn submit(&mut self, times: Option<&wgpu::Buffer>, ready: &Arc<OnceLock<Duration>>) {
        self.open = None;
        let gpu = self.gpu;
        self.arena.write(gpu.queue());
        let empty = Arena::new(gpu.device(), gpu.0.uniform_alignment, &gpu.0.chunks);
        let chunks = std::mem::replace(&mut self.arena, empty).into_chunks();
        let (arrived, start) = (ready.clone(), Instant::now());
        let done = move |is_good: bool| {
            // Nothing else sets it.
            let _ = is_good.then(|| arrived.set(start.elapsed()));
        };
        match std::mem::replace(&mut self.encoder, Encoder::Gone) {
            Encoder::Gone => {}
            Encoder::Own(encoder) => {
                gpu.queue().submit([encoder.finish()]);
                match times {
                    Some(buffer) => buffer.map_async(wgpu::MapMode::Read, .., move |result| done(result.is_ok())),
                    None => gpu.queue().on_submitted_work_done(move || done(true)),
                }
                gpu.0.chunks.give_back(chunks);
            }
            Encoder::Host(encoder) => {
                let lent = gpu.0.chunks.lend(chunks);
                match times {
                    Some(buffer) => {
                        encoder.map_buffer_on_submit(buffer, wgpu::MapMode::Read, .., move |result| {
                            done(result.is_ok());
                        });
                        encoder.on_submitted_work_done(move || drop(lent));
                    }
                    None => encoder.on_submitted_work_done(move || {
                        done(true);
                        drop(lent);
                    }),
                }
            }
        }
    }
}

impl Drop for Frame<'_> {
    /// A frame dropped before its end has no effect. Commands in another program's encoder run
    /// when that is submitted, with the data that they were recorded with.
    fn drop(&mut self) {
        match self.encoder {
            Encoder::Gone => {}
            Encoder::Host(_) => self.submit(None, &Arc::default()),
            Encoder::Own(_) => {
                self.open = None;
                let empty = Arena::new(self.gpu.device(), self.gpu.0.uniform_alignment, &self.gpu.0.chunks);
                self.gpu.0.chunks.give_back(std::mem::replace(&mut self.arena, empty).into_chunks());
            }
        }
    }
}

/// A frame in the encoder of another program, such as an engine that draws its own scene into it.
/// Passes are recorded as in any [`Frame`], but nothing is submitted or waited for.
///
/// What methods want to know of the view's depths arrives after the encoder was submitted;
/// until then they assume the worst, unless the caller says how near and far the scene is:
/// [`View::set_depth_range_m`](crate::view::View::set_depth_range_m). Encoders of one thread
/// are to be submitted in the order in which they were recorded.
///
/// Dropped before it is finished, it leaves what was recorded in the encoder.
pub struct Recorder<'g>(Frame<'g>);

impl<'g> Recorder<'g> {
    pub(super) fn new(gpu: &'g Gpu, encoder: &'g mut wgpu::CommandEncoder) -> Self {
        Self(Frame::recording(gpu, Encoder::Host(encoder)))
    }

    /// Ends the recording. The times, if they are wanted, arrive when the encoder was
    /// submitted and the GPU is done.
    pub fn finish(mut self) -> Submitted {
        self.0.end()
    }
}

impl<'g> std::ops::Deref for Recorder<'g> {
    type Target = Frame<'g>;

    fn deref(&self) -> &Frame<'g> {
        &self.0
    }
}

impl std::ops::DerefMut for Recorder<'_> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
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
