//! Lenses by name: those of the papers and of today's displays, from `assets/presets.ron`.

use crate::lens::Lens;
use crate::viewing::Screen;
use std::sync::LazyLock;

/// A named lens with where its numbers come from.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct LensPreset {
    /// Short name, as on the command line.
    pub name: String,
    /// What it stands for, one line.
    pub title: String,
    /// Source and derivation of its numbers.
    pub source: String,
    /// The lens, in focus at a distance that suits it.
    pub lens: Lens,
    /// The display, where it is worn on the head.
    #[serde(default)]
    pub headset: Option<Headset>,
    /// The display's light, where it is known.
    #[serde(default)]
    pub screen: Option<Screen>,
}

/// A head-mounted display: what the lens does not say about it.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Headset {
    /// Pixels of one eye's display.
    pub eye_px: (u32, u32),
    /// Fastest refresh, Hz.
    pub refresh_hz: f64,
}

/// A name that no preset has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no lens preset '{}': the presets are {known}", name.escape_debug())]
pub struct UnknownPreset {
    /// The name given.
    pub name: String,
    /// The names there are, separated by commas.
    pub known: String,
}

/// All presets, in the order in which to show them.
pub fn presets() -> Vec<LensPreset> {
    // Parsed once: the window asks in every frame.
    static PRESETS: LazyLock<Vec<LensPreset>> = LazyLock::new(|| {
        // Part of the program, not of its input: a mistake in it is found by any test.
        ron::from_str(include_str!("../assets/presets.ron")).expect("assets/presets.ron does not parse")
    });
    PRESETS.clone()
}

/// The preset called `name`; the error lists those there are.
pub fn preset(name: &str) -> Result<LensPreset, UnknownPreset> {
    let all = presets();
    let known = all.iter().map(|p| p.name.as_str()).collect::<Vec<_>>().join(", ");
    all.into_iter().find(|p| p.name == name).ok_or_else(|| UnknownPreset { name: name.into(), known })
}
