//! Where an image's depth comes from and what its numbers mean, as it is asked for.

use crate::window::ui::panels::Field;
use crate::window::ui::widgets::{self, choice};
use defocus::image_io::{exr_layer_names, read_scalars};
use defocus::scene::rgbd::{DepthEncoding, DepthKind};
use defocus_study::DepthArgs;
use eframe::egui::{self, RichText, Ui};
use std::path::{Path, PathBuf};

/// Images that bring no depth of their own.
const WITHOUT_DEPTH: [&str; 7] = ["png", "webp", "bmp", "tif", "tiff", "hdr", "pfm"];

/// Name of the choice that leaves a layer to the file's own names.
const BY_NAME: &str = "by its name";

/// Ends of a depth that has none of its own until they are set, metres.
const USUAL_ENDS_M: (f64, f64) = (0.5, 20.0);

/// Lines of the kind with most numbers, that of the kind included.
const MOST_LINES: f32 = 4.0;

/// Numbers of a file that are looked at for a guess.
const GUESSED_SAMPLES: usize = 1 << 20;

/// What kind of image a file is by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageKind {
    /// One that brings no depth of its own.
    Plain,
    /// One that may bring some, as phones write it.
    Jpeg,
    /// One of layers.
    Exr,
    /// None.
    Other,
}

impl ImageKind {
    /// That of a file.
    pub fn of(file: &str) -> Self {
        let extension = Path::new(file).extension().map(|e| e.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            Some("exr") => Self::Exr,
            Some("jpg" | "jpeg") => Self::Jpeg,
            Some(extension) if WITHOUT_DEPTH.contains(&extension) => Self::Plain,
            _ => Self::Other,
        }
    }
}

/// The fields about depth.
#[derive(Default)]
pub struct DepthForm {
    /// The depth's file as it is typed; empty for depth in the image's own.
    pub file: String,
    encoding: Option<DepthEncoding>,
    /// What the numbers were taken for, in words, and of which file.
    guess: Option<(String, String)>,
    layer: Option<String>,
    depth_layer: Option<String>,
    /// Layers of the EXR of that name.
    layers: Option<(String, Vec<String>)>,
}

impl DepthForm {
    /// What is asked for.
    pub fn args(&self) -> DepthArgs {
        let file = Some(self.file.trim()).filter(|file| !file.is_empty()).map(PathBuf::from);
        let (layer, depth_layer) = (self.layer.clone(), self.depth_layer.clone());
        DepthArgs { file, encoding: self.encoding(), layer, depth_layer, ..DepthArgs::default() }
    }

    fn encoding(&self) -> DepthEncoding {
        self.encoding.unwrap_or(DepthEncoding::METRES)
    }

    /// Why it cannot be used, in words.
    pub fn problem(&self) -> Option<String> {
        self.encoding().check().err().map(|e| e.to_string())
    }

    /// The rows of an EXR's layers.
    pub fn layer_rows(&mut self, ui: &mut Ui, image: &str) {
        let layers = self.layers_of(image);
        let row = |ui: &mut Ui, name: &str, help: &str, chosen: &mut Option<String>| {
            let mut names = vec![BY_NAME];
            names.extend(layers.iter().map(String::as_str));
            let mut index = layers.iter().position(|layer| Some(layer) == chosen.as_ref()).map_or(0, |i| i + 1);
            choice(ui, name, help, &mut index, &names);
            *chosen = index.checked_sub(1).and_then(|i| layers.get(i).cloned());
        };
        let help =
            "The layer that is the picture: Combined, beauty, rgba or one without a name, unless another is chosen.";
        row(ui, "Picture layer", help, &mut self.layer);
        let help = "The layer that is depth: Z, depth, Depth.Z or the like, unless another is chosen.";
        row(ui, "Depth layer", help, &mut self.depth_layer);
    }

    /// Layers of an EXR, read when another file is named; none of what cannot be read.
    fn layers_of(&mut self, image: &str) -> Vec<String> {
        let known = self.layers.take().filter(|(of, _)| of == image);
        let (_, layers) = self
            .layers
            .insert(known.unwrap_or_else(|| (image.to_owned(), exr_layer_names(Path::new(image)).unwrap_or_default())));
        layers.clone()
    }

    /// Looks at a depth file that is named for the first time, and takes its numbers for what files
    /// like it hold; what was set by hand stays.
    pub fn consider(&mut self) {
        let file = self.file.trim();
        let is_known = self.guess.as_ref().is_some_and(|(of, _)| of == file);
        if is_known || self.encoding.is_some() || !Path::new(file).is_file() {
            return;
        }
        let guessed = guess(Path::new(file));
        self.guess = Some((file.to_owned(), guessed.as_ref().map_or_else(String::new, |(_, why)| why.clone())));
        self.encoding = guessed.map(|(encoding, _)| encoding);
    }

    /// What the numbers mean.
    pub fn encoding_rows(&mut self, ui: &mut Ui) {
        let mut encoding = self.encoding();
        // As high whatever the kind is: what stands below does not move when one is guessed.
        let top = ui.cursor().top();
        kind_rows(ui, &mut encoding.kind);
        let line = ui.spacing().interact_size.y + ui.spacing().item_spacing.y;
        ui.add_space((MOST_LINES * line - (ui.cursor().top() - top)).max(0.0));
        let help = "The number, as it stands in the file, that means “not measured”, such as 0.";
        unmeasured_row(ui, "Unknown is", help, &mut encoding.unknown);
        let help = "The number, as it stands in the file, that means “infinitely far”.";
        unmeasured_row(ui, "Infinity is", help, &mut encoding.infinity);
        if encoding != self.encoding() {
            self.encoding = Some(encoding);
        }
        let why = self.guess.as_ref().map(|(_, why)| why.as_str()).filter(|why| !why.is_empty());
        ui.label(RichText::new(why.unwrap_or(" ")).small().weak());
    }
}

