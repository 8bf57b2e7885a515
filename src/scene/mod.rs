//! Scenes: what there is to look at, in plain data, read by the rasteriser and by the
//! ray tracer alike.

pub mod error;
pub mod gltf;
pub mod rgbd;

pub use error::SceneError;

use crate::camera::Camera;
use crate::lens::Lens;
use glam::{DAffine3, UVec2, Vec2, Vec3, Vec4};
use std::sync::Arc;

/// A scene of instanced triangle meshes.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Short name: the built-in name or the file's stem.
    pub name: String,
    /// Triangle meshes, one material each.
    pub meshes: Vec<Mesh>,
    /// Placed meshes.
    pub instances: Vec<Instance>,
    /// What surfaces are made of.
    pub materials: Vec<Material>,
    /// Images that materials refer to.
    pub textures: Vec<Arc<TextureImage>>,
    /// Punctual lights of the file; or the default light where the loader adds it (`gltf`).
    pub lights: Vec<Light>,
    /// Light from everywhere else, and what is seen where nothing is.
    pub environment: Environment,
    /// Cameras of the file, in its order. Never empty: a file without one gets a framing
    /// of its bounds.
    pub cameras: Vec<NamedCamera>,
    /// Focus distance that the scene's author recommends, metres.
    pub focus_hint_m: Option<f64>,
    /// What was approximated or left out while loading, one sentence each.
    pub notes: Vec<String>,
    /// The lens and the frame that it is made for, of a scene that is made for one.
    pub made_for: Option<MadeFor>,
    /// Animations of its file, which can be shown at a moment ([`gltf::load_at`]).
    pub animations: Vec<gltf::Animation>,
}

/// The lens and the frame that a scene is made for.
#[derive(Clone, Debug, PartialEq)]
pub struct MadeFor {
    /// The lens.
    pub lens: Lens,
    /// Size of the frame, px.
    pub size: UVec2,
    /// Margin around it, px.
    pub overscan_px: u32,
}

impl MadeFor {
    /// The lens that makes the same picture in a frame `height_px` high: its CoC in pixels
    /// grows with the frame.
    pub fn lens_at(&self, height_px: u32) -> Lens {
        let aperture_diameter_mm = self.lens.aperture_diameter_mm * self.growth(height_px);
        Lens { aperture_diameter_mm, ..self.lens.clone() }
    }

    /// The margin of a frame `height_px` high, px.
    pub fn overscan_px_at(&self, height_px: u32) -> u32 {
        (f64::from(self.overscan_px) * self.growth(height_px)).ceil() as u32
    }

    fn growth(&self, height_px: u32) -> f64 {
        f64::from(height_px) / f64::from(self.size.y)
    }
}

/// A triangle mesh in object space.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Name of its source, for messages.
    pub name: String,
    /// Vertices.
    pub vertices: Vec<Vertex>,
    /// Three indices a triangle, all within `vertices`; counter-clockwise seen from the front.
    pub indices: Vec<u32>,
    /// Index into [`Scene::materials`].
    pub material: usize,
}

/// A vertex. Everything is finite; `normal` and `tangent.xyz` have unit length.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vertex {
    /// Object-space position, metres.
    pub position: Vec3,
    /// Object-space unit normal.
    pub normal: Vec3,
    /// Object-space unit tangent and the bitangent's sign in w (glTF convention).
    pub tangent: Vec4,
    /// Texture coordinates, origin at the image's top left (glTF convention).
    pub uv: Vec2,
    /// Second set of texture coordinates.
    pub uv1: Vec2,
    /// Linear colour factor.
    pub color: Vec4,
}

/// A mesh placed in the world.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Index into [`Scene::meshes`].
    pub mesh: usize,
    /// Takes object space to world space, metres. May mirror.
    pub world_from_object: DAffine3,
}

/// An 8-bit RGBA image with its sampler.
#[derive(Clone, Debug)]
pub struct TextureImage {
    /// Name of its source, for messages.
    pub name: String,
    /// Size, px.
    pub size: UVec2,
    /// RGBA rows from top to bottom.
    pub rgba8: Vec<[u8; 4]>,
    /// Whether RGB is sRGB-encoded colour (base colour, emissive) or plain data.
    pub srgb: bool,
    /// Addressing beyond [0, 1].
    pub wrap: [Wrap; 2],
}

