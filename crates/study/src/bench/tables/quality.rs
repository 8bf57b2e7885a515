//! The papers' figures that compare pictures: what each says in dB and SSIM, or in words,
//! beside what is measured here, every method as published. Verdicts are about sentences that
//! the papers have.

use super::super::plan::{Blur, Plan, Variant};
use super::super::results::{BenchResults, VariantResult};
use super::{Claim, Comparison, cell_text, setting};
use defocus::view::Input;

/// A figure.
pub(super) struct Figure {
    /// On the command line.
    pub(super) name: &'static str,
    title: &'static str,
    /// The scene that stands in for the paper's.
    scenes: &'static [&'static str],
    mean_cocs_px: &'static [f64],
    /// Size, px, without `--quick`.
    size: [u32; 2],
    /// Whether the reference shades from each point of the lens.
    view_dependent: bool,
    /// What methods are given of the light.
    input: Input,
    rows: &'static [Row],
    claims: &'static [Verdict],
    notes: &'static [&'static str],
}

/// A method of a figure.
struct Row {
    name: &'static str,
    method: &'static str,
    settings: &'static [(&'static str, &'static str)],
    /// The paper's PSNR, dB, and SSIM.
    paper: [Option<f64>; 2],
}

/// A sentence of the paper, or the part of one that can be measured.
struct Verdict {
    /// In the paper's words.
    quote: &'static str,
    says: Says,
    by: Measure,
    /// Why it does not hold here, where it is known not to.
    reason: &'static str,
}

