//! What lens rays need to cross sheets (`shaders/lib/sheet_rays.wgsl`).

use super::tile_lists::TILE_PX;
use crate::gpu::{Buffer, Frame, Pass, Shader, Texture, TextureKey};
use crate::lens::Lens;
use crate::view::{Sheets, View};
use crate::{shader, uniform};
use glam::UVec2;

const SHADER: Shader = shader!("methods/sheet_tiles");

/// Greatest CoC radius of a sheet, px: `GREATEST_SHEET_S` in the shader.
const GREATEST_RADIUS_PX: f64 = 160.0;

uniform! {
    struct SheetTiles {
        tiles: [u32; 2],
        inner_tiles: [u32; 2],
        lens: crate::view::LensUniform,
        first_tile: u32,
        overscan: u32,
        reach: u32,
        lens_radius: f32,
        more_s: f32,
        _unused: [u32; 3],
    }
}

/// The sheets of a view, and which of them the rays of each tile can meet.
pub(super) struct SheetRays {
    color: Texture,
    depths: Texture,
    /// s of the nearest and the farthest sheet within reach of each 8x8 tile of the inner frame.
    pub bounds: Buffer,
    /// Whether there are any.
    pub any: bool,
}

impl SheetRays {
    /// Those of `view` through `lens`; placeholders that no ray reads if it has none.
    pub fn of(frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Self {
        match view.sheets(frame, lens) {
            Some(sheets) => Self::find(frame, view, lens, sheets),
            None => Self::none(frame),
        }
    }

    fn none(frame: &Frame<'_>) -> Self {
        let gpu = frame.gpu();
        let key = TextureKey { size: UVec2::ONE, levels: 1, layers: 2, format: wgpu::TextureFormat::Rgba16Float };
        let empty = || gpu.buffer_of("no sheets", &[[1.0f32, -1.0]]);
        Self {
            color: gpu.texture_of("no sheets", key),
            depths: frame.texture("no sheets", UVec2::ONE, wgpu::TextureFormat::Rgba32Float),
            bounds: (*gpu.memo().get(&SHADER.name, empty)).clone(),
            any: false,
        }
    }

    fn find(frame: &mut Frame<'_>, view: &View, lens: &Lens, sheets: Sheets) -> Self {
        let inner = view.size().map(|side| side.div_ceil(TILE_PX));
        let first_tile = view.overscan_px().div_ceil(TILE_PX);
        let outer = inner + 2 * first_tile;
        let lens_radius = lens.aperture.radius();
        let more_s = 0.5 * lens.greatest_astigmatism_px();
        let reach_px = (GREATEST_RADIUS_PX + more_s) * lens_radius + 1.0;
        let params = SheetTiles {
            tiles: outer.to_array(),
            inner_tiles: inner.to_array(),
            lens: view.lens_uniform(lens),
            first_tile,
            overscan: view.overscan_px(),
            // No tile is farther away than the frame is wide.
            reach: ((reach_px / f64::from(TILE_PX)).ceil() as u32 + 1).min(outer.max_element()),
            lens_radius: lens_radius as f32,
            more_s: more_s as f32,
            _unused: [0; 3],
        };
        let bytes = |tiles: UVec2| 8 * u64::from(tiles.x) * u64::from(tiles.y);
        let marked = frame.gpu().scratch("sheets of tiles", bytes(outer));
        let bounds = frame.gpu().scratch("sheets within reach", bytes(inner));
        frame
            .pass(&SHADER, "mark_sheets")
            .uniform("params", &params)
            .texture("sheet_depths", &sheets.depths)
            .buffer("new_marked", &marked)
            .dispatch(outer);
        frame
            .pass(&SHADER, "reach_sheets")
            .uniform("params", &params)
            .buffer("marked", &marked)
            .buffer("new_bounds", &bounds)
            .dispatch(inner);
        Self { color: sheets.color, depths: sheets.depths, bounds, any: true }
    }

    /// Binds what `shaders/lib/sheet_rays.wgsl` reads.
    pub fn bind<'f, 'g>(&self, pass: Pass<'f, 'g>) -> Pass<'f, 'g> {
        pass.texture("sheet_colors", &self.color)
            .texture("sheet_depths", &self.depths)
            .buffer("sheet_bounds", &self.bounds)
    }
}
