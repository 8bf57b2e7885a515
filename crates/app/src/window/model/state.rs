//! The state as a file that reopens exactly, and as a command line.

use super::document::Document;
use super::method::MethodChoice;
use super::pane::PaneState;
use super::show::Show;
use defocus::eye::{Pupil, amplitude_d};
use defocus::image_io::write_atomically;
use defocus::methods;
use defocus::scene::rgbd::DepthKind;
use defocus::viewing::Screen;
use defocus_study::DepthArgs;
use glam::UVec2;
use std::borrow::Cow;
use std::io::Write;
use std::path::{Path, PathBuf};

/// What a state's file name ends with.
pub const EXTENSION: &str = "ron";

/// Format of the files; a later program reads earlier ones.
const FORMAT: u32 = 1;

/// A file's content.
#[derive(serde::Serialize, serde::Deserialize)]
struct Saved {
    defocus_state: u32,
    document: Document,
}

/// Why a state cannot be read or kept.
#[derive(Debug, thiserror::Error)]
pub enum StateError {
    /// The file cannot be opened or read.
    #[error("{}: cannot read it: {source}; check that the file exists and may be read", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// It is not a state.
    #[error("{}: is not a saved state ({cause}); choose one that this program saved", file.display())]
    Damaged {
        /// The file.
        file: PathBuf,
        /// Where and why.
        cause: String,
    },
    /// A later program's.
    #[error("{}: was saved by a later version of this program (format {format}); update defocus", file.display())]
    TooNew {
        /// The file.
        file: PathBuf,
        /// Its format.
        format: u32,
    },
    /// It cannot be written.
    #[error("{}: cannot write it: {cause}; check that its folder exists and may be written", file.display())]
    Unwritable {
        /// The file.
        file: PathBuf,
        /// The reason.
        cause: String,
    },
}

/// Whether this names a state rather than a scene.
pub fn is_state(spec: &str) -> bool {
    Path::new(spec).extension().is_some_and(|e| e.eq_ignore_ascii_case(EXTENSION))
}

/// Reads a state.
///
/// # Errors
///
/// The file, the cause and the remedy.
pub fn read(file: &Path) -> Result<Document, StateError> {
    let text = std::fs::read_to_string(file).map_err(|source| StateError::Unreadable { file: file.into(), source })?;
    let saved: Saved =
        ron::from_str(&text).map_err(|e| StateError::Damaged { file: file.into(), cause: e.to_string() })?;
    if saved.defocus_state > FORMAT {
        return Err(StateError::TooNew { file: file.into(), format: saved.defocus_state });
    }
    Ok(saved.document.repaired())
}

/// A state as text, which [`read`] reads from a file.
///
/// # Errors
///
/// None in practice: a document is plain data.
pub fn text(document: &Document) -> Result<String, ron::Error> {
    let saved = Saved { defocus_state: FORMAT, document: document.clone() };
    ron::ser::to_string_pretty(&saved, Default::default())
}

/// Keeps a state.
///
/// # Errors
///
/// The file, the cause and the remedy.
pub fn write(file: &Path, document: &Document) -> Result<(), StateError> {
    let failed = |cause: String| StateError::Unwritable { file: file.into(), cause };
    let text = text(document).map_err(|e| failed(e.to_string()))?;
    write_atomically(file, |out| writeln!(out, "{text}")).map_err(|e| failed(e.to_string()))
}

