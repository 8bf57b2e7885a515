//! Highlights: texels far brighter than white, brought to the pixels that their blur
//! covers one by one instead of by chance.

use super::AdaptiveUniform;
use super::tiles::TILE_PX;
use crate::aperture::Aperture;
use crate::gpu::{Buffer, Frame, Gpu, Shader, Texture};
use crate::lens::Lens;
use crate::methods::sprites::SpriteTable;
use crate::view::{Lights, Peeled};
use crate::{shader, uniform};
use glam::{UVec2, dvec2};

const SHADER: Shader = shader!("methods/adaptive_highlights");

/// Emitters that a tile can list. Cells are an eighth to a quarter of the blur's radius
/// wide, at most 32 px, and those reach a tile of 8 px that lie in the 24 cells of 1 px on each side
/// around it, or in fewer larger ones: one surface that is bright everywhere has no more.
const CAPACITY: u32 = 24 * 24;

/// Cells on each side of the aperture's table: one is 1/32 of the lens's radius wide.
const TABLE_SIDE: u32 = 64;

uniform! {
    pub(super) struct HighlightsUniform {
        capacity: u32,
        sample_px: f32,
        is_disc: u32,
        margin_tiles: u32,
        block_px: u32,
        _unused: [u32; 3],
    }
}

/// Emitters and the tiles that see them, on the GPU.
pub(super) struct Highlights {
    pub uniform: HighlightsUniform,
    /// The number of emitters, then for each inner tile how many cover it.
    pub counts: Buffer,
    pub lists: Buffer,
    /// For each inner tile the length of its list.
    pub listed_counts: Buffer,
    pub emitters: Buffer,
    /// Share of the lens's light below and to the left of lens points from -1 to 1 lens radii; of an
    /// astigmatic eye its [`SpriteTable`].
    pub aperture: Texture,
}

impl Highlights {
    /// Records the passes that find the emitters of all layers and list them by tile.
    pub fn find(
        frame: &mut Frame<'_>,
        lens: &Lens,
        lights: &Lights,
        peeled: &Peeled,
        adaptive: &AdaptiveUniform,
    ) -> Self {
        let gpu = frame.gpu();
        let aperture = &lens.aperture;
        let more_s = 0.5 * lens.greatest_astigmatism_px() as f32;
        let [columns, rows] = adaptive.inner_tiles.map(u64::from);
        // What blurs into the inner frame lies within reach of it, in the outer frame or beyond.
        let margin_tiles = adaptive.reach.saturating_sub(adaptive.first_tile);
        let found = Self {
            uniform: HighlightsUniform {
                capacity: CAPACITY,
                sample_px: lights.sample_px,
                is_disc: (*aperture == Aperture::Disc).into(),
                margin_tiles,
                block_px: 1,
                _unused: [0; 3],
            },
            counts: counts(gpu, adaptive),
            listed_counts: counts(gpu, adaptive),
            lists: gpu.scratch("emitter lists", 4 * u64::from(CAPACITY) * columns * rows),
            emitters: gpu.scratch("emitters", EMITTER_BYTES * most_emitters(adaptive, margin_tiles)),
            aperture: match more_s {
                0.0 => gpu.memo().get(aperture, || ApertureTable(aperture_table(gpu, aperture))).0.clone(),
                _ => SpriteTable::texture_of_lens(lens, gpu),
            },
        };
        let greatest_s = adaptive.nearest_s.abs().max(adaptive.farthest_s.abs()) + more_s;
        let has_large = greatest_s * adaptive.lens_radius >= LARGE_FROM_PX;
        // Cells of at most a tile belong to blur of less than 64 px, which reaches no farther.
        let small = (1, margin_tiles.min(LARGE_FROM_PX as u32 / TILE_PX + 1));
        let large = (LARGE_BLOCK_PX, margin_tiles);
        for (block_px, margin_tiles) in [small, large].into_iter().take(1 + usize::from(has_large)) {
            let searched = (UVec2::from(adaptive.tiles) + 2 * margin_tiles) * TILE_PX;
            frame
                .pass(&SHADER, "find_emitters")
                .uniform("adaptive", adaptive)
                .uniform("highlights", &HighlightsUniform { block_px, margin_tiles, ..found.uniform })
                .buffer("lights", &lights.buffer)
                .buffer("light_tiles", &lights.tiles)
                .texture("colors", &peeled.color)
                .texture("depth", &peeled.depth)
                .buffer("emitter_counts", &found.counts)
                .buffer("emitters", &found.emitters)
                .dispatch(searched.map(|side| side.div_ceil(block_px)));
        }
        frame
            .pass(&SHADER, "count_emitters")
            .uniform("adaptive", adaptive)
            .buffer("emitter_counts", &found.counts)
            .buffer("emitters", &found.emitters)
            .dispatch_groups(LISTING, 1, 1);
        frame
            .pass(&SHADER, "list_emitters")
            .uniform("adaptive", adaptive)
            .uniform("highlights", &found.uniform)
            .buffer("emitter_counts", &found.counts)
            .buffer("listed_counts", &found.listed_counts)
            .buffer("emitter_lists", &found.lists)
            .buffer("emitters", &found.emitters)
            .dispatch_groups(LISTING, 1, 1);
        found
    }
}

