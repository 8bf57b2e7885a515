//! Spots as what each pixel gathers, tile by tile: no overdraw and no blending.

use super::sheets::SHEET_LABELS;
use super::{HIDDEN_LABELS, LAYER_LABELS, Splatting};
use crate::gpu::{Buffer, Frame, Gpu, Pass, Shader, Texture};
use crate::view::Layer;
use crate::{shader, uniform};
use glam::UVec2;

const SHADER: Shader = shader!("methods/splat_tiles");

/// Side of a tile, px: `TILE` in the shader.
const TILE_PX: u32 = 16;

/// Most offsets of a chunk: `MOST_OFFSETS` in the shader.
const MOST_OFFSETS: [u32; 2] = [18, 11];

/// Rounds that an offset takes: one, and for each of 2x2 pixels one a strip of an ellipse (`STRIPS` in
/// `shaders/lib/spots.wgsl`) and one for its end. A software adapter runs both sides of a
/// branch: where spots are round, it takes the one for the end.
const fn rounds_an_offset(has_ellipses: bool) -> u32 {
    if has_ellipses { 1 + 4 * (7 + 1) } else { 1 + 4 }
}

/// Chunks of offsets that one pass sums on a software adapter: it ends all loops of an invocation
/// after 65,535 rounds. A chunk takes 13 and their end to put sources into workgroup memory, a row of
/// offsets two more than its offsets, and less than 16 are for the rest; a thousand are left for
/// finding what is near.
const fn chunks_a_part(has_ellipses: bool) -> u32 {
    let [columns, rows] = MOST_OFFSETS;
    64_535 / (14 + rows * (2 + columns * rounds_an_offset(has_ellipses)) + 16)
}

/// Chunks of `count` x `count` offsets.
fn chunks(count: u32) -> u32 {
    MOST_OFFSETS.map(|most| count.div_ceil(most)).iter().product()
}

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

uniform! {
    struct Tiles {
        count: [u32; 2],
        first: u32,
        window: u32,
        part_begin: u32,
        part_end: u32,
        is_first: u32,
        reduced: u32,
    }
}

impl Tiles {
    /// The parts in which the chunks of offsets are summed: as many as of a tile that spots reach
    /// from `reach_px` away, `grid_of` in the shader.
    fn parts(&self, gpu: &Gpu, reach_px: f64, has_ellipses: bool) -> Vec<Self> {
        // A tile's reach has half a pixel more for blocks, and is rounded.
        let reach = (reach_px + 1.0).min(f64::from(TILE_PX * (self.window + 1))).ceil() as u32;
        let whole = chunks(2 * reach) + chunks(reach + 4) * self.reduced;
        let step = if gpu.is_software() { chunks_a_part(has_ellipses) } else { whole };
        let part = |begin| Self { part_begin: begin, part_end: begin + step, is_first: (begin == 0).into(), ..*self };
        (0..whole).step_by(step as usize).map(part).collect()
    }
}

impl Splatting {
    /// L0, L1 and L2.
    pub(super) fn gather_visible(&self, frame: &mut Frame<'_>, arrays: Option<&Texture>) -> [Texture; 3] {
        self.gather(frame, &self.visible, arrays, ["measure_visible", "gather_visible"], LAYER_LABELS, None)
    }

    /// M1 and M2.
    pub(super) fn gather_hidden(&self, frame: &mut Frame<'_>, hidden: &Layer) -> [Texture; 2] {
        self.gather(frame, hidden, None, ["measure_hidden", "gather_hidden"], HIDDEN_LABELS, None)
    }

    /// Sheets in front of the visible surface and behind it, added to `sums` from the second layer on.
    pub(super) fn gather_sheets(
        &self,
        frame: &mut Frame<'_>,
        spots: &Layer,
        sums: Option<[Texture; 2]>,
    ) -> [Texture; 2] {
        self.gather(frame, spots, None, ["measure_hidden", "gather_hidden"], SHEET_LABELS, sums)
    }

