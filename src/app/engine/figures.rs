//! How far panes are from the truth, measured beside the interface on a thread.

use super::pane::Milestone;
use crate::app::document::PaneId;
use crate::display::Display;
use crate::gpu::{Gpu, Texture, download, upload_scalar};
use crate::image::Image;
use crate::metrics::{self, CompareOptions, DEFAULT_PIXELS_PER_DEGREE};
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
    /// Lens points of the truth.
    pub samples: Option<u32>,
}

/// Which two pictures were compared, and how they were shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pair {
    picture: u64,
    truth: u64,
    display: Display,
}

/// What is known about a pane's differences.
#[derive(Default)]
pub struct Judged {
    figures: Option<(Pair, Result<Figures, String>)>,
    map: Option<(Pair, Option<Texture>)>,
}

impl Judged {
    /// The last figures; an error says why there are none.
    pub fn last(&self) -> Option<&Result<Figures, String>> {
        self.figures.as_ref().map(|(_, figures)| figures)
    }

    /// The last FLIP map.
    pub(super) fn map(&self) -> Option<&Texture> {
        self.map.as_ref()?.1.as_ref()
    }

    /// What the last FLIP map is about.
    pub(super) fn map_pair(&self) -> Option<Pair> {
        self.map.as_ref().map(|(pair, _)| *pair)
    }

    /// Forgets figures that belong to another picture than the one seen.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }
}

/// What a comparison is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Purpose {
    Figures,
    FlipMap,
}

enum Verdict {
    Figures(Result<Figures, String>),
    FlipMap(Option<Image<f32>>),
}

struct Job {
    pane: PaneId,
    pair: Pair,
    answer: Receiver<Verdict>,
}

/// Compares two pictures at a time.
#[derive(Default)]
pub(super) struct Judge {
    job: Option<Job>,
}

impl Judge {
    pub fn is_busy(&self) -> bool {
        self.job.is_some()
    }

    /// Starts a comparison unless `judged` has it already; true if something is to be
    /// waited for.
    pub fn judge(
        &mut self,
        gpu: &Gpu,
        pane: PaneId,
        judged: &Judged,
        (picture, truth): (&Milestone, &Milestone),
        display: Display,
        purpose: Purpose,
    ) -> bool {
        let pair = Pair { picture: picture.revision, truth: truth.revision, display };
        let done = match purpose {
            Purpose::Figures => judged.figures.as_ref().map(|(pair, _)| *pair),
            Purpose::FlipMap => judged.map.as_ref().map(|(pair, _)| *pair),
        };
        if done == Some(pair) || picture.texture.size() != truth.texture.size() {
            return false;
        }
        if self.job.is_none() {
            let (sender, answer) = channel();
            let (gpu, picture, truth) = (gpu.clone(), picture.clone(), truth.clone());
            std::thread::spawn(move || {
                // Nobody listens any more where the window was closed meanwhile.
                let _ = sender.send(compare(&gpu, &picture, &truth, display, purpose));
            });
            self.job = Some(Job { pane, pair, answer });
        }
        true
    }

    /// Hands the answer that has arrived to its pane, which `find` finds.
    pub fn poll<'p>(&mut self, gpu: &Gpu, find: impl FnOnce(PaneId) -> Option<&'p mut Judged>) {
        let Some(job) = &self.job else { return };
        let verdict = match job.answer.try_recv() {
            Err(TryRecvError::Empty) => return,
            Ok(verdict) => Some(verdict),
            Err(TryRecvError::Disconnected) => None,
        };
        let (pane, pair) = (job.pane, job.pair);
        self.job = None;
        let Some(judged) = find(pane) else { return };
        match verdict {
            Some(Verdict::Figures(figures)) => judged.figures = Some((pair, figures)),
            Some(Verdict::FlipMap(map)) => {
                judged.map = Some((pair, map.map(|map| upload_scalar(gpu, "FLIP", &map))));
            }
            None => judged.figures = Some((pair, Err("the comparison stopped unexpectedly".into()))),
        }
    }
}

fn compare(gpu: &Gpu, picture: &Milestone, truth: &Milestone, display: Display, purpose: Purpose) -> Verdict {
    let (a, b) = (download(gpu, &picture.texture), download(gpu, &truth.texture));
    match purpose {
        Purpose::Figures => {
            let options = CompareOptions { display, ..Default::default() };
            let figures = metrics::compare(&a, &b, &options).map(|m| Figures {
                identical: m.identical,
                psnr_db: m.psnr_db,
                ssim: m.ssim,
                flip: m.flip,
                samples: truth.samples,
            });
            Verdict::Figures(figures.map_err(|e| e.to_string()))
        }
        Purpose::FlipMap => Verdict::FlipMap(metrics::flip_map(&a, &b, display, DEFAULT_PIXELS_PER_DEGREE).ok()),
    }
}
