//! From linear HDR to what a display shows: exposure, tone map, sRGB.
//!
//! The present shader does the same on the GPU. Metrics are computed on these values
//! before they are quantised.

use crate::image::ColorImage;
use crate::image_io::srgb::srgb_from_linear_f32;
use glam::{Mat3, Vec3, vec3};
use rayon::prelude::*;
use std::fmt;
use std::str::FromStr;

/// Luminance of linear Rec. 709 colour (ITU-R BT.709, item 3.2).
pub const LUMINANCE: Vec3 = vec3(0.2126, 0.7152, 0.0722);

/// How unbounded radiance becomes a displayable value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ToneMap {
    /// Values above 1 are clamped.
    #[default]
    None,
    /// `L / (1 + L)` on the luminance L, the colour scaled with it: Reinhard, Stark,
    /// Shirley and Ferwerda, "Photographic Tone Reproduction for Digital Images"
    /// (SIGGRAPH 2002), equation (3). Saturated colours may still be clamped.
    Reinhard,
    /// Troy Sobotka's AgX in Benjamin Wrensch's polynomial approximation, "Minimal AgX
    /// Implementation" (<https://iolite-engine.com/blog_posts/minimal_agx_implementation>,
    /// 2023), without a look.
    Agx,
}

impl ToneMap {
    /// All of them, in the order in which to show them.
    pub const ALL: [Self; 3] = [Self::None, Self::Reinhard, Self::Agx];
}

impl fmt::Display for ToneMap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::None => "none",
            Self::Reinhard => "reinhard",
            Self::Agx => "agx",
        })
    }
}

/// A name that no tone map has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no tone map '{0}': the tone maps are none, reinhard and agx")]
pub struct UnknownToneMap(pub String);

impl FromStr for ToneMap {
    type Err = UnknownToneMap;
    fn from_str(name: &str) -> Result<Self, UnknownToneMap> {
        Self::ALL.into_iter().find(|t| t.to_string() == name).ok_or_else(|| UnknownToneMap(name.into()))
    }
}

/// How images are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Display {
    /// Colours are multiplied by two to the power of this before they are tone mapped, EV.
    pub exposure_ev: f32,
    /// The tone map.
    pub tone_map: ToneMap,
}

impl Display {
    /// Linear display value in [0, 1] of a linear scene-referred colour.
    pub fn linear(&self, color: Vec3) -> Vec3 {
        self.unclamped(color).clamp(Vec3::ZERO, Vec3::ONE)
    }

    /// As [`Display::linear`], with what a display of high dynamic range shows beyond white.
    pub fn unclamped(&self, color: Vec3) -> Vec3 {
        let exposed = color * self.exposure_ev.exp2();
        match self.tone_map {
            ToneMap::None => exposed,
            ToneMap::Reinhard => reinhard(exposed),
            ToneMap::Agx => agx(exposed),
        }
    }

    /// sRGB-encoded display value in [0, 1], not quantised.
    pub fn encoded(&self, color: Vec3) -> Vec3 {
        let linear = self.linear(color);
        linear.map(srgb_from_linear_f32)
    }

    /// [`Display::linear`] of every pixel.
    pub fn linear_image(&self, image: &ColorImage) -> ColorImage {
        ColorImage { size: image.size, pixels: image.pixels.par_iter().map(|c| self.linear(*c)).collect() }
    }

    /// [`Display::encoded`] of every pixel.
    pub fn encoded_image(&self, image: &ColorImage) -> ColorImage {
        ColorImage { size: image.size, pixels: image.pixels.par_iter().map(|c| self.encoded(*c)).collect() }
    }
}

fn reinhard(color: Vec3) -> Vec3 {
    // Negative luminance, which a filter may leave behind, is as good as none.
    color / (1.0 + color.dot(LUMINANCE).max(0.0))
}

/// AgX up to linear display values: inset, log2 encoding, contrast curve, outset and the
/// curve's own exponent of 2.2.
fn agx(color: Vec3) -> Vec3 {
    const INSET: Mat3 = Mat3::from_cols_array(&[
        0.842_479_06,
        0.042_328_242,
        0.042_375_655,
        0.078_433_6,
        0.878_468_64,
        0.078_433_6,
        0.079_223_745,
        0.079_166_13,
        0.879_143,
    ]);
    const OUTSET: Mat3 = Mat3::from_cols_array(&[
        1.196_879,
        -0.052_896_85,
        -0.052_971_635,
        -0.098_020_88,
        1.151_903_1,
        -0.098_043_45,
        -0.099_029_74,
        -0.098_961_18,
        1.151_073_7,
    ]);
    const MIN_EV: f32 = -12.473_93;
    const MAX_EV: f32 = 4.026_069;
    let inset = INSET * color.max(Vec3::ZERO);
    // The logarithm of 0 is -inf, which the clamp takes to the darkest value.
    let log = vec3(inset.x.log2(), inset.y.log2(), inset.z.log2());
    let x = (log.clamp(Vec3::splat(MIN_EV), Vec3::splat(MAX_EV)) - MIN_EV) / (MAX_EV - MIN_EV);
    let display = OUTSET * agx_contrast(x);
    display.max(Vec3::ZERO).powf(2.2)
}

/// Wrensch's sixth-order fit of AgX's default contrast curve on [0, 1].
fn agx_contrast(x: Vec3) -> Vec3 {
    let (x2, x3) = (x * x, x * x * x);
    let x4 = x2 * x2;
    15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x3 + 0.4298 * x2 + 0.1191 * x - Vec3::splat(0.002_32)
}
