//! Asking for a file: a field for its name, which works on every machine, with the
//! system's own dialog behind a button.

mod depth;
mod preview;

use crate::window::browsing::{Browsed, Browsing, NO_DIALOG, WAITING};
use crate::window::enlarged::{ENLARGEMENTS, PRINT_PX_PER_CM};
use crate::window::model::PictureKind;
use crate::window::model::state;
use crate::window::model::{Document, Numbers, PaneId};
use crate::window::ui::widgets::{self, choice};
use defocus_study::DepthArgs;
use depth::{DepthForm, ImageKind};
use eframe::egui::{self, Context, Id, Key, Modal, RichText, TextEdit, Ui};
use glam::UVec2;
use preview::Preview;
use std::path::{Path, PathBuf};

/// Height of the dialog around what it asks about an image, points.
const AROUND_IMAGE_ROWS: f32 = 190.0;

/// What a file is asked for.
#[derive(Clone, Debug, PartialEq)]
pub enum Purpose {
    /// To be opened.
    Open,
    /// For the state.
    State,
    /// For a pane's picture.
    Picture(PaneId, PictureKind),
    /// For the comparison of all panes.
    Report,
    /// To be the lens's aperture.
    Aperture,
    /// For numbers.
    Numbers(Numbers),
}

impl Purpose {
    fn title(&self) -> &'static str {
        match self {
            Self::Open => "Open a scene, an image with depth, or a saved state",
            Self::State => "Save the state",
            Self::Picture(..) => "Save the picture",
            Self::Report => "Save the comparison as one HTML file",
            Self::Aperture => "An image whose brightness is the aperture's",
            Self::Numbers(numbers) => numbers.about().0,
        }
    }

    fn extensions(&self) -> &'static [&'static str] {
        match self {
            Self::Open => {
                &["glb", "gltf", "exr", "png", "jpg", "jpeg", "webp", "bmp", "tif", "tiff", "hdr", "pfm", "ron"]
            }
            Self::State => &[state::EXTENSION],
            Self::Picture(_, PictureKind::Png) => &["png"],
            Self::Picture(_, PictureKind::Exr) => &["exr"],
            Self::Report => &["html"],
            Self::Aperture => &["png", "jpg", "jpeg", "hdr"],
            Self::Numbers(Numbers::FiguresJson) => &["json"],
            Self::Numbers(_) => &["csv"],
        }
    }

    /// Whether the file is there already, to be read.
    fn reads(&self) -> bool {
        matches!(self, Self::Open | Self::Aperture)
    }
}

/// A file that was named.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// What for.
    pub purpose: Purpose,
    /// The file.
    pub file: PathBuf,
    /// Of an image to be opened: where its depth comes from.
    pub depth: DepthArgs,
    /// Of a picture to be saved: times as many pixels in each direction as it has in the window.
    pub times: u32,
}

#[derive(Clone, Copy, PartialEq)]
enum Asked {
    File,
    Depth,
}

struct Asking {
    purpose: Purpose,
    file: String,
    depth: DepthForm,
    preview: Preview,
    /// What was wrong with it when it was opened before.
    problem: Option<String>,
    /// Size of the picture that is to be saved, px, where it can be drawn larger.
    size: Option<UVec2>,
    /// Place among what is offered.
    enlargement: usize,
    browsing: Option<(Asked, Browsing)>,
    /// Whether the system's dialog was asked for and did not come.
    no_dialog: bool,
    fresh: bool,
}

/// The dialog, if one is open.
pub struct Dialogs {
    asking: Option<Asking>,
    folder: PathBuf,
}

impl Dialogs {
    /// Dialogs that begin in `folder`.
    pub fn in_folder(folder: PathBuf) -> Self {
        Self { asking: None, folder }
    }

    /// The folder in which files are saved at first.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Whether a file is being asked for.
    pub fn is_open(&self) -> bool {
        self.asking.is_some()
    }

    /// Asks for something to open.
    pub fn open(&mut self, ctx: &Context) {
        self.ask(ctx, Purpose::Open, String::new());
    }

    /// Asks where to keep the state.
    pub fn save_state(&mut self, ctx: &Context, document: &Document) {
        self.ask(ctx, Purpose::State, format!("{}.{}", document.name(), state::EXTENSION));
    }

