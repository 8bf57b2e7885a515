//! The comparison of all panes as one HTML file.

use super::document::{Document, REFERENCE_SAMPLES};
use super::state;
use crate::gpu::Gpu;
use crate::image_io::write_atomically;
use crate::methods::Method;
use crate::study::compare::{CompareRequest, compare, runnable};
use crate::study::reference::{Reference, ReferenceRequest, render_reference};
use crate::study::report::{self, ReportInput};
use crate::study::results::{CompareJson, Setting};
use crate::study::timing::Rounds;
use crate::study::{GpuSource, Progress};
use glam::UVec2;
use std::io::Write;
use std::path::Path;

/// Timed runs of each method.
const RUNS: u32 = 5;

/// Renders what the document shows again, `size` px large, measures it and writes `file`.
///
/// # Errors
///
/// In a sentence: a method that cannot render it, a file that cannot be written, or that
/// `progress` asked to stop.
pub fn write(
    gpu: &Gpu,
    source: &GpuSource,
    document: &Document,
    size: UVec2,
    file: &Path,
    progress: &mut Progress<'_>,
) -> Result<(), String> {
    let said = |e: &dyn std::fmt::Display| e.to_string();
    let mut view = source.view(0, size, document.overscan_px, None).map_err(|e| said(&e))?;
    if let Some(camera) = document.camera {
        view.set_camera(camera);
    }
    let reference = document.reference();
    let methods = (document.panes.iter().filter(|p| Some(p.id) != reference))
        .map(|p| p.method.build())
        .collect::<Result<Vec<Box<dyn Method>>, _>>()?;
    let (methods, not_run) = runnable(methods, &view);
    let lens = &document.lens;
    let truth = match view.is_scene() {
        false => None,
        true => {
            let samples = reference.and_then(|id| document.pane(id)?.method.params.get("samples")?.parse().ok());
            let request = ReferenceRequest {
                reference: Reference::Accumulation,
                samples: samples.unwrap_or(REFERENCE_SAMPLES),
                view_dependent: false,
                display: document.display,
            };
            Some(render_reference(source, &mut view, lens, &request, progress).map_err(|e| said(&e))?)
        }
    };
    let display = document.display;
    let rounds = Rounds { warmup: 1, runs: RUNS, redraw: false };
    let request = CompareRequest { lens, methods: &methods, truth: truth.as_ref(), display, rounds };
    let comparison = compare(gpu, &mut view, &request, progress).map_err(|e| said(&e))?;
    let coc = lens.coc_statistics(view.depth_m(gpu).pixels.iter().copied());
    let cameras = source.source().cameras();
    let camera = cameras[document.camera_index.min(cameras.len() - 1)];
    let setting = Setting::new(gpu, source.source().name(), camera, view.size(), lens, coc);
    let json = CompareJson::new(setting, truth.as_ref(), &comparison, not_run);
    let images = comparison.results.iter().map(|r| report::method_images(r, truth.as_ref(), display));
    let images = images.collect::<Result<Vec<_>, _>>().map_err(|e| said(&e))?;
    let mut notes = source.source().notes().to_vec();
    if document.stereo.is_some() {
        notes.push("The window shows two eyes; this is the view from the middle between them.".into());
    }
    let one_eyed = Document { stereo: None, ..document.clone() };
    let html = report::html(&ReportInput {
        json: &json,
        comparison: &comparison,
        truth: truth.as_ref(),
        images: &images,
        display,
        command: &state::command_line(&one_eyed, size),
        notes: &notes,
    })
    .map_err(|e| said(&e))?;
    write_atomically(file, |out| out.write_all(html.as_bytes())).map_err(|e| said(&e))
}
