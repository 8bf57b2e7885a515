//! The papers' tables on the scenes of this program: what they say beside what is measured.
//!
//! Frame rates of 2006 to 2011 mean nothing on another adapter, so what is compared is what
//! a table says about the methods among themselves.

mod comparison;
mod figure;
mod grapp;
mod pg;
mod quality;
mod siga;
mod tvcg;

pub use comparison::{Claim, Comparison};

use super::plan::{Blur, Plan, Variant};
use super::results::{BenchResults, CellResult};
use defocus::view::Input;

/// A table or figure of one of the papers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PaperTable {
    /// TVCG 2009, Fig. 14: four methods over the mean CoC.
    TvcgFig14,
    /// TVCG 2009, Table 1: texture look-ups.
    TvcgTable1,
    /// Pacific Graphics 2008, Table 1: splatting with and without acceleration.
    PgTable1,
    /// SIGGRAPH Asia 2009, Table 1: views, layers and triangles.
    SigaTable1,
    /// GRAPP 2011, section 5: the opaque image blur against the pyramidal one.
    Grapp,
    /// TVCG 2009, section 7.1: temporal flickering. It is measured over moving views and not in
    /// cells: [`crate::flicker`].
    TvcgFlicker,
    /// One of the papers' figures that compare pictures.
    Quality(usize),
}

/// All of them, by what they are called on the command line.
pub const ALL: [(&str, PaperTable); 6 + quality::FIGURES.len()] = {
    let mut all = [("", PaperTable::Grapp); 6 + quality::FIGURES.len()];
    all[0] = ("tvcg-fig14", PaperTable::TvcgFig14);
    all[1] = ("tvcg-table1", PaperTable::TvcgTable1);
    all[2] = ("pg-table1", PaperTable::PgTable1);
    all[3] = ("siga-table1", PaperTable::SigaTable1);
    all[4] = ("grapp", PaperTable::Grapp);
    all[5] = ("tvcg-flicker", PaperTable::TvcgFlicker);
    let mut figure = 0;
    while figure < quality::FIGURES.len() {
        all[6 + figure] = (quality::FIGURES[figure].name, PaperTable::Quality(figure));
        figure += 1;
    }
    all
};

impl std::str::FromStr for PaperTable {
    type Err = String;

    /// The table of that name in [`ALL`].
    fn from_str(name: &str) -> Result<Self, String> {
        let found = ALL.iter().find(|(known, _)| *known == name).map(|(_, table)| *table);
        found.ok_or_else(|| format!("there are {}", ALL.map(|(known, _)| known).join(", ")))
    }
}

impl PaperTable {
    /// What to measure in cells: of [`PaperTable::TvcgFlicker`] nothing. `quick` caps scenes, sizes,
    /// lens points and runs.
    pub fn plan(self, quick: bool) -> Plan {
        match self {
            Self::TvcgFig14 => tvcg::fig14_plan(quick),
            Self::TvcgTable1 => tvcg::table1_plan(quick),
            Self::PgTable1 => pg::plan(quick),
            Self::SigaTable1 => siga::plan(quick),
            Self::Grapp => grapp::plan(quick),
            Self::TvcgFlicker => plan(&[], [1, 1], Vec::new(), Vec::new()),
            Self::Quality(figure) => quality::FIGURES[figure].plan(quick),
        }
    }

    /// The result, beside the paper; of [`PaperTable::TvcgFlicker`], which has no cells, without rows.
    pub fn compared(self, results: &BenchResults) -> Comparison {
        match self {
            Self::TvcgFig14 => tvcg::fig14(results),
            Self::TvcgTable1 => tvcg::table1(results),
            Self::PgTable1 => pg::compared(results),
            Self::SigaTable1 => siga::compared(results),
            Self::Grapp => grapp::compared(results),
            Self::TvcgFlicker => crate::flicker::compared(&crate::flicker::Plan::table(false), "no adapter", &[]),
            Self::Quality(figure) => quality::FIGURES[figure].compared(results),
        }
    }
}

impl Claim {
    fn new(paper: &str, measured: String, holds: Option<bool>, reason: &str) -> Self {
        let reason = if holds == Some(false) { reason.into() } else { String::new() };
        Self { paper: paper.into(), measured, holds, reason }
    }
}

/// A plan with what all tables have alike: no margin around the image, as in the papers.
fn plan(scenes: &[&str], size: [u32; 2], blurs: Vec<Blur>, variants: Vec<Variant>) -> Plan {
    Plan {
        scenes: scenes.iter().map(|s| (*s).to_owned()).collect(),
        sizes: vec![size],
        blurs,
        variants,
        reference_samples: Some(1024),
        reference_only_at: None,
        warmup: 1,
        runs: 9,
        redraw: false,
        count_reads: false,
        error_maps: false,
        overscan_px: Some(0),
        view_dependent: false,
        input: Input::Hdr,
    }
}

/// A number, or a dash where there is none.
fn cell_text(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(|| "–".into(), |v| format!("{v:.decimals$}"))
}

/// Time in ms and as a multiple of the copy's.
fn time_text(cell: Option<&CellResult>, label: &str) -> String {
    let variant = cell.and_then(|c| c.variant(label));
    match variant.and_then(|v| Some((v.ms()?, v.ratio()?))) {
        Some((ms, ratio)) => format!("{} ms ({}x)", three_digits(ms), three_digits(ratio)),
        None => "–".into(),
    }
}

/// A number with three digits, or as many as it has before the point.
fn three_digits(value: f64) -> String {
    let decimals = if value < 10.0 { 2 } else { usize::from(value < 100.0) };
    format!("{value:.decimals$}")
}

/// Multiple of the copy's time.
fn ratio(cell: Option<&CellResult>, label: &str) -> Option<f64> {
    cell?.variant(label)?.ratio()
}

/// What of that multiple the passes take whose label has any of `parts` in it.
fn part_ratio(cell: Option<&CellResult>, label: &str, parts: &[&str]) -> Option<f64> {
    let variant = cell?.variant(label)?;
    let ms = |wanted: &dyn Fn(&str) -> bool| -> f64 {
        variant.passes.iter().filter(|pass| wanted(&pass.label)).map(|pass| pass.ms).sum()
    };
    let all_ms = ms(&|_| true);
    (all_ms > 0.0)
        .then(|| ms(&|label| parts.iter().any(|part| label.contains(part))) / all_ms)
        .zip(variant.ratio())
        .map(|(share, r)| share * r)
}

/// Geometric mean; `None` of nothing.
fn geometric_mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let logarithms: Vec<f64> = values.into_iter().map(f64::ln).collect();
    (!logarithms.is_empty()).then(|| (logarithms.iter().sum::<f64>() / logarithms.len() as f64).exp())
}

fn owned<const N: usize>(texts: [&str; N]) -> Vec<String> {
    texts.map(str::to_owned).to_vec()
}

/// Size, adapter, runs and how much of the plan was measured, in words.
fn setting(results: &BenchResults) -> String {
    let plan = &results.plan;
    let sizes: Vec<String> = plan.sizes.iter().map(|[w, h]| format!("{w}x{h} px")).collect();
    let adapter = results.cells.first().map_or("nothing measured yet", |c| &c.adapter);
    let mut text = format!("{}, {adapter}, median of {} runs", sizes.join(", "), plan.runs);
    if let Some(samples) = plan.reference_samples {
        text += &format!(", reference of {samples} lens points");
    }
    if results.cells.len() < results.cells_wanted {
        text += &format!("; {} of {} cells measured", results.cells.len(), results.cells_wanted);
    }
    text
}
