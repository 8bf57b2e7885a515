//! The truth to compare with.

use super::render::{Rendered, render};
use super::steps::Steps;
use super::{GpuSource, Progress, Source, StudyError, step};
use crate::metrics;
use defocus::display::Display;
use defocus::gpu::{Frame, FrameStats, Gpu, PassTime, download};
use defocus::image::ColorImage;
use defocus::lens::Lens;
use defocus::methods::{self, AccumulationRun, Converging, Method, UnknownMethod};
use defocus::raytrace::{RayOptions, RayRender, RayScene, Shading};
use defocus::view::View;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// What counts as the truth.
#[derive(Clone)]
pub enum Reference {
    /// The mean of rasterised views over the lens.
    Accumulation,
    /// The mean of traced rays over the lens, on the CPU.
    RayTrace,
    /// Any other method.
    Method(Box<dyn Method>),
}

impl Reference {
    /// `accumulation`, `raytrace` or a method's id.
    ///
    /// # Errors
    ///
    /// [`UnknownMethod`], which lists those there are.
    pub fn by_id(id: &str) -> Result<Self, UnknownMethod> {
        match id {
            "accumulation" => Ok(Self::Accumulation),
            "raytrace" => Ok(Self::RayTrace),
            other => methods::by_id(other)
                .map(Self::Method)
                .map_err(|unknown| UnknownMethod { known: format!("{}, raytrace", unknown.known), ..unknown }),
        }
    }

    /// Its short name.
    pub fn id(&self) -> &'static str {
        match self {
            Self::Accumulation => "accumulation",
            Self::RayTrace => "raytrace",
            Self::Method(method) => method.about().id,
        }
    }
}

/// Which truth, and how well converged.
#[derive(Clone)]
pub struct ReferenceRequest {
    /// What counts as the truth.
    pub reference: Reference,
    /// Lens points, of accumulation and ray tracing.
    pub samples: u32,
    /// Whether surfaces are shaded from each lens point.
    pub view_dependent: bool,
    /// How images are shown: that of the convergence estimate.
    pub display: Display,
}

/// A reference image.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// The reference's id.
    pub method: &'static str,
    /// Lens points; `None` for a method that has none.
    pub samples: Option<u32>,
    /// Linear, of the view's inner size.
    pub color: ColorImage,
    /// PSNR, dB, that the image is estimated to have against a fully converged one; see
    /// [`self_psnr_db`].
    pub self_psnr_db: Option<f64>,
}

/// Renders the truth of `view`, which comes from `source`.
///
/// # Errors
///
/// [`StudyError::ImageHasNoReference`], [`StudyError::Stopped`], and what the method says.
pub fn render_reference(
    source: &GpuSource,
    view: &mut View,
    lens: &Lens,
    request: &ReferenceRequest,
    progress: &mut Progress<'_>,
) -> Result<Truth, StudyError> {
    let method = request.reference.id();
    if let (Some(lenses), false) = (lens.primaries(), matches!(request.reference, Reference::Method(_))) {
        let mut of = |lens: &Lens| render_reference(source, view, lens, request, progress);
        let truths = [of(&lenses[0])?, of(&lenses[1])?, of(&lenses[2])?];
        return Ok(of_primaries(truths));
    }
    let (image, halves) = match (&request.reference, source.source()) {
        (Reference::Method(method), _) => {
            step(progress, method.about().id, 0, 1)?;
            let image = render(source.gpu(), view, lens, method.as_ref())?.color;
            return Ok(Truth { method: method.about().id, samples: None, color: image, self_psnr_db: None });
        }
        (_, Source::Image(_)) => return Err(StudyError::ImageHasNoReference { reference: method }),
        (Reference::Accumulation, _) => {
            let accumulated = accumulate_in(Gpu::frame, source.gpu(), view, lens, request, progress)?;
            (accumulated.rendered.color, accumulated.halves)
        }
        (Reference::RayTrace, Source::Scene(scene)) => {
            let camera = view.camera().copied().unwrap_or(scene.cameras[0].camera);
            let rays = Arc::new(RayScene::new(scene.clone(), &camera)?);
            trace(&rays, source, view, lens, request, progress)?
        }
    };
    let self_psnr_db = halves.and_then(|halves| self_psnr_db(&halves, request.display));
    Ok(Truth { method, samples: Some(request.samples), color: image, self_psnr_db })
}

