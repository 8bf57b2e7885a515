//! Figures, the CoC plot and batches as files for other programs, with the state that made them.

use super::App;
use super::engine::{Measured, PaneMetrics};
use super::model::Numbers;
use super::model::{Document, state};
use defocus::image_io::write_atomically;
use defocus_study::curves::CocCurve;
use defocus_study::results::LensJson;
use std::io::Write as _;
use std::path::Path;

/// The figures of a pane as they are shown.
#[derive(serde::Serialize)]
struct PaneFigures {
    pane: usize,
    method: String,
    params: String,
    psnr_db: Option<f64>,
    identical: bool,
    jod: Option<f64>,
    ssim: Option<f64>,
    flip: f64,
    px_per_degree: f64,
    reference_samples: Option<u32>,
    ms: Option<f64>,
    warm_frames: Option<usize>,
}

/// What all figures are of.
#[derive(serde::Serialize)]
struct Of<'a> {
    scene: &'a str,
    width_px: u32,
    height_px: u32,
    lens: LensJson,
    mean_coc_px: Option<f64>,
    adapter: &'a str,
    version: &'static str,
    command: String,
}

impl App {
    /// Writes numbers into a file.
    ///
    /// # Errors
    ///
    /// In a sentence: there are none yet, or the file cannot be written.
    pub(super) fn save_numbers(&mut self, kind: Numbers, file: &Path) -> Result<(), String> {
        let text = match kind {
            Numbers::FiguresCsv => self.figures_csv()?,
            Numbers::FiguresJson => self.figures_json()?,
            Numbers::Coc => self.coc_csv()?,
            Numbers::Batch => self.batch_csv()?,
        };
        write_atomically(file, |out| out.write_all(text.as_bytes())).map_err(|e| e.to_string())
    }

    /// Figures of all panes that have some which are about what is shown.
    fn figures(&self) -> Result<Vec<PaneFigures>, String> {
        let mut found = Vec::new();
        for (index, state) in self.document.panes.iter().enumerate() {
            let PaneMetrics::Current(Measured { of, result: Ok(figures) }) = self.engine.pane_metrics(state.id) else {
                continue;
            };
            let params = state.method.params.iter().map(|(key, value)| format!("{key}={value}"));
            let time = self.engine.pane(state.id).and_then(|pane| pane.time());
            found.push(PaneFigures {
                pane: index + 1,
                method: state.method.id.clone(),
                params: params.collect::<Vec<_>>().join("; "),
                psnr_db: figures.psnr_db,
                identical: figures.identical,
                jod: figures.jod,
                ssim: figures.ssim,
                flip: figures.flip,
                px_per_degree: figures.px_per_degree,
                reference_samples: of.truth.samples,
                ms: time.map(|time| time.ms),
                warm_frames: time.map(|time| time.warm_frames),
            });
        }
        match found.is_empty() {
            true => Err("there are no figures of what is shown: press Figures and wait for the reference".into()),
            false => Ok(found),
        }
    }

    fn of(&mut self) -> Of<'_> {
        let size = self.eye_size_px();
        let lens = self.document.lens.clone();
        let depths = self.engine.depths_m(true);
        let mean_coc_px = depths.and_then(|d| lens.coc_statistics(d.iter().copied())).map(|coc| coc.mean_px);
        Of {
            scene: &self.document.scene,
            width_px: size.x,
            height_px: size.y,
            lens: LensJson::from(&lens),
            mean_coc_px,
            adapter: &self.engine.gpu().adapter().name,
            version: env!("CARGO_PKG_VERSION"),
            command: state::command_line(&Document { stereo: None, ..self.document.clone() }, size),
        }
    }

    /// A line for each pane, each with what it is of.
    fn figures_csv(&mut self) -> Result<String, String> {
        #[derive(serde::Serialize)]
        struct Line<'a> {
            pane: usize,
            method: &'a str,
            params: &'a str,
            psnr_db: Option<f64>,
            identical: bool,
            jod: Option<f64>,
            ssim: Option<f64>,
            flip: f64,
            px_per_degree: f64,
            reference_samples: Option<u32>,
            ms: Option<f64>,
            warm_frames: Option<usize>,
            scene: &'a str,
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
            adapter: &'a str,
            version: &'a str,
            command: &'a str,
        }
        let figures = self.figures()?;
        let of = self.of();
        let mut writer = csv::Writer::from_writer(Vec::new());
        for pane in &figures {
            let line = Line {
                pane: pane.pane,
                method: &pane.method,
                params: &pane.params,
                psnr_db: pane.psnr_db,
                identical: pane.identical,
                jod: pane.jod,
                ssim: pane.ssim,
                flip: pane.flip,
                px_per_degree: pane.px_per_degree,
                reference_samples: pane.reference_samples,
                ms: pane.ms,
                warm_frames: pane.warm_frames,
                scene: of.scene,
                width_px: of.width_px,
                height_px: of.height_px,
                aperture_diameter_mm: of.lens.aperture_diameter_mm,
                focal_length_mm: of.lens.focal_length_mm,
                image_distance_mm: of.lens.image_distance_mm,
                screen_distance_mm: of.lens.screen_distance_mm,
                density_px_per_mm: of.lens.density_px_per_mm,
                focus_m: of.lens.focus_m,
                aperture: &of.lens.aperture,
                mean_coc_px: of.mean_coc_px,
                adapter: of.adapter,
                version: of.version,
                command: &of.command,
            };
            writer.serialize(line).map_err(|e| e.to_string())?;
        }
        let bytes = writer.into_inner().map_err(|e| e.to_string())?;
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }

    /// The same with the whole state, from which the window can be brought back.
    fn figures_json(&mut self) -> Result<String, String> {
        #[derive(serde::Serialize)]
        struct File<'a> {
            of: Of<'a>,
            figures: Vec<PaneFigures>,
            state: String,
        }
        let figures = self.figures()?;
        let state = state::text(&self.document).map_err(|e| e.to_string())?;
        let file = File { of: self.of(), figures, state };
        serde_json::to_string_pretty(&file).map(|text| text + "\n").map_err(|e| e.to_string())
    }

    /// The curve of the CoC plot over the depths in view.
    fn coc_csv(&mut self) -> Result<String, String> {
        let lens = self.document.lens.clone();
        lens.check().map_err(|e| e.to_string())?;
        let range_m = self.engine.depths_m(true).and_then(|depths| CocCurve::range_m(depths.iter().copied()));
        let range_m = range_m.ok_or("nothing in view has a finite depth: look at something")?;
        Ok(CocCurve::of(&lens, range_m).csv())
    }
}
