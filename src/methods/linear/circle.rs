//! Circles of confusion drawn on pixels: section 3.1.2 of the paper, in f64.

/// Half the diagonal of a pixel: a pixel whose centre is farther than this from the
/// circle's edge lies wholly inside or outside ("Adaptive supersampling", Fig. 5).
const HALF_DIAGONAL_PX: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Radius, px, below which a circle lies within its own pixel.
pub const OWN_PIXEL_RADIUS_PX: f64 = 0.5;

/// How the share of a pixel that a circle covers is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coverage {
    /// 1 if the pixel's centre lies in the circle, else 0: aliased, and the total energy
    /// jumps with the radius (Fig. 4).
    Naive,
    /// Sub-pixels at the centres of a regular grid.
    Uniform,
    /// One sub-pixel at a random place in each cell of that grid, the same for all pixels
    /// ("a precomputed set of numbers").
    Jittered,
}

/// How circles are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CircleSampling {
    /// How the share of a pixel that a circle covers is found.
    pub coverage: Coverage,
    /// Sub-pixels along each side of a pixel, at least 1; the paper has 10.
    pub sub_pixels: u32,
}

impl Default for CircleSampling {
    fn default() -> Self {
        Self { coverage: Coverage::Uniform, sub_pixels: 10 }
    }
}

/// Draws circles.
#[derive(Clone, Debug)]
pub struct Circles {
    coverage: Coverage,
    /// Sub-pixels relative to the pixel's centre, px.
    sub_pixels: Vec<[f64; 2]>,
}

impl Circles {
    /// Circles drawn as `sampling` says.
    pub fn new(sampling: CircleSampling) -> Self {
        let sub_pixels = match sampling.coverage {
            Coverage::Naive => Vec::new(),
            Coverage::Uniform => grid(sampling.sub_pixels, |_| [0.5, 0.5]),
            Coverage::Jittered => grid(sampling.sub_pixels, |cell| [random(2 * cell), random(2 * cell + 1)]),
        };
        Self { coverage: sampling.coverage, sub_pixels }
    }

    /// The sub-pixels, px from a pixel's centre; none for [`Coverage::Naive`].
    pub fn sub_pixels(&self) -> &[[f64; 2]] {
        &self.sub_pixels
    }

    /// Share of the pixel `(dx, dy)` px away that a circle of `radius_px` covers.
    pub fn coverage(&self, radius_px: f64, dx: u32, dy: u32) -> f64 {
        let (long, short) = (f64::from(dx.max(dy)), f64::from(dx.min(dy)));
        let distance_px = long.hypot(short);
        if self.coverage == Coverage::Naive {
            return f64::from(u8::from(distance_px < radius_px));
        }
        if distance_px + HALF_DIAGONAL_PX <= radius_px {
            return 1.0;
        }
        if distance_px - HALF_DIAGONAL_PX >= radius_px {
            return 0.0;
        }
        let inside = |[x, y]: &&[f64; 2]| (long + x).powi(2) + (short + y).powi(2) < radius_px * radius_px;
        self.sub_pixels.iter().filter(inside).count() as f64 / self.sub_pixels.len() as f64
    }

    /// Pixels that a circle of `radius_px` covers: the sum of all coverages.
    pub fn area_px2(&self, radius_px: f64) -> f64 {
        let reach = (radius_px + 0.5).ceil() as u32;
        let mut sum = 0.0;
        // One eighth of the plane: coverage depends on the larger and the smaller distance.
        for long in 0..=reach {
            for short in 0..=long {
                let images = match (long, short) {
                    (0, 0) => 1.0,
                    (_, 0) => 4.0,
                    _ if long == short => 4.0,
                    _ => 8.0,
                };
                sum += images * self.coverage(radius_px, long, short);
            }
        }
        sum
    }

    /// Energy that a circle gives to a pixel for each unit of its coverage: 1 over the
    /// circle's area as it is drawn, so that the total is exactly 1; for
    /// [`Coverage::Naive`] the paper's 1/(pi r^2).
    pub fn energy_per_coverage(&self, radius_px: f64) -> f64 {
        match self.coverage {
            Coverage::Naive => 1.0 / disc_area_px2(radius_px),
            _ => 1.0 / self.area_px2(radius_px),
        }
    }

    /// Total energy of a circle whose pixels get coverage/(pi r^2), as printed: 1 but for
    /// what the rasterisation gets wrong. Circles within their own pixel have 1.
    pub fn total_energy_as_printed(&self, radius_px: f64) -> f64 {
        if radius_px < OWN_PIXEL_RADIUS_PX { 1.0 } else { self.area_px2(radius_px) / disc_area_px2(radius_px) }
    }
}

fn disc_area_px2(radius_px: f64) -> f64 {
    std::f64::consts::PI * radius_px * radius_px
}

/// One point in each cell of a grid over a pixel, relative to its centre; `place` puts it
/// in the unit square of its cell.
fn grid(side: u32, place: impl Fn(u32) -> [f64; 2]) -> Vec<[f64; 2]> {
    let point = |cell: u32| {
        let [x, y] = place(cell);
        let axis = |index: u32, at: f64| (f64::from(index) + at) / f64::from(side) - 0.5;
        [axis(cell % side, x), axis(cell / side, y)]
    };
    (0..side * side).map(point).collect()
}

/// A number in [0, 1) for each index: the PCG hash of Jarzynski and Olano, "Hash Functions
/// for GPU Rendering" (2020), to 16 bits.
fn random(index: u32) -> f64 {
    let state = index.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    f64::from(((word >> 22) ^ word) >> 16) / 65536.0
}
