//! The story of a pixel: what every texture that a method makes on its way holds there.

use super::pane::Pane;
use super::reading::{Spot, read_texels};
use super::renderer::Engine;
use crate::window::model::PaneId;
use defocus::gpu::Texture;
use defocus::methods::Meaning;
use glam::{DVec2, UVec2};

/// Slices of one texture that are told: all levels of a pyramid and all layers of a scene have
/// room, and a table of hundreds has not.
const MOST_SLICES: u32 = 24;

/// What a texture holds at a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct StoryLine {
    /// Name under which the method exposes the texture.
    pub texture: String,
    /// Mipmap level, where there are several.
    pub level: Option<u32>,
    /// Array layer, where there are several.
    pub layer: Option<u32>,
    /// The texel that lies there.
    pub texel: UVec2,
    /// Width of a texel in pixels of the picture: above 1, of a tile or a coarser level.
    pub texel_px: f32,
    /// What the numbers mean.
    pub meaning: Meaning,
    /// The stored numbers; those that the format lacks are 0.
    pub values: [f32; 4],
    /// Channels that the format has.
    pub channels: u32,
}

/// All that is known of a pixel in a method.
#[derive(Clone, Debug, PartialEq)]
pub struct Story {
    /// Size of the picture whose textures these are, px.
    pub size: UVec2,
    /// How many times smaller than in full it is drawn.
    pub divisor: u32,
    /// In the order in which the method makes them.
    pub lines: Vec<StoryLine>,
}

impl Engine {
    /// What the textures of a pane's method hold at a point of the picture, from (0, 0) top left
    /// to (1, 1), where [`Request::story`](super::Request) asks for it. Waits for the GPU;
    /// `None` before there is a picture, and where the device is lost.
    pub fn story_at(&self, id: PaneId, at: DVec2) -> Option<Story> {
        let pane = self.panes.get(&id).filter(|_| !self.is_lost())?;
        let size = pane.exposed_size();
        let mut lines = Vec::new();
        let mut spots = Vec::new();
        for (name, texture) in pane.exposed() {
            // What is a single row is a table and has no place on the picture.
            if texture.size().min_element() <= 1 && size.min_element() > 1 {
                continue;
            }
            for (line, spot) in slices(pane, name, texture, at) {
                lines.push(line);
                spots.push(spot);
            }
        }
        let texels = read_texels(&self.gpu, &spots)?;
        let told =
            lines.into_iter().zip(texels).filter_map(|(line, values)| Some(StoryLine { values: values?, ..line }));
        Some(Story { size, divisor: self.exposed_divisor(id), lines: told.collect() })
    }
}

/// The levels and layers of a texture at a point, still without their numbers.
fn slices<'t>(pane: &Pane, name: &str, texture: &'t Texture, at: DVec2) -> impl Iterator<Item = (StoryLine, Spot<'t>)> {
    let (levels, layers) = (texture.levels(), texture.layers());
    let place = pane.place_of(name, texture);
    let (inner, meaning) = (pane.exposed_size(), pane.meaning(name));
    let channels = u32::from(texture.format().components());
    let texture_name = name.to_owned();
    let slices = (0..levels).flat_map(move |level| (0..layers).map(move |layer| (level, layer)));
    slices.take(MOST_SLICES as usize).filter_map(move |(level, layer)| {
        let size = texture.level_size(level);
        let texel = place.texel(size, inner, at)?;
        let line = StoryLine {
            texture: texture_name.clone(),
            level: (levels > 1).then_some(level),
            layer: (layers > 1).then_some(layer),
            texel,
            texel_px: place.size.x / size.x.max(1) as f32,
            meaning: meaning.clone(),
            values: [0.0; 4],
            channels,
        };
        Some((line, Spot { texture, level, layer, texel }))
    })
}
