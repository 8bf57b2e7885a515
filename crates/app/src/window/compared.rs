//! The comparison of all panes, made beside the interface on a device of its own: what reports and
//! figures for a paper are written from.

use super::engine::Activity;
use super::model::state;
use super::model::{Document, MethodChoice};
use defocus::display::Display;
use defocus::gpu::Gpu;
use defocus::image::DepthImage;
use defocus::methods::Method;
use defocus::view::{SurfaceOptions, View};
use defocus_study::compare::{CompareRequest, compare, runnable};
use defocus_study::reference::{Reference, ReferenceRequest, render_reference};
use defocus_study::report::{self, MethodImages};
use defocus_study::results::{CompareJson, Setting};
use defocus_study::timing::Rounds;
use defocus_study::{Comparison, GpuSource, Progress, Source, Step, Truth};
use glam::UVec2;
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Timed runs of each method.
const RUNS: u32 = 5;

/// How soon to look again whether something that is waited for has come.
const LOOK_AGAIN: Duration = Duration::from_millis(20);

/// Time in which the window shows how far the work is, before a run is timed.
const PAINTED_WITHIN: Duration = Duration::from_millis(60);

/// What is compared.
pub struct Order {
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
}

/// The window's reference, which may have to converge first.
pub struct AwaitedTruth {
    /// Where it arrives; closed where it will not.
    pub arrives: Receiver<Truth>,
    /// Lens points that it has and will have.
    pub progress: Arc<Mutex<(u32, u32)>>,
}

/// The result.
pub struct Compared {
    /// The numbers.
    pub json: CompareJson,
    /// The pictures, in the order of the panes that were compared.
    pub comparison: Comparison,
    /// The reference, where there is one.
    pub truth: Option<Truth>,
    /// Pictures and maps as a display shows them, in the same order.
    pub images: Vec<MethodImages>,
    /// Depths of the picture, metres.
    pub depth_m: DepthImage,
    /// How pictures are shown.
    pub display: Display,
    /// The command that repeats it.
    pub command: String,
    /// What was approximated or left out, one sentence each.
    pub notes: Vec<String>,
}

/// The device with what is compared on it.
pub struct Bench {
    /// The device.
    pub gpu: Gpu,
    /// What is drawn.
    pub source: GpuSource,
    /// Where it is seen from.
    pub view: View,
}

impl Bench {
    /// Opens a device for `order` and uploads to it.
    ///
    /// # Errors
    ///
    /// In a sentence: an adapter that cannot be opened, a view that cannot be drawn.
    pub fn open(order: &Order) -> Result<Self, String> {
        let gpu = Gpu::open(Some(&order.adapter)).map_err(|e| said(&e))?;
        for (name, text) in &order.shaders {
            gpu.replace_shader(name, text).map_err(|e| said(&e))?;
        }
        let source = order.source.upload(&gpu, order.options);
        let mut view = source.view(0, order.size, order.document.overscan_px, None).map_err(|e| said(&e))?;
        if let Some(camera) = order.document.camera {
            view.set_camera(camera);
        }
        Ok(Self { gpu, source, view })
    }
}

/// Renders what the document showed and measures it. Times are taken while the window draws
/// nothing; the notes say how many were not.
///
/// # Errors
///
/// In a sentence: a method that cannot render it, or that `progress` asked to stop.
pub fn compare_document(order: &Order, progress: &mut Progress<'_>) -> Result<Compared, String> {
    let Order { document, size, activity, .. } = order;
    let awaited = order.truth.as_ref().map_or(Ok(None), |truth| await_truth(truth, progress))?;
    let Bench { gpu, source, mut view } = Bench::open(order)?;
    let reference = document.reference();
    let compared = document.panes.iter().filter(|p| Some(p.id) != reference && !p.method.as_built);
    let methods = compared.map(|p| p.method.build()).collect::<Result<Vec<Box<dyn Method>>, _>>()?;
    let (methods, not_run) = runnable(methods, &view);
    let lens = &document.lens;
    let truth = match awaited {
        Some(truth) => Some(truth),
        None => own_truth(&source, &mut view, document, lens, progress)?,
    };
    let (display, viewing) = (document.display, document.viewing());
    let rounds = Rounds { warmup: 1, runs: RUNS, redraw: false };
    let request = CompareRequest { lens, methods: &methods, truth: truth.as_ref(), display, viewing, rounds };
    let mut watched = Watched::over(activity);
    let comparison = {
        let mut progress = |step: Step<'_>| watched.step(step, progress);
        compare(&gpu, &mut view, &request, &mut progress).map_err(|e| said(&e))?
    };
    let depth_m = view.depth_m(&gpu).as_ref().clone();
    let setting = setting(&gpu, &source, document, &view, lens, &depth_m);
    let json = CompareJson::new(setting, viewing, truth.as_ref(), &comparison, not_run);
    let images = comparison.results.iter().map(|r| report::method_images(r, truth.as_ref(), display, &viewing));
    let images = images.collect::<Result<Vec<_>, _>>().map_err(|e| said(&e))?;
    let mut notes = source.source().notes().to_vec();
    notes.extend(watched.note());
    if document.stereo.is_some() {
        notes.push("The window shows two eyes; this is the view from the middle between them".into());
    }
    if document.panes.iter().any(|pane| pane.method.as_built) {
        notes.push("Panes with the shaders as built are left out".into());
    }
    let one_eyed = Document { stereo: None, ..document.clone() };
    let command = state::command_line(&one_eyed, *size);
    Ok(Compared { json, comparison, truth, images, depth_m, display, command, notes })
}

/// Where, of what and through which lens pictures of a document are made.
pub fn setting(
    gpu: &Gpu,
    source: &GpuSource,
    document: &Document,
    view: &View,
    lens: &defocus::lens::Lens,
    depth_m: &DepthImage,
) -> Setting {
    let coc = lens.coc_statistics(depth_m.pixels.iter().copied());
    let cameras = source.source().cameras();
    let camera = cameras[document.camera_index.min(cameras.len() - 1)];
    Setting::new(gpu, source.source().name(), camera, view.size(), lens, coc)
}

/// An error in a sentence.
pub fn said(error: &dyn std::fmt::Display) -> String {
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

/// A reference of its own through `lens`, as the document has it; none of an image.
///
/// # Errors
///
/// In a sentence: what the method cannot render, or that `progress` asked to stop.
pub fn own_truth(
    source: &GpuSource,
    view: &mut View,
    document: &Document,
    lens: &defocus::lens::Lens,
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
    render_reference(source, view, lens, &request, progress).map(Some).map_err(|e| said(&e))
}

/// Sees to it that runs are timed while the window draws nothing, and counts those that
/// were not.
pub struct Watched<'a> {
    activity: &'a Activity,
    /// Frames that the window had drawn before the present step.
    seen: u64,
    disturbed: u32,
    steps: u32,
}

impl<'a> Watched<'a> {
    /// Over what the window does from now on.
    pub fn over(activity: &'a Activity) -> Self {
        Self { activity, seen: activity.frames(), disturbed: 0, steps: 0 }
    }

    /// Before a run: waits until the window rests, and counts the run before if it did not.
    pub fn step(&mut self, step: Step<'_>, progress: &mut Progress<'_>) -> ControlFlow<()> {
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
    pub fn note(&self) -> Option<String> {
        let Self { disturbed, steps, .. } = self;
        (*disturbed > 0).then(|| {
            format!("The window was drawing during {disturbed} of {steps} steps: times may be too long. Make the report again without touching the window for better ones.")
        })
    }
}
