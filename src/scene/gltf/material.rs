//! Materials, and which image each of them wants in which form.

use super::super::error::SceneProblem;
use super::super::{Material, TextureUse, Wrap};
use super::exact::{Exact, SpecularGlossiness};
use super::notes::Notes;
use ::gltf::Document;
use ::gltf::material::AlphaMode;
use ::gltf::texture::{Texture, TextureTransform, WrappingMode};
use glam::{Vec3, Vec4};
use std::collections::HashMap;

/// An image in the form in which a material samples it. The same image as colour and as
/// data makes two.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct TextureKey {
    /// Index into the document's images.
    pub image: usize,
    /// Whether RGB is sRGB-encoded.
    pub srgb: bool,
    /// Addressing outside [0, 1].
    pub wrap: [Wrap; 2],
}

/// A material as a primitive needs to know it.
#[derive(Clone, Copy)]
pub(super) struct MaterialUse {
    /// Index into the scene's materials.
    pub index: usize,
    /// The sets of texture coordinates that its textures use: the vertices' first and second.
    pub uv_sets: [Option<u32>; 2],
    /// Whether it has any texture.
    pub is_textured: bool,
    /// Its normal map.
    pub normal_map: Option<TextureUse>,
}

/// Materials in the order of their first use, with the textures they want.
pub(super) struct Materials<'a> {
    exact: &'a Exact,
    placed: HashMap<Option<usize>, MaterialUse>,
    materials: Vec<Material>,
    textures: Vec<TextureKey>,
    to_convert: Vec<(usize, SpecularGlossiness)>,
    unused: usize,
}

/// What is left to do when all materials are known.
pub(super) struct Finished {
    /// The materials.
    pub materials: Vec<Material>,
    /// The textures that they index.
    pub textures: Vec<TextureKey>,
    /// Materials whose colours and textures are of KHR_materials_pbrSpecularGlossiness.
    pub to_convert: Vec<(usize, SpecularGlossiness)>,
}

impl<'a> Materials<'a> {
    pub(super) fn new(document: &Document, exact: &'a Exact) -> Self {
        let unused = document.materials().len();
        let (placed, materials, textures, to_convert) = Default::default();
        Self { exact, placed, materials, textures, to_convert, unused }
    }

    /// Converts a material on its first use.
    pub(super) fn place(&mut self, source: &gltf::Material, notes: &mut Notes) -> Result<MaterialUse, SceneProblem> {
        if let Some(placed) = self.placed.get(&source.index()) {
            return Ok(*placed);
        }
        let placed = self.convert(source, notes)?;
        self.unused = self.unused.saturating_sub(usize::from(source.index().is_some()));
        self.placed.insert(source.index(), placed);
        Ok(placed)
    }

    /// All materials that were placed.
    pub(super) fn finish(self, notes: &mut Notes) -> Finished {
        if self.unused > 0 {
            notes.add(format!("{} materials are not used by anything drawn", self.unused), "");
        }
        Finished { materials: self.materials, textures: self.textures, to_convert: self.to_convert }
    }

