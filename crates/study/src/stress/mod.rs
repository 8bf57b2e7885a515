//! Numerical stress: every method under every condition, with the first bad pixel named.
//!
//! A **specimen** ([`Specimen`]) is a view with a lens. They come from tables of conditions
//! ([`LENSES`], [`DEPTHS`], [`COLORS`], [`SIZES`], [`SCENES`]), combined so that every lens
//! meets every depth and every colour every size, and from random numbers. On each specimen
//! every method is tried, and each result goes through every one of the [`CHECKS`] that
//! applies. What a method is known not to do is in [`KNOWN_LIMITS`].
//!
//! Images are tiny: nothing here depends on their content being pretty, and a run is to
//! see thousands of cases.

mod cases;
mod checks;
mod images;
mod known;
mod lenses;
pub mod precision;
mod run;
mod scenes;
pub mod soak;
mod specimen;

pub use crate::devices::devices;
pub use crate::random::Random;
pub use cases::{Combination, ImageCaseMaker, image_cases, random_case};
pub use checks::{
    BadPixel, CHECKS, Check, F16_ROUNDINGS, F16_SMALLEST_ROUNDINGS, Finding, Subject, first_bad_pixel,
    first_difference, first_not_finite, without_jitter,
};
pub use images::{COLORS, ColorCondition, DEPTHS, DepthCondition, LONG_SIZES, SIZES, busy, point};
pub use known::{KNOWN_LIMITS, KnownLimit};
pub use lenses::{LENSES, LensCondition, blurring};
pub use run::run;
pub use scenes::{Content, SCENES, SceneCondition};
pub use specimen::{ImageCase, Pixels, STEP_PX, Specimen, Step, Twin, as_stored, mirrored, render};

use super::StudyError;
use defocus::gpu::{Gpu, Precision};
use defocus::methods::{Method, set_param};
use std::collections::BTreeMap;
use std::time::Instant;

/// Parameters that differ from the defaults here, as (method, key, value): arithmetic is
/// what is looked at, and neither more lens points nor wider circles show more of it.
const SETTINGS: &[(&str, &str, &str)] = &[("accumulation", "samples", "16"), ("linear", "max_radius", LINEAR_RADIUS)];

/// Radius, px, to which `linear` cuts circles here: as wide as most of the images.
const LINEAR_RADIUS: &str = "12";

/// What to try.
pub struct StressRequest<'a> {
    /// The methods.
    pub methods: &'a [Box<dyn Method>],
    /// Pairs of conditions only, instead of triples.
    pub quick: bool,
    /// Of the random cases, and of what is combined with each pair.
    pub seed: u64,
}

/// A check that a method did not pass.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Failure {
    /// The method's id.
    pub method: &'static str,
    /// What it was tried on.
    pub specimen: String,
    /// The check's name.
    pub check: &'static str,
    /// The pixel, and what is wrong with it.
    #[serde(flatten)]
    pub bad: BadPixel,
    /// Why it is expected, if it is.
    pub known: Option<&'static str>,
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}, {} [{}]: ", self.method, self.check, self.specimen)?;
        match self.bad.at {
            Some(at) => write!(f, "pixel ({}, {}) {}", at.x, at.y, self.bad.found),
            None => write!(f, "{}", self.bad.found),
        }
    }
}

/// What one method did.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Tally {
    /// Specimens that it was tried on.
    pub cases: u64,
    /// Checks that applied.
    pub checks: u64,
    /// Cases with an unexpected failure.
    pub failed: u64,
    /// Cases that failed as they are known to.
    pub expected: u64,
    /// Time that they took, checks included, s.
    pub seconds: f64,
}

/// What a run found.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct Outcome {
    /// By method id.
    pub methods: BTreeMap<&'static str, Tally>,
    /// Every failure, expected ones too.
    pub failures: Vec<Failure>,
    /// Known limits whose witness passed: they are no limits any more.
    pub unexpected_passes: Vec<String>,
}

impl std::ops::AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.cases += other.cases;
        self.checks += other.checks;
        self.failed += other.failed;
        self.expected += other.expected;
        self.seconds += other.seconds;
    }
}

impl Outcome {
    /// Sums over all methods.
    pub fn total(&self) -> Tally {
        self.methods.values().fold(Tally::default(), |mut sum, tally| {
            sum += *tally;
            sum
        })
    }

