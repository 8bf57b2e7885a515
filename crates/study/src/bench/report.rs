//! A benchmark as one HTML page, beside its error maps.

use super::lead::{Lead, leads};
use super::plan::Blur;
use super::plot::{Axis, Plot, Point, Series};
use super::results::{BenchResults, CellResult, VariantResult};
use super::tables;
use crate::report::gradient;
use askama::Template;
use defocus::colormap::ColorMap;
use defocus::methods;
use std::collections::BTreeSet;

/// Mean CoC diameter, px, at which plots over other things are made: the papers' limit for
/// a picture without visible faults.
const TYPICAL_COC_PX: f64 = 16.0;

/// What a report shows.
pub struct ReportInput<'a> {
    /// The figures.
    pub results: &'a BenchResults,
    /// The table that it reproduces, if it does.
    pub table: Option<&'a tables::Comparison>,
    /// What was left out to be quick, if anything was.
    pub caps: &'a str,
    /// The command that made it, for repeating it.
    pub command: &'a str,
}

#[derive(Template)]
#[template(path = "bench.html")]
struct Page<'a> {
    adapters: String,
    runs: String,
    unfinished: String,
    caps: &'a str,
    command: &'a str,
    table: Option<&'a tables::Comparison>,
    sections: Vec<Section>,
    leads: Vec<Vec<String>>,
    maps: Vec<MapGroup>,
    magma: String,
    rows: Vec<Vec<String>>,
    not_run: BTreeSet<String>,
    version: &'static str,
}

struct Section {
    title: &'static str,
    about: &'static str,
    plots: Vec<TitledPlot>,
}

struct TitledPlot {
    title: String,
    svg: String,
}

struct MapGroup {
    title: String,
    maps: Vec<Map>,
}

struct Map {
    file: String,
    caption: String,
}

/// Renders the report.
///
/// # Errors
///
/// None in practice: memory takes everything.
pub fn html(input: &ReportInput<'_>) -> std::io::Result<String> {
    let results = input.results;
    let plan = &results.plan;
    let adapters: BTreeSet<&str> = results.cells.iter().map(|c| c.adapter.as_str()).collect();
    let (done, wanted) = (results.cells.len(), results.cells_wanted);
    let reference = plan.reference_samples.map_or(String::new(), |n| format!(", reference of {n} lens points"));
    let drawn = if plan.redraw { ", everything drawn anew for each run" } else { ", the view kept between runs" };
    let not_run = |cell: &CellResult| -> Vec<String> {
        cell.not_run
            .iter()
            .map(|left| format!("{} was left out on {}: {}", left.method, cell.scene, left.reason))
            .collect()
    };
    let page = Page {
        adapters: adapters.into_iter().collect::<Vec<_>>().join(", "),
        runs: format!("median of {} runs after {}{drawn}{reference}", plan.runs, plan.warmup),
        unfinished: if done < wanted { format!("{done} of {wanted} cells are measured.") } else { String::new() },
        caps: input.caps,
        command: input.command,
        table: input.table,
        sections: sections(results),
        leads: results.cells.iter().flat_map(lead_rows).collect(),
        maps: results.cells.iter().filter_map(map_group).collect(),
        magma: gradient(ColorMap::Magma),
        rows: results.cells.iter().flat_map(rows).collect(),
        not_run: results.cells.iter().flat_map(not_run).collect(),
        version: env!("CARGO_PKG_VERSION"),
    };
    page.render().map_err(std::io::Error::other)
}

fn rows(cell: &CellResult) -> impl Iterator<Item = Vec<String>> {
    let number = |value: Option<f64>, decimals: usize| value.map_or("–".into(), |v| format!("{v:.decimals$}"));
    cell.variants.iter().map(move |v| {
        let m = &v.metrics;
        let psnr = if m.identical == Some(true) { "identical".into() } else { number(m.psnr_db, 2) };
        vec![
            cell.scene.clone(),
            format!("{}x{}", cell.size[0], cell.size[1]),
            format!("{:.1}", cell.mean_coc_px),
            v.label.clone(),
            number(v.ms(), 3),
            v.gpu_ms.map_or("–".into(), |t| format!("{:.3} to {:.3}", t.low, t.high)),
            number(v.ratio(), 2),
            psnr,
            number(m.psnr_defocused_db, 2),
            number(m.worst_block_psnr_db, 2),
            number(m.ssim, 4),
            number(m.flip, 4),
            number(m.jod, 2),
            number(v.reads_per_px, 2),
            format!("{:.1}", v.work.peak_texture_bytes as f64 / f64::from(1 << 20)),
        ]
    })
}

