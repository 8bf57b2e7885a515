//! The GPU, so that a pass is one readable statement.
//!
//! Resources are bound **by name**, reflected from the shader; transient textures are
//! pooled; every pass is timestamped under its label:
//!
//! ```ignore
//! frame.pass(&SHADER, "downsample")
//!     .texture("finer", &finer).texture("coarser", &coarser).uniform("params", &params)
//!     .dispatch(coarser.size());
//! ```

mod arena;
mod bind_groups;
mod device;
mod frame;
mod kernel;
mod memo;
mod pool;
mod radix_sort;
mod readback;
mod reads;
mod schedule;
mod wgsl;

pub(crate) use arena::Piece;
pub(crate) use bind_groups::Resource;
pub use device::{AdapterSummary, GpuError, best_adapter, wanted_features, wanted_limits};
pub(crate) use frame::attachment;
pub use frame::{Blend, Draw, Frame, FrameStats, Pass, PassTime, Recorder, Submitted, Target, Timings, WHOLE_FRAME};
pub(crate) use kernel::embedded_module;
pub use kernel::{SamplerKind, Switches};
pub use memo::Memo;
pub use pool::{Buffer, Texture, TextureKey};
pub use radix_sort::sort_pairs;
pub use readback::{download, download_depth, download_rgba, download_rgba8, upload, upload_scalar};
pub use schedule::{ParseScheduleError, Schedule};
pub use wgsl::{Binding, Module, Precision, Shader, ShaderError, Uniform, UniformLayout};

use device::SOFTWARE;
use glam::UVec2;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::ThreadId;

/// Usages of storage buffers: passes may also copy and clear them.
const STORAGE: wgpu::BufferUsages =
    wgpu::BufferUsages::STORAGE.union(wgpu::BufferUsages::COPY_SRC).union(wgpu::BufferUsages::COPY_DST);

/// Has an instance made without wgpu's check of indirect dispatches, which puts a dispatch
/// of one invocation and two barriers before each. Shaders of this program cut their grids
/// themselves (`plan_dispatches` in `shaders/methods/tile_lists.wgsl`).
pub fn without_indirect_checks(descriptor: &mut wgpu::InstanceDescriptor) {
    descriptor.flags.remove(wgpu::InstanceFlags::VALIDATION_INDIRECT_CALL);
}

/// An instance as the environment says (`WGPU_BACKEND` and the like).
fn instance() -> wgpu::Instance {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    without_indirect_checks(&mut descriptor);
    wgpu::Instance::new(descriptor)
}

/// A device with its kernels and its texture pool; cheap to clone.
#[derive(Clone)]
pub struct Gpu(Arc<Inner>);

struct Inner {
    device: wgpu::Device,
    queue: wgpu::Queue,
    adapter: AdapterSummary,
    pool: Arc<pool::Pool>,
    kernels: kernel::Kernels,
    bind_groups: bind_groups::BindGroups,
    chunks: arena::Chunks,
    /// Multiple of bytes at which uniforms may begin.
    uniform_alignment: u32,
    /// Bytes of the largest buffer that a shader can read or write as a whole.
    largest_binding_bytes: u64,
    /// Greatest side of a texture, px.
    greatest_side: u32,
    /// First allocation beyond these limits, by the thread that asked for it.
    refused: Mutex<Vec<(ThreadId, Refused)>>,
    memo: Memo,
    /// Whether tiles are dispatched by [`Schedule::Branches`].
    by_branches: AtomicBool,
    /// Whether timestamps are usable: those of software adapters are not.
    has_stamps: bool,
    /// Query sets that no frame in flight uses.
    queries: Mutex<Vec<wgpu::QuerySet>>,
}

/// A texture or buffer that is larger than the device allows.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("'{what}' would take {needed}, and this device allows {allowed}")]
pub struct Refused {
    /// What it is for.
    pub what: String,
    /// Its size, with unit.
    pub needed: String,
    /// The greatest size that is allowed.
    pub allowed: String,
}

/// Frames after which bind groups that were not used are forgotten.
const KEPT_BIND_GROUPS: u64 = 2 * pool::KEPT_FRAMES;

impl std::fmt::Debug for Gpu {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Gpu({})", self.0.adapter.name)
    }
}

