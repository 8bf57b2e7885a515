//! Two eyes: where each of them is, and how their pictures become one.
//!
//! ```text
//!        window at window_m, the same for both eyes
//!     ---------+=================+---------
//!               \ .           . /
//!                \   .     .   /       each eye sees the window through its own
//!                 \     .     /        asymmetric frustum; the optical axes
//!                  \  .   .  /         stay parallel
//!                  left   right
//!                    <-ipd->
//! ```

use crate::camera::Camera;
use crate::image::Image;
use glam::{Mat3, UVec2, Vec3, uvec2};
use std::ops::RangeInclusive;

/// Mean interpupillary distance of adults, mm: Dodgson, "Variation and Extrema of Human
/// Interpupillary Distance" (Proc. SPIE 5291, 2004).
pub const MEAN_IPD_MM: f64 = 63.0;

/// Interpupillary distances there are, mm: from small children's to the widest of adults'
/// (the same source).
pub const IPD_MM: RangeInclusive<f64> = 40.0..=80.0;

/// Refresh rates of head-mounted displays, Hz.
pub const REFRESH_HZ: [f64; 5] = [72.0, 90.0, 100.0, 120.0, 144.0];

/// Two eyes and how their pictures are shown.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default)]
pub struct Stereo {
    /// How the two pictures are shown.
    pub layout: Layout,
    /// Distance of the eyes, mm; 0 or more.
    pub ipd_mm: f64,
    /// Depth, metres, of the window that both eyes look through: what lies there has no
    /// disparity. Infinite for parallel frusta, as in a head-mounted display.
    pub window_m: f64,
}

impl Default for Stereo {
    fn default() -> Self {
        Self { layout: Layout::Parallel, ipd_mm: MEAN_IPD_MM, window_m: f64::INFINITY }
    }
}

/// How the pictures of two eyes are shown as one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Layout {
    /// The left eye's picture on the left.
    #[default]
    Parallel,
    /// The left eye's picture on the right, for viewing with crossed eyes.
    Crossed,
    /// Red and cyan glasses, with the colours that Dubois's method keeps.
    Anaglyph,
    /// Red and cyan glasses, without colour: the least rivalry between the eyes.
    GreyAnaglyph,
}

impl Layout {
    /// All, with their names.
    pub const ALL: [(Self, &'static str); 4] = [
        (Self::Parallel, "Side by side"),
        (Self::Crossed, "Crossed eyes"),
        (Self::Anaglyph, "Anaglyph"),
        (Self::GreyAnaglyph, "Anaglyph, grey"),
    ];

    /// Its short name, as the command line takes it.
    pub fn id(self) -> &'static str {
        match self {
            Self::Parallel => "parallel",
            Self::Crossed => "crossed",
            Self::Anaglyph => "anaglyph",
            Self::GreyAnaglyph => "grey-anaglyph",
        }
    }

    /// Whether the pictures stand side by side.
    pub fn is_side_by_side(self) -> bool {
        matches!(self, Self::Parallel | Self::Crossed)
    }

    /// Size of each eye's picture, px, in a frame of `size`.
    pub fn eye_size(self, size: UVec2) -> UVec2 {
        if self.is_side_by_side() { uvec2((size.x / 2).max(1), size.y) } else { size }
    }

    /// Size of the frame, px, in which each eye's picture is `eye` large.
    pub fn whole_size(self, eye: UVec2) -> UVec2 {
        if self.is_side_by_side() { uvec2(2 * eye.x, eye.y) } else { eye }
    }

    /// The two eyes' pictures beside each other. Panics if their sizes differ.
    pub fn side_by_side<T: Copy>(self, left: &Image<T>, right: &Image<T>) -> Image<T> {
        assert_eq!(left.size, right.size, "both eyes see with one size");
        let (first, second) = if self == Self::Crossed { (right, left) } else { (left, right) };
        let width = left.size.x;
        Image::from_fn(uvec2(2 * width, left.size.y), |x, y| match x < width {
            true => first.at(x, y),
            false => second.at(x - width, y),
        })
    }

