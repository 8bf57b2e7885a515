//! An Owen-scrambled Sobol (0,2)-sequence.

use glam::{DVec2, dvec2};

/// Seeds of the two dimensions' scrambling: any two different numbers will do.
const SEEDS: [u32; 2] = [0x9e37_79b9, 0x85eb_ca6b];

/// Point `index` in the open unit square.
pub(super) fn point(index: u32) -> DVec2 {
    // Sobol's first dimension is the van der Corput sequence; as numbers with the binary
    // point on the left it is the index with its bits reversed.
    let x = scramble(index.reverse_bits(), SEEDS[0]);
    let y = scramble(second_dimension(index), SEEDS[1]);
    let unit = |bits: u32| (f64::from(bits) + 0.5) / 4_294_967_296.0;
    dvec2(unit(x), unit(y))
}

/// Sobol's second dimension: the generator matrix is Pascal's triangle modulo 2, whose
/// columns follow from one another by `v ^= v >> 1`.
fn second_dimension(mut index: u32) -> u32 {
    let mut column = 0x8000_0000_u32;
    let mut bits = 0;
    while index != 0 {
        if index & 1 != 0 {
            bits ^= column;
        }
        index >>= 1;
        column ^= column >> 1;
    }
    bits
}

/// Owen's nested uniform scrambling by the hash of Laine and Karras, as in Burley,
/// "Practical Hash-based Owen Scrambling" (JCGT 2020).
fn scramble(bits: u32, seed: u32) -> u32 {
    let mut x = bits.reverse_bits().wrapping_add(seed);
    for factor in [0x6c50_b47c_u32, 0xb82f_1e52, 0xc7af_e638, 0x8d22_f6e6] {
        x ^= x.wrapping_mul(factor);
    }
    x.reverse_bits()
}
