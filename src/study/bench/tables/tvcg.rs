//! Lee, Kim and Choi, "Real-Time Depth-of-Field Rendering Using Anisotropically Filtered
//! Mipmap Interpolation" (TVCG 2009), section 7.2: Fig. 14 and Table 1.

use super::super::plan::{Blur, MEAN_COCS_PX, Plan, Variant};
use super::super::results::BenchResults;
use super::{Claim, Comparison, cell_text, geometric_mean, owned, plan, ratio, setting, time_text};

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
    let whole = plan(&SCENES, size, blurs, METHODS.map(Variant::of).to_vec());
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
            "Small images on a CPU renderer make fixed costs of a pass weigh more than they do at 1024x768.".into(),
        ],
    }
}

/// Geometric mean of a method's multiples of the copy over the cells with a blur.
fn at_blur(results: &BenchResults, method: &str, blur: Blur) -> Option<f64> {
    let cells = results.cells.iter().filter(|c| c.cell.blur == blur);
    geometric_mean(cells.filter_map(|c| ratio(Some(c), method)))
}

fn over_all(results: &BenchResults, method: &str) -> Option<f64> {
    geometric_mean(results.cells.iter().filter_map(|c| ratio(Some(c), method)))
}

fn fig14_claims(results: &BenchResults) -> Vec<Claim> {
    let [ours, zhou, scheuermann, kraus] = METHODS.map(|m| over_all(results, m));
    // A course over the CoC takes more than one of them.
    let by_coc = |method| -> Vec<f64> {
        let ratios: Vec<f64> = results.plan.blurs.iter().filter_map(|b| at_blur(results, method, *b)).collect();
        if ratios.len() > 1 { ratios } else { Vec::new() }
    };
    let spread = |ratios: &[f64]| {
        let [low, high] = ratios.iter().fold([f64::INFINITY, 0.0], |[l, h], r| [f64::min(l, *r), f64::max(h, *r)]);
        (!ratios.is_empty()).then_some(high / low)
    };
    let (ours_by_coc, zhou_by_coc) = (by_coc(METHODS[0]), by_coc(METHODS[1]));
    let times = |value: Option<f64>| cell_text(value, 2);
    let quotient = |a: Option<f64>, b: Option<f64>| a.zip(b).map(|(a, b)| a / b);
    let crossing = zhou_by_coc.first().zip(ours_by_coc.first()).zip(zhou_by_coc.last().zip(ours_by_coc.last()));
    vec![
        Claim::new(
            "Scheuermann's method (preblur) is the fastest, owing to its simplicity",
            format!("preblur {}x a copy, mipmap {}x, on the average over all cells", times(scheuermann), times(ours)),
            scheuermann.zip(ours).map(|(s, o)| s < o),
            "Without texture units each of preblur's 24 reads a pixel costs as much as one of the mipmap's 20, most of which lie in small, cached levels.",
        ),
        Claim::new(
            "Ours (mipmap) is independent of the CoC",
            format!("mean CoC 4 to 128 px: slowest over fastest {}", times(spread(&ours_by_coc))),
            spread(&ours_by_coc).map(|s| s < 1.15),
            "Deeper pyramids need a few more small passes, which weigh the more the smaller the image is.",
        ),
        Claim::new(
            "Kraus and Strengert's (pyramid) is the slowest: under 30 frames a second against more than 90 of ours",
            format!("pyramid over mipmap {}", times(quotient(kraus, ours))),
            quotient(kraus, ours).map(|q| q > 3.0),
            "Empty sub-images are skipped here, so that the pyramid's cost follows the depths in view.",
        ),
        Claim::new(
            "Zhou et al.'s (separable) is faster than ours for small CoCs and slower for large ones",
            format!(
                "separable over mipmap {} at the least CoC, {} at the greatest",
                times(crossing.map(|((z, o), _)| z / o)),
                times(crossing.map(|(_, (z, o))| z / o))
            ),
            crossing.map(|((z0, o0), (z1, o1))| z0 < o0 && z1 > o1),
            "At a mean CoC of 4 px the greatest is several times that, and rows of taps cost with the greatest.",
        ),
        Claim::new(
            "Zhou et al.'s time grows with the CoC",
            format!("separable, slowest over fastest {}", times(spread(&zhou_by_coc))),
            quotient(zhou_by_coc.last().copied(), zhou_by_coc.first().copied()).map(|q| q > 1.5),
            "Images only a few CoCs wide end before the filter does.",
        ),
        Claim::new(
            "Ours and Zhou et al.'s are of one order of magnitude over all CoCs",
            format!("separable over mipmap, on the average {}", times(quotient(zhou, ours))),
            quotient(zhou, ours).map(|q| (0.1..10.0).contains(&q)),
            "The greatest CoC in view decides what the separable filter costs.",
        ),
    ]
}

