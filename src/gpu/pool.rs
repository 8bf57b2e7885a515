//! Transient textures and buffers, pooled: dropping the last handle gives the thing back.

use glam::UVec2;
use rustc_hash::FxHashMap;
use std::hash::Hash;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
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
pub struct Texture(Arc<PooledTexture>);

/// A texture with the views of it that were asked for: they live as long as it does.
struct TextureParts {
    texture: wgpu::Texture,
    whole: wgpu::TextureView,
    levels: OnceLock<Vec<wgpu::TextureView>>,
    /// Views of single array layers, layer by layer of each level.
    slices: OnceLock<Vec<OnceLock<wgpu::TextureView>>>,
}

struct PooledTexture {
    key: TextureKey,
    /// `None` only while it is being given back.
    parts: Option<Box<TextureParts>>,
    pool: Weak<Pool>,
}

impl PooledTexture {
    fn parts(&self) -> &TextureParts {
        self.parts.as_deref().expect("taken only by drop")
    }
}

impl std::fmt::Debug for Texture {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Texture({:?})", self.0.key)
    }
}

impl Drop for PooledTexture {
    fn drop(&mut self) {
        if let (Some(pool), Some(parts)) = (self.pool.upgrade(), self.parts.take()) {
            pool.textures.give_back(self.key, parts, self.key.bytes(), &pool.generation);
        }
    }
}

impl Texture {
    /// Wraps a texture of another owner; it is never pooled.
    pub fn external(texture: wgpu::Texture) -> Self {
        let size = UVec2::new(texture.width(), texture.height());
        let layers = texture.depth_or_array_layers();
        let key = TextureKey { size, levels: texture.mip_level_count(), layers, format: texture.format() };
        Self::new(Box::new(TextureParts::of(texture)), key, Weak::new())
    }

    fn new(parts: Box<TextureParts>, key: TextureKey, pool: Weak<Pool>) -> Self {
        Self(Arc::new(PooledTexture { parts: Some(parts), key, pool }))
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
        &self.0.parts().texture
    }

    /// A view of all levels and layers.
    pub fn view(&self) -> &wgpu::TextureView {
        &self.0.parts().whole
    }

    /// A view of one level: 2D, or of an array with all its layers.
    pub(crate) fn level_view(&self, level: u32) -> &wgpu::TextureView {
        let parts = self.0.parts();
        let of_level = |base_mip_level| {
            let mip_level_count = Some(1);
            let level = wgpu::TextureViewDescriptor { base_mip_level, mip_level_count, ..Default::default() };
            parts.texture.create_view(&level)
        };
        let views = parts.levels.get_or_init(|| (0..self.levels()).map(of_level).collect());
        &views[level as usize]
    }

    /// A plain 2D view of one level of one array layer. Panics if there is none such.
    pub(crate) fn slice_view(&self, level: u32, layer: u32) -> &wgpu::TextureView {
        let parts = self.0.parts();
        let count = (self.levels() * self.layers()) as usize;
        let views = parts.slices.get_or_init(|| (0..count).map(|_| OnceLock::new()).collect());
        assert!(level < self.levels() && layer < self.layers(), "level {level}, layer {layer} of {self:?}");
        views[(level * self.layers() + layer) as usize].get_or_init(|| {
            parts.texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2),
                base_mip_level: level,
                mip_level_count: Some(1),
                base_array_layer: layer,
                array_layer_count: Some(1),
                ..Default::default()
            })
        })
    }

    /// Whether two handles mean the same texture.
    pub fn same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl TextureParts {
    fn of(texture: wgpu::Texture) -> Self {
        let depth = texture.format().has_depth_aspect();
        let aspect = if depth { wgpu::TextureAspect::DepthOnly } else { wgpu::TextureAspect::All };
        let whole = texture.create_view(&wgpu::TextureViewDescriptor { aspect, ..Default::default() });
        Self { texture, whole, levels: OnceLock::new(), slices: OnceLock::new() }
    }
}

/// What makes two buffers interchangeable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct BufferKey {
    bytes: u64,
    usage: wgpu::BufferUsages,
}

/// A shared handle to a storage buffer; cheap to clone.
#[derive(Clone)]
pub struct Buffer(Arc<PooledBuffer>);

struct PooledBuffer {
    key: BufferKey,
    buffer: wgpu::Buffer,
    /// Whether it is to be cleared before anything uses it.
    unclean: AtomicBool,
    pool: Weak<Pool>,
}

impl std::fmt::Debug for Buffer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Buffer({} bytes)", self.0.key.bytes)
    }
}

impl Drop for PooledBuffer {
    fn drop(&mut self) {
        if let Some(pool) = self.pool.upgrade() {
            pool.buffers.give_back(self.key, self.buffer.clone(), self.key.bytes, &pool.generation);
        }
    }
}

impl Buffer {
    /// Wraps a buffer of another owner; it is never pooled.
    pub fn external(buffer: wgpu::Buffer) -> Self {
        let key = BufferKey { bytes: buffer.size(), usage: buffer.usage() };
        Self(Arc::new(PooledBuffer { key, buffer, unclean: AtomicBool::new(false), pool: Weak::new() }))
    }

    /// The buffer itself.
    pub fn raw(&self) -> &wgpu::Buffer {
        &self.0.buffer
    }

    /// Size, bytes.
    pub fn size(&self) -> u64 {
        self.0.key.bytes
    }

