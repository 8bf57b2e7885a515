//! Single levels, layers and channels of textures: alone, or over the picture.

use super::{FORMAT, Map, Place, Present, SHADER};
use crate::display::Display;
use crate::gpu::{Frame, Texture};
use crate::methods::Scale;
use crate::uniform;
use glam::UVec2;

uniform! {
    struct Plane {
        low: f32,
        high: f32,
        channel: u32,
        _unused: u32,
        min_px: [f32; 2],
        texels_per_px: [f32; 2],
    }
}

/// A level and a layer of a float texture.
#[derive(Clone, Copy, Debug)]
pub struct Slice<'a> {
    /// The texture.
    pub texture: &'a Texture,
    /// Mipmap level.
    pub level: u32,
    /// Array layer.
    pub layer: u32,
}

impl Slice<'_> {
    /// Its size, texels.
    pub fn size(&self) -> UVec2 {
        self.texture.level_size(self.level)
    }
}

/// The display values of a slice's red, green and blue.
pub fn slice_picture(frame: &mut Frame<'_>, slice: Slice<'_>, display: &Display) -> Texture {
    let result = frame.texture("slice", slice.size(), FORMAT);
    frame
        .pass(&SHADER, "picture")
        .uniform("present", &Present::new(display))
        .slice("color", slice.texture, slice.level, slice.layer)
        .texture("result", &result)
        .dispatch(result.size());
    result
}

/// Least and greatest finite value of one channel (0 to 3) of a slice; `None` where there
/// is none. Waits for the GPU.
pub fn slice_range(frame: &mut Frame<'_>, slice: Slice<'_>, channel: u32) -> Option<[f32; 2]> {
    let bounds = frame.gpu().buffer_of("channel range", &[u32::MAX, 0]);
    frame
        .pass(&SHADER, "channel_range")
        .uniform("plane", &Plane { channel, ..Plane::default() })
        .slice("color", slice.texture, slice.level, slice.layer)
        .buffer("bounds", &bounds)
        .dispatch(slice.size());
    let bits: Vec<u32> = frame.read_buffer(&bounds);
    let float = |bits: u32| f32::from_bits(if bits & 1 << 31 == 0 { !bits } else { bits & !(1 << 31) });
    match bits[..] {
        [low, high] if low <= high => Some([float(low), float(high)]),
        _ => None,
    }
}

/// One channel of a slice on a colour scale.
#[derive(Clone, Copy, Debug)]
pub struct Numbers<'a> {
    /// Where they are.
    pub slice: Slice<'a>,
    /// The channel, 0 to 3.
    pub channel: u32,
    /// The colours.
    pub map: Map,
    /// Values at its ends.
    pub ends: [f32; 2],
}

impl<'a> Numbers<'a> {
    /// A channel in the colours of `scale`. Waits for the GPU where those depend on what is
    /// found; without a finite number they go from 0 to 1.
    pub fn on(frame: &mut Frame<'_>, slice: Slice<'a>, channel: u32, scale: Scale) -> Self {
        let found = match scale {
            Scale::Classes(_) => None,
            _ => slice_range(frame, slice, channel),
        };
        let map = if scale == Scale::Signed { Map::Diverging } else { Map::Sequential };
        Self { slice, channel, map, ends: scale.ends(found.unwrap_or([0.0, 1.0])) }
    }

    /// The numbers alone, as large as their slice.
    pub fn alone(&self, frame: &mut Frame<'_>) -> Texture {
        let result = frame.texture("slice", self.slice.size(), FORMAT);
        let color_map = self.map.on_gpu(frame.gpu());
        frame
            .pass(&SHADER, "one_channel")
            .uniform("plane", &self.plane())
            .slice("color", self.slice.texture, self.slice.level, self.slice.layer)
            .buffer("color_map", &color_map)
            .texture("result", &result)
            .dispatch(result.size());
        result
    }

    /// The numbers over the picture `color`, grey under them, which they hide by `opacity`
    /// (0 to 1): of each pixel the one whose texel, of a texture in `place`, it lies in.
    /// Where there is no texel or no finite number, the picture is bare.
    pub fn over(
        &self,
        frame: &mut Frame<'_>,
        color: &Texture,
        display: &Display,
        place: Place,
        opacity: f32,
    ) -> Texture {
        let result = frame.texture("numbers over the picture", color.size(), FORMAT);
        let color_map = self.map.on_gpu(frame.gpu());
        let texels_per_px = (self.slice.size().as_vec2() / place.size).to_array();
        let plane = Plane { min_px: place.min.to_array(), texels_per_px, ..self.plane() };
        frame
            .pass(&SHADER, "one_channel_over")
            .uniform("present", &Present { opacity, ..Present::new(display) })
            .uniform("plane", &plane)
            .texture("color", color)
            .slice("other", self.slice.texture, self.slice.level, self.slice.layer)
            .buffer("color_map", &color_map)
            .texture("result", &result)
            .dispatch(result.size());
        result
    }

    fn plane(&self) -> Plane {
        let [low, high] = self.ends;
        Plane { low, high, channel: self.channel, ..Plane::default() }
    }
}
