//! Measuring cell by cell.

use super::plan::{Blur, Cell, Plan, PlanError, Shard, Variant};
use super::results::{CellResult, VariantResult};
use super::store::{Store, StoreError};
use crate::cache::{ReferenceCache, cached_reference};
use crate::compare::{CompareRequest, MethodResult, NotRun, compare, runnable};
use crate::reference::{Reference, ReferenceRequest, Truth};
use crate::results::{MetricsJson, Work};
use crate::source::{DepthArgs, GpuSource, Source, SourceError};
use crate::timing::Rounds;
use crate::{Progress, Step, StudyError, report};
use defocus::display::Display;
use defocus::gpu::{FrameStats, Gpu, PassTime};
use defocus::image::DepthImage;
use defocus::image_io::ImageError;
use defocus::lens::Lens;
use defocus::methods::{self, Method};
use defocus::scene::Scene;
use defocus::view::{SurfaceOptions, Tone, View, auto_overscan_px};
use defocus::viewing::{Screen, Viewing};
use glam::UVec2;
use std::collections::HashMap;
use std::ops::ControlFlow;
use std::time::Instant;

/// Why a benchmark cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// A variant that cannot be made.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A scene that cannot be opened.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// A cell that cannot be rendered.
    #[error("{cell}: {source}")]
    Cell {
        /// The cell in words.
        cell: String,
        /// Cause and remedy.
        source: Box<StudyError>,
    },
    /// The folder cannot be used.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A scene in which nothing gets out of focus.
    #[error("{cell}: all of the image lies at the focus distance, so that no aperture blurs it; leave the scene out")]
    NothingToBlur {
        /// The cell in words.
        cell: String,
    },
}

/// How a benchmark is run.
pub struct BenchRun<'a> {
    /// What to measure.
    pub plan: &'a Plan,
    /// Which part of it.
    pub shard: Shard,
    /// Where results go, and where those of an earlier run lie.
    pub store: &'a Store,
    /// Where references are kept.
    pub cache: Option<&'a ReferenceCache>,
    /// No cell is started, and none goes on, after this time.
    pub deadline: Option<Instant>,
}

/// Result of a run.
#[derive(Debug, Default)]
pub struct BenchOutcome {
    /// Cells measured now.
    pub measured: usize,
    /// Cells of the shard that an earlier run had measured.
    pub found: usize,
    /// Cells of the shard that the time did not suffice for.
    pub left: usize,
    /// What kept references from being kept.
    pub cache_problem: Option<ImageError>,
}

