//! Lee, Eisemann and Seidel, "Depth-of-Field Rendering with Multiview Synthesis" (SIGGRAPH
//! Asia 2009), Table 1.

use super::super::plan::{Blur, Plan, Variant};
use super::super::results::BenchResults;
use super::{Claim, Comparison, cell_text, owned, part_ratio, ratio, setting, time_text};

const BLUR: Blur = Blur::MeanCocPx(16.0);

/// Toys (67 k triangles), Dinosaurs (300 k) and Angels (1.76 M), and what stands in: a
/// small, a middling and a large scene.
const SCENES: [&str; 3] = ["mirrors", "cans", "atrium"];

/// A row: the paper's method, what it is here, and its frame rates by scene.
struct Row {
    name: String,
    variant: Variant,
    fps: [f64; 3],
}

fn row(name: &str, variant: Variant, fps: [f64; 3]) -> Row {
    Row { name: name.into(), variant, fps }
}

fn multiview(views: u32, layers: u32) -> Variant {
    // The thickness that always asks for as many layers as are allowed.
    Variant::published("multiview").with("samples", views).with("slabs", layers).with("delta", 0.5)
}

fn accumulation(views: u32) -> Variant {
    Variant::of("accumulation").with("samples", views)
}

/// N views and M layers of the paper's method, with its frame rates.
const OURS: [(u32, u32, [f64; 3]); 13] = [
    (8, 8, [102.0, 92.0, 43.0]),
    (8, 12, [82.0, 71.0, 38.0]),
    (8, 16, [70.0, 60.0, 34.0]),
    (16, 8, [77.0, 72.0, 38.0]),
    (16, 12, [67.0, 57.0, 34.0]),
    (16, 16, [56.0, 49.0, 31.0]),
    (32, 8, [62.0, 53.0, 32.0]),
    (32, 12, [48.0, 42.0, 28.0]),
    (32, 16, [40.0, 36.0, 25.0]),
    (64, 8, [38.0, 34.0, 24.0]),
    (64, 12, [30.0, 27.0, 21.0]),
    (64, 16, [26.0, 24.0, 19.0]),
    (256, 16, [9.0, 8.0, 8.0]),
];

fn rows() -> Vec<Row> {
    let mut rows = vec![
        row("gather (mipmap)", Variant::published("mipmap"), [223.0, 175.0, 59.0]),
        row(
            "multilayer, 12 layers (pyramid)",
            Variant::published("pyramid").with("sub_images", 12),
            [38.0, 37.0, 26.0],
        ),
        row("reference, 8 views", accumulation(8), [144.0, 59.0, 9.0]),
        row("reference, 16 views", accumulation(16), [75.0, 29.0, 4.0]),
        row("reference, 32 views", accumulation(32), [40.0, 14.0, 2.0]),
        row("reference, 64 views", accumulation(64), [21.0, 7.0, 1.0]),
    ];
    let ours = |(views, layers, fps): &(u32, u32, [f64; 3])| {
        row(&format!("multiview, {views} views, {layers} layers"), multiview(*views, *layers), *fps)
    };
    rows.extend(OURS.iter().map(ours));
    rows
}

/// Whether a quick run has the row: those that the claims are about, and what they compare
/// with.
fn is_quick(row: &Row) -> bool {
    let ours = [(8, 8), (32, 8), (32, 16)].map(|(views, layers)| multiview(views, layers));
    !row.name.contains("views") || row.variant == accumulation(32) || ours.contains(&row.variant)
}

pub(super) fn plan(quick: bool) -> Plan {
    let size = if quick { [200, 150] } else { [800, 600] };
    let variants = rows().iter().filter(|row| !quick || is_quick(row)).map(|row| row.variant.clone()).collect();
    let whole = super::plan(&SCENES, size, vec![BLUR], variants);
    let whole = Plan { redraw: true, ..whole };
    if quick { Plan { reference_samples: None, runs: 3, ..whole } } else { whole }
}

