//! Layers with several texels a pixel on each side.
//!
//! Lens rays end between the centres of pixels. What is there is drawn as a view from off
//! the lens's centre would draw it: textures are read over the footprint of a pixel, not over
//! that of a texel, or it would be another picture of them.

use super::pipelines::{COLOR, STORED_DEPTH};
use super::raster::Shot;
use super::{Layer, LayerQuery, Source, View, ViewError, check_size};
use crate::camera::Projection;
use crate::gpu::{Frame, Gpu};
use crate::lens::Lens;
use crate::{shader, uniform};
use glam::{DVec2, Mat4, UVec2};

const SHADER: crate::gpu::Shader = shader!("fine");

uniform! {
    struct Interleave {
        texels_a_side: u32,
        _pad: u32,
        part: [u32; 2],
    }
}

/// How layers of several texels a pixel are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FineDrawing {
    /// In one draw of the layer's size, with derivatives of texture coordinates as large as those
    /// over pixels: what hardware is best at.
    AtOnce,
    /// In one draw of the pinhole's size for each texel of a pixel. llvmpipe filters
    /// anisotropically over the derivatives that it finds itself, whatever a shader says
    /// (Mesa 22.3, `lp_build_pmin`), and so draws other pictures at once.
    Interleaved,
}

impl FineDrawing {
    /// What is right on the adapter.
    pub fn of(gpu: &Gpu) -> Self {
        if gpu.is_software() { Self::Interleaved } else { Self::AtOnce }
    }

    /// Whether samples of the first layer are staggered: a draw at once has a regular grid.
    pub(super) fn staggers(self) -> bool {
        self == Self::Interleaved
    }
}

/// How far samples lie to the right of and below their places in a regular grid of `a_side` a pixel,
/// samples, by their row and column: `stagger_of` in `shaders/lib/staggered.wgsl`. An edge along a row
/// or column is then known to a sample's share of a pixel, not to a row's: to 1/16 px with 4x4 samples.
/// Chiu, Shirley and Wang, "Multi-jittered sampling", Graphics Gems IV (1994).
fn stagger(part: UVec2, a_side: u32) -> DVec2 {
    let of = |line: u32| {
        f64::from(if line.is_multiple_of(2) { line / 2 } else { a_side - 1 - line / 2 }) / f64::from(a_side)
    };
    DVec2::new(of(part.y), of(part.x))
}

impl View {
    /// A layer of `texels_a_side` texels a pixel on each side: texel `texels_a_side * i` is the
    /// sample at the centre of pixel i, and `below` has as many. Errors if it exceeds the
    /// adapter's texture size, and for more than the pinhole image of an image.
    pub(super) fn fine_layer(
        &mut self,
        frame: &mut Frame<'_>,
        label: &str,
        texels_a_side: u32,
        surfaces: LayerQuery<'_>,
    ) -> Result<Layer, ViewError> {
        self.draw_fine(frame, label, texels_a_side, surfaces, false)
    }

    /// The nearest surfaces at `a_side` samples a pixel on each side, staggered where the way of
    /// drawing can: see [`fine_layer`](Self::fine_layer).
    pub(super) fn fine_samples(&mut self, frame: &mut Frame<'_>, a_side: u32) -> Result<Layer, ViewError> {
        self.draw_fine(frame, "samples", a_side, LayerQuery::NEAREST, true)
    }

    /// How fine layers are drawn.
    pub(super) fn fine_drawing(&self, gpu: &Gpu) -> FineDrawing {
        self.fine_drawing.unwrap_or(FineDrawing::of(gpu))
    }

    fn draw_fine(
        &mut self,
        frame: &mut Frame<'_>,
        label: &str,
        texels_a_side: u32,
        surfaces: LayerQuery<'_>,
        staggered: bool,
    ) -> Result<Layer, ViewError> {
        if texels_a_side == 1 && surfaces.is_nearest() {
            return Ok(self.pinhole(frame));
        }
        let Projection { size, overscan_px, .. } = self.projection;
        check_size(frame.gpu(), size * texels_a_side, overscan_px * texels_a_side)?;
        match self.fine_drawing(frame.gpu()) {
            FineDrawing::AtOnce => {
                // Of the texels of a pixel the first has its centre at the pixel's.
                let shift_px = DVec2::splat(0.5 - 0.5 / f64::from(texels_a_side));
                let shot = Shot { texels_a_side, ..self.moved_shot(surfaces, shift_px) };
                Ok(self.scene_source()?.draw(frame, label, &shot))
            }
            FineDrawing::Interleaved => {
                let layer = empty(frame, self.projection.outer_size() * texels_a_side);
                for index in 0..texels_a_side * texels_a_side {
                    let part = UVec2::new(index % texels_a_side, index / texels_a_side);
                    let off = if staggered { stagger(part, texels_a_side) } else { DVec2::ZERO };
                    let shift_px = (part.as_dvec2() + off) / f64::from(texels_a_side);
                    let drawn = self.fine_part(frame, label, (texels_a_side, part), shift_px, surfaces)?;
                    interleave(frame, &drawn, &layer, part);
                }
                Ok(layer)
            }
        }
    }

    /// One texel of each pixel, `shift_px` to the right of and below its centre.
    fn fine_part(
        &mut self,
        frame: &mut Frame<'_>,
        label: &str,
        (texels_a_side, part): (u32, UVec2),
        shift_px: DVec2,
        surfaces: LayerQuery<'_>,
    ) -> Result<Layer, ViewError> {
        if surfaces.is_nearest() && part == UVec2::ZERO {
            return Ok(self.pinhole(frame));
        }
        let shot = Shot { below_texels: texels_a_side, below_part: part, ..self.moved_shot(surfaces, shift_px) };
        Ok(self.scene_source()?.draw(frame, label, &shot))
    }

    fn scene_source(&self) -> Result<&super::raster::SceneSource, ViewError> {
        match &self.source {
            Source::Scene(source) => Ok(source),
            Source::Image(_) => Err(ViewError::ImageHasNo("hidden surfaces")),
        }
    }

    fn moved_shot<'a>(&'a self, surfaces: LayerQuery<'a>, shift_px: DVec2) -> Shot<'a> {
        Shot::new(&self.projection, moved(&self.projection, shift_px), DVec2::ZERO, surfaces)
    }
}

/// A layer of `size` texels that nothing is in yet.
pub(super) fn empty(frame: &mut Frame<'_>, size: UVec2) -> Layer {
    Layer { color: frame.texture("fine colour", size, COLOR), depth: frame.texture("fine depth", size, STORED_DEPTH) }
}

/// Puts `drawn` into `layer`, which has some texels for each of its: into the one that
/// `part` counts to from the left and from above.
fn interleave(frame: &mut Frame<'_>, drawn: &Layer, layer: &Layer, part: UVec2) {
    let texels_a_side = layer.color.size().x / drawn.color.size().x;
    frame
        .pass(&SHADER, "interleave")
        .uniform("interleaving", &Interleave { texels_a_side, part: part.to_array(), ..Default::default() })
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