/// The command that makes what `document` shows, its picture `size` px large for one eye:
/// `defocus render` for one method alone, `defocus compare` for several, or for one beside
/// the reference.
pub fn command_line(document: &Document, size: UVec2) -> String {
    let methods: Vec<&PaneState> = distinct(document);
    let compares = compares(document, &methods);
    let mut words: Vec<String> = vec!["defocus".into()];
    words.push(if compares { "compare" } else { "render" }.into());
    words.push(document.scene.clone());
    depth_words(&document.depth, &mut words);
    let lens = &document.lens;
    let pupil = pupil(document);
    if let Some(Pupil { both_eyes: false, .. }) = pupil {
        words.push("--one-eye".into());
    }
    let mut option = |name: &str, value: String| words.extend([name.to_owned(), value]);
    match pupil {
        None => option("-E", lens.aperture_diameter_mm.to_string()),
        Some(pupil) => {
            option("--pupil-luminance", pupil.luminance_cd_m2.to_string());
            option("--pupil-field", pupil.field_deg.to_string());
        }
    }
    option("-F", lens.focal_length_mm.to_string());
    option("--dr", lens.image_distance_mm.to_string());
    option("--ds", lens.screen_distance_mm.to_string());
    option("--dpi", lens.density_px_per_mm.to_string());
    option("--focus", lens.focus_distance_m.to_string());
    option("--aperture", lens.aperture.to_string());
    eye_words(document, &mut option);
    // An image with depth, which has no camera, is seen with one eye; so is a comparison.
    let two = document.stereo.filter(|_| document.camera.is_some() && !compares);
    // The command line's size is that of the picture, which may hold both eyes'.
    let whole = two.map_or(size, |stereo| stereo.layout.whole_size(size));
    option("--size", format!("{}x{}", whole.x, whole.y));
    if let Some(camera) = &document.camera {
        let (p, q) = (camera.position, camera.orientation);
        option("--pose", format!("{},{},{},{},{},{},{}", p.x, p.y, p.z, q.x, q.y, q.z, q.w));
        option("--overscan", document.overscan_px.to_string());
        if camera.aspect.is_none() {
            // Where it was fitted to the display it is not the scene's own any more.
            option("--fov", camera.fov_y.to_degrees().to_string());
        }
        if let Some(moment) = &document.moment {
            option("--animation", moment.animation.clone());
            option("--time", moment.time_s.to_string());
        }
        if document.camera_index > 0 {
            option("--camera", document.camera_index.to_string());
        }
    }
    if let Some(stereo) = two {
        option("--stereo", stereo.layout.id().into());
        option("--ipd-mm", stereo.ipd_mm.to_string());
        option("--stereo-window", stereo.window_m.to_string());
    }
    let ids: Vec<&str> = methods.iter().map(|p| p.method.id.as_str()).collect();
    option(if compares { "--methods" } else { "--method" }, ids.join(","));
    for pane in &methods {
        for (key, value) in &pane.method.params {
            option("--set", format!("{}.{key}={value}", pane.method.id));
        }
    }
    if let (true, Some(truth)) = (compares, document.truth()) {
        option("--samples", truth.count("samples").unwrap_or(default_samples()).to_string());
        if truth.is_on(BY_VIEW) {
            // It turns every method's on that has it: those whose is off say so.
            let is_off = |pane: &&&PaneState| !pane.method.is_on(BY_VIEW) && has_param(&pane.method, BY_VIEW);
            for pane in methods.iter().filter(is_off).filter(|pane| !pane.method.params.contains_key(BY_VIEW)) {
                option("--set", format!("{}.{BY_VIEW}=off", pane.method.id));
            }
            words.push("--view-dependent".into());
        }
    }
    let mut option = |name: &str, value: String| words.extend([name.to_owned(), value]);
    if document.display.exposure_ev != 0.0 || !document.automatic_exposure {
        option("--exposure", document.display.exposure_ev.to_string());
    }
    if document.display.tone_map != Default::default() {
        option("--tonemap", document.display.tone_map.to_string());
    }
    viewing_words(document, &mut option);
    if document.screen.hdr {
        words.push("--hdr".into());
    }
    if let Some([r, g, b]) = lens.eye.chromatic {
        // One word: the wavelengths may be left out.
        words.push(format!("--chromatic={r},{g},{b}"));
    }
    let mut option = |name: &str, value: String| words.extend([name.to_owned(), value]);
    option("-o", if compares { "out".into() } else { "out.png".into() });
    words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ")
}

/// A word of a command, quoted where a shell would read it otherwise. `shlex` alone would quote lists and
/// settings too, which no shell changes within a word.
fn quoted(word: &str) -> Cow<'_, str> {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./,:=+@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.into();
    }
    // No word has a zero byte: they are numbers, names and paths of files that were opened.
    shlex::Quoter::new().allow_nul(true).quote(word).unwrap_or_default()
}

/// Light and age that E follows, where it does.
fn pupil(document: &Document) -> Option<Pupil> {
    document.pupil.filter(|pupil| pupil.diameter_mm() == document.lens.aperture_diameter_mm)
}

/// What the eye adds, where it adds anything.
fn eye_words(document: &Document, option: &mut dyn FnMut(&str, String)) {
    let eye = &document.lens.eye;
    let refraction = eye.refraction;
    let numbers =
        [("--sphere", refraction.sphere_d), ("--cylinder", refraction.cylinder_d), ("--axis", refraction.axis_deg)];
    for (name, value) in numbers.into_iter().filter(|(_, value)| *value != 0.0) {
        option(name, value.to_string());
    }
    let limits = |age: &f64| eye.accommodation_d == Some(amplitude_d(*age));
    let age = pupil(document).map(|pupil| pupil.age_years).or(document.age_years.filter(limits));
    if let Some(age) = age {
        option("--age", age.to_string());
    }
    // An age limits the accommodation, unless that is said itself.
    if eye.accommodation_d != age.map(amplitude_d) {
        option("--accommodation", eye.accommodation_d.map_or_else(|| "any".into(), |d| d.to_string()));
    }
}

/// Under what angle and in what light pictures are judged, where that is not the default.
fn viewing_words(document: &Document, option: &mut dyn FnMut(&str, String)) {
    if let Some(ppd) = document.ppd {
        option("--ppd", ppd.to_string());
    }
    let (screen, usual) = (&document.screen, Screen::default());
    if *screen != usual {
        option("--peak-luminance", screen.peak_cd_m2.to_string());
        option("--black-luminance", screen.black_cd_m2.to_string());
        option("--ambient", screen.ambient_lux.to_string());
    }
}

