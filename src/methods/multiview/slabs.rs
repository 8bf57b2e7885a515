//! The scene cut into slabs: sections 4.1 and 4.2.

use crate::gpu::{Buffer, Frame, Shader, Texture, TextureKey};
use crate::methods::MethodError;
use crate::view::{Layer, LayerQuery, LayerSeparation, MAX_SLABS_AT_ONCE, SlabArrays, SlabShot, View};
use crate::{shader, uniform};
use glam::UVec2;
use std::sync::Arc;

/// The passes that make slabs, and those of their N-buffers.
pub(super) const SLAB_SHADER: Shader = shader!("methods/multiview_slabs");

/// Most slabs that a tracer takes: bits of its mask and entries of its uniform.
pub(super) const MAX_SLABS: u32 = 16;

/// Depths of a slab, both bounds included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlabRange {
    /// Greatest stored depth z = near / d.
    pub z_near: f32,
    /// Least stored depth; 0 reaches infinity, with the background.
    pub z_far: f32,
}

/// Cuts the depths in view, from `z_max` (nearest) to `z_min`, into `count` slabs of one
/// thickness, each widened by `overlap` thicknesses at either bound (section 4.2: 10 %).
/// The last one ends at infinity: what is farther than all that is seen may still hide.
///
/// c is affine in z, so slabs of one thickness in z are of one thickness in c for *every*
/// lens: refocusing moves none of them.
pub fn slab_ranges(z_max: f32, z_min: f32, count: u32, overlap: f32) -> Vec<SlabRange> {
    let thickness = (f64::from(z_max) - f64::from(z_min)) / f64::from(count);
    let extra = f64::from(overlap) * thickness;
    let bound = |i: u32| f64::from(z_max) - f64::from(i) * thickness;
    // The nearest surface, drawn once more, may differ by rounding.
    let nearest = (f64::from(z_max) * (1.0 + 1e-6)).min(1.0) as f32;
    let range = |i: u32| SlabRange {
        z_near: if i == 0 { nearest } else { (bound(i) + extra) as f32 },
        z_far: if i + 1 == count { 0.0 } else { (bound(i + 1) - extra).max(f64::MIN_POSITIVE) as f32 },
    };
    (0..count).map(range).collect()
}

/// Slabs on the GPU as arrays with a layer for each slab.
#[derive(Clone)]
pub(super) struct Slabs {
    key: SlabsKey,
    /// Ranges of the slabs that may hold something: those that are in the arrays.
    pub ranges: Arc<[SlabRange]>,
    /// RGBA16F: radiance towards the lens's centre times coverage, coverage; with mipmaps.
    pub color: Texture,
    /// What surfaces are made of, where rays shade by their lens points.
    pub surfaces: Option<Surfaces>,
    /// R32F: stored depth, -1 where there is nothing.
    pub depth: Texture,
    /// For each slab the bits of its greatest z plus 1 (0 if it is empty), and of its least.
    pub content: Buffer,
    /// Texels left of and above the image in the arrays.
    pub padding: UVec2,
}

/// Arrays in RGBA16F, times coverage, with mipmaps.
#[derive(Clone)]
pub(super) struct Surfaces {
    /// Base colour, roughness.
    pub base: Texture,
    /// Normal, metalness.
    pub normal: Texture,
}

/// What slabs are drawn from, beside the view.
#[derive(Clone, PartialEq)]
pub(super) struct SlabsKey {
    pub ranges: Vec<SlabRange>,
    /// Mipmap levels.
    pub levels: u32,
    /// Whether rays do the shading.
    pub surfaces: bool,
    /// Whether slabs of an image hold what nearer surfaces hide, and how far behind those.
    pub hidden: Option<LayerSeparation>,
    /// Whether each slab has a draw of its own, however many there are.
    pub one_by_one: bool,
}

/// Slabs up to which each has a draw of its own: together they take two draws.
const FEW_SLABS: usize = 2;

const EXPLAIN_SHADER: Shader = shader!("methods/multiview_explain");

/// Names of what is exposed.
pub(super) const DEPTH: &str = "slab depth";
const COLOR: &str = "slab colour";
pub(super) const EXPLAINED: &str = "slabs of each pixel";

uniform! {
    struct Explained {
        origin: [i32; 2],
        count: u32,
        _unused: u32,
    }
}

