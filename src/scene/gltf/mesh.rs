//! Primitives to meshes, and nodes to instances of them.

use super::super::error::SceneProblem;
use super::super::{Instance, Mesh, Vertex};
use super::accessor::{self, read_indices, read_vectors};
use super::container::Buffers;
use super::geometry;
use super::material::{MaterialUse, Materials};
use super::nodes::PlacedMesh;
use super::notes::Notes;
use ::gltf::{Document, Primitive, Semantic};
use glam::{Vec2, Vec3, Vec4};
use std::collections::HashMap;

/// Loads the meshes that nodes place, each primitive once however often it is placed.
pub(super) fn load_placed(
    document: &Document,
    placed: &[PlacedMesh],
    buffers: &Buffers,
    materials: &mut Materials,
    notes: &mut Notes,
) -> Result<(Vec<Mesh>, Vec<Instance>), SceneProblem> {
    let sources: Vec<gltf::Mesh> = document.meshes().collect();
    let mut meshes = Vec::new();
    let mut instances = Vec::new();
    let mut loaded: HashMap<usize, std::ops::Range<usize>> = HashMap::new();
    for place in placed {
        let range = match loaded.get(&place.mesh) {
            Some(range) => range.clone(),
            None => {
                let start = meshes.len();
                for primitive in sources[place.mesh].primitives() {
                    let label = Label::new(&sources[place.mesh], &primitive);
                    meshes.extend(load_primitive(&primitive, &label, buffers, materials, notes)?);
                }
                loaded.insert(place.mesh, start..meshes.len());
                start..meshes.len()
            }
        };
        instances.extend(range.map(|mesh| Instance { mesh, world_from_object: place.world_from_object }));
    }
    Ok((meshes, instances))
}

/// What a primitive is called in messages and notes.
struct Label {
    /// `meshes[3] "Chair", primitive 0`.
    item: String,
    /// The mesh's name, or its index.
    name: String,
}

impl Label {
    fn new(mesh: &gltf::Mesh, primitive: &Primitive) -> Self {
        let index = mesh.index();
        let quoted = mesh.name().map(|name| format!(" {name:?}")).unwrap_or_default();
        let item = format!("meshes[{index}]{quoted}, primitive {}", primitive.index());
        Self { item, name: mesh.name().map_or_else(|| format!("mesh {index}"), str::to_owned) }
    }
}

/// A primitive as a mesh; `None` for points, lines and primitives without a triangle.
fn load_primitive(
    primitive: &Primitive,
    label: &Label,
    buffers: &Buffers,
    materials: &mut Materials,
    notes: &mut Notes,
) -> Result<Option<Mesh>, SceneProblem> {
    if !geometry::is_triangles(primitive.mode()) {
        notes.add("points and lines are not drawn", &label.name);
        return Ok(None);
    }
    if primitive.morph_targets().len() > 0 {
        notes.add("morph targets are not applied", &label.name);
    }
    let material = materials.place(&primitive.material(), notes)?;
    let mut vertices = read_vertices(primitive, &material, label, buffers, notes)?;
    let mut indices = read_triangles(primitive, vertices.len(), label, buffers)?;
    if indices.is_empty() {
        notes.add("meshes without a single triangle are not drawn", &label.name);
        return Ok(None);
    }
    if primitive.get(&Semantic::Normals).is_none() {
        (vertices, indices) = geometry::flatten(&vertices, &indices);
    } else if geometry::repair_normals(&mut vertices, &indices) > 0 {
        notes.add("normals of length zero are replaced by those of the faces", &label.name);
    }
    finish_tangents(primitive, &mut vertices, &indices, &material, label, notes);
    Ok(Some(Mesh { name: label.name.clone(), vertices, indices, material: material.index }))
}

fn read_triangles(
    primitive: &Primitive,
    vertex_count: usize,
    label: &Label,
    buffers: &Buffers,
) -> Result<Vec<u32>, SceneProblem> {
    let Some(accessor) = primitive.indices() else {
        let count = u32::try_from(vertex_count).map_err(|_| SceneProblem::Oversize {
            item: label.item.clone(),
            detail: format!("{vertex_count} vertices"),
        })?;
        let all: Vec<u32> = (0..count).collect();
        return Ok(geometry::triangle_list(primitive.mode(), &all));
    };
    let indices = read_indices(&accessor, buffers)?;
    if let Some(&index) = indices.iter().find(|&&index| index as usize >= vertex_count) {
        let item = format!("{}, {}", label.item, accessor::label(&accessor));
        return Err(SceneProblem::IndexOutOfRange {
            item,
            index: u64::from(index),
            count: vertex_count as u64,
            things: "vertices",
        });
    }
    Ok(geometry::triangle_list(primitive.mode(), &indices))
}

