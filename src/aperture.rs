//! The aperture's intensity distribution (IDF) and points on it.
//!
//! Lens points are given in the coordinates of the unit disc with image orientation (x
//! right, y down): the point `v` displaces the image of a point with the signed CoC
//! diameter `c` by `v * c / 2` pixels. The circle of radius 1 is thus the CoC itself; a
//! polygon has its corners on it, an image's longer side spans its diameter, and a
//! Gaussian reaches beyond it.

mod image;
mod polygon;
mod sobol;
mod syntax;

pub use image::{ApertureImage, MAX_SIDE_PX};

use glam::{DVec2, dvec2};
use polygon::Polygon;
use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4};
use std::ops::RangeInclusive;
use std::sync::Arc;

/// Blades that a polygon may have.
pub const BLADES: RangeInclusive<u32> = 3..=16;

/// Greatest standard deviation of a Gaussian aperture over the CoC diameter. Beyond it
/// the "CoC" says nothing about the size of the blur any more.
pub const MAX_SIGMA_PER_COC: f64 = 2.0;

/// Standard deviation over CoC diameter of the Gaussian lens in Lee, Kim and Choi (TVCG
/// 2009), section 3.2: sigma = C / 2.
pub const DEFAULT_SIGMA_PER_COC: f64 = 0.5;

/// Radius at which a Gaussian aperture ends, over the standard deviation of the Gaussian
/// before it is cut.
const GAUSSIAN_CUT: f64 = 3.0;

/// The intensity distribution over the aperture.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Aperture {
    /// Uniform over the unit disc.
    #[default]
    Disc,
    /// Uniform over a regular polygon with its corners on the unit circle.
    Polygon {
        /// Number of blades, in [`BLADES`].
        blades: u32,
        /// Rotation, degrees, clockwise on the image; at 0 a corner points up.
        #[serde(default)]
        rotation_deg: f64,
        /// 0 for straight blades, 1 for the disc; between them the distance of the edge
        /// from the centre is interpolated.
        #[serde(default)]
        roundness: f64,
    },
    /// A Gaussian, cut where three of its standard deviations are reached and widened by
    /// 2.6 % so that the standard deviation of what is left is exactly the one asked for.
    Gaussian {
        /// Standard deviation per axis over CoC diameter, in (0, [`MAX_SIGMA_PER_COC`]].
        sigma_per_coc: f64,
    },
    /// The brightness of an image, moved so that its centroid lies at 0: blur does not
    /// shift what it blurs.
    Image(#[serde(with = "image::shared")] Arc<ApertureImage>),
}

/// What makes an aperture impossible.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ApertureError {
    /// Not the command line's syntax.
    #[error(
        "'{}' is not an aperture: {cause}; \
         write disc, polygon:N[:ROT[:ROUNDNESS]], gaussian[:SIGMA_PER_COC] or image:FILE",
        given.escape_debug()
    )]
    Syntax {
        /// The whole of what was given.
        given: String,
        /// What is wrong with it.
        cause: String,
    },
    /// A parameter outside its range.
    #[error("the aperture's {name} is {value}: it must be {bound}")]
    OutOfRange {
        /// The parameter.
        name: &'static str,
        /// The value given.
        value: f64,
        /// The range in words.
        bound: &'static str,
    },
    /// An aperture image that cannot be read.
    #[error("cannot read the aperture image '{}': {cause}; give a PNG, JPEG or HDR image", path.escape_debug())]
    Unreadable {
        /// The file.
        path: String,
        /// What the system or the decoder says.
        cause: String,
    },
    /// An aperture image that no light passes, or with pixels that are no intensities.
    #[error("the aperture image '{}' {cause}", name.escape_debug())]
    BadImage {
        /// The image's name.
        name: String,
        /// What is wrong and what to do about it.
        cause: String,
    },
}

impl Aperture {
    /// The polygon with straight blades and a corner pointing up.
    pub fn polygon(blades: u32) -> Self {
        Self::Polygon { blades, rotation_deg: 0.0, roundness: 0.0 }
    }

