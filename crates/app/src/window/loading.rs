//! Opening scenes without holding up the window.

use defocus::gpu::Gpu;
use defocus::image_io::ImageError;
use defocus::lens::Lens;
use defocus::scene::rgbd::RgbdError;
use defocus::view::SurfaceOptions;
use defocus_study::meter::{is_metered, view_exposure_ev};
use defocus_study::{DepthArgs, GpuSource, Source, SourceError};
use eframe::egui;
use std::path::Path;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// What was opened, or why not.
pub struct Loaded {
    /// What was asked for, a file with its whole path.
    pub spec: String,
    /// Where an image's depth was to come from.
    pub depth: DepthArgs,
    /// Whether camera and focus are to be chosen for it.
    pub fresh: bool,
    /// Whether it is an image of which more has to be said: where its depth is, what its numbers mean,
    /// which of its layers are meant.
    pub is_incomplete: bool,
    /// Exposure that its light asks for, EV, of a scene that would be white or black without.
    pub metered_ev: Option<f32>,
    /// The source, or a sentence.
    pub result: Result<GpuSource, String>,
}

struct Pending {
    spec: String,
    depth: DepthArgs,
    fresh: bool,
    receiver: Receiver<Result<Opened, SourceError>>,
}

/// Whether an image can be opened once more is said about it.
fn is_incomplete(error: &RgbdError) -> bool {
    match error {
        RgbdError::NoDepth { .. } | RgbdError::Uncalibrated { .. } => true,
        RgbdError::Image(error) => matches!(
            error,
            ImageError::UnclearLayer { .. } | ImageError::MissingChannel { .. } | ImageError::NoSuchLayer { .. }
        ),
        _ => false,
    }
}

/// What was uploaded, and the exposure that its light asks for, EV.
type Opened = (GpuSource, Option<f32>);

/// The exposure that a source's light asks for, EV, seen by its first camera; none of what can be
/// looked at as it is.
fn metered_ev(spec: &str, source: &GpuSource) -> Option<f32> {
    let size = source.source().default_size(0);
    let mut view = is_metered(spec, source.source()).then(|| source.view(0, size, 0, None).ok())??;
    view_exposure_ev(source.gpu(), &mut view, &Lens::PINHOLE).ok()?
}

/// Opens one thing at a time on a thread of its own: parsing, decoding and uploading.
#[derive(Default)]
pub struct Loader {
    pending: Option<Pending>,
}

impl Loader {
    /// Starts to open `spec`; whatever was being opened is forgotten.
    pub fn start(&mut self, spec: &str, depth: &DepthArgs, fresh: bool, gpu: &Gpu, ctx: &egui::Context) {
        let (sender, receiver) = channel();
        // With its whole path a file is found again from wherever the state is opened.
        let file = Path::new(spec);
        let whole = if file.is_file() { std::path::absolute(file).ok() } else { None };
        let spec = whole.map_or_else(|| spec.to_owned(), |path| path.to_string_lossy().into_owned());
        let (name, args, gpu, ctx) = (spec.clone(), depth.clone(), gpu.clone(), ctx.clone());
        std::thread::spawn(move || {
            let opened = Source::open(&name, &args).map(|source| {
                let uploaded = source.upload(&gpu, SurfaceOptions::default());
                let metered_ev = metered_ev(&name, &uploaded);
                (uploaded, metered_ev)
            });
            // Nobody listens any more where something else was opened meanwhile.
            let _ = sender.send(opened);
            ctx.request_repaint();
        });
        self.pending = Some(Pending { spec, depth: depth.clone(), fresh, receiver });
    }

    /// What is being opened.
    pub fn loading(&self) -> Option<&str> {
        self.pending.as_ref().map(|pending| pending.spec.as_str())
    }

    /// Goes on with what is there.
    pub fn cancel(&mut self) {
        self.pending = None;
    }

    /// What was opened, or why not, once.
    pub fn poll(&mut self) -> Option<Loaded> {
        let result = match self.pending.as_ref()?.receiver.try_recv() {
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => Err(None),
            Ok(opened) => opened.map_err(Some),
        };
        let Pending { spec, depth, fresh, .. } = self.pending.take()?;
        let is_incomplete = matches!(&result, Err(Some(SourceError::Image(error))) if is_incomplete(error));
        let stopped = "loading stopped unexpectedly: the program's log says more; try another file";
        let result = result.map_err(|e| e.map_or_else(|| stopped.to_owned(), |e| e.to_string()));
        let metered_ev = result.as_ref().ok().and_then(|(_, ev)| *ev);
        let result = result.map(|(source, _)| source);
        Some(Loaded { spec, depth, fresh, is_incomplete, metered_ev, result })
    }
}
