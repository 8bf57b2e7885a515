//! Where the texels of the pyramids lie.

use crate::gpu::TextureKey;
use glam::UVec2;

/// The pyramids' frame: the image, padded to an even number of texels of the coarsest level and
/// centred in it. A mirrored image has the mirrored pyramid, and the texels of a level lie alike however
/// many levels there are: the image's centre is a border of texels on all of them.
pub(super) struct PyramidGrid {
    /// Number of levels, from the paper's level 1 on.
    pub(super) levels: u32,
    /// Size of level 1, texels.
    pub(super) size: UVec2,
    /// Level-0 texels left of and above the image.
    pub(super) padding: UVec2,
}

impl PyramidGrid {
    pub(super) fn new(image: UVec2, levels: u32) -> Self {
        let padded = image.map(|side| side.next_multiple_of(2 << levels));
        Self { levels, size: padded / 2, padding: (padded - image) / 2 }
    }

    pub(super) fn level_size(&self, level: u32) -> UVec2 {
        (self.size >> level).max(UVec2::ONE)
    }

    pub(super) fn key(&self, layers: u32, format: wgpu::TextureFormat) -> TextureKey {
        TextureKey { size: self.size, levels: self.levels, layers, format }
    }
}