/// The attributes of all vertices, as far as the file has them.
fn read_vertices(
    primitive: &Primitive,
    material: &MaterialUse,
    label: &Label,
    buffers: &Buffers,
    notes: &mut Notes,
) -> Result<Vec<Vertex>, SceneProblem> {
    let blank = Vertex { color: Vec4::ONE, tangent: Vec4::ZERO.with_w(1.0), ..Default::default() };
    let count = primitive.get(&Semantic::Positions).map_or(0, |accessor| accessor.count());
    // The accessor's extent was checked, so that this many bytes are in the file.
    let mut vertices = vec![blank; count];
    let mut reader = AttributeReader { primitive, label, buffers, vertices: &mut vertices };

    reader.read(Semantic::Positions, true, |vertex, position: [f32; 3]| vertex.position = position.into())?;
    reader.read(Semantic::Normals, false, |vertex, normal: [f32; 3]| vertex.normal = normal.into())?;
    reader.read(Semantic::Tangents, false, |vertex, tangent: [f32; 4]| vertex.tangent = tangent.into())?;
    let uv = Semantic::TexCoords(material.uv_set);
    if !reader.read(uv, true, |vertex, uv: [f32; 2]| vertex.uv = uv.into())? && material.is_textured {
        notes.add("textures are drawn without texture coordinates", &label.name);
    }
    let colors = Semantic::Colors(0);
    match primitive.get(&colors).map(|accessor| accessor.dimensions().multiplicity()) {
        None => {}
        Some(3) => {
            reader.read(colors, true, |vertex, rgb: [f32; 3]| vertex.color = Vec3::from(rgb).extend(1.0))?;
        }
        Some(_) => {
            reader.read(colors, true, |vertex, rgba: [f32; 4]| vertex.color = rgba.into())?;
        }
    }
    Ok(vertices)
}

struct AttributeReader<'a> {
    primitive: &'a Primitive<'a>,
    label: &'a Label,
    buffers: &'a Buffers,
    vertices: &'a mut [Vertex],
}

impl AttributeReader<'_> {
    /// Stores one attribute, if the primitive has it. `strict` attributes must be finite;
    /// normals and tangents are repaired later instead.
    fn read<const N: usize>(
        &mut self,
        semantic: Semantic,
        strict: bool,
        store: impl Fn(&mut Vertex, [f32; N]),
    ) -> Result<bool, SceneProblem> {
        let Some(accessor) = self.primitive.get(&semantic) else { return Ok(false) };
        let name = semantic.to_string();
        let values = read_vectors::<N>(&accessor, self.buffers)?;
        if values.len() != self.vertices.len() {
            let detail = format!("has {} elements for {} vertices", values.len(), self.vertices.len());
            return Err(SceneProblem::invalid(format!("{}, attribute {name}", self.label.item), detail));
        }
        if strict && let Some(i) = values.iter().position(|value| !value.iter().all(|x| x.is_finite())) {
            let item = format!("{}, attribute {name} of vertex {i}", self.label.item);
            return Err(SceneProblem::NotFinite { item, detail: format!("{:?}", values[i]) });
        }
        self.vertices.iter_mut().zip(values).for_each(|(vertex, value)| store(vertex, value));
        Ok(true)
    }
}

/// Makes every tangent a unit vector: the file's, or generated for a normal map.
fn finish_tangents(
    primitive: &Primitive,
    vertices: &mut [Vertex],
    indices: &[u32],
    material: &MaterialUse,
    label: &Label,
    notes: &mut Notes,
) {
    // glTF: tangents are to be ignored where normals are absent.
    let from_file = [Semantic::Normals, Semantic::Tangents].iter().all(|s| primitive.get(s).is_some());
    match material.normal_map {
        Some(map) if !from_file => {
            let lookup = |vertex: &Vertex| {
                let uv1 = vertex.uv.extend(1.0);
                Vec2::new(map.u_row.dot(uv1), map.v_row.dot(uv1))
            };
            geometry::generate_tangents(vertices, indices, lookup);
            notes.add("tangents for normal maps are generated from the texture coordinates", &label.name);
        }
        _ => {
            let directionless = geometry::repair_tangents(vertices);
            if from_file && directionless > 0 && material.normal_map.is_some() {
                notes.add("tangents of length zero are replaced by a perpendicular of the normal", &label.name);
            }
        }
    }
}
