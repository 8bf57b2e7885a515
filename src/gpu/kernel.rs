//! Pipelines by shader and entry point, and bind groups by name.

use super::bind_groups::{BindGroups, Resource};
use super::frame::Target;
use super::reads::READS_BINDING;
use super::wgsl::{Binding, Module, Precision, Shader, ShaderError, Uniform};
use rustc_hash::FxHashMap;
use std::any::TypeId;
use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Mutex, OnceLock};

/// How a texture is filtered when a shader samples it by coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SamplerKind {
    /// Nearest texel, coordinates clamped.
    Nearest,
    /// Bilinear (and between levels), coordinates clamped.
    Linear,
}

pub(super) enum Pipeline {
    Compute(wgpu::ComputePipeline),
    Render(wgpu::RenderPipeline),
}

/// A binding of a kernel, by name.
struct Slot {
    name: String,
    binding: Binding,
    /// The program's struct that was found to have the shader's layout.
    checked: OnceLock<TypeId>,
}

/// One `@group` of a kernel.
struct Group {
    index: u32,
    layout: wgpu::BindGroupLayout,
    /// By `@binding`.
    slots: Vec<Slot>,
}

/// Most uniforms of a group: what WebGPU guarantees for a whole pipeline.
const MAX_UNIFORMS: usize = 8;

/// A bind group, ready to be set.
pub(super) struct Bindable {
    pub(super) index: u32,
    pub(super) group: wgpu::BindGroup,
    offsets: [u32; MAX_UNIFORMS],
    offset_count: usize,
}

impl Bindable {
    /// Offsets of its uniforms.
    pub(super) fn offsets(&self) -> &[u32] {
        &self.offsets[..self.offset_count]
    }
}

/// A compiled pipeline with what it binds.
pub(super) struct Kernel {
    pub(super) name: String,
    pub(super) pipeline: Pipeline,
    pub(super) workgroup_size: [u32; 3],
    groups: Vec<Group>,
    counts_reads: bool,
}

impl Kernel {
    fn slots(&self) -> impl Iterator<Item = &Slot> {
        self.groups.iter().flat_map(|group| &group.slots)
    }

    /// Errors in words unless `name` is a uniform with the layout of `U`.
    pub(super) fn check_uniform<U: Uniform>(&self, name: &str) -> Result<(), String> {
        let slot = self.slots().find(|slot| slot.name == name).ok_or_else(|| self.no_such_name(name))?;
        if slot.checked.get() == Some(&TypeId::of::<U>()) {
            return Ok(());
        }
        let layout = slot.binding.uniform.as_ref();
        let layout = layout.ok_or_else(|| format!("{}: {name} is not a uniform", self.name))?;
        U::check(layout).map_err(|e| format!("{}: uniform {name}: {e}", self.name))?;
        // Another type that fits as well is checked each time.
        let _ = slot.checked.set(TypeId::of::<U>());
        Ok(())
    }

    /// Whether it reads textures and counts that.
    pub(super) fn counts_reads(&self) -> bool {
        self.counts_reads
    }

    fn no_such_name(&self, name: &str) -> String {
        let names: Vec<_> = self.slots().map(|slot| slot.name.as_str()).collect();
        format!("{} binds no {name}; it binds {}", self.name, names.join(", "))
    }

