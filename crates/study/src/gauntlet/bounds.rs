//! What methods are known to reach, and whether a run falls below it.
//!
//! Two kinds. For the very scenes on which the bounds were made, each family's mean is known:
//! it changes only with the program, and a little with the driver. For any other scenes, a
//! family's mean is known to differ from its long mean as the scenes' own figures spread:
//! by `s / sqrt(n)` for `n` scenes of a standard deviation `s`.

use super::statistics::counted_db;
use super::{MethodFigures, SceneResult};
use std::collections::BTreeMap;

/// By how much a mean PSNR, dB, over the very same scenes may be lower: drivers round
/// differently. The same on two versions of one software driver differs by less than 0.1 dB.
pub const SAME_SCENES_DB: f64 = 0.3;

/// The same for the mean difference of light kept from 1.
pub const SAME_SCENES_LIGHT: f64 = 0.005;

/// Standard errors by which a mean over other scenes may be worse: of the 460 means of a run
/// over ten methods and 23 families, two figures each, one in 70 runs has one that is worse
/// by chance (one-sided, 3.2e-5 each for a normal distribution).
pub const STANDARD_ERRORS: f64 = 4.0;

/// Mean and standard deviation of a figure over scenes.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Known {
    /// Scenes.
    pub scenes: usize,
    /// Mean.
    pub mean: f64,
    /// Standard deviation of one scene's figure.
    pub deviation: f64,
}

/// Figures of a method on a family.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct KnownFamily {
    /// PSNR, dB, at most [`CAP_DB`](super::CAP_DB).
    pub psnr_db: Known,
    /// Difference of the light kept from 1; none in families without lights.
    pub light_error: Option<Known>,
}

/// Families by name, by method id.
pub type KnownMethods = BTreeMap<String, BTreeMap<String, KnownFamily>>;

/// Which scenes: those of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Which {
    /// Seed of the run.
    pub seed: u64,
    /// Number of scenes, of all families in turn.
    pub scenes: u64,
    /// Size of their frames, px.
    pub size: [u32; 2],
}

/// What is known.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Bounds {
    /// The scenes whose own means are known.
    pub same: Which,
    /// On these.
    pub on_same: KnownMethods,
    /// On many, of any seeds, of the same size.
    pub on_many: KnownMethods,
}

/// What the program is known to reach: `assets/gauntlet_bounds.ron`, as `defocus gauntlet
/// --print-bounds` printed it.
///
/// # Errors
///
/// A file that does not hold bounds.
pub fn known_bounds() -> Result<Bounds, String> {
    ron::from_str(include_str!("../../../../assets/gauntlet_bounds.ron")).map_err(|e| e.to_string())
}

/// The figures of a run, by method and family.
pub fn known(results: &[SceneResult]) -> KnownMethods {
    // PSNR and light of each scene, by method and family.
    type Columns = (Vec<f64>, Vec<f64>);
    let mut figures: BTreeMap<(&str, &str), Columns> = BTreeMap::new();
    for result in results.iter().filter(|r| r.agrees) {
        for (method, found) in &result.methods {
            let (psnr_db, light) = figures.entry((*method, result.family)).or_default();
            psnr_db.push(counted_db(found));
            let kept = match found {
                MethodFigures::Compared(figures) => figures.light_kept,
                MethodFigures::Failed { .. } => None,
            };
            light.extend(kept.map(|kept| (kept - 1.0).abs()));
        }
    }
    let mut all = KnownMethods::new();
    for ((method, family), (psnr_db, light)) in figures {
        let Some(psnr_db) = known_of(&psnr_db) else { continue };
        let of_family = KnownFamily { psnr_db, light_error: known_of(&light) };
        all.entry(method.into()).or_default().insert(family.into(), of_family);
    }
    all
}

fn known_of(values: &[f64]) -> Option<Known> {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    let deviation = (squares / (count - 1.0).max(1.0)).sqrt();
    let short = |value: f64| super::rounded_to(value, 5);
    (!values.is_empty()).then(|| Known { scenes: values.len(), mean: short(mean), deviation: short(deviation) })
}

/// A figure that is worse than its bound.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Regression {
    /// The method's id.
    pub method: String,
    /// The family.
    pub family: String,
    /// Which figure.
    pub figure: &'static str,
    /// Its mean in the run.
    pub mean: f64,
    /// The worst that it may be.
    pub bound: f64,
}

impl std::fmt::Display for Regression {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { method, family, figure, mean, bound } = self;
        write!(f, "{method} on {family}: the mean {figure} is {mean:.4} and may be {bound:.4} at worst")
    }
}

impl Bounds {
    /// What of a run is worse than it may be. Methods and families that the run or the
    /// bounds do not have are not judged.
    pub fn regressions(&self, which: &Which, results: &[SceneResult]) -> Vec<Regression> {
        let found = known(results);
        let same = *which == self.same;
        let expected = if same { &self.on_same } else { &self.on_many };
        let pairs = found.iter().flat_map(|(method, families)| {
            let of_method = expected.get(method);
            families.iter().filter_map(move |(name, found)| Some((method, name, found, of_method?.get(name)?)))
        });
        let mut worse = Vec::new();
        for (method, family, found, expected) in pairs {
            let mut judge = |figure, found: Known, expected: Known, least: f64, sign: f64| {
                let by_chance = STANDARD_ERRORS * expected.deviation / (found.scenes as f64).sqrt();
                let margin = if same { least } else { least + by_chance };
                let bound = expected.mean - sign * margin;
                if sign * (found.mean - bound) < 0.0 {
                    let (method, family) = (method.clone(), family.clone());
                    worse.push(Regression { method, family, figure, mean: found.mean, bound });
                }
            };
            judge("PSNR, dB,", found.psnr_db, expected.psnr_db, SAME_SCENES_DB, 1.0);
            if let (Some(found), Some(expected)) = (found.light_error, expected.light_error) {
                judge("difference of the light kept from 1", found, expected, SAME_SCENES_LIGHT, -1.0);
            }
        }
        worse
    }

    /// As the text of `assets/gauntlet_bounds.ron`.
    pub fn to_text(&self) -> String {
        let pretty = ron::ser::PrettyConfig::new().depth_limit(4);
        ron::ser::to_string_pretty(self, pretty).unwrap_or_default() + "\n"
    }
}
