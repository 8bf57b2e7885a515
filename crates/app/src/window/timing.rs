//! Times of the last frames: a running plot and numbers.

use defocus::gpu::{FrameStats, PassTime};
use eframe::egui;
use egui_plot::{Legend, Line, Plot, PlotPoints};
use std::collections::{BTreeMap, VecDeque};

/// Frames that are kept.
const KEPT: usize = 120;

/// Times of one frame, ms.
#[derive(Clone, Debug, Default, PartialEq)]
struct FrameTimes {
    cpu_ms: f64,
    gpu_ms: f64,
    passes: BTreeMap<String, f64>,
}

/// The last frames' times.
#[derive(Clone, Debug, Default)]
pub struct History {
    frames: VecDeque<FrameTimes>,
    /// Labels in the order in which their passes run.
    order: Vec<String>,
}

/// Median and 95th percentile, ms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantiles {
    /// Half of the frames took no longer.
    pub median: f64,
    /// 95 % of the frames took no longer.
    pub p95: f64,
}

impl Quantiles {
    /// Nearest-rank quantiles; `None` for no values.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = values.into_iter().collect();
        sorted.sort_by(f64::total_cmp);
        let rank = |share: f64| ((share * sorted.len() as f64).ceil() as usize).saturating_sub(1);
        let at = |share| sorted.get(rank(share)).copied();
        Some(Self { median: at(0.5)?, p95: at(0.95)? })
    }
}

impl History {
    /// Adds a frame: time to record it on the CPU, ms, and its passes on the GPU. Passes
    /// of the same label are added up.
    pub fn push(&mut self, cpu_ms: f64, passes: &[PassTime]) {
        let mut times = FrameTimes { cpu_ms, ..Default::default() };
        let mut order: Vec<String> = Vec::new();
        for pass in passes {
            times.gpu_ms += pass.ms;
            *times.passes.entry(pass.label.clone()).or_default() += pass.ms;
            if !order.contains(&pass.label) {
                order.push(pass.label.clone());
            }
        }
        self.frames.push_back(times);
        if self.frames.len() > KEPT {
            self.frames.pop_front();
        }
        let earlier = std::mem::take(&mut self.order);
        let gone = |label: &String| !self.frames.iter().any(|f| f.passes.contains_key(label));
        let rest: Vec<_> = earlier.into_iter().filter(|label| !order.contains(label) && !gone(label)).collect();
        self.order = order.into_iter().chain(rest).collect();
    }

    /// Time of the last frame, ms: the longer of recording it and running it.
    pub fn last_ms(&self) -> Option<f64> {
        self.frames.back().map(|f| f.cpu_ms.max(f.gpu_ms))
    }

    /// GPU time of whole frames.
    pub fn gpu(&self) -> Option<Quantiles> {
        Quantiles::of(self.frames.iter().map(|f| f.gpu_ms))
    }

    /// CPU time of recording frames.
    pub fn cpu(&self) -> Option<Quantiles> {
        Quantiles::of(self.frames.iter().map(|f| f.cpu_ms))
    }

    /// GPU time of each pass over the frames that have it, in the order in which they run.
    pub fn passes(&self) -> Vec<(&str, Quantiles)> {
        let quantiles = |label: &String| Quantiles::of(self.frames.iter().filter_map(|f| f.passes.get(label).copied()));
        self.order.iter().filter_map(|label| Some((label.as_str(), quantiles(label)?))).collect()
    }

    /// Forgets all frames.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    fn series(&self, value: impl Fn(&FrameTimes) -> Option<f64>) -> PlotPoints<'static> {
        let newest = self.frames.len() as f64 - 1.0;
        let point = |(i, frame)| value(frame).map(|ms| [i as f64 - newest, ms]);
        self.frames.iter().enumerate().filter_map(point).collect()
    }
}

/// Times of passes that were taken one by one, the costliest first; `None` while they are
/// taken.
pub fn show_passes(ui: &mut egui::Ui, times: Option<&Result<Vec<PassTime>, String>>) {
    let passes = match times {
        None => {
            ui.weak("being timed …");
            return;
        }
        Some(Err(error)) => {
            ui.colored_label(ui.visuals().error_fg_color, error);
            return;
        }
        Some(Ok(passes)) => passes,
    };
    let all: f64 = passes.iter().map(|pass| pass.ms).sum();
    let mut sorted: Vec<&PassTime> = passes.iter().collect();
    sorted.sort_by(|a, b| b.ms.total_cmp(&a.ms));
    egui::Grid::new("timed passes").num_columns(3).striped(true).spacing([8.0, 3.0]).show(ui, |ui| {
        let mut row = |label: &str, ms: f64| {
            ui.add(egui::Label::new(label).truncate());
            ui.label(egui::RichText::new(format!("{ms:.2} ms")).monospace());
            let share = if all > 0.0 { 100.0 * ms / all } else { 0.0 };
            ui.label(egui::RichText::new(format!("{share:.0} %")).monospace());
            ui.end_row();
        };
        row("all passes", all);
        sorted.iter().for_each(|pass| row(&pass.label, pass.ms));
    });
}

