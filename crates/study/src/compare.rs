//! All methods on one view: their images, their differences from the truth, their cost.

use super::render::render;
use super::timing::{Rounds, RunTimes, Timed, time_all};
use super::{Progress, StudyError, Truth, step};
use crate::metrics::{self, CompareOptions, Metrics};
use defocus::display::Display;
use defocus::gpu::{FrameStats, Gpu, PassTime};
use defocus::image::{ColorImage, Image};
use defocus::lens::Lens;
use defocus::methods::{self, Method};
use defocus::view::View;
use defocus::viewing::Viewing;
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
    /// Under what angle and in what light they are looked at.
    pub viewing: Viewing,
    /// How times are taken.
    pub rounds: Rounds,
}

/// Result of one method.
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
    /// The same as multiples of the time that a copy of the image takes.
    pub copy_ratio: Option<RunTimes>,
    /// Passes of the last run.
    pub passes: Vec<PassTime>,
    /// Counters of the last run.
    pub stats: FrameStats,
}

/// A method that was left out, and why.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct NotRun {
    /// The method's id.
    pub method: String,
    /// The reason.
    pub reason: String,
}

/// Results of all methods.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The pinhole image of the inner frame, linear.
    pub pinhole: ColorImage,
    /// Results in the order of the methods asked for.
    pub results: Vec<MethodResult>,
    /// GPU times, ms, of copying the pinhole image, in the same rounds.
    pub copy_ms: Option<RunTimes>,
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
    let left = left.iter().map(|m| NotRun { method: m.about().id.into(), reason: reason.into() }).collect();
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
    let timed = time_all(gpu, view, request.lens, request.methods, request.rounds, progress)?;
    let copy_ms = timed.copy_ms;
    let methods = request.methods.iter().zip(timed.methods);
    let mut results: Vec<_> = methods.map(|(method, timed)| result_of(method.as_ref(), timed)).collect();
    if let Some(truth) = request.truth {
        let depth_m = view.depth_m(gpu);
        let coc = request.lens.coc();
        let coc_px = depth_m.map(|d| coc.at_depth(f64::from(d)) as f32);
        step(progress, "metrics", 0, 1)?;
        add_metrics(&mut results, &pinhole, &coc_px, truth, request)?;
        add_jod(&mut results, truth, request, progress)?;
        step(progress, "metrics", 1, 1)?;
    }
    Ok(Comparison { pinhole, results, copy_ms })
}

fn result_of(method: &dyn Method, timed: Timed) -> MethodResult {
    let about = method.about();
    MethodResult {
        method: about.id,
        title: about.title,
        params: params_json(method),
        color: timed.rendered.color,
        metrics: None,
        gpu_ms: timed.gpu_ms,
        copy_ratio: timed.copy_ratio,
        passes: timed.rendered.passes,
        stats: timed.rendered.stats,
    }
}

fn add_metrics(
    results: &mut [MethodResult],
    pinhole: &ColorImage,
    coc_px: &Image<f32>,
    truth: &Truth,
    request: &CompareRequest<'_>,
) -> Result<(), StudyError> {
    let failed = |method| move |source| StudyError::Metrics { method, source };
    let mask = metrics::defocused_mask(coc_px, pinhole, &truth.color).map_err(failed(truth.method))?;
    let options = CompareOptions {
        display: request.display,
        viewing: request.viewing,
        defocused: Some(&mask),
        jod: false,
        hdr_flip: false,
    };
    results.par_iter_mut().try_for_each(|result| {
        let metrics = metrics::compare(&result.color, &truth.color, &options).map_err(failed(result.method))?;
        result.metrics = Some(metrics);
        Ok(())
    })
}

/// Adds the JOD, one image after the other: each takes all cores and far more memory than the
/// image.
fn add_jod(
    results: &mut [MethodResult],
    truth: &Truth,
    request: &CompareRequest<'_>,
    progress: &mut Progress<'_>,
) -> Result<(), StudyError> {
    let of = results.len() as u32;
    for (done, result) in (0..).zip(results) {
        step(progress, "JOD", done, of)?;
        let jod = metrics::jod(&result.color, &truth.color, request.display, &request.viewing);
        let jod = jod.map_err(|source| StudyError::Metrics { method: result.method, source })?;
        if let Some(metrics) = &mut result.metrics {
            metrics.jod = jod;
        }
    }
    Ok(())
}

/// Which of `results` is good enough at the least cost.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct GoodEnough {
    /// Least quality that counts as good enough, JOD.
    pub jod: f64,
    /// The cheapest method that reaches it by GPU time on this adapter; `None` where none does.
    pub method: Option<&'static str>,
}

impl GoodEnough {
    /// The cheapest of `results` that has at least `jod`. One without times is as dear as can
    /// be: it wins only where no other is good enough.
    pub fn among(results: &[MethodResult], jod: f64) -> Self {
        let cost_ms = |r: &MethodResult| r.gpu_ms.map_or(f64::INFINITY, |times| times.median);
        let reaches = |r: &&MethodResult| r.metrics.as_ref().and_then(|m| m.jod).is_some_and(|found| found >= jod);
        let cheapest = results.iter().filter(reaches).min_by(|a, b| cost_ms(a).total_cmp(&cost_ms(b)));
        Self { jod, method: cheapest.map(|r| r.method) }
    }
}
