//! How a picture is looked at: what decides whether a difference in it is visible.
//!
//! A difference that a desktop monitor shows may be too fine for a head-mounted display, and
//! one that a bright display shows too faint for a dark one. Metrics of vision therefore ask
//! for the display's pixels per degree and for its luminance.

pub use crate::eye::PRIMARIES_NM;
use crate::lens::Lens;
use std::ops::RangeInclusive;

/// Angular resolutions that metrics are computed for, px per degree. The filters of FLIP grow
/// with it: at the upper end they are 137 px wide.
pub const PX_PER_DEGREE: RangeInclusive<f64> = 1.0..=500.0;

/// Peak luminances of displays, cd/m2: from one that is all but off to the brightest that
/// ColorVideoVDP is computed for.
pub const PEAK_CD_M2: RangeInclusive<f64> = 0.1..=100_000.0;

/// FLIP's viewer: 0.7 m before a display of 3840 px on 0.7 m, 3840 pi / 180 px per degree
/// (Andersson et al. 2020).
pub const FLIP_PX_PER_DEGREE: f64 = 67.020_64;

/// Luminance of diffuse white on a display of high dynamic range, cd/m2: ITU-R BT.2408-7,
/// table 1. The linear display value 1 is shown so.
pub const HDR_WHITE_CD_M2: f64 = 203.0;

/// Share of the surrounding light that a display's surface reflects: the default of
/// ColorVideoVDP, for a matt or coated screen.
const REFLECTIVITY: f64 = 0.005;

/// Light that a display gives, and the light around it.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default)]
pub struct Screen {
    /// Luminance of white, cd/m2, in [`PEAK_CD_M2`].
    pub peak_cd_m2: f64,
    /// Luminance of black in the dark, cd/m2, at most the peak.
    pub black_cd_m2: f64,
    /// Light that falls on the screen, lux; 0 in the dark and in a head-mounted display.
    pub ambient_lux: f64,
    /// Whether it shows values above white, up to the peak; white itself is then
    /// [`HDR_WHITE_CD_M2`], or the peak of a darker one.
    pub hdr: bool,
    /// Dominant wavelengths of its red, green and blue primaries, nm.
    pub primaries_nm: [f64; 3],
}

impl Default for Screen {
    /// A monitor in an office: `standard_4k` of ColorVideoVDP, 200 cd/m2 with a contrast of
    /// 1000 under 250 lux.
    fn default() -> Self {
        Self { peak_cd_m2: 200.0, black_cd_m2: 0.2, ambient_lux: 250.0, hdr: false, primaries_nm: PRIMARIES_NM }
    }
}

/// A screen that cannot be.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ScreenError {
    /// A peak out of range.
    #[error(
        "the display's peak luminance is {0} cd/m2: give {low} to {high}",
        low = PEAK_CD_M2.start(),
        high = PEAK_CD_M2.end()
    )]
    Peak(f64),
    /// A black that is none.
    #[error("the display's black is {black} cd/m2: give 0 to its peak of {peak} cd/m2")]
    Black {
        /// The value given, cd/m2.
        black: f64,
        /// The peak, cd/m2.
        peak: f64,
    },
    /// Light that cannot be.
    #[error("the light on the display is {0} lux: give 0 to 100000")]
    Ambient(f64),
}

impl Screen {
    /// Errors unless a display can be so.
    ///
    /// # Errors
    ///
    /// Which value is out of range.
    pub fn check(&self) -> Result<(), ScreenError> {
        if !PEAK_CD_M2.contains(&self.peak_cd_m2) {
            return Err(ScreenError::Peak(self.peak_cd_m2));
        }
        if !(0.0..=self.peak_cd_m2).contains(&self.black_cd_m2) {
            return Err(ScreenError::Black { black: self.black_cd_m2, peak: self.peak_cd_m2 });
        }
        if !(0.0..=100_000.0).contains(&self.ambient_lux) {
            return Err(ScreenError::Ambient(self.ambient_lux));
        }
        Ok(())
    }

    /// The same with what a file could have wrong replaced by the default.
    pub fn repaired(self) -> Self {
        if self.check().is_ok() && self.primaries_nm.iter().all(|nm| (380.0..=780.0).contains(nm)) {
            self
        } else {
            Self::default()
        }
    }

    /// Luminance of the linear display value 1, cd/m2.
    pub fn white_cd_m2(&self) -> f64 {
        if self.hdr { HDR_WHITE_CD_M2.min(self.peak_cd_m2) } else { self.peak_cd_m2 }
    }

    /// Surrounding light that the screen reflects, cd/m2, as of a matt surface: `E / pi` of
    /// its reflectivity of 0.005.
    pub(crate) fn reflected_cd_m2(&self) -> f64 {
        self.ambient_lux / std::f64::consts::PI * REFLECTIVITY
    }

    /// Share of the surrounding light that every screen reflects.
    pub fn reflectivity() -> f64 {
        REFLECTIVITY
    }

    /// Mean luminance, cd/m2, that an eye adapts to before this display where nothing is
    /// known of the picture: the mid-grey of sRGB, 18 % of white, and what is reflected.
    pub fn adapting_cd_m2(&self) -> f64 {
        0.18 * self.white_cd_m2() + self.black_cd_m2 + self.reflected_cd_m2()
    }
}

/// Under what angle and in what light a picture is looked at.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Viewing {
    /// Pixels of the picture in a degree of the eye's view, in [`PX_PER_DEGREE`].
    pub px_per_degree: f64,
    /// The display's light.
    pub screen: Screen,
}

impl Default for Viewing {
    /// FLIP's viewer, 67 px per degree, before [`Screen::default`].
    fn default() -> Self {
        Self { px_per_degree: FLIP_PX_PER_DEGREE, screen: Screen::default() }
    }
}

impl Viewing {
    /// Before the display that `lens` describes. One with more or fewer pixels per degree than
    /// [`PX_PER_DEGREE`] counts as the nearest that metrics are computed for.
    pub fn of(lens: &Lens, screen: Screen) -> Self {
        let px_per_degree = lens.px_per_degree().clamp(*PX_PER_DEGREE.start(), *PX_PER_DEGREE.end());
        Self { px_per_degree, screen }
    }

    /// The same at `px_per_degree`, where that is given.
    pub fn with_ppd(self, px_per_degree: Option<f64>) -> Self {
        Self { px_per_degree: px_per_degree.unwrap_or(self.px_per_degree), ..self }
    }
}
