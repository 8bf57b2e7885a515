//! Colour maps for error maps.
//!
//! Both are perceptually uniform and readable by the colour-blind; they are matplotlib's
//! (Nathaniel Smith and Stefan van der Walt, 2015, released as CC0), at 33
//! of their 256 steps, between which values are interpolated.

use crate::image::Image;

/// A colour map on [0, 1].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ColorMap {
    /// Black over purple and orange to pale yellow: the one of FLIP's papers.
    #[default]
    Magma,
    /// Dark blue over green to yellow.
    Viridis,
}

impl ColorMap {
    /// sRGB-encoded 8-bit colour of `t`, clamped to [0, 1]; black for NaN.
    pub fn srgb8(self, t: f32) -> [u8; 3] {
        if t.is_nan() {
            return [0; 3];
        }
        let table = match self {
            Self::Magma => &MAGMA,
            Self::Viridis => &VIRIDIS,
        };
        let position = t.clamp(0.0, 1.0) * (table.len() - 1) as f32;
        let low = (position as usize).min(table.len() - 2);
        let share = position - low as f32;
        std::array::from_fn(|i| {
            let (a, b) = (f32::from(table[low][i]), f32::from(table[low + 1][i]));
            (a + (b - a) * share).round() as u8
        })
    }

    /// The colours of a map in which `white` and above get the last colour.
    pub fn apply(self, map: &Image<f32>, white: f32) -> Image<[u8; 3]> {
        map.map(|value| self.srgb8(value / white))
    }
}

const MAGMA: [[u8; 3]; 33] = [
    [0, 0, 4],
    [3, 3, 17],
    [10, 8, 34],
    [19, 13, 51],
    [29, 17, 70],
    [40, 17, 90],
    [54, 16, 106],
    [67, 15, 118],
    [80, 18, 124],
    [93, 23, 127],
    [105, 28, 129],
    [118, 33, 129],
    [130, 38, 129],
    [143, 42, 129],
    [156, 46, 127],
    [169, 50, 125],
    [182, 55, 121],
    [195, 59, 117],
    [207, 65, 112],
    [219, 72, 106],
    [230, 81, 99],
    [238, 92, 94],
    [245, 105, 92],
    [249, 120, 93],
    [251, 135, 97],
    [253, 150, 104],
    [254, 165, 113],
    [254, 180, 123],
    [254, 195, 135],
    [254, 209, 148],
    [253, 224, 162],
    [252, 238, 176],
    [252, 253, 191],
];

const VIRIDIS: [[u8; 3]; 33] = [
    [68, 1, 84],
    [71, 13, 96],
    [72, 24, 106],
    [72, 35, 116],
    [71, 45, 123],
    [69, 54, 129],
    [66, 64, 134],
    [63, 73, 137],
    [59, 82, 139],
    [55, 90, 141],
    [51, 99, 141],
    [47, 106, 142],
    [44, 114, 142],
    [41, 122, 142],
    [38, 129, 142],
    [35, 137, 142],
    [33, 144, 140],
    [31, 152, 139],
    [31, 159, 136],
    [33, 166, 133],
    [40, 174, 128],
    [49, 181, 123],
    [62, 188, 116],
    [76, 194, 108],
    [93, 201, 99],
    [110, 206, 88],
    [130, 211, 76],
    [150, 216, 63],
    [171, 220, 50],
    [192, 223, 36],
    [213, 226, 26],
    [234, 229, 26],
    [253, 231, 37],
];
