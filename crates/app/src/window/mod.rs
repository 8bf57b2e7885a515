//! The window over the library: panes of one scene, each with a method, the lens beside.
//!
//! ```text
//! Document --Request--> Engine --textures--> panes
//!    ^                                         |
//!    +-- controls, heads, actions, mouse ------+
//! ```
//!
//! All that is shown is one [`Document`]: plain data, saved, restored and undone as a
//! whole. What belongs to the person is in [`Preferences`]. Everything else is computed
//! from the two and can be thrown away. No pipelines here: [`defocus::methods`] and
//! [`defocus::present`] have them.
//!
//! **Where a new thing goes.** A panel is a file with `pub fn show(ui: &mut Ui, ...)` over
//! the plain state that it changes (a part of [`Document`]) and the readings that it
//! shows, called from a group in `controls.rs`: the engine has the readings
//! ([`Engine::depths_m`], [`Engine::depth_at_m`], [`Engine::color`] for a pane's values on
//! the CPU, [`Engine::view`]), `viewport.rs` has where the pointer is in the picture
//! ([`App::cursor`]). A new choice that changes the picture is a field of [`Document`]; it
//! is saved and undone without further ado, and reaches the engine through [`Request`]. A
//! new way of looking at a pane is a variant of [`Show`], presented in `engine/pane.rs`
//! and explained in `legend.rs`. A new thing to do is an [`Action`]: it is then in the
//! palette, may have keys, and is on the sheet of keys. What focusing does with the mouse
//! is in `viewport.rs`.

mod action;
mod actions;
mod bars;
mod batch;
mod browsing;
mod classroom;
mod commands;
mod compared;
mod controls;
mod details;
mod dialogs;
mod engine;
mod enlarged;
mod eyes;
mod files;
mod focusing;
mod help;
mod inspecting;
mod kernels;
mod legend;
mod loading;
mod messages;
mod model;
mod navigation;
mod numbers;
mod paint;
mod palette;
mod panes;
mod paper;
mod report;
mod saving;
mod scene_scale;
mod screenshot;
mod shaders;
mod tasks;
mod ui;
mod viewport;
mod viewport_state;
mod watch;

pub use action::{Action, Command};
pub use dialogs::{Answer, Numbers, Purpose};
pub use engine::{
    DISPLAY_INTERVAL_MS, Development, Engine, Exposure, Figures, History, Identity, Kernel, KernelOf, Measured,
    MeasuredKernel, Pairing, Pane, Quantiles, Reading, Request, Tempo, Verdict, Wake,
};
pub use model::state::{StateError, command_line, command_text, left_out, read as read_state, write as write_state};
pub use model::{
    Arrangement, BatchRow, Channel, Difference, DifferenceKind, DistanceUnit, Document, FocusMode, FocusSettings,
    Inside, KernelChoice, LESSONS, Lesson, MAX_PANES, MethodChoice, Navigation, PaneId, PaneState, PaneTree,
    PictureKind, PictureSize, Preferences, REFERENCE_SAMPLES, Show, Theme, Zoom,
};
pub use ui::panels;
pub use ui::style::apply as apply_style;

use anyhow::{Context as _, anyhow};
use defocus::gpu::{self, Gpu, Texture};
use defocus_study::DepthArgs;
use defocus_study::source::DEFAULT_SIZE;
use eframe::egui::util::undoer::{self, Undoer};
use eframe::egui::{self, CentralPanel, TextureId, ThemePreference, Ui, vec2};
use eframe::egui_wgpu::{RenderState, WgpuSetup, WgpuSetupCreateNew};
use screenshot::{Outcome, Screenshot};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use viewport_state::Viewport;

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

/// How long a change must rest before it can be taken back by itself, seconds: less than
/// the pause between two deliberate changes.
const UNDO_REST_S: f32 = 0.5;

/// A texture that egui knows by an id.
struct Registered {
    id: TextureId,
    texture: Texture,
    filter: wgpu::FilterMode,
}

