//! The parameters of `mipmap`, and the numbers that its shaders have of them.

use super::super::{CircleSampling, Circles, IN_FOCUS_COC_PX, Param};
use super::grid::PyramidGrid;
use crate::lens::Lens;
use crate::uniform;
use crate::view::View;
use std::sync::LazyLock;

/// Mipmap interpolation with the paper's constants as parameters.
#[derive(Clone, Debug)]
pub struct Mipmap {
    /// DoB over CoC diameter, sigma = s C (section 3.3: 1/2).
    pub sigma_per_coc: f32,
    /// A [`MipmapCalibration`].
    pub calibration: usize,
    /// k of equation (6), used by the calibration "paper" (2/3).
    pub k: f32,
    /// delta of equation (9), px of DoB; used by the filter "as printed".
    pub delta_px: f32,
    /// Whether blurred background refuses what is sharper (section 4).
    pub anisotropic: bool,
    /// How many times as wide as its own the blur is, behind the focus distance, that a pixel
    /// no longer has a part in; in one half of that it has its full part. Used by the filter
    /// "discs". A pixel's own disc lies between two of which the wider is up to 1.5 times as
    /// wide: below that it would have no part in its own blur.
    pub reach: f32,
    /// Whether blurred foreground reaches over its edges (section 5).
    pub smoothing: bool,
    /// Whether neighbours are read on a circle or a square (section 3.4, Fig. 4); used by the
    /// filter "as printed".
    pub circular: bool,
    /// Whether levels are magnified by bilinear reads alone, equation (7); used by the filter
    /// "as printed".
    pub bilinear: bool,
    /// Index among the choices of the parameter of this name: at how many points DoB and DoN are
    /// read; used by the filter "as printed".
    pub blur_points: usize,
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
    /// Levels that were filtered beforehand by discs; what each pixel has a part in follows
    /// from its own blur. Faster than the paper's filter, and closer to a lens.
    Discs,
    /// Nine reads on a circle, of two levels each, with equations (8) to (11).
    AsPrinted,
}

/// At how many points of the circular filter the degree of blur is read (section 6, step 4).
const BLUR_POINTS: &[&str] = &["9", "5"];

const FILTERS: &[&str] = &["discs", "as printed"];

/// Variance, texel^2 per axis, of a level read through the circular filter, for large levels:
/// of all reductions 1/4, of the bilinear read 1/6, of the filter 3/8.
const LEVEL_VARIANCE: f64 = 0.25 + 1.0 / 6.0 + 0.375;

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
            reach: 2.0,
            smoothing: true,
            circular: true,
            bilinear: false,
            blur_points: 0,
            interpolation: 0,
            filter: 0,
        }
    }
}