/// The paper's Table 1, greatest CoC 16 px: units of a look-up a pixel, and what it counts.
const LOOK_UPS: [(&str, f64, &str); 4] = [
    ("mipmap", 20.98, "2 x 9 (1/4 + 1/16 + 1/64 + 1/256) for the mipmaps, 6 for the DoB, 9 for the interpolation"),
    ("preblur", 24.04, "9/256 for the copy, 12 + 12 for the gathering"),
    ("separable", 27.00, "9 across, 2 x 9 down, for a mean CoC radius of 4 px"),
    ("pyramid", 173.02, "8 sub-images: culling 8, analyses 53.1, syntheses 95.6, matting 8, blending 8"),
];

pub(super) fn table1_plan(quick: bool) -> Plan {
    let variants = LOOK_UPS.map(|(method, ..)| Variant::of(method)).to_vec();
    let size = if quick { [256, 256] } else { [1024, 1024] };
    let whole = plan(&["cans", "atrium"], size, vec![Blur::GreatestCocPx(16.0)], variants);
    Plan { reference_samples: None, count_reads: true, runs: if quick { 5 } else { 9 }, ..whole }
}

pub(super) fn table1(results: &BenchResults) -> Comparison {
    let mut columns = owned(["method", "paper, look-ups a pixel", "what the paper counts"]);
    columns.extend(results.plan.scenes.iter().map(|scene| format!("{scene}, counted")));
    let blur = Blur::GreatestCocPx(16.0);
    let counted = |scene: &str, method: &str| results.cell(scene, blur)?.variant(method)?.reads_per_px;
    let row = |(method, paper, what): &(&str, f64, &str)| {
        let mut row = vec![(*method).to_owned(), format!("{paper:.2}"), (*what).to_owned()];
        row.extend(results.plan.scenes.iter().map(|scene| cell_text(counted(scene, method), 2)));
        row
    };
    let mean = |method| geometric_mean(results.plan.scenes.iter().filter_map(|s| counted(s, method)));
    let order: Option<Vec<f64>> = LOOK_UPS.iter().map(|(method, ..)| mean(method)).collect();
    let holds = order.as_ref().map(|o| o[0] < o[1] && o[1] < o[2] && o[2] < o[3]);
    let measured: Vec<String> = LOOK_UPS.iter().map(|(m, ..)| format!("{m} {}", cell_text(mean(m), 2))).collect();
    let claim = Claim::new(
        "Ours reads least: 20.98 against 24.04, 27.00 and 173.02",
        measured.join(", "),
        holds,
        "The paper counts a read of colour and depth as one and two levels of a mipmap as one; separable reads as far as the CoC of each pixel, not of the mean.",
    );
    Comparison {
        title: "TVCG 2009, Table 1: texture look-ups a pixel".into(),
        setting: format!(
            "{}. Shaders count every read as they run (a filtered read is one), drawing the scene not included; greatest CoC 16 px.",
            setting(results)
        ),
        columns,
        rows: LOOK_UPS.iter().map(row).collect(),
        claims: vec![claim],
        notes: vec![
            "The paper's figures follow from the programs' structure: colour and depth come in one texture with depth as its alpha channel, and one trilinear read serves two levels. Here colour and depth are two textures, depth being 32 bits, so a tap that needs both reads twice.".into(),
            "mipmap: colour and blur levels are reduced from 4x4 texels read one by one (2 x 16 a texel, less what is shared), where the paper counts 9; the final 9 taps read two levels apart in order to blend them after equation (8).".into(),
            "separable: taps are taken as far as the pixel's own CoC asks for, so pixels in focus read little.".into(),
            "pyramid: sub-images without content are skipped, and coarse levels are summed to the end where the paper stops at 1/16.".into(),
        ],
    }
}