/// The truth of a lens with chromatic aberration from those of its primaries: as well
/// converged as the worst of them.
fn of_primaries(truths: [Truth; 3]) -> Truth {
    let color = methods::combined_images(truths.each_ref().map(|truth| &truth.color));
    let self_psnr_db = truths.iter().filter_map(|truth| truth.self_psnr_db).reduce(f64::min);
    let [Truth { method, samples, .. }, ..] = truths;
    Truth { method, samples, color, self_psnr_db }
}

/// Two independent estimates of an image, with the number of lens points of each.
pub struct Halves {
    /// The estimates.
    pub images: [ColorImage; 2],
    /// Lens points of each.
    pub counts: [u32; 2],
}

/// How well converged the mean of two independent estimates is: their PSNR against each
/// other, plus `10 log10((n1 + n2)^2 / (n1 n2))` dB, which is 6.02 dB for equal halves.
///
/// The variance of the estimates' difference is s^2 (1/n1 + 1/n2), that of their weighted
/// mean s^2 / (n1 + n2); the ratio is that of the formula. Low-discrepancy lens points
/// converge faster than independent ones, so the figure is a lower bound in practice.
/// `None` where the halves are equal.
pub fn self_psnr_db(halves: &Halves, display: Display) -> Option<f64> {
    let [a, b] = &halves.images;
    let errors = metrics::abs_error_map(a, b, display).ok()?;
    let squares: f64 = errors.pixels.iter().map(|e| e.as_dvec3().length_squared()).sum();
    let mse = squares / (3.0 * errors.pixels.len() as f64);
    let [n1, n2] = halves.counts.map(f64::from);
    let gain_db = 10.0 * ((n1 + n2).powi(2) / (n1 * n2)).log10();
    (mse > 0.0).then(|| -10.0 * mse.log10() + gain_db)
}

type Estimate = (ColorImage, Option<Halves>);

/// An accumulated image with its halves.
pub struct Accumulated {
    /// The image, its passes and counters.
    pub rendered: Rendered,
    /// Two independent estimates of it; `None` of a single view.
    pub halves: Option<Halves>,
}

impl Accumulated {
    /// The image of a lens with chromatic aberration from those of its primaries.
    fn of_primaries(all: [Self; 3]) -> Self {
        let color = methods::combined_images(all.each_ref().map(|one| &one.rendered.color));
        let mut stats = FrameStats::default();
        all.iter().for_each(|one| add_stats(&mut stats, &one.rendered.stats));
        let passes = all.into_iter().flat_map(|one| one.rendered.passes).collect();
        Self { rendered: Rendered { color, passes, stats }, halves: None }
    }
}

/// Accumulates the request's lens points step by step, so that it can be stopped.
///
/// # Errors
///
/// [`StudyError::Stopped`], a lens that forms no image, a view of an image.
pub fn accumulate(
    gpu: &Gpu,
    view: &mut View,
    lens: &Lens,
    request: &ReferenceRequest,
    progress: &mut Progress<'_>,
) -> Result<Accumulated, StudyError> {
    accumulate_in(Gpu::timed_frame, gpu, view, lens, request, progress)
}

