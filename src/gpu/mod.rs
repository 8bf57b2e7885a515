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

mod device;
mod frame;
mod kernel;
mod pool;
mod radix_sort;
mod readback;
mod reads;
mod wgsl;

pub use device::{AdapterSummary, GpuError, best_adapter, wanted_features, wanted_limits};
pub(crate) use frame::attachment;
pub use frame::{Blend, Draw, Frame, FrameStats, Pass, PassTime, Submitted, Target, Timings};
pub use kernel::SamplerKind;
pub use pool::{Texture, TextureKey};
pub use radix_sort::sort_pairs;
pub use readback::{download, download_depth, download_rgba8, upload, upload_scalar};
pub use wgsl::{Binding, Module, Precision, Shader, ShaderError, Uniform, UniformLayout};

use device::SOFTWARE;
use glam::UVec2;
use std::sync::Arc;

/// A device with its kernels and its texture pool; cheap to clone.
#[derive(Clone)]
pub struct Gpu(Arc<Inner>);

struct Inner {
    device: wgpu::Device,
    queue: wgpu::Queue,
    adapter: AdapterSummary,
    pool: Arc<pool::Pool>,
    kernels: kernel::Kernels,
    /// One for all frames: they are submitted in order, each resolves before the next writes.
    queries: Option<wgpu::QuerySet>,
}

impl std::fmt::Debug for Gpu {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Gpu({})", self.0.adapter.name)
    }
}

impl Gpu {
    /// Opens the best adapter, or the best of those whose name contains `adapter`.
    pub fn open(adapter: Option<&str>) -> Result<Self, GpuError> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
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

    /// Uses a device that belongs to someone else: an application's own.
    ///
    /// Of the optional features it uses those that the device was opened with
    /// ([`wanted_features`]): without `TIMESTAMP_QUERY` there are no timings.
    pub fn from_device(adapter: &wgpu::AdapterInfo, device: wgpu::Device, queue: wgpu::Queue) -> Self {
        let kernels = kernel::Kernels::new(&device);
        let adapter = AdapterSummary::of(adapter);
        // See `timed_frame` on those of software.
        let has_stamps = device.features().contains(wgpu::Features::TIMESTAMP_QUERY) && adapter.kind != SOFTWARE;
        let queries = has_stamps.then(|| {
            let ty = wgpu::QueryType::Timestamp;
            device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("passes"),
                ty,
                count: frame::MAX_TIMESTAMPS,
            })
        });
        Self(Arc::new(Inner { device, queue, adapter, pool: Arc::default(), kernels, queries }))
    }

    /// All adapters of this machine, the best first.
    pub fn adapters() -> Vec<AdapterSummary> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
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

    /// A pooled texture with mipmap levels or array layers, content undefined.
    pub fn texture_of(&self, label: &str, key: TextureKey) -> Texture {
        self.0.pool.take(&self.0.device, label, key)
    }

    /// A storage buffer of `bytes` zeroed bytes (at least 4) that can also be copied,
    /// filled and used for indirect dispatch.
    pub fn buffer(&self, label: &str, bytes: u64) -> wgpu::Buffer {
        use wgpu::BufferUsages as Usage;
        self.0.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: bytes.max(4).next_multiple_of(4),
            usage: Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST | Usage::INDIRECT,
            mapped_at_creation: false,
        })
    }

    /// A storage buffer that holds `data`.
    pub fn buffer_of<T: bytemuck::NoUninit>(&self, label: &str, data: &[T]) -> wgpu::Buffer {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let buffer = self.buffer(label, bytes.len() as u64);
        self.0.queue.write_buffer(&buffer, 0, bytes);
        buffer
    }

    /// Largest texture side, px.
    pub fn max_texture_side(&self) -> u32 {
        self.0.device.limits().max_texture_dimension_2d
    }

    /// Bytes of all pooled textures, in use or free.
    pub fn pooled_bytes(&self) -> u64 {
        self.0.pool.held_bytes()
    }

    /// Starts a frame of work.
    pub fn frame(&self) -> Frame<'_> {
        Frame::new(self)
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
