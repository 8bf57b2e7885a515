//! From which defocus on blur is seen.

use std::ops::RangeInclusive;

/// Defocus, D, at which blur begins to be detected: Wang and Ciuffreda, "Blur Discrimination of
/// the Human Eye in the Near Retinal Periphery" (Optometry and Vision Science 82, 2005) and
/// the studies that Sebastian, Burge and Geisler, "Defocus Blur Discrimination in Natural
/// Images with Natural Optics" (Journal of Vision 15(5):16, 2015), compare: 0.10 to 0.18 D in foveal vision.
pub const BLUR_DETECTION_D: RangeInclusive<f64> = 0.10..=0.18;

/// The vergences, D, between which the eye sees no blur where it is focused at `focus_d`, by
/// the least and the greatest threshold of [`BLUR_DETECTION_D`]: `[[near, far]; 2]`, the
/// narrower one first.
pub fn depth_of_focus_d(focus_d: f64) -> [[f64; 2]; 2] {
    [*BLUR_DETECTION_D.start(), *BLUR_DETECTION_D.end()].map(|d| [focus_d + d, focus_d - d])
}