    /// Bind groups in order, made where these resources were not bound together lately.
    /// Panics, naming kernel and resource, if a name is missing or unknown: that is a
    /// mistake in the program, which every run of the pass would show.
    pub(super) fn bind_groups(
        &self,
        made: &BindGroups,
        device: &wgpu::Device,
        bound: &[(&'static str, Resource)],
        frame: u64,
    ) -> Vec<Bindable> {
        let resource_of = |slot: &Slot| {
            let found = bound.iter().find(|(name, _)| *name == slot.name);
            &found.unwrap_or_else(|| panic!("{}: nothing is bound to {}", self.name, slot.name)).1
        };
        let slots: usize = self.groups.iter().map(|group| group.slots.len()).sum();
        // As many names as slots, and one for each: then none is unknown.
        if bound.len() != slots {
            for (name, _) in bound {
                assert!(self.slots().any(|slot| slot.name == *name), "{}", self.no_such_name(name));
            }
        }
        let bind = |group: &Group| {
            let (mut offsets, mut offset_count) = ([0; MAX_UNIFORMS], 0);
            let resources: Vec<&Resource> = group.slots.iter().map(resource_of).collect();
            for resource in &resources {
                if let Resource::Uniform(piece, _) = resource {
                    offsets[offset_count] = piece.offset;
                    offset_count += 1;
                }
            }
            let numbers = group.slots.iter().map(|slot| slot.binding.binding);
            let bindings = numbers.zip(resources.iter().copied());
            Bindable {
                index: group.index,
                group: made.get(device, &group.layout, bindings, frame),
                offsets,
                offset_count,
            }
        };
        self.groups.iter().map(bind).collect()
    }
}

/// The groups of an entry point, or of a vertex and a fragment entry together, and the
/// pipeline layout that they make.
fn groups(
    device: &wgpu::Device,
    name: &str,
    stages: &[(wgpu::ShaderStages, BTreeMap<String, Binding>)],
) -> (Vec<Group>, wgpu::PipelineLayout) {
    let mut all: BTreeMap<(u32, u32), (Slot, wgpu::ShaderStages)> = BTreeMap::new();
    for (stage, bindings) in stages {
        for (name, binding) in bindings {
            let slot = Slot { name: name.clone(), binding: binding.clone(), checked: OnceLock::new() };
            let entry = all.entry((binding.group, binding.binding)).or_insert((slot, wgpu::ShaderStages::empty()));
            entry.1 |= *stage;
            // A texture that one stage filters is bound as one that can be.
            if let wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable: true }, ..
            } = binding.ty
            {
                entry.0.binding.ty = binding.ty;
            }
        }
    }
    let count = all.keys().last().map_or(0, |(group, _)| group + 1);
    let mut groups = Vec::new();
    for index in 0..count {
        let of_group: Vec<_> = all.extract_if((index, 0)..(index + 1, 0), |_, _| true).collect();
        if of_group.is_empty() {
            continue;
        }
        let entry = |(_, (slot, visibility)): &(_, (Slot, wgpu::ShaderStages))| wgpu::BindGroupLayoutEntry {
            binding: slot.binding.binding,
            visibility: *visibility,
            ty: slot.binding.ty,
            count: None,
        };
        let entries: Vec<_> = of_group.iter().map(entry).collect();
        let descriptor = wgpu::BindGroupLayoutDescriptor { label: Some(name), entries: &entries };
        let layout = device.create_bind_group_layout(&descriptor);
        let slots = of_group.into_iter().map(|(_, (slot, _))| slot).collect();
        groups.push(Group { index, layout, slots });
    }
    let layout_of = |index| groups.iter().find(|group: &&Group| group.index == index).map(|group| &group.layout);
    let layouts: Vec<_> = (0..count).map(layout_of).collect();
    let descriptor =
        wgpu::PipelineLayoutDescriptor { label: Some(name), bind_group_layouts: &layouts, immediate_size: 0 };
    let layout = device.create_pipeline_layout(&descriptor);
    (groups, layout)
}

/// A shader of the program itself, without the counters that end every loop after a while.
///
/// On an H100 they took 12 % of the time of `adaptive` and 31 % of that of the former `mipmap`. All
/// other checks stay: reads and writes beyond textures, buffers and arrays are still defined.
#[allow(unsafe_code, reason = "wgpu leaves it to the caller that no loop is endless")]
pub(crate) fn embedded_module(device: &wgpu::Device, label: &str, source: &str) -> wgpu::ShaderModule {
    let source = wgpu::ShaderSource::Wgsl(source.into());
    let descriptor = wgpu::ShaderModuleDescriptor { label: Some(label), source };
    let mut checks = wgpu::ShaderRuntimeChecks::checked();
    checks.force_loop_bounding = false;
    // SAFETY: without loop bounding no loop may be endless. `tests/loops` proves of every
    // loop of every embedded shader that it ends; sources that a user loads are not made here.
    unsafe { device.create_shader_module_trusted(descriptor, checks) }
}

/// How a shader is compiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Build {
    pub(super) precision: Precision,
    /// Whether every texture read is counted.
    pub(super) counts_reads: bool,
}

/// Most targets of a draw.
pub(super) const MAX_TARGETS: usize = 4;

/// Targets of a draw, the first ones filled.
pub(super) type Targets = [Option<Target>; MAX_TARGETS];

/// Most switches of a pipeline.
const MAX_SWITCHES: usize = 6;

