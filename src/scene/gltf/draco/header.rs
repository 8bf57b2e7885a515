//! How much a Draco stream declares, read before anything is allocated for it (Draco bitstream 2.2,
//! sections 2 to 5: header, metadata, connectivity).

/// Bit of the flags that says that metadata follow the header.
const METADATA: u16 = 0x8000;

/// Deepest metadata that are read over.
const MAX_METADATA_DEPTH: u32 = 8;

/// What a stream declares.
pub(super) struct Counts {
    /// The greatest of its numbers of triangles, points, vertices and symbols.
    pub greatest: u64,
}

/// The counts of a mesh; `None` where the header ends or contradicts itself. What it does not know is
/// left to the decoder.
pub(super) fn counts(bytes: &[u8]) -> Option<Counts> {
    let mut rest = Bytes { rest: bytes };
    let header = rest.take(11)?;
    let is_edgebreaker = header[8] == 1;
    if u16::from_le_bytes([header[9], header[10]]) & METADATA != 0 {
        for _ in 0..rest.varint()? {
            rest.varint()?;
            rest.skip_metadata(0)?;
        }
        rest.skip_metadata(0)?;
    }
    let greatest = if is_edgebreaker {
        rest.take(1)?;
        let (vertices, faces) = (rest.varint()?, rest.varint()?);
        rest.take(1)?;
        let (symbols, splits) = (rest.varint()?, rest.varint()?);
        vertices.max(faces).max(symbols).max(splits)
    } else {
        rest.varint()?.max(rest.varint()?)
    };
    Some(Counts { greatest })
}

struct Bytes<'a> {
    rest: &'a [u8],
}

impl<'a> Bytes<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.rest.split_at_checked(count)?;
        self.rest = rest;
        Some(taken)
    }

    fn varint(&mut self) -> Option<u64> {
        let mut value = 0_u64;
        for shift in (0..64).step_by(7) {
            let byte = self.take(1)?[0];
            value |= u64::from(byte & 0x7f).checked_shl(shift)?;
            if byte & 0x80 == 0 {
                return Some(value);
            }
        }
        None
    }

    /// Entries of a name and a value each, then metadata of a name within it.
    fn skip_metadata(&mut self, depth: u32) -> Option<()> {
        if depth > MAX_METADATA_DEPTH {
            return None;
        }
        for _ in 0..self.varint()? {
            let name = usize::from(self.take(1)?[0]);
            self.take(name)?;
            let value = usize::try_from(self.varint()?).ok()?;
            self.take(value)?;
        }
        for _ in 0..self.varint()? {
            let name = usize::from(self.take(1)?[0]);
            self.take(name)?;
            self.skip_metadata(depth + 1)?;
        }
        Some(())
    }
}
