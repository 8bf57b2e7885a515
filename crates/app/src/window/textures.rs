//! The engine's textures as egui knows them.

use super::App;
use super::model::PaneId;
use defocus::gpu::Texture;
use eframe::egui::{self, TextureId};

/// A texture that egui knows by an id.
pub struct Registered {
    pub id: TextureId,
    pub texture: Texture,
    pub filter: wgpu::FilterMode,
}

impl App {
    /// Tells egui about the textures that the engine made.
    pub(super) fn register_textures(&mut self, ctx: &egui::Context) {
        let device = &self.render_state.device;
        let gone: Vec<PaneId> = self.textures.keys().copied().filter(|id| self.engine.pane(*id).is_none()).collect();
        let mut renderer = self.render_state.renderer.write();
        self.retired.drain(..).for_each(|id| renderer.free_texture(&id));
        for id in gone {
            if let Some(registered) = self.textures.remove(&id) {
                renderer.free_texture(&registered.id);
            }
        }
        for pane in &self.document.panes {
            let Some(shown) = self.shown(pane.id).cloned() else { continue };
            // What is drawn smaller for the sake of speed is smooth.
            let filter = match self.engine.pane(pane.id).is_some_and(|pane| pane.divisor() > 1) {
                true => wgpu::FilterMode::Linear,
                false => self.viewport.filter(),
            };
            match self.textures.get_mut(&pane.id) {
                Some(known) if known.texture.same(&shown) && known.filter == filter => {}
                Some(known) if known.texture.size() == shown.size() => {
                    renderer.update_egui_texture_from_wgpu_texture(device, shown.view(), filter, known.id);
                    (known.texture, known.filter) = (shown, filter);
                }
                // One of another shape is placed otherwise, which this frame did not know.
                _ => {
                    let id = renderer.register_native_texture(device, shown.view(), filter);
                    let old = self.textures.insert(pane.id, Registered { id, texture: shown, filter });
                    self.retired.extend(old.map(|registered| registered.id));
                    // It has an id to be painted by from the next frame on.
                    ctx.request_repaint();
                }
            }
        }
    }
}
