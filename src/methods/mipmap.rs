//! `mipmap`: anisotropically filtered mipmap interpolation.
//!
//! Lee, Kim and Choi, "Real-Time Depth-of-Field Rendering Using Anisotropically Filtered
//! Mipmap Interpolation" (TVCG 2009). Blur is read from a mipmap of the pinhole image at
//! a level that follows from the CoC:
//!
//! 1. a mipmap of depth (as CoC), DoB (degree of blur, sigma = C/2) and DoN (the DoB of
//!    nearer foreground neighbours), section 3.1 and equation (10);
//! 2. a mipmap of colour in which a blurred background refuses sharper texels, equation
//!    (9): no leakage;
//! 3. a level from a blur, equation (6) or the pyramid's measured second moment;
//! 4. the DoB smoothed over the edges of the foreground, equation (11);
//! 5. two levels blended through a circular filter, equation (8), or, by default, two discs
//!    of neighbouring diameters that levels were filtered by beforehand ([`MipmapFilter`]).
//!
//! **Which lens this is.** The paper names a Gaussian lens of sigma = C/2, but its level
//! formula blurs close to a *disc* of diameter C, whose standard deviation is C/4. Here
//! the level is set so that the second moment of what the pyramid really does equals the
//! lens's own ("measured"); the paper's constant is the other setting.

use super::tile_lists::{self, DEFOCUSED, FocusMap, IN_FOCUS, TILE_PX, TileLists};
use super::{About, Apertures, CircleSampling, Circles, IN_FOCUS_COC_PX, Meaning, Method, MethodError, Param};
use super::{Quantity, Scale};
use crate::gpu::{Frame, Pass, SamplerKind, Shader, Texture, TextureKey};
use crate::lens::Lens;
use crate::view::{Layer, LensUniform, View};
use crate::{shader, uniform};
use glam::UVec2;
use std::sync::LazyLock;

const SHADER: Shader = shader!("methods/mipmap");
const READ: Shader = shader!("methods/mipmap_read");

/// Names of what is exposed.
const COLOR_PYRAMID: &str = "colour pyramid";
const BLUR_PYRAMID: &str = "CoC, DoB, DoN";
const EXPLAINED: &str = "blur and level of each pixel";

/// Mipmap interpolation with the paper's constants as parameters.
#[derive(Clone, Debug)]
pub struct Mipmap {
    /// DoB over CoC diameter, sigma = s C (section 3.3: 1/2).
    pub sigma_per_coc: f32,
    /// A [`MipmapCalibration`].
    pub calibration: usize,
    /// k of equation (6), used by the calibration "paper" (2/3).
    pub k: f32,
    /// delta of equation (9), px of DoB.
    pub delta_px: f32,
    /// Whether blurred background refuses sharper texels (section 4).
    pub anisotropic: bool,
    /// Whether the DoB is smoothed over foreground edges (section 5).
    pub smoothing: bool,
    /// Whether neighbours are read on a circle or a square (section 3.4, Fig. 4).
    pub circular: bool,
    /// A [`MipmapInterpolation`].
    pub interpolation: usize,
    /// A [`MipmapFilter`].
    pub filter: usize,
}

/// How a level is found for a blur.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MipmapCalibration {
    /// The level whose blur has the lens's second moment.
    Measured,
    /// Equation (6).
    Paper,
}

const CALIBRATIONS: &[&str] = &["measured", "paper"];

/// How two levels are blended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MipmapInterpolation {
    /// The trilinear read of section 6.
    Arithmetic,
    /// Equation (8) as printed.
    Geometric,
}

const INTERPOLATIONS: &[&str] = &["arithmetic", "geometric"];

/// What a pixel reads of the pyramids.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MipmapFilter {
    /// Two reads of levels that were filtered beforehand, by discs of two diameters, so that
    /// a pixel's disc lies between two that differ by sqrt(2). Discs up to 4 px are drawn on
    /// the image itself. Faster than the paper's filter, and closer to a disc.
    Discs,
    /// Nine reads on a circle, of two levels each, as printed.
    AsPrinted,
}

