//! Light and shade baked into vertex colours.
//!
//! The rasteriser draws no shadows. A corner's colour becomes the fraction of the light
//! it would get unshadowed (ambient and punctual, as the renderers add them up) that
//! reaches it, so that a diffuse surface ends up with the radiance it has with shadows.

use super::noise::hash;
use super::stage::{LightKind, Stage};
use glam::{Mat3, Vec2, Vec3, Vec3A, vec2};
use obvhs::{BvhBuildParams, cwbvh::CwBvh, cwbvh::builder::build_cwbvh_from_tris};
use obvhs::{ray::Ray, ray::RayHit, triangle::Triangle};
use rayon::prelude::*;
use std::f32::consts::{PI, TAU};
use std::time::Duration;

/// Rays a corner for ambient light, and for each punctual light.
const RAYS: [usize; 2] = [64, 16];
/// Mean reflectance of what occludes: the light that bounces back from it.
const BOUNCE: f32 = 0.45;
/// Full darkness would hide texture that a lens should blur.
const FLOOR: f32 = 0.03;

/// All triangles of a stage, to trace rays through.
pub struct Tracer {
    bvh: CwBvh,
    triangles: Vec<Triangle>,
}

impl Tracer {
    /// From every node of `stage` but those with holes.
    pub fn new(stage: &Stage) -> Self {
        let mut triangles = Vec::with_capacity(stage.triangles());
        for &(mesh, placement) in &stage.nodes {
            let (shape, material) = &stage.meshes[mesh];
            if stage.materials[*material].lets_light_past() {
                continue;
            }
            let points: Vec<Vec3A> =
                shape.corners.iter().map(|c| placement.transform_point3a(c.position.into())).collect();
            let corner = |i: u32| points[i as usize];
            let triangle = |t: &[u32]| Triangle { v0: corner(t[0]), v1: corner(t[1]), v2: corner(t[2]) };
            triangles.extend(shape.indices.chunks_exact(3).map(triangle));
        }
        let bvh = build_cwbvh_from_tris(&triangles, BvhBuildParams::fast_build(), &mut Duration::default());
        Self { bvh, triangles }
    }

    /// Distance of the first hit within `reach`, and the triangle's index.
    pub fn hit(&self, origin: Vec3, direction: Vec3, reach: f32) -> Option<(f32, usize)> {
        let ray = Ray::new(origin.into(), direction.into(), 0.0, reach);
        let mut hit = RayHit::none();
        let triangle = |id: usize| self.bvh.primitive_indices[id] as usize;
        self.bvh
            .ray_traverse(ray, &mut hit, |ray, id| self.triangles[triangle(id)].intersect(ray))
            .then(|| (hit.t, triangle(hit.primitive_id as usize)))
    }

    fn open(&self, origin: Vec3, direction: Vec3, reach: f32) -> bool {
        let ray = Ray::new(origin.into(), direction.into(), 0.0, reach);
        self.bvh
            .ray_traverse_miss(ray, |ray, id| self.triangles[self.bvh.primitive_indices[id] as usize].intersect(ray))
    }
}

/// Multiplies every corner's tint by the light that reaches it where the mesh's first
/// node stands.
pub fn bake(stage: &mut Stage) {
    let tracer = Tracer::new(stage);
    let tints: Vec<Option<Vec<Vec3>>> = (0..stage.meshes.len())
        .map(|mesh| {
            let &(_, placement) = stage.nodes.iter().find(|node| node.0 == mesh)?;
            let (shape, material) = &stage.meshes[mesh];
            let both_sides = stage.materials[*material].double_sided;
            let normals = placement.inverse().transpose();
            let light = |c: &super::shape::Corner| {
                let n = normals.transform_vector3(c.normal).normalize_or(Vec3::Y);
                let p = placement.transform_point3(c.position);
                let reached = reaching(stage, &tracer, p, n);
                let reached = if both_sides { reached.max(reaching(stage, &tracer, p, -n)) } else { reached };
                c.tint * reached
            };
            Some(shape.corners.par_iter().map(light).collect())
        })
        .collect();
    for ((shape, _), tints) in stage.meshes.iter_mut().zip(tints) {
        for (corner, tint) in shape.corners.iter_mut().zip(tints.into_iter().flatten()) {
            corner.tint = tint;
        }
    }
}

fn reaching(stage: &Stage, tracer: &Tracer, position: Vec3, normal: Vec3) -> Vec3 {
    // Off the surface by more than neighbouring facets deviate from the smooth shape.
    let origin = position + normal * (2e-4 + 1e-3 * stage.occlusion_m);
    let ambient = stage.sky.ambient(normal);
    let (mut whole, mut reached) = (ambient, ambient * openness(stage, tracer, origin, normal));
    for light in &stage.lights {
        let (to_light, distance, size) = match light.kind {
            LightKind::Directional { direction, spread } => (-direction, 1.0, spread),
            LightKind::Point { position, radius } => {
                let d = position - origin;
                (d.normalize_or(Vec3::Y), d.length(), radius / d.length().max(1e-3))
            }
        };
        let cos = normal.dot(to_light);
        if cos <= 0.0 {
            continue;
        }
        let directional = matches!(light.kind, LightKind::Directional { .. });
        let direct = light.intensity * cos / (PI * distance * distance);
        let reach = if directional { f32::INFINITY } else { distance };
        let basis = Mat3::from_cols(to_light.any_orthonormal_pair().0, to_light.any_orthonormal_pair().1, to_light);
        let visible = (0..RAYS[1]).filter(|&k| {
            let disc = disc_point(k, RAYS[1]) * size;
            tracer.open(origin, (basis * disc.extend(1.0)).normalize(), reach)
        });
        whole += direct;
        reached += direct * visible.count() as f32 / RAYS[1] as f32;
    }
    (reached / whole.max(Vec3::splat(1e-6))).clamp(Vec3::splat(FLOOR), Vec3::ONE)
}

/// Cosine-weighted share of the hemisphere that is open, nearer occluders counting more,
/// brightened by the light that they bounce.
fn openness(stage: &Stage, tracer: &Tracer, origin: Vec3, normal: Vec3) -> f32 {
    let (a, b) = normal.any_orthonormal_pair();
    let basis = Mat3::from_cols(a, b, normal);
    let share = |k| {
        let disc = disc_point(k, RAYS[0]) * 0.995;
        let direction = basis * disc.extend((1.0 - disc.length_squared()).sqrt());
        match tracer.hit(origin, direction.normalize(), stage.occlusion_m) {
            None => 1.0,
            Some((t, _)) => (t / stage.occlusion_m).clamp(0.0, 1.0),
        }
    };
    let open = (0..RAYS[0]).map(share).sum::<f32>() / RAYS[0] as f32;
    open / (1.0 - BOUNCE * (1.0 - open))
}

/// The k-th of n points spread evenly over the unit disc (Vogel's spiral, jittered alike
/// for every corner: a pattern shared by neighbours bands less than it would speckle).
fn disc_point(k: usize, n: usize) -> Vec2 {
    let radius = ((k as f32 + 0.5) / n as f32).sqrt();
    let angle = k as f32 * 2.399_963_2 + 0.3 * hash(k as i32, 0, 9) * TAU / n as f32;
    let (sin, cos) = angle.sin_cos();
    vec2(cos, sin) * radius
}