/// Plot and table.
pub fn show(ui: &mut egui::Ui, history: &History, stats: &FrameStats) {
    if history.frames.is_empty() {
        ui.weak("No frame was rendered yet.");
        return;
    }
    plot(ui, history);
    ui.add_space(4.0);
    table(ui, history);
    for text in work(stats) {
        ui.label(egui::RichText::new(text).small().weak()).on_hover_text("What the last frame consisted of");
    }
    for (what, times) in &stats.skipped {
        let times = if *times > 1 { format!(" ({times} times)") } else { String::new() };
        let text = egui::RichText::new(format!("skipped: {what}{times}")).small().weak();
        ui.label(text).on_hover_text("Work that the last frame did not need");
    }
}

/// What a frame consisted of: the counts that `defocus profile` prints.
fn work(stats: &FrameStats) -> [String; 3] {
    let FrameStats { passes, dispatches, indirect_dispatches, views, triangles, .. } = stats;
    let mb = |bytes: u64| bytes as f64 / 1e6;
    [
        format!("{passes} passes: {dispatches} dispatches, {indirect_dispatches} of them indirect"),
        format!("{views} draws of the scene, {triangles} triangles"),
        format!("{:.0} MB of textures, {:.1} MB of buffers", mb(stats.peak_texture_bytes), mb(stats.peak_buffer_bytes)),
    ]
}

fn plot(ui: &mut egui::Ui, history: &History) {
    // Lines for the passes that matter: more cannot be told apart.
    const LINES: usize = 4;
    let mut passes = history.passes();
    passes.sort_by(|a, b| b.1.median.total_cmp(&a.1.median));
    let color = ui.visuals().text_color();
    let plot = Plot::new("frame times")
        .height(120.0)
        .allow_zoom(false)
        .allow_drag(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .show_x(false)
        .include_y(0.0)
        .include_x(-(KEPT as f64) + 1.0)
        .include_x(0.0)
        .show_axes([false, true])
        .y_axis_formatter(|mark, _| format!("{} ms", mark.value))
        .legend(Legend::default().position(egui_plot::Corner::LeftTop).background_alpha(0.6))
        .show(ui, |plot| {
            plot.line(Line::new("frame", history.series(|f| Some(f.gpu_ms.max(f.cpu_ms)))).color(color).width(2.0));
            for (label, _) in passes.into_iter().take(LINES) {
                let series = history.series(|f| f.passes.get(label).copied());
                plot.line(Line::new(short(label), series).width(1.0));
            }
        });
    plot.response.accessible_name("Times of the last frames");
}

/// A label without its method: "mipmap/blur" is told apart by its end.
fn short(label: &str) -> &str {
    label.rsplit('/').next().unwrap_or(label)
}

fn table(ui: &mut egui::Ui, history: &History) {
    const NUMBER: f32 = 58.0;
    const GAP: f32 = 8.0;
    let height = ui.spacing().interact_size.y;
    let name_width = (ui.available_width() - 2.0 * (NUMBER + GAP) - GAP).max(60.0);
    egui::Grid::new("pass times").num_columns(3).striped(true).spacing([GAP, 3.0]).show(ui, |ui| {
        let right = |ui: &mut egui::Ui, text: egui::RichText| {
            let layout = egui::Layout::right_to_left(egui::Align::Center);
            ui.allocate_ui_with_layout(egui::vec2(NUMBER, height), layout, |ui| {
                ui.set_min_width(NUMBER);
                ui.label(text);
            });
        };
        ui.weak("ms");
        right(ui, egui::RichText::new("median").weak());
        right(ui, egui::RichText::new("95 %").weak());
        ui.end_row();
        let whole = [("whole frame, GPU", history.gpu()), ("recording, CPU", history.cpu())];
        let whole = whole.into_iter().filter_map(|(label, q)| Some((label, q?)));
        for (label, quantiles) in whole.chain(history.passes()) {
            ui.scope(|ui| {
                ui.set_min_width(name_width);
                ui.set_max_width(name_width);
                ui.add(egui::Label::new(label).truncate()).on_hover_text(label);
            });
            right(ui, egui::RichText::new(format!("{:.2}", quantiles.median)).monospace());
            right(ui, egui::RichText::new(format!("{:.2}", quantiles.p95)).monospace());
            ui.end_row();
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_nearest_ranks() {
        let of = |values: &[f64]| Quantiles::of(values.iter().copied());
        assert_eq!(of(&[]), None);
        assert_eq!(of(&[3.0]), Some(Quantiles { median: 3.0, p95: 3.0 }));
        let hundred: Vec<f64> = (1..=100).rev().map(f64::from).collect();
        assert_eq!(of(&hundred), Some(Quantiles { median: 50.0, p95: 95.0 }));
    }

    #[test]
    fn passes_of_one_label_are_added_and_old_frames_go() {
        let pass = |label: &str, ms| PassTime { label: label.into(), ms };
        let mut history = History::default();
        history.push(0.5, &[pass("a", 1.0), pass("b", 4.0), pass("a", 2.0)]);
        assert_eq!(history.last_ms(), Some(7.0));
        assert_eq!(history.passes().iter().map(|(l, q)| (*l, q.median)).collect::<Vec<_>>(), [("a", 3.0), ("b", 4.0)]);
        for _ in 0..KEPT {
            history.push(0.5, &[pass("c", 1.0)]);
        }
        assert_eq!(history.passes().iter().map(|(l, _)| *l).collect::<Vec<_>>(), ["c"]);
        assert_eq!(history.frames.len(), KEPT);
    }
}
