//! Primitives to meshes, and nodes to instances of them.

use super::super::error::SceneProblem;
use super::super::{Instance, Mesh, Vertex};
use super::accessor::{self, read_indices, read_vectors};
use super::budget::Budget;
use super::container::Buffers;
use super::exact::Exact;
use super::material::{MaterialUse, Materials};
use super::nodes::{Placed, PlacedMesh};
use super::notes::Notes;
use super::pose::{Pose, Skin};
use super::{geometry, instancing};
use ::gltf::{Document, Primitive, Semantic};
use glam::{DAffine3, Vec2, Vec3, Vec4};
use std::collections::HashMap;

/// What meshes are loaded from, and what loading them adds to.
pub(super) struct Source<'a, 'e> {
    pub document: &'a Document,
    pub exact: &'a Exact,
    pub buffers: &'a Buffers,
    pub materials: &'a mut Materials<'e>,
    pub budget: &'a mut Budget,
    pub notes: &'a mut Notes,
    pub known: Option<Known<'a>>,
}

/// A mesh as one of its nodes shows it: meshes alike in all of these are loaded once.
pub(super) type Shown = (usize, Vec<u32>, Option<usize>);

/// Which of a scene's meshes show what.
pub(super) type Loaded = HashMap<Shown, std::ops::Range<usize>>;

/// Meshes that were loaded before, of a scene that is posed anew: those that no skin bends are taken
/// from there.
#[derive(Clone, Copy)]
pub(super) struct Known<'a> {
    pub loaded: &'a Loaded,
    pub meshes: &'a [Mesh],
}

impl<'a> Source<'a, '_> {
    /// Loads the meshes that nodes place, each primitive once for all nodes that show it alike.
    pub(super) fn load_placed(&mut self, placed: &Placed) -> Result<(Vec<Mesh>, Vec<Instance>, Loaded), SceneProblem> {
        let nodes: Vec<gltf::Node> = self.document.nodes().collect();
        let sources: Vec<gltf::Mesh> = self.document.meshes().collect();
        let mut meshes = Vec::new();
        let mut instances = Vec::new();
        let mut loaded = Loaded::new();
        for place in &placed.meshes {
            let (node, source) = (&nodes[place.node], &sources[place.mesh]);
            let skin = Skin::of(node, &placed.world_from_node, self.buffers, self.notes)?;
            let at_rest = || node.weights().or(source.weights()).unwrap_or_default().to_vec();
            let weights = self.exact.nodes[place.node].weights.clone().unwrap_or_else(at_rest);
            // A skin alone says where its vertices are: the node's own transform counts for
            // nothing (glTF 2.0, section 3.7.3.3).
            let world_from_object = match &skin {
                Some(skin) => vec![DAffine3::from_translation(skin.origin)],
                None => self.placements(place)?,
            };
            let bits = weights.iter().map(|weight| weight.to_bits()).collect();
            let shown = (place.mesh, bits, skin.is_some().then_some(place.node));
            let pose = Pose { weights, skin };
            let range = match loaded.get(&shown) {
                Some(range) => range.clone(),
                None => {
                    let start = meshes.len();
                    match self.known_meshes(&shown) {
                        Some(known) => {
                            self.place_materials(source)?;
                            meshes.extend_from_slice(known);
                        }
                        None => {
                            for primitive in source.primitives() {
                                let label = Label::new(source, &primitive);
                                meshes.extend(self.load_primitive(&primitive, &pose, &label)?);
                            }
                        }
                    }
                    loaded.entry(shown).or_insert(start..meshes.len()).clone()
                }
            };
            self.budget.instances(range.len() * world_from_object.len(), &format!("nodes[{}]", place.node))?;
            let one_each =
                |mesh| world_from_object.iter().map(move |&world_from_object| Instance { mesh, world_from_object });
            instances.extend(range.flat_map(one_each));
        }
        Ok((meshes, instances, loaded))
    }

    /// The meshes that show the same as before.
    fn known_meshes(&self, shown: &Shown) -> Option<&'a [Mesh]> {
        let Known { loaded, meshes } = self.known.filter(|_| shown.2.is_none())?;
        meshes.get(loaded.get(shown)?.clone())
    }

    /// Numbers the materials of a mesh that is not loaded again as if it were.
    fn place_materials(&mut self, source: &gltf::Mesh) -> Result<(), SceneProblem> {
        for primitive in source.primitives() {
            if geometry::is_triangles(primitive.mode()) && primitive.get(&Semantic::Positions).is_some() {
                self.materials.place(&primitive.material(), self.notes)?;
            }
        }
        Ok(())
    }

    /// Where a node's mesh is: once, or as often as EXT_mesh_gpu_instancing says.
    fn placements(&mut self, place: &PlacedMesh) -> Result<Vec<DAffine3>, SceneProblem> {
        match &self.exact.nodes[place.node].extensions.instancing {
            None => Ok(vec![place.world_from_object]),
            Some(instancing) => {
                let item = format!("nodes[{}].extensions.EXT_mesh_gpu_instancing", place.node);
                let locals = instancing::transforms(instancing, self.document, self.buffers, self.budget, &item)?;
                Ok(locals.into_iter().map(|local| place.world_from_object * local).collect())
            }
        }
    }

    /// A primitive as a mesh; `None` for points, lines and primitives without a triangle.
    fn load_primitive(
        &mut self,
        primitive: &Primitive,
        pose: &Pose,
        label: &Label,
    ) -> Result<Option<Mesh>, SceneProblem> {
        if !geometry::is_triangles(primitive.mode()) {
            self.notes.add("points and lines are not drawn", &label.name);
            return Ok(None);
        }
        let Some(positions) = primitive.get(&Semantic::Positions) else {
            self.notes.add("meshes without positions are not drawn", &label.name);
            return Ok(None);
        };
        self.budget.vertices(positions.count(), &label.item)?;
        let material = self.materials.place(&primitive.material(), self.notes)?;
        let mut vertices = read_vertices(primitive, &material, label, self.buffers, self.notes)?;
        pose.apply(primitive, &mut vertices, &label.item, self.buffers)?;
        let mut indices = read_triangles(primitive, vertices.len(), label, self.buffers)?;
        if indices.is_empty() {
            self.notes.add("meshes without a single triangle are not drawn", &label.name);
            return Ok(None);
        }
        if pose.skin.as_ref().is_some_and(Skin::mirrors) {
            indices.as_chunks_mut::<3>().0.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        if primitive.get(&Semantic::Normals).is_none() {
            self.budget.vertices(indices.len(), &label.item)?;
            (vertices, indices) = geometry::flatten(&vertices, &indices);
        } else if geometry::repair_normals(&mut vertices, &indices) > 0 {
            self.notes.add("normals of length zero are replaced by those of the faces", &label.name);
        }
        finish_tangents(primitive, &mut vertices, &indices, &material, label, self.notes);
        Ok(Some(Mesh { name: label.name.clone(), vertices, indices, material: material.index }))
    }
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
    let [first, second] = material.uv_sets.map(|set| set.map(Semantic::TexCoords));
    let mut has_coordinates = true;
    if let Some(set) = first {
        has_coordinates &= reader.read(set, true, |vertex, uv: [f32; 2]| vertex.uv = uv.into())?;
    }
    if let Some(set) = second {
        has_coordinates &= reader.read(set, true, |vertex, uv: [f32; 2]| vertex.uv1 = uv.into())?;
    }
    if !has_coordinates && material.is_textured {
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
                let at = if map.second_uv { vertex.uv1 } else { vertex.uv }.extend(1.0);
                Vec2::new(map.u_row.dot(at), map.v_row.dot(at))
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
