//! Filters over decoded attributes (appendix B).

/// A signed component of `BYTES` bytes.
fn get<const BYTES: usize>(bytes: &[u8]) -> f32 {
    match BYTES {
        1 => f32::from(bytes[0] as i8),
        _ => f32::from(i16::from_le_bytes([bytes[0], bytes[1]])),
    }
}

fn put<const BYTES: usize>(bytes: &mut [u8], value: f32) {
    // The conversion clamps, and makes 0 of NaN: a damaged element stays a number.
    match BYTES {
        1 => bytes[0] = value.round() as i8 as u8,
        _ => bytes[..2].copy_from_slice(&(value.round() as i16).to_le_bytes()),
    }
}

/// Filter 1: unit vectors in octahedral encoding, as components of `BYTES` bytes.
pub(super) fn octahedral<const BYTES: usize>(bytes: &mut [u8]) {
    let greatest = if BYTES == 1 { 127.0 } else { 32767.0 };
    for element in bytes.chunks_exact_mut(4 * BYTES) {
        let component = |k: usize| get::<BYTES>(&element[k * BYTES..]);
        let one = component(2);
        let (mut x, mut y) = (component(0) / one, component(1) / one);
        let z = 1.0 - x.abs() - y.abs();
        // The lower hemisphere is folded over the diagonals.
        let fold = z.min(0.0);
        x -= fold.copysign(x);
        y -= fold.copysign(y);
        let length = (x * x + y * y + z * z).sqrt();
        for (k, value) in [x, y, z].into_iter().enumerate() {
            put::<BYTES>(&mut element[k * BYTES..], value / length * greatest);
        }
    }
}

/// Filter 2: unit quaternions without their largest component.
pub(super) fn quaternion(bytes: &mut [u8]) {
    for element in bytes.chunks_exact_mut(8) {
        let component = |k: usize| get::<2>(&element[k * 2..]);
        let last = i16::from_le_bytes([element[6], element[7]]);
        let one = f32::from(last | 3);
        let scale = std::f32::consts::FRAC_1_SQRT_2 / one;
        let [x, y, z] = [0, 1, 2].map(|k| component(k) * scale);
        let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
        let largest = usize::from(last as u16 & 3);
        for (k, value) in [w, x, y, z].into_iter().enumerate() {
            put::<2>(&mut element[(largest + k) % 4 * 2..], value * 32767.0);
        }
    }
}

/// Filter 4 (of KHR_meshopt_compression): colours as luma and two differences of chroma, with alpha
/// whose highest bit tells how many bits all of them have; `BYTES` bytes a component.
pub(super) fn color<const BYTES: usize>(bytes: &mut [u8]) {
    let greatest = if BYTES == 1 { 255.0 } else { 65535.0 };
    let unsigned = |bytes: &[u8]| match BYTES {
        1 => i32::from(bytes[0]),
        _ => i32::from(u16::from_le_bytes([bytes[0], bytes[1]])),
    };
    for element in bytes.chunks_exact_mut(4 * BYTES) {
        let (y, alpha) = (unsigned(element), unsigned(&element[3 * BYTES..]));
        let (co, cg) = (get::<BYTES>(&element[BYTES..]) as i32, get::<BYTES>(&element[2 * BYTES..]) as i32);
        // All bits below the highest one: what full alpha is.
        let full = (alpha as u32 + 1).next_power_of_two() as i32 - 1;
        let opacity = ((alpha << 1) & full) | (alpha & 1);
        let scale = greatest / full.max(1) as f32;
        for (k, value) in [y + co - cg, y + cg, y - co - cg, opacity].into_iter().enumerate() {
            let stored = (value as f32 * scale + 0.5).clamp(0.0, greatest);
            match BYTES {
                1 => element[k] = stored as u8,
                _ => element[2 * k..2 * k + 2].copy_from_slice(&(stored as u16).to_le_bytes()),
            }
        }
    }
}

/// Filter 3: floats as an exponent of 8 bits and a mantissa of 24.
pub(super) fn exponential(bytes: &mut [u8]) {
    for element in bytes.as_chunks_mut::<4>().0 {
        let code = i32::from_le_bytes(*element);
        let (exponent, mantissa) = (code >> 24, (code << 8) >> 8);
        let value = (f64::from(mantissa) * f64::from(exponent).exp2()) as f32;
        *element = value.to_le_bytes();
    }
}
