//! The passes of `mipmap`.

use super::super::tile_lists::SKIPPED;
use super::grid::PyramidGrid;
use super::params::{Mipmap, Params};
use crate::gpu::{Frame, SamplerKind, Shader, Texture, TextureKey};
use crate::lens::Lens;
use crate::view::{Layer, LensUniform, View};
use crate::{shader, uniform};
use glam::UVec2;

const PRINTED: Shader = shader!("methods/mipmap");
const LEVELS: Shader = shader!("methods/mipmap_levels");
const READ: Shader = shader!("methods/mipmap_read");

/// Names of what is exposed.
pub(super) const COLOR_PYRAMID: &str = "colour pyramid";
pub(super) const BLUR_PYRAMID: &str = "CoC, DoB, DoN";
pub(super) const PYRAMID: &str = "pyramid: behind, before, all, CoC";
pub(super) const EXPLAINED: &str = "blur and level of each pixel";

/// Classes of tiles: constants in `shaders/methods/mipmap_read.wgsl`.
pub(super) const TILE_CLASSES: [(f32, &str); 3] =
    [(0.0, "in focus: copied"), (1.0, "image and levels"), (2.0, "levels alone: image skipped")];

/// Side of a tile, px: `SIDE` there, and of the workgroups everywhere.
const TILE_PX: u32 = 8;

/// Workgroups along x at most: `MAX_GROUPS` in `shaders/lib/mipmap_atlas.wgsl`.
const MAX_GROUPS: u32 = 65535;

/// Levels up to the one whose texels are four images wide: coarser ones hold nothing but
/// the stretched border, and would make a small image's pyramid vast.
fn levels_with_content(image: UVec2) -> u32 {
    image.max_element().next_power_of_two().ilog2() + 2
}

/// What both ways work on.
struct Input {
    pinhole: Layer,
    grid: PyramidGrid,
    lens: LensUniform,
    params: Params,
    size: UVec2,
}

