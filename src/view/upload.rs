//! A scene on the GPU: what does not depend on the camera.

use super::pipelines::{MaterialUniform, Pipelines, VERTEX_STRIDE, Variant};
use crate::gpu::{Gpu, Texture, upload_scalar};
use crate::image::Image;
use crate::image_io::srgb::{linear_from_srgb8_table, srgb8_from_linear};
use crate::scene::{Environment, Light, Material, Mesh, Scene, TextureImage, TextureUse, Wrap};
use glam::{DVec3, Vec3, Vec4};
use rayon::prelude::*;
use std::sync::Arc;
use wgpu::util::DeviceExt;

/// How surfaces are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub struct SurfaceOptions {
    /// Base colours only, whatever the light.
    pub unlit: bool,
    /// Mipmapped, anisotropic texture filtering; without it, bilinear reads of the full
    /// texture, which is what the ray tracer does.
    pub mipmaps: bool,
}

impl Default for SurfaceOptions {
    fn default() -> Self {
        Self { unlit: false, mipmaps: true }
    }
}

/// A scene's meshes, textures and materials on the GPU; shared by views.
pub struct GpuScene {
    pub(super) gpu: Gpu,
    pub(super) pipelines: Arc<Pipelines>,
    pub(super) options: SurfaceOptions,
    pub(super) vertices: wgpu::Buffer,
    pub(super) indices: wgpu::Buffer,
    pub(super) materials: Vec<wgpu::BindGroup>,
    pub(super) draws: Vec<DrawItem>,
    pub(super) instances: Vec<GpuInstance>,
    pub(super) environment: Environment,
    pub(super) lights: Vec<Light>,
    /// Bound where a layer has no per-pixel limit: everything is farther.
    pub(super) unlimited: Texture,
}

/// All instances of one mesh that are drawn alike.
pub(super) struct DrawItem {
    pub variant: Variant,
    pub material: usize,
    pub indices: std::ops::Range<u32>,
    pub base_vertex: i32,
    /// Indices into [`GpuScene::instances`].
    pub instances: Vec<u32>,
    /// Most of an instance's surfaces that can lie behind one another.
    pub most_layers: u64,
}

impl DrawItem {
    /// Triangles of an instance.
    pub(super) fn triangles(&self) -> u64 {
        u64::from(self.indices.end - self.indices.start) / 3
    }
}

pub(super) struct GpuInstance {
    pub world_from_object: glam::DAffine3,
    /// Object-space bounding sphere.
    pub centre: DVec3,
    pub radius: f64,
}

impl GpuScene {
    /// Uploads a scene.
    pub fn new(gpu: &Gpu, scene: &Scene, options: SurfaceOptions) -> Arc<Self> {
        let pipelines = Arc::new(Pipelines::new(gpu));
        let (vertices, indices) = buffers(gpu, scene);
        Arc::new(Self {
            vertices,
            indices,
            materials: materials(gpu, &pipelines, scene, options),
            draws: draws(scene, &ranges(scene), options),
            instances: instances(scene),
            environment: scene.environment,
            lights: scene.lights.clone(),
            unlimited: upload_scalar(gpu, "unlimited", &Image::filled(glam::UVec2::ONE, f32::INFINITY)),
            gpu: gpu.clone(),
            pipelines,
            options,
        })
    }

    /// The same scene at another moment of an animation: `before` is what was uploaded, and
    /// `scene` has its textures and materials. Nothing of these is uploaded again, nor are meshes
    /// where none is bent.
    pub fn posed(&self, before: &Scene, scene: &Scene) -> Arc<Self> {
        let is_alike = |(a, b): (&Mesh, &Mesh)| a.indices == b.indices && a.vertices == b.vertices;
        let is_rigid =
            before.meshes.len() == scene.meshes.len() && before.meshes.iter().zip(&scene.meshes).all(is_alike);
        let (vertices, indices) =
            if is_rigid { (self.vertices.clone(), self.indices.clone()) } else { buffers(&self.gpu, scene) };
        Arc::new(Self {
            gpu: self.gpu.clone(),
            pipelines: self.pipelines.clone(),
            options: self.options,
            vertices,
            indices,
            materials: self.materials.clone(),
            draws: draws(scene, &ranges(scene), self.options),
            instances: instances(scene),
            environment: scene.environment,
            lights: scene.lights.clone(),
            unlimited: self.unlimited.clone(),
        })
    }

    /// Whether anything in it may cover only a part of what lies behind it.
    pub(super) fn has_sheets(&self) -> bool {
        self.draws.iter().any(|item| item.variant.sheet)
    }

    /// How surfaces are drawn.
    pub fn options(&self) -> SurfaceOptions {
        self.options
    }
}

type MeshRange = (std::ops::Range<u32>, i32);

/// Where each mesh lies in the buffers of all.
fn ranges(scene: &Scene) -> Vec<MeshRange> {
    let (mut base_vertex, mut first) = (0, 0);
    let range = |mesh: &Mesh| {
        let range = (first..first + mesh.indices.len() as u32, base_vertex);
        (base_vertex, first) = (base_vertex + mesh.vertices.len() as i32, range.0.end);
        range
    };
    scene.meshes.iter().map(range).collect()
}