fn lead_rows(cell: &CellResult) -> impl Iterator<Item = Vec<String>> {
    let row = |lead: Lead<'_>| {
        vec![
            cell.scene.clone(),
            format!("{}x{}", cell.size[0], cell.size[1]),
            format!("{:.1}", cell.mean_coc_px),
            lead.leader.into(),
            lead.rival.into(),
            format!("{:+.1}", lead.db_at_equal_time),
            lead.time_at_equal_error.map_or("never".into(), |share| format!("{share:.2}")),
            if lead.beaten.is_empty() { "none".into() } else { lead.beaten.join(", ") },
        ]
    };
    leads(cell).into_iter().map(row)
}

fn map_group(cell: &CellResult) -> Option<MapGroup> {
    let map = |v: &VariantResult| {
        let flip = v.metrics.flip.map_or(String::new(), |f| format!(", {f:.3}"));
        Some(Map { file: v.flip_map.clone()?, caption: format!("{}{flip}", v.label) })
    };
    let maps: Vec<Map> = cell.variants.iter().filter_map(map).collect();
    (!maps.is_empty()).then(|| MapGroup { title: cell.cell.label(), maps })
}

fn sections(results: &BenchResults) -> Vec<Section> {
    let all = [
        Section {
            title: "Time against error",
            about: "Points of one method are joined. Up and left is better; the dashed line is the front that no other variant passes.",
            plots: error_plots(results, PSNR, VariantResult::defocused_db),
        },
        Section {
            title: "Time against visibility",
            about: "Quality in JOD as ColorVideoVDP predicts it before a monitor of 200 cd/m² that shows the picture at the lens's pixels per degree: 10 is no visible difference, below 9 more than 75 % of observers see it. The dashed line is the front that no other variant passes.",
            plots: error_plots(results, JOD, |v| v.metrics.jod),
        },
        Section {
            title: "Time against mean CoC",
            about: "Methods with their default parameters. Bars are the 95 % intervals of the medians.",
            plots: over(results, Over::Coc),
        },
        Section {
            title: "Time against resolution",
            about: "Methods with their default parameters.",
            plots: over(results, Over::Resolution),
        },
        Section {
            title: "Time against triangles",
            about: "Scenes by their number of triangles; methods with their default parameters.",
            plots: over(results, Over::Triangles),
        },
    ];
    all.into_iter().filter(|section| !section.plots.is_empty()).collect()
}

/// Whether a cell is at the blur of the plan that is nearest to the typical one.
fn is_typical(results: &BenchResults, cell: &CellResult) -> bool {
    let distance = |blur: &Blur| (blur.px() / TYPICAL_COC_PX).ln().abs();
    let nearest = results.plan.blurs.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
    nearest.is_some_and(|blur| *blur == cell.cell.blur)
}

/// The same colour and shape for a method everywhere.
fn style(method: &str) -> usize {
    methods::all().iter().position(|m| m.about().id == method).unwrap_or(0)
}

const COPIES: Axis<'_> = Axis { title: "GPU time, multiples of a copy of the image", logarithmic: true };

/// Adds a point to its method's series.
fn add(series: &mut Vec<Series>, method: &str, point: Point) {
    match series.iter_mut().find(|s| s.name == method) {
        Some(found) => found.points.push(point),
        None => series.push(Series { name: method.into(), style: style(method), points: vec![point], markers: true }),
    }
}

fn by_x(series: &mut [Series]) {
    for one in series {
        one.points.sort_by(|a, b| a.x.total_cmp(&b.x));
    }
}

