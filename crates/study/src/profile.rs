//! Where the time of methods goes, on the adapter at hand: no truth is drawn, no picture is
//! kept.

use super::render::gpu_ms;
use super::timing::{RunTimes, copy_once};
use super::{Progress, StudyError, step};
use defocus::gpu::{Frame, FrameStats, Gpu, PassTime, Texture};
use defocus::lens::Lens;
use defocus::methods::{self, Method};
use defocus::view::View;
use serde::Serialize;
use std::time::{Duration, Instant};

/// What changes from one frame to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum While {
    /// Nothing: what a view and a method keep is there.
    Still,
    /// The focus distance, by a hundredth: what depends on the lens is made anew.
    Lens,
    /// The camera: the scene is drawn anew, as a draft ([`View::set_draft`]).
    Camera,
}

/// How methods are profiled.
#[derive(Clone, Copy, Debug)]
pub struct ProfileRequest {
    /// What changes between frames.
    pub during: While,
    /// Frames of each kind, at least 1: timed one by one, recorded, and back to back.
    pub runs: u32,
    /// Fewer frames are taken where those of one kind take longer than this altogether;
    /// at least one is.
    pub most: Duration,
    /// Whether texture reads are counted, in a frame of its own.
    pub count_reads: bool,
}

/// Frames before the timed ones: they compile pipelines and fill pools.
const WARM_UP: u32 = 2;

/// What one method costs. Times in ms; counts of one frame.
#[derive(Clone, Debug, Serialize)]
pub struct MethodProfile {
    /// The method's id.
    pub method: &'static str,
    /// Sum of the passes' GPU times, the median frame's. Of a software adapter: processor
    /// time. Null without timestamps and with more passes than can be timed.
    pub gpu_ms: Option<f64>,
    /// Ends of the 95 % interval of that median.
    pub gpu_ms_95: Option<[f64; 2]>,
    /// The same over the time of a copy of the image.
    pub copy_ratio: Option<f64>,
    /// Time a frame takes where many are submitted without waiting.
    pub back_to_back_ms: f64,
    /// CPU time of recording a frame, without submitting it.
    pub record_ms: f64,
    /// Passes recorded: dispatches, draws and scene views.
    pub passes: u64,
    /// Dispatches among them, indirect ones included.
    pub dispatches: u64,
    /// Dispatches whose grid the GPU decides.
    pub indirect_dispatches: u64,
    /// Views of the scene that were drawn.
    pub scene_draws: u64,
    /// Triangles in them.
    pub triangles: u64,
    /// Texture reads a pixel, where they were counted.
    pub reads_per_px: Option<f64>,
    /// Most bytes of textures in use at once.
    pub peak_texture_bytes: u64,
    /// Most bytes of buffers in use at once.
    pub peak_buffer_bytes: u64,
    /// The sum of both.
    pub peak_bytes: u64,
    /// GPU time of the passes of one label together, the median frame's, most expensive
    /// first; empty without timestamps.
    pub pass_times: Vec<PassTime>,
}

/// Profiles one method on one view.
///
/// # Errors
///
/// What the method says, [`StudyError::Stopped`].
pub fn profile(
    gpu: &Gpu,
    view: &mut View,
    lens: &Lens,
    method: &dyn Method,
    request: &ProfileRequest,
    progress: &mut Progress<'_>,
) -> Result<MethodProfile, StudyError> {
    // It holds nothing that another method left there, and is a draft while the camera moves.
    view.redraw();
    view.set_draft(request.during == While::Camera);
    let mut stage = Stage { gpu, view, lens, method, during: request.during, frames: 0 };
    for _ in 0..WARM_UP {
        let mut frame = gpu.frame();
        stage.record(&mut frame)?;
        frame.finish().timings.wait();
    }
    let times = stage.timed(request, progress)?;
    let record_ms = stage.recorded(request, progress)?;
    let back_to_back_ms = stage.back_to_back(request, progress)?;
    let reads_per_px = if request.count_reads { Some(stage.reads_per_px()?) } else { None };
    let FrameStats { passes, dispatches, indirect_dispatches, peak_texture_bytes, peak_buffer_bytes, .. } = times.stats;
    let gpu_ms = RunTimes::of(&times.gpu_ms);
    Ok(MethodProfile {
        method: method.about().id,
        gpu_ms: gpu_ms.map(|t| t.median),
        gpu_ms_95: gpu_ms.map(|t| [t.low, t.high]),
        copy_ratio: RunTimes::of(&times.ratios).map(|t| t.median),
        back_to_back_ms,
        record_ms,
        passes,
        dispatches,
        indirect_dispatches,
        scene_draws: times.stats.views,
        triangles: times.stats.triangles,
        reads_per_px,
        peak_texture_bytes,
        peak_buffer_bytes,
        peak_bytes: times.stats.peak_bytes(),
        pass_times: medians(&times.passes),
    })
}

/// One method under one kind of change.
struct Stage<'a> {
    gpu: &'a Gpu,
    view: &'a mut View,
    lens: &'a Lens,
    method: &'a dyn Method,
    during: While,
    frames: u32,
}

#[derive(Default)]
struct Times {
    gpu_ms: Vec<f64>,
    ratios: Vec<f64>,
    /// Of each frame the passes by label.
    passes: Vec<Vec<PassTime>>,
    /// Of the last frame.
    stats: FrameStats,
}

