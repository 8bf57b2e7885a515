//! The papers' figures that compare pictures: what each says in dB and SSIM, or in words,
//! beside what is measured here, every method as published.

use super::super::plan::{Blur, Plan, Variant};
use super::super::results::{BenchResults, VariantResult};
use super::{Claim, Comparison, cell_text, setting};

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
    rows: &'static [Row],
    claims: &'static [Order],
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

/// That one row is better than another.
struct Order {
    paper: &'static str,
    /// Rows, best first.
    rows: &'static [usize],
    by: Measure,
    reason: &'static str,
}

/// What "better" means.
#[derive(Clone, Copy)]
enum Measure {
    Psnr,
    Ssim,
}

impl Measure {
    fn of(self, variant: &VariantResult) -> Option<f64> {
        match self {
            Self::Psnr => variant.metrics.psnr_db,
            Self::Ssim => variant.metrics.ssim,
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

const OWN_SCENES: &str = "The paper's scenes and lenses are not public: built-in ones stand in, and figures in dB compare methods on one scene, not scenes.";

/// All of them.
pub(super) const FIGURES: [Figure; 14] = [
    Figure {
        name: "tvcg-fig11",
        title: "TVCG 2009, Fig. 11: background blur, the nearest can in focus",
        scenes: &["cans"],
        mean_cocs_px: &[8.0],
        size: [1024, 768],
        view_dependent: false,
        rows: &TVCG_11,
        claims: &[Order {
            paper: "Ours is most similar to the reference, then Zhou et al.'s, Kraus and Strengert's, Scheuermann's",
            rows: &[0, 2, 1, 3],
            by: Measure::Psnr,
            reason: "pyramid is as bright as its repeated inclusion makes it, which depends on how many sub-images the depths in view need.",
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
        rows: &TVCG_12,
        claims: &[Order {
            paper: "Ours is most similar to the reference, then Zhou et al.'s, Scheuermann's, Kraus and Strengert's",
            rows: &[0, 2, 3, 1],
            by: Measure::Psnr,
            reason: "separable keeps a hard edge around blurred foreground, preblur a softer one that is wrong elsewhere: which costs more depends on the scene.",
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
        rows: &[row("ours (mipmap)", "mipmap", UNKNOWN)],
        claims: &[],
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
        rows: &[row("Kraus and Strengert (pyramid)", "pyramid", UNKNOWN), row("ours (opaque)", "opaque", UNKNOWN)],
        claims: &[Order {
            paper: "Ours avoids the disocclusion that makes objects too opaque, and the images too bright",
            rows: &[1, 0],
            by: Measure::Psnr,
            reason: "Silhouettes of the opaque blur are too sharp, as the paper says itself.",
        }],
        notes: &[
            "The paper shows pictures and gives no numbers. Its reference is ray traced with pbrt; here accumulation, with which this program's ray tracer agrees (README).",
        ],
    },
    Figure {
        name: "pg-fig9",
        title: "Pacific Graphics 2008, Fig. 9: defocused highlights",
        scenes: &["highlights"],
        mean_cocs_px: &[16.0],
        size: [512, 384],
        view_dependent: false,
        rows: &[
            row("splatting the HDR image", "splat", UNKNOWN),
            set("expanding highlights, equation (8)", "splat", &[("highlights", "on")], UNKNOWN),
        ],
        claims: &[],
        notes: &[
            "The paper shows pictures and gives no numbers. Its left column maps tones before the splatting; here all images come in HDR, and equation (8) is for those that do not.",
        ],
    },
    Figure {
        name: "pg-fig10",
        title: "Pacific Graphics 2008, Fig. 10: sprites at the original and at reduced resolution",
        scenes: &["herd", "branches"],
        mean_cocs_px: &[8.0],
        size: [512, 384],
        view_dependent: false,
        rows: &[
            row("not accelerated", "splat", UNKNOWN),
            set("accelerated", "splat", &[("accelerate", "on")], UNKNOWN),
        ],
        claims: &[],
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
        rows: &[
            row("ours, with the hidden image (splat)", "splat", db(36.33)),
            set("ours, without", "splat", &[("hidden", "off")], db(32.84)),
            row("[ZCP07] (separable)", "separable", db(29.4)),
        ],
        claims: &[Order {
            paper: "With the hidden image before without it before Zhou et al.'s",
            rows: &[0, 1, 2],
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
        rows: &[row("with the hidden image", "splat", UNKNOWN), set("without", "splat", &[("hidden", "off")], UNKNOWN)],
        claims: &[],
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
        rows: &[
            row("per-pixel layers (splat)", "splat", UNKNOWN),
            row("global layers of Kraus and Strengert (pyramid)", "pyramid", UNKNOWN),
        ],
        claims: &[Order {
            paper: "A long object that is cut into global layers shows their boundaries, on per-pixel layers it does not",
            rows: &[0, 1],
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
            Order { paper: "Cones remove the grain, with 1 view", rows: &[1, 0], by: Measure::Psnr, reason: "" },
            Order { paper: "The same with 8 views", rows: &[3, 2], by: Measure::Psnr, reason: "" },
            Order { paper: "The same with 16 views", rows: &[5, 4], by: Measure::Psnr, reason: "" },
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
        rows: &[
            set("32 points, fixed", "multiview", &[("jitter", "off")], UNKNOWN),
            set("32 points, jittered", "multiview", &[], UNKNOWN),
            set("64 points, fixed", "multiview", &[("samples", "64"), ("jitter", "off")], UNKNOWN),
        ],
        claims: &[Order {
            paper: "32 jittered points approach 64 fixed ones, and even exceed them to some extent",
            rows: &[1, 2],
            by: Measure::Psnr,
            reason: "A fixed set errs in the same way in all pixels, which looks worse than noise and measures better: PSNR does not tell ghosts from grain, and noise of independent pixels is the greater error.",
        }],
        notes: &["The paper shows pictures and gives no numbers."],
    },
    Figure {
        name: "siga-fig8",
        title: "SIGGRAPH Asia 2009, Fig. 8: strong foreground blur",
        scenes: &["atrium"],
        mean_cocs_px: &[16.0],
        size: [400, 300],
        view_dependent: false,
        rows: &[
            row("ours (multiview)", "multiview", both(30.84, 0.97)),
            row("multilayer, Kraus and Strengert (pyramid)", "pyramid", both(22.28, 0.91)),
            row("gather, Lee et al. 2009 (mipmap)", "mipmap", both(19.53, 0.88)),
        ],
        claims: &[
            Order {
                paper: "Ours before the multilayer before the gather method, PSNR",
                rows: &[0, 1, 2],
                by: Measure::Psnr,
                reason: "pyramid adds light behind each sub-image here, as published: too bright, it falls behind mipmap.",
            },
            Order { paper: "The same, SSIM", rows: &[0, 1, 2], by: Measure::Ssim, reason: "As for the PSNR." },
        ],
        notes: &[OWN_SCENES],
    },
    Figure {
        name: "siga-fig9",
        title: "SIGGRAPH Asia 2009, Fig. 9: view-dependent shading of reflective materials",
        scenes: &["mirrors"],
        mean_cocs_px: &[8.0],
        size: [400, 300],
        view_dependent: true,
        rows: &[
            set("view-dependent", "multiview", &[("view_dependent", "on")], both(41.38, 0.97)),
            set("view-independent", "multiview", &[("view_dependent", "off")], both(27.68, 0.93)),
            row("pinhole", "pinhole", both(18.12, 0.59)),
        ],
        claims: &[
            Order {
                paper: "View-dependent before view-independent shading before the pinhole image, PSNR",
                rows: &[0, 1, 2],
                by: Measure::Psnr,
                reason: "",
            },
            Order {
                paper: "The same, SSIM",
                rows: &[0, 1, 2],
                by: Measure::Ssim,
                reason: "Each ray shades a point of its own, so that reflections are sampled as often as there are rays: their noise costs more structure than what moves by the lens point.",
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
        rows: &[
            set("1 layer", "multiview", &[("slabs", "1"), ("delta", "0.5")], UNKNOWN),
            set("4 layers", "multiview", &[("slabs", "4"), ("delta", "0.5")], UNKNOWN),
            set("8 layers", "multiview", &[("slabs", "8"), ("delta", "0.5")], UNKNOWN),
            set("16 layers", "multiview", &[("slabs", "16"), ("delta", "0.5")], UNKNOWN),
        ],
        claims: &[Order {
            paper: "More layers are better; with one alone artifacts are limited",
            rows: &[3, 2, 1, 0],
            by: Measure::Psnr,
            reason: "A surface that is cut by more bounds has more gaps, which hit what lies behind.",
        }],
        notes: &["The paper shows pictures and gives no numbers."],
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
        let text = |psnr: Option<f64>, ssim: Option<f64>| format!("{}, {}", cell_text(psnr, 2), cell_text(ssim, 3));
        let table_row = |row: &Row| {
            let mut cells = vec![row.name.to_owned(), text(row.paper[0], row.paper[1])];
            cells.extend(self.cells().map(|(scene, px)| {
                let metrics = self.found(results, row, scene, px).map(|found| &found.metrics);
                text(metrics.and_then(|m| m.psnr_db), metrics.and_then(|m| m.ssim))
            }));
            cells
        };
        Comparison {
            title: self.title.into(),
            setting: format!("{}. Methods as published.", setting(results)),
            columns,
            rows: self.rows.iter().map(table_row).collect(),
            claims: self.claims.iter().map(|order| self.claim(results, order)).collect(),
            notes: self.notes.iter().map(|note| (*note).to_owned()).collect(),
        }
    }

    /// An order holds if it does in every cell.
    fn claim(&self, results: &BenchResults, order: &Order) -> Claim {
        let measured = |scene: &str, px: f64| -> Option<Vec<f64>> {
            let of = |row: &usize| order.by.of(self.found(results, &self.rows[*row], scene, px)?);
            order.rows.iter().map(of).collect()
        };
        let all: Vec<_> = self.cells().map(|(scene, px)| (scene, measured(scene, px))).collect();
        let decimals = match order.by {
            Measure::Psnr => 2,
            Measure::Ssim => 3,
        };
        let list = |values: &[f64]| values.iter().map(|v| format!("{v:.decimals$}")).collect::<Vec<_>>().join(", ");
        let words: Vec<String> = (all.iter())
            .map(|(scene, values)| format!("{scene}: {}", values.as_ref().map_or_else(|| "–".into(), |v| list(v))))
            .collect();
        let known: Option<Vec<&Vec<f64>>> = all.iter().map(|(_, values)| values.as_ref()).collect();
        let holds = known.map(|cells| cells.iter().all(|values| values.is_sorted_by(|a, b| a >= b)));
        Claim::new(order.paper, words.join("; "), holds, order.reason)
    }
}
