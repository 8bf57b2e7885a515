//! How far panes are from the truth, measured beside the interface on a thread.

use super::Wake;
use super::identity::Pairing;
use super::milestone::Milestone;
use crate::window::model::PaneId;
use defocus::display::Display;
use defocus::gpu::{Gpu, Texture, download, upload_scalar};
use defocus::image::{ColorImage, Image};
use defocus::viewing::Viewing;
use defocus_study::metrics::{self, CompareOptions};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// Differences from the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// Whether all pixels are equal.
    pub identical: bool,
    /// PSNR of the display values, dB.
    pub psnr_db: Option<f64>,
    /// Mean structural similarity.
    pub ssim: Option<f64>,
    /// Mean FLIP.
    pub flip: f64,
    /// Pixels per degree at which FLIP and JOD looked.
    pub px_per_degree: f64,
    /// Quality as seen on the display, JOD.
    pub jod: Option<f64>,
}

/// Figures with the pictures that they are about; an error says why there are none.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// The two pictures.
    pub of: Pairing,
    /// The figures.
    pub result: Result<Figures, String>,
}

/// What is known of a pane's differences from the truth.
#[derive(Clone, Debug, PartialEq)]
pub enum PaneMetrics<'a> {
    /// There is no truth, and none is asked for.
    Unasked,
    /// Nothing was measured yet.
    Pending,
    /// Of the picture that is asked for and shown.
    Current(&'a Measured),
    /// Of other pictures: what those are, in words.
    Outdated(&'a Measured, Vec<String>),
}

/// A map of differences, `None` where there can be none, with the pictures that it is about.
struct ErrorMap {
    of: Pairing,
    kind: MapKind,
    /// Changes with every map.
    revision: u64,
    map: Option<Texture>,
}

/// What was measured of a pane last.
#[derive(Default)]
pub(super) struct PaneResults {
    figures: Option<Measured>,
    map: Option<ErrorMap>,
}

impl PaneResults {
    /// The last figures.
    pub fn last(&self) -> Option<&Measured> {
        self.figures.as_ref()
    }

    /// The map of these pictures, with its number.
    pub fn map_of(&self, now: &Pairing, kind: MapKind) -> Option<(&Texture, u64)> {
        let known = self.map.as_ref().filter(|known| known.of == *now && known.kind == kind)?;
        Some((known.map.as_ref()?, known.revision))
    }

    /// Forgets what is about no picture that anyone could see again.
    pub fn forget(&mut self) {
        *self = Self::default();
    }

    /// Whether this was measured, or better.
    fn has(&self, pair: &Pairing, purpose: Purpose) -> bool {
        match purpose {
            Purpose::Figures => self.figures.as_ref().is_some_and(|known| {
                known.of.is_of(pair) && known.of.truth.samples.unwrap_or(0) >= pair.truth.samples.unwrap_or(0)
            }),
            Purpose::Map(kind) => self.map.as_ref().is_some_and(|known| known.of == *pair && known.kind == kind),
        }
    }
}

/// What two pictures are compared for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Purpose {
    Figures,
    Map(MapKind),
}

/// Maps of differences that are computed beside the interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MapKind {
    Flip,
    Jod,
}

enum Answer {
    Figures(Result<Figures, String>),
    Map(MapKind, Option<Image<f32>>),
}

struct Job {
    pane: PaneId,
    pair: Pairing,
    answer: Receiver<Answer>,
}

/// Compares two pictures at a time.
#[derive(Default)]
pub(super) struct MetricsWorker {
    job: Option<Job>,
    answered: u64,
}

impl MetricsWorker {
    pub fn is_busy(&self) -> bool {
        self.job.is_some()
    }

    /// Starts a comparison unless `results` has it already; true if something is to be
    /// waited for.
    pub fn measure(
        &mut self,
        gpu: &Gpu,
        wake: &Wake,
        (pane, results): (PaneId, &PaneResults),
        (picture, truth): (&Milestone, &Milestone),
        (display, viewing): (Display, Viewing),
        purpose: Purpose,
    ) -> bool {
        let pair = Pairing { picture: picture.identity.clone(), truth: truth.identity.clone(), display, viewing };
        if results.has(&pair, purpose) || picture.texture.size() != truth.texture.size() {
            return false;
        }
        if self.job.is_none() {
            let (sender, answer) = channel();
            let (gpu, wake, picture, truth) = (gpu.clone(), wake.clone(), picture.clone(), truth.clone());
            std::thread::spawn(move || {
                // Nobody listens any more where the window was closed meanwhile.
                let _ = sender.send(compare(&gpu, &picture, &truth, (display, viewing), purpose));
                // Also where it panicked nobody would wait for ever: the channel is closed.
                drop(sender);
                wake.call();
            });
            self.job = Some(Job { pane, pair, answer });
        }
        true
    }

    /// Hands the answer that has arrived to its pane, which `find` finds; true if there was
    /// one.
    pub fn poll<'p>(&mut self, gpu: &Gpu, find: impl FnOnce(PaneId) -> Option<&'p mut PaneResults>) -> bool {
        let Some(job) = &self.job else { return false };
        let answer = match job.answer.try_recv() {
            Err(TryRecvError::Empty) => return false,
            Ok(answer) => Some(answer),
            Err(TryRecvError::Disconnected) => None,
        };
        let Some(Job { pane, pair, .. }) = self.job.take() else { return false };
        self.answered += 1;
        let Some(results) = find(pane) else { return true };
        match answer {
            Some(Answer::Figures(result)) => results.figures = Some(Measured { of: pair, result }),
            Some(Answer::Map(kind, map)) => {
                let map = map.map(|map| upload_scalar(gpu, "difference", &map));
                results.map = Some(ErrorMap { of: pair, kind, revision: self.answered, map });
            }
            None => {
                let result = Err("the comparison stopped unexpectedly; change something to try again".into());
                results.figures = Some(Measured { of: pair, result });
            }
        }
        true
    }
}

fn compare(
    gpu: &Gpu,
    picture: &Milestone,
    truth: &Milestone,
    (display, viewing): (Display, Viewing),
    purpose: Purpose,
) -> Answer {
    let on_cpu = |milestone: &Milestone| -> Arc<ColorImage> {
        milestone.color.clone().unwrap_or_else(|| Arc::new(download(gpu, &milestone.texture)))
    };
    let (a, b) = (on_cpu(picture), on_cpu(truth));
    match purpose {
        Purpose::Figures => {
            let options = CompareOptions { display, viewing, ..Default::default() };
            let figures = metrics::compare(&a, &b, &options).map(|m| Figures {
                identical: m.identical,
                psnr_db: m.psnr_db,
                ssim: m.ssim,
                flip: m.flip,
                px_per_degree: m.px_per_degree,
                jod: m.jod,
            });
            Answer::Figures(figures.map_err(|e| e.to_string()))
        }
        Purpose::Map(kind @ MapKind::Flip) => {
            Answer::Map(kind, metrics::flip_map(&a, &b, display, viewing.px_per_degree as f32).ok())
        }
        Purpose::Map(kind @ MapKind::Jod) => {
            let found = metrics::jod_map(&a, &b, display, &viewing).ok().flatten();
            Answer::Map(kind, found.map(|found| found.map))
        }
    }
}
