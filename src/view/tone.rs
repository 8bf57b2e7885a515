//! How much of the light methods are given: all of it, or what a display has room for.
//!
//! Tones that are mapped or cut *before* the blur spread as dim discs where a lens spreads bright
//! ones (Lee, Kim and Choi, Pacific Graphics 2008, section 4, Fig. 9). It happens where colours
//! enter a view, so that every method gets the same.

use super::{Layer, Source, View};
use crate::display::LUMINANCE;
use crate::gpu::{Gpu, download, upload};
use crate::image::ColorImage;
use glam::{UVec2, Vec3};
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

/// Added to luminances before their logarithm, so that a black pixel is one among others:
/// equation (1)'s delta.
const DARKEST: f64 = 1e-4;

/// Log-average luminance, Reinhard's equation (1).
fn log_average(image: &ColorImage) -> f64 {
    let log = |color: &Vec3| (DARKEST + f64::from(color.dot(LUMINANCE).max(0.0))).ln();
    (image.pixels.iter().map(log).sum::<f64>() / image.pixels.len().max(1) as f64).exp()
}

impl View {
    /// Gives methods `input` from now on and returns what becomes of a colour. Forgets what was
    /// drawn if that changes anything. [`Input::Reinhard`] waits for the pinhole image.
    pub fn set_input(&mut self, gpu: &Gpu, input: Input) -> Tone {
        let tone = match input {
            Input::Hdr => Tone::Linear,
            Input::Clamped { white } => Tone::Clamped(white),
            Input::Reinhard { key } => {
                self.set_tone(gpu, Tone::Linear);
                let mut frame = gpu.frame();
                let outer = self.pinhole(&mut frame).color;
                frame.finish();
                let inner = download(gpu, &outer).crop(UVec2::splat(self.projection.overscan_px), self.size());
                Tone::Reinhard((f64::from(key) / log_average(&inner)) as f32)
            }
        };
        self.set_tone(gpu, tone);
        tone
    }

    /// What becomes of a colour before it is blurred.
    pub fn tone(&self) -> Tone {
        self.tone
    }

    fn set_tone(&mut self, gpu: &Gpu, tone: Tone) {
        if self.tone == tone {
            return;
        }
        self.tone = tone;
        match &mut self.source {
            Source::Scene(source) => source.tone = tone,
            Source::Image(layer) => {
                let linear = self.linear_image.get_or_insert_with(|| layer.color.clone());
                let toned = match tone {
                    Tone::Linear => linear.clone(),
                    _ => upload(gpu, "image", &download(gpu, linear).map(|color| tone.apply(color))),
                };
                *layer = Layer { color: toned, depth: layer.depth.clone() };
            }
        }
        self.forget();
    }
}
