//! Puts quads where a family wants them: in pixels of the frame and pixels of CoC.

use super::spec::{LEAST_DEPTH_PER_FOCUS, Pattern, QuadSpec, SceneSpec};
use crate::random::Random;
use defocus::camera::Projection;
use defocus::lens::CocOfDepth;
use defocus::view::MAX_AUTO_OVERSCAN_PX;
use glam::{DVec2, UVec2, dvec2};
use std::f64::consts::FRAC_PI_4;

/// Full vertical field of view of every scene, degrees.
const FOV_Y_DEG: f64 = 50.0;

/// Share of the frame that discs of small sources cover, times the cube of their width in
/// sides of the source, up to which halves of [`MOST_POINTS`](super::MOST_POINTS) lens
/// points agree to [`AGREEMENT_DB`](super::AGREEMENT_DB).
///
/// Of N/2 points, `n = N/2 / (pi/4 r^2)` meet a source from a pixel of its disc, r sides wide.
/// The number within a box of a (0,2)-sequence is off by about `n^(1/4)`: a share of
/// `e = 0.7 n^(-3/4)`. In display values, whose slope over the logarithm is at most 0.42,
/// two such halves differ by a mean square of `2 (0.42 e)^2 = 1.6e-7 r^3` within discs for
/// N = 16384, and by that times the share of the frame over all of it: 1e-5 is 50 dB.
const MOST_SHARE_TIMES_CUBE: f64 = 60.0;

/// How far beyond the frame, px, a wall reaches: over the widest margin and the widest
/// shift of a lens point.
const WALL_MARGIN_PX: f64 = 200.0;

/// Greatest share of K that a surface's CoC takes: nearer to 1 it is practically the sky.
const GREATEST_COC_PER_K: f64 = 0.98;

/// Significant digits of a coordinate: a hundredth of a pixel at the border of a frame of
/// some hundred.
const COORDINATE_DIGITS: i32 = 5;

/// A parallelogram in the picture whose CoC changes evenly over it: every such one is the
/// image of a flat quad, since the CoC is affine in reciprocal depth.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    /// Its middle, px from the frame's top left.
    pub centre_px: DVec2,
    /// From the middle to the middle of one side, px.
    pub u_px: DVec2,
    /// From the middle to the middle of the next side, px.
    pub v_px: DVec2,
    /// Signed CoC diameter in the middle, px.
    pub coc_px: f64,
    /// By how much it grows along `u_px`, px.
    pub du_coc_px: f64,
    /// By how much it grows along `v_px`, px.
    pub dv_coc_px: f64,
}

impl Patch {
    /// An upright rectangle that faces the lens.
    pub fn upright(centre_px: DVec2, half_px: DVec2, coc_px: f64) -> Self {
        let (u_px, v_px) = (dvec2(half_px.x, 0.0), dvec2(0.0, half_px.y));
        Self { centre_px, u_px, v_px, coc_px, du_coc_px: 0.0, dv_coc_px: 0.0 }
    }

    /// The rectangle between two corners that faces the lens.
    pub fn between(low_px: DVec2, high_px: DVec2, coc_px: f64) -> Self {
        Self::upright((low_px + high_px) * 0.5, (high_px - low_px) * 0.5, coc_px)
    }

    /// The same turned in the picture by an angle in radians.
    pub fn turned(self, angle: f64) -> Self {
        let turn = DVec2::from_angle(angle);
        Self { u_px: turn.rotate(self.u_px), v_px: turn.rotate(self.v_px), ..self }
    }

    /// The same leaning, so that its CoC grows by these along its two directions, px.
    pub fn leaning(self, du_coc_px: f64, dv_coc_px: f64) -> Self {
        Self { du_coc_px, dv_coc_px, ..self }
    }
}

/// Step in depth, a share of it, between quads that overlap and face the lens: several
/// units of a coordinate's last digit.
const LEAST_STEP_IN_DEPTH: f64 = 5e-4;

/// Whether two convex quads meet nowhere, or in an edge: a side of one divides them.
fn apart(one: &[DVec2; 4], other: &[DVec2; 4]) -> bool {
    let divided_by = |sides: &[DVec2; 4]| {
        (0..4).any(|i| {
            let across = (sides[(i + 1) % 4] - sides[i]).perp().normalize_or_zero();
            let ends = |quad: &[DVec2; 4]| {
                let along = quad.map(|p| p.dot(across));
                (along.into_iter().fold(f64::INFINITY, f64::min), along.into_iter().fold(f64::NEG_INFINITY, f64::max))
            };
            let ((low, high), (other_low, other_high)) = (ends(one), ends(other));
            high <= other_low + 1e-6 || other_high <= low + 1e-6
        })
    };
    divided_by(one) || divided_by(other)
}

