//! The first layer from more samples than it has texels.
//!
//! A lens averages over what a pixel of a blurred surface shows only a point of: a glint on
//! metal, a light bulb a pixel wide that decides how bright a disc of a thousand pixels is.
//! So the nearest surfaces are drawn finer than the layers: once while the view stays.

use super::{Layer, View, ViewError};
use crate::gpu::{Buffer, Frame, Shader, Texture};
use crate::{shader, uniform};
use glam::UVec2;

const SHADER: Shader = shader!("samples");

/// Radiance above which a blurred texel's light is kept apart: `HIGHLIGHT_LIMIT` in
/// `shaders/lib/emitters.wgsl`.
pub const HIGHLIGHT_LIMIT: f32 = 2.0;

/// Most samples a texel of the first layer on each axis.
pub const MAX_DRAWS: u32 = 4;

/// Side of a tile that gets hidden layers or none, and holds light or none, px.
pub(super) const TILE_PX: u32 = 8;

/// Bytes of `Light` in `shaders/lib/emitters.wgsl`.
pub const LIGHT_BYTES: u64 = 48;

uniform! {
    struct Sampling {
        samples_a_side: u32,
        samples_a_texel: u32,
        same_z: f32,
        limited: u32,
        size: [u32; 2],
        staggered: u32,
        _pad: u32,
    }
}

/// What each pixel of the outer frame holds far brighter than white, on the GPU.
#[derive(Clone, Debug)]
pub struct Lights {
    /// `Light` in `shaders/lib/emitters.wgsl`, by pixel.
    pub buffer: Buffer,
    /// By tile of 8x8 px, u32, row by row: bit k is set where layer k holds any.
    pub tiles: Buffer,
    /// Distance of samples, px.
    pub sample_px: f32,
}

/// The first layer, sampled.
pub(super) struct Sampled {
    /// The mean colour of each texel's surface, without what lights bring.
    pub mean: Texture,
    /// Stored depth of each texel: that of its first sample.
    pub depth: Texture,
    /// All samples.
    pub samples: Layer,
    /// Whether they are staggered (`shaders/lib/staggered.wgsl`).
    pub staggered: bool,
    pub lights: Option<Lights>,
}

/// How the first layer is sampled.
pub(super) struct Samples {
    /// Texels a pixel on each side.
    pub fineness: u32,
    /// Samples a texel on each side.
    pub draws: u32,
    /// Stored depth within which samples belong together.
    pub same_z: f32,
    /// Whether what is far brighter than white is kept apart.
    pub lights: bool,
}

/// Tiles of an image of `size` px.
fn tile_count(size: UVec2) -> u64 {
    let tiles = size.map(|side| side.div_ceil(TILE_PX));
    u64::from(tiles.x) * u64::from(tiles.y)
}

uniform! {
    struct Marking {
        size: [u32; 2],
        layers: u32,
        texels_a_side: u32,
    }
}

impl Lights {
    /// Records the pass that finds in which tiles any of the first `layers` layers of `color` and `depth`
    /// holds light, with so many texels a pixel on each side.
    pub(super) fn mark_tiles(
        &self,
        frame: &mut Frame<'_>,
        color: &Texture,
        depth: &Texture,
        layers: u32,
        texels_a_side: u32,
    ) {
        let size = depth.size() / texels_a_side;
        let marking = Marking { size: size.to_array(), layers, texels_a_side };
        frame
            .pass(&SHADER, "mark_lights")
            .uniform("marking", &marking)
            .texture("colors", color)
            .texture("depths", depth)
            .buffer("found_lights", &self.buffer)
            .buffer("light_tiles", &self.tiles)
            .dispatch(size);
    }
}

impl View {
    /// Samples the first layer.
    pub(super) fn sampled(&mut self, frame: &mut Frame<'_>, order: &Samples) -> Result<Sampled, ViewError> {
        let size = self.projection.outer_size();
        let samples_a_side = order.fineness * order.draws;
        let staggered = self.fine_drawing(frame.gpu()).staggers();
        let samples = self.fine_samples(frame, samples_a_side)?;
        let lights = (order.lights && self.brightest(frame) > HIGHLIGHT_LIMIT).then(|| Lights {
            buffer: frame.gpu().scratch("lights", LIGHT_BYTES * u64::from(size.x) * u64::from(size.y)),
            tiles: frame.gpu().scratch("tiles with lights", 4 * tile_count(size)),
            sample_px: 1.0 / samples_a_side as f32,
        });
        let sampling = Sampling {
            samples_a_side,
            samples_a_texel: order.draws,
            same_z: order.same_z,
            limited: lights.is_some().into(),
            size: size.to_array(),
            staggered: staggered.into(),
            ..Default::default()
        };
        let texels = size * order.fineness;
        let mean = frame.texture("mean colour", texels, wgpu::TextureFormat::Rgba16Float);
        let depth = frame.texture("layer depth", texels, wgpu::TextureFormat::R32Float);
        frame
            .pass(&SHADER, "mean_of_samples")
            .uniform("sampling", &sampling)
            .texture("color", &samples.color)
            .texture("depth", &samples.depth)
            .texture("mean", &mean)
            .texture("own_depth", &depth)
            .dispatch(texels);
        if let Some(lights) = &lights {
            frame
                .pass(&SHADER, "find_lights")
                .uniform("sampling", &sampling)
                .texture("color", &samples.color)
                .texture("depth", &samples.depth)
                .buffer("lights", &lights.buffer)
                .dispatch(size);
        }
        Ok(Sampled { mean, depth, samples, staggered, lights })
    }
}