    /// Asks where to save a pane's picture, and of `size` px how much larger.
    pub fn save_picture(
        &mut self,
        ctx: &Context,
        document: &Document,
        (id, kind): (PaneId, PictureKind),
        size: Option<UVec2>,
    ) {
        let method = document.pane(id).map_or("picture", |p| p.method.id.as_str());
        let name = format!("{}-{method}.{}", document.name(), kind.extension());
        self.ask(ctx, Purpose::Picture(id, kind), name);
        if let Some(asking) = &mut self.asking {
            asking.size = size;
        }
    }

    /// Asks where to save the comparison.
    pub fn save_report(&mut self, ctx: &Context, document: &Document) {
        self.ask(ctx, Purpose::Report, format!("{}.html", document.name()));
    }

    /// Asks where to save numbers.
    pub fn save_numbers(&mut self, ctx: &Context, document: &Document, numbers: Numbers) {
        let (_, what, extension) = numbers.about();
        self.ask(ctx, Purpose::Numbers(numbers), format!("{}-{what}.{extension}", document.name()));
    }

    /// Asks for an image to be the aperture.
    pub fn open_aperture(&mut self, ctx: &Context) {
        self.ask(ctx, Purpose::Aperture, String::new());
    }

    /// Asks for what an image lacks to be opened: its depth, or which of its layers are meant.
    pub fn complete(&mut self, ctx: &Context, image: &Path, problem: Option<String>) {
        self.ask(ctx, Purpose::Open, image.to_string_lossy().into_owned());
        if let Some(asking) = &mut self.asking {
            asking.problem = problem;
        }
    }

    fn ask(&mut self, ctx: &Context, purpose: Purpose, name: String) {
        let file = if name.is_empty() { name } else { self.folder.join(name).to_string_lossy().into_owned() };
        self.asking = Some(Asking {
            purpose,
            file,
            depth: DepthForm::default(),
            preview: Preview::default(),
            problem: None,
            size: None,
            enlargement: 0,
            browsing: None,
            no_dialog: false,
            fresh: true,
        });
        ctx.request_repaint();
    }

    /// Shows the dialog; the answer once it is given.
    pub fn show(&mut self, ctx: &Context) -> Option<Answer> {
        let asking = self.asking.as_mut()?;
        asking.take_browsed(ctx.input(|i| i.focused));
        let mut done = None;
        let modal = Modal::new(Id::unique("file dialog")).show(ctx, |ui| {
            ui.set_width(520.0);
            ui.label(RichText::new(asking.purpose.title()).strong());
            ui.add_space(6.0);
            done = asking.ui(ui);
        });
        let answered = match done {
            Some(true) => Some(asking.answer()),
            Some(false) => None,
            None if modal.should_close() => None,
            None => return None,
        };
        self.asking = None;
        if let Some(folder) = answered.as_ref().and_then(|a| a.file.parent()) {
            self.folder = folder.to_owned();
        }
        answered
    }
}

impl Asking {
    /// The fields; `Some(true)` when confirmed, `Some(false)` when given up.
    fn ui(&mut self, ui: &mut Ui) -> Option<bool> {
        let entered = self.file_row(ui, Asked::File);
        let missing = self.missing();
        // Where the window is low, this scrolls and the buttons stay in sight.
        let room = (ui.ctx().content_rect().height() - AROUND_IMAGE_ROWS).max(60.0);
        let rows = egui::ScrollArea::vertical().max_height(room).auto_shrink([false, true]);
        rows.show(ui, |ui| self.image_rows(ui));
        if let Some(size) = self.size {
            enlargement_row(ui, size, &mut self.enlargement);
        }
        if self.no_dialog {
            ui.label(RichText::new(NO_DIALOG).small().color(ui.visuals().warn_fg_color));
        } else if self.browsing.is_some() {
            ui.label(RichText::new(WAITING).small().weak());
        }
        let note = missing.clone().unwrap_or_else(|| self.note());
        ui.label(RichText::new(note).small().weak());
        ui.add_space(6.0);
        let mut done = None;
        ui.horizontal(|ui| {
            let name = if self.purpose.reads() { "Open" } else { "Save" };
            if ui.add_enabled(missing.is_none(), egui::Button::new(name)).clicked() {
                done = Some(true);
            }
            if ui.button("Cancel").clicked() {
                done = Some(false);
            }
        });
        if entered && missing.is_none() { Some(true) } else { done }
    }