const FILTERS: &[&str] = &["discs", "as printed"];

/// More levels than any image has.
const MAX_LEVELS: u32 = 12;

impl Default for Mipmap {
    fn default() -> Self {
        Self {
            sigma_per_coc: 0.5,
            calibration: 0,
            k: 2.0 / 3.0,
            delta_px: 1.0,
            anisotropic: true,
            smoothing: true,
            circular: true,
            interpolation: 0,
            filter: 0,
        }
    }
}

uniform! {
    struct Params {
        sigma_per_coc: f32,
        k: f32,
        delta: f32,
        geometric: u32,
        measured: u32,
        wanted_per_dob: f32,
        anisotropic: u32,
        circular: u32,
        padding: [i32; 2],
        levels: u32,
        overscan: u32,
        smoothing: u32,
        in_focus_coc_px: f32,
        _unused: [u32; 2],
        disc_variance: [f32; 4],
        discs: [[f32; 4]; 6],
    }
}

impl Method for Mipmap {
    fn about(&self) -> About {
        About {
            id: "mipmap",
            title: "Anisotropic mipmaps",
            paper: "Lee, Kim and Choi, Real-Time Depth-of-Field Rendering Using Anisotropically Filtered Mipmap Interpolation, TVCG 2009",
            summary: "Reads each pixel's blur from a mipmap that keeps sharp surfaces out of blurred backgrounds, with smoothed foreground edges.",
            limits: "One view only: what a blurred foreground hides is missing, and sharp surfaces behind it are not seen through it. Round apertures only.",
            apertures: Apertures::Round,
            needs_scene: false,
            conserves_energy: false,
            averages: true,
            samples_lens: false,
            width_tolerance: 0.05,
        }
    }

    fn params(&mut self) -> Vec<Param<'_>> {
        vec![
            Param::choice(
                "calibration",
                "Level calibration",
                &mut self.calibration,
                CALIBRATIONS,
                "measured: the level whose blur has the lens's second moment. paper: m = 1 + log2(k sigma), equation (6).",
            ),
            Param::float(
                "k",
                "k",
                "",
                &mut self.k,
                (0.1, 4.0),
                "Scale of equation (6), for the calibration \"paper\".",
            ),
            Param::float(
                "sigma_per_coc",
                "DoB per CoC",
                "",
                &mut self.sigma_per_coc,
                (0.05, 2.0),
                "Degree of blur sigma over CoC diameter C; section 3.3 has sigma = C/2.",
            ),
            Param::switch(
                "anisotropic",
                "Anisotropic weights",
                &mut self.anisotropic,
                "Blurred background refuses sharper texels while the mipmap is built, equation (9): no leakage.",
            ),
            Param::float(
                "delta",
                "delta",
                "px",
                &mut self.delta_px,
                (0.0, 10.0),
                "How much blurrier than a texel the background must be to refuse it, equation (9).",
            ),
            Param::switch(
                "smoothing",
                "Foreground smoothing",
                &mut self.smoothing,
                "Smooths the degree of blur over the edges of blurred foreground, section 5.",
            ),
            Param::switch(
                "circular",
                "Circular filter",
                &mut self.circular,
                "Reads neighbours on a circle instead of a square, Fig. 4, for the filter \"as printed\".",
            ),
            Param::choice(
                "interpolation",
                "Level interpolation",
                &mut self.interpolation,
                INTERPOLATIONS,
                "geometric: equation (8). arithmetic: the trilinear read of section 6.",
            ),
            Param::choice(
                "filter",
                "Filter",
                &mut self.filter,
                FILTERS,
                "discs: two reads of levels filtered beforehand. as printed: nine reads on a circle, equations (8) and (11).",
            ),
        ]
    }

    fn record(&self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Result<Texture, MethodError> {
        let pinhole = view.pinhole(frame);
        let [nearest_px, farthest_px] = view.coc_bounds_px(frame, lens);
        let levels = self.levels(lens, nearest_px.abs().max(farthest_px.abs()));
        let levels = levels.min(levels_with_content(pinhole.color.size()));
        let grid = PyramidGrid::new(pinhole.color.size(), levels);
        let smoothing = self.smoothing && nearest_px < 0.0;
        if self.smoothing && !smoothing {
            frame.skip("no foreground: no smoothing");
        }
        let params = self.uniform(view, lens, &grid, smoothing);
        let uniforms = Uniforms { lens: view.lens_uniform(lens), params };
        let blocks = blocks_of_levels(frame, view, lens, &grid);
        let pyramids = build_pyramids(frame, &pinhole, &grid, &uniforms, &blocks);
        let result = frame.color_texture("mipmap", view.size());
        let reading = Reading { pinhole: &pinhole, blocks: &blocks, uniforms: &uniforms, result: &result };
        if self.filter == MipmapFilter::Discs as usize {
            reading.through_discs(frame, &pyramids);
        } else {
            reading.as_printed(frame, &pyramids);
        }
        Ok(result)
    }

    fn explains(&self) -> &'static [&'static str] {
        &[EXPLAINED, BLUR_PYRAMID, tile_lists::SKIPPED]
    }

    fn meaning(&self, name: &str) -> Meaning {
        let px = |name, scale| Quantity::new(name, " px", scale);
        match name {
            BLUR_PYRAMID => {
                Meaning::numbers([px("CoC", Scale::Signed), px("DoB", Scale::Found), px("DoN", Scale::Found)])
            }
            tile_lists::SKIPPED => tile_lists::meaning(&TILE_CLASSES),
            EXPLAINED => Meaning::numbers([
                px("CoC", Scale::Signed),
                px("DoB", Scale::Found),
                px("smoothed DoB", Scale::Found),
                Quantity::new("mipmap level", "", Scale::Found),
            ]),
            _ => Meaning::Picture,
        }
    }

    fn texel_px(&self, name: &str) -> Option<u32> {
        // The pyramids begin at level 1.
        [COLOR_PYRAMID, BLUR_PYRAMID].contains(&name).then_some(2)
    }

    fn boxed(&self) -> Box<dyn Method> {
        Box::new(self.clone())
    }
}

