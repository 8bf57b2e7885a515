//! Times of the last frames as a running plot and as numbers.

use crate::window::engine::{FRAMES_KEPT, History, Quantiles};
use defocus::gpu::{FrameStats, PassTime};
use eframe::egui;
use egui_plot::{Legend, Line, Plot};

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
    if history.is_empty() {
        ui.weak("No frame was rendered yet.");
        return;
    }
    plot(ui, history);
    ui.add_space(4.0);
    table(ui, history);
    for text in work(stats) {
        ui.label(egui::RichText::new(text).small().weak()).on_hover_text("What the last frame consisted of");
    }
    let skipped = stats.skipped.iter().map(|(what, times)| format!("{what} ({times})"));
    let skipped: Vec<String> = skipped.collect();
    // One line whatever was skipped: what stands below does not move.
    let text = match skipped.len() {
        0 => "nothing was skipped".to_owned(),
        1 => "one kind of work was skipped".to_owned(),
        n => format!("{n} kinds of work were skipped"),
    };
    let help = format!("Work that the last frame did not need\n\n{}", skipped.join("\n"));
    ui.label(egui::RichText::new(text).small().weak()).on_hover_text(help);
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
    let mut passes = single_passes(history);
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
        .include_x(-(FRAMES_KEPT as f64) + 1.0)
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

/// The passes, without the whole frame, which is all that a software adapter times.
fn single_passes(history: &History) -> Vec<(&str, Quantiles)> {
    history.passes().into_iter().filter(|(label, _)| *label != defocus::gpu::WHOLE_FRAME).collect()
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
        for (label, quantiles) in whole.chain(single_passes(history)) {
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