/// Emitters that there may be, of all layers. An image may hide as much light as it shows; of a scene's
/// hidden layers, which are drawn near edges alone, room for as many would be four times the memory.
fn most_emitters(adaptive: &AdaptiveUniform, margin_tiles: u32) -> u64 {
    let [columns, rows] = adaptive.tiles;
    // Cells, `side` tiles wide, of the frame and so many tiles around it.
    let cells = |around: u32, side: u32| {
        let [x, y] = [columns, rows].map(|n| u64::from((n + 2 * around.min(margin_tiles)).div_ceil(side) + 1));
        x * y
    };
    // A pixel in the frame may be an emitter of its own.
    let inside = u64::from(TILE_PX * TILE_PX) * u64::from(columns) * u64::from(rows);
    // Beyond it lies what reaches into it. Blur of less than 4 px: cells of 1 px up to 3 px away, or
    // fewer and larger ones; of less than 8 px: four cells of 4 px a tile; of less than 64 px: one of
    // a tile; of less than 128 px one of 2x2 tiles; else one of 4x4.
    let next_to = 24 * (2 * u64::from(columns + rows) + 4);
    let beyond = next_to + 4 * cells(2, 1) + cells(9, 1) + cells(17, 2) + cells(u32::MAX / 2, 4);
    let layers = if adaptive.is_image == 0 { 1 } else { u64::from(adaptive.layers) };
    layers * (inside + beyond)
}

/// Radius of a blur, px, from which cells are larger than a tile: `LARGE_LEVEL` in the shader.
const LARGE_FROM_PX: f32 = 64.0;

/// Side, px, of the blocks that such cells are made of.
const LARGE_BLOCK_PX: u32 = 4;

/// Workgroups that count and list emitters, `LISTING` in the shader: they share out all emitters.
const LISTING: u32 = 1024;

/// Bytes of `Emitter` in `shaders/lib/emitters.wgsl`.
const EMITTER_BYTES: u64 = 48;

/// Emitter counts of all tiles, none.
pub(super) fn counts(gpu: &Gpu, adaptive: &AdaptiveUniform) -> Buffer {
    let [columns, rows] = adaptive.inner_tiles.map(u64::from);
    gpu.buffer("emitter counts", 4 * (1 + columns * rows))
}

/// The table of an aperture on the GPU.
struct ApertureTable(Texture);

/// The summed intensity over the aperture at the corners of the table's cells (Crow, "Summed-area
/// tables for texture mapping", 1984), uploaded. A texture of its own, not a pooled one: it is
/// kept, and written before the frame's passes run.
fn aperture_table(gpu: &Gpu, aperture: &Aperture) -> Texture {
    let corners = TABLE_SIDE + 1;
    let size = wgpu::Extent3d { width: corners, height: corners, depth_or_array_layers: 1 };
    let texture = Texture::external(gpu.device().create_texture(&wgpu::TextureDescriptor {
        label: Some("aperture"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::R32Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    }));
    let sums = summed(&shares(aperture));
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(corners * 4), rows_per_image: None };
    gpu.queue().write_texture(texture.raw().as_image_copy(), bytemuck::cast_slice(&sums), layout, size);
    texture
}

/// For each corner of the table's cells the sum of the cells before it in both directions.
fn summed(shares: &[f64]) -> Vec<f32> {
    let (side, corners) = (TABLE_SIDE as usize, TABLE_SIDE as usize + 1);
    let mut sums = vec![0.0; corners * corners];
    for y in 0..side {
        let mut row = 0.0;
        for x in 0..side {
            row += shares[y * side + x];
            sums[(y + 1) * corners + x + 1] = sums[y * corners + x + 1] + row;
        }
    }
    sums.into_iter().map(|sum| sum as f32).collect()
}

/// Share of the light in each cell of the table; their sum is 1.
fn shares(aperture: &Aperture) -> Vec<f64> {
    // Sub-cells on each side, for the edges.
    const FINER: u32 = 6;
    let step = 2.0 * aperture.radius() / f64::from(TABLE_SIDE * FINER);
    let at = |i: u32| (f64::from(i) + 0.5) * step - aperture.radius();
    let sum = |cell: u32| {
        let (x, y) = (FINER * (cell % TABLE_SIDE), FINER * (cell / TABLE_SIDE));
        let points = (0..FINER * FINER).map(|i| dvec2(at(x + i % FINER), at(y + i / FINER)));
        points.map(|v| aperture.intensity(v)).sum::<f64>()
    };
    let sums: Vec<f64> = (0..TABLE_SIDE * TABLE_SIDE).map(sum).collect();
    let total: f64 = sums.iter().sum();
    sums.into_iter().map(|sum| sum / total).collect()
}