/// Texture addressing outside [0, 1].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The image repeats.
    #[default]
    Repeat,
    /// The border texel is repeated.
    Clamp,
    /// The image repeats, every other one mirrored.
    Mirror,
}

/// A texture as a material uses it: `uv' = uv_transform * (u, v, 1)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureUse {
    /// Index into [`Scene::textures`].
    pub texture: usize,
    /// Whether (u, v) is the vertices' second set of texture coordinates.
    pub second_uv: bool,
    /// First row of the texture transform (KHR_texture_transform): u' = dot(row, (u, v, 1)).
    pub u_row: Vec3,
    /// Second row: v' = dot(row, (u, v, 1)).
    pub v_row: Vec3,
}

/// A metallic-roughness material (glTF 2.0), or an unlit one.
#[derive(Clone, Debug)]
pub struct Material {
    /// Name of its source, for messages.
    pub name: String,
    /// KHR_materials_unlit: the base colour is the radiance.
    pub unlit: bool,
    /// Linear base colour factor.
    pub base_color: Vec4,
    /// Base colour texture (sRGB).
    pub base_color_texture: Option<TextureUse>,
    /// Metalness factor in [0, 1].
    pub metallic: f32,
    /// Perceptual roughness factor in [0, 1].
    pub roughness: f32,
    /// Metalness in B, roughness in G.
    pub metallic_roughness_texture: Option<TextureUse>,
    /// Tangent-space normal map.
    pub normal_texture: Option<TextureUse>,
    /// Scale of the normal map's x and y.
    pub normal_scale: f32,
    /// Linear emitted radiance: factor times strength.
    pub emissive: Vec3,
    /// Emissive texture (sRGB).
    pub emissive_texture: Option<TextureUse>,
    /// Fragments with an alpha below this are not there; `None` for surfaces that are not cut.
    pub alpha_cutoff: Option<f32>,
    /// Whether alpha is [coverage](Material::is_sheet) (glTF's BLEND); otherwise it is only
    /// compared with `alpha_cutoff`.
    pub blended: bool,
    /// Share of light in [0, 1] that passes through (KHR_materials_transmission).
    pub transmission: f32,
    /// A factor of `transmission` in R.
    pub transmission_texture: Option<TextureUse>,
    /// Whether back faces are seen.
    pub double_sided: bool,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            unlit: false,
            base_color: Vec4::ONE,
            base_color_texture: None,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            emissive: Vec3::ZERO,
            emissive_texture: None,
            alpha_cutoff: None,
            blended: false,
            transmission: 0.0,
            transmission_texture: None,
            double_sided: false,
        }
    }
}

impl Material {
    /// Whether it may cover only a part of what lies behind it: a sheet of glass, smoke, a leaf
    /// with soft edges. Its coverage q in [0, 1] is the share of a ray that ends there; with the
    /// base colour b, its alpha a (1 unless [`blended`](Self::blended)), the transmission t with
    /// its texture, the metalness m and the cosine n.v of the angle at which it is seen
    ///
    /// ```text
    /// passes  = t (1 - m) mean(b)
    /// mirrors = passes (0.04 + 0.96 (1 - n.v)^5)        0 for unlit surfaces
    /// q       = a (1 - passes + mirrors)
    /// ```
    ///
    /// What is seen of it is shaded with the base colour and the metalness mixed towards a white
    /// mirror's by `mirrors / (1 - passes + mirrors)`. Light that passes goes straight on, and is
    /// dimmed by the mean of the base colour instead of tinted by it.
    pub fn is_sheet(&self) -> bool {
        self.blended || self.transmission > 0.0
    }
}

/// A punctual light (KHR_lights_punctual).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Linear colour times intensity: candela for point and spot, lux for directional, so
    /// that a white diffuse surface facing 1 lux has the radiance 1/pi.
    pub intensity: Vec3,
    /// What kind, and where.
    pub kind: LightKind,
}

/// The shape of a punctual light, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// From infinitely far away; `direction` is the unit vector in which light travels.
    Directional {
        /// Unit vector in which light travels.
        direction: glam::DVec3,
    },
    /// From a point, inverse-square, with an optional range.
    Point {
        /// Position, metres.
        position: glam::DVec3,
        /// Beyond this distance, metres, there is no light; infinity for none.
        range_m: f64,
    },
    /// A point light within a cone.
    Spot {
        /// Position, metres.
        position: glam::DVec3,
        /// Beyond this distance, metres, there is no light; infinity for none.
        range_m: f64,
        /// Unit vector along the cone's axis, away from the light.
        direction: glam::DVec3,
        /// Cosine of the half angle within which intensity is full.
        cos_inner: f64,
        /// Cosine of the half angle beyond which there is none.
        cos_outer: f64,
    },
}

