//! Sub-images by depth and their pyramidal blur: what `opaque` and `pyramid` share.
//!
//! Kraus, "Using Opaque Image Blur for Real-Time Depth-of-Field Rendering" (GRAPP 2011),
//! section 3, after Kraus and Strengert, "Depth-of-Field Rendering by Pyramidal Image
//! Processing" (Eurographics 2007). Sub-image i (negative in front of the focus) holds the
//! pixels around the depth z_i and is blurred by a pyramid of |i| levels.
//!
//! **Weights.** omega_i is the trapezoid of Fig. 2: 0, 1, 1, 0 at z_(i-2), z_(i-1), z_i,
//! z_(i+1). Summed plainly these are 2 between neighbours; it is the *blending* that makes
//! 1 of them: between z_(i-1) and z_i sub-image i is opaque while i-1 fades out over it.
//!
//! **How wide a level blurs.** Analysis with a 4x4 box has a variance of 5/4 squared
//! texels, one step of synthesis 3/4 of the finer texel's: n levels of both come to
//! `2/3 (4^n - 1)` px^2 per axis. The paper's radii `r_n = 1.7 * 2^(n-1)` make that a
//! standard deviation of about r, twice a disc's (r/2). The calibration "measured" puts
//! sub-image i at the CoC whose variance the lens gives as that of |i| levels, with weights
//! linear in variance, so that the blend of two levels has the lens's own second moment;
//! "paper" keeps r_i and weights linear in depth.
//!
//! All sub-images are layers of one array texture a level: a level of all of them is one
//! pass.

use super::{Meaning, Param, Quantity, Scale};
use crate::gpu::{Buffer, Frame, Pass, Precision, Shader, Texture, TextureKey};
use crate::lens::Lens;
use crate::view::{Layer, LensUniform, View};
use crate::{shader, uniform};
use glam::UVec2;

const SHADER: Shader = shader!("methods/subimages");
const EXPLAIN_SHADER: Shader = shader!("methods/subimages_explain");

/// Name under which the sub-image of each pixel is exposed.
const EXPLAINED: &str = "sub-image of each pixel";

/// Names of the debug textures of these passes.
pub(super) const EXPLAINS: &[&str] = &[EXPLAINED];

/// Names of the sub-images' pyramid: by level, then as level 1 of what it is blurred to.
const LEVEL: &str = "sub-images, level ";
const BLURRED: &str = "blurred sub-images";
const GLOW: &str = "glow of sub-images";

/// What a texture of these passes means.
pub(super) fn meaning(name: &str) -> Meaning {
    let number = |name, scale| Quantity::new(name, "", scale);
    match name {
        EXPLAINED => {
            Meaning::numbers([number("sub-image index", Scale::Whole), number("pyramid levels", Scale::Whole)])
        }
        GLOW => Meaning::numbers([number("opacity", Scale::Found)]),
        _ => Meaning::Picture,
    }
}

/// Width, px, of a texel of a texture of these passes.
pub(super) fn texel_px(name: &str) -> Option<u32> {
    let level = match name {
        BLURRED | GLOW => 1,
        _ => name.strip_prefix(LEVEL)?.parse().ok()?,
    };
    1u32.checked_shl(level)
}

/// Greatest |i|: a blur that no image of 16384 px can show more of, and few enough
/// sub-images (25) for one word of bits.
const MAX_LEVEL: i32 = 12;

/// As many sub-images as there can be: |i| from 0 to [`MAX_LEVEL`], on either side.
const MOST_SUB_IMAGES: u32 = 2 * MAX_LEVEL as u32 + 1;

/// `MAX_SUB_IMAGES` in the shader.
const MAX_SUB_IMAGES: usize = 32;

/// How sub-images are placed: [`Spacing::calibration`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpacingCalibration {
    /// Where the lens has the second moment of the sub-image's pyramid.
    Measured,
    /// Equation (1).
    Paper,
}

const CALIBRATIONS: &[&str] = &["measured", "paper"];