uniform! {
    struct Gather {
        z_near: f32,
        z_far: f32,
        slab: u32,
        stretched: u32,
        padding: [i32; 2],
    }
}

impl Slabs {
    /// The slabs of `view`, drawn unless the last ones are the same.
    pub fn of(frame: &mut Frame<'_>, view: &mut View, key: SlabsKey) -> Result<Self, MethodError> {
        if let Some(slabs) = view.kept::<Self>()
            && slabs.key == key
        {
            let slabs = slabs.clone();
            frame.skip("slabs unchanged");
            slabs.expose(frame, view);
            return Ok(slabs);
        }
        *view.kept::<Self>() = None;
        let slabs = Self::draw(frame, view, key)?;
        *view.kept() = Some(slabs.clone());
        slabs.expose(frame, view);
        Ok(slabs)
    }

    /// Debug images of the slabs, also of cached ones.
    fn expose(&self, frame: &mut Frame<'_>, view: &View) {
        frame.expose(DEPTH, &self.depth);
        frame.expose(COLOR, &self.color);
        if !frame.keeps_intermediates() {
            return;
        }
        let explained = frame.texture(EXPLAINED, view.size(), wgpu::TextureFormat::Rgba16Float);
        let origin = (self.padding + view.overscan_px()).as_ivec2().to_array();
        frame
            .pass(&EXPLAIN_SHADER, "explain")
            .uniform("slabs", &Explained { origin, count: self.ranges.len() as u32, _unused: 0 })
            .texture("slab_depth", &self.depth)
            .texture("explained", &explained)
            .dispatch(view.size());
        frame.expose(EXPLAINED, &explained);
    }

    fn draw(frame: &mut Frame<'_>, view: &mut View, key: SlabsKey) -> Result<Self, MethodError> {
        let holds = |r: &&SlabRange| view.may_hold(&LayerQuery { z_near: r.z_near, z_far: r.z_far, below: None });
        let ranges: Arc<[SlabRange]> = key.ranges.iter().filter(holds).copied().collect();
        for _ in ranges.len()..key.ranges.len() {
            frame.skip("slab without surfaces");
        }
        let image = view.projection().outer_size();
        let coarsest = 1u32 << (key.levels - 1);
        let size = UVec2::new(image.x.next_multiple_of(coarsest), image.y.next_multiple_of(coarsest));
        let padding = (size - image) / 2;
        let array = |levels, format| TextureKey { size, levels, layers: array_layers(&ranges), format };
        let gpu = frame.gpu();
        let colors = |label| gpu.texture_of(label, array(key.levels, wgpu::TextureFormat::Rgba16Float));
        let surfaces = || Surfaces { base: colors("slab base colour"), normal: colors("slab normal") };
        let slabs = Self {
            color: colors("slab colour"),
            surfaces: key.surfaces.then(surfaces),
            depth: gpu.texture_of("slab depth", array(1, wgpu::TextureFormat::R32Float)),
            content: gpu.buffer_of("slab content", &[[0, u32::MAX]; MAX_SLABS as usize]),
            key,
            ranges,
            padding,
        };
        // Fragments may not write to textures on every adapter that is reached by GL.
        let by_gl = frame.gpu().adapter().backend == "Gl";
        if view.is_scene() && slabs.ranges.len() > FEW_SLABS && !slabs.key.one_by_one && !by_gl {
            slabs.draw_together(frame, view)?;
        } else {
            for slab in 0..slabs.ranges.len() {
                slabs.draw_one(frame, view, slab)?;
            }
        }
        slabs.reduce(frame);
        Ok(slabs)
    }

