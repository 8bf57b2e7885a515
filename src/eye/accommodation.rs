//! How near an eye can focus.

use std::ops::RangeInclusive;

/// Ages, years, for which the formula is used: those of Duane's (1912) and Donders' (1864)
/// people, whose eyes it sums up.
pub const ACCOMMODATION_AGES: RangeInclusive<f64> = 8.0..=83.0;

/// Amplitude of accommodation, D, of the average eye of that age: Hofstetter, "Useful
/// Age-Amplitude Formula" (Optometric World 38, 1950):
/// `18.5 - 0.3 age`, and none from where that reaches 0, at 61.7 years.
pub fn amplitude_d(age_years: f64) -> f64 {
    (18.5 - 0.3 * age_years).max(0.0)
}
