//! Portable float maps: one or three floats a pixel, rows from bottom to top.

use crate::image::Image;
use glam::UVec2;

/// A decoded file.
#[derive(Debug, PartialEq)]
pub(super) enum Pfm {
    /// `Pf`.
    Grey(Image<f32>),
    /// `PF`.
    Color(Image<[f32; 3]>),
}

/// Whether the bytes begin like such a file.
pub(super) fn is_pfm(start: &[u8]) -> bool {
    matches!(start, [b'P', b'f' | b'F', white, ..] if white.is_ascii_whitespace())
}

/// Size and floats of a file, or what is wrong with it.
pub(super) fn parse(bytes: &[u8]) -> Result<Pfm, String> {
    let mut at = 0;
    // Words of the header; a single white space ends the last of them.
    let mut word = || {
        let start = at + bytes[at..].iter().position(|b| !b.is_ascii_whitespace())?;
        let length = bytes[start..].iter().take(64).position(u8::is_ascii_whitespace)?;
        at = start + length + 1;
        std::str::from_utf8(&bytes[start..start + length]).ok()
    };
    let (kind, width, height, scale) = (word(), word(), word(), word());
    let channels = match kind {
        Some("Pf") => 1,
        Some("PF") => 3,
        _ => return Err("no PFM header".to_owned()),
    };
    let number = |word: Option<&str>| word.and_then(|word| word.parse::<u32>().ok()).filter(|n| *n > 0);
    let scale = scale.and_then(|word| word.parse::<f32>().ok()).filter(|scale| *scale != 0.0 && scale.is_finite());
    let (Some(width), Some(height), Some(scale)) = (number(width), number(height), scale) else {
        return Err("its header has no width, height and scale".to_owned());
    };
    let needed = u128::from(width) * u128::from(height) * channels * 4;
    let rest = &bytes[at.min(bytes.len())..];
    let data = usize::try_from(needed).ok().and_then(|needed| rest.get(..needed));
    let Some(data) = data else { return Err(format!("{} of {needed} bytes", rest.len())) };
    // The scale's sign tells the byte order; its size, a unit that nobody agrees on.
    let float = |bytes: &[u8; 4]| if scale < 0.0 { f32::from_le_bytes(*bytes) } else { f32::from_be_bytes(*bytes) };
    let floats: Vec<f32> = data.as_chunks::<4>().0.iter().map(float).collect();
    let size = UVec2::new(width, height);
    let index = |x: u32, y: u32| (u64::from(height - 1 - y) * u64::from(width) + u64::from(x)) as usize;
    Ok(if channels == 1 {
        Pfm::Grey(Image::from_fn(size, |x, y| floats[index(x, y)]))
    } else {
        Pfm::Color(Image::from_fn(size, |x, y| std::array::from_fn(|c| floats[3 * index(x, y) + c])))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_from_bottom_to_top_in_either_byte_order() {
        let values = [1.0_f32, 2.0, 3.0, 4.0, 5.0, 6.0];
        let little = [&b"Pf\n3 2\n-1.0\n"[..], &values.map(f32::to_le_bytes).concat()].concat();
        let big = [&b"Pf 3 2 1\n"[..], &values.map(f32::to_be_bytes).concat()].concat();
        for bytes in [&little, &big] {
            let Ok(Pfm::Grey(image)) = parse(bytes) else { panic!("{:?}", parse(bytes)) };
            assert_eq!((image.size, image.at(0, 0), image.at(2, 1)), (UVec2::new(3, 2), 4.0, 3.0));
        }
        for cut in 0..little.len() {
            assert!(parse(&little[..cut]).is_err(), "{cut}");
        }
        assert!(parse(b"Pf 4294967295 4294967295 -1\n").is_err());
    }
}
