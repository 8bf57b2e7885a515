//! Compute passes and draws being described.

use super::targets::{Blend, Target, attachment};
use super::timing::Timer;
use super::{Frame, OpenPass};
use crate::gpu::bind_groups::Resource;
use crate::gpu::kernel::{Kernel, MAX_TARGETS, Pipeline, SamplerKind, Switches, Targets};
use crate::gpu::wgsl::{Shader, Uniform};
use crate::gpu::{Buffer, Texture};
use glam::UVec2;
use std::fmt::Display;
use std::sync::Arc;

/// Bindings that a pass has room for from the start.
const EXPECTED_BINDINGS: usize = 12;

/// A resource under its name in the shader.
pub(super) type Bound = (&'static str, Resource);

impl<'g> Frame<'g> {
    /// Starts a compute pass with the entry point `entry`, labelled with its name.
    pub fn pass<'f>(&'f mut self, shader: &Shader, entry: &'static str) -> Pass<'f, 'g> {
        self.specialized_pass(shader, entry, Switches::default())
    }

    /// As [`Frame::pass`], of a pipeline made for those values of the shader's `override` constants:
    /// it has no code for what they switch off.
    pub fn specialized_pass<'f>(
        &'f mut self,
        shader: &Shader,
        entry: &'static str,
        switches: Switches,
    ) -> Pass<'f, 'g> {
        let kernel = self.gpu.0.kernels.compute(shader, entry, switches, self.build());
        Pass { frame: self, entry, label: None, kernel, bound: Vec::with_capacity(EXPECTED_BINDINGS) }
    }

    /// Starts a draw with vertex and fragment entry points; vertices come from storage
    /// buffers or from the vertex index. Labelled with the fragment entry's name.
    pub fn draw<'f>(&'f mut self, shader: &'f Shader, vertex: &'static str, fragment: &'static str) -> Draw<'f, 'g> {
        let topology = wgpu::PrimitiveTopology::TriangleList;
        Draw {
            frame: self,
            shader,
            entries: [vertex, fragment],
            topology,
            bound: Vec::with_capacity(EXPECTED_BINDINGS),
            uniform_checks: Vec::new(),
            targets: Vec::new(),
        }
    }
}

/// A compute pass being described.
#[must_use = "a pass does nothing until it is dispatched"]
pub struct Pass<'f, 'g> {
    pub(super) frame: &'f mut Frame<'g>,
    pub(super) entry: &'static str,
    /// The label, with the prefix, where it is not the entry's name.
    pub(super) label: Option<String>,
    pub(super) kernel: Arc<Kernel>,
    pub(super) bound: Vec<Bound>,
}

macro_rules! binders {
    () => {
        /// Binds all levels and layers of a texture, to be read or (storage) written.
        pub fn texture(mut self, name: &'static str, texture: &Texture) -> Self {
            self.bound.push((name, Resource::View(texture.view().clone())));
            self
        }

        /// Binds one mipmap level of a texture, to be read or (storage) written.
        pub fn level(mut self, name: &'static str, texture: &Texture, level: u32) -> Self {
            self.bound.push((name, Resource::View(texture.level_view(level).clone())));
            self
        }

        /// Binds one mipmap level of one array layer as a plain texture, to be read or
        /// (storage) written.
        pub fn slice(mut self, name: &'static str, texture: &Texture, level: u32, layer: u32) -> Self {
            self.bound.push((name, Resource::View(texture.slice_view(level, layer).clone())));
            self
        }

        /// Binds a storage buffer.
        pub fn buffer(mut self, name: &'static str, buffer: &Buffer) -> Self {
            let resource = self.frame.used(buffer);
            self.bound.push((name, resource));
            self
        }

        /// Binds a sampler.
        pub fn sampler(mut self, name: &'static str, kind: SamplerKind) -> Self {
            self.bound.push((name, Resource::Sampler(self.frame.gpu.0.kernels.sampler(kind))));
            self
        }
    };
}

