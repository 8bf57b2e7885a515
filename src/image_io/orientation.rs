//! Turning images the way their camera was held (Exif).

use crate::image::Image;
use glam::UVec2;
pub use image::metadata::Orientation;

/// The image turned or mirrored so that it stands upright.
pub(crate) fn upright<T: Copy>(image: &Image<T>, orientation: Orientation) -> Image<T> {
    let UVec2 { x: width, y: height } = image.size;
    let (right, bottom) = (width.saturating_sub(1), height.saturating_sub(1));
    let size = if is_sideways(orientation) { UVec2::new(height, width) } else { image.size };
    Image::from_fn(size, |x, y| match orientation {
        Orientation::NoTransforms => image.at(x, y),
        Orientation::Rotate90 => image.at(y, bottom - x),
        Orientation::Rotate180 => image.at(right - x, bottom - y),
        Orientation::Rotate270 => image.at(right - y, x),
        Orientation::FlipHorizontal => image.at(right - x, y),
        Orientation::FlipVertical => image.at(x, bottom - y),
        Orientation::Rotate90FlipH => image.at(y, x),
        Orientation::Rotate270FlipH => image.at(right - y, bottom - x),
    })
}

/// Whether width and height change places.
pub(crate) fn is_sideways(orientation: Orientation) -> bool {
    use Orientation::{Rotate90, Rotate90FlipH, Rotate270, Rotate270FlipH};
    matches!(orientation, Rotate90 | Rotate270 | Rotate90FlipH | Rotate270FlipH)
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{DynamicImage, GrayImage};

    #[test]
    fn agrees_with_the_image_crate() {
        let size = UVec2::new(3, 2);
        let own = Image::from_fn(size, |x, y| (10 * y + x) as u8);
        for exif in 1..=8 {
            let orientation = Orientation::from_exif(exif).expect("one of eight");
            let mut theirs = DynamicImage::from(GrayImage::from_raw(3, 2, own.pixels.clone()).expect("six bytes"));
            theirs.apply_orientation(orientation);
            let turned = upright(&own, orientation);
            assert_eq!((turned.size.x, turned.size.y), (theirs.width(), theirs.height()), "{exif}");
            assert_eq!(turned.pixels, theirs.into_luma8().into_raw(), "{exif}");
        }
    }
}
