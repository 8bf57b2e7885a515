//! Opens the window: what it starts with, on which device, and what is kept until the next time.

use super::engine::{Engine, Tempo};
use super::model::{self, Document, Preferences, Theme};
use super::screenshot::{Outcome, Screenshot};
use super::ui::style::apply as apply_style;
use super::undoing::undoer;
use super::{App, dialogs, messages, shaders};
use anyhow::{Context as _, anyhow};
use defocus::gpu::{self, Gpu};
use eframe::egui::{self, Ui, vec2};
use eframe::egui_wgpu::{RenderState, WgpuSetup, WgpuSetupCreateNew};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// How the window starts.
#[derive(Clone, Debug, Default)]
pub struct AppOptions {
    /// What to open; the built-in scene `cans` without it.
    pub scene: Option<String>,
    /// Part of the name of the adapter to use; the best one without it.
    pub adapter: Option<String>,
    /// Saves the whole window as a PNG once the picture is there, and ends.
    pub screenshot: Option<PathBuf>,
    /// What to show at first; what was shown last, or [`Document::default`], without it.
    pub document: Option<Document>,
    /// The person's choices; the last ones without it.
    pub preferences: Option<Preferences>,
    /// The folder in which files are saved at first; the current one without it.
    pub folder: Option<PathBuf>,
    /// The folder whose shaders are read again on save; that of the program's source
    /// without it.
    pub shaders: Option<PathBuf>,
    /// How pictures and interface share time.
    pub tempo: Tempo,
}

/// Keys under which the window's storage holds what is kept.
const KEPT_DOCUMENT: &str = "document";
const KEPT_PREFERENCES: &str = "preferences";

/// Opens the window and returns when it is closed.
///
/// # Errors
///
/// No display, no adapter, or a screenshot that cannot be taken.
pub fn run(options: AppOptions) -> anyhow::Result<()> {
    let outcome = Outcome::default();
    let taken = outcome.clone();
    let photographing = options.screenshot.is_some();
    let native = native_options(options.adapter.clone());
    let create: eframe::AppCreator<'_> = Box::new(move |context| {
        apply_style(&context.egui_ctx);
        let state = context.wgpu_render_state.as_ref().ok_or("the window has no wgpu renderer")?;
        let options = options.with_kept(context.storage);
        Ok(Box::new(App::with_outcome(state, options, taken)))
    });
    eframe::run_native("defocus", native, create)
        .map_err(|e| anyhow!("{e}"))
        .context("the window cannot be opened; on a machine without a display use `defocus render`")?;
    match outcome.lock().map_err(|_| anyhow!("the window's thread stopped unexpectedly"))?.take() {
        Some(result) => result.map_err(|e| anyhow!(e)),
        None if photographing => Err(anyhow!("the window was closed before the screenshot was taken")),
        None => Ok(()),
    }
}

fn native_options(adapter: Option<String>) -> eframe::NativeOptions {
    let mut options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("defocus")
            .with_app_id("defocus")
            .with_inner_size(vec2(1280.0, 800.0))
            .with_min_inner_size(vec2(640.0, 400.0))
            .with_drag_and_drop(true),
        ..Default::default()
    };
    options.wgpu_options.wgpu_setup = wgpu_setup(adapter);
    options
}

/// How to open the device that window and library share: with what the library wants, on
/// the best adapter or the one whose name contains `adapter`.
pub fn wgpu_setup(adapter: Option<String>) -> WgpuSetup {
    let choose = move |adapters: &[wgpu::Adapter], surface: Option<&wgpu::Surface<'_>>| {
        let usable = |a: &&wgpu::Adapter| surface.is_none_or(|s| a.is_surface_supported(s));
        let usable: Vec<_> = adapters.iter().filter(usable).cloned().collect();
        gpu::best_adapter(usable, adapter.as_deref()).map_err(|e| e.to_string())
    };
    let mut setup = WgpuSetupCreateNew::without_display_handle();
    gpu::without_indirect_checks(&mut setup.instance_descriptor);
    WgpuSetup::CreateNew(WgpuSetupCreateNew {
        native_adapter_selector: Some(Arc::new(choose)),
        device_descriptor: Arc::new(|adapter| wgpu::DeviceDescriptor {
            label: Some("defocus"),
            required_features: adapter.features() & gpu::wanted_features(),
            required_limits: gpu::wanted_limits(&adapter.limits()),
            ..Default::default()
        }),
        ..setup
    })
}

impl AppOptions {
    /// The same with what the last session kept, where nothing else is asked for. A
    /// photograph shows what it is told to and nothing that was kept.
    fn with_kept(mut self, storage: Option<&dyn eframe::Storage>) -> Self {
        let Some(storage) = storage.filter(|_| self.screenshot.is_none()) else { return self };
        self.preferences = self.preferences.or_else(|| eframe::get_value(storage, KEPT_PREFERENCES));
        if self.scene.is_none() {
            self.document = self.document.or_else(|| eframe::get_value(storage, KEPT_DOCUMENT));
        }
        self
    }
}

impl App {
    /// The content for a window that draws with `render_state`, whose device was opened
    /// as [`wgpu_setup`] does.
    pub fn new(render_state: &RenderState, options: AppOptions) -> Self {
        Self::with_outcome(render_state, options, Outcome::default())
    }

    fn with_outcome(render_state: &RenderState, options: AppOptions, outcome: Outcome) -> Self {
        let RenderState { adapter, device, queue, .. } = render_state.clone();
        let mut messages = messages::Messages::default();
        let mut document = options.document.unwrap_or_default().repaired();
        match options.scene {
            Some(file) if model::state::is_state(&file) => match model::state::read(file.as_ref()) {
                Ok(read) => document = read,
                Err(error) => messages.error_later(error.to_string()),
            },
            Some(scene) => document.scene = scene,
            None => {}
        }
        let mut engine = Engine::new(Gpu::from_device(&adapter.get_info(), device, queue));
        engine.set_tempo(options.tempo);
        Self {
            document,
            preferences: options.preferences.unwrap_or_default(),
            engine,
            render_state: render_state.clone(),
            textures: BTreeMap::new(),
            retired: Vec::new(),
            viewport: Default::default(),
            eyes: Default::default(),
            focus_motion: Default::default(),
            animating: Default::default(),
            lens_panel: Default::default(),
            inspector: Default::default(),
            kernels: Default::default(),
            undoer: undoer(),
            loader: Default::default(),
            loaded: None,
            watched: Default::default(),
            reload: shaders::Reload::of(options.shaders),
            dialogs: dialogs::Dialogs::in_folder(
                options.folder.or_else(|| std::env::current_dir().ok()).unwrap_or_default(),
            ),
            palette: Default::default(),
            tasks: Vec::new(),
            wanted_truths: Vec::new(),
            messages,
            screenshot: options.screenshot.map(|path| Screenshot::new(path, outcome)),
            applied_theme: Theme::System,
            help: false,
            lessons: Default::default(),
            paper: Default::default(),
            batch: Default::default(),
            scale_offer: Default::default(),
            metered_ev: None,
            started: false,
        }
    }
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut Ui, _: &mut eframe::Frame) {
        self.show(ui);
    }

    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        visuals.panel_fill.to_normalized_gamma_f32()
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        if self.screenshot.is_none() {
            eframe::set_value(storage, KEPT_DOCUMENT, &self.document);
            eframe::set_value(storage, KEPT_PREFERENCES, &self.preferences);
        }
    }

    fn persist_egui_memory(&self) -> bool {
        self.screenshot.is_none()
    }
}