    fn convert(&mut self, source: &gltf::Material, notes: &mut Notes) -> Result<MaterialUse, SceneProblem> {
        let name = match (source.name(), source.index()) {
            (Some(name), _) => name.to_owned(),
            (None, Some(index)) => format!("material {index}"),
            (None, None) => "default material".to_owned(),
        };
        let of_file = source.index().and_then(|index| self.exact.materials.get(index));
        let specular_glossiness = of_file.and_then(|material| material.extensions.specular_glossiness);
        let slots = slots(source, specular_glossiness.is_some());
        let uv_sets = uv_sets(&slots);
        let [base, rough, normal, emissive, transmission] = slots.map(|slot| {
            let slot = slot?;
            if let Some(second) = uv_sets.iter().position(|set| *set == Some(slot.uv_set)) {
                return Some(self.texture_use(&slot, second == 1));
            }
            notes.add(
                "textures that use a third set of texture coordinates are left out",
                format!("{name} ({})", slot.what),
            );
            None
        });
        let pbr = source.pbr_metallic_roughness();
        let material = Material {
            unlit: source.unlit(),
            base_color: Vec4::from(pbr.base_color_factor()),
            base_color_texture: base,
            metallic: pbr.metallic_factor(),
            roughness: pbr.roughness_factor(),
            metallic_roughness_texture: rough,
            normal_texture: normal,
            normal_scale: source.normal_texture().map_or(1.0, |texture| texture.scale()),
            emissive: emitted(source),
            emissive_texture: emissive,
            alpha_cutoff: alpha_cutoff(source),
            blended: source.alpha_mode() == AlphaMode::Blend,
            transmission: passes(source),
            transmission_texture: transmission,
            double_sided: source.double_sided(),
            name,
        };
        note_approximations(source, &material.name, notes);
        check(&material, source.index(), &self.materials)?;
        self.to_convert.extend(specular_glossiness.map(|factors| (self.materials.len(), factors)));
        self.materials.push(material);
        Ok(MaterialUse {
            index: self.materials.len() - 1,
            uv_sets,
            is_textured: [base, rough, normal, emissive, transmission].iter().any(Option::is_some),
            normal_map: normal,
        })
    }

    fn texture_use(&mut self, slot: &Slot, second_uv: bool) -> TextureUse {
        let known = self.textures.iter().position(|key| *key == slot.key);
        let texture = known.unwrap_or_else(|| {
            self.textures.push(slot.key);
            self.textures.len() - 1
        });
        TextureUse { texture, second_uv, u_row: slot.rows[0], v_row: slot.rows[1] }
    }
}

/// The first two different sets of texture coordinates in the order of the slots, and
/// TEXCOORD_0 for a material without textures.
fn uv_sets(slots: &[Option<Slot>; 5]) -> [Option<u32>; 2] {
    let mut used = slots.iter().flatten().map(|slot| slot.uv_set);
    let first = used.next().unwrap_or(0);
    [Some(first), used.find(|set| *set != first)]
}

/// One of a material's textures.
struct Slot {
    what: &'static str,
    key: TextureKey,
    uv_set: u32,
    rows: [Vec3; 2],
}

/// Base colour, metallic-roughness (a colour where it is specular and glossiness yet),
/// normal, emissive and transmission texture.
fn slots(source: &gltf::Material, is_specular: bool) -> [Option<Slot>; 5] {
    let pbr = source.pbr_metallic_roughness();
    let from_info = |what, info: gltf::texture::Info, srgb| {
        let transform = info.texture_transform();
        let uv_set = transform.as_ref().and_then(TextureTransform::tex_coord).unwrap_or(info.tex_coord());
        Slot { what, key: key(&info.texture(), srgb), uv_set, rows: transform.map_or(IDENTITY_ROWS, |t| rows(&t)) }
    };
    // Unlit materials have no use for the others.
    let lit = |slot: Option<Slot>| if source.unlit() { None } else { slot };
    let transmission = source.transmission().and_then(|transmission| transmission.transmission_texture());
    [
        pbr.base_color_texture().map(|info| from_info("base colour", info, true)),
        lit(pbr.metallic_roughness_texture().map(|info| from_info("metallic-roughness", info, is_specular))),
        lit(source.normal_texture().map(|texture| normal_slot(&texture))),
        lit(source.emissive_texture().map(|info| from_info("emissive", info, true))),
        lit(transmission.map(|info| from_info("transmission", info, false))),
    ]
}