    /// The layers called `labels`, the last of three, added to `sums`.
    fn gather<const N: usize>(
        &self,
        frame: &mut Frame<'_>,
        source: &Layer,
        arrays: Option<&Texture>,
        [measure, gather]: [&'static str; 2],
        labels: [&str; N],
        sums: Option<[Texture; N]>,
    ) -> [Texture; N] {
        let none = frame.texture("no sums", UVec2::ONE, FORMAT);
        let no_arrays = frame.texture("no sprite arrays", UVec2::ONE, wgpu::TextureFormat::R32Uint);
        let tiles = self.tiles(arrays.is_some());
        let arrays = arrays.unwrap_or(&no_arrays);
        let reach = self.measure(frame, source, arrays, &tiles, measure);
        let goes_on = sums.is_some();
        let mut layers: [Texture; N] = sums.unwrap_or_else(|| std::array::from_fn(|_| none.clone()));
        for part in tiles.parts(frame.gpu(), self.reach_px, self.lens.astigmatism_px != 0.0) {
            let part = Tiles { is_first: if goes_on { 0 } else { part.is_first }, ..part };
            let new = labels.map(|label| frame.texture(label, self.size, FORMAT));
            let pass = self.of_source(frame.pass(&SHADER, gather), source, arrays, &part);
            let mut pass = pass
                .buffer("tile_reach_px", &reach)
                .texture("idf_sums", &self.idf_sums)
                .buffer("idf_table", &self.idf_table)
                .uniform("params", &self.params);
            // Of fewer than three the sums of the first are neither kept nor read.
            for (i, (old_name, new_name)) in SUMS.into_iter().enumerate() {
                let layer = i.checked_sub(SUMS.len() - N);
                pass = pass.texture(old_name, layer.map_or(&none, |layer| &layers[layer]));
                if let Some(layer) = layer {
                    pass = pass.texture(new_name, &new[layer]);
                }
            }
            let [x, y] = self.size.map(|side| side.div_ceil(TILE_PX)).to_array();
            pass.texture("visible_depth", &self.visible.depth).dispatch_groups(x, y, 1);
            layers = new;
        }
        layers
    }

    fn tiles(&self, reduced: bool) -> Tiles {
        let first = self.sprites.overscan.div_ceil(TILE_PX);
        let count = self.size.map(|side| side.div_ceil(TILE_PX)) + 2 * first;
        // A block's spot lies half a pixel off, and may be rounded up. No tile is farther away
        // than the frame is wide.
        let window = (((self.reach_px + 1.0) / f64::from(TILE_PX)).ceil() as u32).saturating_add(1);
        Tiles {
            count: count.to_array(),
            first,
            window: window.min(count.max_element()),
            reduced: reduced.into(),
            ..bytemuck::Zeroable::zeroed()
        }
    }

    /// How far the spots of each tile reach.
    fn measure(
        &self,
        frame: &mut Frame<'_>,
        source: &Layer,
        arrays: &Texture,
        tiles: &Tiles,
        entry: &'static str,
    ) -> Buffer {
        let [x, y] = tiles.count;
        let reach = frame.gpu().scratch("reach of each tile", 4 * u64::from(x) * u64::from(y));
        let pass = self.of_source(frame.pass(&SHADER, entry), source, arrays, tiles);
        pass.uniform("params", &self.params).buffer("new_tile_reach_px", &reach).dispatch_groups(x, y, 1);
        reach
    }

    fn of_source<'f, 'g>(&self, pass: Pass<'f, 'g>, source: &Layer, arrays: &Texture, tiles: &Tiles) -> Pass<'f, 'g> {
        pass.uniform("tiles", tiles)
            .uniform("lens", &self.lens)
            .uniform("sprites", &self.sprites)
            .texture("color", &source.color)
            .texture("depth", &source.depth)
            .texture("arrays", arrays)
    }
}

/// Sums of the parts before and of this one, by the shader's names.
const SUMS: [(&str, &str); 3] = [("sum_front", "new_front"), ("sum_same", "new_same"), ("sum_behind", "new_behind")];
