//! KHR_texture_basisu: Basis Universal textures (ETC1S and UASTC) in KTX 2.0 containers, decoded to
//! RGBA.
//!
//! Of the `basisu` crate only the decoders to plain pixels are used: its own entry point links the
//! tables of every GPU format.

use basisu::basislz::etc1s::Etc1sTranscoder;
use basisu::ktx2::{BasisFormat, Ktx2Header};
use basisu::uastc::unpack::unpack_uastc;
use glam::UVec2;
use ruzstd::io::Read;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// First bytes of a KTX 2.0 file.
const MAGIC: &[u8; 12] = b"\xabKTX 20\xbb\r\n\x1a\n";

/// Least bytes of a file: the header and one level.
const MIN_BYTES: usize = 104;

/// Width and height of a block, px.
const BLOCK: u32 = 4;

/// Supercompression schemes of KTX 2.0.
const NONE: u32 = 0;
const ZSTANDARD: u32 = 2;

/// Length of the header of the codebooks of ETC1S, and of an image's description, bytes.
const GLOBAL_HEADER_BYTES: usize = 20;

/// Whether the file begins like KTX 2.0.
pub(super) fn is_ktx2(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Width and height by the header, px.
pub(super) fn dimensions(bytes: &[u8]) -> Option<(u32, u32)> {
    let word = |at: usize| bytes.get(at..at + 4)?.try_into().ok().map(u32::from_le_bytes);
    is_ktx2(bytes).then(|| Some((word(20)?, word(24)?)))?
}

/// The largest image of the first layer and face, or why there is none. Who calls has checked the
/// [`dimensions`].
pub(super) fn decode(bytes: &[u8]) -> Result<(UVec2, Vec<[u8; 4]>), String> {
    // The parts of the crate check streams, but not for all that a damaged one can hold.
    catch_unwind(AssertUnwindSafe(|| decode_unguarded(bytes)))
        .unwrap_or_else(|_| Err("the parts of its KTX 2.0 file contradict each other".to_owned()))
}

fn decode_unguarded(bytes: &[u8]) -> Result<(UVec2, Vec<[u8; 4]>), String> {
    let damaged = || "a damaged KTX 2.0 file".to_owned();
    if bytes.len() < MIN_BYTES {
        return Err(damaged());
    }
    let header = Ktx2Header::parse(bytes)
        .ok_or("a KTX 2.0 file that is damaged or holds no Basis Universal texture (ETC1S or UASTC)")?;
    let size = UVec2::new(header.width, header.height);
    let pixels = match header.format {
        BasisFormat::Etc1s => etc1s(bytes, &header).ok_or_else(damaged)?,
        BasisFormat::Uastc => uastc(bytes, &header).ok_or_else(damaged)?,
        _ => return Err("a KTX 2.0 texture of high dynamic range or of ASTC, which is not read".to_owned()),
    };
    Ok((size, pixels))
}

/// Bytes from an offset that a file declares.
fn slice(bytes: &[u8], offset: u64, length: u64) -> Option<&[u8]> {
    let (start, end) = (usize::try_from(offset).ok()?, usize::try_from(offset.checked_add(length)?).ok()?);
    bytes.get(start..end)
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..at.checked_add(4)?)?.try_into().ok()?))
}

/// Codebooks that all images share, then an image of indices into them for colour and one for alpha
/// (KTX 2.0, annex C: BasisLZ).
fn etc1s(bytes: &[u8], header: &Ktx2Header) -> Option<Vec<[u8; 4]>> {
    let global = slice(bytes, header.sgd_byte_offset, header.sgd_byte_length)?;
    let counts = word(global, 0)?;
    let [endpoint_bytes, selector_bytes, table_bytes] = [word(global, 4)?, word(global, 8)?, word(global, 12)?];
    let images = u64::from(header.level_count.max(1))
        .checked_mul(u64::from(header.layer_count.max(1)))?
        .checked_mul(u64::from(header.face_count.max(1)))?;
    let mut at = GLOBAL_HEADER_BYTES.checked_add(usize::try_from(images).ok()?.checked_mul(GLOBAL_HEADER_BYTES)?)?;
    let mut part = |length: u32| {
        let part = slice(global, at as u64, u64::from(length))?;
        at += part.len();
        Some(part)
    };
    let (endpoints, selectors, tables) = (part(endpoint_bytes)?, part(selector_bytes)?, part(table_bytes)?);
    let mut decoder = Etc1sTranscoder::new();
    let is_whole =
        decoder.decode_palettes(counts & 0xffff, endpoints, counts >> 16, selectors) && decoder.decode_tables(tables);
    if !is_whole {
        return None;
    }
    // The first image is that of the largest level, layer 0 and face 0.
    let described = |field: usize| word(global, GLOBAL_HEADER_BYTES + 4 * field);
    let level = header.levels.first()?;
    let image = |offset: u32, length: u32| {
        slice(slice(bytes, level.byte_offset, level.byte_length)?, u64::from(offset), u64::from(length))
    };
    let color = image(described(1)?, described(2)?)?;
    let (width, height) = (header.width, header.height);
    let (across, down) = (width.div_ceil(BLOCK), height.div_ceil(BLOCK));
    let mut rgba = vec![0; pixel_count(header)?.checked_mul(4)?];
    if header.has_alpha {
        let alpha = image(described(3)?, described(4)?)?;
        decoder.transcode_image_rgba32(color, alpha, across, down, width, height, None, &mut rgba)?;
    } else {
        decoder.transcode_slice_rgba32(color, across, down, width, height, None, &mut rgba)?;
    }
    Some(rgba.as_chunks::<4>().0.to_vec())
}

/// Blocks of 16 bytes in rows, as they are or compressed once more by Zstandard.
fn uastc(bytes: &[u8], header: &Ktx2Header) -> Option<Vec<[u8; 4]>> {
    let (width, height) = (header.width as usize, header.height as usize);
    let across = width.div_ceil(BLOCK as usize);
    let wanted = across.checked_mul(height.div_ceil(BLOCK as usize))?.checked_mul(16)?;
    let level = header.levels.first()?;
    let stored = slice(bytes, level.byte_offset, level.byte_length)?;
    let blocks = match header.supercompression {
        NONE => stored.get(..wanted)?.to_vec(),
        ZSTANDARD => {
            let mut blocks = vec![0; wanted];
            ruzstd::StreamingDecoder::new(stored).ok()?.read_exact(&mut blocks).ok()?;
            blocks
        }
        _ => return None,
    };
    let mut pixels = vec![[0; 4]; pixel_count(header)?];
    for (index, block) in blocks.as_chunks::<16>().0.iter().enumerate() {
        let texels = unpack_uastc(block, false)?;
        let (left, top) = (index % across * 4, index / across * 4);
        for (i, texel) in texels.iter().enumerate() {
            let (x, y) = (left + i % 4, top + i / 4);
            if x < width && y < height {
                pixels[y * width + x] = texel.c;
            }
        }
    }
    Some(pixels)
}

fn pixel_count(header: &Ktx2Header) -> Option<usize> {
    usize::try_from(header.width).ok()?.checked_mul(usize::try_from(header.height).ok()?)
}
