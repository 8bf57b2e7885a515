//! Many small pieces of work, shared out among devices.

use super::{Progress, StudyError, step};
use defocus::gpu::{Gpu, GpuError};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

/// Most devices that a run opens: each compiles all shaders for itself.
const MOST_DEVICES: usize = 8;

/// How long a run waits for a result before it asks again whether to stop.
const PATIENCE: Duration = Duration::from_millis(100);

/// The devices that a run is shared out among: `gpu`, and where that is a program on the
/// processor one more for each further core. Small images keep only one core busy.
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

/// Does `work` on every job, on all of `gpus` at once; each result is handed to `found` as it
/// comes, with the job's index.
///
/// # Errors
///
/// [`StudyError::Stopped`], and the first error of `work`.
pub fn share_out<J: Sync, R: Send>(
    gpus: &[Gpu],
    jobs: &[J],
    what: &str,
    work: impl Fn(&Gpu, &J) -> Result<R, StudyError> + Sync,
    mut found: impl FnMut(usize, R),
    progress: &mut Progress<'_>,
) -> Result<(), StudyError> {
    let next = AtomicUsize::new(0);
    let (sender, results) = channel();
    std::thread::scope(|scope| {
        for gpu in gpus {
            let (sender, next, work) = (sender.clone(), &next, &work);
            scope.spawn(move || {
                while let Some((index, job)) = take(jobs, next) {
                    // Nobody listens any more once the run is stopped.
                    if sender.send((index, work(gpu, job))).is_err() {
                        return;
                    }
                }
            });
        }
        drop(sender);
        collect(results, jobs.len(), what, &mut found, progress)
    })
}

fn take<'a, J>(jobs: &'a [J], next: &AtomicUsize) -> Option<(usize, &'a J)> {
    let index = next.fetch_add(1, Ordering::Relaxed);
    jobs.get(index).map(|job| (index, job))
}

fn collect<R>(
    results: Receiver<(usize, Result<R, StudyError>)>,
    count: usize,
    what: &str,
    found: &mut impl FnMut(usize, R),
    progress: &mut Progress<'_>,
) -> Result<(), StudyError> {
    let mut done = 0;
    loop {
        step(progress, what, done, count as u32)?;
        match results.recv_timeout(PATIENCE) {
            Ok((index, result)) => {
                found(index, result?);
                done += 1;
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        }
    }
}
