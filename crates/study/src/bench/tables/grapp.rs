//! Kraus, "Using Opaque Image Blur for Real-Time Depth-of-Field Rendering" (GRAPP 2011),
//! section 5.

use super::super::plan::{Blur, Plan, Variant};
use super::super::results::BenchResults;
use super::{Claim, Comparison, cell_text, geometric_mean, owned, ratio, setting, time_text};

const SCENES: [&str; 4] = ["cans", "atrium", "branches", "herd"];
const BLURS: [Blur; 2] = [Blur::MeanCocPx(8.0), Blur::MeanCocPx(16.0)];

/// How many times faster the paper finds the opaque image blur.
const PAPER_SPEED: f64 = 1.9;

/// How far from the paper's figure a quotient of two times still agrees with it: a fifth either
/// way, as the cells of one run of this table differ by up to that.
const AGREES: std::ops::Range<f64> = PAPER_SPEED / 1.2..PAPER_SPEED * 1.2;

pub(super) fn plan(quick: bool) -> Plan {
    let size = if quick { [256, 192] } else { [1024, 768] };
    let variants = ["opaque", "pyramid"].map(Variant::published).to_vec();
    let whole = super::plan(&SCENES, size, BLURS.to_vec(), variants);
    if quick { Plan { reference_samples: Some(32), runs: 5, ..whole } } else { whole }
}

pub(super) fn compared(results: &BenchResults) -> Comparison {
    let speed = |scene: &str, blur| {
        let cell = results.cell(scene, blur);
        Some(ratio(cell, "pyramid")? / ratio(cell, "opaque")?)
    };
    let mut rows = Vec::new();
    for scene in SCENES {
        for blur in BLURS {
            let cell = results.cell(scene, blur);
            let psnr = |label: &str| cell_text(cell.and_then(|c| c.variant(label)?.metrics.psnr_db), 2);
            rows.push(vec![
                scene.to_owned(),
                format!("{}", blur.px()),
                time_text(cell, "opaque"),
                time_text(cell, "pyramid"),
                cell_text(speed(scene, blur), 2),
                psnr("opaque"),
                psnr("pyramid"),
            ]);
        }
    }
    let all = SCENES.iter().flat_map(|scene| BLURS.map(|blur| speed(scene, blur))).flatten();
    let mean = geometric_mean(all);
    Comparison {
        title: "GRAPP 2011, section 5: the opaque image blur against the pyramidal one".into(),
        setting: setting(results),
        columns: owned(["scene", "mean CoC, px", "opaque", "pyramid", "speed", "opaque, PSNR dB", "pyramid, PSNR dB"]),
        rows,
        claims: vec![Claim::new(
            "1.9 times as fast as Kraus and Strengert's method",
            format!("{} times on the average", cell_text(mean, 2)),
            mean.map(|m| AGREES.contains(&m)),
            "Both share every step but one, and skip what is empty, so the difference is that step alone: filling what is culled against a second pyramid of opacity.",
        )],
        notes: vec![
            "The paper names one figure, on a GeForce 320M, with copies in both programs that it says could be avoided.".into(),
        ],
    }
}