    /// Errors unless all parameters lie in their ranges.
    pub fn check(&self) -> Result<(), ApertureError> {
        let out_of_range = |name, value, bound| Err(ApertureError::OutOfRange { name, value, bound });
        match *self {
            Self::Disc | Self::Image(_) => Ok(()),
            Self::Polygon { blades, .. } if !BLADES.contains(&blades) => {
                out_of_range("number of blades", f64::from(blades), "3 to 16")
            }
            Self::Polygon { rotation_deg, .. } if !rotation_deg.is_finite() => {
                out_of_range("rotation", rotation_deg, "a finite number of degrees")
            }
            Self::Polygon { roundness, .. } if !(0.0..=1.0).contains(&roundness) => {
                out_of_range("roundness", roundness, "0 (straight blades) to 1 (disc)")
            }
            Self::Polygon { .. } => Ok(()),
            Self::Gaussian { sigma_per_coc } if !(sigma_per_coc > 0.0 && sigma_per_coc <= MAX_SIGMA_PER_COC) => {
                out_of_range("sigma over CoC diameter", sigma_per_coc, "above 0 and at most 2")
            }
            Self::Gaussian { .. } => Ok(()),
        }
    }

    /// Point `index` of a progressive set distributed as [`Aperture::intensity`].
    ///
    /// The points are an Owen-scrambled Sobol (0,2)-sequence, mapped by a function of the
    /// aperture that keeps densities. Any prefix is a good set, those of a power of two
    /// the best; so is any aligned block `k * 2^m .. (k + 1) * 2^m`, such as each *half*
    /// of a set (not every other point).
    pub fn lens_point(&self, index: u32) -> DVec2 {
        self.map_square(sobol::point(index))
    }

    /// `sets` sets of `samples` points each, one after another: blocks of [`Aperture::lens_point`] that begin
    /// at powers of two, each of which is spread well. A single point is the lens's centre.
    pub(crate) fn lens_point_sets(&self, samples: u32, sets: u32) -> Vec<DVec2> {
        let block = samples.next_power_of_two();
        let point = |i: u32| if samples == 1 { DVec2::ZERO } else { self.lens_point(i) };
        (0..sets).flat_map(|k| (0..samples).map(move |i| point(k * block + i))).collect()
    }

    /// The points of [`Aperture::lens_point_sets`], those of all sets that lie in one cell of the lens one after
    /// another: the unit square that they are mapped from is cut into as many cells as a set has points,
    /// and each set has one point in each. Where `samples` is a power of two they are rectangles.
    pub(crate) fn lens_point_sets_by_cell(&self, samples: u32, sets: u32) -> Vec<DVec2> {
        if samples == 1 {
            return self.lens_point_sets(samples, sets);
        }
        let block = samples.next_power_of_two();
        // Columns of the square, each cut into as many rows as it has points.
        let columns = 1usize << (samples.ilog2() / 2);
        let by_cell: Vec<Vec<DVec2>> = (0..sets)
            .map(|k| {
                let mut points: Vec<DVec2> = (0..samples).map(|i| sobol::point(k * block + i)).collect();
                points.sort_by(|a, b| a.x.total_cmp(&b.x));
                let count = points.len();
                for column in 0..columns {
                    let of_column = column * count / columns..(column + 1) * count / columns;
                    points[of_column].sort_by(|a, b| a.y.total_cmp(&b.y));
                }
                points
            })
            .collect();
        (0..samples as usize).flat_map(|i| by_cell.iter().map(move |set| self.map_square(set[i]))).collect()
    }

    /// The first `n` points of [`Aperture::lens_point`].
    pub fn lens_points(&self, n: u32) -> Vec<DVec2> {
        (0..n).map(|index| self.lens_point(index)).collect()
    }

    /// Takes uniform points of the unit square to points distributed as the intensity.
    pub(crate) fn map_square(&self, u: DVec2) -> DVec2 {
        match self {
            Self::Disc => disc_from_square(u),
            Self::Polygon { blades, rotation_deg, roundness } => {
                Polygon::new(*blades, *rotation_deg, *roundness).map_disc(disc_from_square(u))
            }
            Self::Gaussian { sigma_per_coc } => gaussian_from_disc(disc_from_square(u), gaussian_sigma(*sigma_per_coc)),
            Self::Image(image) => image.map_square(u),
        }
    }

