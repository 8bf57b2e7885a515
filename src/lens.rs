//! The thin lens, once, for every method: f64 and free of any GPU.
//!
//! Symbols are those of Lee, Kim and Choi, "Real-Time Depth-of-Field Rendering Using
//! Anisotropically Filtered Mipmap Interpolation" (TVCG 2009), section 3.2:
//! E, F, dr, ds, DPI and df. With depth d along the optical axis,
//!
//! ```text
//! K    = DPI * (ds / dr) * E * F / (df - F)      [px]    needs df > F
//! c(d) = K * (1 - df / d)                        [px]    signed CoC diameter
//! ```
//!
//! which is equations (3) and (4) of that paper with the sign kept: c < 0 in front of
//! the focus distance, c > 0 behind it, c -> K at infinity.

use crate::aperture::{Aperture, ApertureError};
use crate::eye::{Eye, EyeError};
use glam::{DMat2, DVec2};

/// Millimetres in a metre: lenses are given in millimetres, scenes in metres.
pub const MM_PER_M: f64 = 1000.0;

/// CoC diameter, px, to which shaders cut greater ones: a lens may ask for any, but what is
/// wider than four of the widest images looks the same, and an intermediate in f16 ends at
/// 65504. `GREATEST_COC` in `shaders/lib/lens.wgsl`.
pub const GREATEST_COC_PX: f64 = 30000.0;

/// A lens (or eye), the display its image is shown on, and where it is focused.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Lens {
    /// E: effective diameter of the aperture (the pupil), mm; 0 is a pinhole.
    #[serde(rename = "E")]
    pub aperture_diameter_mm: f64,
    /// F: focal length, mm.
    #[serde(rename = "F")]
    pub focal_length_mm: f64,
    /// dr: distance from the lens to the image plane (the retina, the sensor), mm.
    #[serde(rename = "dr")]
    pub image_distance_mm: f64,
    /// ds: distance from the lens to the screen on which the image is shown, mm.
    #[serde(rename = "ds")]
    pub screen_distance_mm: f64,
    /// DPI: pixel density of that screen, px per mm.
    #[serde(rename = "dpi")]
    pub density_px_per_mm: f64,
    /// df: focus distance, metres in the scene; may be infinite.
    #[serde(rename = "focus_m")]
    pub focus_distance_m: f64,
    /// The intensity distribution over the aperture.
    #[serde(default)]
    pub aperture: Aperture,
    /// What an eye adds: a prescription, a limit of accommodation, chromatic aberration.
    #[serde(default, skip_serializing_if = "Eye::is_plain")]
    pub eye: Eye,
}

/// To a ten thousandth, for people.
fn rounded_mm(mm: f64) -> f64 {
    (1e4 * mm).round() / 1e4
}

/// What makes a lens impossible: which value, and which bound it breaks.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LensError {
    /// A value that is NaN or infinite where it must not be.
    #[error("{symbol} ({name}) is {value}: it must be a finite number")]
    NotFinite {
        /// The papers' symbol.
        symbol: &'static str,
        /// What the symbol stands for.
        name: &'static str,
        /// The value given.
        value: f64,
    },
    /// A value at or below its lower bound.
    #[error("{symbol} ({name}) is {value} {unit}: it must be {bound}")]
    OutOfBounds {
        /// The papers' symbol.
        symbol: &'static str,
        /// What the symbol stands for.
        name: &'static str,
        /// The value given, in `unit`.
        value: f64,
        /// Unit of `value`.
        unit: &'static str,
        /// The bound in words, such as "above 0".
        bound: &'static str,
    },
    /// The focus distance does not exceed the focal length: no image forms.
    #[error(
        "focus distance df = {} mm does not exceed the focal length F = {} mm, \
         so no image forms: move the focus farther or choose a shorter focal length",
        rounded_mm(*focus_distance_mm),
        rounded_mm(*focal_length_mm)
    )]
    FocusInsideFocalLength {
        /// df, mm.
        focus_distance_mm: f64,
        /// F, mm.
        focal_length_mm: f64,
    },
    /// An aperture with a parameter outside its range.
    #[error(transparent)]
    Aperture(#[from] ApertureError),
    /// An eye that cannot be.
    #[error(transparent)]
    Eye(#[from] EyeError),
}

/// The signed CoC diameter as an affine function of reciprocal depth:
/// `c = k_px - k_df_px_m / d`. With the reversed infinite depth buffer `z = near / d`
/// this is `c = k_px - (k_df_px_m / near) * z`: no division, exact at infinity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CocOfDepth {
    /// K, the CoC diameter at infinity, px.
    pub k_px: f64,
    /// K * df, px m; finite even where df is not.
    pub k_df_px_m: f64,
}

