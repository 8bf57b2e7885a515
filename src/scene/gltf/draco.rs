//! KHR_draco_mesh_compression: primitives whose accessors are stored in a Draco stream.

mod header;

use super::super::error::SceneProblem;
use super::container::Buffers;
use super::exact::{Draco, Exact};
use ::gltf::{Document, json};
use draco_oxide_decoder::Decoder;
use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Triangles and points that any stream may stand for.
const FREE_ELEMENTS: u64 = 1 << 18;

/// Triangles or points a byte of a stream, beyond that. A regular grid of two million triangles takes
/// 0.85 bytes a triangle with positions, normals and coordinates; connectivity alone takes less.
const ELEMENTS_PER_BYTE: u64 = 32;

/// A decoded stream: what its primitives' accessors hold.
struct Decoded {
    /// Three points a triangle.
    indices: Vec<u32>,
    attributes: HashMap<usize, Attribute>,
}

/// An attribute's values, one a point.
struct Attribute {
    values: Vec<f64>,
    components: usize,
}

/// Decodes the compressed primitives and gives their accessors the decoded values. A stream says how
/// many points it has, and decoders may divide them differently from the accessors' counts: those
/// become the decoded ones.
pub(super) fn decode_all(document: Document, exact: &Exact, buffers: &mut Buffers) -> Result<Document, SceneProblem> {
    let mut root = document.into_json();
    // By accessor, the buffer view that it was decoded from.
    let mut filled: HashMap<usize, usize> = HashMap::new();
    let mut streams: HashMap<usize, Decoded> = HashMap::new();
    for (m, mesh) in exact.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let Some(source) = &primitive.extensions.draco else { continue };
            let item = format!("meshes[{m}].primitives[{p}].extensions.KHR_draco_mesh_compression");
            let decoded = match streams.entry(source.buffer_view) {
                std::collections::hash_map::Entry::Occupied(known) => known.into_mut(),
                std::collections::hash_map::Entry::Vacant(free) => {
                    let view = root.buffer_views.get(source.buffer_view);
                    let bytes = view.map(|view| buffers.raw_view(view, source.buffer_view)).transpose()?;
                    let missing = || SceneProblem::invalid(&item, "refers to a buffer view that is not in the file");
                    free.insert(decode(bytes.ok_or_else(missing)?, &item)?)
                }
            };
            let targets = targets(&root, (m, p), source, decoded, &item)?;
            for (accessor, values) in targets {
                match filled.insert(accessor, source.buffer_view) {
                    Some(other) if other != source.buffer_view => {
                        let detail = format!("shares accessors[{accessor}] with another stream");
                        return Err(SceneProblem::invalid(&item, detail));
                    }
                    Some(_) => {}
                    None => fill(&mut root.accessors[accessor], accessor, &values, buffers, &item)?,
                }
            }
        }
    }
    Ok(Document::from_json_without_validation(root))
}

/// What an accessor gets: values and how many there are an element.
type Values<'a> = (std::borrow::Cow<'a, [f64]>, usize);

/// The accessors of a primitive that its stream holds, with their values.
fn targets<'a>(
    root: &json::Root,
    (mesh, primitive): (usize, usize),
    source: &Draco,
    decoded: &'a Decoded,
    item: &str,
) -> Result<Vec<(usize, Values<'a>)>, SceneProblem> {
    let own = root.meshes.get(mesh).and_then(|mesh| mesh.primitives.get(primitive));
    let own = own.ok_or_else(|| SceneProblem::invalid(item, "belongs to no primitive"))?;
    let mut found = Vec::new();
    for (name, &id) in &source.attributes {
        let semantic = own.attributes.iter().find(|(key, _)| match key {
            json::validation::Checked::Valid(semantic) => semantic.to_string() == *name,
            json::validation::Checked::Invalid => false,
        });
        let Some((_, accessor)) = semantic else { continue };
        let attribute = decoded.attributes.get(&id).ok_or_else(|| {
            SceneProblem::invalid(
                format!("{item}.attributes.{name}"),
                format!("is {id}, which its stream does not hold"),
            )
        })?;
        found.push((accessor.value(), (attribute.values.as_slice().into(), attribute.components)));
    }
    if let Some(indices) = &own.indices {
        let values: Vec<f64> = decoded.indices.iter().map(|&index| f64::from(index)).collect();
        found.push((indices.value(), (values.into(), 1)));
    }
    Ok(found)
}