impl Gpu {
    /// Opens the best adapter, or the best of those whose name contains `adapter`.
    pub fn open(adapter: Option<&str>) -> Result<Self, GpuError> {
        let instance = instance();
        let adapter = device::choose(&instance, adapter)?;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("defocus"),
            required_features: adapter.features() & wanted_features(),
            required_limits: wanted_limits(&adapter.limits()),
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|e| GpuError::NoDevice { adapter: adapter.get_info().name, cause: e.to_string() })?;
        Ok(Self::from_device(&adapter.get_info(), device, queue))
    }

    /// Uses the device of an application that embeds this library.
    ///
    /// Of the optional features it uses those that the device was opened with
    /// ([`wanted_features`]): without `TIMESTAMP_QUERY` there are no timings.
    pub fn from_device(adapter: &wgpu::AdapterInfo, device: wgpu::Device, queue: wgpu::Queue) -> Self {
        let kernels = kernel::Kernels::new(&device);
        let adapter = AdapterSummary::of(adapter);
        // See `timed_frame` on those of software.
        let has_stamps = device.features().contains(wgpu::Features::TIMESTAMP_QUERY) && adapter.kind != SOFTWARE;
        let schedule = Schedule::of(adapter.kind);
        let limits = device.limits();
        Self(Arc::new(Inner {
            device,
            queue,
            adapter,
            pool: Arc::default(),
            kernels,
            bind_groups: Default::default(),
            chunks: Default::default(),
            uniform_alignment: limits.min_uniform_buffer_offset_alignment,
            largest_binding_bytes: limits.max_storage_buffer_binding_size.min(limits.max_buffer_size),
            greatest_side: limits.max_texture_dimension_2d,
            refused: Mutex::default(),
            memo: Memo::default(),
            by_branches: AtomicBool::new(schedule == Schedule::Branches),
            has_stamps,
            queries: Mutex::default(),
        }))
    }

    /// Counts a frame and frees what was long unused. Returns the frame's number.
    fn start_frame(&self) -> u64 {
        let number = self.0.pool.start_frame();
        if number.is_multiple_of(pool::KEPT_FRAMES) {
            self.0.bind_groups.forget(number.saturating_sub(KEPT_BIND_GROUPS));
        }
        number
    }

    /// A query set of its own for a frame; `None` where timestamps say nothing.
    fn take_queries(&self) -> Option<wgpu::QuerySet> {
        let make = || {
            self.0.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("passes"),
                ty: wgpu::QueryType::Timestamp,
                count: frame::MAX_TIMESTAMPS,
            })
        };
        let free = || self.0.queries.lock().unwrap_or_else(PoisonError::into_inner).pop();
        self.0.has_stamps.then(|| free().unwrap_or_else(make))
    }

    fn give_back_queries(&self, queries: wgpu::QuerySet) {
        self.0.queries.lock().unwrap_or_else(PoisonError::into_inner).push(queries);
    }

    /// All adapters of this machine, the best first.
    pub fn adapters() -> Vec<AdapterSummary> {
        let instance = instance();
        device::adapters(&instance).iter().map(|a| AdapterSummary::of(&a.get_info())).collect()
    }

    /// The wgpu device.
    pub fn device(&self) -> &wgpu::Device {
        &self.0.device
    }

    /// The wgpu queue.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.0.queue
    }

    /// Which adapter this is.
    pub fn adapter(&self) -> &AdapterSummary {
        &self.0.adapter
    }

    /// Whether the adapter is a program on the processor.
    pub fn is_software(&self) -> bool {
        self.0.adapter.kind == SOFTWARE
    }

    /// Whether an optional feature is there.
    pub fn has(&self, feature: wgpu::Features) -> bool {
        self.0.device.features().contains(feature)
    }

    /// A pooled texture with undefined content.
    pub fn texture(&self, label: &str, size: UVec2, format: wgpu::TextureFormat) -> Texture {
        self.texture_of(label, TextureKey { size, levels: 1, layers: 1, format })
    }

    /// A pooled texture with mipmap levels or array layers, content undefined. Beyond the
    /// adapter's greatest side it is cut, and `take_refused` tells.
    pub fn texture_of(&self, label: &str, mut key: TextureKey) -> Texture {
        let limit = self.0.greatest_side;
        if key.size.max_element() > limit {
            self.refuse(label, format!("{}x{} px", key.size.x, key.size.y), format!("{limit} px a side"));
            key.size = key.size.min(UVec2::splat(limit));
        }
        self.0.pool.texture(&self.0.device, label, key)
    }

    /// A pooled storage buffer of `bytes` zeros (at least 4 bytes). The first frame that
    /// uses it clears it: where every byte is written first, [`Gpu::scratch`] costs less.
    ///
    /// One that shaders could not bind is cut, and `take_refused` tells.
    pub fn buffer(&self, label: &str, bytes: u64) -> Buffer {
        let bytes = self.bindable(label, bytes);
        self.0.pool.buffer(&self.0.device, label, bytes, STORAGE, true)
    }

    /// As [`Gpu::buffer`], with undefined content.
    pub fn scratch(&self, label: &str, bytes: u64) -> Buffer {
        let bytes = self.bindable(label, bytes);
        self.0.pool.buffer(&self.0.device, label, bytes, STORAGE, false)
    }

    /// As [`Gpu::buffer`], for grids of [`Pass::dispatch_indirect`].
    pub fn indirect_buffer(&self, label: &str, bytes: u64) -> Buffer {
        self.0.pool.buffer(&self.0.device, label, bytes, STORAGE | wgpu::BufferUsages::INDIRECT, true)
    }

    /// A storage buffer that holds `data`. A new one each time, not a pooled one: it is
    /// written before the commands of frames that are not submitted yet. Tables that stay the
    /// same belong in [`Gpu::memo`].
    pub fn buffer_of<T: bytemuck::NoUninit>(&self, label: &str, data: &[T]) -> Buffer {
        Buffer::external(self.lasting_buffer(label, bytemuck::cast_slice(data), STORAGE))
    }

    /// A buffer of at least 4 bytes that begins with `contents`. On a lost device it is
    /// invalid like all that is made there, where wgpu's `create_buffer_init` panics.
    pub(crate) fn lasting_buffer(&self, label: &str, contents: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
        let size = (contents.len() as u64).max(4).next_multiple_of(4);
        let usage = usage | wgpu::BufferUsages::COPY_DST;
        let descriptor = wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false };
        let buffer = self.0.device.create_buffer(&descriptor);
        if contents.len().is_multiple_of(4) {
            self.0.queue.write_buffer(&buffer, 0, contents);
        } else {
            let mut padded = contents.to_vec();
            padded.resize(size as usize, 0);
            self.0.queue.write_buffer(&buffer, 0, &padded);
        }
        buffer
    }

    /// How work on tiles of several kinds is dispatched.
    pub fn schedule(&self) -> Schedule {
        if self.0.by_branches.load(Ordering::Relaxed) { Schedule::Branches } else { Schedule::TileLists }
    }

    /// From the next frame on dispatches work on tiles like this, whatever the adapter.
    pub fn set_schedule(&self, schedule: Schedule) {
        self.0.by_branches.store(schedule == Schedule::Branches, Ordering::Relaxed);
    }

    /// A cache of what is computed from parameters: tables of apertures, lens points.
    pub fn memo(&self) -> &Memo {
        &self.0.memo
    }

    /// Largest texture side, px.
    pub(crate) fn max_texture_side(&self) -> u32 {
        self.0.greatest_side
    }

    /// Bytes of the largest buffer that a shader can read or write as a whole.
    pub(crate) fn largest_binding_bytes(&self) -> u64 {
        self.0.largest_binding_bytes
    }

    /// `bytes`, or as many as can be bound.
    fn bindable(&self, label: &str, bytes: u64) -> u64 {
        let limit = self.0.largest_binding_bytes;
        if bytes > limit {
            let mb = |bytes: u64| format!("{} MB", bytes / 1_000_000);
            self.refuse(label, mb(bytes), mb(limit));
            // Buffers have whole words.
            return limit / 4 * 4;
        }
        bytes
    }

    fn refuse(&self, label: &str, needed: String, allowed: String) {
        let refused = Refused { what: label.to_owned(), needed, allowed };
        let mut all = self.0.refused.lock().unwrap_or_else(PoisonError::into_inner);
        all.push((std::thread::current().id(), refused));
    }

    /// The first thing that this thread asked for since the last call and that is larger than
    /// the device allows: what was recorded with it is valid, but no picture.
    pub(crate) fn take_refused(&self) -> Option<Refused> {
        let mut all = self.0.refused.lock().unwrap_or_else(PoisonError::into_inner);
        let thread = std::thread::current().id();
        let first = all.iter().position(|(of, _)| *of == thread).map(|first| all[first].1.clone());
        all.retain(|(of, _)| *of != thread);
        first
    }

    /// Bytes of all pooled textures and buffers, in use or free.
    pub fn pooled_bytes(&self) -> u64 {
        self.0.pool.held_bytes()
    }

    /// Starts a frame of work. Its passes are not timed unless [`Frame::time_passes`] asks
    /// for it.
    pub fn frame(&self) -> Frame<'_> {
        Frame::new(self)
    }

    /// Starts to record into the encoder of another program.
    pub fn recorder<'a>(&'a self, encoder: &'a mut wgpu::CommandEncoder) -> Recorder<'a> {
        Recorder::new(self, encoder)
    }

    /// Starts a frame whose passes are timed one by one on every adapter.
    ///
    /// Software adapters have timestamps that say nothing: llvmpipe takes them when its
    /// rasteriser gets to them, not when the compute work between them is done. There each
    /// pass is submitted alone and waited for, and its time is the *processor time* of all
    /// threads of this program meanwhile: what a software adapter costs, and unlike elapsed
    /// time hardly touched by what else the machine does. Other adapters without timestamps
    /// are timed by the clock.
    pub fn timed_frame(&self) -> Frame<'_> {
        Frame::timed_on_host(self)
    }

    /// Replaces the source of the shader called `name` from the next pass on; an invalid
    /// source is refused with the compiler's message and the last good one stays.
    pub fn replace_shader(&self, name: &str, source: &str) -> Result<(), ShaderError> {
        self.0.kernels.replace(name, source)
    }
}