impl BenchRun<'_> {
    /// Measures the cells of the shard that are not measured yet.
    ///
    /// # Errors
    ///
    /// [`BenchError`]; one with [`StudyError::Stopped`] when `progress` asks to stop.
    pub fn run(&self, gpu: &Gpu, progress: &mut Progress<'_>) -> Result<BenchOutcome, BenchError> {
        let cells: Vec<Cell> = self.plan.cells().into_iter().filter(|cell| self.shard.has(cell)).collect();
        let mut outcome = BenchOutcome::default();
        let mut sources = HashMap::new();
        for (done, cell) in cells.iter().enumerate() {
            if self.store.cell(cell.index)?.is_some() {
                outcome.found += 1;
                continue;
            }
            if self.deadline.is_some_and(|deadline| Instant::now() > deadline) {
                outcome.left += 1;
                continue;
            }
            let label = cell.label();
            let mut late = false;
            let result = self.measure(gpu, &mut sources, cell, &mut outcome.cache_problem, &mut |inner| {
                late = self.deadline.is_some_and(|deadline| Instant::now() > deadline);
                let what = format!("{label}: {}", inner.what);
                let told = progress(Step { what: &what, done: done as u32, of: cells.len() as u32 });
                if late { ControlFlow::Break(()) } else { told }
            });
            match result {
                Ok(result) => {
                    self.store.add(&result)?;
                    outcome.measured += 1;
                }
                Err(BenchError::Cell { source, .. }) if late && matches!(*source, StudyError::Stopped) => {
                    outcome.left += 1;
                }
                Err(error) => return Err(error),
            }
        }
        Ok(outcome)
    }

    fn measure(
        &self,
        gpu: &Gpu,
        sources: &mut HashMap<String, GpuSource>,
        cell: &Cell,
        cache_problem: &mut Option<ImageError>,
        progress: &mut Progress<'_>,
    ) -> Result<CellResult, BenchError> {
        let failed = |source| BenchError::Cell { cell: cell.label(), source: Box::new(source) };
        if !sources.contains_key(&cell.scene) {
            let source = Source::open(&cell.scene, &DepthArgs::default())?.upload(gpu, SurfaceOptions::default());
            sources.insert(cell.scene.clone(), source);
        }
        let source = &sources[&cell.scene];
        let mut stage = Stage::new(gpu, source, cell, self.plan.overscan_px)?;
        let variants = Variants::of(self.plan, cell, &stage.view)?;
        let mut truth = self.truth(source, &mut stage, cell.blur, cache_problem, progress).map_err(failed)?;
        let tone = stage.view.set_input(gpu, self.plan.input);
        if let Some(truth) = truth.as_mut().filter(|_| tone != Tone::Linear) {
            truth.color = truth.color.map(|color| tone.apply(color));
        }
        let rounds = Rounds { warmup: self.plan.warmup, runs: self.plan.runs, redraw: self.plan.redraw };
        let viewing = Viewing::of(&stage.lens, Screen::default());
        let request = CompareRequest {
            lens: &stage.lens,
            methods: &variants.methods,
            truth: truth.as_ref(),
            display: Display::default(),
            viewing,
            rounds,
        };
        let comparison = compare(gpu, &mut stage.view, &request, progress).map_err(failed)?;
        let mut results = Vec::new();
        for ((label, method), result) in variants.labels.iter().zip(&variants.methods).zip(&comparison.results) {
            let mut found = variant_result(label, result);
            if self.plan.count_reads {
                let reads = reads_per_px(gpu, &mut stage, method.as_ref());
                found.reads_per_px = Some(reads.map_err(failed)?);
            }
            let is_first = !results.iter().any(|r: &VariantResult| r.method == found.method);
            if self.plan.error_maps && is_first {
                let image = report::flip_image(result, truth.as_ref(), Display::default(), &viewing).map_err(failed)?;
                let map = image.map(|map| self.store.add_map(cell.index, &found.method, &map));
                found.flip_map = map.transpose()?;
            }
            results.push(found);
        }
        let [mean_coc_px, greatest_coc_px, in_focus] = stage.coc_figures();
        Ok(CellResult {
            cell: cell.clone(),
            adapter: format!("{} ({})", gpu.adapter().name, gpu.adapter().backend),
            version: env!("CARGO_PKG_VERSION").into(),
            scene: source.source().name().into(),
            scene_triangles: triangles(source.source()),
            size: stage.view.size().to_array(),
            mean_coc_px,
            greatest_coc_px,
            in_focus,
            reference_self_psnr_db: truth.as_ref().and_then(|t| t.self_psnr_db),
            copy_ms: comparison.copy_ms,
            variants: results,
            not_run: variants.not_run,
        })
    }

    /// None of an image, nor if the plan wants none.
    fn truth(
        &self,
        source: &GpuSource,
        stage: &mut Stage,
        blur: Blur,
        cache_problem: &mut Option<ImageError>,
        progress: &mut Progress<'_>,
    ) -> Result<Option<Truth>, StudyError> {
        let samples = self.plan.reference_samples_at(blur).filter(|_| stage.view.is_scene());
        let Some(samples) = samples else { return Ok(None) };
        let reference = Reference::Accumulation;
        let view_dependent = self.plan.view_dependent;
        let request = ReferenceRequest { reference, samples, view_dependent, display: Display::default() };
        let (view, lens) = (&mut stage.view, &stage.lens);
        let (truth, problem) = cached_reference(self.cache, source, view, lens, &request, progress)?;
        *cache_problem = cache_problem.take().or(problem);
        Ok(Some(truth))
    }
}

/// A view with the lens of a cell.
struct Stage {
    view: View,
    lens: Lens,
    depth_m: std::sync::Arc<DepthImage>,
}

impl Stage {
    fn new(gpu: &Gpu, source: &GpuSource, cell: &Cell, overscan_px: Option<u32>) -> Result<Self, BenchError> {
        let failed =
            |source: defocus::view::ViewError| BenchError::Cell { cell: cell.label(), source: Box::new(source.into()) };
        let size = source.source().fitted_size(UVec2::from(cell.size));
        let mut view = source.view(0, size, 0, None).map_err(failed)?;
        let depth_m = view.depth_m(gpu);
        let lens = opened(&source.source().default_lens(&depth_m), cell.blur, &depth_m);
        let lens = lens.ok_or_else(|| BenchError::NothingToBlur { cell: cell.label() })?;
        let overscan_px = overscan_px.unwrap_or_else(|| auto_overscan_px(&lens, &depth_m));
        // An image has no surroundings to draw.
        let overscan_px = if source.source().is_scene() { overscan_px } else { 0 };
        view.set_size(gpu, size, overscan_px).map_err(failed)?;
        Ok(Self { view, lens, depth_m })
    }

