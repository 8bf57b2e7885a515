//! What a benchmark finds out, as files hold it.

use super::plan::{Blur, Cell, Plan};
use crate::compare::NotRun;
use crate::results::{MetricsJson, Work};
use crate::timing::RunTimes;
use defocus::gpu::PassTime;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// All that is known of a plan.
#[derive(Clone, Debug, Serialize)]
pub struct BenchResults {
    /// What was to be measured.
    pub plan: Plan,
    /// Cells in the plan.
    pub cells_wanted: usize,
    /// What was measured so far, in the plan's order.
    pub cells: Vec<CellResult>,
}

/// Result of one cell.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct CellResult {
    /// Which.
    pub cell: Cell,
    /// The adapter's name and back end.
    pub adapter: String,
    /// Version of the program.
    pub version: String,
    /// The scene's short name.
    pub scene: String,
    /// Triangles of the whole scene, instances counted; 2 for an image.
    pub scene_triangles: u64,
    /// Size of the image, px: an image with depth is never enlarged.
    pub size: [u32; 2],
    /// Mean CoC diameter of the image, px.
    pub mean_coc_px: f64,
    /// Greatest CoC diameter, px.
    pub greatest_coc_px: f64,
    /// Share of pixels with a CoC diameter under 1 px.
    pub in_focus: f64,
    /// Estimated PSNR of the reference against a converged one, dB.
    pub reference_self_psnr_db: Option<f64>,
    /// GPU times, ms, of copying the image in the same rounds.
    pub copy_ms: Option<RunTimes>,
    /// Result of each variant.
    pub variants: Vec<VariantResult>,
    /// Variants left out, with the reason.
    pub not_run: Vec<NotRun>,
}

/// Result of one variant in one cell.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct VariantResult {
    /// Method and settings in words.
    pub label: String,
    /// The method's id.
    pub method: String,
    /// All its parameters.
    pub params: Map<String, Value>,
    /// Differences from the reference.
    #[serde(flatten)]
    pub metrics: MetricsJson,
    /// GPU times, ms.
    pub gpu_ms: Option<RunTimes>,
    /// The same as multiples of the copy's time.
    pub copy_ratio: Option<RunTimes>,
    /// Passes of the last run, those of one label added up.
    pub passes: Vec<PassTime>,
    /// What else the last run took.
    #[serde(flatten)]
    pub work: Work,
    /// Texture reads over pixels of the image, if they were counted.
    pub reads_per_px: Option<f64>,
    /// The file, beside the results, that holds the FLIP map.
    pub flip_map: Option<String>,
}

impl CellResult {
    /// The variant of that label.
    pub fn variant(&self, label: &str) -> Option<&VariantResult> {
        self.variants.iter().find(|v| v.label == label)
    }
}

impl VariantResult {
    /// Multiple of the copy's time.
    pub fn ratio(&self) -> Option<f64> {
        self.copy_ratio.map(|r| r.median)
    }

    /// Median GPU time, ms.
    pub fn ms(&self) -> Option<f64> {
        self.gpu_ms.map(|t| t.median)
    }

    /// PSNR over the defocused pixels, dB.
    pub fn defocused_db(&self) -> Option<f64> {
        self.metrics.psnr_defocused_db
    }
}

impl BenchResults {
    /// The cell of a scene (as the plan has it) with a blur, at the least size.
    pub fn cell(&self, scene: &str, blur: Blur) -> Option<&CellResult> {
        self.cells.iter().find(|c| c.cell.scene == scene && c.cell.blur == blur)
    }

    /// As CSV, a line for each variant in each cell.
    ///
    /// # Errors
    ///
    /// None in practice: memory takes everything.
    pub fn csv(&self) -> Result<Vec<u8>, csv::Error> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        for cell in &self.cells {
            for variant in &cell.variants {
                writer.serialize(Line::of(cell, variant))?;
            }
        }
        writer.into_inner().map_err(|e| e.into_error().into())
    }
}

/// A line of CSV; what does not exist is empty.
#[derive(Serialize)]
struct Line<'a> {
    adapter: &'a str,
    version: &'a str,
    scene: &'a str,
    scene_triangles: u64,
    width: u32,
    height: u32,
    mean_coc_px: f64,
    greatest_coc_px: f64,
    in_focus: f64,
    variant: &'a str,
    method: &'a str,
    gpu_ms: Option<f64>,
    gpu_ms_low: Option<f64>,
    gpu_ms_high: Option<f64>,
    runs: Option<u32>,
    copy_ms: Option<f64>,
    copies: Option<f64>,
    copies_low: Option<f64>,
    copies_high: Option<f64>,
    psnr_db: Option<f64>,
    psnr_defocused_db: Option<f64>,
    worst_block_psnr_db: Option<f64>,
    ssim: Option<f64>,
    flip: Option<f64>,
    ppd: Option<f64>,
    jod: Option<f64>,
    rel_mse: Option<f64>,
    reference_self_psnr_db: Option<f64>,
    triangles_drawn: u64,
    views_drawn: u64,
    peak_texture_bytes: u64,
    reads_per_px: Option<f64>,
}

impl<'a> Line<'a> {
    fn of(cell: &'a CellResult, variant: &'a VariantResult) -> Self {
        let metrics = &variant.metrics;
        Self {
            adapter: &cell.adapter,
            version: &cell.version,
            scene: &cell.scene,
            scene_triangles: cell.scene_triangles,
            width: cell.size[0],
            height: cell.size[1],
            mean_coc_px: cell.mean_coc_px,
            greatest_coc_px: cell.greatest_coc_px,
            in_focus: cell.in_focus,
            variant: &variant.label,
            method: &variant.method,
            gpu_ms: variant.ms(),
            gpu_ms_low: variant.gpu_ms.map(|t| t.low),
            gpu_ms_high: variant.gpu_ms.map(|t| t.high),
            runs: variant.gpu_ms.map(|t| t.runs),
            copy_ms: cell.copy_ms.map(|t| t.median),
            copies: variant.ratio(),
            copies_low: variant.copy_ratio.map(|t| t.low),
            copies_high: variant.copy_ratio.map(|t| t.high),
            psnr_db: metrics.psnr_db,
            psnr_defocused_db: metrics.psnr_defocused_db,
            worst_block_psnr_db: metrics.worst_block_psnr_db,
            ssim: metrics.ssim,
            flip: metrics.flip,
            ppd: metrics.ppd,
            jod: metrics.jod,
            rel_mse: metrics.rel_mse,
            reference_self_psnr_db: cell.reference_self_psnr_db,
            triangles_drawn: variant.work.drawn.triangles,
            views_drawn: variant.work.drawn.views,
            peak_texture_bytes: variant.work.peak_texture_bytes,
            reads_per_px: variant.reads_per_px,
        }
    }
}