/// The crate gives normal textures no typed transform, only the extension's JSON.
fn normal_slot(texture: &gltf::material::NormalTexture) -> Slot {
    let transform = texture.extension_value("KHR_texture_transform");
    let field = |name: &str| transform.and_then(|t| t.get(name));
    let pair = |name: &str, default: [f32; 2]| {
        field(name).and_then(|v| serde_json::from_value::<[f32; 2]>(v.clone()).ok()).unwrap_or(default)
    };
    let rotation = field("rotation").and_then(serde_json::Value::as_f64).unwrap_or(0.0) as f32;
    let uv_set = field("texCoord").and_then(serde_json::Value::as_u64).and_then(|set| u32::try_from(set).ok());
    Slot {
        what: "normal",
        key: key(&texture.texture(), false),
        uv_set: uv_set.unwrap_or(texture.tex_coord()),
        rows: transform_rows(pair("offset", [0.0; 2]), rotation, pair("scale", [1.0; 2])),
    }
}

const IDENTITY_ROWS: [Vec3; 2] = [Vec3::X, Vec3::Y];

fn rows(transform: &TextureTransform) -> [Vec3; 2] {
    transform_rows(transform.offset(), transform.rotation(), transform.scale())
}

/// KHR_texture_transform: `translation * rotation * scale`, where a positive rotation
/// turns the coordinates counter-clockwise as seen on an image whose v points down.
fn transform_rows(offset: [f32; 2], rotation_rad: f32, scale: [f32; 2]) -> [Vec3; 2] {
    let (sin, cos) = rotation_rad.sin_cos();
    [Vec3::new(cos * scale[0], sin * scale[1], offset[0]), Vec3::new(-sin * scale[0], cos * scale[1], offset[1])]
}

fn key(texture: &Texture, srgb: bool) -> TextureKey {
    let sampler = texture.sampler();
    TextureKey { image: texture.source().index(), srgb, wrap: [wrap(sampler.wrap_s()), wrap(sampler.wrap_t())] }
}

fn wrap(mode: WrappingMode) -> Wrap {
    match mode {
        WrappingMode::Repeat => Wrap::Repeat,
        WrappingMode::ClampToEdge => Wrap::Clamp,
        WrappingMode::MirroredRepeat => Wrap::Mirror,
    }
}

/// Emitted radiance. KHR_materials_unlit: the base colour is all that an unlit one shows.
fn emitted(source: &gltf::Material) -> Vec3 {
    if source.unlit() {
        return Vec3::ZERO;
    }
    Vec3::from(source.emissive_factor()) * source.emissive_strength().unwrap_or(1.0)
}

fn alpha_cutoff(source: &gltf::Material) -> Option<f32> {
    (source.alpha_mode() == AlphaMode::Mask).then(|| source.alpha_cutoff().unwrap_or(0.5))
}

/// Share of light that passes. An unlit material shows its base colour and nothing else.
fn passes(source: &gltf::Material) -> f32 {
    let transmission = source.transmission().filter(|_| !source.unlit());
    transmission.map_or(0.0, |transmission| transmission.transmission_factor().clamp(0.0, 1.0))
}

fn note_approximations(source: &gltf::Material, name: &str, notes: &mut Notes) {
    if passes(source) > 0.0 {
        notes.add(
            "light passes transmissive materials without being bent, and is dimmed by the mean of their colour instead of tinted",
            name,
        );
    }
    if source.occlusion_texture().is_some() {
        notes.add("occlusion textures are ignored", name);
    }
}

fn check(material: &Material, index: Option<usize>, known: &[Material]) -> Result<(), SceneProblem> {
    let transforms = [
        material.base_color_texture,
        material.metallic_roughness_texture,
        material.normal_texture,
        material.emissive_texture,
        material.transmission_texture,
    ];
    let finite = material.base_color.is_finite()
        && material.emissive.is_finite()
        && [material.metallic, material.roughness, material.normal_scale, material.transmission]
            .iter()
            .all(|x| x.is_finite())
        && material.alpha_cutoff.is_none_or(f32::is_finite)
        && transforms.iter().flatten().all(|t| t.u_row.is_finite() && t.v_row.is_finite());
    if finite {
        return Ok(());
    }
    let item = format!("materials[{}] {:?}", index.unwrap_or(known.len()), material.name);
    Err(SceneProblem::NotFinite { item, detail: "one of its factors or texture transforms".to_owned() })
}
