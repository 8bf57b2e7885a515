//! The triangles in front of the camera, in view space, and the nearest one along a ray.
//!
//! The hierarchy is the eight-wide compressed one of Ylitie, Karras and Laine 2017 as
//! `obvhs` builds it: f32 boxes, 80 bytes a node. The triangles themselves are intersected
//! in f64 with the watertight test of Woop, Benthin and Wald, "Watertight Ray/Triangle
//! Intersection" (JCGT 2013): no ray slips between two triangles that share an edge.

use glam::{DVec2, DVec3, Vec3, Vec3A, dvec3, vec3a};
use obvhs::aabb::Aabb;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::cwbvh::{CwBvh, bvh2_to_cwbvh::bvh2_to_cwbvh};
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use obvhs::ray::{Ray, RayHit};

/// Share of the nodes that the builder tries to place better: what `obvhs` calls a medium
/// build, 0.05, costs a second at a million triangles and returns it within ten lens points.
const REINSERTION_RATIO: f32 = 0.05;

/// Boxes are widened by this part of their farthest coordinate, eight units in the last
/// place of f32: `obvhs` tests boxes in f32 and a box must never reject what the f64
/// triangle inside it would accept.
const BOX_PADDING: f32 = 1.0 / (1 << 20) as f32;

/// A triangle in view space with the place it came from.
#[derive(Clone, Copy)]
pub(super) struct Triangle {
    /// Corners in the mesh's order, in units of the near distance.
    pub corners: [Vec3; 3],
    /// Index of the instance in the scene.
    pub instance: u32,
    /// Index of the triangle in its mesh.
    pub triangle: u32,
}

/// A ray `(origin, 0) + t * (slope, -1)` in view space: `t` is the depth along the axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct LensRay {
    /// Where it leaves the lens, units of the near distance.
    pub origin: DVec2,
    /// Its x and y a unit of depth.
    pub slope: DVec2,
    /// Nothing nearer than this depth is hit.
    pub min_depth: f64,
}

/// Where a ray met a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    /// Depth along the axis, units of the near distance.
    pub depth: f64,
    /// Barycentric weights of the corners.
    pub weights: DVec3,
    /// Whether the corners run counter-clockwise as the ray sees them.
    pub counter_clockwise: bool,
}

/// The nearest accepted crossing of a ray, and with what.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    pub crossing: Crossing,
    pub instance: u32,
    pub triangle: u32,
}

/// Triangles in the order of the hierarchy's leaves, and the hierarchy.
pub(super) struct Triangles {
    triangles: Vec<Triangle>,
    hierarchy: CwBvh,
}

impl Triangles {
    /// Builds the hierarchy.
    pub fn new(triangles: Vec<Triangle>) -> Self {
        if triangles.is_empty() {
            return Self { triangles, hierarchy: CwBvh::default() };
        }
        let boxes: Vec<Aabb> = triangles.iter().map(Triangle::padded_box).collect();
        let ids = (0..triangles.len() as u32).collect();
        let mut binary = PlocBuilder::with_capacity(boxes.len()).build(
            PlocSearchDistance::Medium,
            &boxes,
            ids,
            SortPrecision::U64,
            3,
        );
        drop(boxes);
        ReinsertionOptimizer::default().run(&mut binary, REINSERTION_RATIO, None);
        let mut hierarchy = bvh2_to_cwbvh(&binary, 3, true, false);
        // In leaf order the triangles of a leaf lie side by side and need no index.
        let in_leaf_order = std::mem::take(&mut hierarchy.primitive_indices);
        let triangles = in_leaf_order.iter().map(|&i| triangles[i as usize]).collect();
        Self { triangles, hierarchy }
    }

    /// How many triangles there are.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// The nearest crossing that `accept` does not let pass.
    pub fn nearest(&self, ray: &LensRay, accept: impl Fn(&Triangle, &Crossing) -> bool) -> Option<Hit> {
        if self.triangles.is_empty() {
            return None;
        }
        let origin = vec3a(ray.origin.x as f32, ray.origin.y as f32, 0.0);
        // + 0.0 turns -0.0 into 0.0: `obvhs` takes the former's reciprocal for negative and
        // its direction for positive, and so misses everything.
        let direction = vec3a(ray.slope.x as f32 + 0.0, ray.slope.y as f32 + 0.0, -1.0);
        let box_ray = Ray::new(origin, direction, 0.0, f32::INFINITY);
        let mut best: Option<Hit> = None;
        let mut best_depth = f64::INFINITY;
        self.hierarchy.ray_traverse(box_ray, &mut RayHit::none(), |_, index| {
            let triangle = &self.triangles[index];
            match triangle.cross(ray, best_depth) {
                Some(crossing) if accept(triangle, &crossing) => {
                    best_depth = crossing.depth;
                    best = Some(Hit { crossing, instance: triangle.instance, triangle: triangle.triangle });
                    // Rounded up, so that what lies between the two is still looked at.
                    (crossing.depth as f32).next_up()
                }
                _ => f32::INFINITY,
            }
        });
        best
    }
}

