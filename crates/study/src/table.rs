//! A comparison as a table for other programs: a line for each method, which says by itself what
//! it is of.

use super::results::{CompareJson, ResultJson};
use serde::Serialize;

/// A line; what does not exist is empty.
#[derive(Serialize)]
struct Line<'a> {
    scene: &'a str,
    camera: &'a str,
    width_px: u32,
    height_px: u32,
    aperture_diameter_mm: f64,
    focal_length_mm: f64,
    image_distance_mm: f64,
    screen_distance_mm: f64,
    density_px_per_mm: f64,
    focus_m: Option<f64>,
    aperture: &'a str,
    mean_coc_px: Option<f64>,
    greatest_coc_px: Option<f64>,
    px_per_degree: f64,
    method: &'a str,
    params: String,
    reference: &'a str,
    reference_samples: Option<u32>,
    reference_self_psnr_db: Option<f64>,
    psnr_db: Option<f64>,
    psnr_defocused_db: Option<f64>,
    worst_block_psnr_db: Option<f64>,
    ssim: Option<f64>,
    jod: Option<f64>,
    flip: Option<f64>,
    rel_mse: Option<f64>,
    identical: Option<bool>,
    gpu_ms: Option<f64>,
    gpu_ms_min: Option<f64>,
    gpu_ms_max: Option<f64>,
    runs: Option<u32>,
    copies: Option<f64>,
    adapter: &'a str,
    version: &'a str,
}

impl<'a> Line<'a> {
    fn of(json: &'a CompareJson, result: &'a ResultJson) -> Self {
        let (setting, lens, m) = (&json.setting, &json.setting.lens, &result.metrics);
        let reference = json.reference.as_ref();
        Self {
            scene: &setting.scene,
            camera: &setting.camera,
            width_px: setting.size[0],
            height_px: setting.size[1],
            aperture_diameter_mm: lens.aperture_diameter_mm,
            focal_length_mm: lens.focal_length_mm,
            image_distance_mm: lens.image_distance_mm,
            screen_distance_mm: lens.screen_distance_mm,
            density_px_per_mm: lens.density_px_per_mm,
            focus_m: lens.focus_m,
            aperture: &lens.aperture,
            mean_coc_px: setting.coc.map(|coc| coc.mean_px),
            greatest_coc_px: setting.coc.map(|coc| coc.greatest_px()),
            px_per_degree: json.viewing.px_per_degree,
            method: result.method,
            params: params_text(result),
            reference: reference.map_or("", |r| r.method),
            reference_samples: reference.and_then(|r| r.samples),
            reference_self_psnr_db: reference.and_then(|r| r.self_psnr_db),
            psnr_db: m.psnr_db,
            psnr_defocused_db: m.psnr_defocused_db,
            worst_block_psnr_db: m.worst_block_psnr_db,
            ssim: m.ssim,
            jod: m.jod,
            flip: m.flip,
            rel_mse: m.rel_mse,
            identical: m.identical,
            gpu_ms: result.gpu_ms.map(|t| t.median),
            gpu_ms_min: result.gpu_ms.map(|t| t.min),
            gpu_ms_max: result.gpu_ms.map(|t| t.max),
            runs: result.gpu_ms.map(|t| t.runs),
            copies: result.copy_ratio.map(|t| t.median),
            adapter: &setting.adapter,
            version: env!("CARGO_PKG_VERSION"),
        }
    }
}

/// A method's parameters in one cell: "smoothing=on; delta=0.5".
pub fn params_text(result: &ResultJson) -> String {
    let plain = |value: &serde_json::Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    let params = result.params.iter().map(|(key, value)| format!("{key}={}", plain(value)));
    params.collect::<Vec<_>>().join("; ")
}

/// Comparisons as CSV, a line for each method in each; lengths in the units that their columns
/// name.
///
/// # Errors
///
/// None in practice: memory takes everything.
pub fn csv<'a>(comparisons: impl IntoIterator<Item = &'a CompareJson>) -> Result<String, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for json in comparisons {
        for result in &json.results {
            writer.serialize(Line::of(json, result))?;
        }
    }
    let bytes = writer.into_inner().map_err(|e| csv::Error::from(e.into_error()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
