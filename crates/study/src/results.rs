//! Results as JSON: the shapes that scripts rely on. A value that does not exist is null,
//! never 0 or infinity.

use super::timing::RunTimes;
use super::{Comparison, MethodResult, Rendered, Truth, compare};
use crate::metrics::{Metrics, Visibility};
use defocus::eye::Eye;
use defocus::gpu::{FrameStats, Gpu, PassTime};
use defocus::lens::{CocStatistics, Lens};
use defocus::stereo::Stereo;
use defocus::viewing::Viewing;
use glam::UVec2;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// A lens, with what follows from it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LensJson {
    /// E, mm.
    #[serde(rename = "E")]
    pub aperture_diameter_mm: f64,
    /// F, mm.
    #[serde(rename = "F")]
    pub focal_length_mm: f64,
    /// dr, mm.
    #[serde(rename = "dr")]
    pub image_distance_mm: f64,
    /// ds, mm.
    #[serde(rename = "ds")]
    pub screen_distance_mm: f64,
    /// DPI, px/mm.
    #[serde(rename = "dpi")]
    pub density_px_per_mm: f64,
    /// df, metres; null at infinity.
    pub focus_m: Option<f64>,
    /// K, the CoC diameter at infinity, px.
    #[serde(rename = "K_px")]
    pub k_px: f64,
    /// The aperture's shape, as the command line takes it.
    pub aperture: String,
    /// What the eye adds.
    pub eye: Eye,
    /// Distance of what is sharp, metres; null where that is infinity or nothing is.
    pub sharpest_m: Option<f64>,
}

impl From<&Lens> for LensJson {
    fn from(lens: &Lens) -> Self {
        Self {
            aperture_diameter_mm: lens.aperture_diameter_mm,
            focal_length_mm: lens.focal_length_mm,
            image_distance_mm: lens.image_distance_mm,
            screen_distance_mm: lens.screen_distance_mm,
            density_px_per_mm: lens.density_px_per_mm,
            focus_m: Some(lens.focus_distance_m).filter(|m| m.is_finite()),
            k_px: lens.k_px(),
            aperture: lens.aperture.to_string(),
            eye: lens.eye,
            sharpest_m: Some(lens.sharpest_m()).filter(|m| m.is_finite()),
        }
    }
}

/// Where, of what and through which lens images were made.
#[derive(Clone, Debug, Serialize)]
pub struct Setting {
    /// The adapter's name.
    pub adapter: String,
    /// Its back end, such as "Vulkan".
    pub backend: String,
    /// The scene's or image's name.
    pub scene: String,
    /// The camera's name.
    pub camera: String,
    /// Width and height, px.
    pub size: [u32; 2],
    /// The lens.
    pub lens: LensJson,
    /// The CoC over the pinhole image.
    pub coc: Option<CocStatistics>,
    /// What was approximated, left out or filled in while loading, one sentence each.
    pub notes: Vec<String>,
}

impl Setting {
    /// The setting of images of `size` px made on `gpu`, without notes.
    pub fn new(gpu: &Gpu, scene: &str, camera: &str, size: UVec2, lens: &Lens, coc: Option<CocStatistics>) -> Self {
        let adapter = gpu.adapter();
        Self {
            adapter: adapter.name.clone(),
            backend: adapter.backend.clone(),
            scene: scene.into(),
            camera: camera.into(),
            size: size.to_array(),
            lens: lens.into(),
            coc,
            notes: Vec::new(),
        }
    }
}

/// What was drawn.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Drawn {
    /// Triangles sent to the rasteriser.
    pub triangles: u64,
    /// Views of the scene.
    pub views: u64,
}

/// What making an image took, beside time.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Work {
    /// What was drawn.
    pub drawn: Drawn,
    /// Most bytes of textures alive at once, the view's own included.
    pub peak_texture_bytes: u64,
    /// What was not needed, by name, with how often.
    pub skipped: BTreeMap<String, u64>,
}

impl From<&FrameStats> for Work {
    fn from(stats: &FrameStats) -> Self {
        Self {
            drawn: Drawn { triangles: stats.triangles, views: stats.views },
            peak_texture_bytes: stats.peak_texture_bytes,
            skipped: stats.skipped.clone(),
        }
    }
}

/// Two eyes.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct StereoJson {
    /// How their images are one.
    pub layout: &'static str,
    /// Their distance, mm.
    pub ipd_mm: f64,
    /// Depth of the window that both look through, metres; null at infinity.
    pub window_m: Option<f64>,
}

impl From<Stereo> for StereoJson {
    fn from(Stereo { layout, ipd_mm, window_m }: Stereo) -> Self {
        Self { layout: layout.id(), ipd_mm, window_m: Some(window_m).filter(|m| m.is_finite()) }
    }
}

/// One image.
#[derive(Clone, Debug, Serialize)]
pub struct RenderJson {
    /// Where, of what, through which lens.
    #[serde(flatten)]
    pub setting: Setting,
    /// The two eyes that see it; null for one.
    pub stereo: Option<StereoJson>,
    /// The method's id.
    pub method: String,
    /// Its parameters.
    pub params: Map<String, Value>,
    /// GPU times of its passes, in order.
    pub passes: Vec<PassTime>,
    /// Their sum, ms.
    pub gpu_ms: Option<f64>,
    /// What else it took.
    #[serde(flatten)]
    pub work: Work,
}

