//! Small scenes and lenses for tests.

#![allow(dead_code, reason = "every test binary compiles this module and uses its own part of it")]

use defocus::aperture::{Aperture, ApertureImage};
use defocus::camera::Camera;
use defocus::lens::Lens;
use defocus::scene::{Instance, Material, Mesh, Scene, TextureImage, TextureUse, Vertex, Wrap};
use glam::{DAffine3, DVec3, UVec2, Vec2, Vec3, Vec4, uvec2, vec2, vec3};
use std::sync::{Arc, OnceLock};

/// The one device of a test binary. Without any Vulkan driver the tests fail: software
/// Vulkan is enough, and `script/test` installs it.
pub fn gpu() -> &'static defocus::gpu::Gpu {
    static GPU: OnceLock<defocus::gpu::Gpu> = OnceLock::new();
    GPU.get_or_init(|| defocus::gpu::Gpu::open(None).expect("a graphics adapter; script/test installs a software one"))
}

/// The files beside the repository that some tests read, or `None` with a word on standard
/// error where they are absent.
pub fn shared() -> Option<std::path::PathBuf> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared");
    if path.is_dir() {
        return Some(path);
    }
    eprintln!("skipped: {} is not there, so its files are not tried", path.display());
    None
}

/// A camera at the origin looking along -z, 60 degrees high, near plane at 0.1 m.
pub fn front_camera() -> Camera {
    Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, 60f64.to_radians(), 0.1)
}

/// A disc lens focused at `focus_m` that blurs infinity by `k_px`.
pub fn lens(k_px: f64, focus_m: f64) -> Lens {
    let unit = Lens {
        aperture_diameter_mm: 1.0,
        focal_length_mm: 17.0,
        image_distance_mm: 24.0,
        screen_distance_mm: 3000.0,
        density_px_per_mm: 0.32,
        focus_distance_m: focus_m,
        aperture: Default::default(),
        eye: Default::default(),
    };
    // K is proportional to E; where df is infinite the product K * df is what is asked for.
    let blur_of_unit = if focus_m.is_finite() { unit.k_px() } else { unit.coc().k_df_px_m };
    Lens { aperture_diameter_mm: k_px / blur_of_unit, ..unit }
}

/// Every kind of aperture, asymmetric ones among them.
pub fn apertures() -> Vec<Aperture> {
    // An L: no symmetry at all.
    let pixels = vec![1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.5, 0.25];
    let image = ApertureImage::new("L", uvec2(3, 3), pixels).unwrap();
    vec![
        Aperture::Disc,
        Aperture::polygon(3),
        Aperture::Polygon { blades: 6, rotation_deg: 11.0, roundness: 0.3 },
        Aperture::Gaussian { sigma_per_coc: 0.25 },
        Aperture::Image(Arc::new(image)),
    ]
}

/// An unlit, single-sided material of one colour.
pub fn unlit(color: Vec3) -> Material {
    Material { unlit: true, base_color: color.extend(1.0), ..Material::default() }
}

/// An unlit white material with the scene's texture 0 once over [0, 1].
pub fn textured() -> Material {
    let texture = TextureUse { texture: 0, second_uv: false, u_row: Vec3::X, v_row: Vec3::Y };
    Material { base_color_texture: Some(texture), ..unlit(Vec3::ONE) }
}

/// A texture whose texels all differ: red grows with u, green with v, and blue is a chequer.
pub fn uv_grid_texture(size: UVec2) -> TextureImage {
    let texel = |i: u32| {
        let (x, y) = (i % size.x, i / size.x);
        [(x * 255 / size.x) as u8, (y * 255 / size.y) as u8, if (x + y) % 2 == 0 { 230 } else { 20 }, 255]
    };
    let rgba8 = (0..size.x * size.y).map(texel).collect();
    TextureImage { name: "uv grid".into(), size, rgba8, srgb: true, wrap: [Wrap::Clamp; 2] }
}

/// A rectangle across the optical axis at z = `-depth_m`, facing a camera that looks along
/// -z, from `min` to `max` (metres, y up), texture upright.
pub fn quad(depth_m: f32, min: Vec2, max: Vec2, material: usize) -> Mesh {
    let corner = |x, y, u, v| Vertex {
        position: vec3(x, y, -depth_m),
        normal: Vec3::Z,
        tangent: Vec4::new(1.0, 0.0, 0.0, 1.0),
        uv: vec2(u, v),
        color: Vec4::ONE,
        ..Default::default()
    };
    let vertices = vec![
        corner(min.x, min.y, 0.0, 1.0),
        corner(max.x, min.y, 1.0, 1.0),
        corner(max.x, max.y, 1.0, 0.0),
        corner(min.x, max.y, 0.0, 0.0),
    ];
    Mesh { name: "quad".into(), vertices, indices: vec![0, 1, 2, 0, 2, 3], material }
}

/// A sphere of `rings` by `2 * rings` quads with its normals, facing outwards.
pub fn sphere(radius_m: f32, rings: u32, material: usize) -> Mesh {
    let columns = 2 * rings;
    let vertex = |i: u32| {
        let (ring, column) = (i / (columns + 1), i % (columns + 1));
        let (sin_polar, cos_polar) = (std::f32::consts::PI * ring as f32 / rings as f32).sin_cos();
        let (sin_around, cos_around) = (std::f32::consts::TAU * column as f32 / columns as f32).sin_cos();
        let normal = vec3(sin_polar * sin_around, cos_polar, sin_polar * cos_around);
        Vertex {
            position: normal * radius_m,
            normal,
            tangent: Vec4::new(cos_around, 0.0, -sin_around, 1.0),
            uv: vec2(column as f32 / columns as f32, ring as f32 / rings as f32),
            color: Vec4::ONE,
            ..Default::default()
        }
    };
    let cell = |i: u32| {
        let a = i / columns * (columns + 1) + i % columns;
        let b = a + columns + 1;
        [a, b, b + 1, a, b + 1, a + 1]
    };
    Mesh {
        name: "sphere".into(),
        vertices: (0..(rings + 1) * (columns + 1)).map(vertex).collect(),
        indices: (0..rings * columns).flat_map(cell).collect(),
        material,
    }
}

/// A scene of the meshes, each placed once where it is, with an 8x8 [`uv_grid_texture`].
pub fn scene(meshes: Vec<Mesh>, materials: Vec<Material>) -> Scene {
    let place = |mesh| Instance { mesh, world_from_object: DAffine3::IDENTITY };
    Scene {
        instances: (0..meshes.len()).map(place).collect(),
        meshes,
        materials,
        textures: vec![Arc::new(uv_grid_texture(uvec2(8, 8)))],
        ..Scene::default()
    }
}