/// Where sub-images lie, in terms of the CoC.
#[derive(Clone, Debug)]
pub struct Spacing {
    /// A [`SpacingCalibration`].
    pub calibration: usize,
    /// r_1, px: the CoC *radius* at the first sub-images (equation (1): 1.7).
    pub first_radius_px: f32,
    /// r_(n+1) / r_n (equation (1): 2).
    pub growth: f32,
    /// Most sub-images, 2 to `MOST_SUB_IMAGES`: those with the widest blur are left out first.
    pub most: u32,
}

impl Default for Spacing {
    fn default() -> Self {
        Self {
            calibration: SpacingCalibration::Measured as usize,
            first_radius_px: 1.7,
            growth: 2.0,
            most: MOST_SUB_IMAGES,
        }
    }
}

/// Greatest |i| for an image whose half is `centre` px: two levels more than make one texel
/// of that half. Blurred farther, a sub-image's opacity is that of a dot in transparent
/// black, and the quotients that rescale it lose their digits.
fn deepest_useful(centre: UVec2) -> i32 {
    (levels_to_one(centre) as i32 + 2).min(MAX_LEVEL)
}

/// Levels after which `centre`, px, is one texel.
fn levels_to_one(centre: UVec2) -> u32 {
    centre.max_element().next_power_of_two().ilog2()
}

/// Sets the format of colours for passes that make `level`, and returns the one that was
/// set: f32 from the second level on, where it costs a sixteenth of an image at most.
/// Analysis and synthesis round a texel twice a level, and with f16 ten levels add up to half
/// a percent.
fn set_precision(frame: &mut Frame<'_>, level: u32) -> Precision {
    let precision = if level >= 2 { Precision::Full } else { frame.precision };
    std::mem::replace(&mut frame.precision, precision)
}

/// Texels of the next level along a side that a workgroup makes: `BOXES` in the shader.
const BOXES: u32 = 15;

/// Workgroups that make the texels of a level of `size` from the blocks below it.
pub(super) fn box_groups(size: UVec2) -> UVec2 {
    size.map(|side| side.div_ceil(BOXES))
}

/// Most blocks of 2x2 px that an image of `size` has a part in, wherever in a block it begins.
pub(super) fn image_blocks(size: UVec2) -> UVec2 {
    size / 2 + 1
}

/// Variance per axis, px^2, of a blur by `levels` pyramid levels, averaged over where the
/// point lies on the coarsest level.
pub fn pyramid_variance_px2(levels: u32) -> f64 {
    (4f64.powi(levels as i32) - 1.0) * 2.0 / 3.0
}

