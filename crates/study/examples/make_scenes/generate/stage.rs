//! A scene under construction.

use super::canvas::Canvas;
use super::shape::Shape;
use glam::{Mat4, Vec3};

/// Everything that goes into one file.
#[derive(Default)]
pub struct Stage {
    pub textures: Vec<Texture>,
    pub materials: Vec<Material>,
    pub meshes: Vec<(Shape, usize)>,
    /// Mesh index and placement. A mesh is lit by where its first node stands.
    pub nodes: Vec<(usize, Mat4)>,
    pub lights: Vec<Light>,
    pub cameras: Vec<Camera>,
    pub sky: Sky,
    pub focus_m: f32,
    /// Reach of ambient occlusion, metres.
    pub occlusion_m: f32,
}

/// A texture and its encoding.
pub struct Texture {
    pub canvas: Canvas,
    /// JPEG quality, or PNG.
    pub jpeg: Option<u8>,
}

/// A metallic-roughness material.
#[derive(Clone)]
pub struct Material {
    pub name: &'static str,
    /// Linear factor.
    pub color: Vec3,
    pub texture: Option<usize>,
    pub metallic: f32,
    pub roughness: f32,
    /// Linear radiance.
    pub emissive: Vec3,
    pub emissive_texture: Option<usize>,
    pub double_sided: bool,
    /// Whether the texture's opacity cuts holes; such a surface casts no baked shadow.
    pub cut: bool,
    /// Opacity, a factor of the texture's, where the surface is blended with what lies behind it.
    pub blended: Option<f32>,
    /// Share of light that passes through.
    pub transmission: f32,
}

impl Material {
    /// Whether light gets past it: no baked shadow says how much.
    pub fn lets_light_past(&self) -> bool {
        self.cut || self.blended.is_some() || self.transmission > 0.0
    }
}

/// A punctual light with the size it has for soft shadows.
pub struct Light {
    /// Linear colour times intensity: lux for directional, candela for point.
    pub intensity: Vec3,
    pub kind: LightKind,
}

/// Shape of a light.
pub enum LightKind {
    /// Direction in which light travels, and the tangent of its angular radius.
    Directional { direction: Vec3, spread: f32 },
    /// Position and radius, metres.
    Point { position: Vec3, radius: f32 },
}

/// A camera by eye and target.
pub struct Camera {
    pub name: &'static str,
    pub eye: Vec3,
    pub target: Vec3,
    pub fov_y_degrees: f32,
    pub near_m: f32,
}

/// The studio environment of the project's scenes, linear radiances.
#[derive(Clone, Copy, Default)]
pub struct Sky {
    pub zenith: Vec3,
    pub horizon: Vec3,
    pub ground: Vec3,
    pub softbox: f32,
}

impl Sky {
    /// Mean radiance over the hemisphere about `n`, as the renderers take it.
    pub fn ambient(&self, n: Vec3) -> Vec3 {
        let (low, high) = ((self.ground + self.horizon) * 0.5, (self.zenith + self.horizon) * 0.5);
        low.lerp(high, n.y * 0.5 + 0.5)
    }
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: "plain",
            color: Vec3::ONE,
            texture: None,
            metallic: 0.0,
            roughness: 0.8,
            emissive: Vec3::ZERO,
            emissive_texture: None,
            double_sided: false,
            cut: false,
            blended: None,
            transmission: 0.0,
        }
    }
}

impl Stage {
    /// Adds a texture as PNG.
    pub fn png(&mut self, canvas: Canvas) -> usize {
        self.textures.push(Texture { canvas, jpeg: None });
        self.textures.len() - 1
    }

    /// Adds a texture as JPEG.
    pub fn jpeg(&mut self, canvas: Canvas, quality: u8) -> usize {
        self.textures.push(Texture { canvas, jpeg: Some(quality) });
        self.textures.len() - 1
    }

    /// Adds a material.
    pub fn material(&mut self, material: Material) -> usize {
        self.materials.push(material);
        self.materials.len() - 1
    }

    /// Adds a non-metallic textured material.
    pub fn matte(&mut self, name: &'static str, texture: usize, roughness: f32) -> usize {
        self.material(Material { name, texture: Some(texture), roughness, ..Material::default() })
    }

    /// Adds a mesh to be placed by [`Stage::node`].
    pub fn mesh(&mut self, shape: Shape, material: usize) -> usize {
        self.meshes.push((shape, material));
        self.meshes.len() - 1
    }

    /// Places a mesh.
    pub fn node(&mut self, mesh: usize, placement: Mat4) {
        self.nodes.push((mesh, placement));
    }

    /// Adds a mesh that stands once, where it is.
    pub fn place(&mut self, shape: Shape, material: usize) {
        let mesh = self.mesh(shape, material);
        self.node(mesh, Mat4::IDENTITY);
    }

    /// Adds a sun: lux, direction of travel, tangent of the angular radius.
    pub fn sun(&mut self, intensity: Vec3, direction: Vec3, spread: f32) {
        let kind = LightKind::Directional { direction: direction.normalize(), spread };
        self.lights.push(Light { intensity, kind });
    }

    /// Adds a lamp: candela, position and radius in metres.
    pub fn lamp(&mut self, intensity: Vec3, position: Vec3, radius: f32) {
        self.lights.push(Light { intensity, kind: LightKind::Point { position, radius } });
    }

    /// Adds a camera.
    pub fn camera(&mut self, name: &'static str, eye: Vec3, target: Vec3, fov_y_degrees: f32, near_m: f32) {
        self.cameras.push(Camera { name, eye, target, fov_y_degrees, near_m });
    }

    /// Triangles over all nodes.
    pub fn triangles(&self) -> usize {
        self.nodes.iter().map(|&(mesh, _)| self.meshes[mesh].0.triangles()).sum()
    }
}

/// The rotation after which -z points along `direction`, +y up.
pub fn facing(direction: Vec3) -> Mat4 {
    let back = -direction.normalize();
    let up = if back.y.abs() > 0.99 { Vec3::X } else { Vec3::Y };
    let right = up.cross(back).normalize();
    Mat4::from_cols(right.extend(0.0), back.cross(right).extend(0.0), back.extend(0.0), glam::Vec4::W)
}

impl Camera {
    /// Takes view space to world space.
    pub fn pose(&self) -> Mat4 {
        Mat4::from_translation(self.eye) * facing(self.target - self.eye)
    }
}
