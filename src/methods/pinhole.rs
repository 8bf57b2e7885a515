//! `pinhole`: the input of every other method, everything sharp.

use super::{About, Apertures, Method, MethodError, Param};
use crate::gpu::{Frame, Texture};
use crate::lens::Lens;
use crate::view::View;

/// The pinhole image, unblurred.
#[derive(Clone, Debug, Default)]
pub struct Pinhole;

impl Method for Pinhole {
    fn about(&self) -> About {
        About {
            id: "pinhole",
            title: "Pinhole",
            paper: "",
            summary: "The scene through an infinitely small aperture: everything is sharp.",
            limits: "No depth of field.",
            apertures: Apertures::None,
            needs_scene: false,
            conserves_energy: true,
            averages: true,
            samples_lens: false,
            width_tolerance: 0.0,
        }
    }

    fn params(&mut self) -> Vec<Param<'_>> {
        Vec::new()
    }

    fn record(&self, frame: &mut Frame<'_>, view: &mut View, _: &Lens) -> Result<Texture, MethodError> {
        Ok(inner(frame, view))
    }

    fn boxed(&self) -> Box<dyn Method> {
        Box::new(self.clone())
    }
}

/// The pinhole image without its overscan: the drawn texture itself where there is none.
pub(super) fn inner(frame: &mut Frame<'_>, view: &mut View) -> Texture {
    let color = view.pinhole(frame).color;
    if view.overscan_px() == 0 {
        return color;
    }
    let inner = frame.texture("inner frame", view.size(), color.format());
    frame.copy_part(&color, glam::UVec2::splat(view.overscan_px()), &inner);
    inner
}
