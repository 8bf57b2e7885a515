//! The papers' figures that compare pictures: what each says in dB and SSIM, or in words,
//! beside what is measured here, every method as published. Verdicts are about sentences that
//! the papers have.

use super::figure::{Figure, Measure, Row, Says, Verdict};
use defocus::view::Input;

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
        let Ok(files) = std::fs::read_dir(&folder) else {
            eprintln!("not checked: the papers are not at {}", folder.display());
            return;
        };
        let papers: Vec<String> = files.flatten().filter_map(|f| std::fs::read_to_string(f.path()).ok()).collect();
        let papers: Vec<String> = papers.iter().map(|text| words(text)).collect();
        for (figure, verdict) in FIGURES.iter().flat_map(|figure| figure.claims.iter().map(move |v| (figure, v))) {
            let quote = words(verdict.quote);
            assert!(papers.iter().any(|paper| paper.contains(&quote)), "{}: {quote}", figure.name);
        }
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
