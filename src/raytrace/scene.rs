//! A scene made ready for rays from one camera.

use super::bvh::{Crossing, Hit, LensRay, Triangle, Triangles};
use super::shading::{RelativeLight, Surface, unlit};
use super::texture::lookup;
use super::{RayError, Shading, environment};
use crate::camera::Camera;
use crate::scene::{Instance, Material, Mesh, Scene, Vertex};
use glam::{DAffine3, DMat3, DVec2, DVec3, Mat3, Vec2, Vec3, Vec4};
use std::sync::Arc;

/// Surfaces behind one another that a ray goes through at most.
const MOST_SURFACES: u32 = 256;

/// Share of a ray below which what lies behind is not looked at.
const LEAST_LEFT: f32 = 1e-4;

/// Relative difference of depth within which crossings of two triangles of one instance are one:
/// far above the rounding of their f32 corners, far below what a pixel shows.
const SAME_DEPTH: f64 = 1e-6;

/// A scene made ready for rays from one camera: its triangles in view space, in a bounding
/// volume hierarchy, and its lights relative to the lens centre.
///
/// Lengths within are in units of the camera's near distance: the hierarchy's fixed
/// tolerances then mean the same in a watch and in a valley. Positions pass from object to
/// view space in f64 before they become f32.
pub struct RayScene {
    scene: Arc<Scene>,
    /// Metres in a unit of view space.
    unit_m: f64,
    world_from_view: DMat3,
    placements: Vec<Placement>,
    lights: Vec<RelativeLight>,
    triangles: Triangles,
}

/// What a hit on an instance needs, computed once.
struct Placement {
    /// Whether the transform flips handedness: the front is then clockwise (glTF 2.0, 3.7.4).
    mirrored: bool,
    double_sided: bool,
    alpha_cutoff: Option<f32>,
    world_from_object: Mat3,
    normal_from_object: Mat3,
}

/// A ray with the shading of its origin: what [`RayScene::radiance`] needs.
pub(super) struct Sample {
    pub ray: LensRay,
    /// From where surfaces are looked at, metres in view space.
    pub viewer_m: DVec2,
}

impl RayScene {
    /// Brings the scene into the camera's view space and builds the hierarchy: about a second
    /// for a million triangles. Triangles behind the lens are left out.
    ///
    /// Errors if the near distance is not a positive number or there are more triangles
    /// than 32-bit indices reach.
    pub fn new(scene: Arc<Scene>, camera: &Camera) -> Result<Self, RayError> {
        let unit_m = camera.near_m;
        if !(unit_m > 0.0 && unit_m.is_finite()) {
            return Err(RayError::Near { near_m: unit_m });
        }
        let triangle_count = scene.triangle_count();
        if triangle_count > u64::from(u32::MAX) {
            return Err(RayError::TooManyTriangles { triangle_count });
        }
        let unit_from_world = DAffine3::from_scale(DVec3::splat(1.0 / unit_m)) * camera.view_from_world();
        let triangles = (0u32..).zip(&scene.instances).flat_map(|(index, instance)| {
            view_triangles(&scene.meshes[instance.mesh], index, unit_from_world * instance.world_from_object)
        });
        Ok(Self {
            triangles: Triangles::new(triangles.collect()),
            placements: scene.instances.iter().map(|i| Placement::new(&scene, i)).collect(),
            lights: scene.lights.iter().map(|light| RelativeLight::new(light, camera.position)).collect(),
            world_from_view: DMat3::from_quat(camera.orientation),
            unit_m,
            scene,
        })
    }

    /// Triangles in the hierarchy: those of the scene that reach before the lens.
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// Metres in the unit of [`LensRay`]s.
    pub(super) fn unit_m(&self) -> f64 {
        self.unit_m
    }

