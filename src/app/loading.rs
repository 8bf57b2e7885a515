//! Opening scenes and asking for files without holding up the window.

use crate::gpu::Gpu;
use crate::study::{DepthArgs, GpuSource, Source};
use crate::view::SurfaceOptions;
use eframe::egui;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// Opens one thing at a time on a thread of its own: parsing, decoding and uploading.
#[derive(Default)]
pub struct Loader {
    pending: Option<(String, Receiver<Result<GpuSource, String>>)>,
}

impl Loader {
    /// Starts to open `spec`; whatever was being opened is forgotten.
    pub fn start(&mut self, spec: &str, gpu: &Gpu, ctx: &egui::Context) {
        let (sender, receiver) = channel();
        let (name, gpu, ctx) = (spec.to_owned(), gpu.clone(), ctx.clone());
        std::thread::spawn(move || {
            let opened = Source::open(&name, &DepthArgs::default())
                .map(|source| source.upload(&gpu, SurfaceOptions::default()))
                .map_err(|e| e.to_string());
            // Nobody listens any more where something else was opened meanwhile.
            let _ = sender.send(opened);
            ctx.request_repaint();
        });
        self.pending = Some((spec.into(), receiver));
    }

    /// What is being opened.
    pub fn loading(&self) -> Option<&str> {
        self.pending.as_ref().map(|(spec, _)| spec.as_str())
    }

    /// What was opened, or why not, once.
    pub fn poll(&mut self) -> Option<(String, Result<GpuSource, String>)> {
        let (_, receiver) = self.pending.as_ref()?;
        let opened = match receiver.try_recv() {
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => {
                Err("loading stopped unexpectedly: the program's log says more; try another file".to_owned())
            }
            Ok(opened) => opened,
        };
        let (spec, _) = self.pending.take()?;
        Some((spec, opened))
    }
}

/// The system's dialog for opening a file.
#[derive(Default)]
pub struct OpenDialog {
    answer: Option<Receiver<Option<PathBuf>>>,
}

impl OpenDialog {
    /// Shows the dialog unless it is shown already.
    pub fn show(&mut self, ctx: &egui::Context) {
        if self.answer.is_some() {
            return;
        }
        let (sender, receiver) = channel();
        // Made here: some systems want dialogs to come from the main thread.
        let dialog = rfd::AsyncFileDialog::new()
            .set_title("Open a scene or an image with depth")
            .add_filter("Scenes and images with depth", &["glb", "gltf", "exr", "png", "jpg", "jpeg", "hdr"])
            .pick_file();
        let ctx = ctx.clone();
        std::thread::spawn(move || {
            let file = pollster::block_on(dialog);
            let _ = sender.send(file.map(|file| file.path().to_owned()));
            ctx.request_repaint();
        });
        self.answer = Some(receiver);
    }

    /// The chosen file, once.
    pub fn poll(&mut self) -> Option<PathBuf> {
        match self.answer.as_ref()?.try_recv() {
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => {
                self.answer = None;
                None
            }
            Ok(file) => {
                self.answer = None;
                file
            }
        }
    }
}
