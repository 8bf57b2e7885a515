//! Opening scenes without holding up the window.

use defocus::gpu::Gpu;
use defocus::scene::rgbd::RgbdError;
use defocus::view::SurfaceOptions;
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
    /// Whether it is an image that only lacks its depth.
    pub lacks_depth: bool,
    /// The source, or a sentence.
    pub result: Result<GpuSource, String>,
}

struct Pending {
    spec: String,
    depth: DepthArgs,
    fresh: bool,
    receiver: Receiver<Result<GpuSource, SourceError>>,
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
            let opened = Source::open(&name, &args).map(|source| source.upload(&gpu, SurfaceOptions::default()));
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
        let lacks_depth = matches!(&result, Err(Some(SourceError::Image(RgbdError::NoDepth { .. }))));
        let stopped = "loading stopped unexpectedly: the program's log says more; try another file";
        let result = result.map_err(|e| e.map_or_else(|| stopped.to_owned(), |e| e.to_string()));
        Some(Loaded { spec, depth, fresh, lacks_depth, result })
    }
}
