//! The first layer from more samples than it has texels.
//!
//! A lens averages over what a pixel of a blurred surface shows only a point of: a glint on
//! metal, a light bulb a pixel wide that decides how bright a disc of a thousand pixels is.
//! So the scene is drawn a few times more, moved by parts of a texel: once while the view
//! stays.

use super::raster::Shot;
use super::{Layer, LayerQuery, Source, View};
use crate::camera::Projection;
use crate::gpu::{Frame, Shader, Texture};
use crate::lens::Lens;
use crate::{shader, uniform};
use glam::{DVec2, Mat4, Vec2, dvec2};

const SHADER: Shader = shader!("samples");

/// Radiance above which a blurred texel's light is kept apart: `HIGHLIGHT_LIMIT` in
/// `shaders/lib/emitters.wgsl`.
pub const HIGHLIGHT_LIMIT: f32 = 2.0;

/// Most draws on an axis: `COUNT_SCALE` in the shader is one over its square.
pub const MAX_DRAWS: u32 = 4;

/// Bytes of `Light` in `shaders/lib/emitters.wgsl`.
const LIGHT_BYTES: u64 = 32;

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
    pub buffer: wgpu::Buffer,
    /// Distance of samples, px.
    pub sample_px: f32,
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
    /// The mean colour of each texel of the first layer, and the lights, where there are any.
    pub(super) fn sampled(
        &mut self,
        frame: &mut Frame<'_>,
        first: &Layer,
        samples: &Samples,
    ) -> (Texture, Option<Lights>) {
        let size = self.projection.outer_size();
        let samples_a_side = samples.fineness * samples.draws;
        let lights = (self.brightest(frame) > HIGHLIGHT_LIMIT).then(|| Lights {
            buffer: frame.gpu().buffer("lights", LIGHT_BYTES * u64::from(size.x) * u64::from(size.y)),
            sample_px: 1.0 / samples_a_side as f32,
        });
        let mut mean: Option<Texture> = None;
        for draw in 0..samples.draws * samples.draws {
            let part = dvec2((draw % samples.draws).into(), (draw / samples.draws).into());
            let shift_px = part / f64::from(samples_a_side);
            let drawn = match (&self.source, draw) {
                (Source::Scene(_), 1..) => self.shifted(frame, samples.fineness, shift_px),
                _ => first.clone(),
            };
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
        (mean.unwrap_or_else(|| first.color.clone()), lights)
    }

    /// The pinhole image of a scene with `fineness` squared texels a pixel, sampled
    /// `shift_px` to the right and down of where [`View::peeled`] samples.
    fn shifted(&self, frame: &mut Frame<'_>, fineness: u32, shift_px: DVec2) -> Layer {
        let Source::Scene(source) = &self.source else { unreachable!("only scenes are drawn") };
        let projection = self.projection.refined(fineness);
        let clip_from_view = fine_clip_from_view(&projection, fineness, shift_px);
        source.draw(frame, "more samples", &fine_shot(&projection, clip_from_view, fineness, LayerQuery::NEAREST))
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

/// A shot of fine texels in which textures keep the mipmap level that they have in the
/// pinhole image.
pub(super) fn fine_shot<'a>(
    projection: &'a Projection,
    clip_from_view: Mat4,
    fineness: u32,
    query: LayerQuery<'a>,
) -> Shot<'a> {
    Shot { projection, clip_from_view, shading_eye_m: DVec2::ZERO, lod_bias: (fineness as f32).log2(), query }
}

/// The pinhole's projection with the first of the `fineness` texels of a pixel sampled
/// `shift_px` beside the pixel's own centre.
pub(super) fn fine_clip_from_view(projection: &Projection, fineness: u32, shift_px: DVec2) -> Mat4 {
    // x_clip grows by shift * w, and w = -z.
    let texels = 0.5 * f64::from(fineness - 1) + shift_px * f64::from(fineness);
    let shift_ndc = (2.0 * texels / projection.outer_size().as_dvec2()).as_vec2() * Vec2::new(-1.0, 1.0);
    let mut moved = projection.clip_from_view(&Lens::PINHOLE, DVec2::ZERO);
    moved.z_axis.x -= shift_ndc.x;
    moved.z_axis.y -= shift_ndc.y;
    moved
}
