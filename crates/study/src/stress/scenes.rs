//! A small scene, placed and scaled so that f32 would lose it.

use super::lenses::blurring;
use super::specimen::{Specimen, Twin, step};
use defocus::camera::Camera;
use defocus::gpu::Gpu;
use defocus::lens::Lens;
use defocus::scene::{Environment, Instance, Material, Mesh, Scene, TextureImage, TextureUse, Vertex, Wrap};
use defocus::view::{GpuScene, SurfaceOptions, View, ViewError};
use glam::{DAffine3, DVec3, UVec2, Vec2, Vec3, Vec4, dvec3, uvec2, vec2, vec3};
use std::sync::Arc;

/// A scene with what it is a case of.
#[derive(Clone, Copy)]
pub struct SceneCondition {
    /// In words.
    pub name: &'static str,
    /// What the scene is.
    pub content: Content,
    /// Where its origin lies in the world, in its own unscaled metres.
    pub origin: [f64; 3],
    /// Size of all of it, lens and near plane included, against the unscaled one.
    pub scale: f64,
    /// Distance of the near plane, unscaled metres.
    pub near_m: f64,
    /// Vertical field of view, degrees.
    pub fov_y_deg: f64,
    /// Inner frame, px.
    pub size: UVec2,
    /// Margin, px.
    pub overscan_px: u32,
    /// CoC at infinity, px.
    pub k_px: f64,
}

/// What there is to see.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// Lit, textured surfaces at three depths, one across the focus.
    Surfaces,
    /// The same in one colour, that of the sky too.
    OneColor,
    /// A triangle behind the camera: nothing.
    Nothing,
}

const PLAIN: SceneCondition = SceneCondition {
    name: "plain",
    content: Content::Surfaces,
    origin: [0.0; 3],
    scale: 1.0,
    near_m: 0.1,
    fov_y_deg: 60.0,
    size: uvec2(24, 16),
    overscan_px: 4,
    k_px: 6.0,
};

/// The scenes.
pub const SCENES: &[SceneCondition] = &[
    PLAIN,
    SceneCondition { name: "1000 km from the origin", origin: [6e5, -2e5, 8e5], ..PLAIN },
    SceneCondition { name: "a ten-thousandth of the size", scale: 1e-4, ..PLAIN },
    SceneCondition { name: "a million times the size", scale: 1e6, ..PLAIN },
    SceneCondition { name: "near plane at a micrometre", near_m: 1e-6, ..PLAIN },
    SceneCondition { name: "near plane close to the nearest surface", near_m: 0.69, ..PLAIN },
    SceneCondition { name: "field of view of 0.5 degrees", fov_y_deg: 0.5, ..PLAIN },
    SceneCondition { name: "field of view of 175 degrees", fov_y_deg: 175.0, ..PLAIN },
    SceneCondition { name: "one pixel", size: uvec2(1, 1), ..PLAIN },
    SceneCondition { name: "100 x 1 px", size: uvec2(100, 1), ..PLAIN },
    SceneCondition { name: "1 x 100 px, no overscan", size: uvec2(1, 100), overscan_px: 0, ..PLAIN },
    SceneCondition { name: "CoC wider than the image", k_px: 300.0, ..PLAIN },
    SceneCondition { name: "CoC of a million px", k_px: 1e6, ..PLAIN },
    SceneCondition { name: "slight blur", k_px: 0.2, ..PLAIN },
    SceneCondition { name: "overscan wider than the image", overscan_px: 40, size: uvec2(9, 7), ..PLAIN },
    SceneCondition { name: "one colour", content: Content::OneColor, ..PLAIN },
    SceneCondition { name: "one colour, CoC wider than the image", content: Content::OneColor, k_px: 300.0, ..PLAIN },
    SceneCondition { name: "one colour, no overscan", content: Content::OneColor, overscan_px: 0, k_px: 20.0, ..PLAIN },
    SceneCondition { name: "one colour, 1000 km away", content: Content::OneColor, origin: [1e6, 0.0, 0.0], ..PLAIN },
    SceneCondition { name: "nothing in view", content: Content::Nothing, ..PLAIN },
];

/// Focus distance, unscaled metres: within the floor that recedes from the camera.
const FOCUS_M: f64 = 2.0;

/// The colour of everything where there is but one.
const ONE_COLOR: Vec3 = vec3(0.25, 0.5, 0.75);

impl SceneCondition {
    fn lens(&self) -> Lens {
        let unscaled = blurring(self.k_px);
        // K = strength / (df - F), and the CoC at a depth, stay when E, F and df scale and
        // the display's density compensates for the E and F that remain.
        Lens {
            aperture_diameter_mm: unscaled.aperture_diameter_mm * self.scale,
            focal_length_mm: unscaled.focal_length_mm * self.scale,
            density_px_per_mm: unscaled.density_px_per_mm / self.scale,
            focus_distance_m: FOCUS_M * self.scale,
            ..unscaled
        }
    }

