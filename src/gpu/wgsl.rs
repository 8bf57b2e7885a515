//! Shader sources: imports, validation and reflection, all without a GPU.

use super::reads::counting_reads;
use naga::valid::{Capabilities, ValidationFlags, Validator};
use std::collections::BTreeMap;

/// A WGSL file under `shaders/`, embedded in the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Shader {
    /// Path under `shaders/` without the extension, such as "methods/mipmap".
    pub name: &'static str,
    /// The file as it was when the program was built.
    pub source: &'static str,
}

/// Embeds `shaders/NAME.wgsl` as a [`Shader`].
#[macro_export]
macro_rules! shader {
    ($name:literal) => {
        $crate::gpu::Shader {
            name: $name,
            source: include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/", $name, ".wgsl")),
        }
    };
}

/// Files of functions, with the bindings of group 1 and up that some of them read, which
/// others take in with a line `#import NAME`.
const LIBRARY: &[Shader] = &[
    shader!("lib/color"),
    shader!("lib/emitters"),
    shader!("lib/four_layers"),
    shader!("lib/gather"),
    shader!("lib/hash"),
    shader!("lib/layers"),
    shader!("lib/lens"),
    shader!("lib/lens_rays"),
    shader!("lib/lens_views"),
    shader!("lib/listed_tiles"),
    shader!("lib/mipmap"),
    shader!("lib/mipmap_atlas"),
    shader!("lib/mipmap_discs"),
    shader!("lib/nearest_grid"),
    shader!("lib/ray_colors"),
    shader!("lib/sampling"),
    shader!("lib/scene_surface"),
    shader!("lib/shading"),
    shader!("lib/sheet_rays"),
    shader!("lib/splat"),
    shader!("lib/spots"),
    shader!("lib/sprites"),
    shader!("lib/staggered"),
    shader!("lib/subimage_pixels"),
    shader!("lib/subimages"),
    shader!("lib/thresholds"),
    shader!("lib/tile_lists"),
];

/// Storage format of intermediate colour images; shaders name it `COLOR_FORMAT`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Precision {
    /// RGBA16F: half the bandwidth, 11 bits of mantissa.
    #[default]
    Half,
    /// RGBA32F: to find out what f16 costs.
    Full,
}

impl Precision {
    /// The texture format that `COLOR_FORMAT` stands for.
    pub fn format(self) -> wgpu::TextureFormat {
        match self {
            Self::Half => wgpu::TextureFormat::Rgba16Float,
            Self::Full => wgpu::TextureFormat::Rgba32Float,
        }
    }

    fn wgsl_name(self) -> &'static str {
        match self {
            Self::Half => "rgba16float",
            Self::Full => "rgba32float",
        }
    }
}

/// A shader that does not parse or validate, with the compiler's message.
#[derive(Debug, Clone, thiserror::Error)]
#[error("shader {name} is not valid:\n{message}")]
pub struct ShaderError {
    /// [`Shader::name`].
    pub name: String,
    /// What the compiler says, with source lines.
    pub message: String,
}

/// Resolves `#import` lines (each library once, in order) and `COLOR_FORMAT`.
pub fn preprocess(name: &str, source: &str, precision: Precision) -> Result<String, ShaderError> {
    let mut text = String::new();
    expand(name, source, &mut Vec::new(), &mut text)?;
    Ok(text.replace("COLOR_FORMAT", precision.wgsl_name()))
}

fn expand(name: &str, source: &str, done: &mut Vec<&'static str>, text: &mut String) -> Result<(), ShaderError> {
    for line in source.lines() {
        let Some(import) = line.strip_prefix("#import ") else {
            text.push_str(line);
            text.push('\n');
            continue;
        };
        let path = format!("lib/{}", import.trim());
        let Some(library) = LIBRARY.iter().find(|library| library.name == path) else {
            let known: Vec<_> = LIBRARY.iter().map(|l| l.name.trim_start_matches("lib/")).collect();
            let message =
                format!("#import {}: there is no such library; there are {}", import.trim(), known.join(", "));
            return Err(ShaderError { name: name.into(), message });
        };
        if !done.contains(&library.name) {
            done.push(library.name);
            expand(library.name, library.source, done, text)?;
        }
    }
    Ok(())
}

/// What an entry point binds, by name.
#[derive(Clone, Debug)]
pub struct Binding {
    /// `@group`.
    pub group: u32,
    /// `@binding`.
    pub binding: u32,
    /// What may be bound; of a uniform with an offset that is given when it is bound.
    pub ty: wgpu::BindingType,
    /// For uniforms: the fields of the struct.
    pub uniform: Option<UniformLayout>,
}

/// Layout of a uniform struct as the shader declares it.
#[derive(Clone, Debug, PartialEq)]
pub struct UniformLayout {
    /// Size in bytes.
    pub size: u32,
    /// Name, byte offset and byte size of each member.
    pub fields: Vec<(String, u32, u32)>,
}

