//! The pupil by light and age: Watson and Yellott, "A Unified Formula for Light-Adapted Pupil
//! Size" (Journal of Vision 12(10):12, 2012).

use std::ops::RangeInclusive;

/// Ages, years, of the people whose pupils the formula was fitted to.
pub const PUPIL_AGES: RangeInclusive<f64> = 20.0..=83.0;

/// Luminances, cd/m2, over which the formula was fitted.
pub const PUPIL_LUMINANCE_CD_M2: RangeInclusive<f64> = 1e-4..=1e4;

/// Age, years, of the observers of the formula that this one corrects for age.
const REFERENCE_AGE: f64 = 28.58;

/// Share of the light that one eye's pupil answers to when the other is covered.
const ONE_EYE: f64 = 0.1;

/// What a pupil's width depends on.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default)]
pub struct Pupil {
    /// Luminance that the eye is adapted to, cd/m2.
    pub luminance_cd_m2: f64,
    /// Diameter of the lit field, degrees.
    pub field_deg: f64,
    /// Whether both eyes see it.
    pub both_eyes: bool,
    /// Age, years.
    pub age_years: f64,
}

impl Default for Pupil {
    /// Both eyes of thirty-year-olds before a field of 60 degrees and 100 cd/m2.
    fn default() -> Self {
        Self { luminance_cd_m2: 100.0, field_deg: 60.0, both_eyes: true, age_years: 30.0 }
    }
}

/// Light or an age that the formula does not hold for.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PupilError {
    /// Luminance.
    #[error("{0} cd/m2: the pupil's width is known for 0.0001 to 10000 cd/m2")]
    Luminance(f64),
    /// Age.
    #[error("{0} years: the pupil's width is known for ages from 20 to 83")]
    Age(f64),
    /// Field.
    #[error("a field of {0} degrees: give more than 0, up to 180")]
    Field(f64),
}

impl Pupil {
    /// Errors where the formula does not hold.
    ///
    /// # Errors
    ///
    /// What lies outside the data.
    pub fn check(&self) -> Result<(), PupilError> {
        if !PUPIL_LUMINANCE_CD_M2.contains(&self.luminance_cd_m2) {
            return Err(PupilError::Luminance(self.luminance_cd_m2));
        }
        if !PUPIL_AGES.contains(&self.age_years) {
            return Err(PupilError::Age(self.age_years));
        }
        if !(self.field_deg > 0.0 && self.field_deg <= 180.0) {
            return Err(PupilError::Field(self.field_deg));
        }
        Ok(())
    }

    /// The same with what a file could have wrong replaced by the default.
    pub fn repaired(self) -> Self {
        if self.check().is_ok() { self } else { Self::default() }
    }

    /// Its diameter, mm.
    pub fn diameter_mm(&self) -> f64 {
        let radius_deg = 0.5 * self.field_deg;
        let area_deg2 = std::f64::consts::PI * radius_deg * radius_deg;
        let eyes = if self.both_eyes { 1.0 } else { ONE_EYE };
        pupil_diameter_mm(self.luminance_cd_m2 * area_deg2 * eyes, self.age_years)
    }
}

/// Diameter of the pupil, mm, by effective corneal flux density (cd/m2 deg2: luminance times
/// the field's area, a tenth of that for one eye) and age, years.
///
/// The formula of Stanley and Davies (1995), `D = 7.75 - 5.75 x / (x + 2)` with
/// `x = (flux / 846)^0.41`, plus `(age - 28.58) (0.02132 - 0.009562 D)`.
pub fn pupil_diameter_mm(flux_cd_m2_deg2: f64, age_years: f64) -> f64 {
    let x = (flux_cd_m2_deg2 / 846.0).powf(0.41);
    let of_the_young = 7.75 - 5.75 * (x / (x + 2.0));
    of_the_young + (age_years - REFERENCE_AGE) * (0.02132 - 0.009562 * of_the_young)
}
