//! The comparison of all panes as one HTML file, made beside the interface on a device of
//! its own.

use super::engine::Activity;
use super::model::state;
use super::model::{Document, MethodChoice};
use defocus::gpu::Gpu;
use defocus::image_io::write_atomically;
use defocus::methods::Method;
use defocus::view::{SurfaceOptions, View};
use defocus_study::compare::{CompareRequest, compare, runnable};
use defocus_study::reference::{Reference, ReferenceRequest, render_reference};
use defocus_study::report::{self, ReportInput};
use defocus_study::results::{CompareJson, Setting};
use defocus_study::timing::Rounds;
use defocus_study::{GpuSource, Progress, Source, Step, Truth};
use glam::UVec2;
use std::collections::BTreeMap;
use std::io::Write;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Timed runs of each method.
const RUNS: u32 = 5;

/// How soon to look again whether something that is waited for has come.
const LOOK_AGAIN: Duration = Duration::from_millis(20);

/// Time in which the window shows how far the work is, before a run is timed.
const PAINTED_WITHIN: Duration = Duration::from_millis(60);

/// What a report is made of.
pub struct ReportOrder {
    /// What is shown.
    pub source: Source,
    /// How its surfaces are drawn.
    pub options: SurfaceOptions,
    /// Name of the adapter.
    pub adapter: String,
    /// Shaders that were replaced, by name.
    pub shaders: BTreeMap<String, String>,
    /// What the document was.
    pub document: Document,
    /// Size of one eye's picture, px.
    pub size: UVec2,
    /// The window's reference, if it has one.
    pub truth: Option<AwaitedTruth>,
    /// What the window draws meanwhile.
    pub activity: Activity,
    /// Where to write it.
    pub file: PathBuf,
}

/// The window's reference, which may have to converge first.
pub struct AwaitedTruth {
    /// Where it arrives; closed where it will not.
    pub arrives: Receiver<Truth>,
    /// Lens points that it has and will have.
    pub progress: Arc<Mutex<(u32, u32)>>,
}

/// Renders what the document showed, measures it and writes the file. Times are taken while
/// the window draws nothing; the report says how many were not.
///
/// # Errors
///
/// In a sentence: a method that cannot render it, a file that cannot be written, or that
/// `progress` asked to stop.
pub fn write(order: ReportOrder, progress: &mut Progress<'_>) -> Result<(), String> {
    let ReportOrder { source, document, size, activity, file, .. } = &order;
    let awaited = order.truth.as_ref().map_or(Ok(None), |truth| await_truth(truth, progress))?;
    let gpu = &Gpu::open(Some(&order.adapter)).map_err(|e| said(&e))?;
    for (name, text) in &order.shaders {
        gpu.replace_shader(name, text).map_err(|e| said(&e))?;
    }
    let source = &source.upload(gpu, order.options);
    let mut view = source.view(0, *size, document.overscan_px, None).map_err(|e| said(&e))?;
    if let Some(camera) = document.camera {
        view.set_camera(camera);
    }
    let reference = document.reference();
    let methods = (document.panes.iter().filter(|p| Some(p.id) != reference))
        .map(|p| p.method.build())
        .collect::<Result<Vec<Box<dyn Method>>, _>>()?;
    let (methods, not_run) = runnable(methods, &view);
    let lens = &document.lens;
    let truth = match awaited {
        Some(truth) => Some(truth),
        None => own_truth(source, &mut view, document, progress)?,
    };
    let (display, viewing) = (document.display, document.viewing());
    let rounds = Rounds { warmup: 1, runs: RUNS, redraw: false };
    let request = CompareRequest { lens, methods: &methods, truth: truth.as_ref(), display, viewing, rounds };
    let mut watched = Watched { activity, seen: activity.frames(), disturbed: 0, steps: 0 };
    let comparison = {
        let mut progress = |step: Step<'_>| watched.step(step, progress);
        compare(gpu, &mut view, &request, &mut progress).map_err(|e| said(&e))?
    };
    let coc = lens.coc_statistics(view.depth_m(gpu).pixels.iter().copied());
    let cameras = source.source().cameras();
    let camera = cameras[document.camera_index.min(cameras.len() - 1)];
    let setting = Setting::new(gpu, source.source().name(), camera, view.size(), lens, coc);
    let json = CompareJson::new(setting, viewing, truth.as_ref(), &comparison, not_run);
    let images = comparison.results.iter().map(|r| report::method_images(r, truth.as_ref(), display, &viewing));
    let images = images.collect::<Result<Vec<_>, _>>().map_err(|e| said(&e))?;
    let mut notes = source.source().notes().to_vec();
    notes.extend(watched.note());
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
        command: &state::command_line(&one_eyed, *size),
        notes: &notes,
    })
    .map_err(|e| said(&e))?;
    write_atomically(file, |out| out.write_all(html.as_bytes())).map_err(|e| said(&e))
}

fn said(error: &dyn std::fmt::Display) -> String {
    error.to_string()
}

/// The window's reference once it has converged; `None` where the window shows something
/// else by now.
fn await_truth(truth: &AwaitedTruth, progress: &mut Progress<'_>) -> Result<Option<Truth>, String> {
    loop {
        match truth.arrives.recv_timeout(LOOK_AGAIN) {
            Ok(truth) => return Ok(Some(truth)),
            Err(RecvTimeoutError::Disconnected) => return Ok(None),
            Err(RecvTimeoutError::Timeout) => {}
        }
        let (done, of) = truth.progress.lock().map_or((0, 0), |progress| *progress);
        if progress(Step { what: "the window's reference", done, of }).is_break() {
            return Err(said(&defocus_study::StudyError::Stopped));
        }
    }
}

/// A reference of its own, as the document has it; none of an image.
fn own_truth(
    source: &GpuSource,
    view: &mut View,
    document: &Document,
    progress: &mut Progress<'_>,
) -> Result<Option<Truth>, String> {
    if !view.is_scene() {
        return Ok(None);
    }
    let choice = document.truth().unwrap_or_else(MethodChoice::reference);
    let request = ReferenceRequest {
        reference: Reference::Accumulation,
        samples: choice.count("samples").unwrap_or(super::model::REFERENCE_SAMPLES),
        view_dependent: choice.is_on("view_dependent"),
        display: document.display,
    };
    render_reference(source, view, &document.lens, &request, progress).map(Some).map_err(|e| said(&e))
}

/// Sees to it that runs are timed while the window draws nothing, and counts those that
/// were not.
struct Watched<'a> {
    activity: &'a Activity,
    /// Frames that the window had drawn before the present step.
    seen: u64,
    disturbed: u32,
    steps: u32,
}

impl Watched<'_> {
    fn step(&mut self, step: Step<'_>, progress: &mut Progress<'_>) -> ControlFlow<()> {
        if self.steps > 0 && self.activity.frames() != self.seen {
            self.disturbed += 1;
        }
        progress(step)?;
        // For the window to show the step before the clock runs.
        std::thread::sleep(PAINTED_WITHIN);
        while self.activity.is_busy() {
            std::thread::sleep(LOOK_AGAIN);
            progress(Step { what: "the window to come to rest", done: step.done, of: step.of })?;
        }
        self.steps += 1;
        self.seen = self.activity.frames();
        ControlFlow::Continue(())
    }

    /// What the report says of disturbed times.
    fn note(&self) -> Option<String> {
        let Self { disturbed, steps, .. } = self;
        (*disturbed > 0).then(|| {
            format!("The window was drawing during {disturbed} of {steps} steps: times may be too long. Make the report again without touching the window for better ones.")
        })
    }
}