/// Levels up to the one whose texels are four images wide: coarser ones hold nothing but
/// the stretched border, and would make a small image's pyramid vast.
fn levels_with_content(image: UVec2) -> u32 {
    image.max_element().next_power_of_two().ilog2() + 2
}

impl Mipmap {
    /// The paper's M: the level that the greatest CoC in view, px, needs, and one more for
    /// the filter around it.
    pub fn levels(&self, lens: &Lens, greatest_coc_px: f64) -> u32 {
        let sigma_px = f64::from(self.sigma_per_coc) * greatest_coc_px;
        let m = if self.calibration == MipmapCalibration::Paper as usize {
            1.0 + (f64::from(self.k) * sigma_px).log2()
        } else {
            // Level m has a variance of 0.79 * 4^(m-1) - 0.25: `variance_as_printed` in the shader,
            // which blurs less than the narrow disc on that level: enough levels for both.
            1.0 + 0.5 * (((lens.aperture.sigma_per_coc() * greatest_coc_px).powi(2) + 0.25) / 0.79).log2()
        };
        (m.ceil().max(0.0) as u32 + 1).min(MAX_LEVELS)
    }

    fn uniform(&self, view: &View, lens: &Lens, grid: &PyramidGrid, smoothing: bool) -> Params {
        let discs = &*DISCS;
        Params {
            sigma_per_coc: self.sigma_per_coc,
            k: self.k,
            delta: self.delta_px,
            geometric: (self.interpolation == MipmapInterpolation::Geometric as usize).into(),
            measured: (self.calibration == MipmapCalibration::Measured as usize).into(),
            wanted_per_dob: lens.aperture.sigma_per_coc() as f32 / self.sigma_per_coc,
            anisotropic: self.anisotropic.into(),
            circular: self.circular.into(),
            padding: grid.padding.as_ivec2().to_array(),
            levels: grid.levels,
            overscan: view.overscan_px(),
            smoothing: smoothing.into(),
            in_focus_coc_px: IN_FOCUS_COC_PX as f32,
            _unused: [0; 2],
            disc_variance: discs.variance,
            discs: discs.weights,
        }
    }
}

