//! Layers of surfaces, peeled front to back as the pinhole sees them.

use super::samples::{Lights, MAX_DRAWS, Sampled, Samples, TILE_PX};
use super::{Layer, LayerQuery, LensUniform, View, ViewError, hidden, nearest};
use crate::gpu::{Buffer, Frame, Texture, TextureKey};
use crate::lens::Lens;
use crate::{shader, uniform};
use glam::UVec2;

const SHADER: crate::gpu::Shader = shader!("peel");

/// Mipmap levels of [`Peeled::color`]: level 4 has texels of 16 px.
pub const PEELED_LEVELS: u32 = 5;

/// Surfaces behind one another, nearest first, as texture arrays.
#[derive(Clone, Debug)]
pub struct Peeled {
    /// RGBA16F array: linear radiance, of the first layer the mean over its samples with
    /// [`PEELED_LEVELS`] box-filtered levels. The size is the outer one in fine texels,
    /// padded to whole texels of the coarsest level.
    pub color: Texture,
    /// R32F array of the outer size in fine texels: stored depth z = near / d, -1 where a layer is empty.
    pub depth: Texture,
    /// Number of layers; the arrays may have more.
    pub layers: u32,
    /// By tile of 8x8 px of the outer frame, u32, row by row: not 0 where hidden layers may be seen. They
    /// are empty elsewhere.
    pub hidden_needed: Buffer,
    /// Fine texels a pixel on each side. Texel `fineness * i` is the sample at the centre
    /// of pixel i.
    pub fineness: u32,
    /// The samples of the first layer; of a size that is a multiple of the outer one. Texel
    /// `samples_a_side * i` is pixel i of the pinhole image.
    pub samples: Layer,
    /// Samples a pixel on each side.
    pub samples_a_side: u32,
    /// R32F array of the outer size in pixels: the greatest stored depth of the samples within
    /// [`NEAREST_REACH_PX`](super::NEAREST_REACH_PX) pixels along x and y.
    pub nearest: Texture,
    /// Whether each sample of a pixel has a column and a row of its own (`shaders/lib/staggered.wgsl`);
    /// else they lie in a regular grid.
    pub staggered: bool,
    /// What is far brighter than white in the first layer; left out of its mean.
    pub lights: Option<Lights>,
    order: PeelOrder,
}

/// What layers are wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeelOrder {
    /// Greatest number of layers.
    pub count: u32,
    /// Texels a pixel on each side.
    pub fineness: u32,
    /// Samples of the first layer a texel on each axis, 1 to
    /// [`MAX_DRAWS`].
    pub draws: u32,
    /// How far a layer lies behind the one before it at least.
    pub separation: LayerSeparation,
    /// Whether what is far brighter than white is kept apart, as [`Peeled::lights`].
    pub lights: bool,
}

/// Distance of surfaces, in stored depth, from which on they are layers of their own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerSeparation {
    /// At any depth.
    pub z: f32,
    /// In front of this depth hidden surfaces lie farther apart, by a twentieth (`WIDENING` in
    /// `shaders/peel.wgsl`) of what they lie in front of it: mouldings of a blurred column are
    /// not told apart, and what is behind the column gets the layers.
    pub widening_from_z: f32,
}

impl LayerSeparation {
    /// More than half and at most one pixel of CoC radius, and of near hidden surfaces a
    /// twentieth of theirs. Powers of two, so that a lens slider draws layers anew only when it has
    /// doubled or halved the blur or the focus distance.
    pub fn of(lens: &LensUniform) -> Self {
        // Focused beyond infinity, everything is in front of the focus.
        let widening_from_z = lens.focus_z.max(0.0).log2().ceil().exp2();
        Self { z: (2.0 / lens.slope_px).log2().floor().exp2(), widening_from_z }
    }
}

uniform! {
    struct PeelParams {
        separation_z: f32,
        widening_from_z: f32,
        nearest: u32,
        tile: u32,
        tiles_x: u32,
        tiles_y: u32,
        radius_per_z: f32,
        edge: f32,
    }
}

/// CoC radius, px, that a neighbour may reach behind an edge without any hidden surface
/// showing: half a pixel is less than the tolerance of a hit and its texel.
pub const DISOCCLUSION_PX: f32 = 0.5;