/// [`command_line`] with a line of comment that says what it leaves out, if it does.
pub fn command_text(document: &Document, size: UVec2) -> String {
    let line = command_line(document, size);
    match left_out(document).join(", ") {
        missing if missing.is_empty() => line,
        missing => format!("{line}\n# left out: {missing}"),
    }
}

/// The parameter that has shading look from each point of the lens.
const BY_VIEW: &str = "view_dependent";

fn has_param(choice: &MethodChoice, key: &str) -> bool {
    methods::by_id(&choice.id).is_ok_and(|mut method| method.params().iter().any(|param| param.key == key))
}

/// Lens points of the reference as it is by default.
fn default_samples() -> u32 {
    methods::Accumulation::default().samples
}

/// Whether the command is that of a comparison.
fn compares(document: &Document, methods: &[&PaneState]) -> bool {
    let is_scene = document.camera.is_some();
    let is_measured = document.truth().is_some() && methods.iter().all(|pane| Some(pane.id) != document.reference());
    methods.len() > 1 || (is_scene && is_measured)
}

/// What [`command_line`] has no words for, in words.
pub fn left_out(document: &Document) -> Vec<&'static str> {
    let methods = distinct(document);
    let reference = |p: &&PaneState| p.method.id == "accumulation" && document.panes.len() > 1;
    let shown = document.panes.iter().filter(|p| !reference(p)).count();
    let references = document.panes.iter().filter(|p| p.method.id == "accumulation").count();
    let whole = [
        (document.stereo.is_some() && document.camera.is_some() && compares(document, &methods), "the right eye"),
        (document.panes.iter().any(|p| p.show != Show::Picture), "overlays and differences"),
        (document.channel != Default::default(), "the choice of a channel"),
        (document.panes.iter().any(|p| p.method.as_built), "which build of the shaders"),
        (methods.len() < shown, "further panes of one method"),
        (references > 1 && document.panes.len() > 1, "further references"),
        (references > 0 && document.camera.is_none() && methods.len() < document.panes.len(), "the reference"),
    ];
    whole.into_iter().filter(|(is_left_out, _)| *is_left_out).map(|(_, what)| what).collect()
}

/// The panes, of several with one method the first; the reference comes by itself.
fn distinct(document: &Document) -> Vec<&PaneState> {
    let mut found: Vec<&PaneState> = Vec::new();
    for pane in &document.panes {
        let is_reference = pane.method.id == "accumulation" && document.panes.len() > 1;
        if !is_reference && found.iter().all(|p| p.method.id != pane.method.id) {
            found.push(pane);
        }
    }
    if found.is_empty() { vec![&document.panes[0]] } else { found }
}

fn depth_words(depth: &DepthArgs, words: &mut Vec<String>) {
    let named = [("--layer", &depth.layer), ("--depth-layer", &depth.depth_layer)];
    words.extend(named.into_iter().filter_map(|(option, name)| Some([option.into(), name.clone()?])).flatten());
    words.extend(depth.scene_scale.map(|factor| ["--scene-scale".into(), factor.to_string()]).into_iter().flatten());
    let Some(file) = &depth.file else { return };
    words.extend(["--depth".into(), file.to_string_lossy().into_owned()]);
    let range = |kind: &str, near: f64, far: f64| {
        ["--depth-kind".into(), kind.into(), "--depth-range".into(), format!("{near},{far}")]
    };
    let scaled =
        |kind: &str, per_unit: f64| ["--depth-kind".into(), kind.into(), "--depth-scale".into(), per_unit.to_string()];
    match depth.encoding.kind {
        DepthKind::Metres { per_unit } => words.extend(["--depth-scale".into(), per_unit.to_string()]),
        DepthKind::Distance { per_unit } => words.extend(scaled("distance", per_unit)),
        DepthKind::Dioptres { per_unit } => words.extend(scaled("dioptres", per_unit)),
        DepthKind::Inverse { near_m, far_m } => words.extend(range("inverse", near_m, far_m)),
        DepthKind::Device { near_m, far_m, .. } => words.extend(range("device", near_m, far_m)),
        DepthKind::Relative { near_m, far_m } => words.extend(range("relative", near_m, far_m)),
        DepthKind::Disparity { focal_px, baseline_m, offset_px, per_unit } => {
            words.extend(scaled("disparity", per_unit));
            words.extend(["--depth-calibration".into(), format!("{focal_px},{baseline_m},{offset_px}")]);
        }
    }
    if let Some(infinity) = depth.encoding.infinity {
        words.extend(["--depth-infinity".into(), infinity.to_string()]);
    }
    if let Some(unknown) = depth.encoding.unknown {
        words.extend(["--depth-unknown".into(), unknown.to_string()]);
    }
}
