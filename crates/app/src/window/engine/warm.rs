//! How long a pane's picture takes: the median of its last frames, the first of which does not
//! count where there are others, since it builds pipelines and fills pools.

use super::history::Quantiles;
use std::collections::VecDeque;

/// Frames over which the median is taken: enough to leave out an odd one, and few enough to
/// follow a lens that is being opened.
const WARM_FRAMES: usize = 9;

/// A time with what it rests on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameTime {
    /// Median of the warm frames, or the time of the first, ms.
    pub ms: f64,
    /// Warm frames that it is the median of; 0 while only the first one was drawn.
    pub warm_frames: usize,
}

/// Times of the frames of one workload.
#[derive(Clone, Debug, Default)]
pub(super) struct WarmTimes {
    divisor: u32,
    cold_ms: Option<f64>,
    warm_ms: VecDeque<f64>,
}

impl WarmTimes {
    /// Takes in the time of a picture that was drawn `divisor` times smaller than in full;
    /// times of another size mean nothing for this one.
    pub fn take(&mut self, divisor: u32, ms: f64) {
        if self.divisor != divisor {
            *self = Self { divisor, ..Self::default() };
        }
        if self.cold_ms.is_none() {
            self.cold_ms = Some(ms);
            return;
        }
        self.warm_ms.push_back(ms);
        if self.warm_ms.len() > WARM_FRAMES {
            self.warm_ms.pop_front();
        }
    }

    /// The time to be told.
    pub fn told(&self) -> Option<FrameTime> {
        let warm_frames = self.warm_ms.len();
        match Quantiles::of(self.warm_ms.iter().copied()) {
            Some(Quantiles { median, .. }) => Some(FrameTime { ms: median, warm_frames }),
            None => self.cold_ms.map(|ms| FrameTime { ms, warm_frames: 0 }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_frame_counts_only_while_it_is_alone() {
        let mut times = WarmTimes::default();
        assert_eq!(times.told(), None);
        times.take(1, 900.0);
        assert_eq!(times.told(), Some(FrameTime { ms: 900.0, warm_frames: 0 }));
        for ms in [10.0, 50.0, 12.0] {
            times.take(1, ms);
        }
        assert_eq!(times.told(), Some(FrameTime { ms: 12.0, warm_frames: 3 }));
        times.take(2, 3.0);
        assert_eq!(times.told(), Some(FrameTime { ms: 3.0, warm_frames: 0 }), "another size begins anew");
    }

    #[test]
    fn old_frames_go() {
        let mut times = WarmTimes::default();
        (0..50).for_each(|frame| times.take(1, if frame < 30 { 100.0 } else { 1.0 }));
        assert_eq!(times.told(), Some(FrameTime { ms: 1.0, warm_frames: WARM_FRAMES }));
    }
}
