//! Files whose lengths are not metres: the unit is offered where everything in view is far away.

use super::App;
use super::ui::panels::{ScaleAction, ScaleView, scale_offer};
use defocus_study::{DepthArgs, builtin};
use eframe::egui::{Context, Frame, Margin, Panel, Ui};

/// Distance of the nearest things in view from which on the unit is asked for, metres: what
/// stands so far off in centimetres is half a metre away, as near as one looks at things.
const OFFERED_FROM_M: f64 = 50.0;

/// Share of the picture that counts as the nearest.
const NEAREST_SHARE: f64 = 0.05;

/// Whether the unit of a scene's file is to be asked for.
#[derive(Default)]
pub struct ScaleOffer {
    /// Whether this scene was looked at already.
    is_settled: bool,
    /// Distance of the nearest in view, metres, where it is asked for.
    nearest_m: Option<f64>,
}

/// Depth, metres, that a share of the picture is nearer than; what is infinitely far does not
/// count.
fn nearest_m(depths_m: &[f32]) -> Option<f64> {
    let mut finite: Vec<f32> = depths_m.iter().copied().filter(|d| d.is_finite() && *d > 0.0).collect();
    finite.sort_by(f32::total_cmp);
    let rank = (NEAREST_SHARE * finite.len().saturating_sub(1) as f64) as usize;
    finite.get(rank).map(|d| f64::from(*d))
}

impl App {
    /// Looks at a scene that was opened.
    pub(super) fn forget_scale_offer(&mut self) {
        self.scale_offer = ScaleOffer::default();
    }

    /// Reads the scene's file again with lengths of `metres` a unit.
    pub(super) fn scale_scene(&mut self, ctx: &Context, metres: f64) {
        let scene = self.document.scene.clone();
        let depth = DepthArgs { scene_scale: Some(metres).filter(|m| *m != 1.0), ..self.document.depth.clone() };
        self.scale_offer = ScaleOffer { is_settled: true, nearest_m: None };
        self.document.automatic_lens = true;
        self.loader.start(&scene, &depth, true, self.engine.gpu(), ctx);
    }

    /// Asks for the unit where a file's scene lies far away.
    pub(super) fn show_scale_offer(&mut self, ui: &mut Ui) {
        self.consider_scale();
        let Some(nearest_m) = self.scale_offer.nearest_m else { return };
        let frame = Frame::side_top_panel(ui.style()).inner_margin(Margin::symmetric(8, 5));
        let shown = Panel::top("scale").frame(frame).show(ui, |ui| scale_offer(ui, ScaleView { nearest_m }));
        match shown.inner {
            Some(ScaleAction::Read(metres)) => self.scale_scene(ui.ctx(), metres),
            Some(ScaleAction::Keep) => self.scale_offer.nearest_m = None,
            None => {}
        }
    }

    fn consider_scale(&mut self) {
        let is_file = builtin::builtin(&self.document.scene).is_none() && self.document.depth.scene_scale.is_none();
        let is_scene = self.engine.source().is_some_and(|source| source.source().is_scene());
        if self.scale_offer.is_settled || !is_file || !is_scene || !self.shows_what_is_named() {
            return;
        }
        let Some(depths_m) = self.engine.depths_m(false) else { return };
        self.scale_offer = ScaleOffer {
            is_settled: true,
            nearest_m: nearest_m(depths_m).filter(|nearest_m| *nearest_m >= OFFERED_FROM_M),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_is_a_share_of_what_is_there() {
        let depths: Vec<f32> = (1..=100).map(|d| d as f32).chain([f32::INFINITY; 40]).collect();
        assert_eq!(nearest_m(&depths), Some(5.0));
        assert_eq!(nearest_m(&[f32::INFINITY]), None);
        assert_eq!(nearest_m(&[]), None);
    }
}
