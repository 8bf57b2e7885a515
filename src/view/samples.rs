//! The first layer from more samples than it has texels.
//!
//! A lens averages over what a pixel of a blurred surface shows only a point of: a glint on
//! metal, a light bulb a pixel wide that decides how bright a disc of a thousand pixels is.
//! So the scene is drawn a few times more, moved by parts of a texel: once while the view
//! stays.

use super::fine::{FineQuery, empty, weave};
use super::{Layer, LayerQuery, Source, View, ViewError};
use crate::gpu::{Buffer, Frame, Shader, Texture};
use crate::{shader, uniform};
use glam::UVec2;

const SHADER: Shader = shader!("samples");

/// Radiance above which a blurred texel's light is kept apart: `HIGHLIGHT_LIMIT` in
/// `shaders/lib/emitters.wgsl`.
pub const HIGHLIGHT_LIMIT: f32 = 2.0;

/// Most draws on an axis: `COUNT_SCALE` in the shader is one over its square.
pub const MAX_DRAWS: u32 = 4;

/// Bytes of `Light` in `shaders/lib/emitters.wgsl`.
const LIGHT_BYTES: u64 = 48;

uniform! {
    struct Sampling {
        fineness: u32,
        share: f32,
        shift: [f32; 2],
        size: [u32; 2],
        same_z: f32,
        limited: u32,
    }
}

/// What each pixel of the outer frame holds far brighter than white, on the GPU.
#[derive(Clone, Debug)]
pub struct Lights {
    /// `Light` in `shaders/lib/emitters.wgsl`, by pixel.
    pub buffer: Buffer,
    /// Distance of samples, px.
    pub sample_px: f32,
}

/// The first layer, sampled.
pub(super) struct Sampled {
    /// The mean colour of each texel's surface, without what lights bring.
    pub mean: Texture,
    /// All samples, those of all draws.
    pub samples: Layer,
    pub lights: Option<Lights>,
}

/// How the first layer is sampled.
pub(super) struct Samples {
    pub fineness: u32,
    /// Draws on each axis.
    pub draws: u32,
    /// Stored depth within which samples belong together.
    pub same_z: f32,
}

impl View {
    /// Samples the first layer, which has been drawn once.
    pub(super) fn sampled(
        &mut self,
        frame: &mut Frame<'_>,
        first: &Layer,
        samples: &Samples,
    ) -> Result<Sampled, ViewError> {
        let size = self.projection.outer_size();
        let samples_a_side = samples.fineness * samples.draws;
        let lights = (self.brightest(frame) > HIGHLIGHT_LIMIT).then(|| Lights {
            buffer: frame.gpu().buffer("lights", LIGHT_BYTES * u64::from(size.x) * u64::from(size.y)),
            sample_px: 1.0 / samples_a_side as f32,
        });
        let mut mean: Option<Texture> = None;
        let all = match samples.draws {
            1 => first.clone(),
            draws => empty(frame, first.color.size() * draws),
        };
        for draw in 0..samples.draws * samples.draws {
            let part = UVec2::new(draw % samples.draws, draw / samples.draws);
            let shift_px = part.as_dvec2() / f64::from(samples_a_side);
            let drawn = match (&self.source, draw) {
                (Source::Scene(_), 1..) => {
                    let query = FineQuery { fineness: samples.fineness, shift_px, surfaces: LayerQuery::NEAREST };
                    self.fine_layer(frame, "more samples", &query)?
                }
                _ => first.clone(),
            };
            if samples.draws > 1 {
                weave(frame, &drawn, &all, part);
            }
            let sampling = Sampling {
                fineness: samples.fineness,
                share: 1.0 / (samples_a_side * samples_a_side) as f32,
                shift: shift_px.as_vec2().to_array(),
                size: size.to_array(),
                same_z: samples.same_z,
                limited: lights.is_some().into(),
            };
            mean = Some(add_sample(frame, mean.as_ref(), first, &drawn, &sampling));
            if let Some(lights) = &lights {
                frame
                    .pass(&SHADER, "add_lights")
                    .uniform("sampling", &sampling)
                    .texture("color", &drawn.color)
                    .texture("depth", &drawn.depth)
                    .buffer("lights", &lights.buffer)
                    .dispatch(size);
            }
        }
        Ok(Sampled { mean: mean.unwrap_or_else(|| first.color.clone()), samples: all, lights })
    }
}

fn add_sample(
    frame: &mut Frame<'_>,
    mean: Option<&Texture>,
    first: &Layer,
    drawn: &Layer,
    sampling: &Sampling,
) -> Texture {
    let next = frame.texture("mean colour", first.color.size(), wgpu::TextureFormat::Rgba16Float);
    match mean {
        None => frame.pass(&SHADER, "first_sample"),
        Some(mean) => frame
            .pass(&SHADER, "add_sample")
            .texture("depth", &drawn.depth)
            .texture("own_depth", &first.depth)
            .texture("mean", mean),
    }
    .uniform("sampling", sampling)
    .texture("color", &drawn.color)
    .texture("next_mean", &next)
    .dispatch(next.size());
    next
}
