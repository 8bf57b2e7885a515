//! Flicker: how restlessly each method's error changes from frame to frame while the focus is
//! pulled slowly, or the camera moves slowly (Lee, Kim and Choi, TVCG 2009, section 7.1).
//!
//! What moves smoothly has small second differences in time. Those of a picture itself also hold
//! what the scene does; so they are taken of the picture *minus the reference*:
//!
//!   flicker = RMS over pixels and frames of e(t-1) - 2 e(t) + e(t+1),   e = method - reference
//!
//! in steps of 8 bits of what a display shows. Noise that is the same in each frame does not
//! flicker, an edge that jumps between texels of a coarse level does.

use crate::bench::tables::{Claim, Comparison};
use crate::source::GpuSource;
use crate::{DepthArgs, Progress, Source, StudyError, render, step};
use defocus::camera::Camera;
use defocus::display::Display;
use defocus::gpu::Gpu;
use defocus::image::ColorImage;
use defocus::lens::Lens;
use defocus::methods::{self, Accumulation, Method};
use defocus::view::{SurfaceOptions, View};
use glam::{UVec2, Vec3, uvec2};

/// What moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// The focus distance: its reciprocal by a hundredth a frame, away from the eye.
    Focus,
    /// The camera, sideways: what is in focus moves by a quarter of a pixel a frame.
    Camera,
}

impl Motion {
    const ALL: [Self; 2] = [Self::Focus, Self::Camera];

    fn name(self) -> &'static str {
        match self {
            Self::Focus => "focus pull",
            Self::Camera => "camera move",
        }
    }
}

/// How far the camera moves a frame, px of what is in focus: not a fraction that a pyramid's grid
/// meets again after a few frames.
const CAMERA_STEP_PX: f64 = 0.23;

/// By how much the reciprocal of the focus distance falls a frame.
const FOCUS_STEP: f64 = 0.01;

/// What is measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// A built-in scene, or a file with one.
    pub scene: String,
    /// Size of the images, px.
    pub size: UVec2,
    /// Mean CoC diameter, px, at the first frame.
    pub mean_coc_px: f64,
    /// Frames of each motion, three at least.
    pub frames: u32,
    /// Lens points of the reference.
    pub samples: u32,
    /// Whether methods are as their sources published them.
    pub as_published: bool,
}

impl Plan {
    /// The table's, `quick` or not.
    pub fn table(quick: bool) -> Self {
        let size = if quick { uvec2(128, 96) } else { uvec2(512, 384) };
        let (frames, samples) = if quick { (6, 32) } else { (24, 256) };
        // As large over the image as 16 px at 512x384.
        let mean_coc_px = 16.0 * f64::from(size.x) / 512.0;
        Self { scene: "cans".into(), size, mean_coc_px, frames, samples, as_published: true }
    }
}

/// Flicker of a method, in steps of 8 bits: over a focus pull and over a camera move; `None` where
/// it could not render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flicker {
    /// The method's id.
    pub method: &'static str,
    /// By [`Motion`], in the order of the table.
    pub steps: [f64; 2],
}

/// The flicker of every method but the references.
///
/// # Errors
///
/// A scene that cannot be opened or blurred, [`StudyError::Stopped`].
pub fn flicker(gpu: &Gpu, plan: &Plan, progress: &mut Progress<'_>) -> Result<Vec<Flicker>, StudyError> {
    let source = Source::open(&plan.scene, &DepthArgs::default())?.upload(gpu, SurfaceOptions::default());
    let mut all = methods::all();
    all.retain(|method| method.about().id != "accumulation");
    if plan.as_published {
        all.iter_mut().for_each(|method| methods::set_as_published(method.as_mut()));
    }
    let mut results: Vec<_> = all.iter().map(|m| Flicker { method: m.about().id, steps: [0.0; 2] }).collect();
    for (which, motion) in Motion::ALL.into_iter().enumerate() {
        let sums = of_motion(gpu, plan, &source, motion, &all, progress)?;
        for (result, sum) in results.iter_mut().zip(sums) {
            result.steps[which] = sum;
        }
    }
    Ok(results)
}

fn of_motion(
    gpu: &Gpu,
    plan: &Plan,
    source: &GpuSource,
    motion: Motion,
    methods: &[Box<dyn Method>],
    progress: &mut Progress<'_>,
) -> Result<Vec<f64>, StudyError> {
    let mut stage = Stage::new(gpu, plan, source)?;
    let reference = Accumulation { samples: plan.samples, view_dependent: false };
    // Errors of the last two frames, and the sum of squares so far.
    let mut histories: Vec<History> = methods.iter().map(|_| History::default()).collect();
    for frame in 0..plan.frames {
        step(progress, motion.name(), frame, plan.frames)?;
        let lens = stage.at(motion, frame);
        let truth = shown(&render(gpu, &mut stage.view, &lens, &reference)?.color);
        for (method, history) in methods.iter().zip(&mut histories) {
            let picture = shown(&render(gpu, &mut stage.view, &lens, method.as_ref())?.color);
            history.add(picture.iter().zip(&truth).map(|(a, b)| *a - *b).collect());
        }
    }
    Ok(histories.iter().map(History::rms).collect())
}

/// What a display shows of an image, in steps of 8 bits.
fn shown(image: &ColorImage) -> Vec<Vec3> {
    Display::default().encoded_image(image).pixels.iter().map(|c| 255.0 * *c).collect()
}

/// Errors of the last frames.
#[derive(Default)]
struct History {
    before: Vec<Vec<Vec3>>,
    sum: f64,
    count: f64,
}