impl RenderJson {
    /// An image by the method of that id with those parameters.
    pub fn new(
        setting: Setting,
        stereo: Option<Stereo>,
        method: &str,
        params: Map<String, Value>,
        rendered: &Rendered,
    ) -> Self {
        Self {
            setting,
            stereo: stereo.map(StereoJson::from),
            method: method.into(),
            params,
            passes: rendered.passes.clone(),
            gpu_ms: rendered.gpu_ms(),
            work: Work::from(&rendered.stats),
        }
    }
}

/// Methods against a reference.
#[derive(Clone, Debug, Serialize)]
pub struct CompareJson {
    /// Where, of what, through which lens.
    #[serde(flatten)]
    pub setting: Setting,
    /// Under what angle and in what light the images are looked at.
    pub viewing: Viewing,
    /// The truth, where there is one.
    pub reference: Option<ReferenceJson>,
    /// Result of each method.
    pub results: Vec<ResultJson>,
    /// GPU times, ms, of a copy of the pinhole image in the same rounds.
    pub copy_ms: Option<RunTimes>,
    /// Methods left out, with the reason.
    pub not_run: Vec<compare::NotRun>,
    /// The cheapest method that is good enough, where that was asked for.
    pub good_enough: Option<compare::GoodEnough>,
}

/// The truth.
#[derive(Clone, Debug, Serialize)]
pub struct ReferenceJson {
    /// Its id.
    pub method: &'static str,
    /// Lens points.
    pub samples: Option<u32>,
    /// Estimated PSNR against a fully converged image, dB.
    pub self_psnr_db: Option<f64>,
}

/// Result of one method.
#[derive(Clone, Debug, Serialize)]
pub struct ResultJson {
    /// Its id.
    pub method: &'static str,
    /// Its parameters.
    pub params: Map<String, Value>,
    /// Differences from the truth.
    #[serde(flatten)]
    pub metrics: MetricsJson,
    /// GPU times.
    pub gpu_ms: Option<RunTimes>,
    /// The same as multiples of the time that a copy of the image takes.
    pub copy_ratio: Option<RunTimes>,
    /// What else the last run took.
    #[serde(flatten)]
    pub work: Work,
}

/// Differences between two images; all null where there is nothing to compare with.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MetricsJson {
    /// Whether all pixels are equal.
    pub identical: Option<bool>,
    /// PSNR, dB.
    pub psnr_db: Option<f64>,
    /// PSNR, dB, over the defocused pixels only.
    pub psnr_defocused_db: Option<f64>,
    /// Mean structural similarity.
    pub ssim: Option<f64>,
    /// Mean FLIP.
    pub flip: Option<f64>,
    /// Pixels per degree at which FLIP and JOD looked at the images.
    #[serde(default)]
    pub ppd: Option<f64>,
    /// Quality by ColorVideoVDP, JOD, 10 for equal images.
    #[serde(default)]
    pub jod: Option<f64>,
    /// The same in a word.
    #[serde(default)]
    pub visibility: Option<Visibility>,
    /// Relative mean squared error.
    pub rel_mse: Option<f64>,
    /// PSNR, dB, of the worst block.
    pub worst_block_psnr_db: Option<f64>,
    /// The worst block's first pixel.
    pub worst_block: Option<[u32; 2]>,
}

impl From<&Metrics> for MetricsJson {
    fn from(m: &Metrics) -> Self {
        Self {
            identical: Some(m.identical),
            psnr_db: m.psnr_db,
            psnr_defocused_db: m.psnr_defocused_db,
            ssim: m.ssim,
            flip: Some(m.flip),
            ppd: Some(m.px_per_degree),
            jod: m.jod,
            visibility: m.jod.map(Visibility::of_jod),
            rel_mse: Some(m.rel_mse),
            worst_block_psnr_db: m.worst_block_psnr_db,
            worst_block: m.worst_block.map(|p| p.to_array()),
        }
    }
}

impl From<&MethodResult> for ResultJson {
    fn from(result: &MethodResult) -> Self {
        Self {
            method: result.method,
            params: result.params.clone(),
            metrics: result.metrics.as_ref().map(MetricsJson::from).unwrap_or_default(),
            gpu_ms: result.gpu_ms,
            copy_ratio: result.copy_ratio,
            work: Work::from(&result.stats),
        }
    }
}

impl CompareJson {
    /// Result of a comparison.
    pub fn new(
        setting: Setting,
        viewing: Viewing,
        truth: Option<&Truth>,
        comparison: &Comparison,
        not_run: Vec<compare::NotRun>,
    ) -> Self {
        let reference =
            |t: &Truth| ReferenceJson { method: t.method, samples: t.samples, self_psnr_db: t.self_psnr_db };
        Self {
            setting,
            viewing,
            reference: truth.map(reference),
            results: comparison.results.iter().map(ResultJson::from).collect(),
            copy_ms: comparison.copy_ms,
            not_run,
            good_enough: None,
        }
    }
}
