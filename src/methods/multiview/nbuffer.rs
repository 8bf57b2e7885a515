//! N-buffers (Decoret, "N-Buffers for efficient depth map query", Eurographics 2005): at
//! full resolution, the nearest depth in a square window at each texel. Four windows make
//! any square up to twice their side, so each slab keeps the one level that its greatest
//! CoC asks for.

use super::slabs::{SLAB_SHADER, Slabs};
use crate::gpu::{Frame, Texture, TextureKey};
use crate::uniform;
use crate::view::View;

/// The N-buffer of a view's slabs.
#[derive(Clone)]
pub(super) struct NBuffer {
    /// The slabs' depth that it was built from.
    depth: Texture,
    sides: Vec<u32>,
    /// R32F array: greatest z over the slab's window right of and below each texel.
    pub nearest: Texture,
}

uniform! {
    struct Level {
        side: u32,
        growing: u32,
    }
}

/// Side, px, of the windows with which four reads make a square of side `square`: the
/// greatest power of two that fits in it.
pub(super) fn window_side(square: u32) -> u32 {
    1 << square.max(1).ilog2()
}

impl NBuffer {
    /// Windows of `sides[i]` px (powers of two) for slab i, built unless one of the last `most` ones
    /// fits.
    pub fn of(frame: &mut Frame<'_>, view: &mut View, slabs: &Slabs, sides: Vec<u32>, most: usize) -> Self {
        let mut kept: Vec<Self> = view.kept().take().unwrap_or_default();
        kept.retain(|kept| kept.depth.same(&slabs.depth));
        let known = kept.iter().position(|kept| kept.sides == sides);
        let last = match known {
            Some(index) => {
                let known = kept.remove(index);
                frame.skip("N-buffer unchanged");
                frame.expose(format_args!("N-buffer {}", known.sides.iter().max().unwrap_or(&1)), &known.nearest);
                known
            }
            None => {
                kept.truncate(most - 1);
                Self { nearest: build(frame, slabs, &sides), sides, depth: slabs.depth.clone() }
            }
        };
        kept.insert(0, last.clone());
        *view.kept() = Some(kept);
        last
    }
}

fn build(frame: &mut Frame<'_>, slabs: &Slabs, sides: &[u32]) -> Texture {
    let size = slabs.depth.size();
    let key = TextureKey { size, levels: 1, layers: slabs.depth.layers(), format: wgpu::TextureFormat::R32Float };
    let widest = sides.iter().copied().max().unwrap_or(1);
    let mut nearest = slabs.depth.clone();
    let mut side = 1;
    while side < widest {
        let wider = frame.gpu().texture_of("N-buffer", key);
        let growing = sides.iter().enumerate().map(|(i, &s)| u32::from(s > side) << i).sum();
        frame
            .pass(&SLAB_SHADER, "widen_windows")
            .label(format_args!("N-buffer {}", 2 * side))
            .uniform("level", &Level { side, growing })
            .texture("narrower", &nearest)
            .texture("wider", &wider)
            .dispatch_groups(size.x.div_ceil(8), size.y.div_ceil(8), sides.len() as u32);
        nearest = wider;
        side *= 2;
        frame.expose(format_args!("N-buffer {side}"), &nearest);
    }
    nearest
}