impl CocOfDepth {
    /// Signed CoC diameter, px, at depth `d_m` metres (may be infinite).
    pub fn at_depth(&self, d_m: f64) -> f64 {
        self.k_px - self.k_df_px_m / d_m
    }

    /// The factor of the stored depth `z = near / d`, px: `c = k_px - slope * z`.
    pub fn slope_px(&self, near_m: f64) -> f64 {
        self.k_df_px_m / near_m
    }

    /// Signed CoC diameter, px, at the stored depth `z = near / d`.
    pub fn at_stored(&self, z: f64, near_m: f64) -> f64 {
        self.k_px - self.slope_px(near_m) * z
    }

    /// Depth, metres, at which the signed CoC diameter is `c_px`; infinite at or beyond K.
    pub fn depth_at(&self, c_px: f64) -> f64 {
        if c_px >= self.k_px { f64::INFINITY } else { self.k_df_px_m / (self.k_px - c_px) }
    }
}

/// Mean and extremes of the CoC over an image.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct CocStatistics {
    /// Mean of the CoC diameter |c|, px: the papers' control variable.
    pub mean_px: f64,
    /// 95th percentile of |c|, px.
    pub p95_px: f64,
    /// Least signed CoC diameter, px.
    pub min_signed_px: f64,
    /// Greatest signed CoC diameter, px.
    pub max_signed_px: f64,
}

impl CocStatistics {
    /// Greatest CoC diameter |c|, px.
    pub fn greatest_px(&self) -> f64 {
        self.min_signed_px.abs().max(self.max_signed_px.abs())
    }
}

impl Lens {
    /// A lens with a closed aperture: no blur at any depth.
    pub const PINHOLE: Self = Self {
        aperture_diameter_mm: 0.0,
        focal_length_mm: 17.0,
        image_distance_mm: 24.0,
        screen_distance_mm: 3000.0,
        density_px_per_mm: 0.32,
        focus_distance_m: 3.0,
        aperture: Aperture::Disc,
        eye: Eye::PLAIN,
    };

    /// Focus distance df, mm.
    pub(crate) fn focus_distance_mm(&self) -> f64 {
        self.focus_distance_m * MM_PER_M
    }

