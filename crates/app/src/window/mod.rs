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
//! **Where a new thing goes.** A panel is a function over plain values in `ui/panels`; a group of
//! the panel beside the picture, in `ui/groups`, is told what is shown and what the engine knows
//! ([`Engine::depths_m`], [`Engine::depth_at_m`], [`Engine::color`] for a pane's values on the CPU)
//! and returns [`Action`]s; `controls.rs` gathers the one and does the other. A new choice that
//! changes the picture is a field of [`Document`] and an [`Edit`] that sets it; it is saved and
//! undone without further ado, and reaches the engine through [`Request`]. A new way of looking
//! at a pane is a variant of [`Show`], presented in `engine/pane.rs` and explained in `legend.rs`.
//! A new thing to do is an [`Action`]: in `commands.rs` it gets its name in the palette and its
//! keys. All of them are done in `actions.rs`. What focusing does with the mouse is in
//! `viewport.rs`, and where the pointer is in the picture, [`App::cursor`].

mod action;
mod actions;
mod animating;
mod bars;
mod batch;
mod browsing;
mod classroom;
mod commands;
mod compared;
mod controls;
mod dialogs;
mod engine;
mod enlarged;
mod eyes;
mod files;
mod focusing;
mod frame;
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
mod start;
mod suiting;
mod tasks;
mod textures;
mod ui;
mod undoing;
mod viewport;
mod viewport_state;
mod watch;

pub use action::{Action, Command};
pub use dialogs::{Answer, Purpose};
pub use engine::{
    DISPLAY_INTERVAL_MS, DisplaySettings, Engine, Figures, History, Identity, Kernel, KernelOf, Measured,
    MeasuredKernel, Pairing, Pane, PaneMetrics, Quantiles, Reading, RenderRequest, Request, Tempo, Wake,
};
pub use model::state::{StateError, command_line, command_text, left_out, read as read_state, write as write_state};
pub use model::{
    Arrangement, BatchRow, Channel, Difference, DifferenceKind, DistanceUnit, Document, Edit, EyeSettings, FocusMode,
    FocusSettings, Inside, KernelChoice, LESSONS, Lesson, MAX_PANES, MethodChoice, Moment, Navigation, Numbers, PaneId,
    PaneState, PaneTree, PictureKind, PictureSize, Preference, Preferences, REFERENCE_SAMPLES, Show, Theme,
    ViewSettings, Zoom,
};
pub use start::{AppOptions, run, wgpu_setup};
pub use ui::panels;
pub use ui::style::apply as apply_style;

use defocus::gpu::Texture;
use defocus_study::DepthArgs;
use eframe::egui::util::undoer::Undoer;
use eframe::egui::{self, TextureId};
use eframe::egui_wgpu::RenderState;
use std::collections::BTreeMap;

/// The window's content.
pub struct App {
    document: Document,
    preferences: Preferences,
    engine: Engine,
    render_state: RenderState,
    textures: BTreeMap<PaneId, textures::Registered>,
    /// Ids that this frame still paints with.
    retired: Vec<TextureId>,
    viewport: viewport_state::Viewport,
    eyes: eyes::Eyes,
    focus_motion: focusing::FocusMotion,
    animating: animating::Animating,
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
    screenshot: Option<screenshot::Screenshot>,
    applied_theme: Theme,
    help: bool,
    lessons: classroom::Lessons,
    paper: paper::PaperForm,
    batch: batch::Batch,
    scale_offer: scene_scale::ScaleOffer,
    /// Exposure that the source's light asks for, EV, where it asks for one.
    metered_ev: Option<f32>,
    started: bool,
}

impl App {
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
}
