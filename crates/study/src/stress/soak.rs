//! Many frames: whatever one of them leaves behind adds up.

use super::scenes::SCENES;
use crate::{Progress, StudyError, step};
use defocus::gpu::Gpu;
use defocus::lens::Lens;
use defocus::methods::{self, Method};
use defocus::view::View;
use glam::{UVec2, uvec2};

/// Frames after which every method has run at every size several times: what they need
/// has been allocated.
pub const WARM_UP_FRAMES: u32 = 240;

/// Frames between two sizes of the window.
const FRAMES_A_SIZE: u32 = 30;

const SIZES: [UVec2; 4] = [uvec2(64, 48), uvec2(37, 53), uvec2(96, 20), uvec2(48, 48)];

/// Memory before and after many frames, bytes.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Soak {
    /// Frames after the warm-up.
    pub frames: u32,
    /// Most that the pool held during the warm-up.
    pub pool_warm_bytes: u64,
    /// Most that it held afterwards.
    pub pool_bytes: u64,
    /// What the process held after the warm-up; `None` where the system does not tell.
    pub process_warm_bytes: Option<u64>,
    /// What it held at the end.
    pub process_bytes: Option<u64>,
}

impl Soak {
    /// Growth of the process a frame, bytes.
    pub fn process_growth_a_frame(&self) -> Option<f64> {
        let growth = self.process_bytes? as f64 - self.process_warm_bytes? as f64;
        Some(growth / f64::from(self.frames.max(1)))
    }

    /// Whether memory stayed bounded: the pool's at what the warm-up needed, the process's
    /// within [`GROWTH_A_FRAME_BYTES`].
    pub fn is_bounded(&self) -> bool {
        let process = self.process_growth_a_frame().is_none_or(|growth| growth < GROWTH_A_FRAME_BYTES);
        process && self.pool_bytes <= self.pool_warm_bytes
    }
}

/// Less than the smallest texture of any frame here (a page): growth below it is the
/// allocator's, and a frame that kept a single texture or buffer would exceed it.
pub const GROWTH_A_FRAME_BYTES: f64 = 4096.0;

/// Renders `frames` frames after a warm-up with all methods in turn while focus, aperture
/// and size change.
///
/// # Errors
///
/// [`StudyError::Stopped`], and what methods say.
pub fn soak(
    gpu: &Gpu,
    methods: &[Box<dyn Method>],
    frames: u32,
    progress: &mut Progress<'_>,
) -> Result<Soak, StudyError> {
    let specimen = SCENES[0].specimen(gpu)?;
    let (mut view, lens) = (specimen.view, specimen.lens);
    let mut pool = [0_u64; 2];
    let mut process_warm_bytes = None;
    for index in 0..WARM_UP_FRAMES + frames {
        let warm = index >= WARM_UP_FRAMES;
        if index % 16 == 0 {
            step(progress, "soak", index, WARM_UP_FRAMES + frames)?;
        }
        if index == WARM_UP_FRAMES {
            process_warm_bytes = process_bytes();
        }
        let size = SIZES[(index / FRAMES_A_SIZE) as usize % SIZES.len()];
        view.set_size(gpu, size, 4)?;
        frame(gpu, &*methods[index as usize % methods.len()], &mut view, &at_frame(&lens, index))?;
        let held = &mut pool[usize::from(warm)];
        *held = (*held).max(gpu.pooled_bytes());
    }
    Ok(Soak {
        frames,
        pool_warm_bytes: pool[0],
        pool_bytes: pool[1],
        process_warm_bytes,
        process_bytes: process_bytes(),
    })
}

fn frame(gpu: &Gpu, method: &dyn Method, view: &mut View, lens: &Lens) -> Result<(), StudyError> {
    let mut frame = gpu.frame();
    methods::record(method, &mut frame, view, lens)
        .map_err(|source| StudyError::Method { method: method.about().id, source })?;
    // Waiting frees what the frame used: a queue of frames is no leak.
    frame.finish().timings.wait();
    let _ = gpu.device().poll(wgpu::PollType::wait_indefinitely());
    Ok(())
}

/// A slow focus pull with an aperture that breathes.
fn at_frame(lens: &Lens, index: u32) -> Lens {
    let phase = f64::from(index) * 0.05;
    Lens {
        focus_distance_m: lens.focus_distance_m * (1.0 + 0.5 * phase.sin()),
        aperture_diameter_mm: lens.aperture_diameter_mm * (1.5 + (0.7 * phase).cos()),
        ..lens.clone()
    }
}

/// Resident memory of this process; `None` but on Linux.
fn process_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    let kib: u64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(kib * 1024)
}