/// A scene in the making.
pub struct Maker {
    /// The random numbers of this scene.
    pub random: Random,
    /// Size of the frame, px.
    pub size: DVec2,
    projection: Projection,
    /// Corners, px, and depths, metres, of the quads so far that face the lens.
    facing: Vec<([DVec2; 4], f64)>,
    spec: SceneSpec,
}

impl Maker {
    /// Nothing but a black sky.
    pub fn new(name: String, mut random: Random, size: UVec2) -> Self {
        let focus_m = [1.0, 2.0, 4.0][random.index(3)];
        let spec = SceneSpec {
            name,
            size_px: size.to_array(),
            overscan_px: 0,
            fov_y_deg: FOV_Y_DEG,
            focus_m,
            k_px: 8.0,
            sky: [0.0; 3],
            as_image: false,
            quads: Vec::new(),
        };
        let projection = spec.camera().projection(size, 0);
        Self { random, size: size.as_dvec2(), projection, facing: Vec::new(), spec }
    }

    /// Chooses K between two values, px, uniform in the logarithm.
    pub fn k_between(&mut self, low_px: f64, high_px: f64) -> f64 {
        self.spec.k_px = rounded(self.random.log_between(low_px, high_px));
        self.spec.k_px
    }

    /// K, px.
    pub fn k_px(&self) -> f64 {
        self.spec.k_px
    }

    /// The radiance of the sky.
    pub fn sky(&mut self, radiance: [f32; 3]) {
        self.spec.sky = radiance;
    }

    /// Hands methods the picture with its depth only.
    pub fn as_image(&mut self) {
        self.spec.as_image = true;
    }

    /// A signed CoC that a surface behind the focus may have, px: from 0 to nearly K.
    pub fn far_coc_px(&mut self) -> f64 {
        let share = self.random.between(0.0, GREATEST_COC_PER_K);
        share * self.k_px()
    }

    /// A depth in metres with that CoC, as far as there is one.
    fn depth_m(&self, coc_px: f64) -> f64 {
        let k_px = self.k_px();
        let coc = CocOfDepth { k_px, k_df_px_m: k_px * self.spec.focus_m };
        let depth_m = coc.depth_at(coc_px.min(GREATEST_COC_PER_K * k_px));
        rounded_to(depth_m.max(LEAST_DEPTH_PER_FOCUS * self.spec.focus_m), COORDINATE_DIGITS)
    }

    /// That depth, or one just before it: two that overlap in one plane would be seen in no
    /// certain order.
    fn own_depth_m(&mut self, corners_px: &[DVec2; 4], depth_m: f64) -> f64 {
        let taken = |depth_m: f64| {
            let close = |other_m: f64| (other_m / depth_m - 1.0).abs() < 0.5 * LEAST_STEP_IN_DEPTH;
            self.facing.iter().any(|(corners, other_m)| close(*other_m) && !apart(corners, corners_px))
        };
        let mut own_m = depth_m;
        while taken(own_m) {
            own_m = rounded_to(own_m * (1.0 - LEAST_STEP_IN_DEPTH), COORDINATE_DIGITS);
        }
        self.facing.push((*corners_px, own_m));
        own_m
    }

    fn corner_m(&self, at_px: DVec2, depth_m: f64) -> [f64; 3] {
        let slope = self.projection.view_direction(at_px);
        let metres = |slope: f64| rounded_to(slope * depth_m, COORDINATE_DIGITS);
        [metres(slope.x), metres(slope.y), depth_m]
    }

    /// Adds a quad.
    pub fn add(&mut self, patch: Patch, radiance: [f32; 3], pattern: Pattern) {
        self.push(patch, radiance, pattern, false);
    }

    /// Adds a quad that counts as a light.
    pub fn add_light(&mut self, patch: Patch, radiance: [f32; 3]) {
        self.push(patch, radiance, Pattern::Plain, true);
    }

    fn push(&mut self, patch: Patch, radiance: [f32; 3], pattern: Pattern, light: bool) {
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let corners_px = corners.map(|(i, j)| patch.centre_px + patch.u_px * i + patch.v_px * j);
        let mut depths_m = corners.map(|(i, j)| self.depth_m(patch.coc_px + patch.du_coc_px * i + patch.dv_coc_px * j));
        if depths_m.iter().all(|depth_m| *depth_m == depths_m[0]) {
            depths_m = [self.own_depth_m(&corners_px, depths_m[0]); 4];
        }
        let corners_m = [0, 1, 2, 3].map(|i| self.corner_m(corners_px[i], depths_m[i]));
        self.spec.quads.push(QuadSpec { corners_m, radiance, pattern, light });
    }

    /// A wall over all of the frame and beyond.
    pub fn wall(&mut self, coc_px: f64, radiance: [f32; 3], pattern: Pattern) {
        let patch = Patch::upright(self.size * 0.5, self.size * 0.5 + WALL_MARGIN_PX, coc_px);
        self.add(patch, radiance, pattern);
    }