/// Stores values for an accessor in its own component type.
fn fill(
    accessor: &mut json::Accessor,
    index: usize,
    (values, components): &Values,
    buffers: &mut Buffers,
    item: &str,
) -> Result<(), SceneProblem> {
    let (json::validation::Checked::Valid(kind), json::validation::Checked::Valid(dimensions)) =
        (&accessor.component_type, &accessor.type_)
    else {
        return Err(SceneProblem::invalid(format!("accessors[{index}]"), "has no type that glTF knows"));
    };
    if dimensions.multiplicity() != *components {
        let detail = format!("stores {components} components for accessors[{index}], which has another number");
        return Err(SceneProblem::invalid(item, detail));
    }
    let bytes = packed(values, kind.0);
    (accessor.count, accessor.sparse) = (json::validation::USize64((values.len() / components) as u64), None);
    (accessor.buffer_view, accessor.byte_offset) = (None, None);
    buffers.fill_accessor(index, bytes);
    Ok(())
}

/// Values as the bytes of a component type, one behind the other; what does not fit is cut.
fn packed(values: &[f64], kind: json::accessor::ComponentType) -> Vec<u8> {
    use json::accessor::ComponentType::{F32, I8, I16, U8, U16, U32};
    let each = |bytes: &dyn Fn(f64) -> [u8; 4]| {
        values.iter().flat_map(|&value| bytes(value).into_iter().take(kind.size())).collect()
    };
    match kind {
        I8 => each(&|value| [value as i8 as u8, 0, 0, 0]),
        U8 => each(&|value| [value as u8, 0, 0, 0]),
        I16 => each(&|value| i32::from(value as i16).to_le_bytes()),
        U16 => each(&|value| u32::from(value as u16).to_le_bytes()),
        U32 => each(&|value| (value as u32).to_le_bytes()),
        F32 => each(&|value| (value as f32).to_le_bytes()),
    }
}

fn decode(bytes: &[u8], item: &str) -> Result<Decoded, SceneProblem> {
    let damaged =
        |detail: String| SceneProblem::invalid(item, format!("holds a Draco stream that does not decode ({detail})"));
    let counts = header::counts(bytes).ok_or_else(|| damaged("its header is damaged".to_owned()))?;
    let most = (bytes.len() as u64).saturating_mul(ELEMENTS_PER_BYTE).max(FREE_ELEMENTS);
    if counts.greatest > most {
        let detail = format!("{} triangles or points in {} bytes", counts.greatest, bytes.len());
        return Err(SceneProblem::Oversize { item: item.to_owned(), detail });
    }
    // The decoder checks streams, but not for all that a damaged one can hold.
    let mesh = catch_unwind(AssertUnwindSafe(|| Decoder::new().decode_mesh(bytes)))
        .map_err(|_| damaged("its parts contradict each other".to_owned()))?
        .map_err(|e| damaged(e.to_string()))?;
    let indices: Vec<u32> =
        mesh.get_faces().iter().flatten().map(|&point| u32::try_from(usize::from(point)).unwrap_or(u32::MAX)).collect();
    let point_count = mesh.get_attributes().iter().map(|attribute| attribute.len()).max().unwrap_or(0);
    let mut attributes = HashMap::new();
    for attribute in mesh.get_attributes() {
        let kind = attribute.get_component_type();
        let (size, components) = (kind.size(), attribute.get_num_components());
        let data = attribute.get_data_as_bytes();
        let value_of = |point: usize| match attribute.point_map_as_slice() {
            Some(map) => map.get(point).map(|&index| usize::from(index)),
            None => Some(point),
        };
        let mut values = Vec::with_capacity(point_count * components);
        for point in 0..point_count {
            let bytes = value_of(point)
                .and_then(|value| value.checked_mul(components * size))
                .and_then(|start| data.get(start..start.checked_add(components * size)?))
                .ok_or_else(|| damaged("a point without values".to_owned()))?;
            values.extend(bytes.chunks_exact(size).map(|bytes| number(bytes, kind.get_id())));
        }
        attributes.insert(attribute.get_id().as_usize(), Attribute { values, components });
    }
    if indices.iter().any(|&index| index as usize >= point_count) {
        return Err(damaged("a triangle of points that are not there".to_owned()));
    }
    Ok(Decoded { indices, attributes })
}

/// A number of one of Draco's component types (draco::DataType).
fn number(bytes: &[u8], kind: u8) -> f64 {
    let mut word = [0; 4];
    word[..bytes.len().min(4)].copy_from_slice(&bytes[..bytes.len().min(4)]);
    match kind {
        1 => f64::from(word[0] as i8),
        2 => f64::from(word[0]),
        3 => f64::from(i16::from_le_bytes([word[0], word[1]])),
        4 => f64::from(u16::from_le_bytes([word[0], word[1]])),
        5 => f64::from(i32::from_le_bytes(word)),
        6 => f64::from(u32::from_le_bytes(word)),
        _ => f64::from(f32::from_le_bytes(word)),
    }
}
