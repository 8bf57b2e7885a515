// Thresholds of stochastic transparency (Enderton, Sintorn, Shirley and Luebke, "Stochastic
// Transparency", I3D 2010): a surface of coverage q is there where q is above its threshold.
//
// The thresholds of one pixel and surface are stratified over the lens points: any 2^k points
// from a multiple of 2^k on have one in each 2^-k of [0, 1). Those of different surfaces and
// pixels come in another order and are independent, so that the transmittances of surfaces behind
// one another multiply: Burley, "Practical Hash-Based Owen Scrambling" (JCGT 2020).

#import hash

/// A permutation of 32-bit numbers in which a bit depends on lower ones only.
fn permuted(number: u32, seed: u32) -> u32 {
    var x = number + seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return x;
}

/// Cells of depth, by the number of which surfaces of one mesh are told apart, in a doubling.
const CELLS_AN_OCTAVE = 32.0;

/// The threshold in [0, 1) of a surface at stored depth z for a pixel and a lens point.
fn threshold(pixel: vec2u, surface: u32, z: f32, lens_point: u32) -> f32 {
    let cell = u32(i32(floor(CELLS_AN_OCTAVE * log2(max(z, 1e-30)))) + 4096);
    let seed = hash(pixel.x + hash(pixel.y + hash(surface + hash(cell))));
    let shuffled = permuted(reverseBits(lens_point), seed);
    let scrambled = reverseBits(permuted(reverseBits(shuffled), hash(seed)));
    return f32(scrambled >> 8u) / 16777216.0;
}
