//! A regular polygon with straight or rounded blades.
//!
//! With `phi` the angle from the middle of a blade, the edge lies at
//! `r(phi) = straight / cos(phi) + round`, where `straight = (1 - roundness) cos(pi / N)`
//! and `round = roundness`: corners at distance 1 for every roundness.

use glam::{DVec2, dvec2};
use std::f64::consts::{FRAC_PI_2, PI};

pub(super) struct Polygon {
    /// Half the angle of a blade, radians.
    half_angle: f64,
    /// Angle of a corner, radians.
    corner_angle: f64,
    straight: f64,
    round: f64,
}

impl Polygon {
    pub(super) fn new(blades: u32, rotation_deg: f64, roundness: f64) -> Self {
        let half_angle = PI / f64::from(blades);
        Self {
            half_angle,
            // Up is -y in image orientation, and growing angles turn clockwise.
            corner_angle: rotation_deg.to_radians() - FRAC_PI_2,
            straight: (1.0 - roundness) * half_angle.cos(),
            round: roundness,
        }
    }

    fn edge(&self, phi: f64) -> f64 {
        self.straight / phi.cos() + self.round
    }

    /// Twice the area between the blade's middle and `phi`: the integral of the squared edge.
    fn twice_area(&self, phi: f64) -> f64 {
        let (s, r) = (self.straight, self.round);
        s * s * phi.tan() + 2.0 * s * r * phi.sin().atanh() + r * r * phi
    }

    /// Angle from the middle of its blade, and the middle's own angle.
    fn blade_of(&self, angle: f64) -> (f64, f64) {
        let blade = 2.0 * self.half_angle;
        let middle = self.corner_angle + self.half_angle;
        let nearest = ((angle - middle) / blade).round() * blade + middle;
        (angle - nearest, nearest)
    }

    /// Takes the unit disc to the polygon so that areas keep their ratios: each disc
    /// sector goes to the sector with the same share of the area, and rays are scaled.
    pub(super) fn map_disc(&self, disc: DVec2) -> DVec2 {
        let (phi, middle) = self.blade_of(disc.y.atan2(disc.x));
        let target = phi / self.half_angle * self.twice_area(self.half_angle);
        let phi = self.solve_area(target);
        let angle = middle + phi;
        disc.length() * self.edge(phi) * dvec2(angle.cos(), angle.sin())
    }

    /// The angle at which [`Self::twice_area`] is `target`: Newton's method, which
    /// converges from any start inside the blade because the function is odd and convex
    /// on one side; 8 steps reach the last bits also for the triangle.
    fn solve_area(&self, target: f64) -> f64 {
        let mut phi = target / self.twice_area(self.half_angle) * self.half_angle;
        for _ in 0..8 {
            let edge = self.edge(phi);
            phi = (phi - (self.twice_area(phi) - target) / (edge * edge)).clamp(-self.half_angle, self.half_angle);
        }
        phi
    }

    pub(super) fn intensity(&self, v: DVec2) -> f64 {
        let (phi, _) = self.blade_of(v.y.atan2(v.x));
        if v.length() > self.edge(phi) {
            return 0.0;
        }
        // 2 N half blades make the whole, and N = pi / half_angle.
        self.half_angle / (PI * self.twice_area(self.half_angle))
    }

    /// Standard deviation per axis; the same in all directions from three blades on.
    pub(super) fn sigma(&self) -> f64 {
        let (s, r, phi) = (self.straight, self.round, self.half_angle);
        // Integrals of the powers of 1/cos from 0 to phi.
        let tan = phi.tan();
        let sec1 = phi.sin().atanh();
        let sec3 = 0.5 * (tan / phi.cos() + sec1);
        let sec4 = tan + tan.powi(3) / 3.0;
        let fourth = s.powi(4) * sec4
            + 4.0 * s.powi(3) * r * sec3
            + 6.0 * (s * r).powi(2) * tan
            + 4.0 * s * r.powi(3) * sec1
            + r.powi(4) * phi;
        // E|v|^2 = (fourth / 4) / (twice_area / 2), half of it for either axis.
        (0.25 * fourth / self.twice_area(phi)).sqrt()
    }
}