impl Pass<'_, '_> {
    binders!();

    /// Replaces the pass's label. It is only formatted where labels are read:
    /// `format_args!` costs nothing.
    pub fn label(mut self, label: impl Display) -> Self {
        if self.frame.wants_labels() {
            self.label = Some(format!("{}{label}", self.frame.prefix));
        }
        self
    }

    /// Uploads and binds a uniform. Panics if its layout differs from the shader's.
    pub fn uniform<U: Uniform>(mut self, name: &'static str, value: &U) -> Self {
        self.kernel.check_uniform::<U>(name).unwrap_or_else(|e| panic!("{e}"));
        let uniform = self.frame.uniform(value);
        self.bound.push((name, uniform));
        self
    }

    /// Runs one invocation for each element of `size` (and a few beyond: shaders check).
    pub fn dispatch(self, size: UVec2) {
        let [x, y, _] = self.kernel.workgroup_size;
        self.dispatch_groups(size.x.div_ceil(x), size.y.div_ceil(y), 1);
    }

    /// As [`Pass::dispatch`], once for each of `layers`: z of the grid is the layer.
    pub fn dispatch_layers(self, size: UVec2, layers: u32) {
        let [x, y, _] = self.kernel.workgroup_size;
        self.dispatch_groups(size.x.div_ceil(x), size.y.div_ceil(y), layers);
    }

    /// Runs a grid of workgroups.
    pub fn dispatch_groups(self, x: u32, y: u32, z: u32) {
        self.run(|pass| pass.dispatch_workgroups(x, y, z));
    }

    /// Runs the grid of workgroups whose three u32 lie at byte `offset` of `counts`, a buffer
    /// of [`Gpu::indirect_buffer`](crate::gpu::Gpu::indirect_buffer). They must not exceed the adapter's greatest grid: 65535
    /// on each axis anywhere.
    pub fn dispatch_indirect(self, counts: &Buffer, offset: u64) {
        self.frame.clear_unclean(counts);
        self.frame.stats.indirect_dispatches += 1;
        self.run(|pass| pass.dispatch_workgroups_indirect(counts.raw(), offset));
    }

    fn run(self, dispatch: impl FnOnce(&mut wgpu::ComputePass<'_>)) {
        let Self { frame, entry, label, kernel, bound } = self;
        let bound = frame.with_reads(&kernel, bound);
        let groups = kernel.bind_groups(&frame.gpu.0.bind_groups, frame.gpu.device(), &bound, frame.number);
        frame.stats.dispatches += 1;
        let slot = frame.timed(label.as_deref().unwrap_or(entry), label.is_none());
        // A pass that is timed stands alone.
        let is_timed = !matches!(frame.timer, Timer::None);
        if is_timed {
            frame.open = None;
        }
        let open = frame.open.take();
        let is_set = open.as_ref().is_some_and(|open| Arc::ptr_eq(&open.kernel, &kernel));
        let mut pass = match open {
            Some(open) => open.pass,
            None => {
                let timestamp_writes = slot.as_ref().map(|(query_set, first)| wgpu::ComputePassTimestampWrites {
                    query_set,
                    beginning_of_pass_write_index: Some(*first),
                    end_of_pass_write_index: Some(first + 1),
                });
                let label = is_timed.then_some(kernel.name.as_str());
                let descriptor = wgpu::ComputePassDescriptor { label, timestamp_writes };
                frame.encoder.get().begin_compute_pass(&descriptor).forget_lifetime()
            }
        };
        if let (Pipeline::Compute(pipeline), false) = (&kernel.pipeline, is_set) {
            pass.set_pipeline(pipeline);
        }
        for bindable in &groups {
            pass.set_bind_group(bindable.index, &bindable.group, bindable.offsets());
        }
        dispatch(&mut pass);
        frame.open = (!is_timed).then_some(OpenPass { pass, kernel });
    }
}

pub(super) type UniformCheck = fn(&Kernel, &str) -> Result<(), String>;

/// A draw being described.
#[must_use = "a draw does nothing until its vertices are named"]
pub struct Draw<'f, 'g> {
    pub(super) frame: &'f mut Frame<'g>,
    pub(super) shader: &'f Shader,
    pub(super) entries: [&'static str; 2],
    pub(super) topology: wgpu::PrimitiveTopology,
    pub(super) bound: Vec<Bound>,
    pub(super) uniform_checks: Vec<(&'static str, UniformCheck)>,
    pub(super) targets: Vec<(Target, wgpu::TextureView, wgpu::LoadOp<wgpu::Color>)>,
}

impl Draw<'_, '_> {
    binders!();

    /// Uploads and binds a uniform; its layout is checked when the draw runs.
    pub fn uniform<U: Uniform>(mut self, name: &'static str, value: &U) -> Self {
        self.uniform_checks.push((name, Kernel::check_uniform::<U>));
        let uniform = self.frame.uniform(value);
        self.bound.push((name, uniform));
        self
    }

    /// Draws triangle strips (quads of four vertices) instead of triangle lists.
    pub fn strips(mut self) -> Self {
        self.topology = wgpu::PrimitiveTopology::TriangleStrip;
        self
    }

    /// Adds a target; `clear` sets it before the draw, `None` keeps what is there.
    pub fn target(mut self, texture: &Texture, blend: Blend, clear: Option<[f64; 4]>) -> Self {
        let load = match clear {
            Some([r, g, b, a]) => wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a }),
            None => wgpu::LoadOp::Load,
        };
        let target = Target { format: texture.format(), blend };
        self.targets.push((target, texture.level_view(0).clone(), load));
        self
    }