impl Mipmap {
    pub(super) fn list(&mut self) -> Vec<Param<'_>> {
        vec![
            Param::choice(
                "calibration",
                "Level calibration",
                &mut self.calibration,
                CALIBRATIONS,
                "measured: the level whose blur has the lens's second moment. paper: m = 1 + log2(k sigma), equation (6).",
            ).as_published("paper"),
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
                "Blurred background refuses what is sharper: no leakage. As printed: equation (9).",
            ),
            Param::float(
                "delta",
                "delta",
                "px",
                &mut self.delta_px,
                (0.0, 10.0),
                "How much blurrier than a texel the background must be to refuse it, equation (9), for the filter \"as printed\".",
            ),
            Param::float(
                "reach",
                "Reach",
                "",
                &mut self.reach,
                (1.6, 16.0),
                "Behind the focus distance a pixel has no part in a blur this many times as wide as its own, and its full part in one half of that; for the filter \"discs\". 2: in full as far as its own blur reaches.",
            ),
            Param::switch(
                "smoothing",
                "Foreground over its edges",
                &mut self.smoothing,
                "discs: foreground is spread by its own blur over what is behind. As printed: the degree of blur is smoothed over its edges, equations (10) and (11).",
            ),
            Param::switch(
                "circular",
                "Circular filter",
                &mut self.circular,
                "Reads neighbours on a circle instead of a square, Fig. 4, for the filter \"as printed\".",
            ),
            Param::switch(
                "bilinear",
                "Bilinear magnification",
                &mut self.bilinear,
                "Magnifies levels by the hardware's bilinear read alone, equation (7) and Fig. 5a: blocky. For the filter \"as printed\".",
            ),
            Param::choice(
                "blur_points",
                "Points of the blur",
                &mut self.blur_points,
                BLUR_POINTS,
                "At how many points of the circular filter the degree of blur and of neighbours is read, section 6, step 4, for the filter \"as printed\".",
            ),
            Param::choice(
                "interpolation",
                "Level interpolation",
                &mut self.interpolation,
                INTERPOLATIONS,
                "geometric: equation (8). arithmetic: the trilinear read of section 6.",
            ).as_published("geometric"),
            Param::choice(
                "filter",
                "Filter",
                &mut self.filter,
                FILTERS,
                "discs: levels filtered beforehand, in which each pixel has a part by its own blur. as printed: nine reads on a circle, equations (8) to (11).",
            ).as_published("as printed"),
        ]
    }

    /// The paper's M: the level that the greatest CoC in view, px, needs, and one more for
    /// what is read around it.
    pub fn levels(&self, lens: &Lens, greatest_coc_px: f64) -> u32 {
        let variance_px2 = (self.sigma_px_per_coc(lens) * greatest_coc_px).powi(2);
        let needed = match self.filter == MipmapFilter::Discs as usize {
            true => 0.5 * ((variance_px2 + 0.25) / (0.25 + 1.0 / 6.0 + DISCS.variance_px2[1])).log2(),
            false if self.calibration == MipmapCalibration::Paper as usize => self.level_as_printed(greatest_coc_px),
            false => 1.0 + 0.5 * ((variance_px2 + 0.25) / LEVEL_VARIANCE).log2(),
        };
        (needed.ceil().max(1.0) as u32 + 1).min(MAX_LEVELS)
    }

    /// Equation (6), for what is blurred enough.
    fn level_as_printed(&self, coc_px: f64) -> f64 {
        1.0 + (f64::from(self.k) * f64::from(self.sigma_per_coc) * coc_px).log2()
    }

    /// Standard deviation of the blur, px, over CoC diameter: the lens's own, or that of the
    /// paper's level. Level m has a variance of 0.79 * 4^(m-1) - 0.25 px^2
    /// (`variance_as_printed` in the shader), where 2^(m-1) is k sigma by equation (6).
    fn sigma_px_per_coc(&self, lens: &Lens) -> f64 {
        match self.calibration == MipmapCalibration::Paper as usize {
            true => LEVEL_VARIANCE.sqrt() * f64::from(self.k) * f64::from(self.sigma_per_coc),
            false => lens.aperture.sigma_per_coc(),
        }
    }

    /// The first level whose discs are all wider than the greatest blur in front of the focus
    /// distance, where the least signed CoC is `least_coc_px`: nothing in front is handed on to
    /// it. `widest` in `shaders/lib/mipmap_discs.wgsl`, in which a thousandth is far more than
    /// f32 rounds away.
    fn front_level(&self, lens: &Lens, least_coc_px: f64) -> u32 {
        let variance_px2 = (self.sigma_px_per_coc(lens) * least_coc_px.min(0.0)).powi(2);
        let widest = |level: u32| match level {
            0 => DISCS.variance_px2[2],
            _ => {
                let texel2 = 4f64.powi(level as i32);
                0.25 * (texel2 - 1.0) + texel2 * (1.0 / 6.0 + DISCS.variance_px2[2])
            }
        };
        (1..MAX_LEVELS).find(|level| variance_px2 < 0.999 * widest(level - 1)).unwrap_or(MAX_LEVELS)
    }

    /// What the shaders need, where CoCs lie between `coc_bounds_px`.
    pub(super) fn uniform(&self, view: &View, lens: &Lens, grid: &PyramidGrid, coc_bounds_px: [f64; 2]) -> Params {
        let discs = &*DISCS;
        let foreground = coc_bounds_px[0] < 0.0;
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
            smoothing: (self.smoothing && foreground).into(),
            in_focus_coc_px: IN_FOCUS_COC_PX as f32,
            foreground: foreground.into(),
            background: (coc_bounds_px[1] > 0.0).into(),
            level_1: grid.size.to_array(),
            reach: self.reach,
            sigma_px_per_coc: self.sigma_px_per_coc(lens) as f32,
            bilinear: self.bilinear.into(),
            five_points: (BLUR_POINTS[self.blur_points] == "5").into(),
            front_level: self.front_level(lens, coc_bounds_px[0]).min(grid.levels),
            _unused: 0,
            disc_variance: array4(discs.variance_px2),
            discs: discs.weights,
        }
    }
}

uniform! {
    pub(super) struct Params {
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
        foreground: u32,
        background: u32,
        level_1: [u32; 2],
        reach: f32,
        sigma_px_per_coc: f32,
        bilinear: u32,
        five_points: u32,
        front_level: u32,
        _unused: u32,
        disc_variance: [f32; 4],
        discs: [[f32; 4]; 6],
    }
}

/// Diameters, texels, of the discs: the first on the image only.
const DISC_DIAMETERS: [f64; 3] = [2.0, 3.0, 3.0 * std::f64::consts::SQRT_2];

/// Neighbours that the discs reach, up to symmetry: `discs` in `shaders/lib/mipmap.wgsl`.
const DISC_NEIGHBOURS: [(u32, u32); 6] = [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)];

/// The discs as the shaders have them: computed once, for all frames.
struct Discs {
    /// Per axis, texel^2.
    variance_px2: [f64; 3],
    weights: [[f32; 4]; 6],
}

static DISCS: LazyLock<Discs> = LazyLock::new(|| Discs {
    variance_px2: DISC_DIAMETERS.map(disc_variance),
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