    /// Draws all slabs in two draws, or in as many times two as their depths need buffers.
    fn draw_together(&self, frame: &mut Frame<'_>, view: &mut View) -> Result<(), MethodError> {
        let gpu = frame.gpu();
        let size = self.color.size();
        let bytes = 4 * u64::from(size.x) * u64::from(size.y);
        let most = (gpu.largest_binding_bytes() / bytes).clamp(1, MAX_SLABS_AT_ONCE as u64) as usize;
        let ranges: Vec<_> = self.ranges.iter().map(|range| [range.z_near, range.z_far]).collect();
        let padding = self.padding.as_ivec2().to_array();
        for (i, ranges) in ranges.chunks(most).enumerate() {
            let first = (i * most) as u32;
            let count = ranges.len() as u32;
            let shot = SlabShot { ranges, first, size, padding: self.padding };
            let found = gpu.buffer("slab depths", bytes * u64::from(count));
            view.draw_slab_depths(frame, &shot, &found)?;
            let gather = Gather { z_near: 0.0, z_far: 0.0, slab: first, stretched: 0, padding };
            frame
                .pass(&SLAB_SHADER, "gather_depths")
                .uniform("gather", &gather)
                .buffer("found", &found)
                .level("slab_color", &self.color, 0)
                .texture("slab_depth", &self.depth)
                .buffer("content", &self.content)
                .dispatch_layers(size, count);
            if let Some(arrays) = &self.surfaces {
                frame
                    .pass(&SLAB_SHADER, "empty_surfaces")
                    .uniform("gather", &gather)
                    .level("slab_base", &arrays.base, 0)
                    .level("slab_normal", &arrays.normal, 0)
                    .dispatch_layers(size, count);
            }
            let surfaces = self.surfaces.as_ref().map(|arrays| [&arrays.base, &arrays.normal]);
            let arrays = SlabArrays { color: &self.color, surfaces };
            view.draw_slab_surfaces(frame, &shot, &self.depth, &arrays)?;
        }
        Ok(())
    }

    fn draw_one(&self, frame: &mut Frame<'_>, view: &mut View, slab: usize) -> Result<(), MethodError> {
        let SlabRange { z_near, z_far } = self.ranges[slab];
        let label = format!("slab {slab}");
        let query = LayerQuery { z_near, z_far, below: None };
        let padding = self.padding.as_ivec2().to_array();
        // Rays go on beyond the border of an image whose hidden surfaces are guessed.
        let stretched = self.key.hidden.is_some().into();
        let gather = Gather { z_near, z_far, slab: slab as u32, stretched, padding };
        let layer = match &self.surfaces {
            // The one layer of an image is cut up.
            _ if !view.is_scene() => view.pinhole(frame),
            None => view.layer(frame, &label, query)?,
            Some(arrays) => {
                let layer = view.surface_layer(frame, &label, query)?;
                frame
                    .pass(&SLAB_SHADER, "gather_surfaces")
                    .label(format_args!("gather surfaces {slab}"))
                    .uniform("gather", &gather)
                    .texture("base_roughness", &layer.base_roughness)
                    .texture("normal_metallic", &layer.normal_metallic)
                    .level("slab_base", &arrays.base, 0)
                    .level("slab_normal", &arrays.normal, 0)
                    .dispatch(arrays.base.size());
                Layer { color: layer.color, depth: layer.depth }
            }
        };
        frame.expose(label, &layer.color);
        frame
            .pass(&SLAB_SHADER, "gather_slab")
            .label(format_args!("gather slab {slab}"))
            .uniform("gather", &gather)
            .texture("color", &layer.color)
            .texture("depth", &layer.depth)
            .level("slab_color", &self.color, 0)
            .texture("slab_depth", &self.depth)
            .buffer("content", &self.content)
            .dispatch(self.color.size());
        if let Some(separation) = self.key.hidden {
            let hidden = view.hidden(frame, &layer.depth, separation)?;
            frame
                .pass(&SLAB_SHADER, "gather_hidden")
                .label(format_args!("gather hidden {slab}"))
                .uniform("gather", &gather)
                .texture("color", &hidden.color)
                .texture("depth", &hidden.depth)
                .texture("visible_depth", &layer.depth)
                .level("slab_color", &self.color, 0)
                .texture("slab_depth", &self.depth)
                .buffer("content", &self.content)
                .dispatch(self.color.size());
        }
        Ok(())
    }

    fn reduce(&self, frame: &mut Frame<'_>) {
        let surfaces = self.surfaces.iter().flat_map(|s| [&s.base, &s.normal]);
        for array in [&self.color].into_iter().chain(surfaces) {
            for level in 1..array.levels() {
                let size = array.level_size(level);
                frame
                    .pass(&SLAB_SHADER, "reduce_slabs")
                    .label(format_args!("reduce slabs {level}"))
                    .level("finer", array, level - 1)
                    .level("coarser", array, level)
                    .dispatch_groups(size.x.div_ceil(8), size.y.div_ceil(8), self.ranges.len() as u32);
            }
        }
    }
}

/// Layers of an array for these slabs: a texture of one layer would be no array.
fn array_layers(ranges: &[SlabRange]) -> u32 {
    (ranges.len() as u32).max(2)
}
