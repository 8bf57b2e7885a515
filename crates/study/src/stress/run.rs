//! A run: every case, shared out among devices.

use super::{
    KNOWN_LIMITS, KnownLimit, Outcome, SCENES, SceneCondition, Specimen, StressRequest, image_cases, prepared, try_all,
    try_witnesses,
};
use crate::devices::share_out;
use crate::stress::cases::ImageCaseMaker;
use crate::{Progress, StudyError};
use defocus::gpu::Gpu;
use defocus::methods::Method;

/// A unit of work.
enum Job<'a> {
    Scene(&'a SceneCondition),
    Image(&'a ImageCaseMaker),
    Limit(&'a KnownLimit),
}

impl Job<'_> {
    fn done(&self, gpu: &Gpu, methods: &[Box<dyn Method>]) -> Result<Outcome, StudyError> {
        let mut outcome = Outcome::default();
        match self {
            Self::Scene(condition) => try_all(gpu, methods, &mut condition.specimen(gpu)?, &mut outcome),
            Self::Image(case) => try_all(gpu, methods, &mut Specimen::of_image(gpu, &case())?, &mut outcome),
            Self::Limit(limit) => try_witnesses(gpu, methods, limit, &mut outcome)?,
        }
        Ok(outcome)
    }
}

/// Tries the methods on everything that the request asks for, on all of `gpus` at once.
/// What was found is in `outcome` also if the run is stopped.
///
/// # Errors
///
/// [`StudyError::Stopped`], and sizes that the adapter cannot draw.
pub fn run(
    gpus: &[Gpu],
    request: &StressRequest<'_>,
    outcome: &mut Outcome,
    progress: &mut Progress<'_>,
) -> Result<(), StudyError> {
    let methods = prepared(request.methods);
    let cases = image_cases(request.quick, request.seed);
    let images = cases.iter().map(Job::Image);
    let jobs: Vec<_> = SCENES.iter().map(Job::Scene).chain(images).chain(KNOWN_LIMITS.iter().map(Job::Limit)).collect();
    let mut found: Vec<_> = jobs.iter().map(|_| None).collect();
    let keep = |index: usize, part: Outcome| found[index] = Some(part);
    let result = share_out(gpus, &jobs, "stress", |gpu, job| job.done(gpu, &methods), keep, progress);
    // In the order of the cases, whichever device was the faster.
    for part in found.into_iter().flatten() {
        outcome.add(part);
    }
    result
}
