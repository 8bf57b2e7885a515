//! Render pipelines of the scene rasteriser (`shaders/scene.wgsl`).

use crate::gpu::{Frame, Gpu, Module, Precision, Resource, Uniform};
use crate::{shader, uniform};
use std::collections::HashMap;
use std::sync::Mutex;

/// Bytes a vertex: position f32x3, normal and tangent snorm16x4, two uv f32x4, colour f32x4.
pub(super) const VERTEX_STRIDE: u64 = 12 + 8 + 8 + 16 + 16;

/// Bytes an instance: three rows of f32x4 that take object space to view space.
pub(super) const INSTANCE_STRIDE: u64 = 48;

uniform! {
    /// `View` in `scene.wgsl`.
    pub(super) struct ViewUniform {
        pub clip_from_view: [[f32; 4]; 4],
        pub environment: EnvironmentUniform,
        pub shading_eye: [f32; 3],
        pub z_near: f32,
        pub z_far: f32,
        pub texels_a_side: f32,
        pub below_part: [u32; 2],
        pub below_texels: u32,
        pub lens_point: u32,
        pub tone: u32,
        pub tone_scale: f32,
    }
}

uniform! {
    /// `Environment` in `shaders/lib/shading.wgsl`.
    pub struct EnvironmentUniform {
        /// World x axis in view space.
        pub view_from_world_x: [f32; 4],
        /// World y axis in view space.
        pub view_from_world_y: [f32; 4],
        /// World z axis in view space.
        pub view_from_world_z: [f32; 4],
        /// Radiance straight up.
        pub zenith: [f32; 4],
        /// Radiance at the horizon.
        pub horizon: [f32; 4],
        /// Radiance straight down.
        pub ground: [f32; 4],
        /// Radiance of the soft boxes.
        pub softbox: f32,
        /// Number of lights.
        pub light_count: u32,
        /// Padding to a multiple of 16 bytes.
        pub _pad: [u32; 2],
    }
}

uniform! {
    /// `Material` in `scene.wgsl`.
    pub(super) struct MaterialUniform {
        pub base_color: [f32; 4],
        pub emissive: [f32; 3],
        pub metallic: f32,
        pub roughness: f32,
        pub normal_scale: f32,
        pub alpha_cutoff: f32,
        pub transmission: f32,
        pub blended: u32,
        pub _pad: [u32; 3],
        pub uv_rows: [[f32; 4]; 10],
    }
}

/// `Light` in `scene.wgsl`, an element of a storage array.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct LightElement {
    pub position: [f32; 3],
    pub inverse_range: f32,
    pub direction: [f32; 3],
    pub kind: u32,
    pub intensity: [f32; 3],
    pub cos_inner: f32,
    pub cos_outer: f32,
    pub _pad: [u32; 3],
}

impl LightElement {
    /// A light without intensity.
    pub(super) const NONE: Self = Self {
        position: [0.0; 3],
        inverse_range: 0.0,
        direction: [0.0; 3],
        kind: 0,
        intensity: [0.0; 3],
        cos_inner: 0.0,
        cos_outer: 0.0,
        _pad: [0; 3],
    };
}

/// Key of a pipeline that draws surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct Variant {
    pub masked: bool,
    pub double_sided: bool,
    pub mirrored: bool,
    /// Bit k: the material has texture k.
    pub textures: u32,
    /// Whether surfaces show their base colour, whatever the light.
    pub unlit: bool,
    /// Whether it is drawn with several texels a pixel.
    pub fine: bool,
    /// Whether it may cover a part of what lies behind it.
    pub sheet: bool,
}

impl Variant {
    /// Values of the shader's constants.
    fn constants(self) -> [(&'static str, f64); 3] {
        [("TEXTURES", self.textures.into()), ("UNLIT", self.unlit.into()), ("FINE", self.fine.into())]
    }
}

/// What a pipeline draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Drawn {
    /// Surfaces of one kind.
    Surfaces(Variant),
    /// The background.
    Sky,
    /// A depth mask at the near plane where the layer holds nothing: fragments there fail the depth test
    /// before they are shaded.
    Closed,
}

/// Which layer is drawn: the nearest, or a farther one or slab, which drops fragments, or
/// one of those with what its surfaces are made of instead of what they show; or all slabs
/// at once, which are written to what the pass binds and not to targets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum LayerKind {
    Nearest,
    Farther,
    /// The nearest sheet below a bound, with its coverage.
    Sheets,
    Attributes,
    /// The nearest depth in each slab.
    SlabDepths,
    /// What the surfaces there show.
    Slabs,
    /// What they are made of.
    SlabSurfaces,
}

