//! All methods on one view: their images, their differences from the truth, their cost.

use super::render::{gpu_ms, render};
use super::{Progress, StudyError, Truth, step};
use crate::display::Display;
use crate::gpu::{FrameStats, Gpu, PassTime};
use crate::image::{ColorImage, Image};
use crate::lens::Lens;
use crate::methods::{self, Method};
use crate::metrics::{self, CompareOptions, Metrics};
use crate::view::View;
use rayon::prelude::*;
use serde_json::{Map, Value};

/// What to compare, and how.
pub struct CompareRequest<'a> {
    /// The lens.
    pub lens: &'a Lens,
    /// Methods with their parameters.
    pub methods: &'a [Box<dyn Method>],
    /// The truth; `None` to measure times only.
    pub truth: Option<&'a Truth>,
    /// How images are shown.
    pub display: Display,
    /// Runs of each method before the timed ones, which build pipelines and fill pools.
    pub warmup: u32,
    /// Timed runs of each method, at least 1.
    pub runs: u32,
}

/// GPU times of one method over several runs, ms.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct RunTimes {
    /// The middle one, or the mean of the middle two.
    pub median: f64,
    /// The shortest.
    pub min: f64,
    /// The longest.
    pub max: f64,
    /// How many there were.
    pub runs: u32,
}

impl RunTimes {
    /// Statistics of `ms`; `None` for no times.
    pub fn of(ms: &[f64]) -> Option<Self> {
        let mut sorted = ms.to_vec();
        sorted.sort_by(f64::total_cmp);
        let (min, max) = (*sorted.first()?, *sorted.last()?);
        let (low, high) = (sorted[(sorted.len() - 1) / 2], sorted[sorted.len() / 2]);
        Some(Self { median: 0.5 * (low + high), min, max, runs: sorted.len() as u32 })
    }
}

/// What came of one method.
#[derive(Clone, Debug)]
pub struct MethodResult {
    /// Its id.
    pub method: &'static str,
    /// Its name for people.
    pub title: &'static str,
    /// Its parameters, by key.
    pub params: Map<String, Value>,
    /// Its image, linear.
    pub color: ColorImage,
    /// Differences from the truth, where there is one.
    pub metrics: Option<Metrics>,
    /// GPU times; `None` where the adapter has no timestamps or there were too many passes.
    pub gpu_ms: Option<RunTimes>,
    /// Passes of the last run.
    pub passes: Vec<PassTime>,
    /// Counters of the last run.
    pub stats: FrameStats,
}

/// A method that was left out, and why.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct NotRun {
    /// The method's id.
    pub method: &'static str,
    /// The reason.
    pub reason: String,
}

/// What came of all methods.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The pinhole image of the inner frame, linear.
    pub pinhole: ColorImage,
    /// Results in the order of the methods asked for.
    pub results: Vec<MethodResult>,
}

/// A method's parameters by key, for JSON.
pub fn params_json(method: &dyn Method) -> Map<String, Value> {
    let mut method = method.boxed();
    method.params().iter().map(|param| (param.key.to_owned(), param.json())).collect()
}

/// Splits methods into those that `view` can serve and those it cannot: an image has no
/// hidden surfaces and no other viewpoints.
pub fn runnable(methods: Vec<Box<dyn Method>>, view: &View) -> (Vec<Box<dyn Method>>, Vec<NotRun>) {
    let (run, left): (Vec<_>, Vec<_>) = methods.into_iter().partition(|m| view.is_scene() || !m.about().needs_scene);
    let reason = "it needs a scene: an image with depth has no hidden surfaces and no other viewpoints";
    let left = left.iter().map(|m| NotRun { method: m.about().id, reason: reason.into() }).collect();
    (run, left)
}

/// Renders every method, timed runs interleaved so that a clock that changes meanwhile
/// touches all alike, then computes the differences from the truth in parallel.
///
/// # Errors
///
/// What a method says, [`StudyError::Stopped`], an image with NaN or infinity.
pub fn compare(
    gpu: &Gpu,
    view: &mut View,
    request: &CompareRequest<'_>,
    progress: &mut Progress<'_>,
) -> Result<Comparison, StudyError> {
    // Drawn before the first method, to whose time it would otherwise be added.
    let pinhole = render(gpu, view, request.lens, &methods::Pinhole)?.color;
    let mut results = time_all(gpu, view, request, progress)?;
    if let Some(truth) = request.truth {
        let depth_m = view.depth_m(gpu);
        let coc = request.lens.coc();
        let coc_px = depth_m.map(|d| coc.at_depth(f64::from(d)) as f32);
        step(progress, "metrics", 0, 1)?;
        add_metrics(&mut results, &pinhole, &coc_px, truth, request.display)?;
        step(progress, "metrics", 1, 1)?;
    }
    Ok(Comparison { pinhole, results })
}

fn time_all(
    gpu: &Gpu,
    view: &mut View,
    request: &CompareRequest<'_>,
    progress: &mut Progress<'_>,
) -> Result<Vec<MethodResult>, StudyError> {
    let rounds = request.warmup + request.runs.max(1);
    let mut times: Vec<Vec<f64>> = vec![Vec::new(); request.methods.len()];
    let mut results = Vec::new();
    for round in 0..rounds {
        for (index, method) in request.methods.iter().enumerate() {
            step(progress, method.about().id, round, rounds)?;
            if round + 1 == rounds {
                let result = result_of(gpu, view, request.lens, method.as_ref())?;
                times[index].extend(gpu_ms(&result.passes, &result.stats));
                results.push(MethodResult { gpu_ms: RunTimes::of(&times[index]), ..result });
            } else {
                let ms = time_once(gpu, view, request.lens, method.as_ref())?;
                times[index].extend(ms.filter(|_| round >= request.warmup));
            }
        }
    }
    Ok(results)
}

/// GPU time, ms, of a run whose image nobody looks at.
fn time_once(gpu: &Gpu, view: &mut View, lens: &Lens, method: &dyn Method) -> Result<Option<f64>, StudyError> {
    let mut frame = gpu.frame();
    let failed = |source| StudyError::Method { method: method.about().id, source };
    methods::record(method, &mut frame, view, lens).map_err(failed)?;
    let submitted = frame.finish();
    Ok(gpu_ms(&submitted.timings.wait(), &submitted.stats))
}

fn result_of(gpu: &Gpu, view: &mut View, lens: &Lens, method: &dyn Method) -> Result<MethodResult, StudyError> {
    let rendered = render(gpu, view, lens, method)?;
    let about = method.about();
    Ok(MethodResult {
        method: about.id,
        title: about.title,
        params: params_json(method),
        color: rendered.color,
        metrics: None,
        gpu_ms: None,
        passes: rendered.passes,
        stats: rendered.stats,
    })
}

fn add_metrics(
    results: &mut [MethodResult],
    pinhole: &ColorImage,
    coc_px: &Image<f32>,
    truth: &Truth,
    display: Display,
) -> Result<(), StudyError> {
    let failed = |method| move |source| StudyError::Metrics { method, source };
    let mask = metrics::defocused_mask(coc_px, pinhole, &truth.color).map_err(failed(truth.method))?;
    let options = CompareOptions { display, defocused: Some(&mask), ..Default::default() };
    results.par_iter_mut().try_for_each(|result| {
        let metrics = metrics::compare(&result.color, &truth.color, &options).map_err(failed(result.method))?;
        result.metrics = Some(metrics);
        Ok(())
    })
}
