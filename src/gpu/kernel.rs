//! Pipelines by shader and entry point, and bind groups by name.

use super::frame::Target;
use super::reads::READS_BINDING;
use super::wgsl::{Binding, Module, Precision, Shader, ShaderError, Uniform};
use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Mutex};

/// How a texture is filtered when a shader samples it by coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SamplerKind {
    /// Nearest texel, coordinates clamped.
    Nearest,
    /// Bilinear (and between levels), coordinates clamped.
    Linear,
}

/// Something bound to a name.
#[derive(Clone)]
pub(super) enum Resource {
    View(wgpu::TextureView),
    Buffer(wgpu::Buffer),
    Sampler(wgpu::Sampler),
}

pub(super) enum Pipeline {
    Compute(wgpu::ComputePipeline),
    Render(wgpu::RenderPipeline),
}

/// A compiled pipeline with what it binds.
pub(super) struct Kernel {
    pub(super) name: String,
    pub(super) pipeline: Pipeline,
    pub(super) workgroup_size: [u32; 3],
    bindings: BTreeMap<String, Binding>,
}

impl Kernel {
    /// Errors in words unless `name` is a uniform with the layout of `U`.
    pub(super) fn check_uniform<U: Uniform>(&self, name: &str) -> Result<(), String> {
        let binding = self.bindings.get(name).ok_or_else(|| self.no_such_name(name))?;
        let layout = binding.uniform.as_ref().ok_or_else(|| format!("{}: {name} is not a uniform", self.name))?;
        U::check(layout).map_err(|e| format!("{}: uniform {name}: {e}", self.name))
    }

    /// Whether it reads textures and counts that.
    pub(super) fn counts_reads(&self) -> bool {
        self.bindings.contains_key(READS_BINDING)
    }

    fn no_such_name(&self, name: &str) -> String {
        let names: Vec<_> = self.bindings.keys().map(String::as_str).collect();
        format!("{} binds no {name}; it binds {}", self.name, names.join(", "))
    }

    /// Bind groups in order. Panics, naming kernel and resource, if a name is missing or
    /// unknown: that is a mistake in the program, which every run of the pass would show.
    pub(super) fn bind_groups(
        &self,
        device: &wgpu::Device,
        bound: &[(&'static str, Resource)],
    ) -> Vec<(u32, wgpu::BindGroup)> {
        for (name, _) in bound {
            assert!(self.bindings.contains_key(*name), "{}", self.no_such_name(name));
        }
        let mut groups: BTreeMap<u32, Vec<wgpu::BindGroupEntry<'_>>> = BTreeMap::new();
        for (name, binding) in &self.bindings {
            let resource = bound.iter().find(|(n, _)| n == name).map(|(_, r)| r);
            let resource = resource.unwrap_or_else(|| panic!("{}: nothing is bound to {name}", self.name));
            let resource = match resource {
                Resource::View(view) => wgpu::BindingResource::TextureView(view),
                Resource::Buffer(buffer) => buffer.as_entire_binding(),
                Resource::Sampler(sampler) => wgpu::BindingResource::Sampler(sampler),
            };
            let entry = wgpu::BindGroupEntry { binding: binding.binding, resource };
            groups.entry(binding.group).or_default().push(entry);
        }
        let label = Some(self.name.as_str());
        let bind = |(group, entries): (u32, Vec<wgpu::BindGroupEntry<'_>>)| {
            let layout = match &self.pipeline {
                Pipeline::Compute(pipeline) => pipeline.get_bind_group_layout(group),
                Pipeline::Render(pipeline) => pipeline.get_bind_group_layout(group),
            };
            let descriptor = wgpu::BindGroupDescriptor { label, layout: &layout, entries: &entries };
            (group, device.create_bind_group(&descriptor))
        };
        groups.into_iter().map(bind).collect()
    }
}

/// How a shader is compiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Build {
    pub(super) precision: Precision,
    /// Whether every texture read is counted.
    pub(super) counts_reads: bool,
}

#[derive(Clone, PartialEq, Eq, Hash)]
struct KernelKey {
    shader: &'static str,
    entries: Vec<String>,
    build: Build,
    targets: Vec<Target>,
    topology: wgpu::PrimitiveTopology,
}

struct Compiled {
    module: Module,
    shader: wgpu::ShaderModule,
}

/// Compiled shaders and pipelines, made when first used.
pub(super) struct Kernels {
    device: wgpu::Device,
    replaced: Mutex<HashMap<String, String>>,
    modules: Mutex<HashMap<(&'static str, Build), Arc<Compiled>>>,
    kernels: Mutex<HashMap<KernelKey, Arc<Kernel>>>,
    samplers: [wgpu::Sampler; 2],
}

const UNPOISONED: &str = "no panic while a cache is locked";

impl Kernels {
    pub(super) fn new(device: &wgpu::Device) -> Self {
        let sampler = |filter: wgpu::FilterMode| {
            let mipmap_filter = match filter {
                wgpu::FilterMode::Nearest => wgpu::MipmapFilterMode::Nearest,
                wgpu::FilterMode::Linear => wgpu::MipmapFilterMode::Linear,
            };
            let descriptor =
                wgpu::SamplerDescriptor { mag_filter: filter, min_filter: filter, mipmap_filter, ..Default::default() };
            device.create_sampler(&descriptor)
        };
        Self {
            device: device.clone(),
            replaced: Mutex::default(),
            modules: Mutex::default(),
            kernels: Mutex::default(),
            samplers: [sampler(wgpu::FilterMode::Nearest), sampler(wgpu::FilterMode::Linear)],
        }
    }