/// Vertices and indices of all meshes.
fn buffers(gpu: &Gpu, scene: &Scene) -> (wgpu::Buffer, wgpu::Buffer) {
    let (vertices, indices) = geometry(scene);
    let init = |label, contents: &[u8], usage| gpu.lasting_buffer(label, contents, usage);
    let vertices = init("vertices", &vertices, wgpu::BufferUsages::VERTEX);
    (vertices, init("indices", bytemuck::cast_slice(&indices), wgpu::BufferUsages::INDEX))
}

fn geometry(scene: &Scene) -> (Vec<u8>, Vec<u32>) {
    let vertex_count: usize = scene.meshes.iter().map(|m| m.vertices.len()).sum();
    let mut vertices = Vec::with_capacity(vertex_count * VERTEX_STRIDE as usize);
    let mut indices = Vec::new();
    let snorm = |v: Vec4| v.to_array().map(|c| (c.clamp(-1.0, 1.0) * 32767.0).round() as i16);
    for mesh in &scene.meshes {
        for v in &mesh.vertices {
            vertices.extend_from_slice(bytemuck::bytes_of(&v.position));
            vertices.extend_from_slice(bytemuck::bytes_of(&snorm(v.normal.extend(0.0))));
            vertices.extend_from_slice(bytemuck::bytes_of(&snorm(v.tangent)));
            vertices.extend_from_slice(bytemuck::cast_slice(&[v.uv, v.uv1]));
            vertices.extend_from_slice(bytemuck::bytes_of(&v.color));
        }
        indices.extend_from_slice(&mesh.indices);
    }
    // A scene of nothing but a sky has buffers too, which must not be empty.
    if vertices.is_empty() {
        vertices.resize(VERTEX_STRIDE as usize, 0);
    }
    if indices.is_empty() {
        indices.push(0);
    }
    (vertices, indices)
}

fn instances(scene: &Scene) -> Vec<GpuInstance> {
    let spheres: Vec<_> = scene.meshes.iter().map(|m| m.bounds().unwrap_or_default()).collect();
    let of = |instance: &crate::scene::Instance| {
        let (low, high) = spheres[instance.mesh];
        let (low, high) = (low.as_dvec3(), high.as_dvec3());
        let (centre, radius) = ((low + high) * 0.5, (high - low).length() * 0.5);
        GpuInstance { world_from_object: instance.world_from_object, centre, radius }
    };
    scene.instances.iter().map(of).collect()
}

fn draws(scene: &Scene, ranges: &[MeshRange], options: SurfaceOptions) -> Vec<DrawItem> {
    let mut items: Vec<DrawItem> = Vec::new();
    let mut found = std::collections::HashMap::new();
    for (index, instance) in scene.instances.iter().enumerate() {
        let mesh = &scene.meshes[instance.mesh];
        let material = &scene.materials[mesh.material];
        let mirrored = instance.world_from_object.matrix3.determinant() < 0.0;
        let item = *found.entry((instance.mesh, mirrored)).or_insert_with(|| {
            let (indices, base_vertex) = ranges[instance.mesh].clone();
            let uses = texture_uses(material).into_iter().enumerate();
            let variant = Variant {
                masked: material.alpha_cutoff.is_some(),
                double_sided: material.double_sided,
                mirrored,
                textures: uses.map(|(slot, used)| u32::from(used.is_some()) << slot).sum(),
                unlit: material.unlit || options.unlit,
                fine: false,
                sheet: material.is_sheet(),
            };
            let most_layers = if mesh.is_flat() { 1 } else { mesh.indices.len() as u64 / 3 };
            let (material, instances) = (mesh.material, Vec::new());
            items.push(DrawItem { variant, material, indices, base_vertex, instances, most_layers });
            items.len() - 1
        });
        items[item].instances.push(index as u32);
    }
    // Opaque surfaces first: they hide most of what would run the costlier masked shader.
    items.sort_by_key(|item| (item.variant, item.material));
    items
}

fn materials(gpu: &Gpu, pipelines: &Pipelines, scene: &Scene, options: SurfaceOptions) -> Vec<wgpu::BindGroup> {
    let textures: Vec<_> = scene.textures.par_iter().map(|t| mip_chain(t, options.mipmaps)).collect();
    let textures: Vec<_> = scene.textures.iter().zip(textures).map(|(t, mips)| texture(gpu, t, &mips)).collect();
    let white = TextureImage {
        name: "white".into(),
        size: glam::UVec2::ONE,
        rgba8: vec![[255; 4]],
        srgb: false,
        wrap: [Wrap::Repeat; 2],
    };
    let white_view = texture(gpu, &white, std::slice::from_ref(&white.rgba8));
    let bind = |material: &Material| {
        let uses = texture_uses(material);
        let view = |slot: usize| uses[slot].map_or(&white_view, |u| &textures[u.texture]);
        let samplers = uses.map(|u| sampler(gpu, u.map_or(white.wrap, |u| scene.textures[u.texture].wrap), options));
        let uniform = uniform(material, &uses);
        let contents = bytemuck::bytes_of(&uniform);
        let usage = wgpu::BufferUsages::UNIFORM;
        let buffer = gpu.lasting_buffer("material", contents, usage);
        pipelines.bind_material(gpu, &buffer, [view(0), view(1), view(2), view(3), view(4)], &samplers)
    };
    scene.materials.iter().map(bind).collect()
}

