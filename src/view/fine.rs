//! Layers with several texels a pixel on each side.
//!
//! Lens rays end between the centres of pixels. What is there is drawn as a view from off
//! the lens's centre would draw it: at the size of the pinhole image, moved by parts of a
//! pixel, one draw for each texel of a pixel. One draw at the finer size would read textures
//! over smaller footprints, and make another picture of them.

use super::pipelines::{COLOR, STORED_DEPTH};
use super::raster::Shot;
use super::{Layer, LayerQuery, Source, View, ViewError, check_size};
use crate::camera::Projection;
use crate::gpu::Frame;
use crate::lens::Lens;
use crate::{shader, uniform};
use glam::{DVec2, Mat4, UVec2};

const SHADER: crate::gpu::Shader = shader!("fine");

uniform! {
    struct Weave {
        fineness: u32,
        _pad: u32,
        part: [u32; 2],
    }
}

/// What a fine layer is to show.
#[derive(Clone, Copy)]
pub(super) struct FineQuery<'a> {
    /// Texels a pixel on each side: texel `fineness * i` is the sample at the centre of
    /// pixel i if nothing is moved.
    pub fineness: u32,
    /// How far all samples are moved to the right and down, px.
    pub shift_px: DVec2,
    /// Which surfaces; `below` is of the fine size.
    pub surfaces: LayerQuery<'a>,
}

impl View {
    /// A layer of `fineness` texels a pixel on each side. Errors if it exceeds the adapter's
    /// texture size, and for more than the pinhole image of an image.
    pub(super) fn fine_layer(
        &mut self,
        frame: &mut Frame<'_>,
        label: &str,
        query: &FineQuery<'_>,
    ) -> Result<Layer, ViewError> {
        let fineness = query.fineness;
        if fineness == 1 {
            return self.fine_part(frame, label, query, UVec2::ZERO);
        }
        let Projection { size, overscan_px, .. } = self.projection;
        check_size(frame.gpu(), size * fineness, overscan_px * fineness)?;
        let layer = empty(frame, self.projection.outer_size() * fineness);
        for index in 0..fineness * fineness {
            let part = UVec2::new(index % fineness, index / fineness);
            let drawn = self.fine_part(frame, label, query, part)?;
            weave(frame, &drawn, &layer, part);
        }
        Ok(layer)
    }

    /// One texel of each pixel.
    fn fine_part(
        &mut self,
        frame: &mut Frame<'_>,
        label: &str,
        query: &FineQuery<'_>,
        part: UVec2,
    ) -> Result<Layer, ViewError> {
        let shift_px = query.shift_px + part.as_dvec2() / f64::from(query.fineness);
        if query.surfaces.is_nearest() && shift_px == DVec2::ZERO {
            return Ok(self.pinhole(frame));
        }
        let Source::Scene(source) = &self.source else { return Err(ViewError::ImageHasNo("hidden surfaces")) };
        let shot = Shot {
            projection: &self.projection,
            clip_from_view: moved(&self.projection, shift_px),
            shading_eye_m: DVec2::ZERO,
            query: query.surfaces,
            below_texels: query.fineness,
            below_part: part,
        };
        Ok(source.draw(frame, label, &shot))
    }
}

/// A layer of `size` texels that nothing is in yet.
pub(super) fn empty(frame: &mut Frame<'_>, size: UVec2) -> Layer {
    Layer { color: frame.texture("fine colour", size, COLOR), depth: frame.texture("fine depth", size, STORED_DEPTH) }
}

/// Puts `drawn` into `layer`, which has some texels for each of its: into the one that
/// `part` counts to from the left and from above.
pub(super) fn weave(frame: &mut Frame<'_>, drawn: &Layer, layer: &Layer, part: UVec2) {
    let fineness = layer.color.size().x / drawn.color.size().x;
    frame
        .pass(&SHADER, "weave")
        .uniform("weaving", &Weave { fineness, part: part.to_array(), ..Default::default() })
        .texture("color", &drawn.color)
        .texture("depth", &drawn.depth)
        .texture("fine_color", &layer.color)
        .texture("fine_depth", &layer.depth)
        .dispatch(drawn.color.size());
}

/// The pinhole's projection with pixels sampled `shift_px` to the right of and below their
/// centres.
fn moved(projection: &Projection, shift_px: DVec2) -> Mat4 {
    // x_clip grows by shift * w, and w = -z; y points up in clip space.
    let shift_ndc = (2.0 * shift_px / projection.outer_size().as_dvec2()).as_vec2();
    let mut clip_from_view = projection.clip_from_view(&Lens::PINHOLE, DVec2::ZERO);
    clip_from_view.z_axis.x += shift_ndc.x;
    clip_from_view.z_axis.y -= shift_ndc.y;
    clip_from_view
}
