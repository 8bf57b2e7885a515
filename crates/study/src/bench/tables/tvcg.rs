//! Lee, Kim and Choi, "Real-Time Depth-of-Field Rendering Using Anisotropically Filtered
//! Mipmap Interpolation" (TVCG 2009), section 7.2: Fig. 14 and Table 1.

use super::super::plan::{Blur, MEAN_COCS_PX, Plan, Variant};
use super::super::results::{BenchResults, CellResult};
use super::{Claim, Comparison, cell_text, geometric_mean, owned, part_ratio, plan, ratio, setting, time_text};

/// The paper's four methods: ours, its reference 23, 8 and 27.
const METHODS: [&str; 4] = ["mipmap", "separable", "preblur", "pyramid"];

/// The paper's scenes "Forest", "Cans", "Elephants" and "Sponza Atrium", and what stands in
/// for them.
const SCENES: [&str; 4] = ["forest", "cans", "herd", "atrium"];

/// Where the table says what the time buys.
const QUALITY_AT: Blur = Blur::MeanCocPx(16.0);

pub(super) fn fig14_plan(quick: bool) -> Plan {
    let blurs = MEAN_COCS_PX.map(Blur::MeanCocPx).to_vec();
    let size = if quick { [256, 192] } else { [1024, 768] };
    let whole = plan(&SCENES, size, blurs, METHODS.map(Variant::published).to_vec());
    let whole = Plan { reference_only_at: Some(QUALITY_AT), ..whole };
    if quick { Plan { reference_samples: Some(32), runs: 5, ..whole } } else { whole }
}

pub(super) fn fig14(results: &BenchResults) -> Comparison {
    let blurs = &results.plan.blurs;
    let mut columns = owned(["scene", "method"]);
    columns.extend(blurs.iter().map(|blur| format!("C = {} px", blur.px())));
    columns.push("PSNR at 16 px".into());
    let mut rows = Vec::new();
    for scene in &results.plan.scenes {
        for method in METHODS {
            let mut row = vec![scene.clone(), method.to_owned()];
            row.extend(blurs.iter().map(|blur| time_text(results.cell(scene, *blur), method)));
            let at_16 = results.cell(scene, QUALITY_AT).and_then(|c| c.variant(method));
            row.push(cell_text(at_16.and_then(|v| v.metrics.psnr_db), 2));
            rows.push(row);
        }
    }
    Comparison {
        title: "TVCG 2009, Fig. 14: time of four methods over the mean CoC".into(),
        setting: format!(
            "{}. Built-in scenes stand in for the paper's: forest (a picture with depth, without a reference), cans, herd for Elephants, atrium for Sponza.",
            setting(results)
        ),
        columns,
        rows,
        claims: fig14_claims(results),
        notes: vec![
            "The paper gives frame rates on a GeForce 8800 GTX at 1024x768, drawing the scene included, and only as bars. Times here are of the blur alone; in brackets as multiples of a copy of the same image in the same runs.".into(),
            "Methods are as published, with no margin around the image, as in the paper. The program's own margin (--overscan) is half the greatest CoC: methods that build pyramids reduce it too.".into(),
        ],
    }
}

/// Geometric mean over the scenes of what `of` says of each, for each blur that has any.
fn by_blur(results: &BenchResults, of: impl Fn(&CellResult) -> Option<f64>) -> Vec<f64> {
    let at = |blur: &Blur| geometric_mean(results.cells.iter().filter(|c| c.cell.blur == *blur).filter_map(&of));
    results.plan.blurs.iter().filter_map(at).collect()
}

/// Greatest over least of a course over the CoC, which takes more than one of them.
fn spread(ratios: &[f64]) -> Option<f64> {
    let [low, high] = ratios.iter().fold([f64::INFINITY, 0.0], |[l, h], r| [f64::min(l, *r), f64::max(h, *r)]);
    (ratios.len() > 1 && low > 0.0).then_some(high / low)
}

