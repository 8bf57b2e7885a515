//! `pinhole`: the input of every other method, everything sharp.

use super::{About, Apertures, Method, MethodError, Param};
use crate::gpu::{Frame, Shader, Texture};
use crate::lens::Lens;
use crate::view::View;
use crate::{shader, uniform};

const COPY: Shader = shader!("copy");

uniform! {
    struct Copy {
        overscan: u32,
    }
}

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
            astigmatism: false,
            needs_scene: false,
            conserves_energy: true,
            averages: true,
            samples_lens: false,
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
    if view.overscan_px() == 0 {
        return view.pinhole(frame).color;
    }
    copy_inner(frame, view)
}

/// A copy of the pinhole image without its overscan, always by one pass over all pixels:
/// what the cost of methods is measured by.
pub fn copy_inner(frame: &mut Frame<'_>, view: &mut View) -> Texture {
    let color = view.pinhole(frame).color;
    let result = frame.color_texture("inner frame", view.size());
    frame
        .pass(&COPY, "copy_inner")
        .uniform("copy", &Copy { overscan: view.overscan_px() })
        .texture("color", &color)
        .texture("result", &result)
        .dispatch(result.size());
    result
}