impl LayerKind {
    /// Formats of its targets.
    fn targets(self) -> &'static [wgpu::TextureFormat] {
        match self {
            Self::Nearest | Self::Farther | Self::Sheets => &[COLOR, STORED_DEPTH],
            Self::Attributes => &[COLOR, STORED_DEPTH, COLOR, COLOR],
            Self::SlabDepths | Self::Slabs | Self::SlabSurfaces => &[],
        }
    }

    /// Whether a depth buffer finds the nearest surface.
    fn tests_depth(self) -> bool {
        !self.targets().is_empty()
    }

    /// What a pass binds to group 2, in order.
    fn bound(self) -> Vec<wgpu::BindingType> {
        let storage = wgpu::BindingType::StorageTexture {
            access: wgpu::StorageTextureAccess::WriteOnly,
            format: COLOR,
            view_dimension: wgpu::TextureViewDimension::D2Array,
        };
        let depths = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2Array,
            multisampled: false,
        };
        let uniform = buffer(wgpu::BufferBindingType::Uniform, true);
        match self {
            Self::Nearest | Self::Farther | Self::Sheets | Self::Attributes => Vec::new(),
            Self::SlabDepths => vec![uniform, buffer(wgpu::BufferBindingType::Storage { read_only: false }, false)],
            Self::Slabs => vec![uniform, depths, storage],
            Self::SlabSurfaces => vec![uniform, depths, storage, storage, storage],
        }
    }
}

/// Formats of a layer: colour and stored depth.
pub(super) const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
pub(super) const STORED_DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;
pub(super) const DEPTH_BUFFER: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Pipelines, made when first used: each costs tens of milliseconds to compile.
pub(super) struct Pipelines {
    device: wgpu::Device,
    module: wgpu::ShaderModule,
    frame_layout: wgpu::BindGroupLayout,
    material_layout: wgpu::BindGroupLayout,
    layouts: Mutex<HashMap<LayerKind, Layouts>>,
    made: Mutex<HashMap<(LayerKind, Drawn), wgpu::RenderPipeline>>,
}

/// Layouts of what draws layers of one kind.
#[derive(Clone)]
struct Layouts {
    pipeline: wgpu::PipelineLayout,
    /// Of group 2, where there is one.
    slabs: Option<wgpu::BindGroupLayout>,
}

impl Pipelines {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let shader = shader!("scene");
        let module = Module::parse(shader.name, shader.source, Precision::Half).unwrap_or_else(|e| panic!("{e}"));
        check_uniforms(&module).unwrap_or_else(|e| panic!("{e}"));
        let device = gpu.device();
        let module = crate::gpu::embedded_module(device, "scene", &module.source);
        let frame_layout = frame_layout(device);
        let material_layout = material_layout(device);
        let (layouts, made) = (Mutex::default(), Mutex::default());
        Self { device: device.clone(), module, frame_layout, material_layout, layouts, made }
    }

    fn layouts(&self, kind: LayerKind) -> Layouts {
        let make = || {
            let bound: Vec<_> = kind.bound().into_iter().map(|ty| (ty, wgpu::ShaderStages::FRAGMENT)).collect();
            let slabs = (!bound.is_empty()).then(|| layout(&self.device, &bound));
            let groups = [Some(&self.frame_layout), Some(&self.material_layout), slabs.as_ref()];
            let pipeline = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("scene"),
                bind_group_layouts: &groups[..if slabs.is_some() { 3 } else { 2 }],
                immediate_size: 0,
            });
            Layouts { pipeline, slabs }
        };
        let mut layouts = self.layouts.lock().expect("no panic while a layout is made");
        layouts.entry(kind).or_insert_with(make).clone()
    }

    /// The pipeline that draws this into a layer of that kind.
    pub(super) fn get(&self, kind: LayerKind, drawn: Drawn) -> wgpu::RenderPipeline {
        let mut made = self.made.lock().expect("no panic while a pipeline is made");
        let make = || {
            let layout = self.layouts(kind).pipeline;
            match drawn {
                Drawn::Surfaces(variant) => surface_pipeline(&self.device, &layout, &self.module, kind, variant),
                Drawn::Sky => sky_pipeline(&self.device, &layout, &self.module, kind),
                Drawn::Closed => closed_pipeline(&self.device, &layout, &self.module, kind),
            }
        };
        made.entry((kind, drawn)).or_insert_with(make).clone()
    }

    /// Binds a [`ViewUniform`], the lights and the bound that surfaces lie below; the first
    /// by its offset, which is to be given when the group is set.
    pub(super) fn bind_frame(&self, frame: &Frame<'_>, bound: &[Resource; 3]) -> wgpu::BindGroup {
        frame.bind_group(&self.frame_layout, bound)
    }

    /// Binds what all slabs are drawn into: group 2. Panics for a kind that has targets.
    pub(super) fn bind_slabs(&self, frame: &Frame<'_>, kind: LayerKind, bound: &[Resource]) -> wgpu::BindGroup {
        let layout = self.layouts(kind).slabs.expect("a kind of slabs binds what it writes");
        frame.bind_group(&layout, bound)
    }

    pub(super) fn bind_material(
        &self,
        gpu: &Gpu,
        uniform: &wgpu::Buffer,
        textures: [&wgpu::TextureView; 5],
        samplers: &[wgpu::Sampler; 5],
    ) -> wgpu::BindGroup {
        let [base, rough, normal, emissive, transmission] = textures.map(wgpu::BindingResource::TextureView);
        let mut bound = vec![uniform.as_entire_binding(), base, rough, normal, emissive];
        bound.extend(samplers[..4].iter().map(wgpu::BindingResource::Sampler));
        bound.extend([transmission, wgpu::BindingResource::Sampler(&samplers[4])]);
        bind(gpu, &self.material_layout, bound.into_iter())
    }
}

