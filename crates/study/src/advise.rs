//! Which methods are good enough for a display: over pupils and focus distances, what each
//! looks like there and what it costs here.

use crate::bench::plot::{Axis, Plot, Point, Series};
use crate::compare::{CompareRequest, GoodEnough, MethodResult, compare};
use crate::metrics::Visibility;
use crate::reference::{Reference, ReferenceRequest, render_reference};
use crate::source::GpuSource;
use crate::timing::Rounds;
use crate::{Progress, Step, StudyError};
use askama::Template;
use defocus::display::Display;
use defocus::gpu::Gpu;
use defocus::image::DepthImage;
use defocus::lens::Lens;
use defocus::methods::{self, Method};
use defocus::view::{View, auto_overscan_px};
use defocus::viewing::Viewing;
use serde::Serialize;

/// Pupils, mm: from bright light to the dark.
pub const PUPILS_MM: [f64; 4] = [2.0, 4.0, 6.0, 8.0];

/// Shares of the depths in view at which to focus where nothing else is asked for.
const FOCUS_RANKS: [f64; 3] = [0.1, 0.5, 0.9];

/// What to advise on.
pub struct AdviceRequest<'a> {
    /// The display, and the eye before it; its E and focus are replaced.
    pub lens: &'a Lens,
    /// Pupils, mm.
    pub pupils_mm: &'a [f64],
    /// Focus distances, metres.
    pub focus_m: &'a [f64],
    /// Methods with their parameters.
    pub methods: &'a [Box<dyn Method>],
    /// Lens points of the reference.
    pub samples: u32,
    /// Timed runs of each method.
    pub runs: u32,
    /// Least quality that is good enough, JOD.
    pub good_enough_jod: f64,
    /// How images are shown.
    pub display: Display,
    /// Under what angle and in what light.
    pub viewing: Viewing,
}

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct Advice {
    /// Least quality that counts as good enough, JOD.
    pub good_enough_jod: f64,
    /// By focus distance, then by pupil.
    pub cells: Vec<AdviceCell>,
    /// The cheapest method that is good enough everywhere, by its greatest time; null where
    /// none is.
    pub everywhere: Option<&'static str>,
}

/// One pupil at one focus distance.
#[derive(Clone, Debug, Serialize)]
pub struct AdviceCell {
    /// Pupil, mm.
    pub pupil_mm: f64,
    /// Focus distance, metres; null at infinity.
    pub focus_m: Option<f64>,
    /// Mean CoC diameter over the picture, px.
    pub mean_coc_px: f64,
    /// Estimated PSNR of the reference against a converged one, dB.
    pub reference_self_psnr_db: Option<f64>,
    /// What each method looks like and costs.
    pub methods: Vec<AdviceMethod>,
    /// The cheapest that is good enough; null where none is.
    pub cheapest: Option<&'static str>,
}

/// A method in one cell.
#[derive(Clone, Debug, Serialize)]
pub struct AdviceMethod {
    /// Its id.
    pub method: &'static str,
    /// Quality as seen on the display, JOD.
    pub jod: Option<f64>,
    /// The same in a word.
    pub visibility: Option<Visibility>,
    /// Whether that is good enough.
    pub good_enough: bool,
    /// Median GPU time, ms.
    pub gpu_ms: Option<f64>,
}

/// Focus distances where none are asked for, metres: near, middle and far of what is in view.
pub fn focus_distances_m(depth: &DepthImage) -> Vec<f64> {
    let mut finite: Vec<f32> = depth.pixels.iter().copied().filter(|d| d.is_finite()).collect();
    finite.sort_by(f32::total_cmp);
    let at = |rank: f64| finite.get(((finite.len().max(1) - 1) as f64 * rank) as usize).copied();
    let mut found: Vec<f64> = FOCUS_RANKS.iter().filter_map(|rank| at(*rank)).map(f64::from).collect();
    found.dedup();
    found
}