struct Uniforms {
    lens: LensUniform,
    params: Params,
}

/// The pyramids' frame: the image, padded to whole texels of the coarsest level and
/// centred in it, so that a mirrored image has the mirrored pyramid.
struct PyramidGrid {
    /// Number of levels, from the paper's level 1 on.
    levels: u32,
    /// Size of level 1, texels.
    size: UVec2,
    /// Level-0 texels left of and above the image.
    padding: UVec2,
}

impl PyramidGrid {
    fn new(image: UVec2, levels: u32) -> Self {
        let coarsest = 1u32 << levels;
        let padded = UVec2::new(image.x.next_multiple_of(coarsest), image.y.next_multiple_of(coarsest));
        Self { levels, size: padded / 2, padding: (padded - image) / 2 }
    }

    fn level_size(&self, level: u32) -> UVec2 {
        (self.size >> level).max(UVec2::ONE)
    }

    fn key(&self, format: wgpu::TextureFormat) -> TextureKey {
        TextureKey { size: self.size, levels: self.levels, layers: 1, format }
    }
}

struct Pyramids {
    color: Texture,
    /// (c, sigma, rho): signed CoC, DoB, DoN, px.
    blur: Texture,
}

/// How far from a pixel the texels lie that its blur is made of, over its CoC diameter: a
/// disc of 3 texels, read between texels of up to 2/3 of the CoC that are made of others as
/// far again.
const REACH_PER_COC: f64 = 3.0;

/// Blocks of every level by whether there is blur near by.
fn blocks_of_levels(frame: &mut Frame<'_>, view: &mut View, lens: &Lens, grid: &PyramidGrid) -> Vec<TileLists> {
    let map = FocusMap::new(frame, view, lens, IN_FOCUS_COC_PX, REACH_PER_COC);
    (0..grid.levels).map(|level| map.blocks(frame, grid.level_size(level), 2 << level, grid.padding)).collect()
}

fn build_pyramids(
    frame: &mut Frame<'_>,
    pinhole: &Layer,
    grid: &PyramidGrid,
    uniforms: &Uniforms,
    blocks: &[TileLists],
) -> Pyramids {
    let gpu = frame.gpu();
    let color = gpu.texture_of("colour pyramid", grid.key(frame.precision.format()));
    let blur = gpu.texture_of("blur pyramid", grid.key(wgpu::TextureFormat::Rgba16Float));
    for (level, blocks) in (0..).zip(blocks) {
        for (class, image, finer) in
            [(DEFOCUSED, "reduce_image", "reduce_level"), (IN_FOCUS, "halve_image", "halve_level")]
        {
            let mut pass = if level == 0 {
                frame.pass(&SHADER, image).uniform("params", &uniforms.params).texture("color", &pinhole.color)
            } else {
                frame.pass(&SHADER, finer).label(format_args!("{finer} {level}")).level(
                    "finer_color",
                    &color,
                    level - 1,
                )
            };
            if class == IN_FOCUS {
                pass = pass.sampler("linear_clamp", SamplerKind::Linear);
            } else if level == 0 {
                pass = pass.uniform("lens", &uniforms.lens).texture("depth", &pinhole.depth);
            } else {
                pass = pass.uniform("params", &uniforms.params).level("finer_blur", &blur, level - 1);
            }
            let pass = pass.level("coarser_color", &color, level).level("coarser_blur", &blur, level);
            blocks.dispatch(pass, class);
        }
    }
    frame.expose(COLOR_PYRAMID, &color);
    frame.expose(BLUR_PYRAMID, &blur);
    Pyramids { color, blur }
}

/// Diameters, texels, of the discs that a level is filtered by: the first on the image only.
const DISC_DIAMETERS: [f64; 3] = [2.0, 3.0, 3.0 * std::f64::consts::SQRT_2];

