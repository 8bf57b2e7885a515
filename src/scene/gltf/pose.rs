//! Morph targets and skins: where a node puts the vertices of its mesh when nothing moves.

use super::super::Vertex;
use super::super::error::SceneProblem;
use super::accessor::{self, read_vectors};
use super::container::Buffers;
use super::notes::Notes;
use ::gltf::{Node, Primitive, Semantic};
use glam::{DAffine3, DMat3, DMat4, DVec3, Vec3, Vec4};

/// What a node does to the vertices of its mesh.
#[derive(Default)]
pub(super) struct Pose {
    /// A weight per morph target.
    pub weights: Vec<f32>,
    /// The skin's joints.
    pub skin: Option<Skin>,
}

/// Joints of a skin at rest.
pub(super) struct Skin {
    /// Where vertices are counted from, world space: what a skin moves far from the world's
    /// origin keeps its digits.
    pub origin: DVec3,
    /// Per joint, from the mesh's space to the world.
    world_from_mesh: Vec<DAffine3>,
}

impl Skin {
    /// The skin of a node; `None` where it has none, or one whose joints are not in the scene.
    pub(super) fn of(
        node: &Node,
        world_from_node: &[Option<DAffine3>],
        buffers: &Buffers,
        notes: &mut Notes,
    ) -> Result<Option<Self>, SceneProblem> {
        let Some(skin) = node.skin() else { return Ok(None) };
        let item = format!("skins[{}]", skin.index());
        let joints: Option<Vec<DAffine3>> = skin.joints().map(|joint| world_from_node[joint.index()]).collect();
        let Some(joints) = joints.filter(|joints| !joints.is_empty()) else {
            notes.add("skins whose joints are not in the scene are not applied", item);
            return Ok(None);
        };
        // The crate's reader would index; without matrices they are the identity.
        let matrices = match skin.inverse_bind_matrices() {
            Some(accessor) => read_vectors::<16>(&accessor, buffers)?,
            None => vec![DMat4::IDENTITY.as_mat4().to_cols_array(); joints.len()],
        };
        if matrices.len() < joints.len() {
            let detail = format!("has {} inverse bind matrices for {} joints", matrices.len(), joints.len());
            return Err(SceneProblem::invalid(item, detail));
        }
        let origin = joints[0].translation;
        let world_from_mesh: Vec<DAffine3> = joints
            .iter()
            .zip(&matrices)
            .map(|(joint, matrix)| *joint * DAffine3::from_mat4(DMat4::from_cols_array(&matrix.map(f64::from))))
            .collect();
        if let Some(joint) = world_from_mesh.iter().position(|m| !m.is_finite()) {
            let item = format!("the transform of joint {joint} of {item}");
            return Err(SceneProblem::NotFinite { item, detail: "too large, NaN or infinite".to_owned() });
        }
        Ok(Some(Self { origin, world_from_mesh }))
    }

    /// Whether the joints turn front faces to back faces.
    pub(super) fn mirrors(&self) -> bool {
        self.world_from_mesh.iter().all(|m| m.matrix3.determinant() < 0.0)
    }
}

impl Pose {
    /// Moves vertices by morph targets, then by the skin.
    pub(super) fn apply(
        &self,
        primitive: &Primitive,
        vertices: &mut [Vertex],
        item: &str,
        buffers: &Buffers,
    ) -> Result<(), SceneProblem> {
        let targets = primitive.morph_targets().zip(&self.weights).filter(|(_, weight)| **weight != 0.0);
        for (target, &weight) in targets {
            add(target.positions(), vertices, item, buffers, |v, delta| v.position += weight * delta)?;
            add(target.normals(), vertices, item, buffers, |v, delta| v.normal += weight * delta)?;
            add(target.tangents(), vertices, item, buffers, |v, delta| v.tangent += weight * delta.extend(0.0))?;
        }
        if let Some(skin) = &self.skin {
            skin.apply(primitive, vertices, item, buffers)?;
        }
        let lost = vertices.iter().position(|v| !v.position.is_finite());
        lost.map_or(Ok(()), |i| {
            let item = format!("{item}, the posed position of vertex {i}");
            Err(SceneProblem::NotFinite { item, detail: format!("{:?}", vertices[i].position) })
        })
    }
}

