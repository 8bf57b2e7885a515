//! Sheets, which the paper does not have: spots that cover a part of what lies behind them.
//!
//! Layer by layer their pixels are spread as far as the layers in front let through, and summed in
//! front of and behind the visible solid surface of each destination.

use super::Splatting;
use crate::gpu::{Frame, Shader, Texture};
use crate::view::{Layer, Sheets};
use crate::{shader, uniform};

const SHADER: Shader = shader!("methods/splat");

/// Labels of what sheets add up to, in front of the visible surface and behind it.
pub(super) const SHEET_LABELS: [&str; 2] = ["sheets in front", "sheets behind"];

uniform! {
    struct SheetLayer {
        index: u32,
    }
}

impl Splatting {
    /// What sheets bring in front of the visible surface and behind it.
    pub(super) fn splat_sheets(&self, frame: &mut Frame<'_>, sheets: &Sheets) -> [Texture; 2] {
        let params = super::Params { sheets: 1, ..self.params };
        // How wide the spots of each tile are is measured.
        let of_sheets = Self { params, reach_px: f64::INFINITY, ..self.clone() };
        let mut sums = None;
        for index in 0..sheets.count {
            let spots = spots(frame, sheets, index);
            sums = Some(match self.by_sprites {
                true => of_sheets.draw_sheets(frame, &spots, sums),
                false => of_sheets.gather_sheets(frame, &spots, sums),
            });
        }
        let sums = sums.expect("there is a layer of sheets where there are sheets");
        for (label, sum) in SHEET_LABELS.into_iter().zip(&sums) {
            frame.expose(label, sum);
        }
        sums
    }

    /// The layer behind the visible surface with sheets in front of it.
    pub(super) fn put_behind(&self, frame: &mut Frame<'_>, sheets: &Texture, behind: &Texture) -> Texture {
        let new = frame.texture("layer behind, with sheets", self.size, wgpu::TextureFormat::Rgba32Float);
        frame
            .pass(&SHADER, "sheets_behind")
            .texture("sheet_sums", sheets)
            .texture("layer_behind", behind)
            .texture("new_behind", &new)
            .dispatch(self.size);
        new
    }

    /// The picture with the sheets in front of it.
    pub(super) fn put_in_front(&self, frame: &mut Frame<'_>, sheets: &Texture, seen: &Texture) -> Texture {
        let result = frame.color_texture("splat", self.size);
        frame
            .pass(&SHADER, "sheets_in_front")
            .texture("sheet_sums", sheets)
            .texture("seen", seen)
            .texture("result", &result)
            .dispatch(self.size);
        result
    }
}

/// What one layer of sheets spreads.
fn spots(frame: &mut Frame<'_>, sheets: &Sheets, index: u32) -> Layer {
    let size = sheets.depths.size();
    let spots = Layer {
        color: frame.texture("sheet spots", size, wgpu::TextureFormat::Rgba16Float),
        depth: frame.texture("depth of sheet spots", size, wgpu::TextureFormat::R32Float),
    };
    frame
        .pass(&SHADER, "take_sheets")
        .uniform("sheet_layer", &SheetLayer { index })
        .texture("sheet_color", &sheets.color)
        .texture("sheet_depths", &sheets.depths)
        .texture("spot_color", &spots.color)
        .texture("spot_depth", &spots.depth)
        .dispatch(size);
    spots
}