    /// Whether it must be cleared first; only the first call is told so.
    pub(super) fn take_unclean(&self) -> bool {
        // Most buffers never are: the exchange is for those that may be.
        self.0.unclean.load(Ordering::Relaxed) && self.0.unclean.swap(false, Ordering::Relaxed)
    }
}

/// Things that were given back, with the bytes of each.
type Returned<V> = Vec<(V, u64)>;

/// What is free of one kind, and how many bytes are in use.
///
/// Things may be given back while the commands that use them wait to be submitted. Later
/// commands of the same thread come after them on the queue and may overwrite them;
/// another thread's may come before, so each thread is given only what it gave back itself.
struct Shelf<K, V> {
    free: Mutex<FxHashMap<(ThreadId, K), Returned<V>>>,
    live_bytes: AtomicU64,
    peak_bytes: AtomicU64,
}

impl<K, V> Default for Shelf<K, V> {
    fn default() -> Self {
        Self { free: Mutex::default(), live_bytes: AtomicU64::new(0), peak_bytes: AtomicU64::new(0) }
    }
}

const UNLOCKED: &str = "no panic while the pool is locked";

impl<K: Hash + Eq + Copy, V> Shelf<K, V> {
    /// A free one, and whether it had to be made.
    fn take(&self, key: K, bytes: u64, make: impl FnOnce() -> V) -> (V, bool) {
        let thread = std::thread::current().id();
        let free = self.free.lock().expect(UNLOCKED).get_mut(&(thread, key)).and_then(Vec::pop);
        let live = self.live_bytes.fetch_add(bytes, Ordering::Relaxed) + bytes;
        self.peak_bytes.fetch_max(live, Ordering::Relaxed);
        match free {
            Some((value, _)) => (value, false),
            None => (make(), true),
        }
    }

    fn give_back(&self, key: K, value: V, bytes: u64, generation: &AtomicU64) {
        self.live_bytes.fetch_sub(bytes, Ordering::Relaxed);
        let now = generation.load(Ordering::Relaxed);
        let thread = std::thread::current().id();
        self.free.lock().expect(UNLOCKED).entry((thread, key)).or_default().push((value, now));
    }

    fn start_frame(&self, now: u64) {
        self.peak_bytes.store(self.live_bytes.load(Ordering::Relaxed), Ordering::Relaxed);
        self.free.lock().expect(UNLOCKED).retain(|_, values| {
            values.retain(|(_, since)| now.saturating_sub(*since) <= KEPT_FRAMES);
            !values.is_empty()
        });
    }

    fn held_bytes(&self, bytes: impl Fn(&K) -> u64) -> u64 {
        let free = self.free.lock().expect(UNLOCKED);
        let free: u64 = free.iter().map(|((_, key), values)| bytes(key) * values.len() as u64).sum();
        free + self.live_bytes.load(Ordering::Relaxed)
    }
}

/// Free textures and buffers.
#[derive(Default)]
pub(super) struct Pool {
    textures: Shelf<TextureKey, Box<TextureParts>>,
    buffers: Shelf<BufferKey, wgpu::Buffer>,
    generation: AtomicU64,
}

/// Frames for which what is free is kept before its memory is returned.
pub(super) const KEPT_FRAMES: u64 = 8;

impl Pool {
    pub(super) fn texture(self: &Arc<Self>, device: &wgpu::Device, label: &str, key: TextureKey) -> Texture {
        let make = || Box::new(TextureParts::of(create_texture(device, label, key)));
        let (parts, _) = self.textures.take(key, key.bytes(), make);
        Texture::new(parts, key, Arc::downgrade(self))
    }

    /// A buffer of a multiple of 4 bytes; with `zeroed` it is cleared before its first use.
    pub(super) fn buffer(
        self: &Arc<Self>,
        device: &wgpu::Device,
        label: &str,
        bytes: u64,
        usage: wgpu::BufferUsages,
        zeroed: bool,
    ) -> Buffer {
        let key = BufferKey { bytes: bytes.max(4).next_multiple_of(4), usage };
        let make = || {
            let (size, label) = (key.bytes, Some(label));
            device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false })
        };
        let (buffer, is_new) = self.buffers.take(key, key.bytes, make);
        // New buffers hold zeros.
        let unclean = AtomicBool::new(zeroed && !is_new);
        Buffer(Arc::new(PooledBuffer { key, buffer, unclean, pool: Arc::downgrade(self) }))
    }

    /// Starts a frame: the peaks count from here, what was long unused is freed. Returns the
    /// frame's number.
    pub(super) fn start_frame(&self) -> u64 {
        let now = self.generation.fetch_add(1, Ordering::Relaxed) + 1;
        self.textures.start_frame(now);
        self.buffers.start_frame(now);
        now
    }

    /// Most bytes of textures in use at once since the frame started.
    pub(super) fn peak_texture_bytes(&self) -> u64 {
        self.textures.peak_bytes.load(Ordering::Relaxed)
    }

    /// Most bytes of buffers in use at once since the frame started.
    pub(super) fn peak_buffer_bytes(&self) -> u64 {
        self.buffers.peak_bytes.load(Ordering::Relaxed)
    }

    /// Bytes held, in use or free.
    pub(super) fn held_bytes(&self) -> u64 {
        self.textures.held_bytes(TextureKey::bytes) + self.buffers.held_bytes(|key| key.bytes)
    }
}

fn create_texture(device: &wgpu::Device, label: &str, key: TextureKey) -> wgpu::Texture {
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