/// The window's content.
pub struct App {
    document: Document,
    preferences: Preferences,
    engine: Engine,
    render_state: RenderState,
    textures: BTreeMap<PaneId, Registered>,
    /// Ids that this frame still paints with.
    retired: Vec<TextureId>,
    viewport: Viewport,
    eyes: eyes::Eyes,
    focus_motion: focusing::FocusMotion,
    lens_panel: panels::LensPanel,
    inspector: inspecting::Inspector,
    kernels: kernels::Kernels,
    undoer: Undoer<Document>,
    loader: loading::Loader,
    /// What the engine's source was opened from.
    loaded: Option<(String, DepthArgs)>,
    watched: watch::Watched,
    reload: shaders::Reload,
    dialogs: dialogs::Dialogs,
    palette: palette::Palette,
    tasks: Vec<tasks::Task>,
    wanted_truths: Vec<saving::WantedTruth>,
    messages: messages::Messages,
    screenshot: Option<Screenshot>,
    applied_theme: Theme,
    help: bool,
    lessons: classroom::Lessons,
    paper: paper::PaperForm,
    batch: batch::Batch,
    scale_offer: scene_scale::ScaleOffer,
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
        let settings = undoer::Settings { stable_time: UNDO_REST_S, ..Default::default() };
        let mut engine = Engine::new(Gpu::from_device(&adapter.get_info(), device, queue));
        engine.set_tempo(options.tempo);
        Self {
            document,
            preferences: options.preferences.unwrap_or_default(),
            engine,
            render_state: render_state.clone(),
            textures: BTreeMap::new(),
            retired: Vec::new(),
            viewport: Viewport::default(),
            eyes: Default::default(),
            focus_motion: Default::default(),
            lens_panel: Default::default(),
            inspector: Default::default(),
            kernels: Default::default(),
            undoer: Undoer::with_settings(settings),
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
            started: false,
        }
    }

    /// What is shown.
    pub fn document(&self) -> &Document {
        &self.document
    }

    /// The person's choices.
    pub fn preferences(&self) -> &Preferences {
        &self.preferences
    }

    /// What renders.
    pub fn engine(&self) -> &Engine {
        &self.engine
    }

    /// Where the whole picture of a pane is, points; it may reach beyond the pane.
    pub fn picture_rect(&self, pane: PaneId) -> Option<egui::Rect> {
        self.viewport.picture(pane)
    }

    /// Where the pointer is in the picture, from (0, 0) at the top left to (1, 1).
    pub fn cursor(&self) -> Option<glam::DVec2> {
        self.viewport.cursor()
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

    /// The view that is drawn, the left eye's where there are two.
    pub fn view(&mut self) -> Option<&mut defocus::view::View> {
        self.engine.view()
    }

    /// |c| at the ends of the CoC's colour map, px.
    pub fn coc_scale_px(&self) -> f32 {
        self.viewport.coc_scale_px
    }

    /// Size of what a pane shows, px.
    pub fn shown_size(&self, pane: PaneId) -> Option<glam::UVec2> {
        self.shown(pane).map(Texture::size)
    }

    /// Whether everything is shown as it will stay until something is changed.
    pub fn is_settled(&self) -> bool {
        self.started
            && self.loader.loading().is_none()
            && self.shows_what_is_named()
            && self.tasks.is_empty()
            && self.engine.wants_update_in().is_none()
            && self.eyes.wants_update_in().is_none()
            && !self.focus_motion.is_moving()
            && self.viewport.is_at_rest()
            && self.engine.source().is_some()
    }

    /// One frame of the interface.
    pub fn show(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        self.take_in(&ctx);
        self.keys(&ctx);
        if !self.preferences.panels_hidden {
            self.top_bar(ui);
            self.status_bar(ui);
        }
        self.show_scale_offer(ui);
        self.class_bars(ui);
        if !self.preferences.panels_hidden {
            self.controls(ui);
        }
        CentralPanel::no_frame().show(ui, |ui| self.show_panes(ui));
        self.update_pictures(ui);
        self.hand_out_truths();
        self.show_feet(ui);
        self.show_help(&ctx);
        self.show_palette(&ctx);
        self.show_paper_form(&ctx);
        self.show_batch(&ctx);
        if let Some(answer) = self.dialogs.show(&ctx) {
            self.answer(&ctx, answer);
        }
        self.show_tasks(&ctx);
        self.messages.show(&ctx);
        self.feed_undo(&ctx);
        self.finish_frame(&ctx);
    }

    /// What arrived since the last frame: files, answers, complaints, a new theme.
    fn take_in(&mut self, ctx: &egui::Context) {
        if !self.started {
            ctx.set_zoom_factor(self.preferences.ui_scale.clamp(0.5, 4.0));
            let ctx = ctx.clone();
            self.engine.set_wake(Wake::with(move || ctx.request_repaint()));
        } else {
            // Ctrl and +, − or 0 change it too.
            self.preferences.ui_scale = ctx.zoom_factor();
        }
        self.started = true;
        let dropped = ctx.input(|i| i.raw.dropped_files.first().map(|f| f.path().to_owned()));
        if let Some(file) = dropped {
            self.open_anything(ctx, &file.to_string_lossy());
        }
        if !self.watched.take().is_empty()
            && let Some((spec, depth)) = self.loaded.clone()
        {
            self.loader.start(&spec, &depth, false, self.engine.gpu(), ctx);
        }
        self.take_in_loaded(ctx);
        self.load_what_is_named(ctx);
        self.prepare_lesson();
        self.reload_shaders(ctx);
        for trouble in self.engine.take_troubles() {
            self.messages.error(ctx, &trouble);
        }
        if self.preferences.theme != self.applied_theme {
            self.applied_theme = self.preferences.theme;
            ctx.set_theme(match self.preferences.theme {
                Theme::System => ThemePreference::System,
                Theme::Light => ThemePreference::Light,
                Theme::Dark => ThemePreference::Dark,
            });
        }
    }

    fn choose_camera(&mut self, index: usize) {
        let Some(source) = self.engine.source() else { return };
        self.document.camera_index = index;
        self.document.camera = match source.source() {
            defocus_study::Source::Scene(scene) => scene.cameras.get(index).map(|c| c.camera),
            defocus_study::Source::Image(_) => None,
        };
    }

    /// Focus, and the rest of the lens where it is automatic, as the source asks for it.
    fn refocus(&mut self) {
        let Some(lens) = self.suitable_lens() else { return };
        self.focus_motion.stop();
        self.document.pivot_m = lens.focus_distance_m;
        self.document.lens.focus_distance_m = lens.focus_distance_m;
        if self.document.automatic_lens {
            let aperture = self.document.lens.aperture.clone();
            self.document.lens = defocus::lens::Lens { aperture, ..lens };
        }
    }

    /// A lens that suits what is shown.
    fn suitable_lens(&mut self) -> Option<defocus::lens::Lens> {
        let size = Some(self.eye_size_px()).filter(|s| s.min_element() > 0).unwrap_or(DEFAULT_SIZE);
        self.engine.default_lens(self.document.camera, size).ok()
    }

    /// Gives the picture another size. A lens that follows the scene follows it in this too:
    /// its display spans the camera's field of view also then.
    pub(super) fn resize_picture(&mut self, size: PictureSize) {
        self.document.size = size.repaired();
        if let (true, Some(lens)) = (self.document.automatic_lens, self.suitable_lens()) {
            let defocus::lens::Lens { aperture, focus_distance_m, .. } = self.document.lens.clone();
            self.document.lens = defocus::lens::Lens { aperture, focus_distance_m, ..lens };
        }
    }

    fn suit_lens(&mut self) {
        self.document.automatic_lens = true;
        self.refocus();
    }

    /// Notes what can be taken back.
    fn feed_undo(&mut self, ctx: &egui::Context) {
        if self.loader.loading().is_some() || self.engine.source().is_none() {
            return;
        }
        self.undoer.feed_state(ctx.input(|i| i.time), &self.document.without_gaze());
        if self.undoer.is_in_flux() {
            ctx.request_repaint_after(Duration::from_secs_f32(UNDO_REST_S));
        }
    }

    fn undo(&mut self) {
        if let Some(earlier) = self.undoer.undo(&self.document.without_gaze()).cloned() {
            self.restore(earlier);
        }
    }

    fn redo(&mut self) {
        if let Some(later) = self.undoer.redo(&self.document.without_gaze()).cloned() {
            self.restore(later);
        }
    }

    fn restore(&mut self, document: Document) {
        let Document { zoom, divider, .. } = self.document;
        let focus_m = self.document.lens.focus_distance_m;
        self.document = Document { zoom, divider, ..document };
        if self.document.focus.mode.follows() {
            self.document.lens.focus_distance_m = focus_m;
        }
        self.focus_motion.stop();
    }

    fn show_tasks(&mut self, ctx: &egui::Context) {
        let (mut row, messages) = (0, &mut self.messages);
        self.tasks.retain_mut(|task| {
            row += 1;
            match task.show(ctx, row - 1) {
                None => return true,
                Some(tasks::Ended::Well(text)) => messages.note(ctx, &text),
                Some(tasks::Ended::Badly(error)) => messages.error(ctx, &error),
                Some(tasks::Ended::Stopped) => messages.note(ctx, "Cancelled; nothing was written."),
            }
            false
        });
    }

    /// Brings the pictures up to date with what was changed in this frame. They are
    /// painted after it, so that they follow the mouse without delay.
    fn update_pictures(&mut self, ui: &Ui) {
        if self.shows_what_is_named() {
            self.update_engine(ui);
        } else {
            // For the lens that suits what is being opened.
            self.viewport.measure(ui.ctx().pixels_per_point());
        }
        self.register_textures(ui.ctx());
    }

    /// Whether the engine has what the document names.
    fn shows_what_is_named(&self) -> bool {
        let wanted = (&self.document.scene, &self.document.depth);
        self.loaded.as_ref().is_some_and(|(scene, depth)| (scene, depth) == wanted)
    }

    /// Tells egui about the textures that the engine made.
    fn register_textures(&mut self, ctx: &egui::Context) {
        let device = &self.render_state.device;
        let gone: Vec<PaneId> = self.textures.keys().copied().filter(|id| self.engine.pane(*id).is_none()).collect();
        let mut renderer = self.render_state.renderer.write();
        self.retired.drain(..).for_each(|id| renderer.free_texture(&id));
        for id in gone {
            if let Some(registered) = self.textures.remove(&id) {
                renderer.free_texture(&registered.id);
            }
        }
        for pane in &self.document.panes {
            let Some(shown) = self.shown(pane.id).cloned() else { continue };
            // What is drawn smaller for the sake of speed is smooth.
            let filter = match self.engine.pane(pane.id).is_some_and(|pane| pane.divisor() > 1) {
                true => wgpu::FilterMode::Linear,
                false => self.viewport.filter(),
            };
            match self.textures.get_mut(&pane.id) {
                Some(known) if known.texture.same(&shown) && known.filter == filter => {}
                Some(known) if known.texture.size() == shown.size() => {
                    renderer.update_egui_texture_from_wgpu_texture(device, shown.view(), filter, known.id);
                    (known.texture, known.filter) = (shown, filter);
                }
                // One of another shape is placed otherwise, which this frame did not know.
                _ => {
                    let id = renderer.register_native_texture(device, shown.view(), filter);
                    let old = self.textures.insert(pane.id, Registered { id, texture: shown, filter });
                    self.retired.extend(old.map(|registered| registered.id));
                    // It has an id to be painted by from the next frame on.
                    ctx.request_repaint();
                }
            }
        }
    }

    /// Asks for another frame only where there is something to do in it.
    fn finish_frame(&mut self, ctx: &egui::Context) {
        let pauses = [self.engine.wants_update_in(), self.eyes.wants_update_in()];
        if let Some(pause) = pauses.into_iter().flatten().min() {
            ctx.request_repaint_after(pause);
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
