//! Figures that compare pictures: rows, what the paper says of them, and whether that holds here.

use super::super::plan::{Blur, Plan, Variant};
use super::super::results::{BenchResults, VariantResult};
use super::{Claim, Comparison, cell_text, setting};
use defocus::view::Input;

/// A figure.
pub(super) struct Figure {
    /// On the command line.
    pub(super) name: &'static str,
    pub(super) title: &'static str,
    /// The scene that stands in for the paper's.
    pub(super) scenes: &'static [&'static str],
    pub(super) mean_cocs_px: &'static [f64],
    /// Size, px, without `--quick`.
    pub(super) size: [u32; 2],
    /// Whether the reference shades from each point of the lens.
    pub(super) view_dependent: bool,
    /// What methods are given of the light.
    pub(super) input: Input,
    pub(super) rows: &'static [Row],
    pub(super) claims: &'static [Verdict],
    pub(super) notes: &'static [&'static str],
}

/// A method of a figure.
pub(super) struct Row {
    pub(super) name: &'static str,
    pub(super) method: &'static str,
    pub(super) settings: &'static [(&'static str, &'static str)],
    /// The paper's PSNR, dB, and SSIM.
    pub(super) paper: [Option<f64>; 2],
}

/// A sentence of the paper, or the part of one that can be measured.
pub(super) struct Verdict {
    /// In the paper's words.
    pub(super) quote: &'static str,
    pub(super) says: Says,
    pub(super) by: Measure,
    /// Why it does not hold here, where it is known not to.
    pub(super) reason: &'static str,
}

/// What a sentence says of rows.
pub(super) enum Says {
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
    pub(super) fn rows(&self) -> &[usize] {
        match self {
            Self::Order(rows) | Self::First(rows) => rows,
            Self::Near(rows, _) => rows,
            Self::AtLeast { row, .. } => std::slice::from_ref(row),
        }
    }

    pub(super) fn holds(&self, values: &[f64]) -> bool {
        match self {
            Self::Order(_) => values.is_sorted_by(|a, b| a >= b),
            Self::First(_) => values.iter().all(|v| values[0] >= *v),
            Self::Near(_, by) => values[1] - values[0] < *by,
            Self::AtLeast { least, .. } => values[0] >= *least,
        }
    }

    /// Whether it says anything about a mean CoC.
    pub(super) fn is_about(&self, mean_coc_px: f64) -> bool {
        match self {
            Self::AtLeast { up_to_px, .. } => mean_coc_px <= *up_to_px,
            _ => true,
        }
    }
}

/// What "better" means: more of this.
#[derive(Clone, Copy)]
pub(super) enum Measure {
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

impl Row {
    pub(super) fn variant(&self) -> Variant {
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

    #[test]
    fn every_kind_of_verdict_can_fail() {
        assert!(Says::Order(&[]).holds(&[3.0, 2.0]) && !Says::Order(&[]).holds(&[2.0, 3.0]));
        assert!(Says::First(&[]).holds(&[3.0, 1.0, 2.0]) && !Says::First(&[]).holds(&[3.0, 1.0, 4.0]));
        assert!(Says::Near([0, 1], 1.0).holds(&[3.5, 4.0]) && !Says::Near([0, 1], 1.0).holds(&[3.0, 4.0]));
        let floor = Says::AtLeast { row: 0, least: 2.0, up_to_px: 8.0 };
        assert!(floor.holds(&[2.0]) && !floor.holds(&[1.9]) && floor.is_about(8.0) && !floor.is_about(16.0));
    }
}