impl PeelParams {
    fn new(outer: UVec2, fineness: u32, separation: LayerSeparation) -> Self {
        let tile = TILE_PX * fineness;
        let texels_per_px = fineness as f32;
        Self {
            separation_z: separation.z,
            widening_from_z: separation.widening_from_z,
            nearest: 1,
            tile,
            tiles_x: outer.x.div_ceil(tile),
            tiles_y: outer.y.div_ceil(tile),
            // c = k - slope z, and slope is at most 2 / separation: `LayerSeparation::of`.
            radius_per_z: texels_per_px / separation.z,
            edge: DISOCCLUSION_PX * texels_per_px,
        }
    }
}

uniform! {
    struct ReduceParams {
        finer_size: [u32; 2],
    }
}

impl View {
    /// How far layers lie apart for a lens: the same for all primaries of a chromatic eye, so that
    /// layers are drawn once for all of them.
    pub fn layer_separation(&self, lens: &Lens) -> LayerSeparation {
        LayerSeparation::of(&self.lens_uniform(&lens.of_all_primaries()))
    }

    /// The nearest layers; an image's have one texel a pixel, and what it hides is guessed
    /// (`view/hidden.rs`). Kept until the view or the order changes. Errors if the fine layers
    /// exceed the adapter's texture size.
    pub fn peeled(&mut self, frame: &mut Frame<'_>, order: &PeelOrder) -> Result<Peeled, ViewError> {
        let order = if self.is_scene() {
            let (count, fineness) = (order.count.max(1), order.fineness.max(1));
            // As many samples as an adapter's textures hold.
            let most = frame.gpu().device().limits().max_texture_dimension_2d;
            let fitting = most / (fineness * self.projection.outer_size().max_element());
            let draws = order.draws.min(fitting).clamp(1, MAX_DRAWS);
            match self.draft {
                true => PeelOrder { count, fineness: 1, draws: 1, ..*order },
                false => PeelOrder { count, fineness, draws, ..*order },
            }
        } else {
            PeelOrder { count: order.count.max(1), fineness: 1, draws: 1, ..*order }
        };
        if let Some(peeled) = self.peeled.as_ref().filter(|peeled| peeled.order == order) {
            frame.skip("layers unchanged");
            return Ok(peeled.clone());
        }
        let PeelOrder { count, fineness, draws, separation, lights: _ } = order;
        // Means over surfaces a pixel of s apart would blur the outline of one as much as the
        // other: half of that is what reads tell apart.
        let sampling = Samples { fineness, draws, same_z: 0.5 * separation.z, lights: order.lights };
        let outer = self.projection.outer_size() * fineness;
        let params = PeelParams::new(outer, fineness, separation);
        let padded = outer.map(|side| side.next_multiple_of(1 << (PEELED_LEVELS - 1)));
        let (half, float) = (wgpu::TextureFormat::Rgba16Float, wgpu::TextureFormat::R32Float);
        let gpu = frame.gpu();
        // A shader's array needs two layers to be one.
        let key = TextureKey { size: padded, levels: PEELED_LEVELS, layers: count.max(2), format: half };
        let color = gpu.texture_of("layer colours", key);
        let key = TextureKey { size: outer, levels: 1, layers: count.max(2), format: float };
        let depth = gpu.texture_of("layer depths", key);
        let Sampled { mean, depth: first_depth, samples, staggered, lights } = self.sampled(frame, &sampling)?;
        let mut nearer = Layer { color: mean, depth: first_depth };
        let needed = find_needed(frame, &nearer.depth, &params, count);
        for index in 0..count {
            let marked = frame.texture("marked depth", outer, float);
            let below = frame.texture("next layer's bound", outer, float);
            frame
                .pass(&SHADER, "mark_layer")
                .uniform("params", &PeelParams { nearest: (index == 0).into(), ..params })
                .texture("color", &nearer.color)
                .texture("depth", &nearer.depth)
                .texture("marked", &marked)
                .texture("below", &below)
                .buffer("needed", &needed)
                .dispatch(outer);
            copy_to_array_layer(frame, &nearer.color, &color, index);
            copy_to_array_layer(frame, &marked, &depth, index);
            if index + 1 < count {
                nearer = if self.is_scene() {
                    let surfaces = LayerQuery { below: Some(&below), ..LayerQuery::NEAREST };
                    self.fine_layer(frame, &format!("peel {}", index + 1), fineness, surfaces)?
                } else {
                    // With its lights: the mean of the first layer is without them.
                    let seen = if index == 0 { &samples } else { &nearer };
                    hidden::behind(frame, seen, &below, separation.z)
                };
            }
        }
        reduce(frame, &color, outer);
        if let Some(lights) = &lights {
            lights.mark_tiles(frame, &color, &depth, count, fineness);
        }
        let samples_a_side = fineness * draws;
        let nearest = nearest::nearest_depths(frame, &samples.depth, self.projection.outer_size(), samples_a_side);
        let peeled = Peeled {
            color,
            depth,
            layers: count,
            hidden_needed: needed,
            fineness,
            samples,
            samples_a_side,
            nearest,
            staggered,
            lights,
            order,
        };
        self.peeled = Some(peeled.clone());
        Ok(peeled)
    }
}