    /// Radiance along the sample's ray, and the depth along the axis, metres, of the nearest surface
    /// that covers half of the ray or more; infinity where none does. The ray goes on behind what
    /// covers less than all of it.
    pub(super) fn seen(&self, sample: &Sample, shading: Shading) -> (Vec3, f32) {
        let mut ray = sample.ray;
        let (mut sum, mut depth_m, mut left) = (Vec3::ZERO, f32::INFINITY, 1.0);
        let mut passed = None;
        for _ in 0..MOST_SURFACES {
            let Some(hit) = self.nearest(&ray, passed.as_ref()) else {
                return (sum + self.background(&sample.ray) * left, depth_m);
            };
            let (radiance, coverage) = self.surface(sample, &hit, shading);
            sum += radiance * (left * coverage);
            left *= 1.0 - coverage;
            if coverage >= 0.5 && depth_m == f32::INFINITY {
                depth_m = (hit.crossing.depth * self.unit_m) as f32;
            }
            if left < LEAST_LEFT {
                break;
            }
            ray.min_depth = hit.crossing.depth;
            passed = Some(hit);
        }
        (sum, depth_m)
    }

    /// The nearest surface on the ray: neither a culled back face nor cut away, nor one that was
    /// `passed`: two triangles of it may share the edge that the ray goes through.
    fn nearest(&self, ray: &LensRay, passed: Option<&Hit>) -> Option<Hit> {
        self.triangles.nearest(ray, |triangle, crossing| {
            let was_passed = passed.is_some_and(|hit| {
                let apart = crossing.depth - hit.crossing.depth;
                hit.instance == triangle.instance && apart <= SAME_DEPTH * crossing.depth
            });
            if was_passed {
                return false;
            }
            let placement = &self.placements[triangle.instance as usize];
            let visible = placement.double_sided || placement.shows_front(crossing);
            visible && placement.alpha_cutoff.is_none_or(|cutoff| self.alpha(triangle, crossing) >= cutoff)
        })
    }

    fn background(&self, ray: &LensRay) -> Vec3 {
        let direction = self.world_from_view * ray.slope.extend(-1.0);
        environment::radiance(&self.scene.environment, direction.normalize().as_vec3())
    }

    /// Radiance of a surface along the sample's ray, and its coverage.
    fn surface(&self, sample: &Sample, hit: &Hit, shading: Shading) -> (Vec3, f32) {
        let fragment = self.fragment(hit.instance, hit.triangle, &hit.crossing);
        let material = fragment.material;
        let base_color = self.base_color(&fragment);
        let uv = fragment.uv();
        let textures = &self.scene.textures;
        let alpha = if material.blended { base_color.w } else { 1.0 };
        let passing = match material.transmission {
            0.0 => 0.0,
            share => {
                let texture = lookup(textures, material.transmission_texture.as_ref(), uv).x;
                (share * texture * base_color.truncate().element_sum() / 3.0).clamp(0.0, 1.0)
            }
        };
        if material.unlit || shading == Shading::Unlit {
            return (unlit(base_color), (alpha * (1.0 - passing)).clamp(0.0, 1.0));
        }
        let metallic_roughness = lookup(textures, material.metallic_roughness_texture.as_ref(), uv);
        let emissive = lookup(textures, material.emissive_texture.as_ref(), uv).truncate();
        let in_view = (sample.ray.origin + sample.ray.slope * hit.crossing.depth).extend(-hit.crossing.depth);
        let mut surface = Surface {
            position: (self.world_from_view * (in_view * self.unit_m)).as_vec3(),
            normal: self.shading_normal(&fragment, hit, uv),
            albedo: base_color.truncate(),
            metallic: material.metallic * metallic_roughness.z,
            roughness: material.roughness * metallic_roughness.y,
            emissive: material.emissive * emissive,
        };
        let viewer = (self.world_from_view * sample.viewer_m.extend(0.0)).as_vec3();
        let covers = surface.let_pass(passing, viewer);
        (surface.radiance(viewer, &self.lights, &self.scene.environment), (alpha * covers).clamp(0.0, 1.0))
    }

