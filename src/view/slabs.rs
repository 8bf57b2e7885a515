//! Many slabs of depth in two draws of the scene.
//!
//! A depth buffer knows one surface a pixel, so a draw with one makes one slab. Here the first
//! draw finds the nearest surface of every slab by atomic maxima, and the second shades, of
//! all surfaces, those that were found, each into its slab's layer of an array. Where two
//! surfaces lie at exactly the same depth, either may be shown.

use super::pipelines::LayerKind;
use super::{LayerQuery, Source, View, ViewError};
use crate::gpu::{Buffer, Frame, Resource, Texture};
use crate::uniform;
use glam::UVec2;

/// Most slabs that are drawn at once.
pub const MAX_SLABS_AT_ONCE: usize = 16;

uniform! {
    struct SlabDraw {
        ranges: [[f32; 4]; MAX_SLABS_AT_ONCE],
        size: [u32; 2],
        padding: [u32; 2],
        first: u32,
        count: u32,
        _unused: [u32; 2],
    }
}

/// Slabs that are drawn at once.
#[derive(Clone, Copy, Debug)]
pub struct SlabShot<'a> {
    /// Greatest and least stored depth of each, both included; a least one of 0 takes the
    /// background. From near to far, so that both fall. At most [`MAX_SLABS_AT_ONCE`].
    pub ranges: &'a [[f32; 2]],
    /// Layer of the arrays that the first one has.
    pub first: u32,
    /// Size of the arrays, texels.
    pub size: UVec2,
    /// Texels left of and above the outer frame in them.
    pub padding: UVec2,
}

/// RGBA16F arrays with a layer for each slab; level 0 is written where there is a surface.
#[derive(Clone, Copy, Debug)]
pub struct SlabArrays<'a> {
    /// Radiance towards the lens's centre, and 1.
    pub color: &'a Texture,
    /// Base colour and roughness; normal and metalness.
    pub surfaces: Option<[&'a Texture; 2]>,
}

impl SlabShot<'_> {
    fn uniform(&self) -> SlabDraw {
        let mut ranges = [[0.0; 4]; MAX_SLABS_AT_ONCE];
        for (of_shader, [near, far]) in ranges.iter_mut().zip(self.ranges) {
            *of_shader = [*near, *far, 0.0, 0.0];
        }
        SlabDraw {
            ranges,
            size: self.size.to_array(),
            padding: self.padding.to_array(),
            first: self.first,
            count: self.ranges.len().min(MAX_SLABS_AT_ONCE) as u32,
            _unused: [0; 2],
        }
    }

    /// What holds all of them.
    fn query(&self) -> LayerQuery<'static> {
        let z_near = self.ranges.iter().map(|range| range[0]).fold(0.0, f32::max);
        let z_far = self.ranges.iter().map(|range| range[1]).fold(1.0, f32::min);
        LayerQuery { z_near, z_far, below: None }
    }
}

impl View {
    /// Writes to `nearest`, a u32 for each texel of each slab of the shot, that held 0, the
    /// bits of the greatest stored depth in the slab plus 1. Errors for an image.
    pub(crate) fn draw_slab_depths(
        &mut self,
        frame: &mut Frame<'_>,
        shot: &SlabShot<'_>,
        nearest: &Buffer,
    ) -> Result<(), ViewError> {
        let nearest = frame.used(nearest);
        self.draw_slabs(frame, "slab depths", shot, LayerKind::SlabDepths, vec![nearest])
    }

    /// Writes what surfaces at `depths` show to the slabs' layers, R32F array: stored depth of
    /// each slab, less than 0 where it is empty. Errors for an image.
    pub(crate) fn draw_slab_surfaces(
        &mut self,
        frame: &mut Frame<'_>,
        shot: &SlabShot<'_>,
        depths: &Texture,
        arrays: &SlabArrays<'_>,
    ) -> Result<(), ViewError> {
        let level = |texture: &Texture| Resource::View(texture.level_view(0).clone());
        let mut bound = vec![level(depths), level(arrays.color)];
        bound.extend(arrays.surfaces.iter().flatten().map(|array| level(array)));
        let kind = if arrays.surfaces.is_some() { LayerKind::SlabSurfaces } else { LayerKind::Slabs };
        self.draw_slabs(frame, "slab surfaces", shot, kind, bound)
    }

    fn draw_slabs(
        &mut self,
        frame: &mut Frame<'_>,
        label: &str,
        shot: &SlabShot<'_>,
        kind: LayerKind,
        mut bound: Vec<Resource>,
    ) -> Result<(), ViewError> {
        let Source::Scene(source) = &self.source else { return Err(ViewError::ImageHasNo("hidden surfaces")) };
        bound.insert(0, frame.uniform(&shot.uniform()));
        source.draw_slabs(frame, label, &self.pinhole_shot(shot.query()), kind, &bound);
        Ok(())
    }
}
