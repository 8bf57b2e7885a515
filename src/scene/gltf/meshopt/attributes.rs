//! Mode 0: attributes as differences of consecutive elements.
//!
//! Version 0 (EXT_meshopt_compression) has the differences of single bytes; version 1
//! (KHR_meshopt_compression) also those of words of 16 bits and the exclusive or of words of 32,
//! bytes that do not change at all, and differences of one bit.

use super::Stream;

/// The header's upper half; the version is the lower.
const HEADER: u8 = 0xa0;

/// Elements whose differences are encoded alike.
const GROUP: usize = 16;

/// Least bytes of the tail of either version, whose last bytes are the baseline element.
const MIN_TAIL_BYTES: [usize; 2] = [32, 24];

/// Bits of a difference by a group's mode: of version 0, and of the two kinds of version 1.
const BITS: [[usize; 4]; 3] = [[0, 2, 4, 8], [0, 1, 2, 4], [1, 2, 4, 8]];

/// `count` elements of `stride` bytes, a multiple of 4; `None` for a damaged stream.
pub(super) fn decode(stream: &mut Stream, stride: usize, count: usize) -> Option<Vec<u8>> {
    let version = usize::from(stream.byte()? ^ HEADER);
    let channel_bytes = if version == 0 { 0 } else { stride / 4 };
    let tail_bytes = (stride + channel_bytes).max(*MIN_TAIL_BYTES.get(version)?);
    let tail_at = stream.rest.len().checked_sub(tail_bytes)?;
    let (blocks, tail) = stream.rest.split_at(tail_at);
    stream.rest = blocks;
    let (baseline, channels) = tail[tail_bytes - stride - channel_bytes..].split_at(stride);
    let mut previous = baseline.to_vec();

    let most = ((8192 / stride) & !(GROUP - 1)).min(256);
    let mut decoded = vec![0; count * stride];
    for block in decoded.chunks_mut(most * stride) {
        let elements = block.len() / stride;
        let controls = stream.take(channel_bytes)?;
        for (word, previous) in previous.as_chunks_mut::<4>().0.iter_mut().enumerate() {
            let control = controls.get(word).copied();
            let mut codes: [Vec<u8>; 4] = Default::default();
            for (byte, codes) in codes.iter_mut().enumerate() {
                *codes = byte_codes(stream, control.map(|control| (control >> (2 * byte)) & 3), elements)?;
            }
            let channel = channels.get(word).copied().unwrap_or(0);
            for (i, element) in block.chunks_exact_mut(stride).enumerate() {
                let code = [0, 1, 2, 3].map(|byte: usize| codes[byte][i]);
                *previous = next(*previous, code, channel)?;
                element[word * 4..word * 4 + 4].copy_from_slice(previous);
            }
        }
    }
    // What is left over would have to be known to someone.
    stream.rest.is_empty().then_some(decoded)
}

/// The codes of one byte of all elements of a block, by its control of version 1.
fn byte_codes(stream: &mut Stream, control: Option<u8>, elements: usize) -> Option<Vec<u8>> {
    let groups = elements.div_ceil(GROUP);
    match control {
        None => grouped(stream, groups, BITS[0]),
        Some(0) => grouped(stream, groups, BITS[1]),
        Some(1) => grouped(stream, groups, BITS[2]),
        Some(2) => Some(vec![0; elements]),
        Some(_) => stream.take(elements).map(<[u8]>::to_vec),
    }
}

/// Four bytes of an element from those of the one before and their codes.
fn next(previous: [u8; 4], code: [u8; 4], channel: u8) -> Option<[u8; 4]> {
    match channel & 3 {
        0 => Some([0, 1, 2, 3].map(|k: usize| previous[k].wrapping_add(unzigzag(code[k])))),
        1 => {
            let half = |k: usize| {
                let code = u16::from_le_bytes([code[k], code[k + 1]]);
                let difference = (code >> 1) ^ (code & 1).wrapping_neg();
                u16::from_le_bytes([previous[k], previous[k + 1]]).wrapping_add(difference).to_le_bytes()
            };
            let ([a, b], [c, d]) = (half(0), half(2));
            Some([a, b, c, d])
        }
        2 => {
            let rotated = u32::from_le_bytes(code).rotate_right(u32::from(channel >> 4));
            Some((u32::from_le_bytes(previous) ^ rotated).to_le_bytes())
        }
        _ => None,
    }
}

/// Codes in groups, each of a number of bits by its mode.
fn grouped(stream: &mut Stream, groups: usize, bits: [usize; 4]) -> Option<Vec<u8>> {
    let modes = stream.take(groups.div_ceil(4))?;
    let mut all = Vec::with_capacity(groups * GROUP);
    for group in 0..groups {
        match bits[usize::from((modes[group / 4] >> (2 * (group % 4))) & 3)] {
            0 => all.extend([0; GROUP]),
            1 => sentinels::<1>(stream, &mut all)?,
            2 => sentinels::<2>(stream, &mut all)?,
            4 => sentinels::<4>(stream, &mut all)?,
            _ => all.extend(stream.take(GROUP)?),
        }
    }
    Some(all)
}

/// Sixteen codes of `BITS` bits each, the first in a byte's highest bits, or in its lowest where
/// they are single bits; one with all bits set is a byte of its own behind them.
fn sentinels<const BITS: usize>(stream: &mut Stream, all: &mut Vec<u8>) -> Option<()> {
    let packed = stream.take(GROUP * BITS / 8)?;
    let per_byte = 8 / BITS;
    let sentinel = (1_u8 << BITS) - 1;
    for i in 0..GROUP {
        let shift = if BITS == 1 { i % 8 } else { 8 - BITS * (i % per_byte + 1) };
        let code = (packed[i / per_byte] >> shift) & sentinel;
        all.push(if code == sentinel { stream.byte()? } else { code });
    }
    Some(())
}

fn unzigzag(code: u8) -> u8 {
    if code & 1 == 1 { !(code >> 1) } else { code >> 1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of the specification.
    #[test]
    fn sentinel_encoding_by_its_example() {
        let mut stream = Stream { rest: &[0x17, 0x5f, 0xf0, 0xbc, 0x77, 0xa9, 0x21, 0x00, 0x34, 0xb5] };
        let mut codes = Vec::new();
        sentinels::<4>(&mut stream, &mut codes).expect("whole");
        let differences: Vec<i8> = codes.into_iter().map(|code| unzigzag(code) as i8).collect();
        assert_eq!(differences, [-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0]);
        assert!(stream.rest.is_empty());
    }
}