/// As [`accumulate`], in frames that `start` starts: timed ones wait for every pass.
fn accumulate_in(
    start: fn(&Gpu) -> Frame<'_>,
    gpu: &Gpu,
    view: &mut View,
    lens: &Lens,
    request: &ReferenceRequest,
    progress: &mut Progress<'_>,
) -> Result<Accumulated, StudyError> {
    let failed = |source| StudyError::Method { method: "accumulation", source };
    lens.check().map_err(|e| failed(e.into()))?;
    if let Some(lenses) = lens.primaries() {
        let mut of = |lens: &Lens| accumulate_in(start, gpu, view, lens, request, progress);
        return Ok(Accumulated::of_primaries([of(&lenses[0])?, of(&lenses[1])?, of(&lenses[2])?]));
    }
    let mut run = AccumulationRun::new(request.view_dependent);
    let (mut passes, mut stats, mut steps) = (Vec::new(), FrameStats::default(), Steps::default());
    while run.count() < request.samples {
        step(progress, "accumulation", run.count(), request.samples)?;
        let (before, since) = (run.count(), Instant::now());
        let mut frame = start(gpu);
        frame.set_prefix("accumulation/");
        run.advance(&mut frame, view, lens, steps.next(request.samples - before)).map_err(failed)?;
        // Waiting keeps the count honest and the work that cannot be stopped any more short.
        add(frame, &mut passes, &mut stats);
        steps.took(run.count() - before, since.elapsed());
    }
    step(progress, "accumulation", run.count(), request.samples)?;
    let mut frame = start(gpu);
    frame.set_prefix("accumulation/");
    let mean = run.mean(&mut frame);
    add(frame, &mut passes, &mut stats);
    // The first half ends at the last power of two below the count.
    let first = 1 << (request.samples.max(2) - 1).ilog2();
    let counts = [first, request.samples.saturating_sub(first)];
    let halves = run.halves(gpu).map(|images| Halves { images, counts });
    Ok(Accumulated { rendered: Rendered { color: download(gpu, &mean), passes, stats }, halves })
}

/// Submits a frame, waits for it and adds up what it did.
fn add(frame: Frame<'_>, passes: &mut Vec<PassTime>, stats: &mut FrameStats) {
    let submitted = frame.finish();
    passes.extend(submitted.timings.wait());
    add_stats(stats, &submitted.stats);
}

fn add_stats(sum: &mut FrameStats, stats: &FrameStats) {
    sum.triangles += stats.triangles;
    sum.views += stats.views;
    sum.passes += stats.passes;
    sum.peak_texture_bytes = sum.peak_texture_bytes.max(stats.peak_texture_bytes);
    for (what, times) in &stats.skipped {
        *sum.skipped.entry(what.clone()).or_default() += times;
    }
}

fn trace(
    rays: &Arc<RayScene>,
    source: &GpuSource,
    view: &View,
    lens: &Lens,
    request: &ReferenceRequest,
    progress: &mut Progress<'_>,
) -> Result<Estimate, StudyError> {
    let shading = if source.options().unlit { Shading::Unlit } else { Shading::Scene };
    let mut done = 0;
    let mut part = |lens_points: Range<u32>| -> Result<ColorImage, StudyError> {
        let options = RayOptions { lens_points, shading, view_dependent: request.view_dependent };
        let mut render = RayRender::new(rays.clone(), view.projection(), lens, &options)?;
        while !render.is_complete() {
            step(progress, "raytrace", done + render.points_done(), request.samples)?;
            render.advance(1, &AtomicBool::new(false));
        }
        done += render.points_wanted();
        Ok(render.image().color)
    };
    let half = request.samples / 2;
    if half == 0 {
        return Ok((part(0..request.samples)?, None));
    }
    let images = [part(0..half)?, part(half..request.samples)?];
    let counts = [half, request.samples - half];
    let share = half as f32 / request.samples as f32;
    let pixels = images[0].pixels.iter().zip(&images[1].pixels).map(|(a, b)| *a * share + *b * (1.0 - share)).collect();
    Ok((ColorImage { size: images[0].size, pixels }, Some(Halves { images, counts })))
}