    /// Errors unless the lens can form an image: finite values, E >= 0, the others
    /// positive, df > F, an aperture within its ranges.
    pub fn check(&self) -> Result<(), LensError> {
        let values = [
            ("E", "aperture diameter", self.aperture_diameter_mm),
            ("F", "focal length", self.focal_length_mm),
            ("dr", "distance to the image plane", self.image_distance_mm),
            ("ds", "distance to the screen", self.screen_distance_mm),
            ("DPI", "pixel density", self.density_px_per_mm),
        ];
        for (symbol, name, value) in values {
            if !value.is_finite() {
                return Err(LensError::NotFinite { symbol, name, value });
            }
            let unit = if symbol == "DPI" { "px/mm" } else { "mm" };
            if symbol == "E" && value < 0.0 {
                return Err(LensError::OutOfBounds { symbol, name, value, unit, bound: "0 or more" });
            }
            if symbol != "E" && value <= 0.0 {
                return Err(LensError::OutOfBounds { symbol, name, value, unit, bound: "above 0" });
            }
        }
        if self.focus_distance_m.is_nan() {
            let value = self.focus_distance_m;
            return Err(LensError::NotFinite { symbol: "df", name: "focus distance", value });
        }
        if self.focus_distance_mm() <= self.focal_length_mm {
            return Err(LensError::FocusInsideFocalLength {
                focus_distance_mm: self.focus_distance_mm(),
                focal_length_mm: self.focal_length_mm,
            });
        }
        // Each value may be finite and their product still not be: the shaders need it.
        if !(self.k_df_px_mm().is_finite() && self.k_px().is_finite()) {
            let value = self.k_df_px_mm();
            return Err(LensError::NotFinite { symbol: "K", name: "CoC diameter at infinity", value });
        }
        self.aperture.check()?;
        self.eye.check()?;
        Ok(())
    }

    /// Vergence of the focus distance that is asked for, D.
    fn wanted_d(&self) -> f64 {
        1.0 / self.focus_distance_m
    }

    /// Vergence, D, of what is sharp: that of the focus distance, unless the eye cannot focus
    /// there. Less than 0 where no real distance is sharp. With chromatic aberration it is
    /// green's.
    pub fn focus_d(&self) -> f64 {
        self.eye.focus_d(self.wanted_d())
    }

    /// Distance, metres, of what is sharp; infinite also where no real distance is.
    pub fn sharpest_m(&self) -> f64 {
        match self.is_focused_as_wanted() {
            true => self.focus_distance_m,
            false if self.focus_d() > 0.0 => 1.0 / self.focus_d(),
            false => f64::INFINITY,
        }
    }

    /// Whether what is sharp lies at the focus distance.
    fn is_focused_as_wanted(&self) -> bool {
        self.focus_d() == self.wanted_d()
    }

    /// `near / d` of what is sharp, for the reversed depth buffer: less than 0 where no real
    /// distance is.
    pub fn stored_focus(&self, near_m: f64) -> f64 {
        // One rounding, so that a plane at the focus distance is in focus to the last bit.
        if self.is_focused_as_wanted() { near_m / self.focus_distance_m } else { near_m * self.focus_d() }
    }

    /// Lenses through which one primary each is seen, red, green and blue; `None` without
    /// chromatic aberration.
    pub fn primaries(&self) -> Option<[Self; 3]> {
        let of = |eye: Eye| Self { eye, ..self.clone() };
        Some(self.eye.primaries()?.map(of))
    }

    /// Of the lens of one primary the lens for light as a whole; else itself.
    pub fn of_all_primaries(&self) -> Self {
        Self { eye: Eye { shift_d: 0.0, farthest_shift_d: 0.0, ..self.eye }, ..self.clone() }
    }

    /// Of the lens of one primary that of the primary which is sharp farthest away: in front of the
    /// focus it blurs most. Else itself.
    pub fn of_farthest_primary(&self) -> Self {
        Self { eye: Eye { shift_d: self.eye.farthest_shift_d, ..self.eye }, ..self.clone() }
    }

    /// CoC diameter, px, that a dioptre of defocus makes: K df, in px m.
    pub fn px_per_dioptre(&self) -> f64 {
        self.coc().k_df_px_m
    }

    /// What astigmatism adds to the CoC, px, as a matrix on lens points: a point with CoC c is
    /// seen from the lens point v at `p0 + (c v + A v) / 2`. The same at every depth.
    pub fn astigmatism_px(&self) -> DMat2 {
        self.eye.refraction.astigmatism_d() * self.px_per_dioptre()
    }