/// What a depth file's numbers are most likely to mean, and why.
fn guess(file: &Path) -> Option<(DepthEncoding, String)> {
    let scalars = read_scalars(file, None).ok()?;
    let stride = scalars.values.pixels.len().div_ceil(GUESSED_SAMPLES).max(1);
    let numbers = scalars.values.pixels.iter().step_by(stride).copied().filter(|v| v.is_finite());
    let greatest = numbers.clone().fold(0.0_f32, f32::max);
    let (near_m, far_m) = USUAL_ENDS_M;
    let unknown = numbers.clone().any(|v| v == 0.0).then_some(0.0);
    let encoding = |kind| DepthEncoding { kind, ..DepthEncoding::METRES };
    Some(match scalars.full_scale {
        65535.0 if greatest > 0.0 => (
            DepthEncoding { unknown, ..encoding(DepthKind::Metres { per_unit: 0.001 }) },
            format!("16-bit numbers up to {greatest}: taken for millimetres, as depth cameras write them."),
        ),
        255.0 => (
            encoding(DepthKind::Relative { near_m, far_m }),
            "8-bit numbers: taken for relative inverse depth, as depth networks draw it. Set its ends.".into(),
        ),
        _ if scalars.is_float() && greatest <= 1.0 => (
            encoding(DepthKind::Relative { near_m, far_m }),
            "Numbers up to 1: taken for relative inverse depth, as depth networks write it. Set its ends.".into(),
        ),
        _ => (encoding(DepthKind::Metres { per_unit: 1.0 }), format!("Numbers up to {greatest}: taken for metres.")),
    })
}

fn kind_rows(ui: &mut Ui, kind: &mut DepthKind) {
    let mut chosen = match kind {
        DepthKind::Metres { .. } => 0,
        DepthKind::Inverse { .. } => 1,
        DepthKind::Device { .. } => 2,
        DepthKind::Distance { .. } => 3,
        DepthKind::Relative { .. } => 4,
        DepthKind::Dioptres { .. } => 5,
        DepthKind::Disparity { .. } => 6,
    };
    let help = "Metres along the optical axis; inverse depth, greater is nearer; a depth buffer, 0 is near; \
                metres along each ray; inverse depth of a network, whose ends are asked for; inverse metres; \
                or pixels between two cameras.";
    let kinds = ["metres", "inverse", "device", "distance", "relative", "dioptres", "disparity"];
    if choice(ui, "Numbers are", help, &mut chosen, &kinds) {
        let (near_m, far_m) = USUAL_ENDS_M;
        *kind = match chosen {
            0 => DepthKind::Metres { per_unit: 1.0 },
            1 => DepthKind::Inverse { near_m, far_m },
            2 => DepthKind::Device { near_m, far_m },
            3 => DepthKind::Distance { per_unit: 1.0 },
            4 => DepthKind::Relative { near_m, far_m },
            5 => DepthKind::Dioptres { per_unit: 1.0 },
            _ => DepthKind::Disparity { focal_px: 1000.0, baseline_m: 0.1, offset_px: 0.0, per_unit: 1.0 },
        };
    }
    let row = |name, help, unit, log| Field { name, help, unit, range: log..=1000.0, log: Some(log), reset: None };
    match kind {
        DepthKind::Metres { per_unit } | DepthKind::Distance { per_unit } => {
            row("Metres a unit", "0.001 for millimetres.", " m", 1e-4).show(ui, per_unit);
        }
        DepthKind::Dioptres { per_unit } => {
            row("Dioptres a unit", "1 for inverse metres.", " /m", 1e-4).show(ui, per_unit);
        }
        DepthKind::Disparity { focal_px, baseline_m, per_unit, .. } => {
            row("Pixels a unit", "1/256 for KITTI.", " px", 1e-4).show(ui, per_unit);
            row("Focal length", "In pixels of the disparity map.", " px", 1e-2).show(ui, focal_px);
            row("Baseline", "Distance of the two cameras.", " m", 1e-4).show(ui, baseline_m);
        }
        DepthKind::Inverse { near_m, far_m }
        | DepthKind::Device { near_m, far_m }
        | DepthKind::Relative { near_m, far_m } => {
            row("Nearest", "Depth of the nearest number.", " m", 0.01).show(ui, near_m);
            row("Farthest", "Depth of the farthest number; may be infinite.", " m", 0.01).show(ui, far_m);
        }
    }
}

/// A switch with the number that it stands for.
fn unmeasured_row(ui: &mut Ui, name: &str, help: &str, value: &mut Option<f32>) {
    widgets::row(ui, name, help, |ui| {
        let mut is_on = value.is_some();
        let switch = ui.checkbox(&mut is_on, "");
        let mut number = value.unwrap_or(0.0);
        let drag = ui.add_enabled(is_on, egui::DragValue::new(&mut number).speed(0.1));
        drag.accessible_name(format!("{name}, as a number"));
        *value = is_on.then_some(number);
        switch
    });
}
