//! A run: many scenes, every method on each.

use super::figures::light_sum;
use super::{Family, Figures, Rules, SceneSpec, family_of, figures, generate, scene_seed, truth};
use crate::devices::share_out;
use crate::{Progress, Source, StudyError, render};
use defocus::gpu::Gpu;
use defocus::image::ColorImage;
use defocus::methods::{self, Method};
use defocus::view::{GpuScene, SurfaceOptions, View};
use glam::UVec2;
use std::collections::BTreeMap;
use std::time::Instant;

/// The method that the truth comes from.
const REFERENCE: &str = "accumulation";

/// Lens points for the sum of light without the lights: a sum over all pixels has far less
/// noise than each of them.
const DARK_POINTS: u32 = 64;

/// What to try.
#[derive(Clone, Copy)]
pub struct GauntletRequest<'a> {
    /// The methods.
    pub methods: &'a [Box<dyn Method>],
    /// Which scenes.
    pub seed: u64,
    /// How many.
    pub scenes: u64,
    /// The family they are of; all in turn without one.
    pub family: Option<&'static Family>,
    /// Size of their frames, px.
    pub size: UVec2,
    /// Lens points of a reference, at least and at most.
    pub points: [u32; 2],
}

/// What one method made of a scene.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[serde(untagged)]
pub enum MethodFigures {
    /// Its differences from the truth.
    Compared(Figures),
    /// It made no picture, or one that holds what is no number.
    Failed {
        /// Why.
        failed: String,
    },
}

/// Result of one scene.
#[derive(Clone, Debug, serde::Serialize)]
pub struct SceneResult {
    /// Its name, by which it is opened.
    pub scene: String,
    /// Its family.
    pub family: &'static str,
    /// Whether it was handed over as an image with depth.
    pub as_image: bool,
    /// Number of quads.
    pub quads: usize,
    /// K, px.
    pub k_px: f64,
    /// Lens points of the reference.
    pub reference_points: u32,
    /// PSNR, dB, of the reference's halves against each other; `None` where they are equal.
    pub reference_halves_db: Option<f64>,
    /// Whether these agree well enough for the scene to count.
    pub agrees: bool,
    /// By method id.
    pub methods: BTreeMap<&'static str, MethodFigures>,
    /// Time that each method took on the clock, s, and the reference as `accumulation`.
    pub seconds: BTreeMap<&'static str, f64>,
}

/// Tries the methods on all scenes of the request, on all of `gpus` at once. What was found
/// is in `results`, in the order of the scenes, also if the run is stopped.
///
/// # Errors
///
/// [`StudyError::Stopped`], and sizes that the adapter cannot draw.
pub fn run(
    gpus: &[Gpu],
    request: &GauntletRequest<'_>,
    results: &mut Vec<SceneResult>,
    progress: &mut Progress<'_>,
) -> Result<(), StudyError> {
    let jobs: Vec<_> = (0..request.scenes)
        .map(|index| {
            let seed = scene_seed(request.seed, index);
            (request.family.unwrap_or_else(|| family_of(seed)), seed)
        })
        .collect();
    let mut found: Vec<_> = jobs.iter().map(|_| None).collect();
    let work = |gpu: &Gpu, job: &(&'static Family, u64)| {
        let spec = generate(job.0, job.1, request.size);
        examine(gpu, &spec, job.0.name, request.methods, request.points)
    };
    let result =
        share_out(gpus, &jobs, "gauntlet", work, |index, result: SceneResult| found[index] = Some(result), progress);
    results.extend(found.into_iter().flatten());
    result
}

/// The truth of a scene and what the methods make of it. `points` are the least and the
/// most lens points of the reference.
///
/// # Errors
///
/// A size that the adapter cannot draw.
pub fn examine(
    gpu: &Gpu,
    spec: &SceneSpec,
    family: &'static str,
    methods: &[Box<dyn Method>],
    points: [u32; 2],
) -> Result<SceneResult, StudyError> {
    let lens = spec.lens();
    let start = Instant::now();
    let mut of_scene = view_of_scene(gpu, spec)?;
    let agreed = truth(gpu, &mut of_scene, &lens, points[0], points[1])?;
    let dark_sum = match spec.has_lights() {
        true => {
            let mut dark = view_of_scene(gpu, &spec.without_lights())?;
            Some(light_sum(&truth(gpu, &mut dark, &lens, DARK_POINTS, DARK_POINTS)?.color))
        }
        false => None,
    };
    let mut seconds = BTreeMap::from([(REFERENCE, start.elapsed().as_secs_f64())]);
    let mut view = match Source::from(spec) {
        Source::Scene(_) => of_scene,
        Source::Image(image) => View::of_image(gpu, &image.color, &image.depth, image.fov_y)?,
    };
    let pinhole = render(gpu, &mut view, &lens, &methods::Pinhole)?.color;
    let coc = lens.coc();
    let coc_px = view.depth_m(gpu).map(|d| coc.at_depth(f64::from(d)) as f32);
    let rules = Rules::new(&agreed.color, &pinhole, &coc_px, dark_sum)
        .map_err(|source| StudyError::Metrics { method: REFERENCE, source })?;
    let able = methods.iter().filter(|m| view.is_scene() || !m.about().needs_scene).collect::<Vec<_>>();
    let mut found = BTreeMap::new();
    for method in able {
        let (id, start) = (method.about().id, Instant::now());
        let image = render(gpu, &mut view, &lens, method.as_ref());
        *seconds.entry(id).or_default() += start.elapsed().as_secs_f64();
        found.insert(id, judged(image.map(|rendered| rendered.color), &rules));
    }
    Ok(SceneResult {
        scene: spec.name.clone(),
        family,
        as_image: spec.as_image,
        quads: spec.quads.len(),
        k_px: spec.k_px,
        reference_points: agreed.points,
        reference_halves_db: agreed.halves_db,
        agrees: agreed.agrees(),
        methods: found,
        seconds,
    })
}

fn judged(image: Result<ColorImage, StudyError>, rules: &Rules<'_>) -> MethodFigures {
    let failed = |failed: String| MethodFigures::Failed { failed };
    match image {
        Ok(image) => figures(&image, rules).map_or_else(|e| failed(e.to_string()), MethodFigures::Compared),
        Err(error) => failed(error.to_string()),
    }
}

fn view_of_scene(gpu: &Gpu, spec: &SceneSpec) -> Result<View, StudyError> {
    let scene = GpuScene::new(gpu, &spec.scene(), SurfaceOptions::default());
    Ok(View::of_scene(scene, spec.camera(), spec.size(), spec.overscan_px)?)
}
