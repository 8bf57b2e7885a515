//! A list of states to be run one after the other: aperture, focus and method.

use super::method::MethodChoice;
use defocus::lens::Lens;

/// Rows of a batch at most: each with a lens of its own takes a reference.
pub const MOST_BATCH_ROWS: usize = 500;

/// A state of a batch; all else is as the document has it.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct BatchRow {
    /// E, mm.
    pub aperture_mm: f64,
    /// Focus distance, metres.
    pub focus_m: f64,
    /// The method.
    pub method: MethodChoice,
}

impl BatchRow {
    /// `lens` with the row's aperture and focus.
    pub fn lens(&self, lens: &Lens) -> Lens {
        Lens { aperture_diameter_mm: self.aperture_mm, focus_distance_m: self.focus_m, ..lens.clone() }
    }

    /// The same with what a file could have wrong put right.
    pub fn repaired(self) -> Self {
        let or = |value: f64, other: f64| if value.is_nan() || value < 0.0 { other } else { value };
        Self { aperture_mm: or(self.aperture_mm, 0.0).min(1e4), focus_m: or(self.focus_m, 1.0), ..self }
    }
}