    pub(super) fn sampler(&self, kind: SamplerKind) -> wgpu::Sampler {
        self.samplers[kind as usize].clone()
    }

    pub(super) fn replace(&self, name: &str, source: &str) -> Result<(), ShaderError> {
        Module::parse(name, source, Precision::Half)?;
        self.replaced.lock().expect(UNPOISONED).insert(name.into(), source.into());
        self.modules.lock().expect(UNPOISONED).retain(|(n, _), _| *n != name);
        self.kernels.lock().expect(UNPOISONED).retain(|key, _| key.shader != name);
        Ok(())
    }

    fn module(&self, shader: &Shader, build: Build) -> Arc<Compiled> {
        let mut modules = self.modules.lock().expect(UNPOISONED);
        let compile = || {
            let replaced = self.replaced.lock().expect(UNPOISONED);
            let source = replaced.get(shader.name).map_or(shader.source, String::as_str);
            // Embedded shaders are validated by the tests, replaced ones when they come in.
            let parse = if build.counts_reads { Module::parse_counting } else { Module::parse };
            let module = parse(shader.name, source, build.precision).unwrap_or_else(|e| panic!("{e}"));
            let source = wgpu::ShaderSource::Wgsl(module.source.as_str().into());
            let descriptor = wgpu::ShaderModuleDescriptor { label: Some(shader.name), source };
            Arc::new(Compiled { shader: self.device.create_shader_module(descriptor), module })
        };
        modules.entry((shader.name, build)).or_insert_with(compile).clone()
    }

    fn kernel(&self, key: KernelKey, make: impl FnOnce(&KernelKey) -> Kernel) -> Arc<Kernel> {
        let mut kernels = self.kernels.lock().expect(UNPOISONED);
        if let Some(kernel) = kernels.get(&key) {
            return kernel.clone();
        }
        let kernel = Arc::new(make(&key));
        kernels.insert(key, kernel.clone());
        kernel
    }

    pub(super) fn compute(&self, shader: &Shader, entry: &str, build: Build) -> Arc<Kernel> {
        let key = KernelKey {
            shader: shader.name,
            entries: vec![entry.into()],
            build,
            targets: Vec::new(),
            topology: wgpu::PrimitiveTopology::TriangleList,
        };
        self.kernel(key, |_| {
            let compiled = self.module(shader, build);
            let name = format!("{}/{entry}", shader.name);
            let bindings = bindings(&compiled.module, entry);
            let mut sizes = compiled.module.entry_points().filter(|e| e.0 == entry).map(|e| e.1);
            let workgroup_size = sizes.next().unwrap_or([1; 3]);
            let pipeline = self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(&name),
                layout: None,
                module: &compiled.shader,
                entry_point: Some(entry),
                compilation_options: Default::default(),
                cache: None,
            });
            Kernel { name, pipeline: Pipeline::Compute(pipeline), workgroup_size, bindings }
        })
    }

    pub(super) fn render(
        &self,
        shader: &Shader,
        [vertex, fragment]: [&str; 2],
        build: Build,
        topology: wgpu::PrimitiveTopology,
        targets: &[Target],
    ) -> Arc<Kernel> {
        let entries = vec![vertex.to_owned(), fragment.to_owned()];
        let key = KernelKey { shader: shader.name, entries, build, targets: targets.to_vec(), topology };
        self.kernel(key, |_| {
            let compiled = self.module(shader, build);
            let name = format!("{}/{fragment}", shader.name);
            let mut all = bindings(&compiled.module, vertex);
            all.extend(bindings(&compiled.module, fragment));
            let states: Vec<_> = targets.iter().map(|t| Some(t.state())).collect();
            let pipeline = self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(&name),
                layout: None,
                vertex: wgpu::VertexState {
                    module: &compiled.shader,
                    entry_point: Some(vertex),
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState { topology, ..Default::default() },
                depth_stencil: None,
                multisample: Default::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &compiled.shader,
                    entry_point: Some(fragment),
                    compilation_options: Default::default(),
                    targets: &states,
                }),
                multiview_mask: None,
                cache: None,
            });
            Kernel { name, pipeline: Pipeline::Render(pipeline), workgroup_size: [1; 3], bindings: all }
        })
    }
}

fn bindings(module: &Module, entry: &str) -> BTreeMap<String, Binding> {
    module.bindings(entry).unwrap_or_else(|| panic!("{} has no entry point {entry}", module.name))
}
