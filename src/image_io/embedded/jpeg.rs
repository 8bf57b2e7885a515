//! The segments of a JPEG that say what else is in its file.

use std::collections::BTreeMap;

const XMP: &[u8] = b"http://ns.adobe.com/xap/1.0/\0";
const EXTENDED_XMP: &[u8] = b"http://ns.adobe.com/xmp/extension/\0";
const MULTI_PICTURE: &[u8] = b"MPF\0";

/// Bytes before a piece of extended XMP: a name of 32, its whole length and the piece's offset.
const PIECE_HEADER_BYTES: usize = 40;

/// Tag of the list of pictures, and bytes of an entry (CIPA DC-007, 5.2.3).
const MP_ENTRY: u32 = 0xb002;
const MP_ENTRY_BYTES: usize = 16;

/// What the application segments before the first scan hold.
pub(super) struct Segments<'a> {
    main: Vec<&'a [u8]>,
    /// By name, then by offset.
    extended: BTreeMap<&'a [u8], BTreeMap<u32, &'a [u8]>>,
    /// Offset in the file and content of the index of pictures.
    multi_picture: Option<(usize, &'a [u8])>,
}

impl<'a> Segments<'a> {
    /// The segments; `None` of what is no JPEG.
    pub(super) fn of(bytes: &'a [u8]) -> Option<Self> {
        if !bytes.starts_with(&[0xff, 0xd8]) {
            return None;
        }
        let mut found = Self { main: Vec::new(), extended: BTreeMap::new(), multi_picture: None };
        let mut at = 2;
        while let Some(&[0xff, marker]) = bytes.get(at..at + 2) {
            match marker {
                0xff => {
                    at += 1;
                    continue;
                }
                // Start of a scan, or the end.
                0xda | 0xd9 => break,
                // Markers without a length.
                0x01 | 0xd0..=0xd8 => {
                    at += 2;
                    continue;
                }
                _ => {}
            }
            let Some(length) = bytes.get(at + 2..at + 4) else { break };
            let length = usize::from(u16::from_be_bytes([length[0], length[1]]));
            let Some(content) = length.checked_sub(2).and_then(|length| bytes.get(at + 4..at + 4 + length)) else {
                break;
            };
            found.take(marker, content, at + 4);
            at += 2 + length;
        }
        Some(found)
    }

    fn take(&mut self, marker: u8, content: &'a [u8], at: usize) {
        if marker == 0xe2 && content.starts_with(MULTI_PICTURE) {
            self.multi_picture = Some((at + MULTI_PICTURE.len(), &content[MULTI_PICTURE.len()..]));
        }
        if marker != 0xe1 {
            return;
        }
        if let Some(text) = content.strip_prefix(XMP) {
            self.main.push(text);
        }
        if let Some((header, piece)) =
            content.strip_prefix(EXTENDED_XMP).and_then(|rest| rest.split_at_checked(PIECE_HEADER_BYTES))
        {
            let offset = u32::from_be_bytes([header[36], header[37], header[38], header[39]]);
            self.extended.entry(&header[..32]).or_default().insert(offset, piece);
        }
    }

    /// All XMP, the extended behind the main one.
    pub(super) fn xmp(&self) -> String {
        let pieces = self.main.iter().chain(self.extended.values().flat_map(BTreeMap::values));
        String::from_utf8_lossy(&pieces.copied().collect::<Vec<_>>().concat()).into_owned()
    }

    /// The pictures behind the first one, by the index of the Multi-Picture Format; those that do not
    /// lie in the file are left out.
    pub(super) fn pictures(&self, bytes: &'a [u8]) -> Vec<&'a [u8]> {
        let entries = self.multi_picture.and_then(|(at, index)| Some((at, entries(index)?)));
        let Some((at, entries)) = entries else { return Vec::new() };
        let picture = |&(offset, length): &(usize, usize)| {
            let start = at.checked_add(offset)?;
            bytes.get(start..start.checked_add(length)?)
        };
        // The first is the file's own picture, at offset 0.
        entries.iter().filter(|(offset, _)| *offset > 0).filter_map(picture).collect()
    }
}

/// Offsets and lengths of the pictures; an index is laid out like a TIFF.
fn entries(index: &[u8]) -> Option<Vec<(usize, usize)>> {
    let is_little = index.starts_with(b"II");
    let short = |at: usize| {
        let bytes: [u8; 2] = index.get(at..at.checked_add(2)?)?.try_into().ok()?;
        Some(if is_little { u16::from_le_bytes(bytes) } else { u16::from_be_bytes(bytes) })
    };
    let long = |at: usize| {
        let bytes: [u8; 4] = index.get(at..at.checked_add(4)?)?.try_into().ok()?;
        Some(if is_little { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) })
    };
    let directory = long(4)? as usize;
    for field in 0..usize::from(short(directory)?) {
        let at = directory.checked_add(2 + 12 * field)?;
        if u32::from(short(at)?) == MP_ENTRY {
            let (length, start) = (long(at + 4)? as usize, long(at + 8)? as usize);
            let list = (0..length / MP_ENTRY_BYTES).map_while(|entry| {
                let entry = start.checked_add(entry * MP_ENTRY_BYTES)?;
                Some((long(entry.checked_add(8)?)? as usize, long(entry + 4)? as usize))
            });
            return Some(list.collect());
        }
    }
    None
}