    /// Draws `instances` copies of `vertices` vertices. Panics with more than four targets.
    pub fn vertices(self, vertices: u32, instances: u32) {
        self.run(|pass| pass.draw(0..vertices, 0..instances));
    }

    /// Draws what four u32 at byte `offset` of `counts`, a buffer of [`Gpu::indirect_buffer`](crate::gpu::Gpu::indirect_buffer),
    /// say: vertices, instances, first vertex and first instance (which must be 0). Panics with
    /// more than four targets.
    pub fn vertices_indirect(self, counts: &Buffer, offset: u64) {
        self.frame.clear_unclean(counts);
        self.run(|pass| pass.draw_indirect(counts.raw(), offset));
    }

    fn run(self, draw: impl FnOnce(&mut wgpu::RenderPass<'_>)) {
        let Self { frame, shader, entries, topology, bound, uniform_checks, targets } = self;
        assert!(targets.len() <= MAX_TARGETS, "{}: a draw has at most {MAX_TARGETS} targets", entries[1]);
        let gpu = frame.gpu;
        let of_kernel: Targets = std::array::from_fn(|i| targets.get(i).map(|t| t.0));
        let kernel = gpu.0.kernels.render(shader, entries, frame.build(), topology, of_kernel);
        for (name, check) in &uniform_checks {
            check(&kernel, name).unwrap_or_else(|e| panic!("{e}"));
        }
        let bound = frame.with_reads(&kernel, bound);
        let groups = kernel.bind_groups(&gpu.0.bind_groups, gpu.device(), &bound, frame.number);
        let slot = frame.timed(entries[1], true);
        let timestamp_writes = slot.as_ref().map(|(query_set, first)| wgpu::RenderPassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: Some(*first),
            end_of_pass_write_index: Some(first + 1),
        });
        let attachments: Vec<_> = targets.iter().map(|(_, view, load)| Some(attachment(view, *load))).collect();
        let mut pass = frame.encoder().begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(&kernel.name),
            color_attachments: &attachments,
            timestamp_writes,
            ..Default::default()
        });
        if let Pipeline::Render(pipeline) = &kernel.pipeline {
            pass.set_pipeline(pipeline);
        }
        for bindable in &groups {
            pass.set_bind_group(bindable.index, &bindable.group, bindable.offsets());
        }
        draw(&mut pass);
    }
}
