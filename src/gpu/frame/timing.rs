//! Times of passes: by the GPU, or by submitting each alone.

use crate::gpu::Gpu;
use std::sync::{Arc, OnceLock};
use std::time::Duration;

/// Timestamps that a query set holds: two a pass. Passes beyond are not timed.
pub(in crate::gpu) const MAX_TIMESTAMPS: u32 = wgpu::QUERY_SET_MAX_QUERIES;

/// Has the timestamps put where the CPU can read them.
pub(super) fn resolve(
    device: &wgpu::Device,
    encoder: &mut wgpu::CommandEncoder,
    queries: &wgpu::QuerySet,
    count: u32,
) -> wgpu::Buffer {
    use wgpu::BufferUsages as Usage;
    let buffer = |usage| {
        let size = u64::from(count) * 8;
        device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
    };
    let resolved = buffer(Usage::QUERY_RESOLVE | Usage::COPY_SRC);
    let mapped = buffer(Usage::MAP_READ | Usage::COPY_DST);
    encoder.resolve_query_set(queries, 0..count, &resolved, 0);
    encoder.copy_buffer_to_buffer(&resolved, 0, &mapped, 0, resolved.size());
    mapped
}

/// Label of the one time that is known of a frame without timestamps.
pub const WHOLE_FRAME: &str = "whole frame";

/// GPU time of a pass.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PassTime {
    /// The pass's label.
    pub label: String,
    /// Duration on the GPU, milliseconds.
    pub ms: f64,
}

/// What measures the time of passes.
pub(super) enum Timer {
    /// Nothing.
    None,
    /// The GPU, by timestamps around each.
    Stamps(wgpu::QuerySet),
    /// The host, by submitting each alone.
    Host(HostTimer),
}

#[derive(Default)]
pub(super) struct HostTimer {
    /// The pass that is recorded but not submitted.
    pub(super) open: Option<String>,
    pub(super) times: Vec<PassTime>,
}

/// Times that arrive when the GPU is done.
pub struct Timings {
    pub(super) gpu: Gpu,
    pub(super) labels: Vec<String>,
    /// Held while the times may be asked for: no other frame may write to it.
    pub(super) queries: Option<wgpu::QuerySet>,
    pub(super) buffer: Option<wgpu::Buffer>,
    /// Times of a frame whose passes the host has timed.
    pub(super) host: Option<Vec<PassTime>>,
    /// How long after its submission the frame was found to be done.
    pub(super) ready: Arc<OnceLock<Duration>>,
}

impl Timings {
    /// The times if they are there by now; `None` if not yet. Of an adapter without usable
    /// timestamps it is the whole frame's, on the host's clock, unless the frame was one of
    /// [`Gpu::timed_frame`].
    pub fn poll(&self) -> Option<Vec<PassTime>> {
        if let Some(times) = &self.host {
            return Some(times.clone());
        }
        // A lost device answers with an error; then the times simply never arrive.
        let _ = self.gpu.device().poll(wgpu::PollType::Poll);
        let elapsed = self.ready.get()?;
        let Some(buffer) = &self.buffer else {
            return Some(vec![PassTime { label: WHOLE_FRAME.into(), ms: elapsed.as_secs_f64() * 1e3 }]);
        };
        let bytes = buffer.get_mapped_range(..).ok()?;
        let stamps: &[u64] = bytemuck::try_cast_slice(&bytes).ok()?;
        let ns_per_tick = f64::from(self.gpu.queue().get_timestamp_period());
        let ms = |pair: &[u64]| pair[1].saturating_sub(pair[0]) as f64 * ns_per_tick * 1e-6;
        let pass = |(label, pair): (&String, &[u64])| PassTime { label: label.clone(), ms: ms(pair) };
        Some(self.labels.iter().zip(stamps.chunks_exact(2)).map(pass).collect())
    }

    /// Waits for the GPU and returns the times, as [`Timings::poll`]; empty if it is lost.
    pub fn wait(&self) -> Vec<PassTime> {
        // As in `poll`: a lost device leaves the times empty.
        let _ = self.gpu.device().poll(wgpu::PollType::wait_indefinitely());
        self.poll().unwrap_or_default()
    }
}

impl Drop for Timings {
    fn drop(&mut self) {
        if let Some(queries) = self.queries.take() {
            self.gpu.give_back_queries(queries);
        }
    }
}