fn texture_uses(material: &Material) -> [Option<TextureUse>; 5] {
    [
        material.base_color_texture,
        material.metallic_roughness_texture,
        material.normal_texture,
        material.emissive_texture,
        material.transmission_texture,
    ]
}

fn uniform(material: &Material, uses: &[Option<TextureUse>; 5]) -> MaterialUniform {
    let mut uv_rows = [[0.0; 4]; 10];
    for (slot, used) in uses.iter().enumerate() {
        let (u, v) = used.map_or((Vec3::X, Vec3::Y), |u| (u.u_row, u.v_row));
        let second_uv = used.is_some_and(|u| u.second_uv);
        uv_rows[2 * slot] = u.extend(if second_uv { 1.0 } else { 0.0 }).to_array();
        uv_rows[2 * slot + 1] = v.extend(0.0).to_array();
    }
    MaterialUniform {
        base_color: material.base_color.to_array(),
        emissive: material.emissive.to_array(),
        metallic: material.metallic,
        roughness: material.roughness,
        normal_scale: material.normal_scale,
        alpha_cutoff: material.alpha_cutoff.unwrap_or(-1.0),
        transmission: material.transmission,
        blended: material.blended.into(),
        uv_rows,
        ..Default::default()
    }
}

fn sampler(gpu: &Gpu, wrap: [Wrap; 2], options: SurfaceOptions) -> wgpu::Sampler {
    let address = |wrap| match wrap {
        Wrap::Repeat => wgpu::AddressMode::Repeat,
        Wrap::Clamp => wgpu::AddressMode::ClampToEdge,
        Wrap::Mirror => wgpu::AddressMode::MirrorRepeat,
    };
    gpu.device().create_sampler(&wgpu::SamplerDescriptor {
        address_mode_u: address(wrap[0]),
        address_mode_v: address(wrap[1]),
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        // 8 samples keep a floor's texture sharp to about 7 degrees of grazing.
        anisotropy_clamp: if options.mipmaps { 8 } else { 1 },
        ..Default::default()
    })
}

fn texture(gpu: &Gpu, image: &TextureImage, levels: &[Vec<[u8; 4]>]) -> wgpu::TextureView {
    let format = if image.srgb { wgpu::TextureFormat::Rgba8UnormSrgb } else { wgpu::TextureFormat::Rgba8Unorm };
    let data: Vec<u8> = levels.iter().flat_map(|level| bytemuck::cast_slice::<_, u8>(level)).copied().collect();
    let texture = gpu.device().create_texture_with_data(
        gpu.queue(),
        &wgpu::TextureDescriptor {
            label: Some(&image.name),
            size: wgpu::Extent3d { width: image.size.x, height: image.size.y, depth_or_array_layers: 1 },
            mip_level_count: levels.len() as u32,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        },
        wgpu::util::TextureDataOrder::LayerMajor,
        &data,
    );
    texture.create_view(&Default::default())
}

/// All mipmap levels, each the box average of the one before it, in linear light.
fn mip_chain(image: &TextureImage, mipmaps: bool) -> Vec<Vec<[u8; 4]>> {
    let mut levels = vec![image.rgba8.clone()];
    let mut size = image.size;
    let decode = if image.srgb { linear_from_srgb8_table() } else { std::array::from_fn(|v| v as f32 / 255.0) };
    let encode = |v: f32| if image.srgb { srgb8_from_linear(v) } else { (v * 255.0 + 0.5) as u8 };
    while mipmaps && size.max_element() > 1 {
        let next = (size / 2).max(glam::UVec2::ONE);
        let finer = &levels[levels.len() - 1];
        let texel = |x: u32, y: u32| finer[(y.min(size.y - 1) * size.x + x.min(size.x - 1)) as usize];
        let average = |i: u32| {
            let (x, y) = (2 * (i % next.x), 2 * (i / next.x));
            let four = [texel(x, y), texel(x + 1, y), texel(x, y + 1), texel(x + 1, y + 1)];
            let mean = |c: usize| four.iter().map(|t| decode[t[c] as usize]).sum::<f32>() * 0.25;
            let alpha = four.iter().map(|t| u32::from(t[3])).sum::<u32>().div_ceil(4).min(255) as u8;
            [encode(mean(0)), encode(mean(1)), encode(mean(2)), alpha]
        };
        let level = (0..next.x * next.y).into_par_iter().map(average).collect();
        levels.push(level);
        size = next;
    }
    levels
}