fn fig14_claims(results: &BenchResults) -> Vec<Claim> {
    let over_all = |m| geometric_mean(results.cells.iter().filter_map(|c| ratio(Some(c), m)));
    let [ours, zhou, scheuermann, kraus] = METHODS.map(over_all);
    let quotient = |a: Option<f64>, b: Option<f64>| a.zip(b).map(|(a, b)| a / b);
    let zhou_over_ours = by_blur(results, |c| quotient(ratio(Some(c), METHODS[1]), ratio(Some(c), METHODS[0])));
    let zhou_by_coc = by_blur(results, |c| ratio(Some(c), METHODS[1]));
    let times = |value: Option<f64>| cell_text(value, 2);
    let ends = |course: &[f64]| (course.len() > 1).then(|| (course[0], course[course.len() - 1]));
    vec![
        Claim::new(
            "Scheuermann's method (preblur) is the fastest, owing to its simplicity",
            format!("preblur {}x a copy, mipmap {}x, on the average over all cells", times(scheuermann), times(ours)),
            scheuermann.zip(ours).map(|(s, o)| s < o),
            "Its reads are as many as the mipmap's (tvcg-table1 counts them), depth being a texture of its own.",
        ),
        independence(results),
        Claim::new(
            "Kraus and Strengert's (pyramid) is the slowest: under 30 frames a second against more than 90 of ours",
            format!("pyramid over mipmap {}", times(quotient(kraus, ours))),
            quotient(kraus, ours).map(|q| q > 3.0),
            "Sub-images without content are passed over here, so that the time follows the depths in view.",
        ),
        Claim::new(
            "Zhou et al.'s (separable) is faster than ours for small CoCs and slower for large ones",
            format!(
                "separable over mipmap {} at the least CoC, {} at the greatest",
                times(zhou_over_ours.first().copied()),
                times(zhou_over_ours.last().copied())
            ),
            ends(&zhou_over_ours).map(|(least, greatest)| least < 1.0 && greatest > 1.0),
            "The two cross beyond the CoCs that were measured.",
        ),
        Claim::new(
            "Zhou et al.'s time grows with the CoC",
            format!("separable, slowest over fastest {}", times(spread(&zhou_by_coc))),
            ends(&zhou_by_coc).map(|(least, greatest)| greatest > 1.5 * least),
            "Filters that are wider than the image end at its border.",
        ),
        Claim::new(
            "Ours ranks second, behind Scheuermann's and before Zhou et al.'s on the average and Kraus and Strengert's",
            format!(
                "copies on the average: preblur {}, mipmap {}, separable {}, pyramid {}",
                times(scheuermann),
                times(ours),
                times(zhou),
                times(kraus)
            ),
            scheuermann.zip(ours).zip(zhou.zip(kraus)).map(|((s, o), (z, k))| s < o && o < z && o < k),
            "The average is over CoCs from 4 to 128 px, of which the separable filter is faster for the small ones.",
        ),
    ]
}

/// What the passes of mipmap are called that build its levels, and not one for each pixel of
/// the image.
const LEVELS: [&str; 2] = ["level", "_image"];

/// That mipmap's time does not depend on the CoC, and which of its passes do.
fn independence(results: &BenchResults) -> Claim {
    let ours = METHODS[0];
    let whole = spread(&by_blur(results, |c| ratio(Some(c), ours)));
    let levels = by_blur(results, |c| part_ratio(Some(c), ours, &LEVELS));
    let rest = by_blur(results, |c| Some(ratio(Some(c), ours)? - part_ratio(Some(c), ours, &LEVELS)?));
    let ends = [levels.first(), levels.last()].map(|r| cell_text(r.copied(), 1));
    Claim::new(
        "Ours (mipmap) is independent of the CoC",
        format!(
            "mean CoC 4 to 128 px: slowest over fastest {}; without building the levels {}",
            cell_text(whole, 2),
            cell_text(spread(&rest), 2)
        ),
        whole.map(|s| s < 1.15),
        &format!(
            "The image is padded to whole texels of the coarsest level, which grow with the CoC: the levels take {} copies to build at the least CoC and {} at the greatest.",
            ends[0], ends[1]
        ),
    )
}

/// The paper's Table 1, greatest CoC 16 px: units of a look-up a pixel, and what it counts.
const LOOK_UPS: [(&str, f64, &str); 4] = [
    ("mipmap", 20.98, "2 x 9 (1/4 + 1/16 + 1/64 + 1/256) for the mipmaps, 6 for the DoB, 9 for the interpolation"),
    ("preblur", 24.04, "9/256 for the copy, 12 + 12 for the gathering"),
    ("separable", 27.00, "9 across, 2 x 9 down, for a mean CoC radius of 4 px"),
    ("pyramid", 173.02, "8 sub-images: culling 8, analyses 53.1, syntheses 95.6, matting 8, blending 8"),
];

