//! Streams of encoders that this repository does not have, as base64.
//!
//! The Draco streams are of Google's encoder (npm `draco3d` 1.5.9): [`grid`] with quantisation of 11, 8
//! and 10 bits for positions, normals and coordinates. The KTX 2.0 files are of Binomial's encoder (npm
//! `ktx2-encoder` 0.6.0): [`picture`] with its best quality, sRGB, without mipmaps.

use base64::Engine;

/// Grid of 4x4 squares, edgebreaker, speed 5.
const DRACO_EDGEBREAKER: &str = "\
    RFJBQ08CAgEBAAAAGSACIAQACl/71FN9qlrVpwr/ARH/AsxC/wLMQgP/AAAAAAABAAABAAkDAAACAQEJAwABAwEDCQIAAgIBAQEB\
    A4AQ/SJpA0UE/////////+8hBSEF//////////Pc+QVpA/////////////////////fcGCheKMEK1jmMD3gjIqTUGdxnyTpZ6k5P\
    gAAAAAD/BwAAAAAAAAAAAAAAAAAAAACAPwsAAwEBAYABuT7/90kBAyLfnv8AAAB/AAAACAEBAQALAxUuPQoTkQKRApECBzWwVQ5r\
    T4AA/Q/Q/z8AAgogAAAgAgAAAAD/AwAAAAAAAAAAAAAAAIA/Cg==";

/// The same with a seam in its coordinates, edgebreaker with valences, speed 0.
const DRACO_VALENCE: &str = "\
    RFJBQ08CAgEBAAAAGSACIAQACl/71FN9qlrVpwr/ARH/AsxC5gXStLtbgAP/AAEAAAABAQABAAkDAAACAQEJAwABAwEDCQIAAgIB\
    AQEBBoAQ/SJpAyEF/////////+9pA0UE//////////Pc1QZFBP////////////////////fcFwnqAn97Nnz8M0GKFDElCge5eMzu\
    /mJfAAAAAP8HAAAAAAAAAAAAAAAAAAAAAIA/CwYDAQAJA5ECF3E9A6SLkRXV5gDmAME01RxUVFdXGC9UAIc/NGdUA1RXGLtUVwCr\
    mGeEPzRnVKsoBGeYO1RXVwD/AAAAfwAAAP8Cs0EIBQEBAAsDaQYT8Q4REVUVRQQKkb7DjGLfEPQ+swD9D9A/UgZgKYUJgCdAP4Ck\
    T5UAMr7H82XFFw2D/gMA0D+cDAAggDFAP42Bm9t/Qvb7AMYADPIUARoAAAAKA/wuhAAAAAD/AwAAAAAAAAAAAAAAAIA/Cg==";

/// Grid of 2x2 squares, sequential, speed 10.
const DRACO_SEQUENTIAL: &str = "\
    RFJBQ08CAgEAAAAICQEAAQIAAgMBBAUBBQIDAgYDBgcCBQgCCAYBAwAJAwAAAQkDAAEDCQIAAgIDAgABAQAMAx0HI+U4AwTghfg/\
    AAAAgP8D8P8A+F8A/g8AAPz///33PwD+D4D/BwAAAAQAAAAA/wcAAAADAQEBgAFxPP/3kQMDoMyK/wAAAH8AAAAAAQEACwMdBxs5\
    Dq0qBIiqwYEACAAA//8H8P//APz/n///AfwPAAAAAAD/AwAAAAAAAAAAAAAAAAAAAAAAPwsIAAAAAAAAAAAAAIA/Cg==";

/// ETC1S without alpha.
const KTX2_ETC1S: &str = "\
    q0tUWCAyMLsNChoKAAAAAAEAAAAIAAAACAAAAAAAAAAAAAAAAQAAAAEAAAABAAAAaAAAACwAAACUAAAAJAAAALgAAAAAAAAAmQAA\
    AAAAAABRAQAAAAAAAAIAAAAAAAAAAAAAAAAAAAAsAAAAAAAAAAIAKACjAQIAAwMAAAgAAAAAAAAAAAA/AAAAAAAAAAAA/////x8A\
    AABLVFh3cml0ZXIAQmFzaXMgVW5pdmVyc2FsIDIuNTAAAAQABAA1AAAAEQAAACsAAAAAAAAAAAAAAAAAAAACAAAAAAAAAAAAAAAd\
    QCSBAAAAYNALxnSLQICoAQMAAICgA0xukFkApgAIAAAAAJArB8AUAAEAAAAQJI2Q9fyJAlRVVVX9////r6qqqgIAAAAAAMFEAAAA\
    AAAA8l+NAJgBAAAAAABAQgEQgUAAAAAA1AgAJgAAAAAAABBAACwQ";

