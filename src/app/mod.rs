//! The window over the library: a scene large in the middle, the lens beside it.
//!
//! ```text
//! Settings --request--> Engine --textures--> viewport
//!    ^                                          |
//!    +--- controls, bars, mouse and keys -------+
//! ```
//!
//! All of the user's choices are one [`Settings`]; everything else is computed from them
//! and can be thrown away. No pipelines here: [`crate::methods`] and [`crate::present`]
//! have them.

mod bars;
mod controls;
mod engine;
mod help;
mod loading;
mod messages;
mod navigation;
mod paint;
pub mod panels;
mod screenshot;
mod settings;
mod style;
mod timing;
mod viewport;
mod widgets;

pub use engine::{Engine, Pane, Request};
pub use settings::{MethodChoice, Navigation, Settings, Show, Theme};
pub use style::apply as apply_style;
pub use timing::{History, Quantiles};

use crate::gpu::{self, Gpu, Texture};
use crate::methods;
use crate::study::GpuSource;
use crate::study::source::DEFAULT_SIZE;
use anyhow::{Context as _, anyhow};
use eframe::egui::{self, CentralPanel, TextureId, ThemePreference, Ui, vec2};
use eframe::egui_wgpu::{RenderState, WgpuSetup, WgpuSetupCreateNew};
use screenshot::{Outcome, Screenshot};
use std::path::PathBuf;
use std::sync::Arc;
use viewport::Viewport;

/// How the window starts.
#[derive(Clone, Debug, Default)]
pub struct AppOptions {
    /// What to open; the built-in scene `cans` without it.
    pub scene: Option<String>,
    /// Part of the name of the adapter to use; the best one without it.
    pub adapter: Option<String>,
    /// Saves the whole window as a PNG once the picture is there, and ends.
    pub screenshot: Option<PathBuf>,
    /// Choices to start with; those of [`Settings::default`] without it.
    pub settings: Option<Settings>,
}

/// A texture that egui knows by an id.
struct Registered {
    id: TextureId,
    texture: Texture,
}

/// The window's content.
pub struct App {
    settings: Settings,
    engine: Engine,
    render_state: RenderState,
    textures: Vec<Option<Registered>>,
    viewport: Viewport,
    loader: loading::Loader,
    dialog: loading::OpenDialog,
    messages: messages::Messages,
    screenshot: Option<Screenshot>,
    applied_theme: Theme,
    help: bool,
    started: bool,
}

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
    WgpuSetup::CreateNew(WgpuSetupCreateNew {
        native_adapter_selector: Some(Arc::new(choose)),
        device_descriptor: Arc::new(|adapter| wgpu::DeviceDescriptor {
            label: Some("defocus"),
            required_features: adapter.features() & gpu::wanted_features(),
            required_limits: gpu::wanted_limits(&adapter.limits()),
            ..Default::default()
        }),
        ..WgpuSetupCreateNew::without_display_handle()
    })
}

impl App {
    /// The content for a window that draws with `render_state`, whose device was opened
    /// as [`wgpu_setup`] does.
    pub fn new(render_state: &RenderState, options: AppOptions) -> Self {
        Self::with_outcome(render_state, options, Outcome::default())
    }

    fn with_outcome(render_state: &RenderState, options: AppOptions, outcome: Outcome) -> Self {
        let RenderState { adapter, device, queue, .. } = render_state.clone();
        let mut settings = options.settings.unwrap_or_default().repaired();
        if let Some(scene) = options.scene {
            settings.scene = scene;
        }
        Self {
            settings,
            engine: Engine::new(Gpu::from_device(&adapter.get_info(), device, queue)),
            render_state: render_state.clone(),
            textures: Vec::new(),
            viewport: Viewport::default(),
            loader: Default::default(),
            dialog: Default::default(),
            messages: Default::default(),
            screenshot: options.screenshot.map(|path| Screenshot::new(path, outcome)),
            applied_theme: Theme::System,
            help: false,
            started: false,
        }
    }

    /// The user's choices as they are now.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// What renders.
    pub fn engine(&self) -> &Engine {
        &self.engine
    }

    /// Where the picture is, points.
    pub fn picture_rect(&self) -> egui::Rect {
        self.viewport.picture()
    }

    /// The last error that was shown.
    pub fn last_error(&self) -> Option<&str> {
        self.messages.last_error()
    }

    /// Why the picture is not up to date, such as a lens that forms no image.
    pub fn problem(&self) -> Option<&str> {
        self.viewport.problem()
    }

    /// [`Engine::depth_at_m`] of the picture.
    pub fn depth_at_m(&mut self, at: glam::DVec2) -> Option<f64> {
        self.engine.depth_at_m(at)
    }

    /// Whether everything is shown as it will stay until something is changed.
    pub fn is_settled(&self) -> bool {
        self.started
            && self.loader.loading().is_none()
            && !self.engine.is_busy()
            && self.viewport.is_at_rest()
            && self.engine.source().is_some()
    }

    /// One frame of the interface.
    pub fn show(&mut self, ui: &mut Ui) {
        self.take_in(ui.ctx());
        self.keys(ui);
        self.top_bar(ui);
        self.status_bar(ui);
        self.controls(ui);
        CentralPanel::no_frame().show(ui, |ui| self.show_viewport(ui));
        help::show(ui.ctx(), &mut self.help);
        self.messages.show(ui.ctx());
        self.finish_frame(ui.ctx());
    }