/// Renders and judges every cell.
///
/// # Errors
///
/// What a method says, [`StudyError::Stopped`], an image with depth, which has no reference.
pub fn advise(
    gpu: &Gpu,
    source: &GpuSource,
    view: &mut View,
    request: &AdviceRequest<'_>,
    progress: &mut Progress<'_>,
) -> Result<Advice, StudyError> {
    let size = view.size();
    let depth = view.depth_m(gpu);
    let of = (request.focus_m.len() * request.pupils_mm.len()) as u32;
    let mut cells = Vec::new();
    for &focus_distance_m in request.focus_m {
        for &aperture_diameter_mm in request.pupils_mm {
            let lens = Lens { aperture_diameter_mm, focus_distance_m, ..request.lens.clone() };
            let done = cells.len() as u32;
            let mut progress = |inner: Step<'_>| {
                let what = format!("{aperture_diameter_mm} mm at {focus_distance_m:.2} m: {}", inner.what);
                progress(Step { what: &what, done, of })
            };
            view.set_size(gpu, size, auto_overscan_px(&lens, &depth))?;
            cells.push(cell(gpu, source, view, &lens, request, &mut progress)?);
        }
    }
    let everywhere = everywhere(&cells);
    Ok(Advice { good_enough_jod: request.good_enough_jod, cells, everywhere })
}

fn cell(
    gpu: &Gpu,
    source: &GpuSource,
    view: &mut View,
    lens: &Lens,
    request: &AdviceRequest<'_>,
    progress: &mut Progress<'_>,
) -> Result<AdviceCell, StudyError> {
    let (display, viewing) = (request.display, request.viewing);
    let reference = ReferenceRequest {
        reference: Reference::Accumulation,
        samples: request.samples,
        view_dependent: false,
        display,
    };
    let truth = render_reference(source, view, lens, &reference, progress)?;
    let rounds = Rounds { warmup: 1, runs: request.runs, redraw: false };
    let compared = CompareRequest { lens, methods: request.methods, truth: Some(&truth), display, viewing, rounds };
    let results = compare(gpu, view, &compared, progress)?.results;
    let least = request.good_enough_jod;
    let of = |result: &MethodResult| {
        let jod = result.metrics.as_ref().and_then(|m| m.jod);
        AdviceMethod {
            method: result.method,
            jod,
            visibility: jod.map(Visibility::of_jod),
            good_enough: jod.is_some_and(|jod| jod >= least),
            gpu_ms: result.gpu_ms.map(|ms| ms.median),
        }
    };
    let depth = view.depth_m(gpu);
    Ok(AdviceCell {
        pupil_mm: lens.aperture_diameter_mm,
        focus_m: Some(lens.focus_distance_m).filter(|m| m.is_finite()),
        mean_coc_px: lens.coc_statistics(depth.pixels.iter().copied()).map_or(0.0, |s| s.mean_px),
        reference_self_psnr_db: truth.self_psnr_db,
        methods: results.iter().map(of).collect(),
        cheapest: GoodEnough::among(&results, least).method,
    })
}

/// The cheapest method that is good enough in every cell, by its greatest time.
fn everywhere(cells: &[AdviceCell]) -> Option<&'static str> {
    let first = cells.first()?;
    let in_all =
        |id: &&'static str| cells.iter().all(|cell| cell.methods.iter().any(|m| m.method == *id && m.good_enough));
    let greatest_ms = |id: &'static str| {
        let times = cells.iter().flat_map(|cell| &cell.methods).filter(|m| m.method == id);
        times.map(|m| m.gpu_ms.unwrap_or(f64::INFINITY)).fold(0.0, f64::max)
    };
    let ids = first.methods.iter().map(|m| m.method).filter(in_all);
    ids.min_by(|a, b| greatest_ms(a).total_cmp(&greatest_ms(b)))
}