/// A parsed and validated shader.
#[derive(Debug)]
pub struct Module {
    /// [`Shader::name`].
    pub name: String,
    /// Source with imports resolved.
    pub source: String,
    module: naga::Module,
    info: naga::valid::ModuleInfo,
}

impl Module {
    /// Parses and validates `source`, the text of the shader called `name`.
    pub fn parse(name: &str, source: &str, precision: Precision) -> Result<Self, ShaderError> {
        Self::validated(name, preprocess(name, source, precision)?)
    }

    /// As [`Module::parse`], with every texture read counted (`gpu/reads.rs`).
    pub fn parse_counting(name: &str, source: &str, precision: Precision) -> Result<Self, ShaderError> {
        Self::validated(name, counting_reads(&preprocess(name, source, precision)?))
    }

    fn validated(name: &str, source: String) -> Result<Self, ShaderError> {
        let error = |message: String| ShaderError { name: name.into(), message };
        let module = naga::front::wgsl::parse_str(&source).map_err(|e| error(e.emit_to_string(&source)))?;
        let info = Validator::new(ValidationFlags::all(), Capabilities::all())
            .validate(&module)
            .map_err(|e| error(e.emit_to_string(&source)))?;
        Ok(Self { name: name.into(), source, module, info })
    }

    /// Names of all entry points with their workgroup sizes (zero for non-compute ones).
    pub fn entry_points(&self) -> impl Iterator<Item = (&str, [u32; 3])> {
        self.module.entry_points.iter().map(|e| (e.name.as_str(), e.workgroup_size))
    }

    /// Errors unless this can stand in for `earlier` in a running program: the same entry
    /// points that bind the same names, with uniforms of the same layout.
    pub fn check_stands_in_for(&self, earlier: &Self) -> Result<(), ShaderError> {
        let error = |message: String| Err(ShaderError { name: self.name.clone(), message });
        for (entry, _) in earlier.entry_points() {
            let Some(bindings) = self.bindings(entry) else {
                return error(format!("the entry point {entry} is gone, which the program calls: build it again"));
            };
            let before = earlier.bindings(entry).unwrap_or_default();
            let same = |(a, b): ((&String, &Binding), (&String, &Binding))| a.0 == b.0 && a.1.uniform == b.1.uniform;
            if bindings.len() != before.len() || !bindings.iter().zip(&before).all(same) {
                return error(format!("{entry} binds other things than the program gives it: build it again"));
            }
        }
        Ok(())
    }

    /// The bindings that `entry` uses, by name; `None` if there is no such entry point.
    pub fn bindings(&self, entry: &str) -> Option<BTreeMap<String, Binding>> {
        let index = self.module.entry_points.iter().position(|e| e.name == entry)?;
        let used = self.info.get_entry_point(index);
        let globals = self.module.global_variables.iter().filter(|(handle, _)| !used[*handle].is_empty());
        let bindings = globals.filter_map(|(handle, global)| {
            let at = global.binding.as_ref()?;
            let uniform = (global.space == naga::AddressSpace::Uniform).then(|| self.uniform_layout(global.ty));
            let filters = |sampler| !is_nearest(&self.module.global_variables[sampler]);
            let filtered = used.sampling_set.iter().any(|pair| pair.image == handle && filters(pair.sampler));
            let ty = self.binding_type(global, filtered);
            Some((global.name.clone()?, Binding { group: at.group, binding: at.binding, ty, uniform }))
        });
        Some(bindings.collect())
    }

    /// The naga module, for tests that look at what a shader does.
    pub fn naga(&self) -> (&naga::Module, &naga::valid::ModuleInfo) {
        (&self.module, &self.info)
    }

