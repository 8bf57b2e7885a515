//! Lee, Kim and Choi, "Depth-of-Field Rendering using Point Splatting on Per-Pixel Layers"
//! (Pacific Graphics 2008), Table 1.

use super::super::plan::{Blur, Plan, Variant};
use super::super::results::BenchResults;
use super::{Claim, Comparison, cell_text, geometric_mean, owned, part_ratio, ratio, setting, time_text};

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

/// Most views of an accumulation that is quick: 384 of the larger scene are minutes on a CPU.
const QUICK_VIEWS: u32 = 24;

pub(super) fn plan_variants() -> Vec<Variant> {
    let mut variants = vec![
        Variant::published("splat").with("accelerate", "on"),
        Variant::published("splat").with("accelerate", "off"),
        Variant::published("separable"),
    ];
    variants.extend(COLUMNS.iter().map(|(px, views)| accumulation(*views).only_at(Blur::MeanCocPx(*px))));
    variants
}

pub(super) fn plan(quick: bool) -> Plan {
    let blurs = (0..COLUMNS.len()).map(blur).collect();
    let size = if quick { [256, 192] } else { [1024, 768] };
    let too_long: Vec<_> = COLUMNS.iter().filter(|(_, views)| quick && *views > QUICK_VIEWS).collect();
    let is_wanted =
        |variant: &Variant| !too_long.iter().any(|(_, views)| variant.label() == accumulation(*views).label());
    let variants = plan_variants().into_iter().filter(is_wanted).collect();
    let whole = super::plan(&SCENES, size, blurs, variants);
    let whole = Plan { redraw: true, ..whole };
    if quick { Plan { reference_samples: None, runs: 3, ..whole } } else { whole }
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
            "Times here contain drawing the scene, as the paper's frame rates do. The paper's 24, 96 and 384 views are used for its mean CoCs of 8, 16 and 32 px (with --quick the 24 only).".into(),
            shares(results),
        ],
    }
}

/// What the time of splatting goes to.
fn shares(results: &BenchResults) -> String {
    let of = |scene: &&str| {
        let cell = results.cell(scene, blur(0));
        let sprites = |row: usize| part_ratio(cell, &label(row, 0), &["fs_visible"]);
        let part = |part| part_ratio(cell, &label(1, 0), &[part]);
        let figures = [part("/pinhole")?, part("/hidden")?, sprites(1)?, sprites(0)?, part("fs_hidden")?];
        let [visible, hidden, each, reduced, hidden_sprites] = figures.map(|copies| format!("{copies:.0}"));
        Some(format!(
            "{scene}: drawing the visible image {visible}, the hidden one {hidden}; its sprites {each}, accelerated {reduced}; the hidden image's, which are not reduced, {hidden_sprites}"
        ))
    };
    let found: Vec<String> = SCENES.iter().filter_map(of).collect();
    format!("What the time of splat goes to at C = 8, in copies of the image. {}.", found.join(". "))
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
        let both = speeds.iter().filter_map(|(paper, here)| paper.zip(*here));
        let agree: Vec<bool> = both.map(|(paper, here)| (paper > 1.0) == (here > 1.0)).collect();
        Claim::new(
            &format!(
                "{} over {}: {} times as fast at C = 8, 16, 32",
                PAPER[rows[0]].0,
                PAPER[rows[1]].0,
                list(speeds.iter().map(|s| s.0).collect())
            ),
            format!("{} times", list(speeds.iter().map(|s| s.1).collect())),
            (!agree.is_empty()).then(|| agree.iter().all(|agrees| *agrees)),
            reason,
        )
    };
    vec![
        claim(
            [0, 1],
            "See the notes: sprites are a part of the time only, and those of the hidden image are not reduced.",
        ),
        claim([2, 0], "The separable filter's rows are as long as the greatest CoC asks for."),
        claim(
            [0, 3],
            "See the notes for what the sprites take; accumulation takes as many views of the scene as it has.",
        ),
    ]
}
