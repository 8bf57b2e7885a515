//! What a display shows of a linear HDR texture, on the GPU: [`Display`] into RGBA8, and
//! overlays of the quantities behind a picture.
//!
//! The formulas are those of [`crate::display`], which a test holds them to.

use crate::colormap::ColorMap;
use crate::display::{Display, ToneMap};
use crate::gpu::{Buffer, Frame, Gpu, Shader, Texture};
use crate::lens::Lens;
use crate::view::View;
use crate::{shader, uniform};
use std::sync::Arc;

mod place;
mod slice;

pub use place::Place;
pub use slice::{Numbers, Slice, slice_picture, slice_range};

const SHADER: Shader = shader!("present");

/// Format of what is presented: sRGB-encoded values, alpha 1.
pub const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// The difference of display values, in [0, 1], that reaches the end of the colour map.
/// Fixed, so that two difference images can be compared by eye.
pub const DIFFERENCE_FULL_SCALE: f32 = 0.25;

/// The relative difference of linear values that reaches the end of the colour map.
pub const RELATIVE_FULL_SCALE: f32 = 1.0;

/// How much the tint of [`Overlay::Zone`] hides: little, since what is blurred is to be seen.
const ZONE_OPACITY: f32 = 0.45;

/// Linear radiance added to what a relative difference is relative to: a hundredth of
/// white, below which a display shows next to nothing.
pub const RELATIVE_DARK: f32 = 0.01;

uniform! {
    struct Present {
        gain: f32,
        tone_map: u32,
        full_scale: f32,
        overscan: u32,
        dark: f32,
        opacity: f32,
    }
}

impl Present {
    fn new(display: &Display) -> Self {
        let tone_map = match display.tone_map {
            ToneMap::None => 0,
            ToneMap::Reinhard => 1,
            ToneMap::Agx => 2,
        };
        Self {
            gain: display.exposure_ev.exp2(),
            tone_map,
            full_scale: 1.0,
            overscan: 0,
            dark: RELATIVE_DARK,
            opacity: 1.0,
        }
    }
}

/// A quantity to be shown instead of, or over, the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Overlay {
    /// The signed CoC: [`Map::Diverging`] from `-full_scale_px` to `full_scale_px`.
    Coc {
        /// |c| at the ends of the map, px, above 0.
        full_scale_px: f32,
        /// How much the colours hide of the picture, which is grey under them: 0 to 1.
        opacity: f32,
    },
    /// Reciprocal depth: [`Map::Sequential`] from infinity to the nearest surface.
    Depth {
        /// As of [`Overlay::Coc`].
        opacity: f32,
    },
    /// Which part is sharp: it keeps its colours, the rest is grey with a tint of the
    /// ends of [`Map::Diverging`].
    Zone {
        /// |c| up to which a point counts as sharp, px.
        acceptable_px: f32,
    },
}

/// A colour map, for the shader and for legends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Map {
    /// Blue in front of the focus distance, near white in focus, orange behind it: hues
    /// that all common forms of colour blindness tell apart.
    Diverging,
    /// Viridis.
    Sequential,
    /// Magma, as for error maps of metrics.
    Error,
}

impl Map {
    /// sRGB-encoded 8-bit colour of `t`, clamped to [0, 1].
    pub fn srgb8(self, t: f32) -> [u8; 3] {
        match self {
            Self::Diverging => diverging(t),
            Self::Sequential => ColorMap::Viridis.srgb8(t),
            Self::Error => ColorMap::Magma.srgb8(t),
        }
    }

    fn on_gpu(self, gpu: &Gpu) -> Arc<Buffer> {
        gpu.memo().get(&self, || gpu.buffer_of("colour map", &self.table()))
    }

    /// 256 steps of the map as the shader reads them.
    fn table(self) -> Vec<[f32; 4]> {
        let encoded = |v: u8| f32::from(v) / 255.0;
        let step = |i: u8| self.srgb8(encoded(i)).map(encoded);
        (0..=255).map(step).map(|[r, g, b]| [r, g, b, 1.0]).collect()
    }
}

fn diverging(t: f32) -> [u8; 3] {
    const FRONT: [f32; 3] = [28.0, 92.0, 201.0];
    const FOCUS: [f32; 3] = [240.0, 238.0, 232.0];
    const BEHIND: [f32; 3] = [214.0, 94.0, 10.0];
    let signed = t.clamp(0.0, 1.0) * 2.0 - 1.0;
    let end = if signed < 0.0 { FRONT } else { BEHIND };
    std::array::from_fn(|i| (FOCUS[i] + (end[i] - FOCUS[i]) * signed.abs()).round() as u8)
}

