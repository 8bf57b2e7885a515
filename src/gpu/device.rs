//! Finding an adapter and opening a device on it.

use wgpu::{DeviceType, Features};

/// Why no GPU can be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// There is no adapter at all.
    #[error(
        "no graphics adapter was found: install a Vulkan driver (on Debian or Ubuntu: apt-get install \
         libvulkan1 mesa-vulkan-drivers, which also brings a software one)"
    )]
    NoAdapter,
    /// No adapter's name contains what was asked for.
    #[error("no adapter is called '{}'; there are: {available}", wanted.escape_debug())]
    NoSuchAdapter {
        /// The substring asked for.
        wanted: String,
        /// Names of the adapters there are.
        available: String,
    },
    /// The adapter refuses to open a device.
    #[error("adapter '{adapter}' does not open a device: {cause}; try another with --adapter")]
    NoDevice {
        /// The adapter's name.
        adapter: String,
        /// The driver's reason.
        cause: String,
    },
}

/// Optional features that are used where they are there, each with a fallback.
pub fn wanted_features() -> Features {
    Features::TIMESTAMP_QUERY
        | Features::FLOAT32_FILTERABLE
        | Features::FLOAT32_BLENDABLE
        // Only to count the texture reads of vertex shaders.
        | Features::VERTEX_WRITABLE_STORAGE
}

/// The limits to open a device with: what the adapter has of those that matter here.
pub fn wanted_limits(adapter: &wgpu::Limits) -> wgpu::Limits {
    wgpu::Limits {
        max_texture_dimension_2d: adapter.max_texture_dimension_2d,
        max_buffer_size: adapter.max_buffer_size,
        max_storage_buffer_binding_size: adapter.max_storage_buffer_binding_size,
        max_storage_textures_per_shader_stage: adapter.max_storage_textures_per_shader_stage.min(8),
        max_color_attachment_bytes_per_sample: adapter.max_color_attachment_bytes_per_sample.min(128),
        ..wgpu::Limits::default()
    }
}

/// [`AdapterSummary::kind`] of an adapter that is a program.
pub(super) const SOFTWARE: &str = "software";

/// An adapter by description, as `defocus adapters` lists it.
#[derive(Clone, Debug, serde::Serialize)]
pub struct AdapterSummary {
    /// The driver's name for it.
    pub name: String,
    /// "Vulkan", "Metal", ...
    pub backend: String,
    /// "discrete", "integrated", "virtual", "software" or "other".
    pub kind: &'static str,
    /// Driver and its version.
    pub driver: String,
}

impl AdapterSummary {
    pub(super) fn of(info: &wgpu::AdapterInfo) -> Self {
        let kind = match info.device_type {
            DeviceType::DiscreteGpu => "discrete",
            DeviceType::IntegratedGpu => "integrated",
            DeviceType::VirtualGpu => "virtual",
            DeviceType::Cpu => SOFTWARE,
            DeviceType::Other => "other",
        };
        let driver = format!("{} {}", info.driver, info.driver_info).trim().to_owned();
        Self { name: info.name.clone(), backend: format!("{:?}", info.backend), kind, driver }
    }
}

fn rank(info: &wgpu::AdapterInfo) -> (u8, u8) {
    let kind = match info.device_type {
        DeviceType::DiscreteGpu => 0,
        DeviceType::IntegratedGpu => 1,
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 3,
        DeviceType::Cpu => 4,
    };
    // GL is a fallback only: no float filtering or blending through EGL.
    (u8::from(info.backend == wgpu::Backend::Gl), kind)
}

/// All adapters, the best first: real GPUs before software, GL last.
pub(super) fn adapters(instance: &wgpu::Instance) -> Vec<wgpu::Adapter> {
    let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    adapters.sort_by_key(|a| rank(&a.get_info()));
    adapters
}

/// The best of `adapters`, or the best of those whose name contains `wanted` (case
/// ignored): real GPUs before software, GL last.
///
/// # Errors
///
/// No adapter at all, or none of that name.
pub fn best_adapter(mut adapters: Vec<wgpu::Adapter>, wanted: Option<&str>) -> Result<wgpu::Adapter, GpuError> {
    adapters.sort_by_key(|a| rank(&a.get_info()));
    if adapters.is_empty() {
        return Err(GpuError::NoAdapter);
    }
    let Some(wanted) = wanted else {
        return adapters.into_iter().next().ok_or(GpuError::NoAdapter);
    };
    let names: Vec<_> = adapters.iter().map(|a| a.get_info().name).collect();
    let matches = |name: &str| name.to_lowercase().contains(&wanted.to_lowercase());
    let found = adapters.into_iter().find(|a| matches(&a.get_info().name));
    found.ok_or_else(|| GpuError::NoSuchAdapter { wanted: wanted.into(), available: names.join(", ") })
}

/// [`best_adapter`] of the machine's.
pub(super) fn choose(instance: &wgpu::Instance, wanted: Option<&str>) -> Result<wgpu::Adapter, GpuError> {
    best_adapter(adapters(instance), wanted)
}