impl Stage<'_> {
    /// Records the next frame, with its change.
    fn record(&mut self, frame: &mut Frame<'_>) -> Result<Texture, StudyError> {
        self.frames += 1;
        let mut lens = self.lens.clone();
        match self.during {
            While::Still => {}
            While::Lens if self.frames.is_multiple_of(2) => lens.focus_distance_m *= 1.01,
            While::Lens => {}
            While::Camera => self.view.redraw(),
        }
        methods::record(self.method, frame, self.view, &lens)
            .map_err(|source| StudyError::Method { method: self.method.about().id, source })
    }

    fn timed(&mut self, request: &ProfileRequest, progress: &mut Progress<'_>) -> Result<Times, StudyError> {
        let (mut times, start) = (Times::default(), Instant::now());
        for run in 0..request.runs.max(1) {
            if run > 0 && start.elapsed() > request.most {
                break;
            }
            step(progress, self.method.about().id, run, request.runs)?;
            let copy_ms = copy_once(self.gpu, self.view);
            let mut frame = self.gpu.timed_frame();
            self.record(&mut frame)?;
            let submitted = frame.finish();
            let passes = submitted.timings.wait();
            if let Some(ms) = gpu_ms(&passes, &submitted.stats) {
                times.gpu_ms.push(ms);
                times.ratios.extend(copy_ms.filter(|copy| *copy > 0.0).map(|copy| ms / copy));
            }
            times.passes.push(passes);
            times.stats = submitted.stats;
        }
        Ok(times)
    }

    /// Time of recording, ms: into an encoder that is submitted afterwards, which costs the
    /// same whether anyone waits for it.
    fn recorded(&mut self, request: &ProfileRequest, progress: &mut Progress<'_>) -> Result<f64, StudyError> {
        let (mut times_ms, start) = (Vec::new(), Instant::now());
        for run in 0..request.runs.max(1) {
            if run > 0 && start.elapsed() > request.most {
                break;
            }
            step(progress, self.method.about().id, run, request.runs)?;
            // Passes are recorded one by one where what to record depends on a wait.
            let mut frame = self.gpu.frame();
            self.view.z_bounds(&mut frame);
            frame.finish();
            let begin = Instant::now();
            let mut encoder = self.gpu.device().create_command_encoder(&Default::default());
            let mut recorder = self.gpu.recorder(&mut encoder);
            let _picture = self.record(&mut recorder)?;
            recorder.finish();
            let commands = encoder.finish();
            times_ms.push(begin.elapsed().as_secs_f64() * 1e3);
            self.gpu.queue().submit([commands]);
            self.wait();
        }
        Ok(RunTimes::of(&times_ms).map_or(0.0, |t| t.median))
    }

    fn back_to_back(&mut self, request: &ProfileRequest, progress: &mut Progress<'_>) -> Result<f64, StudyError> {
        // Frames in flight beyond which their memory counts and not their time.
        const MOST: u32 = 30;
        step(progress, self.method.about().id, request.runs, request.runs)?;
        self.wait();
        let (mut count, start) = (0, Instant::now());
        while count == 0 || (count < MOST.min(request.runs) && start.elapsed() < request.most) {
            let mut frame = self.gpu.frame();
            self.record(&mut frame)?;
            frame.finish();
            count += 1;
        }
        self.wait();
        Ok(start.elapsed().as_secs_f64() * 1e3 / f64::from(count))
    }

    fn reads_per_px(&mut self) -> Result<f64, StudyError> {
        let mut frame = self.gpu.frame();
        let reads = frame.count_texture_reads();
        self.record(&mut frame)?;
        let count = frame.read_buffer::<u64>(&reads).first().copied().unwrap_or(0);
        frame.finish();
        Ok(count as f64 / f64::from(self.view.size().element_product()))
    }

    fn wait(&self) {
        // A lost device answers with an error, which other calls report.
        let _ = self.gpu.device().poll(wgpu::PollType::wait_indefinitely());
    }
}

/// Of each label the median over the frames of the sum of its passes, the greatest first.
fn medians(frames: &[Vec<PassTime>]) -> Vec<PassTime> {
    let mut labels: Vec<&str> = Vec::new();
    for pass in frames.iter().flatten() {
        if !labels.contains(&pass.label.as_str()) {
            labels.push(&pass.label);
        }
    }
    let median = |label: &&str| {
        let of_frame = |frame: &Vec<PassTime>| frame.iter().filter(|p| p.label == *label).map(|p| p.ms).sum();
        let sums: Vec<f64> = frames.iter().map(of_frame).collect();
        PassTime { label: (*label).to_owned(), ms: RunTimes::of(&sums).map_or(0.0, |t| t.median) }
    };
    let mut passes: Vec<PassTime> = labels.iter().map(median).collect();
    passes.sort_by(|a, b| b.ms.total_cmp(&a.ms));
    passes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_of_one_label_are_added_up_and_sorted() {
        let pass = |label: &str, ms| PassTime { label: label.into(), ms };
        let frames = vec![
            vec![pass("a", 1.0), pass("b", 5.0), pass("a", 2.0)],
            vec![pass("a", 2.0), pass("b", 7.0), pass("a", 3.0)],
            vec![pass("a", 9.0), pass("b", 6.0), pass("a", 9.0)],
        ];
        assert_eq!(medians(&frames), [pass("b", 6.0), pass("a", 5.0)]);
        assert_eq!(medians(&[]), []);
    }
}
