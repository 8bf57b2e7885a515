//! `accumulation`: the reference, as many views as there are lens points.
//!
//! Haeberli and Akeley, "The Accumulation Buffer: Hardware Support for High-Quality
//! Rendering" (SIGGRAPH 1990): the eye moves over the lens, the projection is sheared so
//! that the plane at the focus distance stays where it is, and the views are averaged.
//! Pixels are not jittered, so that a pixel in focus equals the pinhole image's.

use super::{About, Apertures, Converging, Method, MethodError, Param};
use crate::gpu::{Frame, Gpu, Shader, Texture};
use crate::image::ColorImage;
use crate::lens::Lens;
use crate::shader;
use crate::uniform;
use crate::view::View;

const SHADER: Shader = shader!("methods/accumulation");

/// Sums are 32-bit: added up in f16, 1024 views lose 15 % of their light on adapters that
/// truncate.
const SUM: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// Views submitted at once: enough to keep a GPU busy, few enough to cancel promptly.
const BATCH: u32 = 16;

/// Accumulation over lens points.
#[derive(Clone, Debug)]
pub struct Accumulation {
    /// Number of lens points.
    pub samples: u32,
    /// Whether shading looks from each lens point, or from the lens centre.
    pub view_dependent: bool,
}

impl Default for Accumulation {
    fn default() -> Self {
        Self { samples: 64, view_dependent: false }
    }
}

uniform! {
    struct MeanUniform {
        reciprocal_count: f32,
    }
}

impl Method for Accumulation {
    fn about(&self) -> About {
        About {
            id: "accumulation",
            title: "Accumulation buffer",
            paper: "Haeberli and Akeley, The Accumulation Buffer, SIGGRAPH 1990",
            summary: "The mean of many views over the lens: right for every scene as the number of views grows.",
            limits: "Draws the scene once for every lens point; with few, ghosts show, and glass is grainy.",
            apertures: Apertures::Any,
            astigmatism: true,
            needs_scene: true,
            conserves_energy: true,
            averages: true,
            samples_lens: true,
        }
    }

    fn params(&mut self) -> Vec<Param<'_>> {
        vec![
            Param::int("samples", "Lens points", "", &mut self.samples, (1, 4096), "Views over the lens.")
                .trading(&["8", "32", "128"]),
            Param::switch(
                "view_dependent",
                "View-dependent shading",
                &mut self.view_dependent,
                "Shade from each lens point, so that reflections shift; otherwise a surface emits what the pinhole image shows.",
            ),
        ]
    }

    fn record(&self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Result<Texture, MethodError> {
        let mut run = AccumulationRun::new(self.view_dependent);
        while run.count() < self.samples {
            let batch = BATCH.min(self.samples - run.count());
            run.advance(frame, view, lens, batch)?;
            frame.flush();
        }
        Ok(run.mean(frame))
    }

    fn converging(&self) -> Option<(Box<dyn Converging>, u32)> {
        Some((Box::new(AccumulationRun::new(self.view_dependent)), self.samples.max(1)))
    }

    fn boxed(&self) -> Box<dyn Method> {
        Box::new(self.clone())
    }
}

/// The mean of images that come one by one.
#[derive(Default)]
pub(super) struct RunningMean {
    count: u32,
    sum: Option<Texture>,
}

impl RunningMean {
    /// Images so far.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Adds an image, of the same size as those before.
    pub fn add(&mut self, frame: &mut Frame<'_>, image: &Texture) {
        let next = frame.texture("sum of views", image.size(), SUM);
        match &self.sum {
            None => frame.pass(&SHADER, "first_view").texture("view", image).texture("next", &next),
            Some(sum) => {
                frame.pass(&SHADER, "add_view").texture("view", image).texture("sum", sum).texture("next", &next)
            }
        }
        .dispatch(image.size());
        self.sum = Some(next);
        self.count += 1;
    }

    /// The mean, RGBA32F; `None` before the first image.
    pub fn mean(&self, frame: &mut Frame<'_>) -> Option<Texture> {
        let sum = self.sum.as_ref()?;
        let mean = frame.texture("mean of views", sum.size(), SUM);
        let scale = MeanUniform { reciprocal_count: 1.0 / self.count as f32 };
        frame
            .pass(&SHADER, "mean_of_views")
            .texture("sum", sum)
            .texture("next", &mean)
            .uniform("scale", &scale)
            .dispatch(sum.size());
        Some(mean)
    }
}

/// An accumulation under way: it can be looked at, carried on or given up at any time.
pub struct AccumulationRun {
    view_dependent: bool,
    sum: RunningMean,
    /// The sum as it was at the last two powers of two, the older first, with those counts.
    snapshots: Vec<(Texture, u32)>,
}

impl AccumulationRun {
    /// A run with no views yet.
    pub fn new(view_dependent: bool) -> Self {
        Self { view_dependent, sum: RunningMean::default(), snapshots: Vec::new() }
    }

    /// The means over two disjoint sets of lens points, whose difference tells how far the
    /// run has converged: the points up to the last power of two, and those after it.
    /// `None` until both are there.
    pub fn halves(&self, gpu: &Gpu) -> Option<[ColorImage; 2]> {
        let (half, half_count) = self.snapshots.iter().rev().find(|(_, count)| *count < self.count())?;
        let rest = self.count() - half_count;
        let first = crate::gpu::download(gpu, half);
        let all = crate::gpu::download(gpu, self.sum.sum.as_ref()?);
        let pixels = all.pixels.iter().zip(&first.pixels).map(|(a, f)| (*a - *f) / rest as f32).collect();
        let second = ColorImage { size: all.size, pixels };
        Some([first.map(|p| p / *half_count as f32), second])
    }
}

impl Converging for AccumulationRun {
    fn count(&self) -> u32 {
        self.sum.count()
    }

    fn advance(&mut self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens, n: u32) -> Result<(), MethodError> {
        for index in self.count()..self.count() + n {
            let v = lens.aperture.lens_point(index);
            let color = view.from_lens_point(frame, lens, v, index, self.view_dependent)?.color;
            self.sum.add(frame, &color);
            if let Some(sum) = self.sum.sum.clone().filter(|_| self.count().is_power_of_two()) {
                self.snapshots.push((sum, self.count()));
                if self.snapshots.len() > 2 {
                    self.snapshots.remove(0);
                }
            }
        }
        Ok(())
    }

    fn mean(&self, frame: &mut Frame<'_>) -> Texture {
        self.sum.mean(frame).expect("a mean needs at least one view")
    }
}
