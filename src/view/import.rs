//! Pinhole images that another program has drawn, on its own device.

use super::{Layer, Repaired, View, ViewError};
use crate::gpu::{Frame, Shader, Texture};
use crate::{shader, uniform};

const SHADER: Shader = shader!("import");

/// What the values of a depth buffer mean: how they follow from the depth d along the
/// optical axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DepthConvention {
    /// `near / d`: 1 at the near plane, 0 at infinity.
    ReversedInfinite,
    /// 1 at the near plane, 0 at the far plane.
    Reversed {
        /// Distance of the far plane, metres.
        far_m: f64,
    },
    /// `1 - near / d`: 0 at the near plane, 1 at infinity.
    ConventionalInfinite,
    /// 0 at the near plane, 1 at the far plane (Vulkan, Direct3D and Metal; WebGPU too).
    Conventional {
        /// Distance of the far plane, metres.
        far_m: f64,
    },
}

impl DepthConvention {
    /// Offset and scale with which `offset + scale * value` is the stored depth near / d.
    pub(crate) fn stored_from_value(self, near_m: f64) -> (f64, f64) {
        match self {
            Self::ReversedInfinite => (0.0, 1.0),
            Self::ConventionalInfinite => (1.0, -1.0),
            Self::Reversed { far_m } => (near_m / far_m, 1.0 - near_m / far_m),
            Self::Conventional { far_m } => (1.0, near_m / far_m - 1.0),
        }
    }
}

/// A frame that another program has drawn through a pinhole.
#[derive(Clone, Copy, Debug)]
pub struct ExternalFrame<'a> {
    /// Linear colour: any float, unorm or sRGB format that can be sampled, usable as
    /// `TEXTURE_BINDING`.
    pub color: &'a wgpu::Texture,
    /// Depth: a depth format or R32Float, usable as `TEXTURE_BINDING`, of the same size.
    pub depth: &'a wgpu::Texture,
    /// What its values mean.
    pub convention: DepthConvention,
    /// Distance of the near plane, metres.
    pub near_m: f64,
    /// Full vertical field of view, radians.
    pub fov_y: f64,
}

uniform! {
    struct Import {
        offset: f32,
        scale: f32,
    }
}

impl View {
    /// A view of a frame that another program has drawn with the same device.
    ///
    /// Pixels that are not numbers do not spread: such a colour becomes black, such a depth
    /// infinite, and [`View::repaired_pixels`] counts them.
    ///
    /// # Errors
    ///
    /// Textures of different sizes, a size that the adapter cannot handle, a near plane
    /// that is not positive.
    pub fn of_external(frame: &mut Frame<'_>, external: &ExternalFrame<'_>) -> Result<Self, ViewError> {
        let [color, depth] = [external.color, external.depth].map(|t| Texture::external(t.clone()));
        if color.size() != depth.size() {
            return Err(ViewError::External("colour and depth differ in size: hand over textures of one size"));
        }
        if !(external.near_m > 0.0 && external.near_m.is_finite()) {
            return Err(ViewError::External("the near plane must lie at a positive distance"));
        }
        super::check_size(frame.gpu(), color.size(), 0)?;
        let (offset, scale) = external.convention.stored_from_value(external.near_m);
        let import = Import { offset: offset as f32, scale: scale as f32 };
        let layer = Layer {
            color: frame.texture("imported colour", color.size(), wgpu::TextureFormat::Rgba16Float),
            depth: frame.texture("imported depth", color.size(), wgpu::TextureFormat::R32Float),
        };
        let repaired = frame.gpu().buffer("repaired pixels", 4);
        let pass = if depth.format().is_depth_stencil_format() {
            frame.pass(&SHADER, "import_depth_buffer").texture("depth_buffer", &depth)
        } else {
            frame.pass(&SHADER, "import_plane").texture("depth", &depth)
        };
        pass.uniform("import_", &import)
            .texture("color", &color)
            .texture("color_out", &layer.color)
            .texture("depth_out", &layer.depth)
            .buffer("repaired", &repaired)
            .dispatch(color.size());
        let view = Self::of_layer(layer, external.near_m, external.fov_y);
        Ok(Self { repaired: Repaired::OnGpu(repaired), ..view })
    }

    /// Makes this the view of another frame, such as the next one of the same program: what
    /// [`View::set_depth_range_m`] promised goes on to hold.
    ///
    /// # Errors
    ///
    /// Those of [`View::of_external`]; then the view stays what it was.
    pub fn set_external(&mut self, frame: &mut Frame<'_>, external: &ExternalFrame<'_>) -> Result<(), ViewError> {
        let next = Self::of_external(frame, external)?;
        let before = std::mem::replace(self, next);
        self.keep_promises_of(&before);
        Ok(())
    }
}
