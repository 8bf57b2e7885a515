//! Which glTF extensions are read, and which a file may require although they are not.

use super::super::error::SceneProblem;
use super::notes::Notes;
use ::gltf::Document;

/// Extensions that are honoured, where this build has their decoders.
const OPTIONAL: &[(&str, bool)] =
    &[("KHR_draco_mesh_compression", cfg!(feature = "draco")), ("KHR_texture_basisu", cfg!(feature = "basis"))];

/// Extensions that are honoured.
const READ: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_meshopt_compression",
    "KHR_materials_emissive_strength",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_transform",
];

/// Extensions that change neither where a surface is nor how it is shaded: what moves, what
/// a viewer may do, and what things mean. A scene at rest is drawn the same without them.
const HARMLESS: &[&str] = &[
    "AGI_articulations",
    "AGI_stk_metadata",
    "EXT_feature_metadata",
    "EXT_instance_features",
    "EXT_mesh_features",
    "EXT_structural_metadata",
    "KHR_animation_pointer",
    "KHR_interactivity",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_techniques_webgl",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "MSFT_lod",
    "MSFT_packing_normalRoughnessMetallic",
    "MSFT_packing_occlusionRoughnessMetallic",
];

fn is_read(name: &str) -> bool {
    READ.contains(&name) || OPTIONAL.contains(&(name, true))
}

/// Whether a file that requires the extension is drawn: extensions of materials, lights and
/// textures change what a surface shows and never where it is.
fn may_be_required(name: &str) -> bool {
    let shading = ["_materials_", "_lights_", "_texture_"].iter().any(|part| name.contains(part));
    shading || is_read(name) || HARMLESS.contains(&name)
}

/// Refuses what changes geometry and is not read.
pub(super) fn check_required(required: &[String]) -> Result<(), SceneProblem> {
    let Some(name) = required.iter().find(|name| !may_be_required(name)) else { return Ok(()) };
    let hint = match name.as_str() {
        "KHR_draco_mesh_compression" => ", that is with uncompressed meshes, or use a build with the feature draco",
        _ => "",
    };
    Err(SceneProblem::RequiredExtension { name: name.clone(), hint })
}

/// Notes the extensions that a file uses and that are not read.
pub(super) fn note_ignored(document: &Document, notes: &mut Notes) {
    let ignored = document.extensions_used().filter(|name| !is_read(name) && !HARMLESS.contains(name));
    for name in ignored {
        let required = document.extensions_required().any(|other| other == name);
        notes.add(
            if required {
                "the file asks for glTF extensions that are left out"
            } else {
                "glTF extensions that are ignored"
            },
            name,
        );
    }
}