/// Light from all around, analytic so that rasteriser and ray tracer agree exactly.
///
/// With `y` the world-space height of a unit direction, `mix(a, b, t) = a + (b - a) t`:
///
/// ```text
/// radiance(r)        = mix(horizon, zenith, y)           y >= 0     shown as background
///                      mix(horizon, ground, min(-3y,1))  y < 0
/// ambient(n)         = mix((ground+horizon)/2, (zenith+horizon)/2, (n.y+1)/2)   times albedo: diffuse
/// reflected(r,rough) = mix(radiance(r), ambient(r), rough)
///                      + softbox * sum over the four s = normalize(+-1, 1.2, +-0.6) of
///                        smoothstep(0.9 - w, 0.9 + w, dot(r, s)),  w = 0.02 + 0.3 rough
/// ```
///
/// `reflected` is weighted by the split-sum fit of Karis, "Physically Based Shading on
/// Mobile" (2014).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Environment {
    /// None: black behind everything and no ambient light.
    #[default]
    Black,
    /// A gradient over the sphere with four softboxes for glossy surfaces to reflect.
    Studio {
        /// Linear radiance straight up.
        zenith: Vec3,
        /// Linear radiance at the horizon.
        horizon: Vec3,
        /// Linear radiance straight down.
        ground: Vec3,
        /// Linear radiance of the softboxes; 0 for none.
        softbox: f32,
    },
}

/// A camera with its name.
#[derive(Clone, Debug)]
pub struct NamedCamera {
    /// The file's name for it, or "framing".
    pub name: String,
    /// Pose and field of view.
    pub camera: Camera,
}

impl Scene {
    /// Triangles over all instances.
    pub fn triangle_count(&self) -> u64 {
        self.instances.iter().map(|i| self.meshes[i.mesh].indices.len() as u64 / 3).sum()
    }

    /// World-space bounds over all instances, metres; `None` for an empty scene.
    pub fn bounds_m(&self) -> Option<(glam::DVec3, glam::DVec3)> {
        let boxes: Vec<_> = self.meshes.iter().map(Mesh::bounds).collect();
        let corners = self.instances.iter().filter_map(|i| Some((boxes[i.mesh]?, i))).flat_map(|((lo, hi), i)| {
            (0..8).map(move |k| {
                let pick = |bit: u32, lo: f32, hi: f32| f64::from(if k & bit == 0 { lo } else { hi });
                let corner = glam::dvec3(pick(1, lo.x, hi.x), pick(2, lo.y, hi.y), pick(4, lo.z, hi.z));
                i.world_from_object.transform_point3(corner)
            })
        });
        corners.fold(None, |bounds, p| match bounds {
            None => Some((p, p)),
            Some((lo, hi)) => Some((p.min(lo), p.max(hi))),
        })
    }
}

impl Mesh {
    /// Whether all of it lies in one plane, to within a part in 100,000 of its size: nothing of it
    /// hides anything else of it.
    pub(crate) fn is_flat(&self) -> bool {
        let Some((low, high)) = self.bounds() else { return true };
        let tolerance = 1e-5 * (high - low).length();
        let corners = |t: &[u32]| [0, 1, 2].map(|k| self.vertices[t[k] as usize].position);
        let normal = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a);
        let triangles = self.indices.chunks_exact(3).map(corners);
        let widest = triangles.max_by(|a, b| normal(*a).length_squared().total_cmp(&normal(*b).length_squared()));
        let Some(widest) = widest else { return true };
        let (unit, origin) = (normal(widest).normalize_or_zero(), widest[0]);
        self.vertices.iter().all(|v| unit.dot(v.position - origin).abs() <= tolerance)
    }

    /// Object-space bounds; `None` for a mesh without vertices.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let first = self.vertices.first()?.position;
        Some(self.vertices.iter().fold((first, first), |(lo, hi), v| (lo.min(v.position), hi.max(v.position))))
    }
}