    /// Whether it stays the same when it is turned.
    pub fn is_round(&self) -> bool {
        match self {
            Self::Disc | Self::Gaussian { .. } => true,
            Self::Polygon { roundness, .. } => *roundness == 1.0,
            Self::Image(_) => false,
        }
    }

    /// Greatest |v| of any lens point: blur ends `radius() * |c| / 2` px from a pixel.
    pub fn radius(&self) -> f64 {
        match self {
            Self::Disc | Self::Polygon { .. } => 1.0,
            Self::Gaussian { sigma_per_coc } => GAUSSIAN_CUT * gaussian_sigma(*sigma_per_coc),
            Self::Image(image) => image.radius(),
        }
    }

    /// Density over the plane of `v`; its integral over the plane is 1.
    pub fn intensity(&self, v: DVec2) -> f64 {
        match self {
            Self::Disc => {
                if v.length_squared() <= 1.0 {
                    FRAC_1_PI
                } else {
                    0.0
                }
            }
            Self::Polygon { blades, rotation_deg, roundness } => {
                Polygon::new(*blades, *rotation_deg, *roundness).intensity(v)
            }
            Self::Gaussian { sigma_per_coc } => gaussian_intensity(v, gaussian_sigma(*sigma_per_coc)),
            Self::Image(image) => image.intensity(v),
        }
    }

    /// Standard deviation of the blur per axis over the CoC diameter: 1/4 for the disc.
    /// For an image whose axes differ, the root of the mean of their variances.
    pub fn sigma_per_coc(&self) -> f64 {
        match self {
            Self::Disc => 0.25,
            // A point v displaces by v * C / 2, so half a standard deviation in v.
            Self::Polygon { blades, rotation_deg, roundness } => {
                0.5 * Polygon::new(*blades, *rotation_deg, *roundness).sigma()
            }
            Self::Gaussian { sigma_per_coc } => *sigma_per_coc,
            Self::Image(image) => 0.5 * image.sigma(),
        }
    }
}

/// The concentric map of Shirley and Chiu, "A Low Distortion Map Between Disk and Square"
/// (1997): keeps areas, and squares about the centre become circles.
fn disc_from_square(u: DVec2) -> DVec2 {
    let p = 2.0 * u - DVec2::ONE;
    if p == DVec2::ZERO {
        return DVec2::ZERO;
    }
    let (radius, angle) =
        if p.x.abs() > p.y.abs() { (p.x, FRAC_PI_4 * (p.y / p.x)) } else { (p.y, FRAC_PI_2 - FRAC_PI_4 * (p.x / p.y)) };
    radius * dvec2(angle.cos(), angle.sin())
}

/// Share of a round Gaussian beyond [`GAUSSIAN_CUT`] standard deviations.
fn gaussian_tail() -> f64 {
    (-0.5 * GAUSSIAN_CUT * GAUSSIAN_CUT).exp()
}

/// Standard deviation in v, before the cut, of the Gaussian that has `sigma_per_coc` after
/// it. With q = cut^2 / 2, the cut leaves the share `1 - q e^-q / (1 - e^-q)` of the
/// variance per axis.
fn gaussian_sigma(sigma_per_coc: f64) -> f64 {
    let q = 0.5 * GAUSSIAN_CUT * GAUSSIAN_CUT;
    let kept_variance = 1.0 - q * gaussian_tail() / (1.0 - gaussian_tail());
    2.0 * sigma_per_coc / kept_variance.sqrt()
}

/// Box and Muller's transform of a uniform point of the disc: the squared radius is
/// uniform in [0, 1], the angle stays.
fn gaussian_from_disc(disc: DVec2, sigma: f64) -> DVec2 {
    let share = disc.length_squared().min(1.0);
    if share == 0.0 {
        return DVec2::ZERO;
    }
    let radius = sigma * (-2.0 * (1.0 - share * (1.0 - gaussian_tail())).ln()).sqrt();
    disc * (radius / disc.length())
}

fn gaussian_intensity(v: DVec2, sigma: f64) -> f64 {
    let squared = v.length_squared() / (sigma * sigma);
    if squared > GAUSSIAN_CUT * GAUSSIAN_CUT {
        return 0.0;
    }
    0.5 * FRAC_1_PI / (sigma * sigma) * (-0.5 * squared).exp() / (1.0 - gaussian_tail())
}
