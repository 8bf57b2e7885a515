//! Transient textures, pooled: dropping the last handle gives the texture back.

use glam::UVec2;
use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, Weak};
use std::thread::ThreadId;

/// What makes two textures interchangeable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TextureKey {
    /// Size of level 0, px.
    pub size: UVec2,
    /// Number of mipmap levels.
    pub levels: u32,
    /// Number of array layers; 1 is a plain 2D texture.
    pub layers: u32,
    /// Texel format.
    pub format: wgpu::TextureFormat,
}

impl TextureKey {
    /// Bytes over all levels and layers.
    pub fn bytes(&self) -> u64 {
        let texel = u64::from(self.format.block_copy_size(None).unwrap_or(4));
        let texels =
            (0..self.levels).map(|l| u64::from((self.size.x >> l).max(1)) * u64::from((self.size.y >> l).max(1)));
        texels.sum::<u64>() * texel * u64::from(self.layers)
    }
}

/// A shared handle to a texture; cheap to clone.
#[derive(Clone)]
pub struct Texture(Arc<Pooled>);

struct Pooled {
    texture: wgpu::Texture,
    key: TextureKey,
    whole: wgpu::TextureView,
    levels: OnceLock<Vec<wgpu::TextureView>>,
    pool: Weak<Pool>,
}

impl std::fmt::Debug for Texture {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Texture({:?})", self.0.key)
    }
}

impl Drop for Pooled {
    fn drop(&mut self) {
        if let Some(pool) = self.pool.upgrade() {
            pool.give_back(self.key, self.texture.clone());
        }
    }
}

impl Texture {
    /// Wraps a texture that belongs to someone else; it is never pooled.
    pub fn external(texture: wgpu::Texture) -> Self {
        let size = UVec2::new(texture.width(), texture.height());
        let layers = texture.depth_or_array_layers();
        let key = TextureKey { size, levels: texture.mip_level_count(), layers, format: texture.format() };
        Self::new(texture, key, Weak::new())
    }

    fn new(texture: wgpu::Texture, key: TextureKey, pool: Weak<Pool>) -> Self {
        let depth = key.format.has_depth_aspect();
        let aspect = if depth { wgpu::TextureAspect::DepthOnly } else { wgpu::TextureAspect::All };
        let whole = texture.create_view(&wgpu::TextureViewDescriptor { aspect, ..Default::default() });
        Self(Arc::new(Pooled { texture, key, whole, levels: OnceLock::new(), pool }))
    }

    /// Size of level 0, px.
    pub fn size(&self) -> UVec2 {
        self.0.key.size
    }

    /// Size of `level`, px.
    pub fn level_size(&self, level: u32) -> UVec2 {
        UVec2::new((self.0.key.size.x >> level).max(1), (self.0.key.size.y >> level).max(1))
    }

    /// Number of mipmap levels.
    pub fn levels(&self) -> u32 {
        self.0.key.levels
    }

    /// Number of array layers.
    pub fn layers(&self) -> u32 {
        self.0.key.layers
    }

    /// Texel format.
    pub fn format(&self) -> wgpu::TextureFormat {
        self.0.key.format
    }

    /// The texture itself, to copy from or to.
    pub fn raw(&self) -> &wgpu::Texture {
        &self.0.texture
    }

    /// A view of all levels and layers.
    pub fn view(&self) -> &wgpu::TextureView {
        &self.0.whole
    }

    /// A view of one level: 2D, or of an array with all its layers.
    pub fn level_view(&self, level: u32) -> &wgpu::TextureView {
        let views = self.0.levels.get_or_init(|| {
            let of_level = |level| {
                self.0.texture.create_view(&wgpu::TextureViewDescriptor {
                    base_mip_level: level,
                    mip_level_count: Some(1),
                    ..Default::default()
                })
            };
            (0..self.levels()).map(of_level).collect()
        });
        &views[level as usize]
    }