/// What the pinhole image of a view hides, guessed once.
struct KeptHidden {
    separation_z: f32,
    distances: Buffer,
}

impl View {
    /// What the pinhole image hides, where it lies behind `below`, R32F stored depth; none where that is
    /// -1. Of a scene the nearest surfaces there. Of an image what goes on from beside nearer
    /// surfaces, as far behind them as layers lie apart, guessed once for each image: where
    /// nothing is hidden its alpha is 0.
    pub fn hidden(
        &mut self,
        frame: &mut Frame<'_>,
        below: &Texture,
        separation: LayerSeparation,
    ) -> Result<Layer, ViewError> {
        if self.is_scene() {
            return self.layer(frame, "hidden", LayerQuery { below: Some(below), ..LayerQuery::NEAREST });
        }
        let separation_z = separation.z;
        let seen = self.pinhole(frame);
        let kept = self.kept::<KeptHidden>().take().filter(|kept| kept.separation_z == separation_z);
        let distances = match kept {
            Some(kept) => {
                frame.skip("hidden surfaces known");
                kept.distances
            }
            None => hidden::follow(frame, &seen, separation_z),
        };
        *self.kept() = Some(KeptHidden { separation_z, distances: distances.clone() });
        Ok(hidden::show(frame, &seen, &distances, below, separation_z))
    }
}

/// By tile, whether hidden layers may be seen there: a buffer of u32.
fn find_needed(frame: &mut Frame<'_>, depth: &Texture, params: &PeelParams, layers: u32) -> Buffer {
    let gpu = frame.gpu();
    let tiles = UVec2::new(params.tiles_x, params.tiles_y);
    let buffer = |label, bytes: u64| gpu.scratch(label, bytes * u64::from(tiles.x) * u64::from(tiles.y));
    if layers == 1 {
        return gpu.buffer("tiles with hidden layers", 4 * u64::from(tiles.x) * u64::from(tiles.y));
    }
    let needed = buffer("tiles with hidden layers", 4);
    let (edges, rows) = (buffer("edges", 8), buffer("edges along rows", 8));
    frame
        .pass(&SHADER, "find_edges")
        .uniform("params", params)
        .texture("depth", depth)
        .buffer("edges", &edges)
        .dispatch(tiles);
    frame
        .pass(&SHADER, "spread_edges")
        .uniform("params", params)
        .buffer("edges", &edges)
        .buffer("row_edges", &rows)
        .dispatch(tiles);
    frame
        .pass(&SHADER, "mark_needed")
        .uniform("params", params)
        .buffer("row_edges", &rows)
        .buffer("needed", &needed)
        .dispatch(tiles);
    needed
}

/// Copies level 0 of an image to an array layer of another of the same format.
pub(crate) fn copy_to_array_layer(frame: &mut Frame<'_>, from: &Texture, to: &Texture, layer: u32) {
    let size = wgpu::Extent3d { width: from.size().x, height: from.size().y, depth_or_array_layers: 1 };
    let mut target = to.raw().as_image_copy();
    target.origin.z = layer;
    frame.encoder().copy_texture_to_texture(from.raw().as_image_copy(), target, size);
}

/// Box-filters the first layer, level by level.
fn reduce(frame: &mut Frame<'_>, color: &Texture, outer: UVec2) {
    let mut finer_size = outer;
    for level in 1..color.levels() {
        let size = finer_size.map(|side| side.div_ceil(2));
        frame
            .pass(&SHADER, "reduce_layer")
            .uniform("reduction", &ReduceParams { finer_size: finer_size.to_array() })
            .level("finer", color, level - 1)
            .level("coarser", color, level)
            .dispatch(size);
        finer_size = size;
    }
}