/// Binds resources to bindings 0, 1, 2 ...
fn bind<'a>(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    resources: impl Iterator<Item = wgpu::BindingResource<'a>>,
) -> wgpu::BindGroup {
    let entry = |(i, resource)| wgpu::BindGroupEntry { binding: i as u32, resource };
    let entries: Vec<_> = resources.enumerate().map(entry).collect();
    gpu.device().create_bind_group(&wgpu::BindGroupDescriptor { label: Some("scene"), layout, entries: &entries })
}

fn check_uniforms(module: &Module) -> Result<(), String> {
    let bindings = module.bindings("fs_layer").ok_or("scene.wgsl has no entry point fs_layer")?;
    let layout = |name: &str| {
        let binding = bindings.get(name).ok_or(format!("scene.wgsl does not bind {name}"))?;
        binding.uniform.as_ref().ok_or(format!("{name} in scene.wgsl is not a uniform"))
    };
    ViewUniform::check(layout("view")?)?;
    MaterialUniform::check(layout("material")?)
}

fn layout(device: &wgpu::Device, types: &[(wgpu::BindingType, wgpu::ShaderStages)]) -> wgpu::BindGroupLayout {
    let entry = |(i, &(ty, visibility)): (usize, &(wgpu::BindingType, wgpu::ShaderStages))| {
        wgpu::BindGroupLayoutEntry { binding: i as u32, visibility, ty, count: None }
    };
    let entries: Vec<_> = types.iter().enumerate().map(entry).collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("scene"), entries: &entries })
}

fn buffer(ty: wgpu::BufferBindingType, has_dynamic_offset: bool) -> wgpu::BindingType {
    wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: None }
}

fn texture(filterable: bool) -> wgpu::BindingType {
    wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    }
}

fn frame_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    use wgpu::ShaderStages as Stages;
    let storage = buffer(wgpu::BufferBindingType::Storage { read_only: true }, false);
    layout(
        device,
        &[
            (buffer(wgpu::BufferBindingType::Uniform, true), Stages::VERTEX_FRAGMENT),
            (storage, Stages::FRAGMENT),
            (texture(false), Stages::FRAGMENT),
        ],
    )
}

fn material_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let mut types = vec![(buffer(wgpu::BufferBindingType::Uniform, false), wgpu::ShaderStages::FRAGMENT)];
    types.extend([(texture(true), wgpu::ShaderStages::FRAGMENT); 4]);
    let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
    types.extend([(sampler, wgpu::ShaderStages::FRAGMENT); 4]);
    types.extend([(texture(true), wgpu::ShaderStages::FRAGMENT), (sampler, wgpu::ShaderStages::FRAGMENT)]);
    layout(device, &types)
}

