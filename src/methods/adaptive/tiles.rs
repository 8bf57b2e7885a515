//! Tiles of 8x8 pixels and the CoC radii that lens rays from them can meet.
//!
//! A neighbouring tile's bin counts only if its blur reaches here; bins behind all that
//! the pinhole sees within reach are dropped; what is left makes the tile's class.

use super::super::sheet_rays::SheetRays;
pub use super::super::tile_lists::TILE_PX;
use super::super::tile_lists::{SKIPPED, TileLists};
use super::AdaptiveUniform;
use super::highlights::{self, Highlights};
use crate::gpu::{Buffer, Frame, Shader, Switches, Texture};
use crate::lens::Lens;
use crate::shader;
use crate::view::{Peeled, View};
use glam::{DVec2, UVec2};

const SHADER: Shader = shader!("methods/adaptive_tiles");

/// Bins of s: `BINS` in `shaders/lib/layers.wgsl`.
pub const BINS: u32 = 64;

/// CoC radius, px, below which a tile counts as in focus: `COPY_S` in the shader. A disc
/// of that radius has a standard deviation of half of it on each axis.
pub const COPY_RADIUS_PX: f64 = 0.05;

/// Greatest CoC radius, px, that rays are traced for; what is blurred more is blurred as
/// much as this. Beyond it the search for neighbours costs more than the picture shows.
pub const MAX_RADIUS_PX: f64 = 160.0;

/// What a tile's rays can meet: `Tile` in `shaders/lib/layers.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Tile {
    /// Occupied bins, bit i for bin i: 0 to 31, then 32 to 63.
    pub bins: [u32; 2],
    /// Of marked tiles, the farthest bin of the first layer; of the second layer; and of the
    /// second where the first lies in front of its farthest bin in the tile.
    pub farthest: [u32; 3],
    /// 0 copy, 1 uniform, 2 complex.
    pub class: u32,
    /// Emitters whose blur may cover the tile.
    pub emitters: u32,
    /// Greatest difference of s, px, between neighbouring texels of the first layer.
    pub step_s: f32,
    /// Not 0 where the first layer may hold light that is kept apart, here or in a tile beside.
    pub lit: u32,
}

/// Tiles of a view through a lens, still on the GPU.
pub struct Tiles {
    /// s of up to four layers in an RGBA16F texture of the outer size; 60000 for none.
    pub radii: Texture,
    /// [`Tile`]s of the outer frame: what lies in them.
    pub marked: Buffer,
    /// [`Tile`]s of the inner frame: what their rays can meet.
    pub dilated: Buffer,
    /// By inner tile, u32: the buckets that its rays hit, a bit each. Tracing writes those of tiles out of
    /// focus.
    pub buckets: Buffer,
    /// Inner tiles by class.
    pub lists: TileLists,
    /// Class / 2 of each inner tile, as a debug image.
    pub classes: Texture,
    /// Where there is light far brighter than white.
    pub(super) highlights: Option<Highlights>,
}

/// The bins and tiles of a view through a lens.
#[derive(Clone, Copy, Debug)]
pub struct TileGrid {
    /// Least and greatest signed CoC radius, px.
    pub radii_px: [f64; 2],
    /// Tiles of the outer frame.
    pub tiles: UVec2,
    /// Tiles of the inner frame.
    pub inner_tiles: UVec2,
    /// Outer tile of the inner frame's first pixel, in both directions.
    pub first_tile: u32,
    /// Tiles on every side whose blur may reach a tile.
    pub reach: u32,
}