/// ETC1S with alpha.
const KTX2_ETC1S_ALPHA: &str = "\
    q0tUWCAyMLsNChoKAAAAAAEAAAAIAAAACAAAAAAAAAAAAAAAAQAAAAEAAAABAAAAaAAAADwAAACkAAAAJAAAAMgAAAAAAAAAnwAA\
    AAAAAABnAQAAAAAAAAQAAAAAAAAAAAAAAAAAAAA8AAAAAAAAAAIAOACjAQIAAwMAAAgIAAAAAAAAAAA/AAAAAAAAAAAA/////0AA\
    Pw8AAAAAAAAAAP////8fAAAAS1RYd3JpdGVyAEJhc2lzIFVuaXZlcnNhbCAyLjUwAAAGAAQAOAAAABEAAAAuAAAAAAAAAAAAAAAA\
    AAAAAgAAAAIAAAACAAAAHUAkgQAAAEDYCyJdJgYCTAkAAAAAAEEbbDQ7gLgBAgAAgKCpEG/wAJgCIAAAAACCpBEA+KpyuS38////\
    V1VVVQUAAACoqqqqAgDBRAAAAAAAABLlv40BMAVAAAAAAIBkKAEiBgwAAABCVpwiAJgAAAAAAABAAAHvG2gC";

/// UASTC as it is.
const KTX2_UASTC: &str = "\
    q0tUWCAyMLsNChoKAAAAAAEAAAAIAAAACAAAAAAAAAAAAAAAAQAAAAEAAAAAAAAAaAAAACwAAACUAAAALAAAAAAAAAAAAAAAAAAA\
    AAAAAADAAAAAAAAAAEAAAAAAAAAAQAAAAAAAAAAsAAAAAAAAAAIAKACmAQIAAwMAABAAAAAAAAAAAAB/AwAAAAAAAAAA/////x8A\
    AABLVFh3cml0ZXIAQmFzaXMgVW5pdmVyc2FsIDIuNTAAAAQAAAB/fwAAF5lM5j+1igAAAAAAAAAAABeFjPu/DegCAAAAAAAAAAAX\
    2UMGyFxBAAAAAAAAAAAAF8WDGygqZAMAAAAAAAAAAA==";

/// UASTC compressed once more by Zstandard.
const KTX2_UASTC_ZSTANDARD: &str = "\
    q0tUWCAyMLsNChoKAAAAAAEAAAAIAAAACAAAAAAAAAAAAAAAAQAAAAEAAAACAAAAaAAAACwAAACUAAAAJAAAAAAAAAAAAAAAAAAA\
    AAAAAAC4AAAAAAAAADMAAAAAAAAAQAAAAAAAAAAsAAAAAAAAAAIAKACmAQIAAwMAABAAAAAAAAAAAAB/AwAAAAAAAAAA/////x8A\
    AABLVFh3cml0ZXIAQmFzaXMgVW5pdmVyc2FsIDIuNTAAACi1L/0gQFUBAPAXmUzmP7WKABeFjPu/DegC2UMGyFxBAMWDGygqZAME\
    AIAYUMzMwgnABQ==";

fn bytes(encoded: &str) -> Vec<u8> {
    base64::engine::general_purpose::STANDARD.decode(encoded).expect("base64 of this file")
}

/// The Draco streams: squares a side, whether the coordinates have a seam, the stream.
pub fn draco() -> [(u32, bool, Vec<u8>); 3] {
    [(4, false, bytes(DRACO_EDGEBREAKER)), (4, true, bytes(DRACO_VALENCE)), (2, false, bytes(DRACO_SEQUENTIAL))]
}

/// The KTX 2.0 files by name, with whether they have alpha.
pub fn ktx2() -> [(&'static str, bool, Vec<u8>); 4] {
    [
        ("ETC1S", false, bytes(KTX2_ETC1S)),
        ("ETC1S with alpha", true, bytes(KTX2_ETC1S_ALPHA)),
        ("UASTC", true, bytes(KTX2_UASTC)),
        ("UASTC and Zstandard", true, bytes(KTX2_UASTC_ZSTANDARD)),
    ]
}

/// Position of a corner of the grid that was encoded.
pub fn corner(x: u32, y: u32) -> [f32; 3] {
    [x as f32 * 0.25, y as f32 * 0.25, ((x * y) % 3) as f32 * 0.125]
}

/// Texture coordinates of that corner, seen from a square that is in the right half or not.
pub fn coordinates(n: u32, x: u32, y: u32, is_right: bool) -> [f32; 2] {
    let (u, v) = (x as f32 / n as f32, y as f32 / n as f32);
    [u * 0.5 + if is_right { 0.5 } else { 0.0 }, v]
}

/// The picture of 8x8 px that was encoded, by blocks of four colours.
pub fn picture(x: u32, y: u32, has_alpha: bool) -> [u8; 4] {
    let (is_left, is_top) = (x < 4, y < 4);
    let alpha = if has_alpha && !is_top { 64 } else { 255 };
    [if is_left { 200 } else { 40 }, if is_top { 100 } else { 30 }, if is_left { 50 } else { 220 }, alpha]
}
