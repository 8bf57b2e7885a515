//! Camera, lens and size as a source asks for them.

use super::App;
use super::model::PictureSize;
use defocus::lens::Lens;
use defocus_study::Source;
use defocus_study::source::DEFAULT_SIZE;

impl App {
    pub(super) fn choose_camera(&mut self, index: usize) {
        let Some(source) = self.engine.source() else { return };
        self.document.camera_index = index;
        self.document.camera = match source.source() {
            Source::Scene(scene) => scene.cameras.get(index).map(|c| c.camera),
            Source::Image(_) => None,
        };
    }

    /// Focus, and the rest of the lens where it is automatic, as the source asks for it.
    pub(super) fn refocus(&mut self) {
        let Some(lens) = self.suitable_lens() else { return };
        self.focus_motion.stop();
        self.document.pivot_m = lens.focus_distance_m;
        self.document.lens.focus_distance_m = lens.focus_distance_m;
        if self.document.automatic_lens {
            let aperture = self.document.lens.aperture.clone();
            self.document.lens = Lens { aperture, ..lens };
        }
    }

    /// A lens that suits what is shown.
    pub(super) fn suitable_lens(&mut self) -> Option<Lens> {
        let size = Some(self.eye_size_px()).filter(|s| s.min_element() > 0).unwrap_or(DEFAULT_SIZE);
        self.engine.default_lens(self.document.camera, size).ok()
    }

    /// Gives the picture another size. A lens that follows the scene follows it in this too:
    /// its display spans the camera's field of view also then.
    pub(super) fn resize_picture(&mut self, size: PictureSize) {
        self.document.size = size.repaired();
        if let (true, Some(lens)) = (self.document.automatic_lens, self.suitable_lens()) {
            let Lens { aperture, focus_distance_m, .. } = self.document.lens.clone();
            self.document.lens = Lens { aperture, focus_distance_m, ..lens };
        }
    }

    pub(super) fn suit_lens(&mut self) {
        self.document.automatic_lens = true;
        self.refocus();
    }
}