/// What a pipeline is made for: values of the `override` constants of its shader that are `bool`, by
/// name; those that are not named have the shader's own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Switches {
    values: [Option<(&'static str, bool)>; MAX_SWITCHES],
    /// Workgroup memory holds anything at the start, not zeros.
    uninitialized_memory: bool,
}

impl Switches {
    /// Those names and values, at most six.
    pub fn of<const N: usize>(values: [(&'static str, bool); N]) -> Self {
        values.into_iter().fold(Self::default(), |switches, (name, value)| switches.with(name, value))
    }

    /// One more of them. Panics if there are six.
    pub fn with(mut self, name: &'static str, value: bool) -> Self {
        let free = self.values.iter_mut().find(|value| value.is_none());
        *free.expect("a pipeline has at most six switches") = Some((name, value));
        self
    }

    /// For a shader that writes all of its workgroup memory before it reads it: zeros would be written
    /// for nothing.
    pub fn with_uninitialized_memory(self) -> Self {
        Self { uninitialized_memory: true, ..self }
    }

    fn constants(&self) -> Vec<(&'static str, f64)> {
        self.values.iter().flatten().map(|(name, value)| (*name, f64::from(u8::from(*value)))).collect()
    }
}

#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct KernelKey {
    shader: &'static str,
    switches: Switches,
    /// A compute entry alone, or vertex and fragment.
    entries: [&'static str; 2],
    build: Build,
    targets: Targets,
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
    kernels: Mutex<FxHashMap<KernelKey, Arc<Kernel>>>,
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
            let shader = match replaced.contains_key(shader.name) {
                false => embedded_module(&self.device, shader.name, &module.source),
                true => self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
                    label: Some(shader.name),
                    source: wgpu::ShaderSource::Wgsl(module.source.as_str().into()),
                }),
            };
            Arc::new(Compiled { shader, module })
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

    pub(super) fn compute(
        &self,
        shader: &Shader,
        entry: &'static str,
        switches: Switches,
        build: Build,
    ) -> Arc<Kernel> {
        let key = KernelKey {
            shader: shader.name,
            switches,
            entries: [entry, ""],
            build,
            targets: [None; MAX_TARGETS],
            topology: wgpu::PrimitiveTopology::TriangleList,
        };
        self.kernel(key, |_| {
            let compiled = self.module(shader, build);
            let name = format!("{}/{entry}", shader.name);
            let bindings = bindings(&compiled.module, entry);
            let counts_reads = bindings.contains_key(READS_BINDING);
            let (groups, layout) = groups(&self.device, &name, &[(wgpu::ShaderStages::COMPUTE, bindings)]);
            let mut sizes = compiled.module.entry_points().filter(|e| e.0 == entry).map(|e| e.1);
            let workgroup_size = sizes.next().unwrap_or([1; 3]);
            let pipeline = self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(&name),
                layout: Some(&layout),
                module: &compiled.shader,
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: &switches.constants(),
                    zero_initialize_workgroup_memory: !switches.uninitialized_memory,
                },
                cache: None,
            });
            Kernel { name, pipeline: Pipeline::Compute(pipeline), workgroup_size, groups, counts_reads }
        })
    }

    pub(super) fn render(
        &self,
        shader: &Shader,
        entries: [&'static str; 2],
        build: Build,
        topology: wgpu::PrimitiveTopology,
        targets: Targets,
    ) -> Arc<Kernel> {
        let switches = Switches::default();
        let key = KernelKey { shader: shader.name, switches, entries, build, targets, topology };
        let [vertex, fragment] = entries;
        self.kernel(key, |_| {
            let compiled = self.module(shader, build);
            let name = format!("{}/{fragment}", shader.name);
            let stages = [(wgpu::ShaderStages::VERTEX, vertex), (wgpu::ShaderStages::FRAGMENT, fragment)];
            let stages = stages.map(|(stage, entry)| (stage, bindings(&compiled.module, entry)));
            let counts_reads = stages.iter().any(|(_, bindings)| bindings.contains_key(READS_BINDING));
            let (groups, layout) = groups(&self.device, &name, &stages);
            let states: Vec<_> = targets.iter().flatten().map(|t| Some(t.state())).collect();
            let pipeline = self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(&name),
                layout: Some(&layout),
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
            Kernel { name, pipeline: Pipeline::Render(pipeline), workgroup_size: [1; 3], groups, counts_reads }
        })
    }
}

fn bindings(module: &Module, entry: &str) -> BTreeMap<String, Binding> {
    module.bindings(entry).unwrap_or_else(|| panic!("{} has no entry point {entry}", module.name))
}
