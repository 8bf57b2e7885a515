//! How much of the light methods are given: all of it, or what a display has room for.
//!
//! Tones that are mapped or cut *before* the blur spread as dim discs where a lens spreads bright
//! ones (Lee, Kim and Choi, Pacific Graphics 2008, section 4, Fig. 9). It happens where colours
//! enter a view, so that every method gets the same.

use crate::display::LUMINANCE;
use glam::Vec3;
use std::fmt;
use std::str::FromStr;

/// What becomes of colours before anything is blurred.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Input {
    /// Nothing: linear radiance of any range.
    #[default]
    Hdr,
    /// What is above white is cut.
    Clamped {
        /// White, linear radiance, above 0.
        white: f32,
    },
    /// `L / (1 + L)` on luminances that are scaled such that their log-average over the pinhole
    /// image is the key a: Reinhard, Stark, Shirley and Ferwerda, "Photographic Tone Reproduction
    /// for Digital Images" (SIGGRAPH 2002), equations (1) to (3).
    Reinhard {
        /// a, above 0: 0.18 is usual, 0.72 that of the paper's Fig. 9.
        key: f32,
    },
}

/// Reinhard's usual key.
const USUAL_KEY: f32 = 0.18;

/// A text that names no [`Input`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "there is no input '{}': give hdr, clamped[:WHITE] or reinhard[:KEY], with a number above 0 such as reinhard:0.72",
    .0.escape_debug()
)]
pub struct UnknownInput(pub String);

impl fmt::Display for Input {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Hdr => f.write_str("hdr"),
            Self::Clamped { white } => write!(f, "clamped:{white}"),
            Self::Reinhard { key } => write!(f, "reinhard:{key}"),
        }
    }
}

impl From<Input> for String {
    fn from(input: Input) -> Self {
        input.to_string()
    }
}

impl TryFrom<String> for Input {
    type Error = UnknownInput;

    fn try_from(text: String) -> Result<Self, UnknownInput> {
        text.parse()
    }
}

impl FromStr for Input {
    type Err = UnknownInput;

    fn from_str(text: &str) -> Result<Self, UnknownInput> {
        let (name, number) = text.split_once(':').map_or((text, None), |(name, number)| (name, Some(number)));
        let positive = |otherwise: f32| match number {
            None => Some(otherwise),
            Some(number) => number.parse().ok().filter(|n: &f32| n.is_finite() && *n > 0.0),
        };
        let known = match name {
            "hdr" if number.is_none() => Some(Self::Hdr),
            "clamped" => positive(1.0).map(|white| Self::Clamped { white }),
            "reinhard" => positive(USUAL_KEY).map(|key| Self::Reinhard { key }),
            _ => None,
        };
        known.ok_or_else(|| UnknownInput(text.into()))
    }
}

/// An [`Input`] for one view, whose log-average is known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Tone {
    /// Colours as they are.
    #[default]
    Linear,
    /// Cut at a white.
    Clamped(f32),
    /// Reinhard's curve over luminances times a factor.
    Reinhard(f32),
}

impl Tone {
    /// As `View::tone` and `View::tone_scale` in `shaders/scene.wgsl`.
    pub(super) fn uniform(self) -> (u32, f32) {
        match self {
            Self::Linear => (0, 1.0),
            Self::Clamped(white) => (1, white),
            Self::Reinhard(scale) => (2, scale),
        }
    }

    /// What is given of a linear colour: `toned` in the shader.
    pub fn apply(self, color: Vec3) -> Vec3 {
        match self {
            Self::Linear => color,
            Self::Clamped(white) => color.min(Vec3::splat(white)),
            Self::Reinhard(scale) => {
                let scaled = color * scale;
                (scaled / (1.0 + scaled.dot(LUMINANCE).max(0.0))).min(Vec3::ONE)
            }
        }
    }
}