/// The display values of `color` in a texture of [`FORMAT`].
pub fn picture(frame: &mut Frame<'_>, color: &Texture, display: &Display) -> Texture {
    let result = frame.texture("picture", color.size(), FORMAT);
    frame
        .pass(&SHADER, "picture")
        .uniform("present", &Present::new(display))
        .texture("color", color)
        .texture("result", &result)
        .dispatch(color.size());
    result
}

/// `overlay` over `color`, which is a picture of `view` through `lens`.
///
/// Panics if `color` does not have the view's size.
pub fn overlay(
    frame: &mut Frame<'_>,
    view: &mut View,
    color: &Texture,
    lens: &Lens,
    display: &Display,
    overlay: Overlay,
) -> Texture {
    assert_eq!(color.size(), view.size(), "a picture of the view has its size");
    let depth = view.pinhole(frame).depth;
    let result = frame.texture("overlay", color.size(), FORMAT);
    let (entry, map, full_scale, opacity) = match overlay {
        Overlay::Coc { full_scale_px, opacity } => ("coc", Map::Diverging, full_scale_px, opacity),
        Overlay::Depth { opacity } => {
            // A view of nothing but the background has no nearest surface: any scale will do.
            let nearest = view.z_bounds(frame)[1].max(f32::MIN_POSITIVE);
            ("reciprocal_depth", Map::Sequential, nearest, opacity)
        }
        Overlay::Zone { acceptable_px } => ("zone", Map::Diverging, acceptable_px, ZONE_OPACITY),
    };
    let present = Present { full_scale, overscan: view.overscan_px(), opacity, ..Present::new(display) };
    let color_map = map.on_gpu(frame.gpu());
    let pass = frame.pass(&SHADER, entry).uniform("present", &present).texture("depth", &depth).texture("color", color);
    let pass = match overlay {
        Overlay::Depth { .. } => pass,
        _ => pass.uniform("lens", &view.lens_uniform(lens)),
    };
    pass.buffer("color_map", &color_map).texture("result", &result).dispatch(color.size());
    result
}

/// A difference between two images, each kind with its own scale.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DifferenceOf {
    /// |a - b| of the display values, the greatest channel: [`Map::Error`] from 0 to
    /// [`DIFFERENCE_FULL_SCALE`].
    Display,
    /// a - b of the display values, the mean of the channels: [`Map::Diverging`] from
    /// -[`DIFFERENCE_FULL_SCALE`] to it.
    Signed,
    /// |a - b| / (|b| + [`RELATIVE_DARK`]) of the linear values, the greatest channel:
    /// [`Map::Error`] from 0 to [`RELATIVE_FULL_SCALE`].
    Relative,
}

impl DifferenceOf {
    /// The colour map.
    pub fn map(self) -> Map {
        if self == Self::Signed { Map::Diverging } else { Map::Error }
    }

    /// The difference at the end of the map.
    pub(crate) fn full_scale(self) -> f32 {
        if self == Self::Relative { RELATIVE_FULL_SCALE } else { DIFFERENCE_FULL_SCALE }
    }
}

/// How `a` differs from `b`, on a colour scale that is stretched by `gain`, above 0: its end
/// is reached at `DifferenceOf::full_scale` over that. Panics if the sizes differ.
pub fn difference(
    frame: &mut Frame<'_>,
    a: &Texture,
    b: &Texture,
    display: &Display,
    of: DifferenceOf,
    gain: f32,
) -> Texture {
    assert_eq!(a.size(), b.size(), "images of one size are compared");
    let result = frame.texture("difference", a.size(), FORMAT);
    let present = Present { full_scale: of.full_scale() / gain, ..Present::new(display) };
    let color_map = of.map().on_gpu(frame.gpu());
    let entry = match of {
        DifferenceOf::Display => "difference",
        DifferenceOf::Signed => "signed_difference",
        DifferenceOf::Relative => "relative_difference",
    };
    frame
        .pass(&SHADER, entry)
        .uniform("present", &present)
        .texture("color", a)
        .texture("other", b)
        .buffer("color_map", &color_map)
        .texture("result", &result)
        .dispatch(a.size());
    result
}