    fn view(&self, gpu: &Gpu) -> Result<View, ViewError> {
        let eye = DVec3::from_array(self.origin) * self.scale;
        let camera = Camera::look_at(eye, eye + DVec3::NEG_Z, self.fov_y_deg.to_radians(), self.near_m * self.scale);
        let options = SurfaceOptions { unlit: self.content == Content::OneColor, mipmaps: true };
        let scene = GpuScene::new(gpu, &self.scene(), options);
        View::of_scene(scene, camera, self.size, self.overscan_px)
    }

    fn scene(&self) -> Scene {
        let meshes = match self.content {
            Content::Nothing => vec![quad(dvec3(0.0, 0.0, 3.0), vec2(1.0, 1.0), 0.0)],
            _ => vec![
                quad(dvec3(0.2, 0.1, -0.7), vec2(0.12, 0.3), 0.0),
                quad(dvec3(0.0, -0.4, -2.5), vec2(1.5, 1.8), -1.4),
                quad(dvec3(-0.4, 0.3, -6.0), vec2(3.0, 2.0), 0.2),
            ],
        };
        let one_color = self.content == Content::OneColor;
        let texture = TextureUse { texture: 0, second_uv: false, u_row: Vec3::X, v_row: Vec3::Y };
        let material = Material {
            base_color: if one_color { ONE_COLOR.extend(1.0) } else { Vec4::ONE },
            base_color_texture: (!one_color).then_some(texture),
            metallic: 0.0,
            double_sided: true,
            ..Material::default()
        };
        let environment = if one_color {
            Environment::Studio { zenith: ONE_COLOR, horizon: ONE_COLOR, ground: ONE_COLOR, softbox: 0.0 }
        } else {
            let (zenith, horizon, ground) = (vec3(0.2, 0.4, 0.9), Vec3::splat(0.8), Vec3::splat(0.2));
            Environment::Studio { zenith, horizon, ground, softbox: 4.0 }
        };
        let world_from_object = DAffine3::from_translation(DVec3::from_array(self.origin) * self.scale)
            * DAffine3::from_scale(DVec3::splat(self.scale));
        Scene {
            name: self.name.into(),
            instances: (0..meshes.len()).map(|mesh| Instance { mesh, world_from_object }).collect(),
            meshes,
            materials: vec![material],
            textures: vec![Arc::new(tiles())],
            environment,
            ..Scene::default()
        }
    }

    /// The scene as a specimen.
    ///
    /// # Errors
    ///
    /// A size that the adapter cannot draw.
    pub fn specimen(&self, gpu: &Gpu) -> Result<Specimen, ViewError> {
        let moved = self.scale != 1.0 || self.origin != [0.0; 3];
        let home = Self { origin: [0.0; 3], scale: 1.0, ..*self };
        let (mut view, lens) = (self.view(gpu)?, self.lens());
        let twin = if moved { Some(Twin { view: home.view(gpu)?, lens: home.lens() }) } else { None };
        Ok(Specimen {
            name: format!("scene: {}", self.name),
            step: step(gpu, &mut view, &lens),
            lens,
            view,
            pixels: None,
            only_color: (self.content == Content::OneColor).then_some(ONE_COLOR),
            mirrored: None,
            twin,
        })
    }
}

/// A rectangle around `centre` (camera looks along -z), its upper edge leaning away by
/// `lean_rad`.
fn quad(centre: DVec3, half_size: Vec2, lean_rad: f32) -> Mesh {
    let (sin, cos) = lean_rad.sin_cos();
    let corner = |i: u32| {
        let at = vec2((i & 1) as f32, (i >> 1) as f32);
        let offset = (at * 2.0 - 1.0) * half_size;
        Vertex {
            position: centre.as_vec3() + vec3(offset.x, offset.y * cos, offset.y * sin),
            normal: vec3(0.0, -sin, cos),
            tangent: Vec4::new(1.0, 0.0, 0.0, 1.0),
            uv: vec2(at.x, 1.0 - at.y),
            color: Vec4::ONE,
            ..Default::default()
        }
    };
    let vertices = (0..4).map(corner).collect();
    Mesh { name: "quad".into(), vertices, indices: vec![0, 1, 3, 0, 3, 2], material: 0 }
}

/// Coloured tiles with hard edges.
fn tiles() -> TextureImage {
    let size = UVec2::splat(16);
    let texel = |i: u32| {
        let (x, y) = (i % size.x, i / size.x);
        let light = if (x / 2 + y / 2).is_multiple_of(2) { 230 } else { 40 };
        [light, (x * 16) as u8, (y * 16) as u8, 255]
    };
    let rgba8 = (0..size.x * size.y).map(texel).collect();
    TextureImage { name: "tiles".into(), size, rgba8, srgb: true, wrap: [Wrap::Repeat; 2] }
}