impl TileGrid {
    /// For signed CoC diameters between `near_px` and `far_px`.
    pub fn new(view: &View, lens: &Lens, near_px: f64, far_px: f64) -> Self {
        let radii_px = [near_px, far_px].map(|c| (0.5 * c).clamp(-MAX_RADIUS_PX, MAX_RADIUS_PX));
        let inner_tiles = view.size().map(|side| side.div_ceil(TILE_PX));
        let first_tile = view.overscan_px().div_ceil(TILE_PX);
        let more_px = 0.5 * lens.greatest_astigmatism_px();
        let greatest_px = (radii_px[0].abs().max(radii_px[1].abs()) + more_px) * lens.aperture.radius();
        let reach = ((greatest_px + 1.0) / f64::from(TILE_PX)).ceil() as u32 + 1;
        Self { radii_px, tiles: inner_tiles + 2 * first_tile, inner_tiles, first_tile, reach }
    }

    /// t = sign(s) sqrt(|s|) of the first bin's near edge, and the width of a bin in t.
    pub fn bins(&self) -> DVec2 {
        let [near, far] = self.radii_px.map(|s| s.signum() * s.abs().sqrt());
        // All surfaces at one CoC still need bins of some width.
        DVec2::new(near, ((far - near) / f64::from(BINS)).max(1e-4))
    }
}

/// Records the passes that find the tiles of `peeled`.
pub(super) fn build(
    frame: &mut Frame<'_>,
    view: &mut View,
    lens: &Lens,
    peeled: &Peeled,
    adaptive: &AdaptiveUniform,
    sheets: &SheetRays,
) -> Tiles {
    let gpu = frame.gpu();
    let count = |tiles: [u32; 2]| u64::from(tiles[0]) * u64::from(tiles[1]);
    let bytes = |tiles| count(tiles) * size_of::<Tile>() as u64;
    let (outer, inner) = (UVec2::from(adaptive.tiles), UVec2::from(adaptive.inner_tiles));
    let rows = gpu.buffer("dilated rows", bytes(adaptive.tiles));
    let radii = frame.texture("CoC radii", peeled.depth.size(), wgpu::TextureFormat::Rgba16Float);
    let marked = gpu.buffer("marked tiles", bytes(adaptive.tiles));
    let light_tiles = match &peeled.lights {
        Some(lights) => lights.tiles.clone(),
        None => gpu.buffer("no tiles with lights", 4),
    };
    frame
        .specialized_pass(&SHADER, "mark_tiles", Switches::default().with_uninitialized_memory())
        .uniform("adaptive", adaptive)
        .texture("depth", &peeled.depth)
        .texture("radii", &radii)
        .buffer("needed", &peeled.hidden_needed)
        .buffer("light_tiles", &light_tiles)
        .buffer("marked", &marked)
        .dispatch_groups(outer.x, outer.y, 1);
    let highlights = peeled.lights.as_ref().map(|lights| Highlights::find(frame, lens, lights, peeled, adaptive));
    let emitter_counts = match &highlights {
        Some(highlights) => highlights.counts.clone(),
        None => highlights::counts(gpu, adaptive),
    };
    let tiles = Tiles {
        radii,
        marked,
        dilated: gpu.buffer("dilated tiles", bytes(adaptive.inner_tiles)),
        buckets: gpu.scratch("buckets of tiles", 4 * count(adaptive.inner_tiles)),
        lists: TileLists::new(gpu, view.size()),
        classes: frame.texture("tile class", inner, wgpu::TextureFormat::Rgba16Float),
        highlights,
    };
    frame
        .pass(&SHADER, "dilate_rows")
        .uniform("adaptive", adaptive)
        .buffer("marked", &tiles.marked)
        .buffer("rows", &rows)
        .dispatch(outer);
    tiles
        .lists
        .filled_by(frame.pass(&SHADER, "classify_tiles"))
        .uniform("adaptive", adaptive)
        .buffer("marked", &tiles.marked)
        .buffer("rows", &rows)
        .buffer("emitter_counts", &emitter_counts)
        .buffer("sheet_bounds", &sheets.bounds)
        .buffer("dilated", &tiles.dilated)
        .buffer("tile_buckets", &tiles.buckets)
        .texture("classes", &tiles.classes)
        .dispatch(inner);
    tiles.lists.plan(frame);
    frame.expose(SKIPPED, &tiles.classes);
    tiles
}