    /// The greater eigenvalue of [`Lens::astigmatism_px`], px: the diameters of the ellipse that a
    /// point with CoC c blurs to are `|c| + a` and `||c| - a|`. 0 without astigmatism.
    pub fn greatest_astigmatism_px(&self) -> f64 {
        self.astigmatism_px().x_axis.length()
    }

    /// The one of the ellipse's two axes that is nearer to the x axis, as a unit vector, and the
    /// eigenvalue of [`Lens::astigmatism_px`] that belongs to it, px; that of the other axis is its
    /// opposite. The x axis and 0 without astigmatism.
    pub fn meridian(&self) -> (DVec2, f64) {
        let matrix = self.astigmatism_px();
        let (greatest, double) = (self.greatest_astigmatism_px(), matrix.x_axis);
        if greatest == 0.0 {
            return (DVec2::X, 0.0);
        }
        // The eigenvector of the greater eigenvalue has half the angle of the first column; the other
        // axis, a right angle away, half that of its opposite.
        let (double, own) = if double.x < 0.0 { (-double, -greatest) } else { (double, greatest) };
        (DVec2::from_angle(0.5 * double.y.atan2(double.x)), own)
    }

    /// DPI * ds/dr * E * F, px mm: K * (df - F).
    fn strength_px_mm(&self) -> f64 {
        self.density_px_per_mm
            * (self.screen_distance_mm / self.image_distance_mm)
            * self.aperture_diameter_mm
            * self.focal_length_mm
    }

    /// K: CoC diameter at infinity, px. TVCG 2009, equations (3) and (4).
    ///
    /// In general it is `K df` times the vergence of what is sharp: the image plane stays
    /// where it is while the eye falls short of its focus, and so does `K df`.
    pub fn k_px(&self) -> f64 {
        if self.is_focused_as_wanted() {
            return self.strength_px_mm() / (self.focus_distance_mm() - self.focal_length_mm);
        }
        self.k_df_px_mm() / MM_PER_M * self.focus_d()
    }

    /// K * df, px mm, also where df is infinite.
    fn k_df_px_mm(&self) -> f64 {
        self.strength_px_mm() / (1.0 - self.focal_length_mm / self.focus_distance_mm())
    }

    /// The CoC as an affine function of reciprocal depth.
    pub fn coc(&self) -> CocOfDepth {
        CocOfDepth { k_px: self.k_px(), k_df_px_m: self.k_df_px_mm() / MM_PER_M }
    }

    /// c(d): signed CoC diameter, px, at depth `d_m` metres.
    pub fn coc_diameter_px(&self, d_m: f64) -> f64 {
        self.coc().at_depth(d_m)
    }

    /// A: diameter of the aperture in scene units, metres, that blurs a projection with
    /// `focal_px` by exactly c(d): `A = K * df / focal_px`, which is the design's
    /// `2 K df tan(fovx/2) / W`. The multi-view methods and references use this one, so
    /// that every method blurs by the same pixels whether or not the display is "true".
    pub fn aperture_diameter_m(&self, focal_px: f64) -> f64 {
        self.coc().k_df_px_m / focal_px
    }

    /// The nearest and farthest depth, metres, at which the CoC diameter stays within
    /// `acceptable_px`. The far limit is infinite at and beyond the hyperfocal distance.
    pub fn depth_of_field_m(&self, acceptable_px: f64) -> (f64, f64) {
        let coc = self.coc();
        if coc.k_df_px_m == 0.0 {
            return (0.0, f64::INFINITY);
        }
        (coc.depth_at(-acceptable_px), coc.depth_at(acceptable_px))
    }

    /// The nearest focus distance, metres, at which infinity is blurred by no more than
    /// `acceptable_px`: K(df) = acceptable.
    pub fn hyperfocal_m(&self, acceptable_px: f64) -> f64 {
        (self.strength_px_mm() / acceptable_px + self.focal_length_mm) / MM_PER_M
    }

    /// f-number F/E; infinite for a pinhole.
    pub fn f_number(&self) -> f64 {
        self.focal_length_mm / self.aperture_diameter_mm
    }

