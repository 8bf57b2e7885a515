//! Times of the last frames.

use defocus::gpu::PassTime;
use std::collections::{BTreeMap, VecDeque};

/// Frames that are kept.
pub(in crate::window) const FRAMES_KEPT: usize = 120;

/// Times of one frame, ms.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::window) struct FrameTimes {
    pub cpu_ms: f64,
    pub gpu_ms: f64,
    pub passes: BTreeMap<String, f64>,
}

/// The last frames' times.
#[derive(Clone, Debug, Default)]
pub struct History {
    frames: VecDeque<FrameTimes>,
    /// Labels in the order in which their passes run.
    order: Vec<String>,
}

/// Median and 95th percentile, ms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantiles {
    /// Half of the frames took no longer.
    pub median: f64,
    /// 95 % of the frames took no longer.
    pub p95: f64,
}

impl Quantiles {
    /// Nearest-rank quantiles; `None` for no values.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = values.into_iter().collect();
        sorted.sort_by(f64::total_cmp);
        let rank = |share: f64| ((share * sorted.len() as f64).ceil() as usize).saturating_sub(1);
        let at = |share| sorted.get(rank(share)).copied();
        Some(Self { median: at(0.5)?, p95: at(0.95)? })
    }
}

impl History {
    /// Adds a frame: time to record it on the CPU, ms, and its passes on the GPU. Passes
    /// of the same label are added up.
    pub fn push(&mut self, cpu_ms: f64, passes: &[PassTime]) {
        let mut times = FrameTimes { cpu_ms, ..Default::default() };
        let mut order: Vec<String> = Vec::new();
        for pass in passes {
            times.gpu_ms += pass.ms;
            *times.passes.entry(pass.label.clone()).or_default() += pass.ms;
            if !order.contains(&pass.label) {
                order.push(pass.label.clone());
            }
        }
        self.frames.push_back(times);
        if self.frames.len() > FRAMES_KEPT {
            self.frames.pop_front();
        }
        let earlier = std::mem::take(&mut self.order);
        let gone = |label: &String| !self.frames.iter().any(|f| f.passes.contains_key(label));
        let rest: Vec<_> = earlier.into_iter().filter(|label| !order.contains(label) && !gone(label)).collect();
        self.order = order.into_iter().chain(rest).collect();
    }

    /// Time of the last frame, ms: the longer of recording it and running it.
    pub fn last_ms(&self) -> Option<f64> {
        self.frames.back().map(|f| f.cpu_ms.max(f.gpu_ms))
    }

    /// GPU time of whole frames.
    pub fn gpu(&self) -> Option<Quantiles> {
        Quantiles::of(self.frames.iter().map(|f| f.gpu_ms))
    }

    /// CPU time of recording frames.
    pub fn cpu(&self) -> Option<Quantiles> {
        Quantiles::of(self.frames.iter().map(|f| f.cpu_ms))
    }

    /// GPU time of each pass over the frames that have it, in the order in which they run.
    pub fn passes(&self) -> Vec<(&str, Quantiles)> {
        let quantiles = |label: &String| Quantiles::of(self.frames.iter().filter_map(|f| f.passes.get(label).copied()));
        self.order.iter().filter_map(|label| Some((label.as_str(), quantiles(label)?))).collect()
    }

    /// Whether no frame was drawn yet.
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// Forgets all frames.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Points (frame, ms) of a value of each frame; the newest is frame 0, those before it are
    /// negative.
    pub(in crate::window) fn series(&self, value: impl Fn(&FrameTimes) -> Option<f64>) -> Vec<[f64; 2]> {
        let newest = self.frames.len() as f64 - 1.0;
        let point = |(i, frame)| value(frame).map(|ms| [i as f64 - newest, ms]);
        self.frames.iter().enumerate().filter_map(point).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_nearest_ranks() {
        let of = |values: &[f64]| Quantiles::of(values.iter().copied());
        assert_eq!(of(&[]), None);
        assert_eq!(of(&[3.0]), Some(Quantiles { median: 3.0, p95: 3.0 }));
        let hundred: Vec<f64> = (1..=100).rev().map(f64::from).collect();
        assert_eq!(of(&hundred), Some(Quantiles { median: 50.0, p95: 95.0 }));
    }

    #[test]
    fn passes_of_one_label_are_added_and_old_frames_go() {
        let pass = |label: &str, ms| PassTime { label: label.into(), ms };
        let mut history = History::default();
        history.push(0.5, &[pass("a", 1.0), pass("b", 4.0), pass("a", 2.0)]);
        assert_eq!(history.last_ms(), Some(7.0));
        assert_eq!(history.passes().iter().map(|(l, q)| (*l, q.median)).collect::<Vec<_>>(), [("a", 3.0), ("b", 4.0)]);
        for _ in 0..FRAMES_KEPT {
            history.push(0.5, &[pass("c", 1.0)]);
        }
        assert_eq!(history.passes().iter().map(|(l, _)| *l).collect::<Vec<_>>(), ["c"]);
        assert_eq!(history.frames.len(), FRAMES_KEPT);
    }
}
