//! The caption, which has every parameter, and the README, which repeats the figures.

use crate::window::compared::Compared;
use crate::window::model::numbers::significant;
use crate::window::model::{Document, state};
use defocus_study::results::{CompareJson, ResultJson};
use defocus_study::table::params_text;

/// A number as it is written in a caption: four digits, and all that there are of fewer.
fn number(v: f64) -> String {
    let text = format!("{v:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn lens_text(json: &CompareJson) -> String {
    let lens = &json.setting.lens;
    let focus = lens.focus_m.map_or("infinity".to_owned(), |m| format!("{} m", number(m)));
    let mut text = format!(
        "E = {} mm, F = {} mm, dr = {} mm, ds = {} mm, DPI = {} px/mm, focus at {focus}, aperture {}",
        number(lens.aperture_diameter_mm),
        number(lens.focal_length_mm),
        number(lens.image_distance_mm),
        number(lens.screen_distance_mm),
        number(lens.density_px_per_mm),
        lens.aperture,
    );
    if !lens.eye.is_plain() {
        let eye = &lens.eye;
        text += &format!(", eye: {}", eye.refraction);
        text += &eye.accommodation_d.map_or_else(String::new, |d| format!(", accommodates {} D", number(d)));
        text += &eye.chromatic.map_or_else(String::new, |[r, g, b]| format!(", chromatic at {r}, {g}, {b} nm"));
    }
    if let Some(coc) = &json.setting.coc {
        text += &format!(
            "; circle of confusion {} px in the mean, 95 % below {} px, from {} to {} px",
            number(coc.mean_px),
            number(coc.p95_px),
            number(coc.min_signed_px),
            number(coc.max_signed_px)
        );
    }
    text
}

fn method_text(number: usize, title: &str, paper: &str, result: &ResultJson) -> String {
    let m = &result.metrics;
    let params = params_text(result);
    let params = if params.is_empty() { "no parameters".to_owned() } else { params };
    let identical = (m.identical == Some(true)).then(|| "identical to the reference".to_owned());
    let figures = [
        identical,
        m.psnr_db.map(|v| format!("PSNR {v:.2} dB")),
        m.psnr_defocused_db.map(|v| format!("{v:.2} dB over what is blurred")),
        m.jod.map(|v| format!("{v:.2} JOD")),
        m.ssim.map(|v| format!("SSIM {v:.4}")),
        m.flip.map(|v| format!("FLIP {v:.4}")),
        result.gpu_ms.map(|t| format!("{:.3} ms (median of {})", t.median, t.runs)),
    ];
    let figures: Vec<String> = figures.into_iter().flatten().collect();
    format!("({number}) {title} [{paper}; {params}]: {}.", figures.join(", "))
}

/// The caption, one paragraph.
pub fn caption(compared: &Compared, has_details: bool) -> String {
    let json = &compared.json;
    let setting = &json.setting;
    let [width, height] = setting.size;
    let mut text = format!(
        "Depth of field of {}, camera {}, {width} x {height} px. Lens: {}.",
        setting.scene,
        setting.camera,
        lens_text(json)
    );
    let papers = defocus::methods::all();
    for (index, (result, json)) in compared.comparison.results.iter().zip(&json.results).enumerate() {
        let paper = papers.iter().map(|m| m.about()).find(|a| a.id == result.method).map_or("", |a| a.paper);
        text += &format!(" {}", method_text(index + 1, result.title, paper, json));
    }
    if let Some(reference) = &json.reference {
        let samples = reference.samples.map_or_else(String::new, |n| format!(", {n} lens points"));
        let self_db = reference.self_psnr_db.map_or_else(String::new, |db| format!(", converged to about {db:.1} dB"));
        text += &format!(" Reference: {}{samples}{self_db}.", reference.method);
    }
    let (screen, display) = (&json.viewing.screen, compared.display);
    text += &format!(
        " Shown with an exposure of {} EV and tone map {}; judged at {} px per degree on a display of {} to {} cd/m2 in {} lux. Times: {} ({}).",
        display.exposure_ev,
        display.tone_map,
        significant(json.viewing.px_per_degree),
        number(screen.black_cd_m2),
        number(screen.peak_cd_m2),
        number(screen.ambient_lux),
        setting.adapter,
        setting.backend
    );
    if has_details {
        text += " Details are three times as large.";
    }
    text + "\n"
}

/// What is in the folder, and how it is made again.
pub fn readme(compared: &Compared, document: &Document, files: &[String]) -> String {
    let setting = &compared.json.setting;
    let mut text = format!(
        "# {}: figures\n\nMade by defocus {} on {} ({}).\n\n## Again\n\nFigures and pictures, from the command line:\n\n    {}\n\nThe window as it was: `defocus state.{}`, then *Figures for a paper* in the menu *File*.\n",
        setting.scene,
        env!("CARGO_PKG_VERSION"),
        setting.adapter,
        setting.backend,
        compared.command,
        state::EXTENSION
    );
    let missing = state::left_out(&Document { stereo: None, ..document.clone() });
    if !missing.is_empty() {
        text += &format!("\nThe command leaves out: {}.\n", missing.join(", "));
    }
    if !compared.notes.is_empty() || !compared.json.not_run.is_empty() {
        text += "\n## Notes\n\n";
        text += &compared.notes.iter().map(|note| format!("- {note}.\n")).collect::<String>();
        let left = compared.json.not_run.iter();
        text += &left.map(|left| format!("- {} was left out: {}.\n", left.method, left.reason)).collect::<String>();
    }
    text += "\n## Files\n\n| file | what it is |\n|---|---|\n";
    text += &files.iter().map(|file| format!("| {file} | {} |\n", about(file))).collect::<String>();
    text + "| README.md | this |\n"
}

fn about(file: &str) -> &'static str {
    match file {
        "caption.txt" => "a caption with every parameter",
        "table.csv" => "all figures, a line for each method",
        "table.json" => "the same with everything that they are of",
        "coc.svg" => "circle of confusion against depth",
        "coc.csv" => "the curve of coc.svg: depth in metres, signed diameter in pixels",
        "quality-time.svg" => "quality against time",
        "scales.svg" => "the colours of the maps",
        "pinhole.png" => "the input, everything sharp",
        "reference.png" => "the reference",
        _ if file.starts_with("state.") => "the state of the window",
        _ if file.ends_with("-detail.png") => "a part of the picture of that name, three times as large",
        _ if file.ends_with("-flip.png") => "FLIP",
        _ if file.ends_with("-visible.png") => "what is visible of the difference (ColorVideoVDP)",
        _ if file.ends_with("-error.png") => "absolute error of display values, greatest of R, G and B",
        _ => "the picture of a method",
    }
}
