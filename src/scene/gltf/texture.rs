//! Images, decoded in parallel.

use super::super::TextureImage;
use super::super::error::SceneProblem;
use super::container::{Buffers, read_uri};
use super::material::TextureKey;
use ::gltf::Document;
use glam::UVec2;
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

struct Decoded {
    name: String,
    size: UVec2,
    rgba8: Vec<[u8; 4]>,
}

/// The wanted textures; images that no drawn material wants are not decoded.
pub(super) fn load(
    document: &Document,
    wanted: &[TextureKey],
    buffers: &Buffers,
    scene_path: &Path,
) -> Result<Vec<Arc<TextureImage>>, SceneProblem> {
    let sources: Vec<gltf::Image> = document.images().collect();
    let needed: Vec<usize> = wanted.iter().map(|key| key.image).collect::<BTreeSet<_>>().into_iter().collect();
    let decoded = needed
        .par_iter()
        .map(|&image| Ok((image, decode(document, &sources[image], buffers, scene_path)?)))
        .collect::<Result<std::collections::HashMap<_, _>, SceneProblem>>()?;
    let textures = wanted.iter().map(|key| {
        let Decoded { name, size, rgba8 } = &decoded[&key.image];
        let (name, size, rgba8) = (name.clone(), *size, rgba8.clone());
        Arc::new(TextureImage { name, size, rgba8, srgb: key.srgb, wrap: key.wrap })
    });
    Ok(textures.collect())
}

fn decode(
    document: &Document,
    source: &gltf::Image,
    buffers: &Buffers,
    scene_path: &Path,
) -> Result<Decoded, SceneProblem> {
    let index = source.index();
    let item = match source.name() {
        Some(name) => format!("images[{index}] {name:?}"),
        None => format!("images[{index}]"),
    };
    // The crate's own `Image::source` unwraps the media type, which files leave out.
    let json = &document.as_json().images[index];
    let bytes = match (&json.buffer_view, &json.uri) {
        (Some(view), _) => Cow::Borrowed(buffers.view_at(document, view.value())?),
        (None, Some(uri)) => Cow::Owned(read_uri(uri, &item, scene_path)?),
        (None, None) => return Err(SceneProblem::invalid(item, "has neither a uri nor a bufferView")),
    };
    // The format is told by the content: declared media types are often wrong. The
    // decoder's own limit on memory (512 MiB) refuses absurd sizes.
    let image =
        image::load_from_memory(&bytes).map_err(|e| SceneProblem::Image { item, detail: e.to_string() })?.into_rgba8();
    let size = UVec2::new(image.width(), image.height());
    let rgba8 = image.as_raw().as_chunks::<4>().0.to_vec();
    let name = source.name().map_or_else(|| format!("image {index}"), str::to_owned);
    Ok(Decoded { name, size, rgba8 })
}
