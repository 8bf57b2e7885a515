//! Textures from and to the CPU.

use super::{Buffer, Frame, Gpu, Texture};
use crate::image::{ColorImage, Image};
use glam::{UVec2, Vec4};
use half::f16;

/// Row pitch of buffers that textures are copied to, bytes.
const ROW_ALIGNMENT: u32 = wgpu::COPY_BYTES_PER_ROW_ALIGNMENT;

/// Raw rows of level 0, without padding. Waits for the GPU; empty if the device is lost.
fn rows(gpu: &Gpu, texture: &Texture, texel_bytes: u32) -> Vec<u8> {
    let UVec2 { x: width, y: height } = texture.size();
    let row = width * texel_bytes;
    let pitch = row.next_multiple_of(ROW_ALIGNMENT);
    let buffer = gpu.device().create_buffer(&wgpu::BufferDescriptor {
        label: Some("read-back"),
        size: u64::from(pitch) * u64::from(height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device().create_command_encoder(&Default::default());
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(pitch), rows_per_image: None };
    let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    encoder.copy_texture_to_buffer(texture.raw().as_image_copy(), to, size);
    gpu.queue().submit([encoder.finish()]);
    mapped(gpu, &buffer).chunks_exact(pitch as usize).flat_map(|r| &r[..row as usize]).copied().collect()
}

fn mapped(gpu: &Gpu, buffer: &wgpu::Buffer) -> Vec<u8> {
    buffer.map_async(wgpu::MapMode::Read, .., |_| {});
    // Both fail only with the device lost, which its own callback reports.
    let _ = gpu.device().poll(wgpu::PollType::wait_indefinitely());
    buffer.get_mapped_range(..).map(|bytes| bytes.to_vec()).unwrap_or_default()
}

impl Frame<'_> {
    /// Submits what was recorded, waits for it and returns the buffer's content; nothing if
    /// the device is lost, or where another program submits ([`Frame::may_wait`]).
    pub fn read_buffer<T: bytemuck::Pod>(&mut self, buffer: &Buffer) -> Vec<T> {
        if !self.may_wait() {
            return Vec::new();
        }
        self.clear_unclean(buffer);
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
        let descriptor =
            wgpu::BufferDescriptor { label: Some("read-back"), size: buffer.size(), usage, mapped_at_creation: false };
        let copy = self.gpu().device().create_buffer(&descriptor);
        self.encoder().copy_buffer_to_buffer(buffer.raw(), 0, &copy, 0, buffer.size());
        self.flush();
        bytemuck::pod_collect_to_vec(&mapped(self.gpu(), &copy))
    }
}

/// The colour of a 16- or 32-bit float texture. Waits for the GPU.
///
/// Panics for other formats: methods return one of the two.
pub fn download(gpu: &Gpu, texture: &Texture) -> ColorImage {
    download_rgba(gpu, texture).map(|texel| texel.truncate())
}

/// All four components of a 16- or 32-bit float texture. Waits for the GPU.
///
/// Panics for other formats.
pub fn download_rgba(gpu: &Gpu, texture: &Texture) -> Image<Vec4> {
    let pixels = match texture.format() {
        wgpu::TextureFormat::Rgba16Float => {
            let texels: Vec<[f16; 4]> = bytemuck::pod_collect_to_vec(&rows(gpu, texture, 8));
            texels.iter().map(|t| Vec4::from_array(t.map(f16::to_f32))).collect()
        }
        wgpu::TextureFormat::Rgba32Float => bytemuck::pod_collect_to_vec(&rows(gpu, texture, 16)),
        other => panic!("a colour image in {other:?} cannot be read back"),
    };
    Image { size: texture.size(), pixels }
}

/// The values of an R32Float texture. Waits for the GPU.
pub fn download_depth(gpu: &Gpu, texture: &Texture) -> Image<f32> {
    assert_eq!(texture.format(), wgpu::TextureFormat::R32Float, "stored depth is R32Float");
    Image { size: texture.size(), pixels: bytemuck::pod_collect_to_vec(&rows(gpu, texture, 4)) }
}

/// The texels of an RGBA8 texture, such as [`crate::present`] makes. Waits for the GPU.
pub fn download_rgba8(gpu: &Gpu, texture: &Texture) -> Image<[u8; 4]> {
    assert_eq!(texture.format(), wgpu::TextureFormat::Rgba8Unorm, "presented images are Rgba8Unorm");
    Image { size: texture.size(), pixels: bytemuck::pod_collect_to_vec(&rows(gpu, texture, 4)) }
}

/// A texture of its own, not a pooled one: it is written before the commands of frames that
/// are not submitted yet, whatever they do with a pooled one.
fn new_texture(gpu: &Gpu, label: &str, size: UVec2, format: wgpu::TextureFormat) -> Texture {
    use wgpu::TextureUsages as Usage;
    Texture::external(gpu.device().create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: Usage::TEXTURE_BINDING | Usage::COPY_DST | Usage::COPY_SRC,
        view_formats: &[],
    }))
}

fn write(gpu: &Gpu, texture: &Texture, bytes: &[u8], texel_bytes: u32) {
    let UVec2 { x: width, y: height } = texture.size();
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(width * texel_bytes), rows_per_image: None };
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    gpu.queue().write_texture(texture.raw().as_image_copy(), bytes, layout, size);
}

/// An RGBA16F texture with the image's colours (clamped to f16's range) and alpha 1.
pub fn upload(gpu: &Gpu, label: &str, image: &ColorImage) -> Texture {
    let texture = new_texture(gpu, label, image.size, wgpu::TextureFormat::Rgba16Float);
    let max = f16::MAX.to_f32();
    let half = |v: f32| f16::from_f32(v.clamp(-max, max));
    let texels: Vec<[f16; 4]> = image.pixels.iter().map(|p| [half(p.x), half(p.y), half(p.z), f16::ONE]).collect();
    write(gpu, &texture, bytemuck::cast_slice(&texels), 8);
    texture
}

/// An R32Float texture with the image's values.
pub fn upload_scalar(gpu: &Gpu, label: &str, image: &Image<f32>) -> Texture {
    let texture = new_texture(gpu, label, image.size, wgpu::TextureFormat::R32Float);
    write(gpu, &texture, bytemuck::cast_slice(&image.pixels), 4);
    texture
}
