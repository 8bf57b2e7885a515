//! Checks on the JSON before the `gltf` crate's accessors may touch it.

use super::super::error::SceneProblem;
use super::notes::Notes;
use ::gltf::json::{self, validation};
use ::gltf::{Document, Semantic};

/// Required extensions that are honoured, or whose absence changes shading alone.
const SUPPORTED_EXTENSIONS: &[&str] = &[
    "KHR_lights_punctual",
    "KHR_materials_unlit",
    "KHR_materials_emissive_strength",
    "KHR_materials_specular",
    "KHR_materials_ior",
    "KHR_materials_transmission",
    "KHR_texture_transform",
    "KHR_mesh_quantization",
];

/// The validated document.
pub(super) fn document(root: json::Root) -> Result<Document, SceneProblem> {
    check_extensions(&root)?;
    check_positions(&root)?;
    let mut first = None;
    validation::Validate::validate(&root, &root, json::Path::new, &mut |path, error| {
        if first.is_none() && matters(path().as_str(), error) {
            first = Some((path().as_str().to_owned(), error));
        }
    });
    if let Some((item, error)) = first {
        return Err(SceneProblem::invalid(item, describe(error)));
    }
    Ok(Document::from_json_without_validation(root))
}

fn check_extensions(root: &json::Root) -> Result<(), SceneProblem> {
    let unsupported = root.extensions_required.iter().find(|name| !SUPPORTED_EXTENSIONS.contains(&name.as_str()));
    let Some(name) = unsupported else { return Ok(()) };
    let hint = match name.as_str() {
        "KHR_draco_mesh_compression" | "EXT_meshopt_compression" => ", that is with uncompressed meshes",
        "KHR_texture_basisu" | "EXT_texture_webp" | "EXT_texture_avif" => ", that is with PNG or JPEG images",
        _ => "",
    };
    Err(SceneProblem::RequiredExtension { name: name.clone(), hint })
}

/// The crate's own validation indexes accessors with POSITION before it checks the index.
fn check_positions(root: &json::Root) -> Result<(), SceneProblem> {
    let key = validation::Checked::Valid(Semantic::Positions);
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let item = format!("meshes[{m}].primitives[{p}].attributes.POSITION");
            match primitive.attributes.get(&key) {
                None => return Err(SceneProblem::invalid(item, "is missing")),
                Some(index) if index.value() >= root.accessors.len() => {
                    return Err(SceneProblem::invalid(item, describe(validation::Error::IndexOutOfBounds)));
                }
                Some(_) => {}
            }
        }
    }
    Ok(())
}

/// Whether an error of the crate's validation is one: required extensions have their own
/// check, bounds are computed from the vertices, and attributes of unknown meaning (those
/// of an application begin with `_`) are ignored.
fn matters(path: &str, error: validation::Error) -> bool {
    let bounds = path.ends_with(".min") || path.ends_with(".max");
    let unknown_attribute = path.contains(".attributes[") && matches!(error, validation::Error::Invalid);
    !(path.starts_with("extensionsRequired") || bounds || unknown_attribute)
}

fn describe(error: validation::Error) -> &'static str {
    match error {
        validation::Error::IndexOutOfBounds => "refers to something that is not in the file",
        validation::Error::Invalid => "has a value that glTF does not allow",
        validation::Error::Missing => "is missing",
        validation::Error::Oversize => "is larger than this machine can address",
        validation::Error::Unsupported => "is not supported",
    }
}

/// Notes the features that this loader draws in their rest state or not at all.
pub(super) fn note_what_is_left_out(document: &Document, notes: &mut Notes) {
    if document.animations().len() > 0 {
        notes.add("animations are not played: the rest pose is shown", "");
    }
    if document.skins().len() > 0 {
        notes.add("skins are not applied: the rest pose is shown", "");
    }
    if document.scenes().len() > 1 {
        notes.add("the file has several scenes: only its default one is shown", "");
    }
    let ignored = document.extensions_used().filter(|name| !SUPPORTED_EXTENSIONS.contains(name));
    for name in ignored {
        notes.add("glTF extensions that are ignored", name);
    }
    for name in ["KHR_materials_specular", "KHR_materials_ior"] {
        if document.extensions_used().any(|used| used == name) {
            notes.add("glTF extensions that are ignored", name);
        }
    }
}
