//! Presented pictures made into others: two eyes' pictures into one, and one channel alone.
//!
//! They take and return textures of [`present::FORMAT`](crate::present::FORMAT), so that
//! whatever a pane shows, picture or overlay, can be combined.

use crate::gpu::{Frame, Shader, Texture};
use crate::present::FORMAT;
use crate::stereo::Layout;
use crate::{shader, uniform};
use glam::uvec2;

const SHADER: Shader = shader!("combine");

/// What of a picture is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Channel {
    /// All of it.
    #[default]
    All,
    /// Red, as grey.
    Red,
    /// Green, as grey.
    Green,
    /// Blue, as grey.
    Blue,
    /// Luminance of the linear display values, as grey.
    Luminance,
}

impl Channel {
    /// All, with their names.
    pub const ALL: [(Self, &'static str); 5] = [
        (Self::All, "All channels"),
        (Self::Red, "Red"),
        (Self::Green, "Green"),
        (Self::Blue, "Blue"),
        (Self::Luminance, "Luminance"),
    ];

    /// What the channel is made of, in linear display values; `None` for all channels.
    fn weights(self) -> Option<[f32; 3]> {
        match self {
            Self::All => None,
            Self::Red => Some([1.0, 0.0, 0.0]),
            Self::Green => Some([0.0, 1.0, 0.0]),
            Self::Blue => Some([0.0, 0.0, 1.0]),
            Self::Luminance => Some(crate::display::LUMINANCE.to_array()),
        }
    }
}

uniform! {
    struct Weights {
        /// Rows of the matrix on the first picture's linear display values, then on the second's.
        rows: [[f32; 4]; 6],
    }
}

/// The pictures of the left and the right eye in one: side by side, twice as wide as each,
/// or as an anaglyph. Panics if their sizes differ.
pub fn stereo(frame: &mut Frame<'_>, left: &Texture, right: &Texture, layout: Layout) -> Texture {
    assert_eq!(left.size(), right.size(), "both eyes see with one size");
    let size = left.size();
    let (first, second) = if layout == Layout::Crossed { (right, left) } else { (left, right) };
    if layout.is_side_by_side() {
        let result = frame.texture("side by side", uvec2(2 * size.x, size.y), FORMAT);
        let pass = frame.pass(&SHADER, "side_by_side").texture("first", first).texture("second", second);
        pass.texture("result", &result).dispatch(result.size());
        return result;
    }
    let result = frame.texture("anaglyph", size, FORMAT);
    let [l, r] = layout.anaglyph_matrices();
    let row = |index: usize| {
        let matrix = if index < 3 { l } else { r };
        matrix.row(index % 3).extend(0.0).to_array()
    };
    let weights = Weights { rows: std::array::from_fn(row) };
    let pass = frame.pass(&SHADER, "weighted").uniform("weights", &weights).texture("first", first);
    pass.texture("second", second).texture("result", &result).dispatch(size);
    result
}

/// One channel of a picture as grey; the picture itself for all of them.
pub fn isolated(frame: &mut Frame<'_>, picture: &Texture, channel: Channel) -> Texture {
    let Some([r, g, b]) = channel.weights() else { return picture.clone() };
    let result = frame.texture("channel", picture.size(), FORMAT);
    let (row, none) = ([r, g, b, 0.0], [0.0; 4]);
    let weights = Weights { rows: [row, row, row, none, none, none] };
    let pass = frame.pass(&SHADER, "weighted").uniform("weights", &weights).texture("first", picture);
    pass.texture("second", picture).texture("result", &result).dispatch(picture.size());
    result
}
