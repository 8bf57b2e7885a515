//! Extremes of a pinhole image (depth, depth steps, radiance), on the CPU: which passes are recorded
//! depends on them.
//!
//! A frame of its own waits for them once after each redraw. One that records into another program's
//! encoder ([`Recorder`](crate::gpu::Recorder)) may not: there the numbers arrive after the
//! host has submitted, and until then the worst is assumed, or what the host promises.

use super::{Layer, View};
use crate::gpu::{Buffer, Frame};
use crate::lens::{GREATEST_COC_PX, Lens};
use crate::shader;
use std::sync::{Arc, OnceLock};

const DEPTH_BOUNDS: crate::gpu::Shader = shader!("depth_bounds");

/// Extremes over the outer pinhole image.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Summary {
    z_bounds: [f32; 2],
    greatest_z_step: f32,
    brightest: f32,
}

impl Summary {
    /// From the bits of numbers that are not negative, which order as the numbers do.
    fn of(bits: &[u32]) -> Self {
        let [low, high, greatest_z_step, brightest] =
            [0, 1, 2, 3].map(|i| f32::from_bits(bits.get(i).copied().unwrap_or(0)));
        Self { z_bounds: [low, high], greatest_z_step, brightest }
    }

    /// The worst that an image with these bounds of stored depth can be.
    fn worst(z_bounds: [f32; 2]) -> Self {
        Self { z_bounds, greatest_z_step: z_bounds[1] - z_bounds[0], brightest: f32::MAX }
    }
}

/// A summary whose read-back is pending.
struct Awaited {
    buffer: wgpu::Buffer,
    /// Whether the buffer is mapped, once that is known.
    ready: Arc<OnceLock<bool>>,
}

/// What is known of the image so far.
#[derive(Default)]
pub(super) struct Known {
    summary: Option<Summary>,
    awaited: Option<Awaited>,
    /// Bounds of stored depth that the host promises.
    promised: Option<[f32; 2]>,
}

impl Known {
    /// The image changes: only what is promised still holds.
    pub fn forget(&mut self) {
        *self = Self { promised: self.promised, ..Self::default() };
    }

    /// Takes in what has arrived.
    fn arrived(&mut self) -> Option<Summary> {
        let is_good = *self.awaited.as_ref()?.ready.get()?;
        let buffer = self.awaited.take()?.buffer;
        // What cannot be read is asked for again.
        let bytes = if is_good { buffer.get_mapped_range(..).ok()?.to_vec() } else { return None };
        self.summary = Some(Summary::of(&bytemuck::pod_collect_to_vec(&bytes)));
        self.summary
    }
}

impl View {
    /// Promises that everything to be seen lies between these distances along the optical
    /// axis, metres, the farther one infinite where the background shows: what frames of a
    /// [`Recorder`](crate::gpu::Recorder) go by until they know better. What lies elsewhere
    /// all the same is blurred as if it lay there. Holds until it is called again; `None`
    /// takes the promise back.
    pub fn set_depth_range_m(&mut self, range_m: Option<[f64; 2]>) {
        let near_m = self.projection.near_m;
        // A distance that is no number promises nothing.
        let z = |d: f64, worst: f64| if d > 0.0 { (near_m / d).clamp(0.0, 1.0) } else { worst };
        self.summary.promised = range_m.map(|[nearest_m, farthest_m]| {
            let (low, high) = (z(farthest_m, 0.0) as f32, z(nearest_m, 1.0) as f32);
            [low.min(high), high.max(low)]
        });
    }

    pub(super) fn keep_promises_of(&mut self, other: &Self) {
        self.summary.promised = other.summary.promised;
    }

    /// Least and greatest stored depth z over the outer pinhole image. Reduced on the GPU;
    /// waits for it once after each redraw, since passes to record depend on it. In a frame
    /// that may not wait, bounds that are at least as wide until the right ones arrive.
    pub fn z_bounds(&mut self, frame: &mut Frame<'_>) -> [f32; 2] {
        self.summary(frame).z_bounds
    }

    /// Greatest difference of stored depth between neighbours in the outer pinhole image:
    /// how much hidden surface a lens can show. Waits as [`View::z_bounds`] does.
    pub fn greatest_z_step(&mut self, frame: &mut Frame<'_>) -> f32 {
        self.summary(frame).greatest_z_step
    }

    /// Greatest component of any colour in the outer pinhole image. Waits as
    /// [`View::z_bounds`] does.
    pub fn brightest(&mut self, frame: &mut Frame<'_>) -> f32 {
        self.summary(frame).brightest
    }

    /// Least and greatest signed CoC diameter, px, over the outer pinhole image, cut to
    /// [`GREATEST_COC_PX`] as in shaders.
    pub fn coc_bounds_px(&mut self, frame: &mut Frame<'_>, lens: &Lens) -> [f64; 2] {
        let [z_min, z_max] = self.z_bounds(frame).map(f64::from);
        let at = |z: f64| lens.coc().at_stored(z, self.projection.near_m).clamp(-GREATEST_COC_PX, GREATEST_COC_PX);
        [at(z_max), at(z_min)]
    }

    fn summary(&mut self, frame: &mut Frame<'_>) -> Summary {
        if let Some(known) = self.summary.summary.or_else(|| self.summary.arrived()) {
            return known;
        }
        if frame.may_wait() {
            let result = self.summarise(frame);
            let summary = Summary::of(&frame.read_buffer::<u32>(&result));
            self.summary.summary = Some(summary);
            return summary;
        }
        if self.summary.awaited.is_none() {
            let result = self.summarise(frame);
            self.summary.awaited = Some(send_for(frame, &result));
        }
        Summary::worst(self.summary.promised.unwrap_or([0.0, 1.0]))
    }

    /// Records the pass that finds the extremes, as bits.
    fn summarise(&mut self, frame: &mut Frame<'_>) -> Buffer {
        let Layer { color, depth } = self.pinhole(frame);
        let gpu = frame.gpu();
        let start = gpu.memo().get(&DEPTH_BOUNDS.name, || gpu.buffer_of("no bounds", &[u32::MAX, 0, 0, 0]));
        let result = gpu.scratch("depth bounds", start.size());
        frame.encoder().copy_buffer_to_buffer(start.raw(), 0, result.raw(), 0, start.size());
        frame
            .pass(&DEPTH_BOUNDS, "depth_bounds")
            .texture("depth", &depth)
            .texture("color", &color)
            .buffer("result", &result)
            .dispatch_groups(depth.size().x.div_ceil(64), depth.size().y.div_ceil(64), 1);
        result
    }
}

/// Has a buffer's content sent to the CPU when the frame's commands are done.
fn send_for(frame: &mut Frame<'_>, from: &Buffer) -> Awaited {
    let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
    let (size, label) = (from.size(), Some("depth bounds for the CPU"));
    let descriptor = wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false };
    let buffer = frame.gpu().device().create_buffer(&descriptor);
    let ready: Arc<OnceLock<bool>> = Arc::default();
    let encoder = frame.encoder();
    encoder.copy_buffer_to_buffer(from.raw(), 0, &buffer, 0, size);
    let told = ready.clone();
    encoder.map_buffer_on_submit(&buffer, wgpu::MapMode::Read, .., move |result| {
        // Nothing else sets it.
        let _ = told.set(result.is_ok());
    });
    Awaited { buffer, ready }
}