    /// What of the left and the right eye's linear display values an anaglyph shows: it is
    /// `left * l + right * r`, clamped to [0, 1].
    pub(crate) fn anaglyph_matrices(self) -> [Mat3; 2] {
        match self {
            Self::GreyAnaglyph => {
                let luminance = crate::display::LUMINANCE;
                let rows = |r, g, b| Mat3::from_cols(r, g, b).transpose();
                [rows(luminance, Vec3::ZERO, Vec3::ZERO), rows(Vec3::ZERO, luminance, luminance)]
            }
            _ => DUBOIS,
        }
    }

    /// The anaglyph of two linear display values.
    pub fn anaglyph(self, left: Vec3, right: Vec3) -> Vec3 {
        let [l, r] = self.anaglyph_matrices();
        (l * left + r * right).clamp(Vec3::ZERO, Vec3::ONE)
    }
}

/// There is no layout of that name.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("there is no layout '{}'; there are parallel, crossed, anaglyph and grey-anaglyph", .0.escape_debug())]
pub struct UnknownLayout(pub String);

impl std::str::FromStr for Layout {
    type Err = UnknownLayout;

    fn from_str(id: &str) -> Result<Self, UnknownLayout> {
        let known = Self::ALL.iter().find(|(layout, _)| layout.id() == id);
        known.map(|(layout, _)| *layout).ok_or_else(|| UnknownLayout(id.into()))
    }
}

/// Dubois, "A Projection Method to Generate Anaglyph Stereo Images" (ICASSP 2001): the least
/// squares match of what each eye sees through red and cyan glasses. Coefficients for CRT
/// and plasma primaries as he published them, by columns.
const DUBOIS: [Mat3; 2] = [
    Mat3::from_cols_array(&[
        0.4561,
        -0.0400822,
        -0.0152161,
        0.500484,
        -0.0378246,
        -0.0205971,
        0.176381,
        -0.0157589,
        -0.00546856,
    ]),
    Mat3::from_cols_array(&[
        -0.0434706,
        0.378476,
        -0.0721527,
        -0.0879388,
        0.73364,
        -0.112961,
        -0.00155529,
        -0.0184503,
        1.2264,
    ]),
];

impl Stereo {
    /// Greatest distance of the eyes, mm: a giant's, who sees the scene as a model.
    pub const MOST_IPD_MM: f64 = 1000.0;

    /// Nearest window, metres: through a nearer one an eye sees none of what the other does.
    pub const NEAREST_WINDOW_M: f64 = 0.05;

    /// The same with what a file or a typed number could have wrong put right.
    pub fn repaired(self) -> Self {
        let ipd_mm = if self.ipd_mm.is_nan() { MEAN_IPD_MM } else { self.ipd_mm.clamp(0.0, Self::MOST_IPD_MM) };
        let window_m = if self.window_m.is_nan() { f64::INFINITY } else { self.window_m.max(Self::NEAREST_WINDOW_M) };
        Self { ipd_mm, window_m, ..self }
    }

    /// The left and the right eye's view, the middle between them being `camera`.
    pub fn eyes(&self, camera: &Camera) -> [Camera; 2] {
        let half_m = 0.5 * self.ipd_mm / crate::lens::MM_PER_M;
        [-half_m, half_m].map(|offset_m| camera.beside(offset_m, self.window_m))
    }

    /// Disparity, px, of a point at depth `depth_m` for eyes whose projection has
    /// `focal_px`: its x for the left eye less that for the right.
    pub fn disparity_px(&self, focal_px: f64, depth_m: f64) -> f64 {
        focal_px * self.ipd_mm / crate::lens::MM_PER_M * (1.0 / depth_m - 1.0 / self.window_m)
    }
}

/// Which of [`REFRESH_HZ`] a frame of `frame_ms` keeps up with.
pub fn refresh_met(frame_ms: f64) -> [bool; REFRESH_HZ.len()] {
    REFRESH_HZ.map(|hz| frame_ms <= 1000.0 / hz)
}
