//! Filling holes from their borders inwards.

use crate::image::Image;

/// Gives every unknown pixel a value: ring by ring from the known ones inwards, each pixel
/// the `merge` of its known neighbours (of eight) in the rings before. Every pixel is
/// visited once, whatever the size of the holes. False if nothing at all is known.
pub(super) fn from_surroundings<T: Copy>(image: &mut Image<T>, known: &[bool], merge: impl Fn(&[T]) -> T) -> bool {
    let mut known = known.to_vec();
    let mut ring: Vec<usize> =
        (0..known.len()).filter(|&i| !known[i] && neighbours(image, i).any(|n| known[n])).collect();
    let mut queued = known.clone();
    ring.iter().for_each(|&i| queued[i] = true);
    while !ring.is_empty() {
        let merged: Vec<T> = ring
            .iter()
            .map(|&i| merge(&neighbours(image, i).filter(|&n| known[n]).map(|n| image.pixels[n]).collect::<Vec<_>>()))
            .collect();
        for (&i, value) in ring.iter().zip(merged) {
            image.pixels[i] = value;
            known[i] = true;
        }
        let mut next = Vec::new();
        for &i in &ring {
            for n in neighbours(image, i) {
                if !std::mem::replace(&mut queued[n], true) {
                    next.push(n);
                }
            }
        }
        ring = next;
    }
    known.iter().all(|&known| known)
}

/// Indices of the up to eight pixels around pixel `i`.
fn neighbours<T>(image: &Image<T>, i: usize) -> impl Iterator<Item = usize> + use<T> {
    let (width, height) = (image.size.x as usize, image.size.y as usize);
    let (x, y) = (i % width, i / width);
    let rows = y.saturating_sub(1)..=(y + 1).min(height - 1);
    rows.flat_map(move |row| (x.saturating_sub(1)..=(x + 1).min(width - 1)).map(move |column| row * width + column))
        .filter(move |&n| n != i)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::UVec2;

    #[test]
    fn holes_take_the_merged_value_of_their_border() {
        let size = UVec2::new(9, 7);
        let truth = Image::from_fn(size, |x, _| if x < 4 { 1.0_f32 } else { 5.0 });
        let known: Vec<bool> = (0..63).map(|i| !((2..7).contains(&(i % 9)) && (1..6).contains(&(i / 9)))).collect();
        let mut holed = truth.clone();
        holed.pixels.iter_mut().zip(&known).filter(|(_, known)| !**known).for_each(|(value, _)| *value = f32::NAN);
        assert!(from_surroundings(&mut holed, &known, |near| near.iter().copied().fold(0.0, f32::max)));
        assert!(holed.pixels.iter().all(|value| *value == 1.0 || *value == 5.0));
        // In the middle of the hole's left edge only the left side borders on it.
        assert_eq!((holed.at(2, 3), holed.at(6, 3)), (1.0, 5.0));
        for (i, known) in known.iter().enumerate() {
            assert!(!known || holed.pixels[i] == truth.pixels[i], "known pixel {i} was changed");
        }
    }

    #[test]
    fn nothing_known_is_told() {
        let mut image = Image::filled(UVec2::new(3, 3), 0.0_f32);
        assert!(!from_surroundings(&mut image, &[false; 9], |near| near[0]));
    }
}