    /// A wall of one of the kinds that there are: plain, a gradient, cells.
    pub fn any_wall(&mut self, coc_px: f64) {
        let radiance = self.dim_color();
        match self.random.index(4) {
            0 | 1 => self.wall(coc_px, radiance, Pattern::Plain),
            2 => {
                let other = self.dim_color();
                self.wall(coc_px, radiance, Pattern::Gradient { other });
            }
            _ => {
                let cell_px = self.random.log_between(3.0, 16.0);
                self.checkered_wall(coc_px, cell_px);
            }
        }
    }

    /// A wall of cells about `cell_px` wide.
    pub fn checkered_wall(&mut self, coc_px: f64, cell_px: f64) {
        let [radiance, other] = self.contrast();
        let sides = self.size + 2.0 * WALL_MARGIN_PX;
        let cells = (sides / cell_px).round().as_uvec2().clamp(UVec2::ONE, UVec2::splat(super::spec::MOST_CELLS));
        self.wall(coc_px, radiance, Pattern::Checker { cells: cells.to_array(), other });
    }

    /// A pattern of a thing about `side_px` large.
    pub fn any_pattern(&mut self, side_px: f64) -> Pattern {
        let other = self.dim_color();
        match self.random.index(3) {
            0 => Pattern::Plain,
            1 => Pattern::Gradient { other },
            _ => {
                let most = (side_px / 3.0).clamp(1.0, 12.0);
                let cells = [0; 2].map(|_| self.random.between(1.0, most).round() as u32);
                Pattern::Checker { cells, other }
            }
        }
    }

    /// A colour that a lit surface may have: 0.02 to 1, with a tint.
    pub fn dim_color(&mut self) -> [f32; 3] {
        let radiance = self.random.log_between(0.02, 1.0);
        self.tinted(radiance)
    }

    /// Two colours with a good contrast, in either order.
    pub fn contrast(&mut self) -> [[f32; 3]; 2] {
        let (dark, bright) = (self.random.between(0.0, 0.15), self.random.between(0.4, 1.0));
        let both = [self.tinted(dark), self.tinted(bright)];
        if self.random.index(2) == 0 { both } else { [both[1], both[0]] }
    }

    /// About `radiance`, with a tint.
    pub fn tinted(&mut self, radiance: f64) -> [f32; 3] {
        [0; 3].map(|_| rounded(radiance * self.random.between(0.6, 1.0)) as f32)
    }

    /// A point of the frame, px, `margin_px` away from its border.
    pub fn in_frame(&mut self, margin_px: f64) -> DVec2 {
        let mut along = |side: f64| self.random.between(margin_px.min(side * 0.5), (side - margin_px).max(side * 0.5));
        dvec2(along(self.projection.size.x.into()), along(self.projection.size.y.into()))
    }

    /// One of two signs.
    pub fn sign(&mut self) -> f64 {
        if self.random.index(2) == 0 { -1.0 } else { 1.0 }
    }

    /// A CoC diameter between two values, px, uniform in the logarithm, but no wider than a
    /// reference converges for that many sources with sides of `side_px`.
    pub fn coc_of_sources_px(&mut self, count: usize, side_px: f64, low_px: f64, high_px: f64) -> f64 {
        // All discs cover `count * pi/4 (r side)^2` of the frame.
        let covered_px = count as f64 * FRAC_PI_4 * side_px.powi(2);
        let widest = (MOST_SHARE_TIMES_CUBE * self.size.x * self.size.y / covered_px).powf(0.2);
        let high_px = high_px.min(widest * side_px);
        self.random.log_between(low_px.min(high_px), high_px)
    }

    /// The scene, with as much margin as its greatest CoC asks for.
    pub fn made(self) -> SceneSpec {
        let mut spec = self.spec;
        let lens = spec.lens();
        let greatest_px = spec.quads.iter().flat_map(|q| q.coc_px(&lens)).fold(0.0, |most: f64, c| most.max(c.abs()));
        let overscan_px = (0.5 * greatest_px).ceil().min(f64::from(MAX_AUTO_OVERSCAN_PX)) as u32;
        spec.overscan_px = if spec.as_image { 0 } else { overscan_px };
        spec
    }
}

/// Four significant digits: what is printed is what is drawn, and can be read.
pub fn rounded(value: f64) -> f64 {
    rounded_to(value, 4)
}

/// As many significant digits.
pub fn rounded_to(value: f64, digits: i32) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    let exponent = value.abs().log10().floor() as i32;
    let power = digits - 1 - exponent;
    // A division by a power of ten gives the nearest number with that many digits; a
    // multiplication by a negative power does not.
    if power >= 0 {
        let scale = 10_f64.powi(power);
        (value * scale).round() / scale
    } else {
        let scale = 10_f64.powi(-power);
        (value / scale).round() * scale
    }
}