const PSNR: (Axis<'_>, &str) = (Axis { title: "PSNR over defocused pixels, dB", logarithmic: false }, "dB");

const JOD: (Axis<'_>, &str) = (Axis { title: "quality, JOD", logarithmic: false }, "JOD");

/// Time against a measure of the error, a plot for each cell at the typical blur.
fn error_plots(
    results: &BenchResults,
    (axis, unit): (Axis<'_>, &str),
    measure: fn(&VariantResult) -> Option<f64>,
) -> Vec<TitledPlot> {
    let typical = results.cells.iter().filter(|c| is_typical(results, c));
    typical.filter_map(|cell| error_plot(cell, (axis, unit), measure)).collect()
}

fn error_plot(
    cell: &CellResult,
    (y_axis, unit): (Axis<'_>, &str),
    measure: fn(&VariantResult) -> Option<f64>,
) -> Option<TitledPlot> {
    let mut series = Vec::new();
    for variant in &cell.variants {
        let Some((x, y)) = variant.ratio().filter(|r| *r > 0.0).zip(measure(variant)) else { continue };
        let label = format!("{}: {y:.2} {unit}, {x:.2} copies", variant.label);
        add(&mut series, &variant.method, Point { x, y, interval: None, label });
    }
    by_x(&mut series);
    let svg = Plot { x: COPIES, y: y_axis, series: some(series)?, front: true }.svg();
    Some(TitledPlot { title: cell.cell.label(), svg })
}

/// The series, unless there are none.
fn some(series: Vec<Series>) -> Option<Vec<Series>> {
    Some(series).filter(|s| !s.is_empty())
}

#[derive(Clone, Copy, PartialEq)]
enum Over {
    Coc,
    Resolution,
    Triangles,
}

impl Over {
    fn axis(self) -> Axis<'static> {
        let title = match self {
            Self::Coc => "mean CoC diameter, px",
            Self::Resolution => "pixels",
            Self::Triangles => "triangles",
        };
        Axis { title, logarithmic: true }
    }

    fn x(self, cell: &CellResult) -> f64 {
        match self {
            Self::Coc => cell.cell.blur.px(),
            Self::Resolution => f64::from(cell.size[0]) * f64::from(cell.size[1]),
            Self::Triangles => cell.scene_triangles as f64,
        }
    }

    /// What all cells of one plot have in common.
    fn group(self, cell: &CellResult) -> String {
        let [width, height] = cell.size;
        match self {
            Self::Coc => format!("{} {width}x{height}", cell.scene),
            Self::Resolution => format!("{}, {}", cell.scene, cell.cell.blur),
            Self::Triangles => format!("{width}x{height}, {}", cell.cell.blur),
        }
    }
}

/// A plot for each group of cells that differ in what it is over, where there are several.
fn over(results: &BenchResults, over: Over) -> Vec<TitledPlot> {
    let is_wanted = |cell: &&CellResult| over == Over::Coc || is_typical(results, cell);
    let cells: Vec<&CellResult> = results.cells.iter().filter(is_wanted).collect();
    let mut titles: Vec<String> = Vec::new();
    for title in cells.iter().map(|c| over.group(c)) {
        if !titles.contains(&title) {
            titles.push(title);
        }
    }
    let plot = |title: String| {
        let group: Vec<&CellResult> = cells.iter().copied().filter(|c| over.group(c) == title).collect();
        let xs: BTreeSet<u64> = group.iter().map(|c| over.x(c).to_bits()).collect();
        let series = some(default_series(&group, over)).filter(|_| xs.len() > 1)?;
        // Copies of different sizes are no common measure.
        let y = if over == Over::Resolution { Axis { title: "GPU time, ms", logarithmic: true } } else { COPIES };
        Some(TitledPlot { title, svg: Plot { x: over.axis(), y, series, front: false }.svg() })
    };
    titles.into_iter().filter_map(plot).collect()
}

/// The first variant of each method.
fn default_series(cells: &[&CellResult], over: Over) -> Vec<Series> {
    let mut series = Vec::new();
    for cell in cells {
        let mut seen = BTreeSet::new();
        for variant in cell.variants.iter().filter(|v| seen.insert(&v.method)) {
            let times = if over == Over::Resolution { variant.gpu_ms } else { variant.copy_ratio };
            let Some(times) = times.filter(|t| t.low > 0.0) else { continue };
            let label = format!("{}, {}: {:.3}", variant.label, cell.cell.label(), times.median);
            let interval = Some([times.low, times.high]);
            add(&mut series, &variant.method, Point { x: over.x(cell), y: times.median, interval, label });
        }
    }
    by_x(&mut series);
    series
}