/// What a sentence says of rows.
enum Says {
    /// Each is at least as good as the next.
    Order(&'static [usize]),
    /// The first is at least as good as each of the others.
    First(&'static [usize]),
    /// The first falls behind the second by less than this.
    Near([usize; 2], f64),
    /// A row has at least this where the mean CoC is no greater than so many px.
    AtLeast { row: usize, least: f64, up_to_px: f64 },
}

impl Says {
    /// Rows whose values [`Says::holds`] takes.
    fn rows(&self) -> &[usize] {
        match self {
            Self::Order(rows) | Self::First(rows) => rows,
            Self::Near(rows, _) => rows,
            Self::AtLeast { row, .. } => std::slice::from_ref(row),
        }
    }

    fn holds(&self, values: &[f64]) -> bool {
        match self {
            Self::Order(_) => values.is_sorted_by(|a, b| a >= b),
            Self::First(_) => values.iter().all(|v| values[0] >= *v),
            Self::Near(_, by) => values[1] - values[0] < *by,
            Self::AtLeast { least, .. } => values[0] >= *least,
        }
    }

    /// Whether it says anything about a mean CoC.
    fn is_about(&self, mean_coc_px: f64) -> bool {
        match self {
            Self::AtLeast { up_to_px, .. } => mean_coc_px <= *up_to_px,
            _ => true,
        }
    }
}

/// What "better" means: more of this.
#[derive(Clone, Copy)]
enum Measure {
    Psnr,
    Ssim,
    Jod,
}

impl Measure {
    fn of(self, variant: &VariantResult) -> Option<f64> {
        match self {
            Self::Psnr => variant.metrics.psnr_db,
            Self::Ssim => variant.metrics.ssim,
            Self::Jod => variant.metrics.jod,
        }
    }
}

const fn row(name: &'static str, method: &'static str, paper: [Option<f64>; 2]) -> Row {
    Row { name, method, settings: &[], paper }
}

const fn set(
    name: &'static str,
    method: &'static str,
    settings: &'static [(&'static str, &'static str)],
    paper: [Option<f64>; 2],
) -> Row {
    Row { name, method, settings, paper }
}

const UNKNOWN: [Option<f64>; 2] = [None, None];

const fn db(psnr: f64) -> [Option<f64>; 2] {
    [Some(psnr), None]
}

const fn both(psnr: f64, ssim: f64) -> [Option<f64>; 2] {
    [Some(psnr), Some(ssim)]
}

/// TVCG, Fig. 11 and 12: ours, Kraus, Zhou, Scheuermann.
const fn tvcg_rows(paper: [f64; 4]) -> [Row; 4] {
    [
        row("ours (mipmap)", "mipmap", db(paper[0])),
        row("Kraus and Strengert (pyramid)", "pyramid", db(paper[1])),
        row("Zhou et al. (separable)", "separable", db(paper[2])),
        row("Scheuermann (preblur)", "preblur", db(paper[3])),
    ]
}

const TVCG_11: [Row; 4] = tvcg_rows([37.66, 25.89, 31.65, 25.50]);
const TVCG_12: [Row; 4] = tvcg_rows([35.41, 24.43, 31.63, 28.66]);

/// TVCG 2009, Fig. 11 and 12: PSNR, dB, of the best among the methods whose artifacts the paper
/// points out. What has no artifacts that stand out is above it.
const BEST_WITH_ARTIFACTS_DB: f64 = 31.65;

/// Pacific Graphics 2008, section 4: the better of the two PSNR, dB, that it calls "rather low".
const RATHER_LOW_DB: f64 = 32.84;

/// A difference of this many JOD is seen by three observers in four.
const SEEN_BY_MOST_JOD: f64 = 1.0;

const OWN_SCENES: &str = "The paper's scenes and lenses are not public: built-in ones stand in, and figures in dB compare methods on one scene, not scenes.";

/// All of them.
pub(super) const FIGURES: [Figure; 15] = [
    Figure {
        name: "tvcg-fig11",
        title: "TVCG 2009, Fig. 11: background blur, the nearest can in focus",
        scenes: &["cans"],
        mean_cocs_px: &[8.0],
        size: [1024, 768],
        view_dependent: false,
        input: Input::Hdr,
        rows: &TVCG_11,
        claims: &[Verdict {
            quote: "Our method created an image most similar to the reference",
            says: Says::First(&[0, 1, 2, 3]),
            by: Measure::Psnr,
            reason: "",
        }],
        notes: &[OWN_SCENES],
    },
    Figure {
        name: "tvcg-fig12",
        title: "TVCG 2009, Fig. 12: foreground blur, the farthest wall in focus",
        scenes: &["atrium"],
        mean_cocs_px: &[8.0],
        size: [1024, 768],
        view_dependent: false,
        input: Input::Hdr,
        rows: &TVCG_12,
        claims: &[Verdict {
            quote: "our method showed better image quality (35.41 dB) than the others",
            says: Says::First(&[0, 1, 2, 3]),
            by: Measure::Psnr,
            reason: "",
        }],
        notes: &[OWN_SCENES],
    },
    Figure {
        name: "tvcg-fig13",
        title: "TVCG 2009, Fig. 13: the appearance of blur as the mean CoC grows",
        scenes: &["atrium"],
        mean_cocs_px: &[4.0, 8.0, 16.0, 32.0],
        size: [512, 384],
        view_dependent: false,
        input: Input::Hdr,
        rows: &[row("ours (mipmap)", "mipmap", UNKNOWN)],
        claims: &[Verdict {
            quote: "is equal to or less than 16 pixels, the artifacts do not stand out",
            says: Says::AtLeast { row: 0, least: BEST_WITH_ARTIFACTS_DB, up_to_px: 16.0 },
            by: Measure::Psnr,
            reason: "With its constants the printed filter blurs wider than the lens, the more the wider the lens is open; calibration=measured does not.",
        }],
        notes: &[
            "The paper gives no numbers: \"when the mean CoC diameter is equal to or less than 16 pixels, the artifacts do not stand out\". A row for each mean CoC says how far the picture is from the reference.",
        ],
    },
    Figure {
        name: "grapp-fig4",
        title: "GRAPP 2011, Fig. 4: the opaque image blur, the pyramidal one and ray tracing",
        scenes: &["cans", "branches"],
        mean_cocs_px: &[8.0],
        size: [512, 384],
        view_dependent: false,
        input: Input::Hdr,
        rows: &[row("Kraus and Strengert (pyramid)", "pyramid", UNKNOWN), row("ours (opaque)", "opaque", UNKNOWN)],
        claims: &[Verdict {
            quote: "our method avoids any disocclusion which results in too opaque objects",
            says: Says::Order(&[1, 0]),
            by: Measure::Psnr,
            reason: "Silhouettes of the opaque blur are too sharp, as the paper says itself.",
        }],
        notes: &[
            "The paper shows pictures and gives no numbers. Its reference is ray traced with pbrt; here accumulation, with which this program's ray tracer agrees (docs/results.md).",
        ],
    },
    Figure {
        name: "pg-fig9",
        title: "Pacific Graphics 2008, Fig. 9: defocused highlights of an LDR image",
        scenes: &["highlights"],
        mean_cocs_px: &[16.0],
        size: [512, 384],
        view_dependent: false,
        input: Input::Clamped { white: 1.0 },
        rows: &[
            row("splatting the LDR image", "splat", UNKNOWN),
            set("expanding its highlights, equation (8)", "splat", &[("highlights", "on")], UNKNOWN),
        ],
        claims: &[Verdict {
            quote: "we can mimic the effect using a common trick that extrapolates intensities of bright areas",
            says: Says::Order(&[1, 0]),
            by: Measure::Psnr,
            reason: "gamma is 2 here and in the paper: lights that were 40 times as bright as white before they were cut are still missing.",
        }],
        notes: &[
            "The paper shows pictures and gives no numbers. Methods are given an image that is cut at white, the reference is cut after its blur. Its left column, tones mapped before the splatting, is `defocus compare highlights --mean-coc 16 --methods splat --input reinhard:0.72`.",
        ],
    },
    Figure {
        name: "pg-fig10",
        title: "Pacific Graphics 2008, Fig. 10: sprites at the original and at reduced resolution",
        scenes: &["herd", "branches"],
        mean_cocs_px: &[8.0],
        size: [512, 384],
        view_dependent: false,
        input: Input::Hdr,
        rows: &[
            row("not accelerated", "splat", UNKNOWN),
            set("accelerated", "splat", &[("accelerate", "on")], UNKNOWN),
        ],
        claims: &[Verdict {
            quote: "little perceptual degradation",
            says: Says::Near([1, 0], SEEN_BY_MOST_JOD),
            by: Measure::Jod,
            reason: "Four pixels that are spread as one lose what is finer than two pixels where C is a little over 4 px.",
        }],
        notes: &[
            "The paper shows which pixels are drawn at which resolution and calls the loss \"little perceptual degradation\": the difference of the two rows is that loss here.",
        ],
    },
    Figure {
        name: "pg-fig11",
        title: "Pacific Graphics 2008, Fig. 11: foreground blur with and without the hidden image",
        scenes: &["atrium"],
        mean_cocs_px: &[16.0],
        size: [512, 384],
        view_dependent: false,
        input: Input::Hdr,
        rows: &[
            row("ours, with the hidden image (splat)", "splat", db(36.33)),
            set("ours, without", "splat", &[("hidden", "off")], db(32.84)),
            row("[ZCP07] (separable)", "separable", db(29.4)),
        ],
        claims: &[Verdict {
            quote: "a reasonably high PSNR (36.33 dB) was achieved",
            says: Says::First(&[0, 1, 2]),
            by: Measure::Psnr,
            reason: "As published the hidden image is added to layers that may be complete without it; hidden_blend=filling does not.",
        }],
        notes: &[OWN_SCENES],
    },
    Figure {
        name: "pg-fig12",
        title: "Pacific Graphics 2008, Fig. 12: thin things that overlap",
        scenes: &["branches", "fence"],
        mean_cocs_px: &[8.0],
        size: [512, 384],
        view_dependent: false,
        input: Input::Hdr,
        rows: &[row("with the hidden image", "splat", UNKNOWN), set("without", "splat", &[("hidden", "off")], UNKNOWN)],
        claims: &[Verdict {
            quote: "Whereas the first two are well represented",
            says: Says::AtLeast { row: 0, least: RATHER_LOW_DB, up_to_px: f64::INFINITY },
            by: Measure::Psnr,
            reason: "More than two surfaces lie behind one another here.",
        }],
        notes: &[
            "The paper shows a scene focused on its near, middle and far objects, and finds small artifacts in the third case, where several surfaces in front of a focused one lie behind each other. Built-in scenes have one focus each: --scenes with `defocus compare --focus` shows others.",
        ],
    },
    Figure {
        name: "pg-fig13",
        title: "Pacific Graphics 2008, Fig. 13: long objects on per-pixel layers",
        scenes: &["handrail"],
        mean_cocs_px: &[8.0],
        size: [512, 384],
        view_dependent: false,
        input: Input::Hdr,
        rows: &[
            row("per-pixel layers (splat)", "splat", UNKNOWN),
            row("global layers of Kraus and Strengert (pyramid)", "pyramid", UNKNOWN),
        ],
        claims: &[Verdict {
            quote: "the discretization artifact is not observed in the figure",
            says: Says::Order(&[0, 1]),
            by: Measure::Psnr,
            reason: "",
        }],
        notes: &["The paper's global layers are those of [BBGK02]; the sub-images of pyramid stand in for them."],
    },
    Figure {
        name: "siga-fig6",
        title: "SIGGRAPH Asia 2009, Fig. 6: with and without cones",
        scenes: &["cans"],
        mean_cocs_px: &[16.0],
        size: [400, 300],
        view_dependent: false,
        input: Input::Hdr,
        rows: &[
            set("1 view, rays", "multiview", &[("samples", "1"), ("cones", "off")], UNKNOWN),
            set("1 view, cones", "multiview", &[("samples", "1")], UNKNOWN),
            set("8 views, rays", "multiview", &[("samples", "8"), ("cones", "off")], UNKNOWN),
            set("8 views, cones", "multiview", &[("samples", "8")], UNKNOWN),
            set("16 views, rays", "multiview", &[("samples", "16"), ("cones", "off")], UNKNOWN),
            set("16 views, cones", "multiview", &[("samples", "16")], UNKNOWN),
            set("32 views, rays", "multiview", &[("samples", "32"), ("cones", "off")], UNKNOWN),
            set("32 views, cones", "multiview", &[("samples", "32")], UNKNOWN),
        ],
        claims: &[
            Verdict {
                quote: "it quickly removes the fine grain",
                says: Says::Order(&[1, 0]),
                by: Measure::Psnr,
                reason: "",
            },
            Verdict {
                quote: "it quickly removes the fine grain",
                says: Says::Order(&[3, 2]),
                by: Measure::Psnr,
                reason: "",
            },
            Verdict {
                quote: "it quickly removes the fine grain",
                says: Says::Order(&[5, 4]),
                by: Measure::Psnr,
                reason: "",
            },
            Verdict {
                quote: "approaches the reference with many samples",
                says: Says::Order(&[7, 5, 3, 1]),
                by: Measure::Psnr,
                reason: "",
            },
        ],
        notes: &["The paper shows pictures and gives no numbers."],
    },
    Figure {
        name: "siga-fig7",
        title: "SIGGRAPH Asia 2009, Fig. 7: jittered lens points",
        scenes: &["branches"],
        mean_cocs_px: &[16.0],
        size: [400, 300],
        view_dependent: false,
        input: Input::Hdr,
        rows: &[
            set("32 points, fixed", "multiview", &[("jitter", "off")], UNKNOWN),
            set("32 points, jittered", "multiview", &[], UNKNOWN),
            set("64 points, fixed", "multiview", &[("samples", "64"), ("jitter", "off")], UNKNOWN),
        ],
        claims: &[
            Verdict {
                quote: "approaches and even exceeds the quality of 64 samples to some extent",
                says: Says::Order(&[1, 2]),
                by: Measure::Psnr,
                reason: "A fixed set errs in the same way in all pixels, which looks worse than noise and measures better: PSNR does not tell ghosts from grain, and noise of independent pixels is the greater error.",
            },
            Verdict {
                quote: "trading these artifacts for less objectionable noise",
                says: Says::Order(&[1, 0]),
                by: Measure::Jod,
                reason: "JOD weighs grain of single pixels, which a display of few pixels per degree shows, more than faint ghosts.",
            },
        ],
        notes: &["The paper shows pictures and gives no numbers."],
    },
    Figure {
        name: "siga-fig8",
        title: "SIGGRAPH Asia 2009, Fig. 8: strong foreground blur",
        scenes: &["atrium"],
        mean_cocs_px: &[16.0],
        size: [400, 300],
        view_dependent: false,
        input: Input::Hdr,
        rows: &[
            row("ours (multiview)", "multiview", both(30.84, 0.97)),
            row("multilayer, Kraus and Strengert (pyramid)", "pyramid", both(22.28, 0.91)),
            row("gather, Lee et al. 2009 (mipmap)", "mipmap", both(19.53, 0.88)),
        ],
        claims: &[
            Verdict {
                quote: "Our method shows the highest score (SSIM 0.97, PSNR 30.84 dB)",
                says: Says::First(&[0, 1, 2]),
                by: Measure::Psnr,
                reason: "As published, rays that leave the frame are dropped, and here the blurred column reaches the frame: with --overscan 32 multiview has 33.25 dB and SSIM 0.927 against 30.21 and 0.881 of mipmap (192x144).",
            },
            Verdict {
                quote: "Our method shows the highest score (SSIM 0.97, PSNR 30.84 dB)",
                says: Says::First(&[0, 1, 2]),
                by: Measure::Ssim,
                reason: "As published, rays that leave the frame are dropped, and here the blurred column reaches the frame: with --overscan 32 multiview has 33.25 dB and SSIM 0.927 against 30.21 and 0.881 of mipmap (192x144).",
            },
        ],
        notes: &[OWN_SCENES],
    },
    Figure {
        name: "siga-fig9",
        title: "SIGGRAPH Asia 2009, Fig. 9: view-dependent shading of reflective materials",
        scenes: &["mirrors"],
        mean_cocs_px: &[8.0, 24.0],
        size: [400, 300],
        view_dependent: true,
        input: Input::Hdr,
        rows: &[
            set("view-dependent", "multiview", &[("view_dependent", "on")], both(41.38, 0.97)),
            set("view-independent", "multiview", &[("view_dependent", "off")], both(27.68, 0.93)),
            row("pinhole", "pinhole", both(18.12, 0.59)),
        ],
        claims: &[
            Verdict {
                quote: "Our view-dependent evaluation resulted in a score of (0.97/41.38)",
                says: Says::Order(&[0, 1, 2]),
                by: Measure::Psnr,
                reason: "",
            },
            Verdict {
                quote: "Our view-dependent evaluation resulted in a score of (0.97/41.38)",
                says: Says::Order(&[0, 1, 2]),
                by: Measure::Ssim,
                reason: "",
            },
        ],
        notes: &[OWN_SCENES],
    },
    Figure {
        name: "siga-fig10",
        title: "SIGGRAPH Asia 2009, Fig. 10: the number of layers",
        scenes: &["branches"],
        mean_cocs_px: &[16.0],
        size: [400, 300],
        view_dependent: false,
        input: Input::Hdr,
        rows: &[
            set("1 layer", "multiview", &[("slabs", "1"), ("delta", "0.5")], UNKNOWN),
            set("4 layers", "multiview", &[("slabs", "4"), ("delta", "0.5")], UNKNOWN),
            set("8 layers", "multiview", &[("slabs", "8"), ("delta", "0.5")], UNKNOWN),
            set("16 layers", "multiview", &[("slabs", "16"), ("delta", "0.5")], UNKNOWN),
            row("gather, Lee et al. 2009 (mipmap)", "mipmap", UNKNOWN),
        ],
        claims: &[
            Verdict {
                quote: "we choose the number of layers to fulfill a spacing requirement",
                says: Says::First(&[3, 0]),
                by: Measure::Psnr,
                reason: "A surface that is cut by more bounds has more gaps, which hit what lies behind.",
            },
            Verdict {
                quote: "even if the entire scene were flattened on a single layer, artifacts are limited",
                says: Says::Order(&[0, 4]),
                by: Measure::Psnr,
                reason: "One layer holds nothing that is hidden, as the gather method's image.",
            },
        ],
        notes: &["The paper shows pictures and gives no numbers."],
    },
    Figure {
        name: "gather",
        title: "gather on five scenes, at full and at half resolution",
        scenes: &["cans", "atrium", "branches", "highlights", "mirrors"],
        mean_cocs_px: &[8.0, 16.0],
        size: [512, 384],
        view_dependent: false,
        input: Input::Hdr,
        rows: &[
            set("full resolution", "gather", &[("resolution", "1")], db(29.5)),
            set("half resolution", "gather", &[("resolution", "1/2")], db(28.5)),
        ],
        claims: &[],
        notes: &[
            "No paper's figure: the ring gather that engines ship is published without measurements. 29.5 and 28.5 dB are means that an earlier experiment with such a gather had on other scenes, for orientation.",
        ],
    },
];

impl Row {
    fn variant(&self) -> Variant {
        let published = Variant::published(self.method);
        self.settings.iter().fold(published, |variant, (key, value)| variant.with(key, value))
    }
}

impl Figure {
    pub(super) fn plan(&self, quick: bool) -> Plan {
        let size = if quick { [192, 144] } else { self.size };
        let blurs = self.mean_cocs_px.iter().map(|px| Blur::MeanCocPx(*px)).collect();
        let variants = self.rows.iter().map(Row::variant).collect();
        let samples = if quick { 64 } else { 1024 };
        // Of pictures that are compared times are by the way.
        Plan {
            reference_samples: Some(samples),
            warmup: 0,
            runs: 1,
            view_dependent: self.view_dependent,
            input: self.input,
            ..super::plan(self.scenes, size, blurs, variants)
        }
    }

    /// Result of a row in a cell.
    fn found<'a>(&self, results: &'a BenchResults, row: &Row, scene: &str, px: f64) -> Option<&'a VariantResult> {
        // With `--set` a variant has other settings than the row, but the same place.
        let place = self.rows.iter().position(|r| std::ptr::eq(r, row))?;
        let label = results.plan.variants.get(place)?.label();
        results.cell(scene, Blur::MeanCocPx(px))?.variant(&label)
    }

