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

/// A texel of a level and layer.
#[derive(Clone, Copy)]
pub(super) struct Spot<'t> {
    pub texture: &'t Texture,
    pub level: u32,
    pub layer: u32,
    pub texel: UVec2,
}

/// The numbers of texels in one go; channels that a format lacks are 0, and there is nothing of
/// a format that is neither floats nor whole numbers of 32 bits. Waits for the GPU; `None` where
/// the device is lost.
pub(super) fn read_texels(gpu: &Gpu, spots: &[Spot<'_>]) -> Option<Vec<Option<[f32; 4]>>> {
    // Rows of copies into a buffer begin at multiples of this; no texel is longer.
    const SLOT: u64 = wgpu::COPY_BYTES_PER_ROW_ALIGNMENT as u64;
    if spots.is_empty() {
        return Some(Vec::new());
    }
    let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
    let size = SLOT * spots.len() as u64;
    let descriptor = wgpu::BufferDescriptor { label: Some("texels"), size, usage, mapped_at_creation: false };
    let buffer = gpu.device().create_buffer(&descriptor);
    let mut encoder = gpu.device().create_command_encoder(&Default::default());
    let one = wgpu::Extent3d { width: 1, height: 1, depth_or_array_layers: 1 };
    let is_read = |spot: &Spot<'_>| texel_reader(spot.texture.format()).is_some();
    for (slot, spot) in spots.iter().enumerate().filter(|(_, spot)| is_read(spot)) {
        let from = wgpu::TexelCopyTextureInfo {
            texture: spot.texture.raw(),
            mip_level: spot.level,
            origin: wgpu::Origin3d { x: spot.texel.x, y: spot.texel.y, z: spot.layer },
            aspect: wgpu::TextureAspect::All,
        };
        let layout = wgpu::TexelCopyBufferLayout { offset: SLOT * slot as u64, ..Default::default() };
        encoder.copy_texture_to_buffer(from, wgpu::TexelCopyBufferInfo { buffer: &buffer, layout }, one);
    }
    gpu.queue().submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |_| {});
    // Fails only with the device lost, which its own callback reports.
    gpu.device().poll(wgpu::PollType::wait_indefinitely()).ok()?;
    let mapped = buffer.get_mapped_range(..).ok()?;
    let slots = mapped.chunks_exact(SLOT as usize);
    let texel = |(spot, bytes): (&Spot<'_>, &[u8])| texel_reader(spot.texture.format()).map(|read| read(bytes));
    Some(spots.iter().zip(slots).map(texel).collect())
}

/// How the bytes of a texel become numbers.
fn texel_reader(format: wgpu::TextureFormat) -> Option<impl Fn(&[u8]) -> [f32; 4]> {
    let bytes = format.block_copy_size(None)? as usize;
    let channels = usize::from(format.components());
    let is_whole = format.sample_type(None, None) == Some(wgpu::TextureSampleType::Uint);
    let number: fn(&[u8]) -> f32 = match (bytes / channels, is_whole) {
        (2, false) => |b| f16::from_le_bytes([b[0], b[1]]).to_f32(),
        (4, false) => |b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
        (4, true) => |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as f32,
        _ => return None,
    };
    Some(move |texel: &[u8]| {
        let mut values = [0.0; 4];
        let stored = texel[..bytes].chunks_exact(bytes / channels);
        values.iter_mut().zip(stored).for_each(|(value, stored)| *value = number(stored));
        values
    })
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