    /// Adds what was found elsewhere.
    pub fn add(&mut self, other: Self) {
        for (method, tally) in other.methods {
            *self.methods.entry(method).or_default() += tally;
        }
        self.failures.extend(other.failures);
        self.unexpected_passes.extend(other.unexpected_passes);
    }

    /// The failures that nobody expects.
    pub fn unexpected(&self) -> impl Iterator<Item = &Failure> {
        self.failures.iter().filter(|failure| failure.known.is_none())
    }

    /// Whether there were none, and every known limit showed.
    pub fn is_good(&self) -> bool {
        self.unexpected().next().is_none() && self.unexpected_passes.is_empty()
    }
}

/// The methods as they are tried: with few lens points and circles that are not vast.
pub fn prepared(methods: &[Box<dyn Method>]) -> Vec<Box<dyn Method>> {
    let mut methods = methods.to_vec();
    for (id, key, value) in SETTINGS {
        for method in methods.iter_mut().filter(|m| m.about().id == *id) {
            set_param(&mut **method, key, value).unwrap_or_else(|e| panic!("{e}"));
        }
    }
    methods
}

/// Tries every method that can see the specimen, and adds what was found.
pub fn try_all(gpu: &Gpu, methods: &[Box<dyn Method>], specimen: &mut Specimen, outcome: &mut Outcome) {
    for method in methods {
        if specimen.view.is_scene() || !method.about().needs_scene {
            let start = Instant::now();
            let (checks, failures) = examine(gpu, &**method, specimen);
            let tally = outcome.methods.entry(method.about().id).or_default();
            tally.cases += 1;
            tally.seconds += start.elapsed().as_secs_f64();
            tally.checks += checks;
            tally.failed += u64::from(failures.iter().any(|f| f.known.is_none()));
            tally.expected += u64::from(!failures.is_empty() && failures.iter().all(|f| f.known.is_some()));
            outcome.failures.extend(failures);
        }
    }
}

/// Notes if no witness of the limit shows it any more.
pub fn try_witnesses(
    gpu: &Gpu,
    methods: &[Box<dyn Method>],
    limit: &KnownLimit,
    outcome: &mut Outcome,
) -> Result<(), StudyError> {
    let Some(method) = methods.iter().find(|m| m.about().id == limit.method) else { return Ok(()) };
    for case in (limit.witnesses)() {
        let mut specimen = Specimen::of_image(gpu, &case)?;
        let (_, failures) = examine(gpu, &**method, &mut specimen);
        if failures.iter().any(|f| f.check == limit.check) {
            return Ok(());
        }
    }
    outcome.unexpected_passes.push(format!(
        "{}, {}: holds on all witnesses of a known limit ({}): take it off the list",
        limit.method, limit.check, limit.reason
    ));
    Ok(())
}

/// Runs all checks on what `method` makes of the specimen: how many applied, and which it
/// did not pass.
pub fn examine(gpu: &Gpu, method: &dyn Method, specimen: &mut Specimen) -> (u64, Vec<Failure>) {
    let name = specimen.name.clone();
    let id = method.about().id;
    let limits: Vec<_> = KNOWN_LIMITS.iter().filter(|l| l.method == id && (l.applies)(specimen)).collect();
    let failure = |check: &'static str, bad: BadPixel| {
        let known = limits.iter().find(|limit| limit.check == check).map(|limit| limit.reason);
        Failure { method: id, specimen: name.clone(), check, bad, known }
    };
    let refused = |error: defocus::methods::MethodError| BadPixel { at: None, found: error.to_string() };
    let image = match render(gpu, method, &mut specimen.view, &specimen.lens, Precision::Half) {
        Ok(image) => image,
        Err(error) => return (1, vec![failure("rendering", refused(error))]),
    };
    let mut subject = Subject { gpu, method, specimen, image };
    let (mut count, mut failures) = (0, Vec::new());
    for check in CHECKS {
        match (check.run)(&mut subject) {
            Ok(None) => {}
            Ok(Some(Ok(()))) => count += 1,
            Ok(Some(Err(bad))) => {
                count += 1;
                failures.push(failure(check.name, bad));
            }
            Err(error) => {
                count += 1;
                failures.push(failure(check.name, refused(error)));
            }
        }
    }
    (count, failures)
}
