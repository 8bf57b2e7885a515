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
    shader!("lib/layers"),
    shader!("lib/lens"),
    shader!("lib/lens_rays"),
    shader!("lib/lens_views"),
    shader!("lib/listed_tiles"),
    shader!("lib/mipmap"),
    shader!("lib/mipmap_atlas"),
    shader!("lib/mipmap_discs"),
    shader!("lib/sampling"),
    shader!("lib/shading"),
    shader!("lib/sprites"),
    shader!("lib/subimages"),
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
        let bindings = globals.filter_map(|(_, global)| {
            let at = global.binding.as_ref()?;
            let uniform = (global.space == naga::AddressSpace::Uniform).then(|| self.uniform_layout(global.ty));
            Some((global.name.clone()?, Binding { group: at.group, binding: at.binding, uniform }))
        });
        Some(bindings.collect())
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