    /// Mean and greatest CoC diameter, px, and the share of pixels with less than 1 px.
    fn coc_figures(&self) -> [f64; 3] {
        let statistics = self.lens.coc_statistics(self.depth_m.pixels.iter().copied());
        let [mean, greatest] = statistics.map_or([0.0; 2], |s| [s.mean_px, s.greatest_px()]);
        let coc = self.lens.coc();
        let in_focus = self.depth_m.pixels.iter().filter(|d| coc.at_depth(f64::from(**d)).abs() < 1.0).count();
        [mean, greatest, in_focus as f64 / self.depth_m.pixels.len() as f64]
    }
}

/// The lens with its aperture opened as far as `blur` says; `None` where nothing blurs.
fn opened(lens: &Lens, blur: Blur, depth_m: &DepthImage) -> Option<Lens> {
    let depths = || depth_m.pixels.iter().copied();
    match blur {
        Blur::MeanCocPx(px) => lens.with_mean_coc(px, depths()),
        Blur::GreatestCocPx(px) => {
            let unit = lens.with_mean_coc(1.0, depths())?;
            let greatest_px = unit.coc_statistics(depths())?.greatest_px();
            let aperture_diameter_mm = unit.aperture_diameter_mm * px / greatest_px;
            Some(Lens { aperture_diameter_mm, ..unit })
        }
    }
}

/// The variants of a cell that the view can serve.
struct Variants {
    labels: Vec<String>,
    methods: Vec<Box<dyn Method>>,
    not_run: Vec<NotRun>,
}

impl Variants {
    fn of(plan: &Plan, cell: &Cell, view: &View) -> Result<Self, BenchError> {
        let mut all = Self { labels: Vec::new(), methods: Vec::new(), not_run: Vec::new() };
        for variant in plan.variants_at(cell.blur) {
            let (run, left) = runnable(vec![variant.method()?], view);
            all.labels.extend(run.iter().map(|_| Variant::label(variant)));
            all.methods.extend(run);
            all.not_run.extend(left);
        }
        Ok(all)
    }
}

/// Triangles of a whole scene; an image is two.
fn triangles(source: &Source) -> u64 {
    let of_scene = |scene: &Scene| {
        let indices = |i: &defocus::scene::Instance| scene.meshes[i.mesh].indices.len() as u64;
        scene.instances.iter().map(indices).sum::<u64>() / 3
    };
    match source {
        Source::Scene(scene) => of_scene(scene),
        Source::Image(_) => 2,
    }
}

fn variant_result(label: &str, result: &MethodResult) -> VariantResult {
    VariantResult {
        label: label.into(),
        method: result.method.into(),
        params: result.params.clone(),
        metrics: result.metrics.as_ref().map(MetricsJson::from).unwrap_or_default(),
        gpu_ms: result.gpu_ms,
        copy_ratio: result.copy_ratio,
        passes: by_label(&result.passes),
        work: Work::from(&result.stats),
        reads_per_px: None,
        flip_map: None,
    }
}

/// Passes of one label added up: a reference has hundreds.
fn by_label(passes: &[PassTime]) -> Vec<PassTime> {
    let mut sums: Vec<PassTime> = Vec::new();
    for pass in passes {
        match sums.iter_mut().find(|sum| sum.label == pass.label) {
            Some(sum) => sum.ms += pass.ms,
            None => sums.push(pass.clone()),
        }
    }
    sums
}

/// Texture reads of one run, over the pixels of the image.
fn reads_per_px(gpu: &Gpu, stage: &mut Stage, method: &dyn Method) -> Result<f64, StudyError> {
    let mut frame = gpu.frame();
    let reads = frame.count_texture_reads();
    methods::record(method, &mut frame, &mut stage.view, &stage.lens)
        .map_err(|source| StudyError::Method { method: method.about().id, source })?;
    let count: Vec<u64> = frame.read_buffer(&reads);
    let _: FrameStats = frame.finish().stats;
    let pixels = f64::from(stage.view.size().element_product());
    Ok(count.first().map_or(0.0, |n| *n as f64 / pixels))
}