fn surface_pipeline(
    device: &wgpu::Device,
    layout: &wgpu::PipelineLayout,
    module: &wgpu::ShaderModule,
    kind: LayerKind,
    variant: Variant,
) -> wgpu::RenderPipeline {
    use wgpu::VertexFormat as Format;
    let attributes = wgpu::vertex_attr_array![
        0 => Float32x3, 1 => Snorm16x4, 2 => Snorm16x4, 3 => Float32x4, 4 => Float32x4];
    debug_assert_eq!(attributes[4].offset + Format::Float32x4.size(), VERTEX_STRIDE);
    let step_mode = wgpu::VertexStepMode::Vertex;
    let vertices = wgpu::VertexBufferLayout { array_stride: VERTEX_STRIDE, step_mode, attributes: &attributes };
    let rows = wgpu::vertex_attr_array![5 => Float32x4, 6 => Float32x4, 7 => Float32x4];
    let step_mode = wgpu::VertexStepMode::Instance;
    let instances = wgpu::VertexBufferLayout { array_stride: INSTANCE_STRIDE, step_mode, attributes: &rows };
    let fragment = match (kind, variant.masked) {
        (LayerKind::Sheets, _) => "fs_sheet",
        (LayerKind::Nearest, _) if variant.sheet => "fs_sampled_sheet",
        (LayerKind::Attributes, _) => "fs_attributes",
        (LayerKind::Farther, _) => "fs_layer",
        (LayerKind::Nearest, true) => "fs_masked",
        (LayerKind::Nearest, false) => "fs_opaque",
        (LayerKind::SlabDepths, true) => "fs_masked_slab_depths",
        (LayerKind::SlabDepths, false) => "fs_slab_depths",
        (LayerKind::Slabs, _) => "fs_slabs",
        (LayerKind::SlabSurfaces, _) => "fs_slab_surfaces",
    };
    let primitive = wgpu::PrimitiveState {
        front_face: if variant.mirrored { wgpu::FrontFace::Cw } else { wgpu::FrontFace::Ccw },
        cull_mode: (!variant.double_sided).then_some(wgpu::Face::Back),
        ..Default::default()
    };
    // Reversed depth: nearer is greater.
    let test = wgpu::CompareFunction::Greater;
    let buffers = [Some(vertices), Some(instances)];
    let constants = variant.constants();
    let geometry =
        Geometry { buffers: &buffers, primitive, test, writes: wgpu::ColorWrites::ALL, constants: &constants };
    let vertex = if variant.sheet { "vs_sheet" } else { "vs_surface" };
    pipeline(device, layout, module, [vertex, fragment], geometry, kind)
}

fn sky_pipeline(
    device: &wgpu::Device,
    layout: &wgpu::PipelineLayout,
    module: &wgpu::ShaderModule,
    kind: LayerKind,
) -> wgpu::RenderPipeline {
    let fragment = match kind {
        LayerKind::Nearest => "fs_sky",
        LayerKind::Farther | LayerKind::Sheets => "fs_sky_layer",
        LayerKind::Attributes => "fs_sky_attributes",
        LayerKind::SlabDepths => "fs_sky_slab_depths",
        LayerKind::Slabs => "fs_sky_slabs",
        LayerKind::SlabSurfaces => "fs_sky_slab_surfaces",
    };
    // At infinity, z = 0: passes only where nothing else was drawn.
    let test = wgpu::CompareFunction::GreaterEqual;
    pipeline(device, layout, module, ["vs_sky", fragment], Geometry::background(test), kind)
}

fn closed_pipeline(
    device: &wgpu::Device,
    layout: &wgpu::PipelineLayout,
    module: &wgpu::ShaderModule,
    kind: LayerKind,
) -> wgpu::RenderPipeline {
    let test = wgpu::CompareFunction::Always;
    let geometry = Geometry { writes: wgpu::ColorWrites::empty(), ..Geometry::background(test) };
    pipeline(device, layout, module, ["vs_closed", "fs_closed"], geometry, kind)
}

/// Vertex layout, primitive, depth test and colour writes of a pipeline.
struct Geometry<'a> {
    buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    primitive: wgpu::PrimitiveState,
    test: wgpu::CompareFunction,
    writes: wgpu::ColorWrites,
    /// Values of the shader's constants.
    constants: &'a [(&'a str, f64)],
}

impl Geometry<'_> {
    /// A triangle over all of the frame.
    fn background(test: wgpu::CompareFunction) -> Self {
        let writes = wgpu::ColorWrites::ALL;
        Self { buffers: &[], primitive: Default::default(), test, writes, constants: &[] }
    }
}

fn pipeline(
    device: &wgpu::Device,
    layout: &wgpu::PipelineLayout,
    module: &wgpu::ShaderModule,
    [vertex, fragment]: [&str; 2],
    geometry: Geometry<'_>,
    kind: LayerKind,
) -> wgpu::RenderPipeline {
    let target = |&format: &wgpu::TextureFormat| {
        Some(wgpu::ColorTargetState { format, blend: None, write_mask: geometry.writes })
    };
    let targets: Vec<_> = kind.targets().iter().map(target).collect();
    let test = if kind.tests_depth() { geometry.test } else { wgpu::CompareFunction::Always };
    let compilation_options = wgpu::PipelineCompilationOptions { constants: geometry.constants, ..Default::default() };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(fragment),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(vertex),
            compilation_options: compilation_options.clone(),
            buffers: geometry.buffers,
        },
        primitive: geometry.primitive,
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH_BUFFER,
            depth_write_enabled: Some(kind.tests_depth()),
            depth_compare: Some(test),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(fragment),
            compilation_options,
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}
