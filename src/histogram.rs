//! How often values occur.

use std::ops::RangeInclusive;

/// Counts of values in bins of one width.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    range: RangeInclusive<f64>,
    counts: Vec<u64>,
    below: u64,
    above: u64,
}

impl Histogram {
    /// Counts `values` in `bins` bins over `range`. What lies outside is counted apart, NaN
    /// is not counted. A range without width, or one that is not finite, has no inside.
    pub fn of(values: impl IntoIterator<Item = f64>, range: RangeInclusive<f64>, bins: usize) -> Self {
        let (low, high) = (*range.start(), *range.end());
        let scale = bins as f64 / (high - low);
        let mut histogram = Self { range, counts: vec![0; bins], below: 0, above: 0 };
        for value in values {
            if value < low {
                histogram.below += 1;
            } else if value > high {
                histogram.above += 1;
            } else if let Some(count) = histogram.counts.get_mut(bin(value - low, scale, bins)) {
                *count += 1;
            }
        }
        histogram
    }

    /// Count of each bin, the lowest first.
    pub fn counts(&self) -> &[u64] {
        &self.counts
    }

    /// Values below the range and above it.
    pub fn outside(&self) -> [u64; 2] {
        [self.below, self.above]
    }

    /// Values counted, inside or out.
    pub fn total(&self) -> u64 {
        self.counts.iter().sum::<u64>() + self.below + self.above
    }

    /// What the bins cover.
    pub fn range(&self) -> RangeInclusive<f64> {
        self.range.clone()
    }

    /// Each bin's count over the greatest one; all 0 where nothing was counted.
    pub fn heights(&self) -> Vec<f32> {
        let greatest = self.counts.iter().copied().max().unwrap_or(0).max(1);
        self.counts.iter().map(|c| (*c as f64 / greatest as f64) as f32).collect()
    }
}

/// The bin of a value; beyond all of them for what has none. The upper end of the range
/// belongs to the last bin.
fn bin(above_low: f64, scale: f64, bins: usize) -> usize {
    let position = above_low * scale;
    if position >= 0.0 && position.is_finite() { (position as usize).min(bins.saturating_sub(1)) } else { usize::MAX }
}
