//! What draws write to.

/// How fragments are blended with the target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Blend {
    /// They replace it.
    Replace,
    /// They are added to it.
    Add,
    /// Premultiplied "over": `source + (1 - source alpha) * target`.
    Over,
}

/// Format and blending of a render target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Target {
    /// Texel format.
    pub format: wgpu::TextureFormat,
    /// How fragments are blended with the target.
    pub blend: Blend,
}

impl Target {
    pub(in crate::gpu) fn state(self) -> wgpu::ColorTargetState {
        let blend = match self.blend {
            Blend::Replace => None,
            Blend::Add => {
                let one = wgpu::BlendFactor::One;
                let operation = wgpu::BlendOperation::Add;
                let add = wgpu::BlendComponent { src_factor: one, dst_factor: one, operation };
                Some(wgpu::BlendState { color: add, alpha: add })
            }
            Blend::Over => Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
        };
        wgpu::ColorTargetState { format: self.format, blend, write_mask: wgpu::ColorWrites::ALL }
    }
}

pub(crate) fn attachment(
    view: &wgpu::TextureView,
    load: wgpu::LoadOp<wgpu::Color>,
) -> wgpu::RenderPassColorAttachment<'_> {
    let ops = wgpu::Operations { load, store: wgpu::StoreOp::Store };
    wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops }
}
