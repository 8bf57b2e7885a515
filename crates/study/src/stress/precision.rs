//! What intermediates in f16 cost against f32, method by method.

use super::scenes::SCENES;
use super::specimen::render;
use crate::metrics::{self, CompareOptions};
use crate::{DepthArgs, Progress, Source, StudyError, step};
use defocus::display::Display;
use defocus::gpu::{Gpu, Precision};
use defocus::image::ColorImage;
use defocus::lens::Lens;
use defocus::methods::{Accumulation, Method};
use defocus::view::{SurfaceOptions, View};
use glam::{UVec2, uvec2};

/// PSNR, dB, that f16 may cost against the reference.
pub const ACCEPTABLE_LOSS_DB: f64 = 0.1;

/// Lens points of the reference.
const REFERENCE_POINTS: u32 = 64;

/// Mean CoC, px, at which the built-in scenes are seen.
const MEAN_COC_PX: f64 = 8.0;

/// A method's error against the reference with f16 intermediates and with f32 ones.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct PrecisionRow {
    /// The method's id.
    pub method: &'static str,
    /// What was seen.
    pub scene: String,
    /// PSNR against the reference, dB, with f16; `None` for no difference at all.
    pub half_psnr_db: Option<f64>,
    /// The same with f32.
    pub full_psnr_db: Option<f64>,
    /// PSNR of one against the other, dB; `None` where they are equal.
    pub between_psnr_db: Option<f64>,
    /// Greatest difference of a pixel, of the greatest value that f32 has in the image.
    pub greatest_difference: f32,
}

impl PrecisionRow {
    /// PSNR that f16 costs, dB.
    pub fn loss_db(&self) -> f64 {
        match (self.half_psnr_db, self.full_psnr_db) {
            (Some(half), Some(full)) => full - half,
            (None, _) => 0.0,
            (Some(_), None) => f64::INFINITY,
        }
    }
}

/// A view and a lens to measure on.
struct Measured {
    name: String,
    view: View,
    lens: Lens,
}

/// Measures every method on a small scene and, unless `quick`, on two of the built-in ones.
///
/// # Errors
///
/// [`StudyError::Stopped`], and what methods say.
pub fn measure(
    gpu: &Gpu,
    methods: &[Box<dyn Method>],
    quick: bool,
    progress: &mut Progress<'_>,
) -> Result<Vec<PrecisionRow>, StudyError> {
    let mut subjects = vec![small_scene(gpu)?];
    if !quick {
        for name in ["cans", "highlights"] {
            subjects.push(built_in(gpu, name)?);
        }
    }
    let mut rows = Vec::new();
    let count = subjects.len() as u32;
    for (index, subject) in subjects.iter_mut().enumerate() {
        step(progress, "f16 and f32", index as u32, count)?;
        let reference = Accumulation { samples: REFERENCE_POINTS, ..Accumulation::default() };
        let truth = rendered(gpu, &reference, subject, Precision::Full)?;
        for method in methods {
            step(progress, "f16 and f32", index as u32, count)?;
            rows.push(row(gpu, &**method, subject, &truth)?);
        }
    }
    Ok(rows)
}

fn small_scene(gpu: &Gpu) -> Result<Measured, StudyError> {
    let condition = super::scenes::SceneCondition { size: uvec2(128, 96), overscan_px: 16, k_px: 12.0, ..SCENES[0] };
    let specimen = condition.specimen(gpu)?;
    Ok(Measured { name: "three surfaces".into(), view: specimen.view, lens: specimen.lens })
}

fn built_in(gpu: &Gpu, name: &str) -> Result<Measured, StudyError> {
    const SIZE: UVec2 = uvec2(160, 120);
    let source = Source::open(name, &DepthArgs::default())?;
    let uploaded = source.upload(gpu, SurfaceOptions::default());
    let mut view = uploaded.view(0, SIZE, 0, None)?;
    let depth = view.depth_m(gpu);
    let lens = uploaded.source().default_lens(&depth);
    let lens = lens.with_mean_coc(MEAN_COC_PX, depth.pixels.iter().copied()).unwrap_or(lens);
    view.set_size(gpu, SIZE, defocus::view::auto_overscan_px(&lens, &depth))?;
    Ok(Measured { name: name.into(), view, lens })
}

fn rendered(
    gpu: &Gpu,
    method: &dyn Method,
    subject: &mut Measured,
    precision: Precision,
) -> Result<ColorImage, StudyError> {
    render(gpu, method, &mut subject.view, &subject.lens, precision)
        .map_err(|source| StudyError::Method { method: method.about().id, source })
}

fn row(gpu: &Gpu, method: &dyn Method, subject: &mut Measured, truth: &ColorImage) -> Result<PrecisionRow, StudyError> {
    let id = method.about().id;
    let half = rendered(gpu, method, subject, Precision::Half)?;
    let full = rendered(gpu, method, subject, Precision::Full)?;
    let psnr_db = |test: &ColorImage, reference: &ColorImage| -> Result<Option<f64>, StudyError> {
        let options = CompareOptions { display: Display::default(), ..Default::default() };
        let metrics =
            metrics::compare(test, reference, &options).map_err(|source| StudyError::Metrics { method: id, source })?;
        Ok(metrics.psnr_db)
    };
    let greatest = full.pixels.iter().map(|p| p.max_element()).fold(f32::MIN_POSITIVE, f32::max);
    let difference = half.pixels.iter().zip(&full.pixels).map(|(a, b)| (*a - *b).abs().max_element());
    Ok(PrecisionRow {
        method: id,
        scene: subject.name.clone(),
        half_psnr_db: psnr_db(&half, truth)?,
        full_psnr_db: psnr_db(&full, truth)?,
        between_psnr_db: psnr_db(&half, &full)?,
        greatest_difference: difference.fold(0.0, f32::max) / greatest,
    })
}
