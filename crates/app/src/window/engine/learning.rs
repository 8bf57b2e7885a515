//! What the times of finished frames teach.

use super::renderer::Engine;

/// A lost device never answers; after this long nobody waits for the times any more.
const GIVE_UP_S: f32 = 10.0;

impl Engine {
    /// Takes in the times that have arrived.
    pub(super) fn poll(&mut self) {
        let software = self.gpu.is_software();
        let (history, panes, ms_per_view) = (&mut self.history, &mut self.panes, &mut self.ms_per_view);
        self.in_flight.retain(|flight| {
            let Some(passes) = flight.timings.poll() else {
                return flight.since.elapsed().as_secs_f32() < GIVE_UP_S;
            };
            for part in &flight.parts {
                // Without timestamps there is the whole frame's time: that of a pane which
                // was the only one in it.
                let own = match software {
                    true if flight.parts.len() == 1 => &passes[..],
                    true => &[],
                    false => passes.get(part.passes.start..part.passes.end.min(passes.len())).unwrap_or_default(),
                };
                let gpu_ms: f64 = own.iter().map(|p| p.ms).sum();
                let views = f64::from(part.views.max(1));
                if part.views > 0 {
                    *ms_per_view = (gpu_ms.max(flight.cpu_ms) / views).max(1e-3);
                }
                if let Some(pane) = panes.get_mut(&part.pane).filter(|_| !own.is_empty()) {
                    let alone = flight.parts.len() == 1;
                    let waited_ms = if alone { gpu_ms.max(flight.cpu_ms) } else { gpu_ms };
                    pane.learn(part.divisor, gpu_ms / views, waited_ms / views, flight.blur_px);
                }
            }
            history.push(flight.cpu_ms, &passes);
            false
        });
    }
}
