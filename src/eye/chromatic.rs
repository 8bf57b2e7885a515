//! Longitudinal chromatic aberration of the eye.

/// The lines of daylight by which glasses are named, nm: F (blue) and C (red) of hydrogen.
pub const DAYLIGHT_NM: [f64; 2] = [486.13, 656.27];

/// Dominant wavelengths of primaries where nothing else is known, red, green and blue, nm:
/// those of Cholewiak et al., "ChromaBlur" (SIGGRAPH Asia 2017).
pub const PRIMARIES_NM: [f64; 3] = [617.0, 520.0, 449.0];

/// Chromatic difference of refraction, D, at a wavelength, nm: how much a lens before the eye
/// would have to add for light of that colour; 0 at 589 nm. Greater for red, for which the eye
/// is too weak, than for blue.
///
/// The reduced eye of Thibos, Ye, Zhang and Bradley, "The Chromatic Eye" (Applied Optics 31,
/// 1992): `1.68524 - 633.46 / (nm - 214.102)`.
pub fn chromatic_defocus_d(wavelength_nm: f64) -> f64 {
    1.68524 - 633.46 / (wavelength_nm - 214.102)
}
