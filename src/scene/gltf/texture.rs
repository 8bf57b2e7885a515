//! Images, decoded in parallel.

use super::super::error::SceneProblem;
use super::super::{Material, TextureImage, TextureUse};
#[cfg(feature = "basis")]
use super::basis;
use super::budget::Budget;
use super::container::{Buffers, read_uri};
use super::material::TextureKey;
use super::notes::Notes;
use crate::image_io::one_line;
use ::gltf::Document;
use glam::{UVec2, Vec3};
use image::{DynamicImage, ImageReader};
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::{BTreeSet, HashMap};
use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

/// Longest side of a texture, px: what every adapter takes. A larger image is halved.
const MAX_SIDE: u32 = 8192;

/// What is shown instead of a base colour that cannot be read: middle grey.
const GREY: [u8; 4] = [128, 128, 128, 255];

/// An image's pixels, or why there are none.
type Decoded = Result<Pixels, SceneProblem>;

struct Pixels {
    size: UVec2,
    rgba8: Vec<[u8; 4]>,
    was_shrunk: bool,
}

/// A wanted texture with its image, or why it is a grey pixel instead.
pub(super) struct Loaded {
    image: Arc<TextureImage>,
    problem: Option<String>,
    was_shrunk: bool,
}

/// The wanted textures; images that no drawn material wants are not decoded. An image that
/// is missing or does not decode is a problem of its texture, not of the file.
///
/// # Errors
///
/// Images larger than the file can stand for.
pub(super) fn load(
    document: &Document,
    wanted: &[TextureKey],
    buffers: &Buffers,
    budget: &mut Budget,
    scene_path: &Path,
) -> Result<Vec<Loaded>, SceneProblem> {
    let sources: Vec<gltf::Image> = document.images().collect();
    let needed: BTreeSet<usize> = wanted.iter().map(|key| key.image).collect();
    // Encoded bytes first, so that their sizes are known before anything is decoded.
    let mut encoded = Vec::new();
    for &index in &needed {
        let item = label(&sources[index]);
        let bytes = bytes_of(document, &sources[index], buffers, scene_path);
        if let Some((width, height)) = bytes.as_ref().ok().and_then(|bytes| dimensions(bytes)) {
            let copies = wanted.iter().filter(|key| key.image == index).count() as u64;
            budget.pixels(u64::from(width) * u64::from(height) * copies, &item)?;
        }
        encoded.push((index, item, bytes));
    }
    let decoded: HashMap<usize, Decoded> = encoded
        .into_par_iter()
        .map(|(index, item, bytes)| (index, bytes.and_then(|bytes| decode(&bytes, item))))
        .collect();
    let texture = |key: &TextureKey| {
        let name = sources[key.image].name().map_or_else(|| format!("image {}", key.image), str::to_owned);
        let (size, rgba8, problem, was_shrunk) = match &decoded[&key.image] {
            Ok(pixels) => (pixels.size, pixels.rgba8.clone(), None, pixels.was_shrunk),
            Err(problem) => (UVec2::ONE, vec![GREY], Some(problem.to_string()), false),
        };
        let image = Arc::new(TextureImage { name, size, rgba8, srgb: key.srgb, wrap: key.wrap });
        Loaded { image, problem, was_shrunk }
    };
    Ok(wanted.iter().map(texture).collect())
}

/// The textures, with materials and notes changed for those that could not be read: the
/// base colour is grey; without its texture, a surface is as rough and as metallic as its
/// factors say, flat, and emits nothing.
pub(super) fn keep_readable(
    loaded: Vec<Loaded>,
    materials: &mut [Material],
    notes: &mut Notes,
) -> Vec<Arc<TextureImage>> {
    let is_broken = |slot: &Option<TextureUse>| slot.is_some_and(|slot| loaded[slot.texture].problem.is_some());
    for material in materials {
        if is_broken(&material.metallic_roughness_texture) {
            material.metallic_roughness_texture = None;
        }
        if is_broken(&material.normal_texture) {
            material.normal_texture = None;
        }
        if is_broken(&material.transmission_texture) {
            material.transmission_texture = None;
        }
        if is_broken(&material.emissive_texture) {
            (material.emissive_texture, material.emissive) = (None, Vec3::ZERO);
        }
    }
    for texture in &loaded {
        if let Some(problem) = &texture.problem {
            notes.add("textures that cannot be read are shown grey", problem);
        }
        if texture.was_shrunk {
            notes.add(format!("textures larger than {MAX_SIDE} px are halved"), &texture.image.name);
        }
    }
    loaded.into_iter().map(|texture| texture.image).collect()
}

/// `images[3] "name"`.
fn label(source: &gltf::Image) -> String {
    match source.name() {
        Some(name) => format!("images[{}] {name:?}", source.index()),
        None => format!("images[{}]", source.index()),
    }
}

fn bytes_of<'a>(
    document: &Document,
    source: &gltf::Image,
    buffers: &'a Buffers,
    scene_path: &Path,
) -> Result<Cow<'a, [u8]>, SceneProblem> {
    // The crate's own `Image::source` unwraps the media type, which files leave out.
    let json = &document.as_json().images[source.index()];
    match (&json.buffer_view, &json.uri) {
        (Some(view), _) => Ok(Cow::Borrowed(buffers.view_at(document, view.value())?)),
        (None, Some(uri)) => Ok(Cow::Owned(read_uri(uri, &label(source), scene_path)?)),
        (None, None) => Err(SceneProblem::invalid(label(source), "has neither a uri nor a bufferView")),
    }
}

/// Width and height by the image's header, px.
fn dimensions(bytes: &[u8]) -> Option<(u32, u32)> {
    #[cfg(feature = "basis")]
    if basis::is_ktx2(bytes) {
        return basis::dimensions(bytes);
    }
    ImageReader::new(Cursor::new(bytes)).with_guessed_format().ok()?.into_dimensions().ok()
}

/// The format is told by the content: declared media types are often wrong. The decoder's
/// own limit on memory (512 MiB) refuses absurd sizes.
fn decode(bytes: &[u8], item: String) -> Decoded {
    let image = read(bytes).map_err(|detail| SceneProblem::Image { item, detail: one_line(&detail) })?;
    let was_shrunk = image.width().max(image.height()) > MAX_SIDE;
    let rgba = if was_shrunk { shrunk(&image) } else { image }.into_rgba8();
    let size = UVec2::new(rgba.width(), rgba.height());
    Ok(Pixels { size, rgba8: rgba.as_raw().as_chunks::<4>().0.to_vec(), was_shrunk })
}

fn read(bytes: &[u8]) -> Result<DynamicImage, String> {
    #[cfg(feature = "basis")]
    if basis::is_ktx2(bytes) {
        let (size, rgba8) = basis::decode(bytes)?;
        let image = image::RgbaImage::from_raw(size.x, size.y, rgba8.into_flattened());
        return image.map(DynamicImage::ImageRgba8).ok_or_else(|| "an image of another size than its own".to_owned());
    }
    image::load_from_memory(bytes).map_err(|e| e.to_string())
}

/// Halved, as often as it takes: each pixel the mean of those that it covers.
fn shrunk(image: &DynamicImage) -> DynamicImage {
    let halvings = (image.width().max(image.height()).div_ceil(MAX_SIDE)).next_power_of_two();
    image.thumbnail_exact((image.width() / halvings).max(1), (image.height() / halvings).max(1))
}