    /// What a variable takes; `filtered` says whether a texture is read through a sampler.
    fn binding_type(&self, global: &naga::GlobalVariable, filtered: bool) -> wgpu::BindingType {
        use naga::{AddressSpace, ImageClass, ScalarKind, StorageAccess, TypeInner};
        let buffer = |ty, has_dynamic_offset| {
            let min_binding_size =
                wgpu::BufferSize::new(self.module.types[global.ty].inner.size(self.module.to_ctx()).into());
            wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size }
        };
        match global.space {
            AddressSpace::Uniform => return buffer(wgpu::BufferBindingType::Uniform, true),
            AddressSpace::Storage { access } => {
                let read_only = !access.contains(StorageAccess::STORE);
                return buffer(wgpu::BufferBindingType::Storage { read_only }, false);
            }
            _ => {}
        }
        match self.module.types[global.ty].inner {
            TypeInner::Image { dim, arrayed, class } => {
                let view_dimension = view_dimension(dim, arrayed);
                match class {
                    ImageClass::Storage { format, access } => wgpu::BindingType::StorageTexture {
                        access: match (access.contains(StorageAccess::LOAD), access.contains(StorageAccess::STORE)) {
                            (true, true) => wgpu::StorageTextureAccess::ReadWrite,
                            (true, false) => wgpu::StorageTextureAccess::ReadOnly,
                            _ => wgpu::StorageTextureAccess::WriteOnly,
                        },
                        format: wgpu_naga_bridge::map_storage_format_from_naga(format),
                        view_dimension,
                    },
                    ImageClass::Sampled { multi, kind } => wgpu::BindingType::Texture {
                        sample_type: match kind {
                            ScalarKind::Sint => wgpu::TextureSampleType::Sint,
                            ScalarKind::Uint => wgpu::TextureSampleType::Uint,
                            _ => wgpu::TextureSampleType::Float { filterable: filtered },
                        },
                        view_dimension,
                        multisampled: multi,
                    },
                    ImageClass::Depth { multi } => wgpu::BindingType::Texture {
                        sample_type: wgpu::TextureSampleType::Depth,
                        view_dimension,
                        multisampled: multi,
                    },
                    ImageClass::External => wgpu::BindingType::ExternalTexture,
                }
            }
            TypeInner::Sampler { comparison: true } => wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison),
            TypeInner::Sampler { .. } if is_nearest(global) => {
                wgpu::BindingType::Sampler(wgpu::SamplerBindingType::NonFiltering)
            }
            _ => wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
        }
    }

    fn uniform_layout(&self, ty: naga::Handle<naga::Type>) -> UniformLayout {
        let size_of = |ty: naga::Handle<naga::Type>| self.module.types[ty].inner.size(self.module.to_ctx());
        let fields = match &self.module.types[ty].inner {
            naga::TypeInner::Struct { members, .. } => {
                members.iter().map(|m| (m.name.clone().unwrap_or_default(), m.offset, size_of(m.ty))).collect()
            }
            _ => Vec::new(),
        };
        UniformLayout { size: size_of(ty), fields }
    }
}

/// Whether a sampler is one that filters nothing, by its name: `nearest_...`. With it formats can be
/// gathered from that no adapter need filter, as R32F.
fn is_nearest(sampler: &naga::GlobalVariable) -> bool {
    sampler.name.as_deref().is_some_and(|name| name.starts_with("nearest_"))
}

fn view_dimension(dim: naga::ImageDimension, arrayed: bool) -> wgpu::TextureViewDimension {
    match (dim, arrayed) {
        (naga::ImageDimension::D1, _) => wgpu::TextureViewDimension::D1,
        (naga::ImageDimension::D2, false) => wgpu::TextureViewDimension::D2,
        (naga::ImageDimension::D2, true) => wgpu::TextureViewDimension::D2Array,
        (naga::ImageDimension::D3, _) => wgpu::TextureViewDimension::D3,
        (naga::ImageDimension::Cube, false) => wgpu::TextureViewDimension::Cube,
        (naga::ImageDimension::Cube, true) => wgpu::TextureViewDimension::CubeArray,
    }
}

/// A Rust struct that is uploaded as a uniform; made by [`uniform!`](crate::uniform).
pub trait Uniform: bytemuck::Pod {
    /// Name, byte offset and byte size of each field; names starting with `_` are padding.
    const FIELDS: &'static [(&'static str, usize, usize)];

    /// Errors in words unless the shader's struct has the same fields at the same places.
    fn check(layout: &UniformLayout) -> Result<(), String> {
        let ours: Vec<_> = Self::FIELDS.iter().filter(|f| !f.0.starts_with('_')).collect();
        let theirs: Vec<_> = layout.fields.iter().filter(|f| !f.0.starts_with('_')).collect();
        for (name, offset, size) in &theirs {
            match ours.iter().find(|f| f.0 == name) {
                None => return Err(format!("the shader has a field {name}, the program has not")),
                Some(f) if (f.1, f.2) != (*offset as usize, *size as usize) => {
                    return Err(format!(
                        "field {name} lies at byte {offset} with {size} bytes in the shader, at {} with {} in the program",
                        f.1, f.2
                    ));
                }
                Some(_) => {}
            }
        }
        if ours.len() != theirs.len() {
            return Err(format!("the program has {} fields, the shader {}", ours.len(), theirs.len()));
        }
        if size_of::<Self>() < layout.size as usize {
            return Err(format!("the program has {} bytes, the shader {}", size_of::<Self>(), layout.size));
        }
        Ok(())
    }
}

/// Declares a uniform struct: plain data whose layout is checked against the shader's.
#[macro_export]
macro_rules! uniform {
    ($(#[$meta:meta])* $vis:vis struct $name:ident { $($(#[$field_meta:meta])* $field_vis:vis $field:ident: $ty:ty),* $(,)? }) => {
        $(#[$meta])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
        $vis struct $name { $($(#[$field_meta])* $field_vis $field: $ty),* }

        impl $crate::gpu::Uniform for $name {
            const FIELDS: &'static [(&'static str, usize, usize)] =
                &[$((stringify!($field), std::mem::offset_of!($name, $field), std::mem::size_of::<$ty>())),*];
        }
    };
}
