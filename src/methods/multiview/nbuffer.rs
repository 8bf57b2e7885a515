//! N-buffers (Decoret, "N-Buffers for efficient depth map query", Eurographics 2005): for each
//! slab the nearest depth in square windows of 1, 2, 4 ... blocks of texels at each block. Four
//! windows make any square up to twice their side. No lens has a part in them.

use super::slabs::{SLAB_SHADER, Slabs};
use crate::gpu::{Buffer, Frame, Pass, Texture, TextureKey};
use crate::uniform;
use crate::view::View;
use glam::UVec2;

/// Side of a block, px, unless there are too many of them: that of a tile of rays.
const BLOCK_PX: u32 = 8;

/// The N-buffer of a view's slabs.
#[derive(Clone)]
pub(super) struct NBuffer {
    /// The slabs' depth that it was built from.
    depth: Texture,
    /// Side of a block, px, a power of two.
    pub block_px: u32,
    /// Blocks along x and y.
    pub blocks: UVec2,
    slabs: u32,
    /// By level, slab and block: greatest z in the window of 2^level blocks right of and below
    /// the block, less than 0 where there is nothing.
    pub nearest: Buffer,
}

uniform! {
    struct Level {
        blocks: [u32; 2],
        block_px: u32,
        slab_count: u32,
        level: u32,
        _unused: u32,
    }
}

impl NBuffer {
    /// That of `slabs`, built unless the view's last one is.
    pub fn of(frame: &mut Frame<'_>, view: &mut View, slabs: &Slabs) -> Self {
        let known = view.kept::<Self>().clone().filter(|known| known.depth.same(&slabs.depth));
        let n_buffer = match known {
            Some(known) => {
                frame.skip("N-buffer unchanged");
                known
            }
            None => {
                let n_buffer = Self::sized(frame, slabs);
                n_buffer.build(frame);
                *view.kept() = Some(n_buffer.clone());
                n_buffer
            }
        };
        n_buffer.expose(frame);
        n_buffer
    }

    fn sized(frame: &Frame<'_>, slabs: &Slabs) -> Self {
        let size = slabs.depth.size();
        let count = slabs.ranges.len() as u32;
        let gpu = frame.gpu();
        let mut block_px = BLOCK_PX;
        while bytes(size, block_px, count) > gpu.largest_binding_bytes() {
            block_px *= 2;
        }
        let nearest = gpu.scratch("N-buffer", bytes(size, block_px, count));
        Self { depth: slabs.depth.clone(), block_px, blocks: blocks(size, block_px), slabs: count, nearest }
    }

    fn build(&self, frame: &mut Frame<'_>) {
        let first = frame.pass(&SLAB_SHADER, "find_nearest").texture("slab_depths", &self.depth);
        self.bind(first, 0).dispatch_layers(self.blocks, self.slabs);
        for level in 1..levels(self.blocks) {
            let pass = frame.pass(&SLAB_SHADER, "widen_windows").label(format_args!("N-buffer {}", 1 << level));
            self.bind(pass, level).dispatch_layers(self.blocks, self.slabs);
        }
    }

    fn bind<'f, 'g>(&self, pass: Pass<'f, 'g>, level: u32) -> Pass<'f, 'g> {
        let level = Level {
            blocks: self.blocks.to_array(),
            block_px: self.block_px,
            slab_count: self.slabs,
            level,
            _unused: 0,
        };
        pass.uniform("level", &level).buffer("n_buffer", &self.nearest)
    }

    /// Debug images of the levels, a texel a block.
    fn expose(&self, frame: &mut Frame<'_>) {
        if !frame.keeps_intermediates() {
            return;
        }
        let key = TextureKey {
            size: self.blocks,
            levels: 1,
            layers: self.depth.layers(),
            format: wgpu::TextureFormat::R32Float,
        };
        for level in 0..levels(self.blocks) {
            let shown = frame.gpu().texture_of("N-buffer", key);
            let pass = frame.pass(&SLAB_SHADER, "show_windows").texture("shown", &shown);
            self.bind(pass, level).dispatch_layers(self.blocks, self.slabs);
            frame.expose(format_args!("N-buffer {}", 1 << level), &shown);
        }
    }
}

fn blocks(size: UVec2, block_px: u32) -> UVec2 {
    size.map(|side| side.div_ceil(block_px))
}

/// Levels up to the one whose windows, four of them, make all of the image.
fn levels(blocks: UVec2) -> u32 {
    blocks.max_element().ilog2() + 1
}

fn bytes(size: UVec2, block_px: u32, slabs: u32) -> u64 {
    let blocks = blocks(size, block_px);
    4 * u64::from(levels(blocks)) * u64::from(slabs.max(1)) * u64::from(blocks.x) * u64::from(blocks.y)
}