impl Input {
    fn of(method: &Mipmap, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Self {
        let pinhole = view.pinhole(frame);
        let bounds_px = view.coc_bounds_px(frame, lens);
        let levels = method.levels(lens, bounds_px[0].abs().max(bounds_px[1].abs()));
        let grid = PyramidGrid::new(pinhole.color.size(), levels.min(levels_with_content(pinhole.color.size())));
        if method.smoothing && bounds_px[0] >= 0.0 {
            frame.skip("no foreground: no smoothing");
        }
        let params = method.uniform(view, lens, &grid, bounds_px);
        Self { pinhole, grid, lens: view.lens_uniform(lens), params, size: view.size() }
    }
}

// ---- by discs ----

uniform! {
    struct Reduction {
        level: u32,
    }
}

/// Levels filtered by discs in which each pixel has a part by its own blur; what is in front
/// of the focus distance spread by its own.
pub(super) fn by_discs(method: &Mipmap, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Texture {
    let input = Input::of(method, frame, view, lens);
    let pyramid = reduce(frame, &input);
    frame.expose(PYRAMID, &pyramid);
    let atlas = filter(frame, &input, &pyramid);
    let result = frame.color_texture("mipmap", input.size);
    input.read(frame, "blur", &atlas).texture("result", &result).dispatch(input.size);
    if frame.keeps_intermediates() {
        let explained = frame.texture(EXPLAINED, input.size, wgpu::TextureFormat::Rgba16Float);
        let tiles = input.size.map(|side| side.div_ceil(TILE_PX));
        let classes = frame.texture(SKIPPED, tiles, wgpu::TextureFormat::R32Float);
        input
            .read(frame, "explain", &atlas)
            .texture("explained", &explained)
            .texture("tile_classes", &classes)
            .dispatch(input.size);
        frame.expose(EXPLAINED, &explained);
        frame.expose(SKIPPED, &classes);
    }
    result
}

/// The pyramid's levels, two at a time after the second: a workgroup that makes two reads half as
/// much again, which on levels of few texels is less than another dispatch takes to start.
fn reduce(frame: &mut Frame<'_>, input: &Input) -> Texture {
    let grid = &input.grid;
    let pyramid = frame.gpu().texture_of("pyramid", grid.key(4, frame.precision.format()));
    frame
        .pass(&LEVELS, "reduce_image")
        .uniform("lens", &input.lens)
        .uniform("params", &input.params)
        .texture("color", &input.pinhole.color)
        .texture("depth", &input.pinhole.depth)
        .level("coarser", &pyramid, 0)
        .dispatch(grid.size);
    let mut level = 1;
    while level < grid.levels {
        let two = level > 1 && level + 1 < grid.levels;
        let entry = if two { "reduce_levels" } else { "reduce_level" };
        let pass = frame
            .pass(&LEVELS, entry)
            .label(format!("{entry} {level}"))
            .uniform("params", &input.params)
            .uniform("reduction", &Reduction { level: level + 1 })
            .sampler("linear_clamp", SamplerKind::Linear)
            .level("finer", &pyramid, level - 1)
            .level("coarser", &pyramid, level);
        let pass = if two { pass.level("coarsest", &pyramid, level + 1) } else { pass };
        pass.dispatch(grid.level_size(level));
        level += 1 + u32::from(two);
    }
    pyramid
}

/// All levels through their discs, in one image.
fn filter(frame: &mut Frame<'_>, input: &Input, pyramid: &Texture) -> Texture {
    let grid = &input.grid;
    // Level 1 at the left, the others in a column half as wide.
    let size = UVec2::new(grid.size.x + grid.size.x.div_ceil(2), grid.size.y);
    let key = TextureKey { size, levels: 1, layers: 4, format: frame.precision.format() };
    let atlas = frame.gpu().texture_of("filtered levels", key);
    let groups_of = |level| grid.level_size(level).map(|side| side.div_ceil(TILE_PX)).element_product();
    let groups: u32 = (0..grid.levels).map(groups_of).sum();
    frame
        .pass(&LEVELS, "filter_levels")
        .uniform("params", &input.params)
        .texture("pyramid", pyramid)
        .texture("atlas", &atlas)
        .dispatch_groups(groups.min(MAX_GROUPS), groups.div_ceil(MAX_GROUPS), 1);
    atlas
}

impl Input {
    fn read<'f, 'g>(&self, frame: &'f mut Frame<'g>, entry: &'static str, atlas: &Texture) -> crate::gpu::Pass<'f, 'g> {
        frame
            .pass(&READ, entry)
            .uniform("lens", &self.lens)
            .uniform("params", &self.params)
            .texture("color", &self.pinhole.color)
            .texture("depth", &self.pinhole.depth)
            .texture("atlas", atlas)
            .sampler("linear_clamp", SamplerKind::Linear)
    }
}

// ---- as printed ----

/// The paper's steps.
pub(super) fn as_printed(method: &Mipmap, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Texture {
    let input = Input::of(method, frame, view, lens);
    let gpu = frame.gpu();
    let color = gpu.texture_of("colour pyramid", input.grid.key(1, frame.precision.format()));
    let blur = gpu.texture_of("blur pyramid", input.grid.key(1, wgpu::TextureFormat::Rgba16Float));
    for level in 0..input.grid.levels {
        let pass = if level == 0 {
            frame
                .pass(&PRINTED, "reduce_image")
                .uniform("lens", &input.lens)
                .texture("color", &input.pinhole.color)
                .texture("depth", &input.pinhole.depth)
        } else {
            frame
                .pass(&PRINTED, "reduce_level")
                .label(format!("reduce_level {level}"))
                .level("finer_color", &color, level - 1)
                .level("finer_blur", &blur, level - 1)
        };
        pass.uniform("params", &input.params)
            .level("coarser_color", &color, level)
            .level("coarser_blur", &blur, level)
            .dispatch(input.grid.level_size(level));
    }
    frame.expose(COLOR_PYRAMID, &color);
    frame.expose(BLUR_PYRAMID, &blur);
    let result = frame.color_texture("mipmap", input.size);
    frame
        .pass(&PRINTED, "blur")
        .uniform("lens", &input.lens)
        .uniform("params", &input.params)
        .texture("color", &input.pinhole.color)
        .texture("depth", &input.pinhole.depth)
        .texture("color_pyramid", &color)
        .texture("blur_pyramid", &blur)
        .sampler("linear_clamp", SamplerKind::Linear)
        .texture("result", &result)
        .dispatch(input.size);
    if frame.keeps_intermediates() {
        let explained = frame.texture(EXPLAINED, input.size, wgpu::TextureFormat::Rgba16Float);
        frame
            .pass(&PRINTED, "explain")
            .uniform("lens", &input.lens)
            .uniform("params", &input.params)
            .texture("depth", &input.pinhole.depth)
            .texture("blur_pyramid", &blur)
            .sampler("linear_clamp", SamplerKind::Linear)
            .texture("explained", &explained)
            .dispatch(input.size);
        frame.expose(EXPLAINED, &explained);
    }
    result
}