pub(super) fn compared(results: &BenchResults) -> Comparison {
    let triangles = |scene: &str| {
        results.cell(scene, BLUR).map_or(String::new(), |c| format!(" ({} k triangles)", c.scene_triangles / 1000))
    };
    let mut columns = owned(["method", "paper, fps: Toys 67 k, Dinosaurs 300 k, Angels 1.76 M"]);
    columns.extend(SCENES.iter().map(|scene| format!("{scene}{}", triangles(scene))));
    let table_row = |row: &Row| {
        let mut cells = vec![row.name.clone(), row.fps.map(|f| f.to_string()).join(" / ")];
        let label = row.variant.label();
        cells.extend(SCENES.iter().map(|scene| time_text(results.cell(scene, BLUR), &label)));
        cells
    };
    Comparison {
        title: "SIGGRAPH Asia 2009, Table 1: views, layers and triangles".into(),
        setting: format!(
            "{}, mean CoC 16 px, everything drawn anew for each run. mirrors, cans and atrium stand in for the paper's scenes.",
            setting(results)
        ),
        columns,
        rows: rows().iter().map(table_row).collect(),
        claims: claims(results),
        notes: vec![
            "Times here contain drawing the scene, as the paper's frame rates do; in brackets, multiples of a copy of the image.".into(),
            drawing(results),
            "The column heads of the paper's table were put together again from its text, which lists the columns out of order: rates fall with views and with layers everywhere.".into(),
            "The multilayer method of the paper is Kraus and Strengert's; pyramid here has 12 sub-images at most, and fewer where the CoCs in view ask for fewer.".into(),
        ],
    }
}

/// What of the paper's method is drawing the scene.
fn drawing(results: &BenchResults) -> String {
    let of = |scene: &&str| {
        let (cell, label) = (results.cell(scene, BLUR), multiview(32, 8).label());
        let (slabs, all) = (part_ratio(cell, &label, &["/slab "])?, ratio(cell, &label)?);
        let view = ratio(cell, &accumulation(32).label())? / 32.0;
        Some(format!("{scene}: {slabs:.0} of {all:.0} copies are drawing its 8 slabs, where one view takes {view:.0}"))
    };
    let found: Vec<String> = SCENES.iter().filter_map(of).collect();
    format!("multiview with 32 views and 8 layers. {}.", found.join(". "))
}

fn claims(results: &BenchResults) -> Vec<Claim> {
    let times = |scene: &str, a: &Variant, b: &Variant| {
        let cell = results.cell(scene, BLUR);
        Some(ratio(cell, &a.label())? / ratio(cell, &b.label())?)
    };
    let reference_over_ours = SCENES.map(|scene| times(scene, &accumulation(32), &multiview(32, 8)));
    let views = times("cans", &multiview(32, 8), &multiview(8, 8));
    let layers = times("cans", &multiview(32, 16), &multiview(32, 8));
    let list = reference_over_ours.map(|t| cell_text(t, 2)).join(", ");
    let grows = |values: [Option<f64>; 3]| {
        let [small, middling, large] = [values[0]?, values[1]?, values[2]?];
        Some(small < middling && middling < large)
    };
    vec![
        Claim::new(
            "32 views, 8 layers: against the reference 1.6, 3.8 and 16 times as fast, more with every triangle",
            format!("reference over multiview: {list}"),
            grows(reference_over_ours),
            "Drawing the slabs is most of multiview's time here (see the notes), and on a CPU a view takes the longer the more pixels its triangles cover: what is gained is close to the number of views over that of slabs, whatever the triangles.",
        ),
        Claim::new(
            "From 8 to 32 views (8 layers, Dinosaurs) the time grows 1.74 times: much less than the views",
            format!("{} times, on cans", cell_text(views, 2)),
            views.map(|v| v < 4.0),
            "Tracing is more of the time here than drawing; the notes have its share.",
        ),
        Claim::new(
            "From 8 to 16 layers (32 views, Dinosaurs) the time grows 1.47 times",
            format!("{} times, on cans", cell_text(layers, 2)),
            layers.map(|l| (1.0..2.0).contains(&l)),
            "Every slab is drawn on its own, which is most of the time here (see the notes).",
        ),
    ]
}
