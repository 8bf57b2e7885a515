//! Values of the textures inside methods, where someone points.

use super::pane::Pane;
use super::reading::{Reading, Spot, read_texels};
use super::renderer::Engine;
use crate::window::model::{PaneId, Show};
use defocus::gpu::Texture;
use defocus::methods::{Meaning, Quantity};
use glam::DVec2;

impl Engine {
    /// What a pane that looks inside its method shows at a point of the picture, from (0, 0)
    /// top left to (1, 1), if those are numbers. Waits for the GPU.
    pub fn inside_at(&self, id: PaneId, at: DVec2) -> Option<(&Reading, f32)> {
        let pane = self.panes.get(&id)?;
        let Show::Inside(inside) = &pane.state.show else { return None };
        let (reading, (name, texture)) = (pane.reading()?, pane.exposed_as(inside)?);
        let (level, layer, channel) = reading.at;
        Some((reading, self.texel(pane, name, (texture, level, layer), at)?[channel as usize]))
    }

    /// What a pane's method tells of a point of the picture, as [`Engine::inside_at`] takes
    /// it, where [`Request::explain`](super::Request) asks for it. Waits for the GPU.
    pub fn explained_at(&self, id: PaneId, at: DVec2) -> Vec<(Quantity, f32)> {
        let Some(pane) = self.panes.get(&id) else { return Vec::new() };
        let explained = pane.exposed().filter(|(name, _)| pane.explains().contains(name));
        let told = |(name, texture)| {
            let texel = self.texel(pane, name, (texture, 0, 0), at);
            let Meaning::Numbers(quantities) = pane.meaning(name) else { return Vec::new() };
            texel.map_or_else(Vec::new, |texel| quantities.into_iter().zip(texel).collect())
        };
        explained.flat_map(told).collect()
    }

    /// How many times smaller than the picture that is asked for the one is whose textures a pane
    /// has: a full picture that was drawn beside brings none of its own.
    pub fn exposed_divisor(&self, id: PaneId) -> u32 {
        let exposed = self.panes.get(&id).map(Pane::exposed_size).filter(|size| size.x > 0);
        let (Some(exposed), Some(asked)) = (exposed, self.size()) else { return 1 };
        (f64::from(asked.x) / f64::from(exposed.x)).round().max(1.0) as u32
    }

    /// The texel of a level and layer of an exposed texture that lies at a point of the
    /// picture.
    fn texel(&self, pane: &Pane, name: &str, of: (&Texture, u32, u32), at: DVec2) -> Option<[f32; 4]> {
        let (texture, level, layer) = of;
        if self.is_lost() {
            return None;
        }
        let size = texture.level_size(level);
        let texel = pane.place_of(name, texture).texel(size, pane.exposed_size(), at)?;
        read_texels(&self.gpu, &[Spot { texture, level, layer, texel }])?.pop()?
    }
}
