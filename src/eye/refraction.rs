//! Refractive error as a prescription of glasses.

use glam::DMat2;
use std::fmt;

/// A prescription in minus or plus cylinder form, as opticians write it: `-3.00 -1.50 x 90`.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default)]
pub struct Refraction {
    /// Sphere, D: negative for the short-sighted, positive for the far-sighted.
    pub sphere_d: f64,
    /// Cylinder, D: what is added across the axis; 0 without astigmatism.
    pub cylinder_d: f64,
    /// Axis of the cylinder, degrees, 0 to 180, counterclockwise from the right of whoever
    /// faces the eye (ISO 8429). In the picture that the eye sees, whose y points down, it is
    /// the direction `(cos, sin)`.
    pub axis_deg: f64,
}

/// A prescription that no glasses have.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RefractionError {
    /// Sphere.
    #[error("a sphere of {0} dioptres: give -30 to 30")]
    Sphere(f64),
    /// Cylinder.
    #[error("a cylinder of {0} dioptres: give -10 to 10")]
    Cylinder(f64),
    /// Axis.
    #[error("an axis of {0} degrees: give 0 to 180")]
    Axis(f64),
}

impl Refraction {
    /// Greatest sphere, D, either way.
    pub const MOST_SPHERE_D: f64 = 30.0;

    /// Greatest cylinder, D, either way.
    pub const MOST_CYLINDER_D: f64 = 10.0;

    /// Errors unless glasses could be so.
    ///
    /// # Errors
    ///
    /// Which value is out of range.
    pub fn check(&self) -> Result<(), RefractionError> {
        if !(-Self::MOST_SPHERE_D..=Self::MOST_SPHERE_D).contains(&self.sphere_d) {
            return Err(RefractionError::Sphere(self.sphere_d));
        }
        if !(-Self::MOST_CYLINDER_D..=Self::MOST_CYLINDER_D).contains(&self.cylinder_d) {
            return Err(RefractionError::Cylinder(self.cylinder_d));
        }
        if !(0.0..=180.0).contains(&self.axis_deg) {
            return Err(RefractionError::Axis(self.axis_deg));
        }
        Ok(())
    }

    /// Power of the mean of all meridians, D: sphere and half the cylinder.
    pub fn spherical_equivalent_d(&self) -> f64 {
        self.sphere_d + 0.5 * self.cylinder_d
    }

    /// Power, D, in the meridian at `meridian_deg`: sphere and as much of the cylinder as the
    /// squared sine of the angle to its axis.
    pub fn power_d(&self, meridian_deg: f64) -> f64 {
        self.sphere_d + self.cylinder_d * (meridian_deg - self.axis_deg).to_radians().sin().powi(2)
    }

    /// How the vergence at which the eye is sharp differs from that of the mean meridian, D,
    /// as a matrix on directions in the picture (y down): symmetric, without trace. Long,
    /// "The Matrix Formalism for Obtaining the Dioptric Power" (Optometry 1976), less the
    /// spherical equivalent and with its sign turned about.
    pub fn astigmatism_d(&self) -> DMat2 {
        let (sin, cos) = (2.0 * self.axis_deg.to_radians()).sin_cos();
        let half = 0.5 * self.cylinder_d;
        DMat2::from_cols_array(&[half * cos, half * sin, half * sin, -half * cos])
    }
}

impl fmt::Display for Refraction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:+.2} D", self.sphere_d)?;
        if self.cylinder_d != 0.0 {
            write!(f, " {:+.2} D x {:.0}", self.cylinder_d, self.axis_deg)?;
        }
        Ok(())
    }
}

/// An eye by name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EyePreset {
    /// Short name, as on the command line.
    pub name: &'static str,
    /// What it stands for.
    pub title: &'static str,
    /// Its prescription.
    pub refraction: Refraction,
    /// Its age, years, which decides its accommodation.
    pub age_years: f64,
}

/// Eyes to start from.
pub fn eye_presets() -> [EyePreset; 4] {
    let eye = |name, title, (sphere_d, cylinder_d, axis_deg), age_years| EyePreset {
        name,
        title,
        refraction: Refraction { sphere_d, cylinder_d, axis_deg },
        age_years,
    };
    [
        eye("emmetrope", "Needs no glasses, 25 years", (0.0, 0.0, 0.0), 25.0),
        eye("presbyope", "Needs reading glasses, 55 years", (0.0, 0.0, 0.0), 55.0),
        eye("myope", "Short-sighted, -3 D, 25 years", (-3.0, 0.0, 0.0), 25.0),
        eye("astigmat", "Astigmatic, -1.5 D x 90, 25 years", (0.0, -1.5, 90.0), 25.0),
    ]
}
