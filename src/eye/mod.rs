//! The eye behind the lens: its pupil, its colours, its glasses, and what it sees of blur.
//!
//! ```text
//! light, age --pupil--> E --+
//! age ------accommodation---+--> Lens --> CoC, for each of the display's primaries
//! prescription, primaries --+
//! ```
//!
//! Distances are used here as *vergences*: reciprocal metres, dioptres (D). What is focused at
//! 0.5 m has 2 D, infinity has 0, and what an eye focuses "beyond infinity" has less than 0: no
//! real distance is sharp then.

mod accommodation;
mod blur;
mod chromatic;
mod comfort;
mod pupil;
mod refraction;

pub use accommodation::{ACCOMMODATION_AGES, amplitude_d};
pub use blur::{BLUR_DETECTION_D, depth_of_focus_d};
pub use chromatic::{DAYLIGHT_NM, PRIMARIES_NM, chromatic_defocus_d};
pub use comfort::{Comfort, ComfortZone, conflict_d};
pub use pupil::{PUPIL_AGES, PUPIL_LUMINANCE_CD_M2, Pupil, PupilError, pupil_diameter_mm};
pub use refraction::{EyePreset, Refraction, RefractionError, eye_presets};

/// What an eye adds to a thin lens. The default adds nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default)]
pub struct Eye {
    /// The glasses that it would need to see sharply at infinity at rest, and does not wear.
    pub refraction: Refraction,
    /// How much nearer than at rest it can focus, D; `None` for as near as is asked.
    pub accommodation_d: Option<f64>,
    /// Dominant wavelengths, nm, of the display's red, green and blue primary, where the eye's
    /// chromatic aberration is to be seen; green is in focus.
    pub chromatic: Option<[f64; 3]>,
    /// How much nearer than it accommodates it is sharp, D, for the one primary that it stands
    /// for ([`Eye::primaries`]); 0 for light as a whole.
    #[serde(skip)]
    pub shift_d: f64,
    /// The same of the primary that is sharp farthest away: what all primaries share is made for
    /// that one.
    #[serde(skip)]
    pub farthest_shift_d: f64,
}

/// Least and greatest wavelength, nm, of a primary: the light that eyes see.
pub const WAVELENGTHS_NM: std::ops::RangeInclusive<f64> = 380.0..=780.0;

/// Why an eye cannot be.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EyeError {
    /// A prescription out of range.
    #[error(transparent)]
    Refraction(#[from] RefractionError),
    /// An accommodation out of range.
    #[error("the eye's accommodation is {0} dioptres: give 0 to 20")]
    Accommodation(f64),
    /// A primary that is not seen.
    #[error("a primary of {0} nm: give wavelengths from 380 to 780 nm")]
    Wavelength(f64),
}

impl Eye {
    /// The eye that adds nothing.
    pub const PLAIN: Self = Self {
        refraction: Refraction { sphere_d: 0.0, cylinder_d: 0.0, axis_deg: 0.0 },
        accommodation_d: None,
        chromatic: None,
        shift_d: 0.0,
        farthest_shift_d: 0.0,
    };

    /// Greatest accommodation, D: more than any child has.
    pub const MOST_ACCOMMODATION_D: f64 = 20.0;

    /// Whether it adds nothing.
    pub fn is_plain(&self) -> bool {
        *self == Self::PLAIN
    }

    /// With the chromatic aberration of an eye before usual primaries.
    pub fn chromatic(self) -> Self {
        Self { chromatic: Some(PRIMARIES_NM), ..self }
    }

    /// Errors unless an eye can be so.
    ///
    /// # Errors
    ///
    /// Which value is out of range.
    pub fn check(&self) -> Result<(), EyeError> {
        self.refraction.check()?;
        if let Some(d) = self.accommodation_d
            && !(0.0..=Self::MOST_ACCOMMODATION_D).contains(&d)
        {
            return Err(EyeError::Accommodation(d));
        }
        match self.chromatic.iter().flatten().find(|nm| !WAVELENGTHS_NM.contains(*nm)) {
            Some(nm) => Err(EyeError::Wavelength(*nm)),
            None => Ok(()),
        }
    }

    /// The same with what a file could have wrong left out.
    pub fn repaired(self) -> Self {
        if self.check().is_ok() { self } else { Self::default() }
    }

    /// The vergences that it can focus at, D: its far point and its near point, for the mean
    /// of its meridians. The near point is infinite without a limit.
    pub fn range_d(&self) -> [f64; 2] {
        let far = -self.refraction.spherical_equivalent_d();
        [far, far + self.accommodation_d.unwrap_or(f64::INFINITY)]
    }

    /// The vergence, D, at which it is sharpest where it is to focus at `wanted_d`: as near to
    /// that as it can. In green, where it has chromatic aberration.
    pub fn reached_d(&self, wanted_d: f64) -> f64 {
        let [far, near] = self.range_d();
        // Without a refractive error the far point is infinity itself: nothing is shifted.
        if wanted_d < far {
            far
        } else if wanted_d > near {
            near
        } else {
            wanted_d
        }
    }

    /// The vergence, D, at which the primary is sharpest that this eye stands for.
    pub(crate) fn focus_d(&self, wanted_d: f64) -> f64 {
        self.reached_d(wanted_d) + self.shift_d
    }

    /// Eyes that see one primary each, red, green and blue; `None` without chromatic
    /// aberration.
    pub fn primaries(&self) -> Option<[Self; 3]> {
        let primaries_nm = self.chromatic?;
        let green = chromatic_defocus_d(primaries_nm[1]);
        // The eye is too weak for red: its focus is farther, at a smaller vergence.
        let shifts_d = primaries_nm.map(|nm| green - chromatic_defocus_d(nm));
        let farthest_shift_d = shifts_d.into_iter().fold(f64::INFINITY, f64::min);
        Some(shifts_d.map(|shift_d| Self { chromatic: None, shift_d, farthest_shift_d, ..*self }))
    }

    /// Why it does not see sharply what it is to focus at, `wanted_d` D, in a sentence; `None`
    /// where it does.
    pub fn out_of_reach(&self, wanted_d: f64) -> Option<String> {
        let reached = self.reached_d(wanted_d);
        if (reached - wanted_d).abs() < 1e-9 {
            return None;
        }
        let at = |d: f64| match d {
            d if d > 1e-9 => format!("{} m", rounded(1.0 / d)),
            d if d < -1e-9 => "no distance, not even at infinity".to_owned(),
            _ => "infinity".to_owned(),
        };
        let [far, _] = self.range_d();
        Some(if reached > wanted_d {
            format!("focused at {}, but the far point of this eye is {}: sharpest there", at(wanted_d), at(far))
        } else {
            let has = self.accommodation_d.unwrap_or(0.0);
            format!(
                "focused at {} needs {} D of accommodation; this eye has {} D: sharpest at {}",
                at(wanted_d),
                rounded(wanted_d - far),
                rounded(has),
                at(reached)
            )
        })
    }
}

/// To a hundredth, for people.
fn rounded(value: f64) -> f64 {
    (1e2 * value).round() / 1e2
}