impl History {
    fn add(&mut self, error: Vec<Vec3>) {
        if let [first, second] = &self.before[..] {
            for ((a, b), c) in first.iter().zip(second).zip(&error) {
                self.sum += f64::from((*a - 2.0 * *b + *c).length_squared()) / 3.0;
                self.count += 1.0;
            }
            self.before.remove(0);
        }
        self.before.push(error);
    }

    fn rms(&self) -> f64 {
        (self.sum / self.count.max(1.0)).sqrt()
    }
}

/// The view and the lens at the first frame.
struct Stage {
    view: View,
    lens: Lens,
    camera: Camera,
}

impl Stage {
    fn new(gpu: &Gpu, plan: &Plan, source: &GpuSource) -> Result<Self, StudyError> {
        let mut view = source.view(0, plan.size, 0, None)?;
        let depth_m = view.depth_m(gpu);
        let lens = source.source().default_lens(&depth_m);
        let lens = lens.with_mean_coc(plan.mean_coc_px, depth_m.pixels.iter().copied()).unwrap_or(lens);
        let camera = view.camera().copied();
        let camera = camera.ok_or(defocus::view::ViewError::ImageHasNo("camera that moves"))?;
        Ok(Self { view, lens, camera })
    }

    /// Moves what moves and returns the lens.
    fn at(&mut self, motion: Motion, frame: u32) -> Lens {
        let frame = f64::from(frame);
        let focus_m = self.lens.focus_distance_m;
        match motion {
            Motion::Focus => {
                // Less light-gathering for a farther focus, so that K stays.
                let farther =
                    Lens { focus_distance_m: focus_m / (1.0 - FOCUS_STEP * frame).max(0.1), ..self.lens.clone() };
                let scale = self.lens.k_px() / farther.k_px();
                Lens { aperture_diameter_mm: farther.aperture_diameter_mm * scale, ..farther }
            }
            Motion::Camera => {
                let step_m = CAMERA_STEP_PX * focus_m / self.view.projection().focal_px;
                let right = self.camera.orientation * glam::DVec3::X;
                let position = self.camera.position + frame * step_m * right;
                self.view.set_camera(Camera { position, ..self.camera });
                self.lens.clone()
            }
        }
    }
}

/// The table, beside what the paper says.
pub fn compared(plan: &Plan, adapter: &str, flickers: &[Flicker]) -> Comparison {
    let number = |value: f64| format!("{value:.2}");
    let row = |f: &Flicker| vec![f.method.to_owned(), number(f.steps[0]), number(f.steps[1])];
    let of = |id: &str| flickers.iter().find(|f| f.method == id).map(|f| f.steps);
    let restless = |ids: [&str; 2]| ids.map(of);
    let (calm, other) = (restless(["mipmap", "separable"]), restless(["pyramid", "preblur"]));
    let all = |steps: [Option<[f64; 2]>; 2]| Some([steps[0]?, steps[1]?]);
    let holds = all(calm).zip(all(other)).map(|(calm, other)| {
        (0..2).all(|motion| {
            let most = calm.iter().map(|s| s[motion]).fold(0.0, f64::max);
            let least = other.iter().map(|s| s[motion]).fold(f64::INFINITY, f64::min);
            most <= least
        })
    });
    let words = |id: &str| of(id).map_or_else(|| "–".into(), |s| format!("{id} {:.2} and {:.2}", s[0], s[1]));
    let measured = ["mipmap", "separable", "pyramid", "preblur"].map(words).join(", ");
    let methods = if plan.as_published { "as published" } else { "with their defaults" };
    Comparison {
        title: "TVCG 2009, section 7.1: temporal flickering".into(),
        setting: format!(
            "{}, {}x{} px, {adapter}, mean CoC {} px, {} frames a motion, reference of {} lens points. Methods {methods}.",
            plan.scene, plan.size.x, plan.size.y, plan.mean_coc_px, plan.frames, plan.samples
        ),
        columns: ["method", "focus pull: steps of 8 bits", "camera move"].map(str::to_owned).to_vec(),
        rows: flickers.iter().map(row).collect(),
        claims: vec![Claim {
            paper: format!("\"{QUOTE}\""),
            measured: format!("{measured}; mipmap and separable no more than the two others, in both motions"),
            holds,
            reason: if holds == Some(false) { REASON.into() } else { String::new() },
        }],
        notes: vec![
            "RMS of the second difference in time of what a method shows less the reference. `pinhole` flickers as the reference's blur moves over it, and `multiview` by noise that differs where the scene does.".into(),
        ],
    }
}

/// Of the paper's section 7.1.
pub const QUOTE: &str =
    "the methods of Zhou and ours are adequate for dynamic environments with respect to temporal flickering";

const REASON: &str = "The second difference also holds how the error itself moves with the scene: a method that is wrong by much at edges is counted for that too.";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_changes_evenly_does_not_flicker_and_what_alternates_does() {
        let of = |value: &dyn Fn(usize) -> f32| {
            let mut history = History::default();
            (0..6).for_each(|t| history.add(vec![Vec3::splat(value(t)); 4]));
            history.rms()
        };
        assert_eq!(of(&|t| 3.0 * t as f32), 0.0);
        assert!((of(&|t| (t % 2) as f32) - 2.0).abs() < 1e-6);
    }

    #[test]
    fn the_quoted_sentence_is_in_the_paper() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/papers");
        let Ok(files) = std::fs::read_dir(folder) else { return };
        let texts = files.flatten().filter_map(|f| std::fs::read_to_string(f.path()).ok());
        let words = |text: &str| text.replace("-\n", "").split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(texts.map(|text| words(&text)).any(|text| text.contains(QUOTE)));
    }
}
