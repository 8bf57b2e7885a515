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
//! 5. two levels blended through a circular filter, equation (8).
//!
//! **Which lens this is.** The paper names a Gaussian lens of sigma = C/2, but its level
//! formula blurs close to a *disc* of diameter C, whose standard deviation is C/4. Here
//! the level is set so that the second moment of what the pyramid really does equals the
//! lens's own ("measured"); the paper's constant is the other setting.

use super::{About, Apertures, Method, MethodError, Param};
use crate::gpu::{Frame, SamplerKind, Shader, Texture, TextureKey};
use crate::lens::Lens;
use crate::view::{Layer, LensUniform, View};
use crate::{shader, uniform};
use glam::UVec2;

const SHADER: Shader = shader!("methods/mipmap");

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
                "Reads neighbours on a circle instead of a square, Fig. 4.",
            ),
            Param::choice(
                "interpolation",
                "Level interpolation",
                &mut self.interpolation,
                INTERPOLATIONS,
                "geometric: equation (8). arithmetic: the trilinear read of section 6.",
            ),
        ]
    }

    fn record(&self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Result<Texture, MethodError> {
        let pinhole = view.pinhole(frame);
        let [nearest_px, farthest_px] = view.coc_bounds_px(frame, lens);
        let levels = self.levels(lens, nearest_px.abs().max(farthest_px.abs()));
        let levels = levels.min(levels_with_content(pinhole.color.size()));
        let grid = PyramidGrid::new(pinhole.color.size(), levels);
        let uniforms = Uniforms { lens: view.lens_uniform(lens), params: self.uniform(view, lens, &grid) };

        let pyramids = build_pyramids(frame, &pinhole, &grid, &uniforms);
        let result = frame.color_texture("mipmap", view.size());
        let smoothing = self.smoothing && nearest_px < 0.0;
        if self.smoothing && !smoothing {
            frame.skip("no foreground: no smoothing");
        }
        let entry = if smoothing { "interpolate_smoothed" } else { "interpolate_sharp" };
        let mut pass = frame
            .pass(&SHADER, entry)
            .uniform("lens", &uniforms.lens)
            .uniform("params", &uniforms.params)
            .texture("color", &pinhole.color)
            .texture("depth", &pinhole.depth)
            .texture("color_pyramid", &pyramids.color)
            .sampler("linear_clamp", SamplerKind::Linear)
            .texture("result", &result);
        pass = pass.texture("blur_pyramid", &pyramids.blur);
        pass.dispatch(result.size());
        Ok(result)
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
            // Level m has a variance of 0.79 * 4^(m-1) - 0.25: `level_variance` in the shader.
            1.0 + 0.5 * (((lens.aperture.sigma_per_coc() * greatest_coc_px).powi(2) + 0.25) / 0.79).log2()
        };
        (m.ceil().max(0.0) as u32 + 1).min(MAX_LEVELS)
    }

    fn uniform(&self, view: &View, lens: &Lens, grid: &PyramidGrid) -> Params {
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

    fn key(&self, format: wgpu::TextureFormat) -> TextureKey {
        TextureKey { size: self.size, levels: self.levels, layers: 1, format }
    }
}

struct Pyramids {
    color: Texture,
    /// (c, sigma, rho): signed CoC, DoB, DoN, px.
    blur: Texture,
}

fn build_pyramids(frame: &mut Frame<'_>, pinhole: &Layer, grid: &PyramidGrid, uniforms: &Uniforms) -> Pyramids {
    let gpu = frame.gpu();
    let color = gpu.texture_of("colour pyramid", grid.key(frame.precision.format()));
    let blur = gpu.texture_of("blur pyramid", grid.key(wgpu::TextureFormat::Rgba16Float));
    for level in 0..grid.levels {
        let pass = if level == 0 {
            frame
                .pass(&SHADER, "reduce_image")
                .uniform("lens", &uniforms.lens)
                .texture("color", &pinhole.color)
                .texture("depth", &pinhole.depth)
        } else {
            frame
                .pass(&SHADER, "reduce_level")
                .label(format!("reduce level {level}"))
                .level("finer_color", &color, level - 1)
                .level("finer_blur", &blur, level - 1)
        };
        pass.uniform("params", &uniforms.params)
            .level("coarser_color", &color, level)
            .level("coarser_blur", &blur, level)
            .dispatch(color.level_size(level));
    }
    frame.expose("colour pyramid", &color);
    frame.expose("CoC, DoB, DoN", &blur);
    Pyramids { color, blur }
}