/// Steps that are switched off one at a time, to see what they read: method, parameter, and
/// what it is.
const STEPS: [(&str, &str, &str); 3] = [
    ("mipmap", "smoothing", "without the smoothing of the foreground's DoB (section 5)"),
    ("mipmap", "anisotropic", "without the weights of equation (9)"),
    ("preblur", "leak_test", "without comparing the taps' depths with the centre's"),
];

fn without((method, step, _): &(&str, &str, &str)) -> Variant {
    Variant::published(method).with(step, "off")
}

const TABLE1_AT: Blur = Blur::GreatestCocPx(16.0);

pub(super) fn table1_plan(quick: bool) -> Plan {
    let mut variants = LOOK_UPS.map(|(method, ..)| Variant::published(method)).to_vec();
    variants.extend(STEPS.iter().map(without));
    let size = if quick { [256, 256] } else { [1024, 1024] };
    let whole = plan(&["cans", "atrium"], size, vec![TABLE1_AT], variants);
    Plan { reference_samples: None, count_reads: true, runs: if quick { 5 } else { 9 }, ..whole }
}

pub(super) fn table1(results: &BenchResults) -> Comparison {
    let mut columns = owned(["method", "paper, look-ups a pixel", "what the paper counts"]);
    columns.extend(results.plan.scenes.iter().map(|scene| format!("{scene}, counted")));
    let counted = |scene: &str, label: &str| results.cell(scene, TABLE1_AT)?.variant(label)?.reads_per_px;
    let row = |label: String, paper: String, what: &str| {
        let counts = results.plan.scenes.iter().map(|scene| cell_text(counted(scene, &label), 2));
        [label.clone(), paper, what.to_owned()].into_iter().chain(counts).collect::<Vec<_>>()
    };
    let mut rows: Vec<_> =
        LOOK_UPS.iter().map(|(method, paper, what)| row((*method).into(), format!("{paper:.2}"), what)).collect();
    rows.extend(STEPS.iter().map(|step| row(without(step).label(), "–".into(), step.2)));
    let mean = |label: &str| geometric_mean(results.plan.scenes.iter().filter_map(|s| counted(s, label)));
    let order: Option<Vec<f64>> = LOOK_UPS.iter().map(|(method, ..)| mean(method)).collect();
    let holds = order.as_ref().map(|o| o[0] < o[1] && o[1] < o[2] && o[2] < o[3]);
    let measured: Vec<String> = LOOK_UPS.iter().map(|(m, ..)| format!("{m} {}", cell_text(mean(m), 2))).collect();
    let saved = |step: &(&str, &str, &str)| {
        cell_text(mean(step.0).zip(mean(&without(step).label())).map(|(with, without)| with - without), 1)
    };
    let [smoothing, weights, leak_test] = STEPS.each_ref().map(saved);
    let claim = Claim::new(
        "Ours reads least: 20.98 against 24.04, 27.00 and 173.02",
        measured.join(", "),
        holds,
        &format!(
            "Switched off one at a time, of mipmap's reads {smoothing} go to the smoothing, for which the paper counts 6, and {weights} to the weights; of preblur's, {leak_test} go to the comparison of depths. separable reads as far as each pixel's own CoC, the paper as far as the mean."
        ),
    );
    Comparison {
        title: "TVCG 2009, Table 1: texture look-ups a pixel".into(),
        setting: format!(
            "{}. Shaders count every read as they run (a filtered read is one), drawing the scene not included; greatest CoC 16 px.",
            setting(results)
        ),
        columns,
        rows,
        claims: vec![claim],
        notes: vec![
            "The paper's figures follow from the programs' structure: colour and depth come in one texture with depth as its alpha channel. Here depth is a texture of its own, of 32 bits, and is counted: each of preblur's twelve taps reads the colour, the copy, and the depth for its blurriness.".into(),
            "pyramid: sub-images without content are passed over, and coarse levels are summed to the end where the paper stops at 1/16.".into(),
        ],
    }
}