    /// A plain 2D view of one level of one array layer. Panics if there is none such.
    pub fn slice_view(&self, level: u32, layer: u32) -> wgpu::TextureView {
        self.0.texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2),
            base_mip_level: level,
            mip_level_count: Some(1),
            base_array_layer: layer,
            array_layer_count: Some(1),
            ..Default::default()
        })
    }

    /// Whether two handles mean the same texture.
    pub fn same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// A texture given back, and the frame in which it was.
type Free = (wgpu::Texture, u64);

/// Free textures, and how many bytes are in use.
///
/// A texture may be given back while the commands that use it wait to be submitted. Later
/// commands of the same thread come after them on the queue and may overwrite it; another
/// thread's may come before, so each thread is given only what it gave back itself.
#[derive(Default)]
pub(super) struct Pool {
    free: Mutex<HashMap<(ThreadId, TextureKey), Vec<Free>>>,
    generation: AtomicU64,
    live_bytes: AtomicU64,
    peak_bytes: AtomicU64,
}

/// Frames a free texture is kept for before its memory is returned.
const KEPT_FRAMES: u64 = 8;

impl Pool {
    pub(super) fn take(self: &Arc<Self>, device: &wgpu::Device, label: &str, key: TextureKey) -> Texture {
        let thread = std::thread::current().id();
        let free =
            self.free.lock().expect("no panic while the pool is locked").get_mut(&(thread, key)).and_then(Vec::pop);
        let texture = match free {
            Some((texture, _)) => texture,
            None => create(device, label, key),
        };
        let live = self.live_bytes.fetch_add(key.bytes(), Ordering::Relaxed) + key.bytes();
        self.peak_bytes.fetch_max(live, Ordering::Relaxed);
        Texture::new(texture, key, Arc::downgrade(self))
    }

    fn give_back(&self, key: TextureKey, texture: wgpu::Texture) {
        self.live_bytes.fetch_sub(key.bytes(), Ordering::Relaxed);
        let now = self.generation.load(Ordering::Relaxed);
        let thread = std::thread::current().id();
        let mut free = self.free.lock().expect("no panic while the pool is locked");
        free.entry((thread, key)).or_default().push((texture, now));
    }

    /// Starts a frame: the peak counts from here, textures long unused are freed.
    pub(super) fn start_frame(&self) {
        let now = self.generation.fetch_add(1, Ordering::Relaxed) + 1;
        self.peak_bytes.store(self.live_bytes.load(Ordering::Relaxed), Ordering::Relaxed);
        let mut free = self.free.lock().expect("no panic while the pool is locked");
        free.retain(|_, textures| {
            textures.retain(|(_, since)| now.saturating_sub(*since) <= KEPT_FRAMES);
            !textures.is_empty()
        });
    }

    /// Most bytes in use at once since the frame started.
    pub(super) fn peak_bytes(&self) -> u64 {
        self.peak_bytes.load(Ordering::Relaxed)
    }

    /// Bytes held, in use or free.
    pub(super) fn held_bytes(&self) -> u64 {
        let free = self.free.lock().expect("no panic while the pool is locked");
        let free: u64 = free.iter().map(|((_, key), textures)| key.bytes() * textures.len() as u64).sum();
        free + self.live_bytes.load(Ordering::Relaxed)
    }
}

fn create(device: &wgpu::Device, label: &str, key: TextureKey) -> wgpu::Texture {
    use wgpu::TextureUsages as Usage;
    let depth = key.format.is_depth_stencil_format();
    let mut usage = Usage::TEXTURE_BINDING | Usage::RENDER_ATTACHMENT | Usage::COPY_SRC;
    if !depth {
        usage |= Usage::STORAGE_BINDING | Usage::COPY_DST;
    }
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: key.size.x, height: key.size.y, depth_or_array_layers: key.layers },
        mip_level_count: key.levels,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: key.format,
        usage,
        view_formats: &[],
    })
}
