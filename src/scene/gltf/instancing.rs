//! EXT_mesh_gpu_instancing: a mesh placed many times by accessors.

use super::super::error::SceneProblem;
use super::accessor::read_vectors;
use super::budget::Budget;
use super::container::Buffers;
use super::exact::Instancing;
use ::gltf::Document;
use glam::{DAffine3, DQuat, DVec3, Quat, Vec3};

/// Per instance, its place in the node's space. `item` names the extension in errors.
pub(super) fn transforms(
    instancing: &Instancing,
    document: &Document,
    buffers: &Buffers,
    budget: &mut Budget,
    item: &str,
) -> Result<Vec<DAffine3>, SceneProblem> {
    let accessor = |name: &str| {
        let Some(&index) = instancing.attributes.get(name) else { return Ok(None) };
        let missing = || {
            SceneProblem::invalid(format!("{item}.attributes.{name}"), "refers to something that is not in the file")
        };
        document.accessors().nth(index).ok_or_else(missing).map(Some)
    };
    let [translations, rotations, scales] = [accessor("TRANSLATION")?, accessor("ROTATION")?, accessor("SCALE")?];
    let given = [&translations, &rotations, &scales];
    let Some(count) = given.iter().find_map(|accessor| accessor.as_ref().map(gltf::Accessor::count)) else {
        return Ok(vec![DAffine3::IDENTITY]);
    };
    if given.iter().filter_map(|accessor| accessor.as_ref()).any(|accessor| accessor.count() != count) {
        return Err(SceneProblem::invalid(item, "has attributes of different counts"));
    }
    budget.instances(count, item)?;
    let vectors = |accessor: Option<gltf::Accessor>, default: Vec3| match accessor {
        Some(accessor) => read_vectors::<3>(&accessor, buffers).map(|all| all.into_iter().map(Vec3::from).collect()),
        None => Ok(vec![default; count]),
    };
    let (translations, scales) = (vectors(translations, Vec3::ZERO)?, vectors(scales, Vec3::ONE)?);
    let rotations = match rotations {
        Some(accessor) => read_vectors::<4>(&accessor, buffers)?,
        None => vec![Quat::IDENTITY.to_array(); count],
    };
    let transforms: Vec<DAffine3> = (0..count)
        .map(|i| {
            let (translation, scale): (DVec3, DVec3) = (translations[i].as_dvec3(), scales[i].as_dvec3());
            let rotation = DQuat::from_array(rotations[i].map(f64::from));
            // Quantised quaternions miss the unit length.
            let rotation = if rotation.length_squared() > 0.0 { rotation.normalize() } else { DQuat::IDENTITY };
            DAffine3::from_scale_rotation_translation(scale, rotation, translation)
        })
        .collect();
    match transforms.iter().position(|transform| !transform.is_finite()) {
        None => Ok(transforms),
        Some(i) => {
            let item = format!("{item}, instance {i}");
            Err(SceneProblem::NotFinite { item, detail: "its transform".to_owned() })
        }
    }
}
