//! Layers of surfaces, and which surfaces a layer holds.

use super::pipelines::EnvironmentUniform;
use crate::gpu::{Buffer, Texture};

/// A layer of surfaces as images of the outer (overscanned) size.
#[derive(Clone, Debug)]
pub struct Layer {
    /// RGBA16F: linear radiance, alpha 1 where the layer has a surface (or the background)
    /// and 0 elsewhere.
    pub color: Texture,
    /// R32F: stored depth z = near / d, 0 where there is nothing or the background.
    pub depth: Texture,
}

/// A layer of surfaces with what they are made of, as images of the outer size; all RGBA16F but
/// `depth`, all 0 where the layer has no surface.
#[derive(Clone, Debug)]
pub struct SurfaceLayer {
    /// As [`Layer::color`]: what the centre of the lens sees.
    pub color: Texture,
    /// As [`Layer::depth`].
    pub depth: Texture,
    /// Base colour; alpha is the roughness.
    pub base_roughness: Texture,
    /// Shading normal in view space, 0 where light plays no part; alpha is the metalness.
    pub normal_metallic: Texture,
}

/// What `shaders/lib/shading.wgsl` needs beside a surface.
#[derive(Clone, Debug)]
pub struct Shading {
    /// `Environment` there.
    pub environment: EnvironmentUniform,
    /// A storage array of `Light`.
    pub lights: Buffer,
}

/// Which surfaces a layer holds: per pixel, the nearest that satisfies both bounds.
#[derive(Clone, Copy, Debug)]
pub struct LayerQuery<'a> {
    /// Greatest stored depth z in the layer: 1 is the near plane.
    pub z_near: f32,
    /// Least stored depth z: 0 is infinity, with the background.
    pub z_far: f32,
    /// R32F of the outer size: the layer holds what has z *below* this, per pixel; a value
    /// of 0 or less holds nothing.
    pub below: Option<&'a Texture>,
}

impl LayerQuery<'_> {
    /// Everything: the pinhole image.
    pub const NEAREST: LayerQuery<'static> = LayerQuery { z_near: 1.0, z_far: 0.0, below: None };

    pub(super) fn is_nearest(&self) -> bool {
        self.z_near >= 1.0 && self.z_far <= 0.0 && self.below.is_none()
    }
}