    /// What arrived since the last frame: files, answers, a new theme.
    fn take_in(&mut self, ctx: &egui::Context) {
        if !self.started {
            self.started = true;
            let scene = self.settings.scene.clone();
            self.open(ctx, &scene);
        }
        let dropped = ctx.input(|i| i.raw.dropped_files.first().map(|f| f.path().to_owned()));
        if let Some(file) = dropped.or_else(|| self.dialog.poll()) {
            self.open(ctx, &file.to_string_lossy());
        }
        if let Some((spec, opened)) = self.loader.poll() {
            match opened {
                Ok(source) => self.opened(spec, source),
                Err(error) => self.messages.error(ctx, &error),
            }
        }
        if self.settings.theme != self.applied_theme {
            self.applied_theme = self.settings.theme;
            ctx.set_theme(match self.settings.theme {
                Theme::System => ThemePreference::System,
                Theme::Light => ThemePreference::Light,
                Theme::Dark => ThemePreference::Dark,
            });
        }
    }

    fn open(&mut self, ctx: &egui::Context, spec: &str) {
        self.loader.start(spec, self.engine.gpu(), ctx);
    }

    fn opened(&mut self, spec: String, source: GpuSource) {
        self.engine.set_source(source);
        let restored = self.settings.scene == spec && self.settings.camera.is_some();
        self.settings.scene = spec;
        if !restored {
            self.choose_camera(0);
            self.refocus();
        }
    }

    fn choose_camera(&mut self, index: usize) {
        let Some(source) = self.engine.source() else { return };
        self.settings.camera_index = index;
        self.settings.camera = match source.source() {
            crate::study::Source::Scene(scene) => scene.cameras.get(index).map(|c| c.camera),
            crate::study::Source::Image(_) => None,
        };
    }

    /// Focus, and the rest of the lens where it is automatic, as the source asks for it.
    fn refocus(&mut self) {
        let size = Some(self.viewport.area_px()).filter(|s| s.min_element() > 0).unwrap_or(DEFAULT_SIZE);
        let Ok(lens) = self.engine.default_lens(self.settings.camera, size) else { return };
        self.viewport.stop_focusing();
        self.settings.pivot_m = lens.focus_distance_m;
        self.settings.lens.focus_distance_m = lens.focus_distance_m;
        if self.settings.automatic_lens {
            let aperture = self.settings.lens.aperture.clone();
            self.settings.lens = crate::lens::Lens { aperture, ..lens };
        }
    }

    fn suit_lens(&mut self) {
        self.settings.automatic_lens = true;
        self.refocus();
    }

    fn keys(&mut self, ui: &Ui) {
        if ui.ctx().egui_wants_keyboard_input() {
            return;
        }
        let pressed = |key| ui.input(|i| i.modifiers.is_none() && i.key_pressed(key));
        if pressed(egui::Key::Escape) {
            self.messages.dismiss();
        }
        if pressed(egui::Key::R) {
            self.choose_camera(self.settings.camera_index);
        }
        if pressed(egui::Key::C) {
            let coc = self.settings.show == Show::Coc;
            self.settings.show = if coc { Show::Picture } else { Show::Coc };
        }
        if pressed(egui::Key::B) {
            self.set_comparing(self.settings.methods.len() == 1);
        }
        if pressed(egui::Key::X) {
            self.settings.methods.reverse();
        }
        // Where "?" is typed with shift, the key itself is reported with it.
        if ui.input(|i| i.events.iter().any(|e| matches!(e, egui::Event::Text(text) if text == "?"))) {
            self.help = !self.help;
        }
    }

    /// Title of a pane's method.
    fn title(&self, pane: usize) -> String {
        let id = self.settings.methods.get(pane).map_or("", |m| m.id.as_str());
        methods::by_id(id).map_or_else(|_| id.to_owned(), |m| m.about().title.to_owned())
    }

    /// Tells egui about the textures that the engine made.
    fn register_textures(&mut self) {
        let panes = self.engine.panes();
        self.textures.resize_with(panes.len().max(self.textures.len()), || None);
        let (device, filter) = (&self.render_state.device, wgpu::FilterMode::Linear);
        for (pane, slot) in panes.iter().zip(&mut self.textures) {
            let Some(shown) = &pane.shown else { continue };
            let mut renderer = self.render_state.renderer.write();
            match slot {
                Some(registered) if registered.texture.same(shown) => {}
                Some(registered) => {
                    renderer.update_egui_texture_from_wgpu_texture(device, shown.view(), filter, registered.id);
                    registered.texture = shown.clone();
                }
                None => {
                    let id = renderer.register_native_texture(device, shown.view(), filter);
                    *slot = Some(Registered { id, texture: shown.clone() });
                }
            }
        }
    }

    /// Asks for another frame only where there is something to do in it.
    fn finish_frame(&mut self, ctx: &egui::Context) {
        if self.engine.is_busy() {
            // Soon enough to keep a GPU busy with a converging reference.
            ctx.request_repaint_after(std::time::Duration::from_millis(4));
        }
        let ready = self.is_settled();
        let failure = self.messages.last_error().or(self.viewport.problem());
        if let Some(screenshot) = &mut self.screenshot {
            screenshot.advance(ctx, ready, failure);
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

    fn persist_egui_memory(&self) -> bool {
        self.screenshot.is_none()
    }
}
