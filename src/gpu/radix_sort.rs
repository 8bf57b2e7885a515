//! Sorting on the GPU.

use super::{Buffer, Frame, Shader};
use crate::{shader, uniform};

const SHADER: Shader = shader!("radix_sort");

/// Bits sorted by at once; digits times tiles are counted.
const DIGIT_BITS: u32 = 4;

/// Pairs that one workgroup moves: `PAIRS_PER_TILE` in the shader.
const PAIRS_PER_TILE: u32 = 1024;

uniform! {
    struct Digit {
        len: u32,
        shift: u32,
        tiles: u32,
    }
}

/// Sorts the first `len` of `keys` (u32) in ascending order in place and moves `values`
/// (u32) along. Stable: pairs of equal keys keep their order.
///
/// Non-negative floats may be keys by their bits, which order as the numbers do. Both
/// buffers need at least `len` elements and the usages of [`super::Gpu::buffer`].
pub fn sort_pairs(frame: &mut Frame<'_>, keys: &Buffer, values: &Buffer, len: u32) {
    if len < 2 {
        return;
    }
    let tiles = len.div_ceil(PAIRS_PER_TILE);
    let gpu = frame.gpu();
    let bytes = u64::from(len) * 4;
    let (other_keys, other_values) = (gpu.scratch("sorted keys", bytes), gpu.scratch("sorted values", bytes));
    let counts = gpu.scratch("digit counts", u64::from(tiles << DIGIT_BITS) * 4);
    let (mut from, mut to) = ((keys, values), (&other_keys, &other_values));
    // An even number of digits: the last move ends where the first one began.
    for shift in (0..u32::BITS).step_by(DIGIT_BITS as usize) {
        let digit = Digit { len, shift, tiles };
        let pass = frame.pass(&SHADER, "count_digits").uniform("digit", &digit);
        pass.buffer("keys", from.0).buffer("counts", &counts).dispatch_groups(tiles, 1, 1);
        let pass = frame.pass(&SHADER, "scan_counts").uniform("digit", &digit);
        pass.buffer("counts", &counts).dispatch_groups(1, 1, 1);
        let pass = frame.pass(&SHADER, "move_pairs").uniform("digit", &digit).buffer("counts", &counts);
        let pass = pass.buffer("keys", from.0).buffer("values", from.1);
        pass.buffer("sorted_keys", to.0).buffer("sorted_values", to.1).dispatch_groups(tiles, 1, 1);
        std::mem::swap(&mut from, &mut to);
    }
}
