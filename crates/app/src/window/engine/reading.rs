//! The numbers in a texture of a method: what they are and on which scale they are shown.

use defocus::gpu::{Gpu, Texture};
use defocus::methods::{Meaning, Quantity};
use defocus::present::Map;
use glam::UVec2;
use half::f16;

/// The numbers of a texture that are shown, and on which scale.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// What they are.
    pub quantity: Quantity,
    /// Stored values at the ends of the colour map.
    pub ends: [f32; 2],
    /// The colours.
    pub map: Map,
    /// Mipmap level, array layer and channel.
    pub(super) at: (u32, u32, u32),
}

impl Reading {
    /// Place of a stored value on the map, from 0 to 1.
    pub fn place(&self, value: f32) -> f32 {
        let [low, high] = self.ends;
        if high > low { ((value - low) / (high - low)).clamp(0.0, 1.0) } else { 0.0 }
    }
}

/// The channel to show as numbers, where `wanted` is what was asked for; `None` for a
/// picture.
pub(in crate::window) fn channel_of(meaning: &Meaning, wanted: Option<u32>, components: u32) -> Option<u32> {
    let named = meaning.quantities().len() as u32;
    let channels = if named > 0 { named } else { components };
    match wanted {
        None if named == 0 && components > 1 => None,
        None => Some(0),
        Some(channel) => Some(channel.min(channels - 1)),
    }
}

/// One texel of a level and layer; channels that a format lacks are 0. Waits for the GPU;
/// `None` for a format without floats and where the device is lost.
pub(super) fn read_texel(gpu: &Gpu, texture: &Texture, (level, layer): (u32, u32), at: UVec2) -> Option<[f32; 4]> {
    let bytes = texture.format().block_copy_size(None)?;
    let size = u64::from(bytes.next_multiple_of(4));
    let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
    let descriptor = wgpu::BufferDescriptor { label: Some("texel"), size, usage, mapped_at_creation: false };
    let buffer = gpu.device().create_buffer(&descriptor);
    let mut encoder = gpu.device().create_command_encoder(&Default::default());
    let from = wgpu::TexelCopyTextureInfo {
        texture: texture.raw(),
        mip_level: level,
        origin: wgpu::Origin3d { x: at.x, y: at.y, z: layer },
        aspect: wgpu::TextureAspect::All,
    };
    let layout = wgpu::TexelCopyBufferLayout::default();
    let one = wgpu::Extent3d { width: 1, height: 1, depth_or_array_layers: 1 };
    encoder.copy_texture_to_buffer(from, wgpu::TexelCopyBufferInfo { buffer: &buffer, layout }, one);
    gpu.queue().submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |_| {});
    // Fails only with the device lost, which its own callback reports.
    gpu.device().poll(wgpu::PollType::wait_indefinitely()).ok()?;
    let mapped = buffer.get_mapped_range(..).ok()?;
    let channels = usize::from(texture.format().components());
    let mut texel = [0.0; 4];
    match bytes as usize / channels {
        2 => (texel.iter_mut().zip(mapped.chunks_exact(2)).take(channels))
            .for_each(|(v, b)| *v = f16::from_le_bytes([b[0], b[1]]).to_f32()),
        4 => (texel.iter_mut().zip(mapped.chunks_exact(4)).take(channels))
            .for_each(|(v, b)| *v = f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
        _ => return None,
    }
    Some(texel)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_have_a_place_between_the_ends() {
        let reading = |ends| Reading { quantity: Quantity::default(), ends, map: Map::Sequential, at: (0, 0, 0) };
        assert_eq!(reading([-6.0, 6.0]).place(0.0), 0.5);
        assert_eq!(reading([0.0, 1.0]).place(2.0), 1.0);
        // One value alone has a place too.
        assert_eq!(reading([2.0, 2.0]).place(2.0), 0.0);
    }
}
