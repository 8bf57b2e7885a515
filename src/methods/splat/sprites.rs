//! Spots as sprites that are drawn and blended, as the paper has it.

use super::super::sprites::sum_format;
use super::sheets::SHEET_LABELS;
use super::{HIDDEN_LABELS, LAYER_LABELS, Splatting};
use crate::gpu::{Blend, Draw, Frame, Gpu, Shader, Texture};
use crate::shader;
use crate::view::Layer;

const SHADER: Shader = shader!("methods/splat_sprites");

/// Targets of all layers together.
const TARGETS: u32 = 3;

/// Whether all layers can be summed in 32-bit float.
pub(super) fn blends_32_bits(gpu: &Gpu) -> bool {
    sum_format(gpu, TARGETS) == wgpu::TextureFormat::Rgba32Float
}

impl Splatting {
    /// L0, L1 and L2, in 32-bit float where that can be blended.
    pub(super) fn draw_visible(&self, frame: &mut Frame<'_>, arrays: Option<&Texture>) -> [Texture; 3] {
        let format = sum_format(frame.gpu(), TARGETS);
        let layers = LAYER_LABELS.map(|label| frame.texture(label, self.size, format));
        self.draw_sharp(frame, &layers);
        let pixels = self.visible.depth.size().element_product();
        let Some(arrays) = arrays else {
            self.draw(frame, ["vs_pixel", "fs_visible"], &self.visible, &layers, None).vertices(4, pixels);
            return layers;
        };
        let blocks = arrays.size().element_product();
        for (vertex, sprites) in [("vs_block", blocks), ("vs_pixel_not_reduced", pixels)] {
            let draw = self.draw(frame, [vertex, "fs_visible"], &self.visible, &layers, None);
            draw.texture("arrays", arrays).vertices(4, sprites);
        }
        layers
    }

    /// What stays within its pixel, with which the layers begin.
    fn draw_sharp(&self, frame: &mut Frame<'_>, layers: &[Texture]) {
        let mut draw = frame.draw(&SHADER, "vs_all", "fs_sharp");
        for layer in layers {
            draw = draw.target(layer, Blend::Replace, Some([0.0; 4]));
        }
        draw.uniform("lens", &self.lens)
            .uniform("sprites", &self.sprites)
            .uniform("params", &self.params)
            .texture("color", &self.visible.color)
            .texture("depth", &self.visible.depth)
            .texture("visible_depth", &self.visible.depth)
            .vertices(3, 1);
    }

    /// M1 and M2.
    pub(super) fn draw_hidden(&self, frame: &mut Frame<'_>, hidden: &Layer) -> [Texture; 2] {
        let pixels = hidden.depth.size().element_product();
        let format = sum_format(frame.gpu(), TARGETS);
        let layers = HIDDEN_LABELS.map(|label| frame.texture(label, self.size, format));
        self.draw(frame, ["vs_hidden", "fs_hidden"], hidden, &layers, Some([0.0; 4])).vertices(4, pixels);
        layers
    }

    /// Sheets in front of the visible surface and behind it, added to `sums` from the second layer on.
    pub(super) fn draw_sheets(&self, frame: &mut Frame<'_>, spots: &Layer, sums: Option<[Texture; 2]>) -> [Texture; 2] {
        let pixels = spots.depth.size().element_product();
        let format = sum_format(frame.gpu(), TARGETS);
        let clear = sums.is_none().then_some([0.0; 4]);
        let layers = sums.unwrap_or_else(|| SHEET_LABELS.map(|label| frame.texture(label, self.size, format)));
        self.draw(frame, ["vs_hidden", "fs_sheets"], spots, &layers, clear).vertices(4, pixels);
        layers
    }

    fn draw<'f, 'g>(
        &self,
        frame: &'f mut Frame<'g>,
        [vertex, fragment]: [&'static str; 2],
        source: &Layer,
        layers: &[Texture],
        clear: Option<[f64; 4]>,
    ) -> Draw<'f, 'g> {
        let mut draw = frame.draw(&SHADER, vertex, fragment).strips();
        for layer in layers {
            draw = draw.target(layer, Blend::Add, clear);
        }
        draw.uniform("lens", &self.lens)
            .uniform("sprites", &self.sprites)
            .uniform("params", &self.params)
            .texture("color", &source.color)
            .texture("depth", &source.depth)
            .texture("visible_depth", &self.visible.depth)
            .texture("idf_sums", &self.idf_sums)
    }
}
