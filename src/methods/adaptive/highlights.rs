//! Highlights: texels far brighter than white, brought to the pixels that their blur
//! covers one by one instead of by chance.

use super::AdaptiveUniform;
use super::tiles::TILE_PX;
use crate::aperture::Aperture;
use crate::gpu::{Buffer, Frame, Gpu, Shader, Texture};
use crate::view::{Lights, Peeled};
use crate::{shader, uniform};
use glam::{UVec2, dvec2};
use half::f16;

const SHADER: Shader = shader!("methods/adaptive_highlights");

/// Emitters that a tile can list. Cells are an eighth to a quarter of the blur's radius
/// wide, and those reach a tile of 8 px that lie in the 24 cells of 1 px on each side around
/// it, or in fewer larger ones: one surface that is bright everywhere has no more.
const CAPACITY: u32 = 24 * 24;

/// Side of the aperture's table: a texel is 1/32 of the lens's radius.
const TABLE_SIDE: u32 = 128;

/// Mipmap levels of the table, down to 4x4 texels of a lens radius each.
const TABLE_LEVELS: u32 = 6;

uniform! {
    pub(super) struct HighlightsUniform {
        capacity: u32,
        sample_px: f32,
        is_disc: u32,
        margin_tiles: u32,
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
    /// Density of lens points over the square of v from -2 to 2 lens radii.
    pub aperture: Texture,
}

impl Highlights {
    /// Records the passes that find the emitters of all layers and list them by tile.
    pub fn find(
        frame: &mut Frame<'_>,
        aperture: &Aperture,
        lights: &Lights,
        peeled: &Peeled,
        adaptive: &AdaptiveUniform,
    ) -> Self {
        let gpu = frame.gpu();
        let [columns, rows] = adaptive.inner_tiles.map(u64::from);
        // What blurs into the inner frame lies within reach of it, in the outer frame or beyond.
        let margin_tiles = adaptive.reach.saturating_sub(adaptive.first_tile);
        let searched_tiles = UVec2::from(adaptive.tiles) + 2 * margin_tiles;
        // A pixel in the frame may be an emitter of its own; beyond it a tile has one of 8 px and
        // four of 4 px at most. An image may hide as much light as it shows; of a scene's hidden
        // layers, which are drawn near edges alone, room for as many would be four times the memory.
        let layers = if adaptive.is_image == 0 { 1 } else { u64::from(adaptive.layers) };
        let outer = u64::from(adaptive.tiles[0]) * u64::from(adaptive.tiles[1]);
        let stretched = u64::from(searched_tiles.x) * u64::from(searched_tiles.y) - outer;
        let most_emitters = layers * (u64::from(TILE_PX * TILE_PX) * outer + 5 * stretched);
        let searched = searched_tiles * TILE_PX;
        let found = Self {
            uniform: HighlightsUniform {
                capacity: CAPACITY,
                sample_px: lights.sample_px,
                is_disc: (*aperture == Aperture::Disc).into(),
                margin_tiles,
            },
            counts: counts(gpu, adaptive),
            listed_counts: counts(gpu, adaptive),
            lists: gpu.scratch("emitter lists", 4 * u64::from(CAPACITY) * columns * rows),
            emitters: gpu.scratch("emitters", EMITTER_BYTES * most_emitters),
            aperture: gpu.memo().get(aperture, || AperturePicture(aperture_table(gpu, aperture))).0.clone(),
        };
        frame
            .pass(&SHADER, "find_emitters")
            .uniform("adaptive", adaptive)
            .uniform("highlights", &found.uniform)
            .buffer("lights", &lights.buffer)
            .texture("colors", &peeled.color)
            .texture("depth", &peeled.depth)
            .buffer("emitter_counts", &found.counts)
            .buffer("emitters", &found.emitters)
            .dispatch(searched);
        frame
            .pass(&SHADER, "list_emitters")
            .uniform("adaptive", adaptive)
            .uniform("highlights", &found.uniform)
            .buffer("emitter_counts", &found.counts)
            .buffer("listed_counts", &found.listed_counts)
            .buffer("emitter_lists", &found.lists)
            .buffer("emitters", &found.emitters)
            .dispatch_groups(LISTING / 64, 1, 1);
        found
    }
}

/// Invocations that list emitters, `LISTING` in the shader: they share out all emitters.
const LISTING: u32 = 4096;

/// Bytes of `Emitter` in `shaders/lib/emitters.wgsl`.
const EMITTER_BYTES: u64 = 48;

/// Emitter counts of all tiles, none.
pub(super) fn counts(gpu: &Gpu, adaptive: &AdaptiveUniform) -> Buffer {
    let [columns, rows] = adaptive.inner_tiles.map(u64::from);
    gpu.buffer("emitter counts", 4 * (1 + columns * rows))
}

/// The table of an aperture on the GPU.
struct AperturePicture(Texture);

/// The intensity over the aperture with mipmaps, uploaded. A texture of its own, not a
/// pooled one: it is kept, and written before the frame's passes run.
fn aperture_table(gpu: &Gpu, aperture: &Aperture) -> Texture {
    let texture = Texture::external(gpu.device().create_texture(&wgpu::TextureDescriptor {
        label: Some("aperture"),
        size: wgpu::Extent3d { width: TABLE_SIDE, height: TABLE_SIDE, depth_or_array_layers: 1 },
        mip_level_count: TABLE_LEVELS,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    }));
    let mut densities = densities(aperture);
    let mut side = TABLE_SIDE;
    for mip_level in 0..TABLE_LEVELS {
        let texels: Vec<[f16; 4]> = densities.iter().map(|d| [f16::from_f32(*d); 4]).collect();
        let target = wgpu::TexelCopyTextureInfo { mip_level, ..texture.raw().as_image_copy() };
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(side * 8), rows_per_image: None };
        let extent = wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 };
        gpu.queue().write_texture(target, bytemuck::cast_slice(&texels), layout, extent);
        side /= 2;
        let finer = |x: u32, y: u32| densities[(y * 2 * side + x) as usize];
        let coarser = |i: u32| {
            let (x, y) = (2 * (i % side), 2 * (i / side));
            0.25 * (finer(x, y) + finer(x + 1, y) + finer(x, y + 1) + finer(x + 1, y + 1))
        };
        densities = (0..side * side).map(coarser).collect();
    }
    texture
}

/// Mean density in each texel of the table, whose sum is exactly that of the aperture.
fn densities(aperture: &Aperture) -> Vec<f32> {
    // Sub-texels on each side, for the edges.
    const FINER: u32 = 3;
    let step = 4.0 * aperture.radius() / f64::from(TABLE_SIDE * FINER);
    let at = |i: u32| (f64::from(i) + 0.5) * step - 2.0 * aperture.radius();
    let mean = |texel: u32| {
        let (x, y) = (FINER * (texel % TABLE_SIDE), FINER * (texel / TABLE_SIDE));
        let points = (0..FINER * FINER).map(|i| dvec2(at(x + i % FINER), at(y + i / FINER)));
        points.map(|v| aperture.intensity(v)).sum::<f64>() / f64::from(FINER * FINER)
    };
    let densities: Vec<f64> = (0..TABLE_SIDE * TABLE_SIDE).map(mean).collect();
    let integral = densities.iter().sum::<f64>() * (step * f64::from(FINER)).powi(2);
    densities.iter().map(|d| (d / integral) as f32).collect()
}
