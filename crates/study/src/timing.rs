//! GPU times: many runs of several methods in turn, each beside a copy of the same image.

use super::render::{gpu_ms, render};
use super::{Progress, Rendered, StudyError, step};
use defocus::gpu::{Frame, Gpu};
use defocus::lens::Lens;
use defocus::methods::{self, Method};
use defocus::view::View;

/// Times of one method over several runs: ms, or multiples of the copy's time.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct RunTimes {
    /// The middle one, or the mean of the middle two.
    pub median: f64,
    /// Lower end of the median's 95 % interval; see [`RunTimes::of`].
    pub low: f64,
    /// Upper end of it.
    pub high: f64,
    /// The shortest.
    pub min: f64,
    /// The longest.
    pub max: f64,
    /// How many there were.
    pub runs: u32,
}

impl RunTimes {
    /// Statistics of `times`; `None` for none.
    ///
    /// The interval is that between two of the sorted times and holds for any distribution:
    /// the k-th shortest and the k-th longest enclose the true median unless fewer than k
    /// of n times fall on one side of it, with probability 2 P(Bin(n, 1/2) < k), at most
    /// 5 %. Fewer than 6 times have no such k; theirs is from the shortest to the longest.
    pub fn of(times: &[f64]) -> Option<Self> {
        let mut sorted = times.to_vec();
        sorted.sort_by(f64::total_cmp);
        let n = sorted.len();
        let (min, max) = (*sorted.first()?, *sorted.last()?);
        let (below, above) = (sorted[(n - 1) / 2], sorted[n / 2]);
        let cut = cut_each_side(n);
        let (low, high) = (sorted[cut], sorted[n - 1 - cut]);
        Some(Self { median: 0.5 * (below + above), low, high, min, max, runs: n as u32 })
    }
}

/// How many of n sorted times may be left out at each end: the greatest number k - 1 with
/// 2 P(Bin(n, 1/2) < k) <= 0.05, or 0.
fn cut_each_side(n: usize) -> usize {
    let mut probability = 0.5f64.powi(n.min(1000) as i32);
    let (mut below, mut cut) = (0.0, 0);
    for k in 1..=n / 2 {
        below += probability;
        if 2.0 * below > 0.05 {
            break;
        }
        cut = k - 1;
        probability *= (n + 1 - k) as f64 / k as f64;
    }
    cut
}

/// How often, and of what, times are taken.
#[derive(Clone, Copy, Debug)]
pub struct Rounds {
    /// Runs of each method before the timed ones, which build pipelines and fill pools.
    pub warmup: u32,
    /// Timed runs of each method, at least 1.
    pub runs: u32,
    /// Whether the view is drawn anew for each run, as while the camera moves, or kept, as
    /// while the lens is changed.
    pub redraw: bool,
}

/// Result of timing one method.
pub(super) struct Timed {
    /// The last run.
    pub rendered: Rendered,
    /// `None` where the adapter has no timestamps or there were too many passes.
    pub gpu_ms: Option<RunTimes>,
    /// Multiples of the copy's time in the same round.
    pub copy_ratio: Option<RunTimes>,
}

/// Times of all methods, and those of the copy.
pub(super) struct AllTimed {
    pub methods: Vec<Timed>,
    pub copy_ms: Option<RunTimes>,
}

/// Runs every method in turn, round after round, a copy before each, so that a clock or
/// other load that changes meanwhile touches all alike.
///
/// A method keeps in a view what it made for its last parameters. Where it is there with
/// several, each timed run follows an untimed one of the same, unless all is drawn anew.
pub(super) fn time_all(
    gpu: &Gpu,
    view: &mut View,
    lens: &Lens,
    methods: &[Box<dyn Method>],
    rounds: Rounds,
    progress: &mut Progress<'_>,
) -> Result<AllTimed, StudyError> {
    let all_rounds = rounds.warmup + rounds.runs.max(1);
    let mut times: Vec<[Vec<f64>; 2]> = vec![Default::default(); methods.len()];
    let (mut copies, mut last) = (Vec::new(), Vec::new());
    for round in 0..all_rounds {
        let (mut copies_ms, mut methods_ms) = (Vec::new(), Vec::new());
        for method in methods {
            step(progress, method.about().id, round, all_rounds)?;
            let record = |frame: &mut Frame<'_>, view: &mut View| {
                let failed = |source| StudyError::Method { method: method.about().id, source };
                methods::record(method.as_ref(), frame, view, lens).map_err(failed)
            };
            copies_ms.extend(copy_once(gpu, view));
            if rounds.redraw {
                view.redraw();
            } else if round >= rounds.warmup && shares_what_it_keeps(method.as_ref(), methods) {
                let mut frame = gpu.frame();
                record(&mut frame, view)?;
                frame.finish();
            }
            if round + 1 == all_rounds {
                let rendered = render(gpu, view, lens, method.as_ref())?;
                methods_ms.push(rendered.gpu_ms());
                last.push(rendered);
            } else {
                let mut frame = gpu.timed_frame();
                record(&mut frame, view)?;
                methods_ms.push(finished_ms(frame));
            }
        }
        if round < rounds.warmup {
            continue;
        }
        let copy_ms = RunTimes::of(&copies_ms).map(|copy| copy.median);
        copies.extend(copies_ms);
        for ([all_ms, ratios], ms) in times.iter_mut().zip(methods_ms) {
            all_ms.extend(ms);
            ratios.extend(ms.zip(copy_ms).filter(|(_, copy)| *copy > 0.0).map(|(ms, copy)| ms / copy));
        }
    }
    let timed = |(rendered, [ms, ratios]): (Rendered, [Vec<f64>; 2])| Timed {
        rendered,
        gpu_ms: RunTimes::of(&ms),
        copy_ratio: RunTimes::of(&ratios),
    };
    Ok(AllTimed { methods: last.into_iter().zip(times).map(timed).collect(), copy_ms: RunTimes::of(&copies) })
}

/// Whether another of `methods` is the same with other parameters.
fn shares_what_it_keeps(method: &dyn Method, methods: &[Box<dyn Method>]) -> bool {
    methods.iter().filter(|other| other.about().id == method.about().id).count() > 1
}

pub(super) fn copy_once(gpu: &Gpu, view: &mut View) -> Option<f64> {
    let mut frame = gpu.frame();
    // Drawn in a frame of its own, if it is not there.
    view.pinhole(&mut frame);
    frame.finish();
    let mut frame = gpu.timed_frame();
    methods::copy_inner(&mut frame, view);
    finished_ms(frame)
}

/// GPU time, ms, of a frame whose image nobody looks at.
fn finished_ms(frame: Frame<'_>) -> Option<f64> {
    let submitted = frame.finish();
    gpu_ms(&submitted.timings.wait(), &submitted.stats)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_hold_the_ranks_of_published_tables() {
        // Conover, "Practical Nonparametric Statistics": ranks of the 95 % interval of the
        // median, n = 6: 1 and 6; 9: 2 and 8; 20: 6 and 15; 50: 18 and 33.
        for (n, rank) in [(1, 1), (5, 1), (6, 1), (8, 1), (9, 2), (20, 6), (50, 18)] {
            assert_eq!(cut_each_side(n) + 1, rank, "{n} times");
        }
    }

    #[test]
    fn statistics_do_not_depend_on_the_order() {
        let times = [3.0, 1.0, 2.0, 10.0];
        let wanted = RunTimes { median: 2.5, low: 1.0, high: 10.0, min: 1.0, max: 10.0, runs: 4 };
        assert_eq!(RunTimes::of(&times), Some(wanted));
        assert_eq!(RunTimes::of(&[]), None);
    }
}