    /// What is asked about an image: layers, depth, and what its numbers mean.
    fn image_rows(&mut self, ui: &mut Ui) {
        let kind = self.image_kind();
        if kind == ImageKind::Other {
            return;
        }
        if kind == ImageKind::Exr {
            self.depth.layer_rows(ui, self.file.trim());
        }
        self.file_row(ui, Asked::Depth);
        self.depth.consider();
        self.depth.encoding_rows(ui);
        if let Some(problem) = &self.problem {
            ui.label(RichText::new(problem).small().color(ui.visuals().warn_fg_color));
        }
        let is_named = kind != ImageKind::Plain || !self.depth.file.trim().is_empty();
        let is_known = is_named && Path::new(self.file.trim()).is_file() && self.depth.problem().is_none();
        let args = self.depth.args();
        self.preview.show(ui, is_known.then(|| (self.file.trim(), &args)));
    }

    /// What kind of image is to be opened.
    fn image_kind(&self) -> ImageKind {
        if self.purpose == Purpose::Open { ImageKind::of(self.file.trim()) } else { ImageKind::Other }
    }

    fn file_row(&mut self, ui: &mut Ui, field: Asked) -> bool {
        let (name, text) = match field {
            Asked::File => ("File", &mut self.file),
            Asked::Depth => ("Depth file", &mut self.depth.file),
        };
        let fresh = field == Asked::File && std::mem::take(&mut self.fresh);
        let mut browse = false;
        let edit = widgets::row(ui, name, "", |ui| {
            let width = ui.available_width() - 90.0;
            let edit = ui.add(TextEdit::singleline(text).desired_width(width));
            browse = ui.button("Browse…").clicked();
            edit
        });
        if fresh {
            edit.request_focus();
        }
        if browse {
            self.browse(ui.ctx(), field);
        }
        edit.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter))
    }

    /// What is still missing, in words.
    fn missing(&self) -> Option<String> {
        if self.file.trim().is_empty() {
            return Some("Type the name of a file, or browse for one.".into());
        }
        match self.image_kind() {
            ImageKind::Other => None,
            ImageKind::Plain if self.depth.file.trim().is_empty() => {
                Some("This image has no depth of its own: name a file that has.".into())
            }
            _ => self.depth.problem(),
        }
    }

    fn note(&self) -> String {
        if self.purpose.reads() {
            return "Press Enter to open it.".into();
        }
        if Path::new(&self.file).exists() { "The file is there already: it will be replaced." } else { "A new file." }
            .into()
    }

    fn answer(&self) -> Answer {
        let mut file = PathBuf::from(self.file.trim());
        if !self.purpose.reads() && file.extension().is_none() {
            file.set_extension(self.purpose.extensions()[0]);
        }
        let depth = match self.image_kind() {
            ImageKind::Other => DepthArgs::default(),
            _ => self.depth.args(),
        };
        let times = ENLARGEMENTS.get(self.enlargement).copied().unwrap_or(1);
        Answer { purpose: self.purpose.clone(), file, depth, times }
    }

    /// Shows the system's dialog; its answer arrives later.
    fn browse(&mut self, ctx: &Context, field: Asked) {
        if self.browsing.is_some() {
            return;
        }
        let (extensions, title) = match field {
            Asked::File => (self.purpose.extensions(), self.purpose.title()),
            Asked::Depth => (&["png", "exr", "pfm", "npy", "tif", "tiff"][..], "Depth of the image"),
        };
        let saving = field == Asked::File && !self.purpose.reads();
        self.browsing = Some((field, Browsing::start(ctx, title, extensions, saving)));
        self.no_dialog = false;
    }

    fn take_browsed(&mut self, has_focus: bool) {
        let Some((field, browsing)) = &mut self.browsing else { return };
        let Some(browsed) = browsing.poll(has_focus) else { return };
        self.no_dialog = browsed == Browsed::NeverThere;
        if let Browsed::File(file) = browsed {
            let text = file.to_string_lossy().into_owned();
            match field {
                Asked::File => self.file = text,
                Asked::Depth => self.depth.file = text,
            }
        }
        self.browsing = None;
    }
}

/// How much larger a picture is drawn than it is in the window.
fn enlargement_row(ui: &mut Ui, size: UVec2, chosen: &mut usize) {
    let name = |times: &u32| {
        let UVec2 { x, y } = size * *times;
        let what = if *times == 1 { "As shown".to_owned() } else { format!("{times} times") };
        format!("{what}: {x} x {y} px, {:.1} cm wide in print", f64::from(x) / PRINT_PX_PER_CM)
    };
    let names: Vec<String> = ENLARGEMENTS.iter().map(name).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let help =
        "Drawn anew with so many pixels, beside the interface; the blur grows with them. Print has 300 pixels an inch.";
    choice(ui, "Pixels", help, chosen, &names);
}
