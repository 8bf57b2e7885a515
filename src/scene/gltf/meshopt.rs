//! EXT_meshopt_compression and KHR_meshopt_compression: buffer views decoded from the bitstreams of
//! their appendix A, with the filters of appendix B.
//!
//! Every read is checked, and nothing is allocated that the encoded bytes cannot fill.

mod attributes;
mod filters;
mod indices;

use super::super::error::SceneProblem;
use super::exact::Meshopt;

/// Most bytes that an encoded byte can become: a control of version 1 stands for four bytes of each
/// of up to 256 elements.
const MAX_EXPANSION: usize = 1024;

/// Bytes that any stream may decode to, however short: the baseline of a first block.
const MAX_UNPAID_BYTES: usize = 1 << 16;

/// Most bytes to which so many encoded ones can decode.
pub(super) fn most_decoded_bytes(encoded_bytes: usize) -> usize {
    encoded_bytes.saturating_mul(MAX_EXPANSION).saturating_add(MAX_UNPAID_BYTES)
}

/// Bytes of the encoded stream, taken from the front.
struct Stream<'a> {
    rest: &'a [u8],
}

impl<'a> Stream<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.rest.split_at_checked(count)?;
        self.rest = rest;
        Some(taken)
    }

    fn byte(&mut self) -> Option<u8> {
        self.take(1).map(|bytes| bytes[0])
    }

    /// An unsigned LEB128 number of at most 32 bits.
    fn varint(&mut self) -> Option<u32> {
        let mut value = 0_u32;
        for shift in (0..32).step_by(7) {
            let byte = self.byte()?;
            value |= u32::from(byte & 0x7f).wrapping_shl(shift);
            if byte & 0x80 == 0 {
                return Some(value);
            }
        }
        None
    }
}

/// Decodes a buffer view of `byte_length` bytes, called `item` in errors.
pub(super) fn decode(
    source: &Meshopt,
    encoded: &[u8],
    byte_length: usize,
    item: &str,
) -> Result<Vec<u8>, SceneProblem> {
    let invalid = |detail: String| SceneProblem::invalid(format!("{item}, its compressed data,"), detail);
    let (stride, count) = (source.byte_stride, source.count);
    let size = stride.checked_mul(count).filter(|&size| size == byte_length);
    let Some(size) = size else {
        return Err(invalid(format!("has {count} elements of {stride} bytes for a view of {byte_length} bytes")));
    };
    if size > most_decoded_bytes(encoded.len()) {
        return Err(SceneProblem::OutOfBytes {
            item: item.to_owned(),
            holder: "its compressed data".to_owned(),
            needed: size as u64,
            available: encoded.len() as u64,
        });
    }
    let is_attributes = source.mode == "ATTRIBUTES";
    let stride_is_valid =
        if is_attributes { stride % 4 == 0 && (4..=256).contains(&stride) } else { [2, 4].contains(&stride) };
    if !stride_is_valid {
        return Err(invalid(format!("has a byteStride of {stride}, which mode {} does not allow", source.mode)));
    }
    let filter_is_valid = match source.filter.as_str() {
        "" | "NONE" => true,
        "OCTAHEDRAL" => is_attributes && [4, 8].contains(&stride),
        "QUATERNION" => is_attributes && stride == 8,
        "EXPONENTIAL" => is_attributes,
        "COLOR" => is_attributes && [4, 8].contains(&stride),
        _ => false,
    };
    if !filter_is_valid {
        return Err(invalid(format!("has the filter {:?}, which does not go with its mode and stride", source.filter)));
    }
    let mut stream = Stream { rest: encoded };
    let decoded = match source.mode.as_str() {
        "ATTRIBUTES" => attributes::decode(&mut stream, stride, count),
        "TRIANGLES" if count % 3 == 0 => {
            indices::triangles(&mut stream, count).map(|all| indices::packed(&all, stride))
        }
        "INDICES" => indices::sequence(&mut stream, count).map(|all| indices::packed(&all, stride)),
        mode => return Err(invalid(format!("has the mode {mode:?} for {count} elements, which is not known"))),
    };
    let mut bytes = decoded.ok_or_else(|| invalid("holds a damaged stream".to_owned()))?;
    match source.filter.as_str() {
        "OCTAHEDRAL" if stride == 4 => filters::octahedral::<1>(&mut bytes),
        "OCTAHEDRAL" => filters::octahedral::<2>(&mut bytes),
        "QUATERNION" => filters::quaternion(&mut bytes),
        "EXPONENTIAL" => filters::exponential(&mut bytes),
        "COLOR" if stride == 4 => filters::color::<1>(&mut bytes),
        "COLOR" => filters::color::<2>(&mut bytes),
        _ => {}
    }
    Ok(bytes)
}
