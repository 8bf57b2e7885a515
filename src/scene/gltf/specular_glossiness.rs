//! KHR_materials_pbrSpecularGlossiness by conversion to metallic-roughness: the formula of
//! the Khronos converter (glTF repository, "convert-between-workflows").

use super::super::error::SceneProblem;
use super::super::{Material, TextureImage, TextureUse};
use super::budget::Budget;
use super::exact::SpecularGlossiness;
use super::notes::Notes;
use crate::image_io::srgb::{linear_from_srgb8_table, srgb8_from_linear};
use glam::{UVec2, Vec3, Vec4};
use rayon::prelude::*;
use std::sync::Arc;

/// Reflectance of a dielectric at normal incidence.
const DIELECTRIC: f32 = 0.04;

/// A metallic-roughness surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MetallicRoughness {
    pub base_color: Vec4,
    pub metallic: f32,
    pub roughness: f32,
}

/// Converts a material: its factors alone, or with textures for every texel. The material
/// has its diffuse texture in the place of the base colour, and that of specular colour
/// and glossiness in the place of metalness and roughness.
pub(super) fn apply(
    material: &mut Material,
    factors: &SpecularGlossiness,
    textures: &mut Vec<Arc<TextureImage>>,
    budget: &mut Budget,
    notes: &mut Notes,
) -> Result<(), SceneProblem> {
    let topic = "specular-glossiness materials are converted to metallic-roughness";
    notes.add(topic, &material.name);
    let (diffuse, specular) = (Vec4::from(factors.diffuse_factor), Vec3::from(factors.specular_factor));
    let glossiness = factors.glossiness_factor;
    let (color, shine) = (material.base_color_texture, material.metallic_roughness_texture);
    let Some(lookup) = color.or(shine) else {
        let converted = convert(diffuse, specular, glossiness);
        (material.base_color, material.metallic) = (converted.base_color, converted.metallic);
        material.roughness = converted.roughness;
        return Ok(());
    };
    let like = |slot: TextureUse| TextureUse { texture: lookup.texture, ..slot } == lookup;
    if ![color, shine].into_iter().flatten().all(like) {
        notes.add("textures of a specular-glossiness material are looked up where its diffuse one is", &material.name);
    }
    let image = |slot: Option<TextureUse>| slot.map(|slot| textures[slot.texture].clone());
    let (color, shine) = (image(color), image(shine));
    let size = [&color, &shine].into_iter().flatten().fold(UVec2::ONE, |size, image| size.max(image.size));
    budget.pixels(2 * u64::from(size.x) * u64::from(size.y), &format!("the material {:?}", material.name))?;

    let decode = linear_from_srgb8_table();
    let texel = |image: &Option<Arc<TextureImage>>, x: u32, y: u32| match image {
        None => Vec4::ONE,
        Some(image) => {
            let at = UVec2::new(x, y).as_u64vec2() * image.size.as_u64vec2() / size.as_u64vec2();
            let [r, g, b, a] = image.rgba8[(at.y * u64::from(image.size.x) + at.x) as usize];
            Vec4::new(decode[r as usize], decode[g as usize], decode[b as usize], f32::from(a) / 255.0)
        }
    };
    let byte = |value: f32| (value * 255.0 + 0.5) as u8;
    let texels: Vec<([u8; 4], [u8; 4])> = (0..size.x * size.y)
        .into_par_iter()
        .map(|i| {
            let (x, y) = (i % size.x, i / size.x);
            let shine = texel(&shine, x, y);
            let converted = convert(diffuse * texel(&color, x, y), specular * shine.truncate(), glossiness * shine.w);
            let [r, g, b] = converted.base_color.truncate().to_array().map(srgb8_from_linear);
            ([r, g, b, byte(converted.base_color.w)], [0, byte(converted.roughness), byte(converted.metallic), 255])
        })
        .collect();
    let (base, rough): (Vec<_>, Vec<_>) = texels.into_iter().unzip();
    let wrap = textures[lookup.texture].wrap;
    let mut add = |what: &str, rgba8, srgb| {
        textures.push(Arc::new(TextureImage { name: format!("{what} of {}", material.name), size, rgba8, srgb, wrap }));
        Some(TextureUse { texture: textures.len() - 1, ..lookup })
    };
    let (base, rough) = (add("base colour", base, true), add("metalness and roughness", rough, false));
    (material.base_color_texture, material.metallic_roughness_texture) = (base, rough);
    (material.base_color, material.metallic, material.roughness) = (Vec4::ONE, 1.0, 1.0);
    Ok(())
}

/// The surface that looks like one of linear `diffuse` and `specular` colour.
pub(super) fn convert(diffuse: Vec4, specular: Vec3, glossiness: f32) -> MetallicRoughness {
    let rgb = diffuse.truncate();
    let not_reflected = 1.0 - specular.max_element();
    let metallic = metallic(brightness(rgb), brightness(specular), not_reflected);
    let from_diffuse = rgb * (not_reflected / (1.0 - DIELECTRIC) / (1.0 - metallic).max(1e-6));
    let from_specular = (specular - DIELECTRIC * (1.0 - metallic)) / metallic.max(1e-6);
    let color = from_diffuse.lerp(from_specular, metallic * metallic).clamp(Vec3::ZERO, Vec3::ONE);
    MetallicRoughness { base_color: color.extend(diffuse.w), metallic, roughness: 1.0 - glossiness.clamp(0.0, 1.0) }
}

/// How bright a colour looks.
fn brightness(color: Vec3) -> f32 {
    (color * color).dot(Vec3::new(0.299, 0.587, 0.114)).sqrt()
}

/// The metalness at which a base colour gives both brightnesses: the root of a quadratic.
fn metallic(diffuse: f32, specular: f32, not_reflected: f32) -> f32 {
    if specular < DIELECTRIC {
        return 0.0;
    }
    let a = DIELECTRIC;
    let b = diffuse * not_reflected / (1.0 - DIELECTRIC) + specular - 2.0 * DIELECTRIC;
    let c = DIELECTRIC - specular;
    let root = (b * b - 4.0 * a * c).max(0.0).sqrt();
    ((root - b) / (2.0 * a)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plastics_stay_and_metals_take_their_specular_colour() {
        let plastic = convert(Vec4::new(0.5, 0.2, 0.1, 0.7), Vec3::splat(DIELECTRIC), 0.25);
        assert!((plastic.base_color - Vec4::new(0.5, 0.2, 0.1, 0.7)).abs().max_element() < 1e-5, "{plastic:?}");
        assert!(plastic.metallic < 1e-5 && plastic.roughness == 0.75, "{plastic:?}");
        let gold = convert(Vec4::new(0.0, 0.0, 0.0, 1.0), Vec3::new(1.0, 0.7, 0.3), 1.0);
        assert!((gold.base_color.truncate() - Vec3::new(1.0, 0.7, 0.3)).abs().max_element() < 1e-4, "{gold:?}");
        assert!(gold.metallic > 0.999 && gold.roughness == 0.0, "{gold:?}");
    }
}
