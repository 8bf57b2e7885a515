//! NumPy arrays (.npy) of one number a pixel.

use crate::image::Image;
use glam::UVec2;
use half::f16;

/// First bytes of a file.
const MAGIC: &[u8] = b"\x93NUMPY";

/// From the little-endian bytes of an element to its number.
type Decode = fn(&[u8]) -> f64;

/// Numbers of an array, and the greatest that its type holds where that is an integer.
#[derive(Debug, PartialEq)]
pub(super) struct Array {
    pub values: Image<f32>,
    pub full_scale: f64,
}

/// Whether the bytes begin like such a file.
pub(super) fn is_npy(start: &[u8]) -> bool {
    start.starts_with(MAGIC)
}

/// The array of a file, or what is wrong with it. Arrays of shape (height, width), and with
/// further axes of length 1, are read.
pub(super) fn parse(bytes: &[u8]) -> Result<Array, String> {
    let (header, data) = split(bytes).ok_or_else(|| "its header is cut off".to_owned())?;
    let header = std::str::from_utf8(header).map_err(|_| "its header is no text".to_owned())?;
    let field = |name: &str| {
        let after = header.split_once(&format!("'{name}'"))?.1;
        Some(after.trim_start().strip_prefix(':')?.trim_start())
    };
    let kind = field("descr").and_then(|text| text.strip_prefix('\'')?.split('\'').next());
    let kind = kind.ok_or_else(|| "it holds records, not numbers".to_owned())?;
    let is_columns_first = field("fortran_order").is_some_and(|text| text.starts_with("True"));
    let shape = field("shape").and_then(|text| text.strip_prefix('(')?.split(')').next());
    let axes: Option<Vec<u64>> = shape
        .map(|text| {
            text.split(',').map(str::trim).filter(|axis| !axis.is_empty()).map(|axis| axis.parse().ok()).collect()
        })
        .unwrap_or_default();
    let axes = axes.ok_or_else(|| "its shape is not understood".to_owned())?;
    // A batch or channel axis of one element may stand before or behind.
    let long: Vec<u64> = axes.iter().copied().filter(|axis| *axis != 1).collect();
    let [height, width] = match (axes.as_slice(), long.as_slice()) {
        (&[height, width], _) => [height, width],
        (_, &[height, width]) => [height, width],
        _ => return Err(format!("its shape is {axes:?}, where one number a pixel (height, width) is needed")),
    };
    let (order, kind) = kind.split_at(kind.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(0));
    let (decode, element, full_scale): (Decode, u64, f64) = match kind {
        "f2" => (|b| f16::from_le_bytes([b[0], b[1]]).to_f64(), 2, 1.0),
        "f4" => (|b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])), 4, 1.0),
        "f8" => (|b| f64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]), 8, 1.0),
        "u1" => (|b| f64::from(b[0]), 1, 255.0),
        "u2" => (|b| f64::from(u16::from_le_bytes([b[0], b[1]])), 2, 65535.0),
        "u4" => (|b| f64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])), 4, f64::from(u32::MAX)),
        "i2" => (|b| f64::from(i16::from_le_bytes([b[0], b[1]])), 2, 32767.0),
        "i4" => (|b| f64::from(i32::from_le_bytes([b[0], b[1], b[2], b[3]])), 4, f64::from(i32::MAX)),
        _ => return Err(format!("its numbers are of the type {:?}", kind.escape_default().to_string())),
    };
    let count = height.checked_mul(width).filter(|count| *count > 0);
    let needed = count.and_then(|count| count.checked_mul(element));
    let (Some(needed), Ok(width), Ok(height)) = (needed, u32::try_from(width), u32::try_from(height)) else {
        return Err(format!("its shape is {axes:?}"));
    };
    if (data.len() as u64) < needed {
        return Err(format!("{} of {needed} bytes", data.len()));
    }
    let element = element as usize;
    let is_big_endian = order.starts_with('>');
    let value = |index: usize| {
        let mut raw = [0; 8];
        raw[..element].copy_from_slice(&data[index * element..][..element]);
        if is_big_endian {
            raw[..element].reverse();
        }
        decode(&raw) as f32
    };
    let values = Image::from_fn(UVec2::new(width, height), |x, y| {
        value(if is_columns_first {
            x as usize * height as usize + y as usize
        } else {
            y as usize * width as usize + x as usize
        })
    });
    Ok(Array { values, full_scale })
}

/// Header text and data: the header's length has 2 bytes in version 1 and 4 later.
fn split(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let version = *bytes.get(MAGIC.len())?;
    let rest = bytes.get(MAGIC.len() + 2..)?;
    let (length, rest) = if version == 1 {
        let (length, rest) = rest.split_first_chunk::<2>()?;
        (usize::from(u16::from_le_bytes(*length)), rest)
    } else {
        let (length, rest) = rest.split_first_chunk::<4>()?;
        (usize::try_from(u32::from_le_bytes(*length)).ok()?, rest)
    };
    rest.split_at_checked(length)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(header: &str, data: &[u8]) -> Vec<u8> {
        [MAGIC, &[1, 0], &(header.len() as u16).to_le_bytes(), header.as_bytes(), data].concat()
    }

    #[test]
    fn types_orders_and_shapes() {
        let values = [1.0_f32, 2.0, 3.0, 4.0, 5.0, 6.0];
        let rows = file(
            "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }\n",
            &values.map(f32::to_le_bytes).concat(),
        );
        let columns = file(
            "{'descr': '>f8', 'fortran_order': True, 'shape': (1, 2, 3, 1), }",
            &[1.0_f64, 4.0, 2.0, 5.0, 3.0, 6.0].map(f64::to_be_bytes).concat(),
        );
        for bytes in [&rows, &columns] {
            let array = parse(bytes).expect("an array");
            assert_eq!((array.values.size, array.full_scale), (UVec2::new(3, 2), 1.0));
            assert_eq!(array.values.pixels, values);
        }
        let integers = file("{'descr':'<u2','fortran_order':False,'shape':(1,2)}", &[0, 1, 255, 255]);
        let array = parse(&integers).expect("an array");
        assert_eq!((array.values.pixels, array.full_scale), (vec![256.0, 65535.0], 65535.0));
        for cut in 0..rows.len() {
            assert!(parse(&rows[..cut]).is_err(), "{cut}");
        }
        let wide = file("{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3, 3), }", &[0; 72]);
        assert!(parse(&wide).is_err_and(|e| e.contains("one number a pixel")));
        let endless = file("{'descr': '<f4', 'fortran_order': False, 'shape': (4294967295, 4294967295), }", &[0; 72]);
        assert!(parse(&endless).is_err());
    }
}