    fn cells(&self) -> impl Iterator<Item = (&'static str, f64)> + '_ {
        self.scenes.iter().flat_map(|scene| self.mean_cocs_px.iter().map(|px| (*scene, *px)))
    }

    pub(super) fn compared(&self, results: &BenchResults) -> Comparison {
        let mut columns = vec!["method".to_owned(), "paper: dB, SSIM".to_owned()];
        columns.extend(self.cells().map(|(scene, px)| format!("{scene}, C = {px} px: dB, SSIM")));
        let has_mean = self.cells().count() > 2;
        columns.extend(has_mean.then(|| "mean: dB, SSIM".to_owned()));
        let text = |psnr: Option<f64>, ssim: Option<f64>| format!("{}, {}", cell_text(psnr, 2), cell_text(ssim, 3));
        let table_row = |row: &Row| {
            let mut cells = vec![row.name.to_owned(), text(row.paper[0], row.paper[1])];
            cells.extend(self.cells().map(|(scene, px)| {
                let metrics = self.found(results, row, scene, px).map(|found| &found.metrics);
                text(metrics.and_then(|m| m.psnr_db), metrics.and_then(|m| m.ssim))
            }));
            cells.extend(has_mean.then(|| {
                let [psnr, ssim] = self.means(results, row);
                text(psnr, ssim)
            }));
            cells
        };
        Comparison {
            title: self.title.into(),
            setting: format!("{}. Methods as published.", setting(results)),
            columns,
            rows: self.rows.iter().map(table_row).collect(),
            claims: self.claims.iter().map(|verdict| self.claim(results, verdict)).collect(),
            notes: self.notes.iter().map(|note| (*note).to_owned()).collect(),
        }
    }

    /// A sentence holds if it does in every cell that it is about.
    fn claim(&self, results: &BenchResults, verdict: &Verdict) -> Claim {
        let (says, by) = (&verdict.says, verdict.by);
        let measured = |scene: &str, px: f64| -> Option<Vec<f64>> {
            let of = |row: &usize| by.of(self.found(results, &self.rows[*row], scene, px)?);
            says.rows().iter().map(of).collect()
        };
        let about = self.cells().filter(|(_, px)| says.is_about(*px));
        let all: Vec<_> = about.map(|(scene, px)| (scene, px, measured(scene, px))).collect();
        let decimals = match by {
            Measure::Psnr | Measure::Jod => 2,
            Measure::Ssim => 3,
        };
        let list = |values: &[f64]| values.iter().map(|v| format!("{v:.decimals$}")).collect::<Vec<_>>().join(", ");
        let words: Vec<String> = (all.iter())
            .map(|(scene, px, values)| {
                format!("{scene}, {px} px: {}", values.as_ref().map_or_else(|| "–".into(), |v| list(v)))
            })
            .collect();
        let known: Option<Vec<&Vec<f64>>> = all.iter().map(|(.., values)| values.as_ref()).collect();
        let holds = known.map(|cells| cells.iter().all(|values| says.holds(values)));
        let what = match by {
            Measure::Psnr => "dB",
            Measure::Ssim => "SSIM",
            Measure::Jod => "JOD",
        };
        let bound = match says {
            Says::Order(rows) => format!("{what}, falling: {}", self.names(rows)),
            Says::First(rows) => format!("{what}, the first is the greatest: {}", self.names(rows)),
            Says::Near(rows, by) => format!("{what}, the first less than {by} behind: {}", self.names(rows)),
            Says::AtLeast { row, least, .. } => format!("{what}, at least {least}: {}", self.rows[*row].name),
        };
        let quote = format!("\"{}\"", verdict.quote);
        Claim::new(&quote, format!("{bound}. {}", words.join("; ")), holds, verdict.reason)
    }

    fn names(&self, rows: &[usize]) -> String {
        rows.iter().map(|row| self.rows[*row].name).collect::<Vec<_>>().join(", ")
    }

    /// PSNR, dB, and SSIM of a row, means over all cells; `None` as long as one is missing.
    fn means(&self, results: &BenchResults, row: &Row) -> [Option<f64>; 2] {
        let mean = |by: Measure| {
            let all: Option<Vec<f64>> =
                self.cells().map(|(scene, px)| by.of(self.found(results, row, scene, px)?)).collect();
            all.map(|values| values.iter().sum::<f64>() / values.len() as f64)
        };
        [mean(Measure::Psnr), mean(Measure::Ssim)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Words of a text whatever its line breaks, hyphenation and ligatures.
    fn words(text: &str) -> String {
        let joined = text.replace("-\n", "").replace('ﬁ', "fi").replace('ﬂ', "fl").replace('’', "'");
        joined.split_whitespace().collect::<Vec<_>>().join(" ")
    }

    /// Where the papers lie beside the repository, each sentence is in one of them.
    #[test]
    fn quoted_sentences_are_in_the_papers() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/papers");
        let Ok(files) = std::fs::read_dir(folder) else { return };
        let papers: Vec<String> = files.flatten().filter_map(|f| std::fs::read_to_string(f.path()).ok()).collect();
        let papers: Vec<String> = papers.iter().map(|text| words(text)).collect();
        for (figure, verdict) in FIGURES.iter().flat_map(|figure| figure.claims.iter().map(move |v| (figure, v))) {
            let quote = words(verdict.quote);
            assert!(papers.iter().any(|paper| paper.contains(&quote)), "{}: {quote}", figure.name);
        }
    }

    #[test]
    fn every_kind_of_verdict_can_fail() {
        assert!(Says::Order(&[]).holds(&[3.0, 2.0]) && !Says::Order(&[]).holds(&[2.0, 3.0]));
        assert!(Says::First(&[]).holds(&[3.0, 1.0, 2.0]) && !Says::First(&[]).holds(&[3.0, 1.0, 4.0]));
        assert!(Says::Near([0, 1], 1.0).holds(&[3.5, 4.0]) && !Says::Near([0, 1], 1.0).holds(&[3.0, 4.0]));
        let floor = Says::AtLeast { row: 0, least: 2.0, up_to_px: 8.0 };
        assert!(floor.holds(&[2.0]) && !floor.holds(&[1.9]) && floor.is_about(8.0) && !floor.is_about(16.0));
    }

    #[test]
    fn every_row_of_every_figure_can_be_rendered() {
        for figure in &FIGURES {
            for variant in figure.plan(true).variants {
                assert!(variant.method().is_ok(), "{}: {}", figure.name, variant.label());
            }
            for verdict in figure.claims {
                assert!(verdict.says.rows().iter().all(|row| *row < figure.rows.len()), "{}", figure.name);
            }
        }
    }
}