    /// Horizontal field of view, radians, at which an image of `width_px` on this display
    /// shows what the eye at `ds` would see: `2 atan(W / (2 DPI ds))`.
    pub fn display_fov_x(&self, width_px: u32) -> f64 {
        2.0 * (f64::from(width_px) / (2.0 * self.density_px_per_mm * self.screen_distance_mm)).atan()
    }

    /// The same lens with the display's pixel density such that an image of `width_px` spans
    /// the horizontal field of view `fov_x` (radians, in (0, pi)) as seen from `ds`: the
    /// inverse of [`Lens::display_fov_x`].
    pub fn with_display_fov_x(&self, width_px: u32, fov_x: f64) -> Self {
        let screen_mm = 2.0 * self.screen_distance_mm * (0.5 * fov_x).tan();
        Self { density_px_per_mm: f64::from(width_px) / screen_mm, ..self.clone() }
    }

    /// The same lens with E such that F/E is `f_number`; a pinhole where that is infinite.
    pub fn with_f_number(&self, f_number: f64) -> Self {
        Self { aperture_diameter_mm: self.focal_length_mm / f_number, ..self.clone() }
    }

    /// Pixels of the display in a degree of the eye's view, at the middle of the screen.
    pub fn px_per_degree(&self) -> f64 {
        self.density_px_per_mm * self.screen_distance_mm * 1_f64.to_radians()
    }

    /// What `px` on the display measure on the image plane (the retina, the sensor), mm.
    pub fn on_image_plane_mm(&self, px: f64) -> f64 {
        px / self.density_px_per_mm * (self.image_distance_mm / self.screen_distance_mm)
    }

    /// The angle, arc minutes, under which the eye sees `px` at the middle of the display.
    pub fn arc_minutes(&self, px: f64) -> f64 {
        2.0 * (0.5 * px / (self.density_px_per_mm * self.screen_distance_mm)).atan().to_degrees() * 60.0
    }

    /// CoC statistics over depths in metres; `None` for no depths.
    pub fn coc_statistics(&self, depths_m: impl IntoIterator<Item = f32>) -> Option<CocStatistics> {
        let coc = self.coc();
        let mut diameters: Vec<f64> = Vec::new();
        let (mut min, mut max) = (f64::INFINITY, f64::NEG_INFINITY);
        for d in depths_m {
            let c = coc.at_depth(f64::from(d));
            (min, max) = (min.min(c), max.max(c));
            diameters.push(c.abs());
        }
        if diameters.is_empty() {
            return None;
        }
        let mean_px = diameters.iter().sum::<f64>() / diameters.len() as f64;
        let rank = ((diameters.len() - 1) as f64 * 0.95).round() as usize;
        let (_, &mut p95_px, _) = diameters.select_nth_unstable_by(rank, f64::total_cmp);
        Some(CocStatistics { mean_px, p95_px, min_signed_px: min, max_signed_px: max })
    }

    /// The same lens with E scaled so that the mean CoC diameter over `depths_m` is
    /// `mean_px`; `None` where no E does that (everything lies at the focus distance).
    pub fn with_mean_coc(&self, mean_px: f64, depths_m: impl IntoIterator<Item = f32>) -> Option<Self> {
        let unit = Self { aperture_diameter_mm: 1.0, ..self.clone() };
        let statistics = unit.coc_statistics(depths_m)?;
        // Depths in f32 miss the focus by their rounding: a blur of that is none.
        let greatest_px = statistics.min_signed_px.abs().max(statistics.max_signed_px.abs());
        if greatest_px <= unit.k_px() * f64::from(f32::EPSILON) {
            return None;
        }
        let aperture_diameter_mm = mean_px / statistics.mean_px;
        aperture_diameter_mm.is_finite().then(|| Self { aperture_diameter_mm, ..self.clone() })
    }
}