impl Spacing {
    pub(super) fn params(&mut self) -> Vec<Param<'_>> {
        vec![
            Param::choice(
                "calibration",
                "Sub-image spacing",
                &mut self.calibration,
                CALIBRATIONS,
                "measured: a level is used where its second moment is the lens's. paper: radii r_1, r_2, ... of equation (1), weights linear in depth.",
            ).as_published("paper"),
            Param::float(
                "first_radius",
                "r_1",
                "px",
                &mut self.first_radius_px,
                (0.2, 16.0),
                "CoC radius of the first sub-images, equation (1), for the calibration \"paper\".",
            ),
            Param::float(
                "growth",
                "Growth of r",
                "",
                &mut self.growth,
                (1.25, 4.0),
                "r_(n+1) / r_n, equation (1), for the calibration \"paper\".",
            ),
            Param::int(
                "sub_images",
                "Most sub-images",
                "",
                &mut self.most,
                (2, MOST_SUB_IMAGES),
                "No more sub-images than this, the least blurred ones: what would need a wider blur gets that of the last. 25: as many as the CoCs in view ask for.",
            ),
        ]
    }

    fn measured(&self) -> bool {
        self.calibration == SpacingCalibration::Measured as usize
    }

    /// c_i: signed CoC diameter, px, of sub-image `i`.
    pub fn coc_px(&self, lens: &Lens, i: i32) -> f64 {
        let levels = i.unsigned_abs();
        if levels == 0 {
            return 0.0;
        }
        let diameter_px = if self.measured() {
            pyramid_variance_px2(levels).sqrt() / lens.aperture.sigma_per_coc()
        } else {
            2.0 * f64::from(self.first_radius_px) * f64::from(self.growth).powi(levels as i32 - 1)
        };
        diameter_px * f64::from(i.signum())
    }

    /// Whether sub-image `i` can hold anything: in the paper's terms z_i exists only while
    /// r_i < r_inf, for its weights are linear in depth.
    fn exists(&self, lens: &Lens, i: i32) -> bool {
        i.abs() <= MAX_LEVEL && (i <= 0 || self.measured() || self.coc_px(lens, i) < lens.k_px())
    }

    /// The frontmost and backmost sub-image that pixels with CoC within `bounds_px` need,
    /// of those up to |i| = `most`.
    fn range(&self, lens: &Lens, [low, high]: [f64; 2], most: i32) -> (i32, i32) {
        let all = || (-most..=most).filter(|i| self.exists(lens, *i));
        let front = all().rev().find(|i| self.coc_px(lens, *i) <= low).unwrap_or(-most);
        let back = all().find(|i| self.coc_px(lens, *i) >= high).or_else(|| all().next_back()).unwrap_or(most);
        self.capped(front.min(back), back)
    }

    /// The same without the most blurred ones that are too many.
    fn capped(&self, mut front: i32, mut back: i32) -> (i32, i32) {
        while back - front >= self.most as i32 {
            if back.abs() >= front.abs() {
                back -= 1;
            } else {
                front += 1;
            }
        }
        (front, back)
    }

    /// The variable in which weights are linear, at sub-image `i`: `ramp_variable` in the
    /// shader.
    fn ramp_at(&self, lens: &Lens, near_m: f64, i: i32) -> f64 {
        if self.measured() {
            return pyramid_variance_px2(i.unsigned_abs()) * f64::from(i.signum());
        }
        (lens.coc().depth_at(self.coc_px(lens, i)) / near_m).min(FARTHEST)
    }
}

/// `FARTHEST` in the shader.
const FARTHEST: f64 = 1e9;

/// Ramps that nothing reaches: the paper removes those at the extremes.
const BEYOND: [f32; 2] = [1e30, 2e30];

uniform! {
    /// `SubImages` in `shaders/lib/subimages.wgsl`.
    pub struct SubImagesUniform {
        /// By layer: the ramp variable at sub-images i-2, i-1, i and i+1.
        ramps: [[f32; 4]; MAX_SUB_IMAGES],
        /// x: by layer, |i|. y: from front to back, the layer.
        order: [[u32; 4]; MAX_SUB_IMAGES],
        /// The image's centre, px.
        centre: [i32; 2],
        /// Number of sub-images.
        count: u32,
        /// Overscan, px.
        overscan: u32,
        /// Whether weights are linear in the blur's variance, or in depth.
        variance_ramps: u32,
        /// Whether weights are undone of what the glow adds to them.
        glow_undone: u32,
        /// Whether transparent black surrounds the image.
        transparent_border: u32,
        /// Share of the light behind a sub-image that its opacity fails to cover.
        repeated_inclusion: f32,
    }
}

uniform! {
    struct Level {
        finer: u32,
        _0: u32,
        _1: u32,
        _2: u32,
    }
}

/// Options in which the two methods differ.
pub(super) struct Wanted {
    pub glow: bool,
    pub transparent_border: bool,
    pub repeated_inclusion: f32,
}

/// The sub-images of a view, and what their passes bind.
pub(super) struct SubImages {
    pub uniform: SubImagesUniform,
    lens: LensUniform,
    /// Bit l is set if any pixel lies in the sub-image of layer l: the first pass of a method that
    /// reads pixels notes it, so that those after it leave out what is empty.
    pub occupied: Buffer,
    /// |i| by layer, falling: the layers of a level are the first ones.
    levels: Vec<u32>,
    /// Half the image, px, rounded up.
    centre: UVec2,
    glow: bool,
}

