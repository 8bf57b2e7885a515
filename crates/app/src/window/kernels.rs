//! The point spread function of pane A's method, measured while its panel is in sight.

use super::App;
use super::model::Edit;
use super::ui::panels::{KernelView, kernel_panel};
use super::ui::widgets::revealed;
use eframe::egui::Ui;

/// What the panel remembers.
#[derive(Default)]
pub struct Kernels {
    /// Whether it is to be unfolded and brought into sight.
    reveal: bool,
}

impl App {
    /// Unfolds the panel and brings it into sight.
    pub(super) fn show_kernel(&mut self) {
        self.preferences.panels_hidden = false;
        self.kernels.reveal = true;
    }

    /// The panel.
    pub(super) fn kernel_group(&mut self, ui: &mut Ui) {
        let reveal = std::mem::take(&mut self.kernels.reveal);
        revealed(ui, "Point spread function", false, reveal, |ui| {
            let a = self.document.a;
            let title = self.document.pane(a).map_or_else(String::new, |pane| pane.method.title());
            let known = self.engine.kernel();
            let view = KernelView { title: &title, measured: known.and_then(|kernel| kernel.psf.as_ref()) };
            let mut chosen = self.document.kernel;
            kernel_panel(ui, &mut chosen, &view);
            if chosen != self.document.kernel {
                self.edit(Edit::Kernel(chosen));
            }
            self.engine.measure_kernel(a, self.document.kernel);
        });
    }
}
