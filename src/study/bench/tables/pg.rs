//! Lee, Kim and Choi, "Depth-of-Field Rendering using Point Splatting on Per-Pixel Layers"
//! (Pacific Graphics 2008), Table 1.

use super::super::plan::{Blur, Plan, Variant};
use super::super::results::BenchResults;
use super::{Claim, Comparison, cell_text, geometric_mean, owned, ratio, setting, time_text};

/// Mean CoC diameters, px, with the number of views that the paper's accumulation takes
/// for each.
const COLUMNS: [(f64, u32); 3] = [(8.0, 24), (16.0, 96), (32.0, 384)];

/// The paper's frame rates: Elephant (216,080 triangles), then Grasshopper (46,009).
const PAPER: [(&str, [[f64; 3]; 2]); 4] = [
    ("splat, accelerated", [[67.0, 50.0, 31.0], [68.0, 30.0, 17.0]]),
    ("splat", [[14.0, 4.0, 1.0], [16.0, 5.0, 3.0]]),
    ("separable", [[105.0, 82.0, 57.0], [144.0, 105.0, 67.0]]),
    ("accumulation", [[12.0, 3.0, 0.7], [15.0, 4.0, 0.9]]),
];

/// What stands in for the two scenes.
const SCENES: [&str; 2] = ["herd", "branches"];

fn accumulation(views: u32) -> Variant {
    Variant::of("accumulation").with("samples", views)
}

fn blur(column: usize) -> Blur {
    Blur::MeanCocPx(COLUMNS[column].0)
}

pub(super) fn plan_variants() -> Vec<Variant> {
    let mut variants = vec![
        Variant::of("splat").with("accelerate", "on"),
        Variant::of("splat").with("accelerate", "off"),
        Variant::of("separable"),
    ];
    variants.extend(COLUMNS.iter().map(|(px, views)| accumulation(*views).only_at(Blur::MeanCocPx(*px))));
    variants
}

pub(super) fn plan(quick: bool) -> Plan {
    let blurs = (0..COLUMNS.len()).map(blur).collect();
    let size = if quick { [256, 192] } else { [1024, 768] };
    let whole = super::plan(&SCENES, size, blurs, plan_variants());
    let whole = Plan { redraw: true, ..whole };
    if quick { Plan { reference_samples: Some(64), runs: 3, ..whole } } else { whole }
}

/// The variant of a row in a column.
fn label(row: usize, column: usize) -> String {
    match row {
        3 => accumulation(COLUMNS[column].1).label(),
        row => plan_variants()[row].label(),
    }
}

pub(super) fn compared(results: &BenchResults) -> Comparison {
    let mut columns = owned(["method", "scene"]);
    columns.extend(COLUMNS.iter().flat_map(|(px, _)| [format!("paper C = {px}, fps"), format!("here C = {px}")]));
    let mut rows = Vec::new();
    for (row, (name, fps)) in PAPER.iter().enumerate() {
        for (scene, fps) in SCENES.iter().zip(fps) {
            let mut cells = vec![(*name).to_owned(), (*scene).to_owned()];
            for (column, fps) in fps.iter().enumerate() {
                cells.push(format!("{fps}"));
                cells.push(time_text(results.cell(scene, blur(column)), &label(row, column)));
            }
            rows.push(cells);
        }
    }
    Comparison {
        title: "Pacific Graphics 2008, Table 1: splatting against its peers".into(),
        setting: format!(
            "{}, everything drawn anew for each run. herd stands in for Elephant, branches for Grasshopper.",
            setting(results)
        ),
        columns,
        rows,
        claims: claims(results),
        notes: vec![
            "Times here contain drawing the scene, as the paper's frame rates do. The paper's 24, 96 and 384 views are used for its mean CoCs of 8, 16 and 32 px.".into(),
            "A CPU renderer blends sprites far more slowly than the raster units of a GPU of 2008, in proportion to everything else: rows with splat stand worse here.".into(),
        ],
    }
}

/// Mean of how many times faster the first row is than the second: the paper's, and ours.
fn speed(results: &BenchResults, [fast, slow]: [usize; 2], column: usize) -> (Option<f64>, Option<f64>) {
    let paper = geometric_mean((0..2).map(|s| PAPER[fast].1[s][column] / PAPER[slow].1[s][column]));
    let here = SCENES.iter().filter_map(|scene| {
        let cell = results.cell(scene, blur(column));
        Some(ratio(cell, &label(slow, column))? / ratio(cell, &label(fast, column))?)
    });
    (paper, geometric_mean(here))
}

fn claims(results: &BenchResults) -> Vec<Claim> {
    let claim = |rows: [usize; 2], reason: &str| {
        let speeds: Vec<_> = (0..COLUMNS.len()).map(|column| speed(results, rows, column)).collect();
        let list = |values: Vec<Option<f64>>| values.iter().map(|v| cell_text(*v, 2)).collect::<Vec<_>>().join(", ");
        let holds: Option<Vec<bool>> =
            speeds.iter().map(|(paper, here)| Some((paper.as_ref()? > &1.0) == (here.as_ref()? > &1.0))).collect();
        Claim::new(
            &format!(
                "{} over {}: {} times as fast at C = 8, 16, 32",
                PAPER[rows[0]].0,
                PAPER[rows[1]].0,
                list(speeds.iter().map(|s| s.0).collect())
            ),
            format!("{} times", list(speeds.iter().map(|s| s.1).collect())),
            holds.map(|h| h.iter().all(|agrees| *agrees)),
            reason,
        )
    };
    vec![
        claim(
            [0, 1],
            "Where most of the image is near an edge or has a CoC under 4 px the array of quarter-area sprites is hardly used, and choosing it costs.",
        ),
        claim([2, 0], "The separable filter's rows are as long as the greatest CoC asks for."),
        claim(
            [0, 3],
            "Accumulation draws a scene of these sizes quickly, and sprites are blended by the CPU: with few views it wins.",
        ),
    ]
}
