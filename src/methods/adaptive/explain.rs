//! What the rays of each pixel cost and met, as pictures: for whoever looks.

use crate::gpu::{Frame, Shader, Texture};
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