#[derive(Template)]
#[template(path = "advise.html")]
struct Page<'a> {
    title: &'a str,
    display: &'a str,
    command: &'a str,
    answer: String,
    methods: Vec<&'static str>,
    groups: Vec<Group>,
    plot: String,
    bounds: [&'static str; 4],
    version: &'static str,
}

struct Group {
    title: String,
    rows: Vec<Row>,
}

struct Row {
    head: String,
    cheapest: String,
    cells: Vec<Cell>,
}

struct Cell {
    text: String,
    help: String,
    color: String,
    good: bool,
}

/// The advice in a sentence.
pub fn in_words(advice: &Advice) -> String {
    let least = advice.good_enough_jod;
    match advice.everywhere {
        Some(id) => format!("{id} is the cheapest method with at least {least} JOD for every pupil and focus."),
        None => format!("No method has {least} JOD for every pupil and focus; the cheapest of each is in the table."),
    }
}

/// The advice as an HTML file.
///
/// # Errors
///
/// None in practice: memory takes everything.
pub fn html(advice: &Advice, title: &str, display: &str, command: &str) -> std::io::Result<String> {
    let mut groups: Vec<Group> = Vec::new();
    for cell in &advice.cells {
        let title = cell.focus_m.map_or("focused at infinity".into(), |m| format!("focused at {m:.2} m"));
        if groups.last().is_none_or(|group| group.title != title) {
            groups.push(Group { title, rows: Vec::new() });
        }
        if let Some(group) = groups.last_mut() {
            group.rows.push(row(cell));
        }
    }
    let methods = advice.cells.first().map(|cell| cell.methods.iter().map(|m| m.method).collect()).unwrap_or_default();
    let page = Page {
        title,
        display,
        command,
        answer: in_words(advice),
        methods,
        groups,
        plot: plot(advice),
        bounds: Visibility::ALL.map(Visibility::why),
        version: env!("CARGO_PKG_VERSION"),
    };
    page.render().map_err(std::io::Error::other)
}

fn row(cell: &AdviceCell) -> Row {
    let of = |m: &AdviceMethod| {
        let [r, g, b] = m.visibility.map_or([128; 3], Visibility::srgb8);
        Cell {
            text: m.jod.map_or("–".into(), |jod| format!("{jod:.2}")),
            help: m.gpu_ms.map_or(String::new(), |ms| format!("{ms:.2} ms")),
            color: format!("rgb({r} {g} {b})"),
            good: m.good_enough,
        }
    };
    Row {
        head: format!("{} mm, mean CoC {:.1} px", cell.pupil_mm, cell.mean_coc_px),
        cheapest: cell.cheapest.unwrap_or("none").into(),
        cells: cell.methods.iter().map(of).collect(),
    }
}

/// Cost against quality over all cells.
fn plot(advice: &Advice) -> String {
    let all = methods::all();
    let mut series: Vec<Series> = Vec::new();
    for cell in &advice.cells {
        for m in &cell.methods {
            let Some((x, y)) = m.gpu_ms.filter(|ms| *ms > 0.0).zip(m.jod) else { continue };
            let focus = cell.focus_m.map_or("infinity".into(), |m| format!("{m:.2} m"));
            let label = format!("{}, {} mm at {focus}: {y:.2} JOD, {x:.2} ms", m.method, cell.pupil_mm);
            let point = Point { x, y, interval: None, label };
            match series.iter_mut().find(|s| s.name == m.method) {
                Some(found) => found.points.push(point),
                None => {
                    let style = all.iter().position(|other| other.about().id == m.method).unwrap_or(0);
                    series.push(Series { name: m.method.into(), style, points: vec![point], markers: true });
                }
            }
        }
    }
    if series.is_empty() {
        return String::new();
    }
    let x = Axis { title: "GPU time, ms", logarithmic: true };
    let y = Axis { title: "quality, JOD", logarithmic: false };
    Plot { x, y, series, front: true }.svg()
}
