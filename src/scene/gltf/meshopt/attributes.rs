//! Mode 0: attributes as byte-wise differences of consecutive elements.

use super::Stream;

/// First byte of a stream of version 0.
const HEADER: u8 = 0xa0;

/// Elements whose differences are encoded alike.
const GROUP: usize = 16;

/// Least bytes of the tail, whose last bytes are the baseline element.
const MIN_TAIL_BYTES: usize = 32;

/// `count` elements of `stride` bytes; `None` for a damaged stream.
pub(super) fn decode(stream: &mut Stream, stride: usize, count: usize) -> Option<Vec<u8>> {
    if stream.byte()? != HEADER {
        return None;
    }
    let tail_bytes = stride.max(MIN_TAIL_BYTES);
    let tail_at = stream.rest.len().checked_sub(tail_bytes)?;
    let (blocks, tail) = stream.rest.split_at(tail_at);
    stream.rest = blocks;
    let mut previous = tail[tail_bytes - stride..].to_vec();

    let most = ((8192 / stride) & !(GROUP - 1)).min(256);
    let mut decoded = vec![0; count * stride];
    for block in decoded.chunks_mut(most * stride) {
        for (k, previous) in previous.iter_mut().enumerate() {
            let elements = block.len() / stride;
            let differences = data_block(stream, elements.div_ceil(GROUP))?;
            for (element, difference) in block.chunks_exact_mut(stride).zip(differences) {
                *previous = previous.wrapping_add(unzigzag(difference));
                element[k] = *previous;
            }
        }
    }
    // What is left over would have to be known to someone.
    stream.rest.is_empty().then_some(decoded)
}

/// The differences of one byte of all elements of a block, still zigzag-encoded.
fn data_block(stream: &mut Stream, groups: usize) -> Option<Vec<u8>> {
    let modes = stream.take(groups.div_ceil(4))?;
    let mut all = Vec::with_capacity(groups * GROUP);
    for group in 0..groups {
        match (modes[group / 4] >> (2 * (group % 4))) & 3 {
            0 => all.extend([0; GROUP]),
            1 => sentinels::<2>(stream, &mut all)?,
            2 => sentinels::<4>(stream, &mut all)?,
            _ => all.extend(stream.take(GROUP)?),
        }
    }
    Some(all)
}

/// Sixteen differences of `BITS` bits each, the first in a byte's highest bits; one with all
/// bits set is a byte of its own behind them.
fn sentinels<const BITS: usize>(stream: &mut Stream, all: &mut Vec<u8>) -> Option<()> {
    let packed = stream.take(GROUP * BITS / 8)?;
    let per_byte = 8 / BITS;
    let sentinel = (1_u8 << BITS) - 1;
    for i in 0..GROUP {
        let shift = 8 - BITS * (i % per_byte + 1);
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
