//! A run: every case, shared out among devices.

use super::{
    KNOWN_LIMITS, KnownLimit, Outcome, SCENES, SceneCondition, Specimen, StressRequest, image_cases, prepared, try_all,
    try_witnesses,
};
use crate::gpu::{Gpu, GpuError};
use crate::methods::Method;
use crate::study::stress::cases::ImageCaseMaker;
use crate::study::{Progress, StudyError, step};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

/// Most devices that a run opens: each compiles all shaders for itself.
const MOST_DEVICES: usize = 8;

/// How long a run waits for a result before it asks again whether to stop.
const PATIENCE: Duration = Duration::from_millis(100);

/// The devices that a run is shared out among: `gpu`, and where that is a program on the
/// processor one more for each further core. Images as small as these keep only one busy.
///
/// `adapter` is what `gpu` was opened with.
///
/// # Errors
///
/// As [`Gpu::open`].
pub fn devices(gpu: Gpu, adapter: Option<&str>) -> Result<Vec<Gpu>, GpuError> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let count = if gpu.is_software() { cores.min(MOST_DEVICES) } else { 1 };
    let mut gpus = vec![gpu];
    while gpus.len() < count {
        gpus.push(Gpu::open(adapter)?);
    }
    Ok(gpus)
}

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
    let next = AtomicUsize::new(0);
    let mut found: Vec<_> = jobs.iter().map(|_| None).collect();
    let (sender, results) = channel();
    let result = std::thread::scope(|scope| {
        for gpu in gpus {
            let (sender, jobs, methods, next) = (sender.clone(), &jobs, &methods, &next);
            scope.spawn(move || {
                while let Some((index, job)) = take(jobs, next) {
                    // Nobody listens any more once the run is stopped.
                    if sender.send((index, job.done(gpu, methods))).is_err() {
                        return;
                    }
                }
            });
        }
        drop(sender);
        collect(results, &mut found, progress)
    });
    // In the order of the cases, whichever device was the faster.
    for part in found.into_iter().flatten() {
        outcome.add(part);
    }
    result
}

fn take<'a, 'b>(jobs: &'a [Job<'b>], next: &AtomicUsize) -> Option<(usize, &'a Job<'b>)> {
    let index = next.fetch_add(1, Ordering::Relaxed);
    jobs.get(index).map(|job| (index, job))
}

fn collect(
    results: Receiver<(usize, Result<Outcome, StudyError>)>,
    found: &mut [Option<Outcome>],
    progress: &mut Progress<'_>,
) -> Result<(), StudyError> {
    let of = found.len() as u32;
    let mut done = 0;
    loop {
        step(progress, "stress", done, of)?;
        match results.recv_timeout(PATIENCE) {
            Ok((index, part)) => {
                found[index] = Some(part?);
                done += 1;
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        }
    }
}
