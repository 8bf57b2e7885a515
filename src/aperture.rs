//! The aperture's intensity distribution (IDF) and points on it.

/// The intensity distribution over the aperture.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Aperture {
    /// Uniform over the unit disc.
    #[default]
    Disc,
}
