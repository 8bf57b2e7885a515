//! Sheets: surfaces that cover a part of what lies behind them
//! ([`Material::is_sheet`](crate::scene::Material::is_sheet)).
//!
//! They are peeled one behind another, whatever solid surface lies in front or behind. The pinhole
//! image of a scene has them over its solid surfaces; a method that knows more than one surface a
//! pixel takes the solid ones from [`View::solid`], as if there were no sheets, and mixes in
//! [`View::sheets`] itself.

use super::raster::SceneSource;
use super::{Layer, LayerQuery, Source, View, copy_to_array_layer};
use crate::gpu::{Frame, Shader, Texture, TextureKey};
use crate::lens::Lens;
use crate::{shader, uniform};

const SHADER: Shader = shader!("sheets");

/// Most sheets behind one another; of more the farthest are left out. `MOST_PEELS` in the shader.
pub const MAX_SHEETS: u32 = 8;

/// Layers that they are merged to: components of [`Sheets::depths`].
pub const SHEET_LAYERS: u32 = 4;

uniform! {
    struct Merge {
        peels: u32,
        separation_z: f32,
    }
}

/// All sheets as the pinhole sees them, as arrays of the outer size.
#[derive(Clone)]
pub(super) struct Peels {
    /// RGBA16F: radiance and coverage.
    color: Texture,
    /// R32F: stored depth, nearest sheet first.
    depth: Texture,
    count: u32,
}

/// Sheets in up to four layers as the pinhole sees them, of the outer size.
#[derive(Clone, Debug)]
pub struct Sheets {
    /// RGBA16F array: radiance times coverage, and coverage.
    pub color: Texture,
    /// RGBA32F: stored depth of each layer, nearest first, -1 where it is empty. What lies
    /// closer together than a lens tells apart is one layer, at the depth of its nearest sheet; the last
    /// layer holds all that is left.
    pub depths: Texture,
    /// Layers that may hold anything: the first of the four.
    pub count: u32,
    separation_z: f32,
}

impl View {
    /// Whether any sheet is in view.
    pub fn has_sheets(&self) -> bool {
        self.most_sheets() > 0
    }

    /// The same view without sheets: itself if there are none.
    pub fn solid(&mut self) -> &mut View {
        if !self.has_sheets() {
            return self;
        }
        let Source::Scene(source) = &self.source else { return self };
        if self.solid.is_none() {
            let source = SceneSource::new(source.scene.clone(), source.camera).toned(self.tone);
            let mut solid = Self::new(Source::Scene(Box::new(source)), self.projection);
            solid.without_sheets = true;
            solid.fine_drawing = self.fine_drawing;
            solid.draft = self.draft;
            solid.keep_promises_of(self);
            self.solid = Some(Box::new(solid));
        }
        self.solid.as_mut().expect("it was just made")
    }

    /// The sheets in view, in layers as far apart as `lens` tells; `None` if there are none.
    pub fn sheets(&mut self, frame: &mut Frame<'_>, lens: &Lens) -> Option<Sheets> {
        let separation_z = self.layer_separation(lens).z;
        if let Some(known) = self.sheets.as_ref().filter(|known| known.separation_z == separation_z) {
            frame.skip("sheets unchanged");
            return Some(known.clone());
        }
        let peels = self.peels(frame)?;
        let (size, gpu) = (peels.depth.size(), frame.gpu());
        let key = TextureKey { size, levels: 1, layers: SHEET_LAYERS, format: wgpu::TextureFormat::Rgba16Float };
        let sheets = Sheets {
            color: gpu.texture_of("sheet layers", key),
            depths: frame.texture("depths of sheet layers", size, wgpu::TextureFormat::Rgba32Float),
            count: peels.count.min(SHEET_LAYERS),
            separation_z,
        };
        frame
            .pass(&SHADER, "merge_sheets")
            .uniform("merging", &Merge { peels: peels.count, separation_z })
            .texture("peeled_color", &peels.color)
            .texture("peeled_depth", &peels.depth)
            .texture("new_color", &sheets.color)
            .texture("new_depths", &sheets.depths)
            .dispatch(size);
        self.sheets = Some(sheets.clone());
        Some(sheets)
    }

    /// What the pinhole sees: all sheets in front of `solid` over it, at the depth of the nearest
    /// surface that covers half or more.
    pub(super) fn under_sheets(&mut self, frame: &mut Frame<'_>, solid: Layer) -> Layer {
        let Some(peels) = self.peels(frame) else { return solid };
        let size = solid.color.size();
        let layer = Layer {
            color: frame.texture("pinhole", size, solid.color.format()),
            depth: frame.texture("pinhole depth", size, solid.depth.format()),
        };
        frame
            .pass(&SHADER, "lay_over")
            .uniform("merging", &Merge { peels: peels.count, separation_z: 0.0 })
            .texture("peeled_color", &peels.color)
            .texture("peeled_depth", &peels.depth)
            .texture("solid_color", &solid.color)
            .texture("solid_depth", &solid.depth)
            .texture("seen_color", &layer.color)
            .texture("seen_depth", &layer.depth)
            .dispatch(size);
        layer
    }

    /// How many sheets can lie behind one another in view, at most.
    fn most_sheets(&self) -> u32 {
        match &self.source {
            Source::Scene(source) if !self.without_sheets => {
                source.most_sheets(&self.pinhole_shot(LayerQuery::NEAREST)).min(MAX_SHEETS.into()) as u32
            }
            _ => 0,
        }
    }

    fn peels(&mut self, frame: &mut Frame<'_>) -> Option<Peels> {
        if let Some(known) = &self.peels {
            return Some(known.clone());
        }
        let count = self.most_sheets();
        let Source::Scene(source) = &self.source else { return None };
        if count == 0 {
            return None;
        }
        let size = self.projection.outer_size();
        let gpu = frame.gpu();
        // A shader's array needs two layers to be one.
        let array = |format| TextureKey { size, levels: 1, layers: count.max(2), format };
        let peels = Peels {
            color: gpu.texture_of("peeled sheets", array(wgpu::TextureFormat::Rgba16Float)),
            depth: gpu.texture_of("depths of peeled sheets", array(wgpu::TextureFormat::R32Float)),
            count,
        };
        let mut nearer: Option<Layer> = None;
        for index in 0..count {
            let below = nearer.as_ref().map(|layer| &layer.depth);
            let query = LayerQuery { below, ..LayerQuery::NEAREST };
            let layer = source.draw_sheets(frame, &format!("sheets {index}"), &self.pinhole_shot(query));
            copy_to_array_layer(frame, &layer.color, &peels.color, index);
            copy_to_array_layer(frame, &layer.depth, &peels.depth, index);
            nearer = Some(layer);
        }
        self.peels = Some(peels.clone());
        Some(peels)
    }
}
