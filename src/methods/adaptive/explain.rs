//! Debug images: how many rays and texel reads each pixel took, and which layers its rays hit.

use crate::gpu::{Frame, Shader, Texture};
use crate::methods::{Meaning, Quantity, Scale, tile_lists};
use crate::{shader, uniform};

const SHADER: Shader = shader!("methods/adaptive_explain");

uniform! {
    struct Shown {
        component: u32,
        divisor: u32,
        white: f32,
    }
}

/// No divisor: `NONE` in the shader.
const NONE: u32 = 4;

/// Name, component of the counts, component to divide by, value that is white.
const OVERLAYS: [(&str, u32, u32, f32); 4] = [
    ("rays per pixel, white 64", 0, NONE, 64.0),
    ("texels read per pixel, white 256", 1, NONE, 256.0),
    ("mean layer hit, white the fourth", 2, 0, 3.0),
    ("rays that hit nothing, white all", 3, 0, 1.0),
];

/// What tells what was done where.
pub(super) const EXPLAINS: [&str; 5] =
    [tile_lists::SKIPPED, OVERLAYS[0].0, OVERLAYS[1].0, OVERLAYS[2].0, OVERLAYS[3].0];

/// The classes of tiles as their texture has them.
const CLASSES: [(f32, &str); 3] = [(0.0, "in focus: copied"), (0.5, "one blur"), (1.0, "traced")];

/// What a texture means that the method exposes.
pub(super) fn meaning(name: &str) -> Meaning {
    let units = ["rays", "texels read", "layer hit", "rays that hit nothing"];
    if name == tile_lists::SKIPPED {
        return tile_lists::meaning(&CLASSES);
    }
    let overlay = OVERLAYS.iter().zip(units).find(|((known, ..), _)| *known == name);
    let Some(((.., divisor, white), what)) = overlay else { return Meaning::Picture };
    let quantity = match (*divisor, *white) {
        // A share of the rays.
        (0, 1.0) => Quantity::new(what, " %", Scale::Found).worth(100.0),
        (_, white) => Quantity::new(what, "", Scale::Found).worth(white),
    };
    Meaning::numbers([quantity])
}

/// Exposes the tile classes, what was counted, and what lies in front of, in and behind
/// focus.
pub(super) fn explain(frame: &mut Frame<'_>, classes: &Texture, counts: &Texture, buckets: &Texture) {
    for (name, component, divisor, white) in OVERLAYS {
        let overlay = frame.texture(name, counts.size(), counts.format());
        frame
            .pass(&SHADER, "show_count")
            .uniform("shown", &Shown { component, divisor, white })
            .texture("counts", counts)
            .texture("overlay", &overlay)
            .dispatch(counts.size());
        frame.expose(name, &overlay);
    }
    let overlay = frame.texture("buckets seen", counts.size(), counts.format());
    frame
        .pass(&SHADER, "show_buckets")
        .texture("classes", classes)
        .texture("buckets", buckets)
        .texture("overlay", &overlay)
        .dispatch(counts.size());
    frame.expose("hits: red in front of focus, green in focus, blue behind", &overlay);
}