impl SubImages {
    /// Sub-images for all that `view` shows through `lens`.
    pub fn new(frame: &mut Frame<'_>, view: &mut View, lens: &Lens, spacing: &Spacing, wanted: &Wanted) -> Self {
        let bounds_px = view.coc_bounds_px(frame, lens);
        let depth = view.pinhole(frame).depth;
        let centre = depth.size().map(|side| side.div_ceil(2));
        let (front, back) = spacing.range(lens, bounds_px, deepest_useful(centre));
        let mut layers: Vec<i32> = (front..=back).collect();
        layers.sort_by_key(|i| (-i.abs(), *i));
        let mut uniform = SubImagesUniform {
            centre: centre.as_ivec2().to_array(),
            count: layers.len() as u32,
            overscan: view.overscan_px(),
            variance_ramps: spacing.measured().into(),
            glow_undone: (wanted.glow && spacing.measured()).into(),
            transparent_border: wanted.transparent_border.into(),
            repeated_inclusion: wanted.repeated_inclusion,
            ..Default::default()
        };
        let near_m = view.projection().near_m;
        for (layer, &i) in layers.iter().enumerate() {
            let at = |j: i32| spacing.ramp_at(lens, near_m, j) as f32;
            let [rise, rise_end] = if i == front { [-BEYOND[1], -BEYOND[0]] } else { [at(i - 2), at(i - 1)] };
            let [fall, fall_end] = if i == back { BEYOND } else { [at(i), at(i + 1)] };
            uniform.ramps[layer] = [rise, rise_end, fall, fall_end];
            uniform.order[layer][0] = i.unsigned_abs();
            uniform.order[(i - front) as usize][1] = layer as u32;
        }
        let occupied = frame.gpu().buffer("occupied sub-images", 4);
        let lens = view.lens_uniform(lens);
        let levels = layers.iter().map(|i| i.unsigned_abs()).collect();
        let sub_images = Self { uniform, lens, occupied, levels, centre, glow: wanted.glow };
        if frame.keeps_intermediates() {
            sub_images.explain(frame, view.size(), &depth);
        }
        sub_images
    }

    fn explain(&self, frame: &mut Frame<'_>, size: UVec2, depth: &Texture) {
        let explained = frame.texture(EXPLAINED, size, wgpu::TextureFormat::Rgba16Float);
        frame
            .pass(&EXPLAIN_SHADER, "explain")
            .uniform("sub_images", &self.uniform)
            .uniform("lens", &self.lens)
            .texture("depth", depth)
            .texture("explained", &explained)
            .dispatch(size);
        frame.expose(EXPLAINED, &explained);
    }

    /// Binds what the pixels of sub-images are made of.
    pub fn bind<'f, 'g>(&self, pass: Pass<'f, 'g>, pinhole: &Layer) -> Pass<'f, 'g> {
        pass.uniform("lens", &self.lens)
            .uniform("sub_images", &self.uniform)
            .texture("color", &pinhole.color)
            .texture("depth", &pinhole.depth)
    }

    /// Number of sub-images.
    pub fn count(&self) -> u32 {
        self.levels.len() as u32
    }

    /// Greatest |i|: the number of levels of the deepest pyramid.
    pub fn deepest(&self) -> u32 {
        self.levels.first().copied().unwrap_or(0)
    }

    /// Number of sub-images that are blurred at all: all but i = 0.
    fn blurred_count(&self) -> u32 {
        self.layers_with(1)
    }

    /// Number of sub-images whose pyramids have `level`.
    fn layers_with(&self, level: u32) -> u32 {
        self.levels.iter().filter(|l| **l >= level).count() as u32
    }

    /// Levels after which half the image is one texel.
    pub fn levels_to_one(&self) -> u32 {
        levels_to_one(self.centre)
    }

    /// An array texture of `level` with at least `layers` layers.
    pub fn texture(
        &self,
        frame: &Frame<'_>,
        label: &str,
        level: u32,
        layers: u32,
        format: wgpu::TextureFormat,
    ) -> Texture {
        let size = self.level_size(level);
        // A single layer would make it a plain texture, which shaders bind differently.
        frame.gpu().texture_of(label, TextureKey { size, levels: 1, layers: layers.max(2), format })
    }

    /// Size of a level, texels: an even number.
    pub fn level_size(&self, level: u32) -> UVec2 {
        2 * self.centre.map(|side| side.div_ceil(1 << level.min(16)) + 1)
    }