/// Neighbours that the discs reach, up to symmetry: `discs` in `shaders/lib/mipmap.wgsl`.
const DISC_NEIGHBOURS: [(u32, u32); 6] = [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)];

/// The discs as the shaders have them: computed once, for all frames.
struct Discs {
    variance: [f32; 4],
    weights: [[f32; 4]; 6],
}

static DISCS: LazyLock<Discs> = LazyLock::new(|| Discs {
    variance: array4(DISC_DIAMETERS.map(disc_variance)),
    weights: DISC_NEIGHBOURS.map(|(dx, dy)| array4(DISC_DIAMETERS.map(|d| disc_weight(d, dx, dy)))),
});

fn array4(discs: [f64; 3]) -> [f32; 4] {
    [discs[0] as f32, discs[1] as f32, discs[2] as f32, 0.0]
}

/// Share of a texel's neighbour in the disc around it.
fn disc_weight(diameter: f64, dx: u32, dy: u32) -> f64 {
    let circles = Circles::new(CircleSampling::default());
    circles.coverage(0.5 * diameter, dx, dy) * circles.energy_per_coverage(0.5 * diameter)
}

/// Variance per axis, texel^2, of a disc drawn on texels.
fn disc_variance(diameter: f64) -> f64 {
    let weighted = |x: i32, y: i32| f64::from(x * x) * disc_weight(diameter, x.unsigned_abs(), y.unsigned_abs());
    (-2..=2).flat_map(|y| (-2..=2).map(move |x| (x, y))).map(|(x, y)| weighted(x, y)).sum()
}

/// Classes of tiles, beside those in focus: constants in `shaders/methods/mipmap_read.wgsl`.
#[derive(Clone, Copy)]
enum Class {
    /// Some blur is too narrow to be read from levels alone.
    Near = 1,
    /// All is read from levels.
    Far = 2,
    /// There is blurred foreground near by.
    Smoothed = 3,
}

/// The classes in words; those of [`Class::Smoothed`] end up in one of the others.
const TILE_CLASSES: [(f32, &str); 3] =
    [(0.0, "in focus: copied"), (1.0, "image and levels"), (2.0, "levels alone: image skipped")];

/// What tiles are blurred from.
struct Blurred<'a> {
    discs: &'a Texture,
    /// Filtered (c, sigma, rho).
    blur: &'a Texture,
    /// Of each pixel, px^2.
    variance: &'a Texture,
}

/// Steps 3 to 5: what pixels read of the pyramids.
struct Reading<'a> {
    pinhole: &'a Layer,
    /// Of every level.
    blocks: &'a [TileLists],
    uniforms: &'a Uniforms,
    result: &'a Texture,
}