impl Triangle {
    fn padded_box(&self) -> Aabb {
        let points = self.corners.map(Vec3A::from);
        let tight = Aabb::from_points(&points);
        let padding = Vec3A::splat(tight.min.abs().max(tight.max.abs()).max_element() * BOX_PADDING);
        Aabb::new(tight.min - padding, tight.max + padding)
    }

    /// Where the ray crosses the triangle, between its least depth and `max_depth`.
    ///
    /// Written out in scalars: this is the inner loop of the tracer.
    fn cross(&self, ray: &LensRay, max_depth: f64) -> Option<Crossing> {
        let (ox, oy, sx, sy) = (ray.origin.x, ray.origin.y, ray.slope.x, ray.slope.y);
        // Corners sheared along the ray, so that it runs down the axis through (0, 0).
        let sheared = |p: &Vec3| {
            let z = f64::from(p.z);
            (f64::from(p.x) - ox + z * sx, f64::from(p.y) - oy + z * sy)
        };
        let [a, b, c] = &self.corners;
        let ((ax, ay), (bx, by), (cx, cy)) = (sheared(a), sheared(b), sheared(c));
        // Two triangles compute the very same products for the edge they share, with
        // opposite signs: a point on it is inside at least one of them.
        let wa = bx * cy - by * cx;
        let wb = cx * ay - cy * ax;
        let wc = ax * by - ay * bx;
        let inside = (wa >= 0.0 && wb >= 0.0 && wc >= 0.0) || (wa <= 0.0 && wb <= 0.0 && wc <= 0.0);
        let area = wa + wb + wc;
        if !inside || area == 0.0 {
            return None;
        }
        let depth = -(wa * f64::from(a.z) + wb * f64::from(b.z) + wc * f64::from(c.z)) / area;
        // Not `depth < min || ..`: a NaN is no crossing.
        if !(depth >= ray.min_depth && depth < max_depth) {
            return None;
        }
        let weights = dvec3(wa / area, wb / area, wc / area);
        Some(Crossing { depth, weights, counter_clockwise: area > 0.0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{dvec2, vec3};

    /// A fan around the axis at depth 2: every ray through its rim's inside must hit, also
    /// the rays exactly along shared edges and through the shared corner.
    #[test]
    fn no_ray_slips_between_neighbours() {
        let rim = |k: i32| {
            let angle = f64::from(k) * std::f64::consts::TAU / 7.0;
            vec3(angle.cos() as f32, angle.sin() as f32, -2.0)
        };
        let fan = (0..7).map(|k| Triangle {
            corners: [vec3(0.0, 0.0, -2.0), rim(k), rim((k + 1) % 7)],
            instance: 0,
            triangle: k as u32,
        });
        let fan = Triangles::new(fan.collect());
        for k in 0..7 {
            for step in 0..90 {
                let p = rim(k).truncate().as_dvec2() * f64::from(step) * 0.01;
                let ray = LensRay { origin: DVec2::ZERO, slope: p / 2.0, min_depth: 1.0 };
                let hit = fan.nearest(&ray, |_, _| true).expect("the fan has no holes");
                assert!((hit.crossing.depth - 2.0).abs() < 1e-12, "depth {}", hit.crossing.depth);
                assert!(hit.crossing.counter_clockwise);
            }
        }
    }

    #[test]
    fn one_triangle_and_none() {
        let corners = [vec3(-1.0, -1.0, -3.0), vec3(1.0, -1.0, -3.0), vec3(0.0, 1.0, -5.0)];
        let one = Triangles::new(vec![Triangle { corners, instance: 4, triangle: 9 }]);
        let ray = LensRay { origin: DVec2::ZERO, slope: dvec2(0.0, 0.0), min_depth: 1.0 };
        let hit = one.nearest(&ray, |_, _| true).expect("the axis crosses it");
        assert_eq!((hit.instance, hit.triangle), (4, 9));
        assert!((hit.crossing.depth - 4.0).abs() < 1e-12);
        assert!((hit.crossing.weights - dvec3(0.25, 0.25, 0.5)).length() < 1e-12);
        assert!(one.nearest(&ray, |_, _| false).is_none());
        assert!(one.nearest(&LensRay { min_depth: 4.5, ..ray }, |_, _| true).is_none());
        assert!(Triangles::new(Vec::new()).nearest(&ray, |_, _| true).is_none());
    }

    /// Many triangles in one place make degenerate hierarchies; none may be lost.
    #[test]
    fn the_nearest_of_a_heap() {
        let layer = |k: u32| {
            let z = -3.0 - (k * 797 % 2_003) as f32 * 1e-6;
            Triangle { corners: [vec3(-1.0, -1.0, z), vec3(1.0, -1.0, z), vec3(0.0, 1.0, z)], instance: 0, triangle: k }
        };
        let heap = Triangles::new((0..2_003).map(layer).chain((0..1_000).map(|_| layer(1))).collect());
        for step in 0..50 {
            let ray = LensRay { origin: dvec2(0.0, 0.3), slope: dvec2(f64::from(step) * 0.002, -0.1), min_depth: 1.0 };
            assert_eq!(heap.nearest(&ray, |_, _| true).map(|hit| hit.triangle), Some(0));
        }
    }
}
