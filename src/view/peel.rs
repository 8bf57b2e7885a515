//! Layers of surfaces, peeled front to back as the pinhole sees them.

use super::raster::Shot;
use super::{Layer, LayerQuery, Source, View, ViewError, check_size};
use crate::camera::Projection;
use crate::gpu::{Frame, Texture, TextureKey};
use crate::lens::Lens;
use crate::{shader, uniform};
use glam::{DVec2, Mat4, UVec2, Vec2};

const SHADER: crate::gpu::Shader = shader!("peel");

/// Mipmap levels of [`Peeled::color`]: level 4 has texels of 16 px.
pub const PEELED_LEVELS: u32 = 5;

/// Surfaces behind one another, nearest first, as texture arrays.
#[derive(Clone, Debug)]
pub struct Peeled {
    /// RGBA16F array: linear radiance. The size is the outer one in fine texels, padded to
    /// whole texels of the coarsest level. Of the first layer there are [`PEELED_LEVELS`] box-filtered
    /// levels.
    pub color: Texture,
    /// R32F array of the outer size in fine texels: stored depth z = near / d, -1 where a layer is empty.
    pub depth: Texture,
    /// Number of layers; the arrays may have more.
    pub layers: u32,
    /// Fine texels a pixel on each side. Texel `fineness * i` is the sample at the centre
    /// of pixel i: the pinhole image's own.
    pub fineness: u32,
    separation_z: f32,
}

uniform! {
    struct PeelParams {
        separation_z: f32,
        nearest: u32,
    }
}

uniform! {
    struct ReduceParams {
        finer_size: [u32; 2],
    }
}

impl View {
    /// The nearest `count` layers, each at least `separation_z` of stored depth behind the
    /// one before it, drawn with `fineness` squared texels a pixel; an image has one of one
    /// texel a pixel. Kept until the view or an argument changes. Errors if the fine layers
    /// exceed the adapter's texture size.
    pub fn peeled(
        &mut self,
        frame: &mut Frame<'_>,
        count: u32,
        fineness: u32,
        separation_z: f32,
    ) -> Result<Peeled, ViewError> {
        let (count, fineness) = if self.is_scene() { (count.max(1), fineness.max(1)) } else { (1, 1) };
        if let Some(peeled) = &self.peeled
            && (peeled.layers, peeled.fineness) == (count, fineness)
            && (count == 1 || peeled.separation_z == separation_z)
        {
            frame.skip("layers unchanged");
            return Ok(peeled.clone());
        }
        let mut nearer = self.fine_layer(frame, "fine layer", fineness, LayerQuery::NEAREST)?;
        let outer = nearer.color.size();
        let padded = outer.map(|side| side.next_multiple_of(1 << (PEELED_LEVELS - 1)));
        // A shader's array needs two layers to be one.
        let layers = count.max(2);
        let (half, float) = (wgpu::TextureFormat::Rgba16Float, wgpu::TextureFormat::R32Float);
        let gpu = frame.gpu();
        let key = TextureKey { size: padded, levels: PEELED_LEVELS, layers, format: half };
        let color = gpu.texture_of("layer colours", key);
        let depth = gpu.texture_of("layer depths", TextureKey { size: outer, levels: 1, layers, format: float });
        for index in 0..count {
            let marked = frame.texture("marked depth", outer, float);
            let below = frame.texture("next layer's bound", outer, float);
            frame
                .pass(&SHADER, "mark_layer")
                .uniform("params", &PeelParams { separation_z, nearest: (index == 0).into() })
                .texture("color", &nearer.color)
                .texture("depth", &nearer.depth)
                .texture("marked", &marked)
                .texture("below", &below)
                .dispatch(outer);
            copy_to_array_layer(frame, &nearer.color, &color, index);
            copy_to_array_layer(frame, &marked, &depth, index);
            if index + 1 < count {
                let query = LayerQuery { below: Some(&below), ..LayerQuery::NEAREST };
                nearer = self.fine_layer(frame, &format!("peel {}", index + 1), fineness, query)?;
            }
        }
        reduce(frame, &color, outer);
        let peeled = Peeled { color, depth, layers: count, fineness, separation_z };
        self.peeled = Some(peeled.clone());
        Ok(peeled)
    }

    fn fine_layer(
        &mut self,
        frame: &mut Frame<'_>,
        label: &str,
        fineness: u32,
        query: LayerQuery<'_>,
    ) -> Result<Layer, ViewError> {
        let source = match &self.source {
            Source::Scene(source) if fineness > 1 => source,
            _ if query.is_nearest() => return Ok(self.pinhole(frame)),
            _ => return self.layer(frame, label, query),
        };
        let coarse = self.projection;
        let projection = Projection {
            size: coarse.size * fineness,
            overscan_px: coarse.overscan_px * fineness,
            focal_px: coarse.focal_px * f64::from(fineness),
            axis_px: coarse.axis_px * f64::from(fineness),
            ..coarse
        };
        check_size(frame.gpu(), projection.size, projection.overscan_px)?;
        let centred = projection.clip_from_view(&Lens::PINHOLE, DVec2::ZERO);
        let clip_from_view = with_texels_on_centres(centred, fineness, projection.outer_size());
        // Textures keep the mipmap level that they have in the pinhole image.
        let lod_bias = (fineness as f32).log2();
        let shot = Shot { projection: &projection, clip_from_view, shading_eye_m: DVec2::ZERO, lod_bias, query };
        Ok(source.draw(frame, label, &shot))
    }
}

/// Moves the image so that the centre of the first of the `fineness` texels of a pixel
/// lies where the pixel's own centre did.
fn with_texels_on_centres(clip_from_view: Mat4, fineness: u32, outer: UVec2) -> Mat4 {
    let shift_ndc = (fineness - 1) as f32 / outer.as_vec2() * Vec2::new(-1.0, 1.0);
    // x_clip grows by shift * w, and w = -z.
    let mut moved = clip_from_view;
    moved.z_axis.x -= shift_ndc.x;
    moved.z_axis.y -= shift_ndc.y;
    moved
}

fn copy_to_array_layer(frame: &mut Frame<'_>, from: &Texture, to: &Texture, layer: u32) {
    let size = wgpu::Extent3d { width: from.size().x, height: from.size().y, depth_or_array_layers: 1 };
    let mut target = to.raw().as_image_copy();
    target.origin.z = layer;
    frame.encoder().copy_texture_to_texture(from.raw().as_image_copy(), target, size);
}

/// Box-filters the first layer, level by level.
fn reduce(frame: &mut Frame<'_>, color: &Texture, outer: UVec2) {
    let mut finer_size = outer;
    for level in 1..color.levels() {
        let size = finer_size.map(|side| side.div_ceil(2));
        frame
            .pass(&SHADER, "reduce_layer")
            .uniform("reduction", &ReduceParams { finer_size: finer_size.to_array() })
            .level("finer", color, level - 1)
            .level("coarser", color, level)
            .dispatch(size);
        finer_size = size;
    }
}

/// A separation for [`View::peeled`] of more than half and at most one pixel of CoC radius,
/// where `slope_px` is [`LensUniform::slope_px`](super::LensUniform). A power of two, so
/// that a lens slider draws layers anew only when it has doubled or halved the blur; the
/// focus distance hardly enters at all.
pub fn layer_separation_z(slope_px: f32) -> f32 {
    (2.0 / slope_px).log2().floor().exp2()
}
