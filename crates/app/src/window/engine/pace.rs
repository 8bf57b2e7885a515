//! How large a picture can be drawn without holding the interface up: learned from the
//! times of the last ones.

use crate::window::model::MethodChoice;
use glam::UVec2;
use std::collections::BTreeMap;

/// What the interface may wait for a picture in a frame, ms: half of the 100 ms within which
/// an answer is felt as immediate, the other half being for all else.
pub const BUDGET_MS: f64 = 50.0;

/// How much smaller pictures are drawn that would take too long.
pub const DIVISORS: [u32; 4] = [1, 2, 4, 8];

/// Time of a million pixels of a method that was not seen yet on a software adapter, ms: the
/// cheapest that blur take about half of that on two cores, so that nothing starts too large.
const UNKNOWN_MS_PER_MEGAPIXEL: f64 = 500.0;

/// How time grows with the side of the picture where only a smaller one was seen: with its
/// area for most methods, with its square for those that draw a spot a pixel. Between the
/// two, since what is guessed too slow is measured beside the interface and then known.
const UNKNOWN_EXPONENT: f64 = 3.0;

/// A picture that was too slow counts as quick enough below this share of the budget: times
/// scatter, and the picture should not change its size with them.
const RELIEF: f64 = 0.7;

/// What times are comparable for.
#[derive(Clone, Debug, PartialEq)]
pub struct Workload {
    /// The method with its parameters.
    pub method: MethodChoice,
    /// The full size, px.
    pub size: UVec2,
}

/// The last time at one size.
#[derive(Clone, Copy, Debug)]
struct Known {
    ms: f64,
    blur_px: f64,
}

/// Times of a pane's pictures by how much smaller they were drawn.
#[derive(Clone, Debug, Default)]
pub struct Pace {
    of: Option<Workload>,
    known: BTreeMap<u32, Known>,
    was_slow: bool,
}

/// What the adapter is like, and what there is time for.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Time for a picture, ms.
    pub budget_ms: f64,
    /// Whether the adapter is a program: then what was not seen yet counts as slow.
    pub is_software: bool,
}

impl Pace {
    /// Times of another workload mean nothing for this one; true if it is another.
    pub fn follow(&mut self, workload: &Workload) -> bool {
        let is_other = self.of.as_ref() != Some(workload);
        if is_other {
            *self = Self { of: Some(workload.clone()), ..Self::default() };
        }
        is_other
    }

    /// Whether nothing is known yet.
    pub fn is_unknown(&self) -> bool {
        self.known.is_empty()
    }

    /// Takes in the time of a picture drawn `divisor` times smaller with a mean blur of
    /// `blur_px` (at full size).
    pub fn learn(&mut self, divisor: u32, ms: f64, blur_px: f64) {
        self.known.insert(divisor, Known { ms, blur_px });
    }

    /// Time that a picture is expected to take, ms.
    fn expected_ms(&self, divisor: u32, blur_px: f64, limits: Limits) -> f64 {
        let Some(workload) = &self.of else { return 0.0 };
        // The nearest that is known; of two as near, the finer.
        let nearest = self.known.iter().min_by_key(|(known, _)| known.ilog2().abs_diff(divisor.ilog2()));
        let Some((known, at)) = nearest else {
            let pixels = workload.size.as_dvec2().element_product() / f64::from(divisor * divisor);
            return if limits.is_software { UNKNOWN_MS_PER_MEGAPIXEL * 1e-6 * pixels } else { 0.0 };
        };
        let side = f64::from(*known) / f64::from(divisor);
        let exponent = if side > 1.0 { UNKNOWN_EXPONENT } else { 2.0 };
        // What spreads light over the circle of confusion takes time as its area does.
        let wider = if at.blur_px > 0.0 { (blur_px / at.blur_px).max(1.0) } else { 1.0 };
        at.ms * side.powf(exponent) * wider * wider
    }

    /// Whether the full picture takes longer than there is time for.
    pub fn is_slow(&mut self, blur_px: f64, limits: Limits) -> bool {
        let limit = limits.budget_ms * if self.was_slow { RELIEF } else { 1.0 };
        self.was_slow = self.expected_ms(1, blur_px, limits) > limit;
        self.was_slow
    }

    /// How many times smaller than in full a slow picture is to be drawn: the finest that
    /// there is time for, or the coarsest.
    pub fn divisor(&self, blur_px: f64, limits: Limits) -> u32 {
        let in_time = |divisor: &u32| self.expected_ms(*divisor, blur_px, limits) <= limits.budget_ms;
        let coarser = DIVISORS.into_iter().filter(|divisor| *divisor > 1);
        coarser.clone().find(in_time).or(coarser.max()).unwrap_or(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::uvec2;

    const SOFTWARE: Limits = Limits { budget_ms: 50.0, is_software: true };

    fn pace(size: UVec2) -> Pace {
        let mut pace = Pace::default();
        pace.follow(&Workload { method: MethodChoice::new("splat"), size });
        pace
    }

    #[test]
    fn what_was_not_seen_yet_is_slow_in_software_only_and_only_where_it_is_large() {
        assert!(pace(uvec2(1024, 768)).is_slow(8.0, SOFTWARE));
        assert!(!pace(uvec2(1024, 768)).is_slow(8.0, Limits { is_software: false, ..SOFTWARE }));
        assert!(!pace(uvec2(256, 192)).is_slow(8.0, SOFTWARE));
    }

    #[test]
    fn a_wider_blur_is_expected_to_take_longer() {
        let mut pace = pace(uvec2(1024, 768));
        pace.learn(1, 20.0, 4.0);
        assert!(!pace.is_slow(4.0, SOFTWARE));
        assert!(!pace.is_slow(2.0, SOFTWARE), "a narrower one is not expected to take less, nor more");
        assert!(pace.is_slow(25.0, SOFTWARE), "20 ms at 4 px may be 781 ms at 25 px");
        assert_eq!(pace.divisor(25.0, SOFTWARE), 4);
    }

    #[test]
    fn what_proved_quick_is_drawn_in_full_and_what_proved_slow_is_not() {
        let mut pace = pace(uvec2(1024, 768));
        assert!(pace.is_slow(8.0, SOFTWARE));
        assert_eq!(
            pace.divisor(8.0, SOFTWARE),
            4,
            "98304 px fit into 50 ms at the time of the unknown, and 196608 do not"
        );
        pace.learn(4, 2.0, 8.0);
        assert!(pace.is_slow(8.0, SOFTWARE), "64 times as long is too long");
        pace.learn(1, 40.0, 8.0);
        assert!(pace.is_slow(8.0, SOFTWARE), "times scatter: what was slow must be well below the budget");
        pace.learn(1, 30.0, 8.0);
        assert!(!pace.is_slow(8.0, SOFTWARE));
        pace.learn(1, 14_000.0, 8.0);
        assert!(pace.is_slow(8.0, SOFTWARE));
        // The coarse one is what was measured last at that size.
        assert_eq!(pace.divisor(8.0, SOFTWARE), 4);
    }

    #[test]
    fn another_method_or_size_starts_anew() {
        let mut pace = pace(uvec2(256, 192));
        pace.learn(1, 1000.0, 8.0);
        assert!(pace.is_slow(8.0, SOFTWARE));
        pace.follow(&Workload { method: MethodChoice::new("mipmap"), size: uvec2(256, 192) });
        assert!(pace.is_unknown() && !pace.is_slow(8.0, SOFTWARE));
    }
}