fn add(
    deltas: Option<gltf::Accessor>,
    vertices: &mut [Vertex],
    item: &str,
    buffers: &Buffers,
    add: impl Fn(&mut Vertex, Vec3),
) -> Result<(), SceneProblem> {
    let Some(accessor) = deltas else { return Ok(()) };
    let deltas = read_vectors::<3>(&accessor, buffers)?;
    check_count(deltas.len(), vertices.len(), &format!("{item}, morph target {}", accessor::label(&accessor)))?;
    vertices.iter_mut().zip(deltas).for_each(|(vertex, delta)| add(vertex, delta.into()));
    Ok(())
}

fn check_count(found: usize, vertices: usize, item: &str) -> Result<(), SceneProblem> {
    if found == vertices {
        return Ok(());
    }
    Err(SceneProblem::invalid(item, format!("has {found} elements for {vertices} vertices")))
}

impl Skin {
    fn apply(
        &self,
        primitive: &Primitive,
        vertices: &mut [Vertex],
        item: &str,
        buffers: &Buffers,
    ) -> Result<(), SceneProblem> {
        let mut blended = vec![Blend::NOTHING; vertices.len()];
        let sets = (0..)
            .map_while(|set| Some((primitive.get(&Semantic::Joints(set))?, primitive.get(&Semantic::Weights(set))?)));
        for (joints, weights) in sets {
            let (joints, weights) = (read_vectors::<4>(&joints, buffers)?, read_vectors::<4>(&weights, buffers)?);
            check_count(joints.len(), vertices.len(), &format!("{item}, attribute JOINTS"))?;
            check_count(weights.len(), vertices.len(), &format!("{item}, attribute WEIGHTS"))?;
            for (blend, (joints, weights)) in blended.iter_mut().zip(joints.into_iter().zip(weights)) {
                for (joint, weight) in joints.into_iter().zip(weights).filter(|(_, weight)| *weight != 0.0) {
                    let matrix = self.world_from_mesh.get(joint as usize).ok_or_else(|| {
                        let count = self.world_from_mesh.len() as u64;
                        let item = format!("{item}, attribute JOINTS");
                        SceneProblem::IndexOutOfRange { item, index: joint as u64, count, things: "joints" }
                    })?;
                    blend.add(f64::from(weight), matrix);
                }
            }
        }
        for (vertex, blend) in vertices.iter_mut().zip(blended) {
            self.place(vertex, &blend.world_from_mesh(&self.world_from_mesh[0]));
        }
        Ok(())
    }

    fn place(&self, vertex: &mut Vertex, world_from_mesh: &DAffine3) {
        let m = world_from_mesh.matrix3;
        vertex.position = (world_from_mesh.transform_point3(vertex.position.as_dvec3()) - self.origin).as_vec3();
        // The inverse transpose up to a positive factor, which also serves a joint that
        // flattens; its length is made 1 with the other normals.
        let cofactors = DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
        let side = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
        vertex.normal = (cofactors * vertex.normal.as_dvec3() * side).normalize_or_zero().as_vec3();
        let along = (m * vertex.tangent.truncate().as_dvec3()).normalize_or_zero().as_vec3();
        vertex.tangent = Vec4::from((along, vertex.tangent.w * side as f32));
    }
}

/// A weighted sum of the joints' transforms.
#[derive(Clone, Copy)]
struct Blend {
    weight: f64,
    matrix: DMat3,
    translation: DVec3,
}

impl Blend {
    const NOTHING: Self = Self { weight: 0.0, matrix: DMat3::ZERO, translation: DVec3::ZERO };

    fn add(&mut self, weight: f64, joint: &DAffine3) {
        self.weight += weight;
        self.matrix += joint.matrix3 * weight;
        self.translation += joint.translation * weight;
    }

    /// The sum over that of the weights, which exporters round; a vertex without weights
    /// goes with the first joint.
    fn world_from_mesh(&self, first: &DAffine3) -> DAffine3 {
        if self.weight.abs() <= 1e-6 {
            return *first;
        }
        let scale = self.weight.recip();
        DAffine3 { matrix3: self.matrix * scale, translation: self.translation * scale }
    }
}