    /// The texture of level 1 that a matte writes.
    pub fn matte(&self, frame: &Frame<'_>) -> Texture {
        self.texture(frame, "matted sub-images", 1, self.blurred_count(), frame.precision.format())
    }

    /// The pyramidal blur of the sub-images whose matted level 1 is `first`: all but its
    /// last synthesis step, which the methods fuse with blending.
    pub fn blur(&self, frame: &mut Frame<'_>, first: Texture) -> Blurred {
        let analysis = self.analyse(frame, first);
        for (level, texture) in (1..).zip(&analysis) {
            frame.expose(format_args!("{LEVEL}{level}"), texture);
        }
        let mut blurred = Blurred::starting_at(&analysis[analysis.len() - 1]);
        for finer in (1..self.deepest()).rev() {
            blurred = self.expand(frame, finer, &analysis, &blurred);
        }
        frame.expose(BLURRED, &blurred.blur);
        if self.glow {
            frame.expose(GLOW, &blurred.glow);
        }
        Blurred { analysis: analysis[0].clone(), ..blurred }
    }

    /// Levels 1, 2, ... of the analysis.
    fn analyse(&self, frame: &mut Frame<'_>, first: Texture) -> Vec<Texture> {
        let mut analysis = vec![first];
        for level in 2..=self.deepest() {
            let layers = self.layers_with(level);
            let wanted = set_precision(frame, level);
            let coarser = self.texture(frame, "sub-image analysis", level, layers, frame.precision.format());
            let groups = box_groups(coarser.size());
            frame
                .pass(&SHADER, "reduce")
                .label(format_args!("reduce level {level}"))
                .uniform("sub_images", &self.uniform)
                .buffer("occupied", &self.occupied)
                .texture("finer", &analysis[analysis.len() - 1])
                .texture("coarser", &coarser)
                .dispatch_groups(groups.x, groups.y, layers);
            frame.precision = wanted;
            analysis.push(coarser);
        }
        analysis
    }

    /// Level `finer` of the synthesis from the next coarser one.
    fn expand(&self, frame: &mut Frame<'_>, finer: u32, analysis: &[Texture], coarser: &Blurred) -> Blurred {
        let layers = self.layers_with(finer + 1);
        let wanted = set_precision(frame, finer);
        let blur = self.texture(frame, "sub-image synthesis", finer, layers, frame.precision.format());
        let glow =
            self.glow.then(|| self.texture(frame, "sub-image glow", finer, layers, wgpu::TextureFormat::R32Float));
        let entry = if self.glow { "expand_with_glow" } else { "expand" };
        let mut pass = frame
            .pass(&SHADER, entry)
            .label(format_args!("expand to level {finer}"))
            .uniform("sub_images", &self.uniform)
            .uniform("level", &Level { finer, ..Default::default() })
            .buffer("occupied", &self.occupied)
            .texture("analysis", &analysis[finer as usize])
            .texture("blur", &coarser.blur)
            .texture("finer_blur", &blur);
        if let Some(glow) = &glow {
            pass = pass
                .texture("finer_analysis", &analysis[finer as usize - 1])
                .texture("glow", &coarser.glow)
                .texture("finer_glow", glow);
        }
        pass.dispatch_layers(blur.size(), layers);
        frame.precision = wanted;
        let analysis = analysis[finer as usize - 1].clone();
        Blurred { glow: glow.unwrap_or_else(|| blur.clone()), blur, analysis }
    }
}

/// Level 1 of blurred sub-images. Where a sub-image's synthesis starts at this level, that
/// is the analysis; the others are in `blur` and `glow`.
pub(super) struct Blurred {
    pub analysis: Texture,
    /// Colour and opacity, premultiplied.
    pub blur: Texture,
    /// The glow's opacity; not meaningful without glow.
    pub glow: Texture,
}

impl Blurred {
    /// Before any synthesis: no layer reads `blur` and `glow`, but both must be bound.
    fn starting_at(analysis: &Texture) -> Self {
        Self { analysis: analysis.clone(), blur: analysis.clone(), glow: analysis.clone() }
    }
}