impl Reading<'_> {
    /// Every pixel through the circular filter of the paper.
    fn as_printed(&self, frame: &mut Frame<'_>, pyramids: &Pyramids) {
        self.pass(frame, "blur_as_printed")
            .texture("color", &self.pinhole.color)
            .uniform("lens", &self.uniforms.lens)
            .texture("depth", &self.pinhole.depth)
            .texture("color_pyramid", &pyramids.color)
            .texture("blur_pyramid", &pyramids.blur)
            .sampler("linear_clamp", SamplerKind::Linear)
            .texture("result", self.result)
            .dispatch(self.result.size());
        self.explain(frame, "explain_as_printed", &pyramids.blur);
    }

    /// Exposes what each pixel is blurred by, and where in the pyramid that is read.
    fn explain(&self, frame: &mut Frame<'_>, entry: &'static str, blur: &Texture) {
        if !frame.keeps_intermediates() {
            return;
        }
        let explained = frame.texture(EXPLAINED, self.result.size(), wgpu::TextureFormat::Rgba16Float);
        self.pass(frame, entry)
            .uniform("lens", &self.uniforms.lens)
            .texture("depth", &self.pinhole.depth)
            .texture("blur_pyramid", blur)
            .sampler("linear_clamp", SamplerKind::Linear)
            .texture("explained", &explained)
            .dispatch(explained.size());
        frame.expose(EXPLAINED, &explained);
    }

    /// Tiles by what they need.
    fn through_discs(&self, frame: &mut Frame<'_>, pyramids: &Pyramids) {
        let (discs, blur) = self.filter_levels(frame, pyramids);
        let size = self.result.size();
        let variance = frame.texture("variance", size, wgpu::TextureFormat::R32Float);
        let lists = TileLists::new(frame.gpu(), size);
        let tiles = lists.tiles();
        lists
            .filled_by(self.pass(frame, "classify_tiles"))
            .uniform("lens", &self.uniforms.lens)
            .texture("depth", &self.pinhole.depth)
            .texture("blur_pyramid", &blur)
            .texture("new_variance", &variance)
            .dispatch_groups(tiles.x.div_ceil(TILE_PX), tiles.y, 1);
        lists.plan(frame);
        let blurred = Blurred { discs: &discs, blur: &blur, variance: &variance };
        self.blur_tiles(frame, &lists, &blurred);
        let smoothed = (self.uniforms.params.smoothing != 0).then(|| TileLists::new(frame.gpu(), size));
        if let Some(smoothed) = &smoothed {
            let pass = self
                .pass(frame, "smooth_tiles")
                .uniform("lens", &self.uniforms.lens)
                .texture("depth", &self.pinhole.depth)
                .texture("blur_pyramid", &blur)
                .sampler("linear_clamp", SamplerKind::Linear)
                .texture("new_variance", &variance);
            lists.dispatch(smoothed.filled_from_lists(pass), Class::Smoothed as u32);
            smoothed.plan(frame);
            self.blur_tiles(frame, smoothed, &blurred);
        }
        lists.expose(frame, smoothed.as_ref());
        self.explain(frame, "explain_discs", &blur);
    }

    /// The tiles that are listed as in focus, near or far.
    fn blur_tiles(&self, frame: &mut Frame<'_>, lists: &TileLists, blurred: &Blurred<'_>) {
        lists.copy_in_focus(frame, &self.pinhole.color, self.uniforms.params.overscan, self.result);
        for (class, entry) in [(Class::Near, "blur_near"), (Class::Far, "blur_far")] {
            let mut pass = self
                .pass(frame, entry)
                .texture("blur_pyramid", blurred.blur)
                .texture("disc_pyramid", blurred.discs)
                .texture("variance", blurred.variance)
                .sampler("linear_clamp", SamplerKind::Linear)
                .texture("result", self.result);
            if let Class::Near = class {
                pass = pass.texture("color", &self.pinhole.color);
            }
            lists.dispatch(pass, class as u32);
        }
    }

    /// Every level through two discs, and its blur through the narrower.
    fn filter_levels(&self, frame: &mut Frame<'_>, pyramids: &Pyramids) -> (Texture, Texture) {
        let gpu = frame.gpu();
        let key = |texture: &Texture, layers| TextureKey {
            size: texture.size(),
            levels: texture.levels(),
            layers,
            format: texture.format(),
        };
        let discs = gpu.texture_of("discs", key(&pyramids.color, 2));
        let blur = gpu.texture_of("filtered blur", key(&pyramids.blur, 1));
        for (level, blocks) in (0..).zip(self.blocks) {
            for (class, entry) in [(DEFOCUSED, "filter_level"), (IN_FOCUS, "keep_level")] {
                let mut pass = frame
                    .pass(&SHADER, entry)
                    .label(format_args!("{entry} {level}"))
                    .level("finer_color", &pyramids.color, level)
                    .level("finer_blur", &pyramids.blur, level)
                    .level("new_discs", &discs, level)
                    .level("new_blur", &blur, level);
                if class == DEFOCUSED {
                    pass = pass.uniform("params", &self.uniforms.params);
                }
                blocks.dispatch(pass, class);
            }
        }
        (discs, blur)
    }

    /// A pass with the numbers that all of them need.
    fn pass<'f, 'g>(&self, frame: &'f mut Frame<'g>, entry: &'static str) -> Pass<'f, 'g> {
        frame.pass(&READ, entry).uniform("params", &self.uniforms.params)
    }
}