    fn fragment(&self, instance: u32, triangle: u32, crossing: &Crossing) -> Fragment<'_> {
        let mesh = &self.scene.meshes[self.scene.instances[instance as usize].mesh];
        let first = triangle as usize * 3;
        let corner = |k: usize| &mesh.vertices[mesh.indices[first + k] as usize];
        Fragment {
            corners: [corner(0), corner(1), corner(2)],
            weights: crossing.weights,
            material: &self.scene.materials[mesh.material],
        }
    }

    /// Factor times texture times vertex colour.
    fn base_color(&self, fragment: &Fragment) -> Vec4 {
        let texture = lookup(&self.scene.textures, fragment.material.base_color_texture.as_ref(), fragment.uv());
        fragment.material.base_color * texture * fragment.mix4(|v| v.color)
    }

    fn alpha(&self, triangle: &Triangle, crossing: &Crossing) -> f32 {
        self.base_color(&self.fragment(triangle.instance, triangle.triangle, crossing)).w
    }

    /// World-space unit normal with the normal map applied, turned over on a back face.
    fn shading_normal(&self, fragment: &Fragment, hit: &Hit, uv: [Vec2; 2]) -> Vec3 {
        let placement = &self.placements[hit.instance as usize];
        let normal = (placement.normal_from_object * fragment.mix3(|v| v.normal)).normalize_or_zero();
        let material = fragment.material;
        let mapped = match &material.normal_texture {
            None => normal,
            Some(slot) => {
                let texel = lookup(&self.scene.textures, Some(slot), uv).truncate() * 2.0 - Vec3::ONE;
                let tangent = fragment.mix4(|v| v.tangent);
                let along = (placement.world_from_object * tangent.truncate()).normalize_or_zero();
                let across = normal.cross(along) * fragment.corners[0].tangent.w;
                let scaled = texel.truncate() * material.normal_scale;
                (along * scaled.x + across * scaled.y + normal * texel.z).normalize_or(normal)
            }
        };
        if placement.shows_front(&hit.crossing) { mapped } else { -mapped }
    }
}

impl Placement {
    fn new(scene: &Scene, instance: &Instance) -> Self {
        let material = &scene.materials[scene.meshes[instance.mesh].material];
        let m = instance.world_from_object.matrix3;
        let mirrored = m.determinant() < 0.0;
        // The inverse transpose up to a positive factor, which also serves a transform
        // that flattens: the cofactors, with the determinant's sign.
        let cofactors = DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis))
            * if mirrored { -1.0 } else { 1.0 };
        // Scaled to about 1: f32 has no room for the squares of extreme scales.
        let size = cofactors.to_cols_array().into_iter().fold(f64::MIN_POSITIVE, |size, c| size.max(c.abs()));
        Self {
            mirrored,
            double_sided: material.double_sided,
            alpha_cutoff: material.alpha_cutoff,
            world_from_object: m.as_mat3(),
            normal_from_object: (cofactors * size.recip()).as_mat3(),
        }
    }

    fn shows_front(&self, crossing: &Crossing) -> bool {
        crossing.counter_clockwise != self.mirrored
    }
}

/// A mesh's triangles in view space, without those wholly behind the lens.
fn view_triangles(mesh: &Mesh, instance: u32, view_from_object: DAffine3) -> impl Iterator<Item = Triangle> {
    (0u32..).zip(mesh.indices.chunks_exact(3)).filter_map(move |(triangle, indices)| {
        let corner = |k: usize| {
            let position = mesh.vertices[indices[k] as usize].position;
            view_from_object.transform_point3(position.as_dvec3()).as_vec3()
        };
        let corners = [corner(0), corner(1), corner(2)];
        let drawable = corners.iter().all(|p| p.is_finite()) && corners.iter().any(|p| p.z < 0.0);
        drawable.then_some(Triangle { corners, instance, triangle })
    })
}

/// A point on a triangle with what its vertices carry.
struct Fragment<'a> {
    corners: [&'a Vertex; 3],
    weights: DVec3,
    material: &'a Material,
}

impl Fragment<'_> {
    /// Texture coordinates, interpolated in f64: rays that meet in a point of the focus
    /// plane must read the same texels there.
    fn uv(&self) -> [Vec2; 2] {
        let mix = |of: fn(&Vertex) -> Vec2| {
            let [a, b, c] = self.corners.map(|v| of(v).as_dvec2());
            (a * self.weights.x + b * self.weights.y + c * self.weights.z).as_vec2()
        };
        [mix(|v| v.uv), mix(|v| v.uv1)]
    }

    fn mix3(&self, of: impl Fn(&Vertex) -> Vec3) -> Vec3 {
        let w = self.weights.as_vec3();
        of(self.corners[0]) * w.x + of(self.corners[1]) * w.y + of(self.corners[2]) * w.z
    }

    fn mix4(&self, of: impl Fn(&Vertex) -> Vec4) -> Vec4 {
        let w = self.weights.as_vec3();
        of(self.corners[0]) * w.x + of(self.corners[1]) * w.y + of(self.corners[2]) * w.z
    }
}
