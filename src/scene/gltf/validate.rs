//! Checks on the JSON before the `gltf` crate's accessors may touch it.

use super::super::error::SceneProblem;
use super::extensions;
use super::notes::Notes;
use ::gltf::json::{self, validation};
use ::gltf::{Document, Semantic};

/// The validated document.
pub(super) fn document(root: json::Root) -> Result<Document, SceneProblem> {
    extensions::check_required(&root.extensions_required)?;
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

/// The crate's own validation indexes accessors with POSITION before it checks the index.
fn check_positions(root: &json::Root) -> Result<(), SceneProblem> {
    let key = validation::Checked::Valid(Semantic::Positions);
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let item = format!("meshes[{m}].primitives[{p}].attributes.POSITION");
            match primitive.attributes.get(&key) {
                Some(index) if index.value() >= root.accessors.len() => {
                    return Err(SceneProblem::invalid(item, describe(validation::Error::IndexOutOfBounds)));
                }
                // A primitive without positions is valid, and nothing to draw.
                None | Some(_) => {}
            }
        }
    }
    Ok(())
}

/// Whether an error of the crate's validation is one. It is not where glTF allows what the
/// crate does not (an accessor without a view is zeros, a primitive may lack positions,
/// attributes of unknown meaning are ignored), where another check follows (required
/// extensions), or where nothing depends on it (bounds are computed from the vertices).
fn matters(path: &str, error: validation::Error) -> bool {
    use validation::Error::{Invalid, Missing};
    let ends = |endings: &[&str]| endings.iter().any(|ending| path.ends_with(ending));
    let allowed = match error {
        Missing => {
            let zeros = path.starts_with("accessors[") && ends(&["].bufferView"]);
            zeros || path.contains(".attributes[\"POSITION\"]")
        }
        Invalid => path.contains(".attributes["),
        _ => false,
    };
    !(allowed || path.starts_with("extensionsRequired") || ends(&[".min", ".max"]))
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

/// How the note begins that is true only of a scene at rest.
pub(super) const AT_REST: &str = "animations are not played";

/// Notes the features that this loader draws in their rest state or not at all.
pub(super) fn note_what_is_left_out(document: &Document, is_at_rest: bool, notes: &mut Notes) {
    if is_at_rest {
        notes.add(format!("{AT_REST}: the rest pose is shown (--time S shows another)"), "");
    }
    if document.scenes().len() > 1 {
        notes.add("the file has several scenes: only its default one is shown", "");
    }
    extensions::note_ignored(document, notes);
}
