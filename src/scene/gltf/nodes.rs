//! The node hierarchy: where meshes, cameras and lights are in the world.

use super::super::error::SceneProblem;
use super::super::{Light, LightKind, NamedCamera};
use super::cameras;
use super::exact::{Exact, ExactNode};
use super::notes::Notes;
use ::gltf::khr_lights_punctual::Kind;
use ::gltf::{Document, Node};
use glam::{DAffine3, DMat4, DQuat, DVec3, Vec3};

/// Deepest hierarchy accepted; real ones, skeletons included, stay below a hundred.
const MAX_DEPTH: usize = 1024;

/// What the nodes of the scene place.
#[derive(Default)]
pub(super) struct Placed {
    pub meshes: Vec<PlacedMesh>,
    pub cameras: Vec<NamedCamera>,
    pub lights: Vec<Light>,
    /// Per node of the document, where it is; `None` for nodes outside the scene.
    pub world_from_node: Vec<Option<DAffine3>>,
}

/// A mesh of the document, placed.
pub(super) struct PlacedMesh {
    pub mesh: usize,
    /// The node that places it, for its weights and its skin.
    pub node: usize,
    pub world_from_object: DAffine3,
}

/// `nodes[3] "name"`.
fn label(node: &Node) -> String {
    match node.name() {
        Some(name) => format!("nodes[{}] {name:?}", node.index()),
        None => format!("nodes[{}]", node.index()),
    }
}

/// Walks the default scene (or the first, or all roots of a file without scenes).
///
/// glTF demands disjoint strict trees, so that a node met twice is an error: it would
/// also be the way to a cycle, or to exponentially many instances in a small file.
pub(super) fn walk(document: &Document, exact: &Exact, notes: &mut Notes) -> Result<Placed, SceneProblem> {
    let mut placed = Placed { world_from_node: vec![None; document.nodes().len()], ..Default::default() };
    let mut visited = vec![false; document.nodes().len()];
    let mut stack: Vec<(Node, DAffine3, usize, bool)> =
        roots(document).into_iter().rev().map(|node| (node, DAffine3::IDENTITY, 0, true)).collect();
    while let Some((node, world_from_parent, depth, is_shown)) = stack.pop() {
        let broken = |detail: String| SceneProblem::Hierarchy { item: label(&node), detail };
        if std::mem::replace(&mut visited[node.index()], true) {
            return Err(broken("is reached twice: it has two parents or is its own ancestor".to_owned()));
        }
        if depth > MAX_DEPTH {
            return Err(broken(format!("lies deeper than {MAX_DEPTH} levels")));
        }
        let world_from_node = world_from_parent * local_transform(&exact.nodes[node.index()]);
        if !world_from_node.is_finite() {
            let item = format!("the transform of {}", label(&node));
            return Err(SceneProblem::NotFinite { item, detail: "too large, NaN or infinite".to_owned() });
        }
        placed.world_from_node[node.index()] = Some(world_from_node);
        let hides = exact.nodes[node.index()].extensions.visibility.as_ref().is_some_and(|it| !it.visible);
        if hides {
            notes.add("nodes that the file hides are not drawn", node.name().unwrap_or_default());
        }
        let is_shown = is_shown && !hides;
        place(&node, world_from_node, is_shown, exact, &mut placed, notes)?;
        let children: Vec<Node> = node.children().collect();
        stack.extend(children.into_iter().rev().map(|child| (child, world_from_node, depth + 1, is_shown)));
    }
    cameras::tell_apart(&mut placed.cameras);
    Ok(placed)
}

fn roots(document: &Document) -> Vec<Node<'_>> {
    if let Some(scene) = document.default_scene().or_else(|| document.scenes().next()) {
        return scene.nodes().collect();
    }
    let mut is_child = vec![false; document.nodes().len()];
    document
        .nodes()
        .flat_map(|node| node.children().map(|c| c.index()).collect::<Vec<_>>())
        .for_each(|i| is_child[i] = true);
    document.nodes().filter(|node| !is_child[node.index()]).collect()
}

fn local_transform(node: &ExactNode) -> DAffine3 {
    if let Some(matrix) = &node.matrix {
        return DAffine3::from_mat4(DMat4::from_cols_array(matrix));
    }
    let scale = node.scale.map_or(DVec3::ONE, DVec3::from);
    let translation = node.translation.map_or(DVec3::ZERO, DVec3::from);
    // Exporters round quaternions: a length off by 1e-3 must not become a scale.
    let rotation = node.rotation.map_or(DQuat::IDENTITY, |[x, y, z, w]| {
        let length = DQuat::from_xyzw(x, y, z, w).length();
        if length > 0.0 { DQuat::from_xyzw(x, y, z, w) / length } else { DQuat::IDENTITY }
    });
    DAffine3::from_scale_rotation_translation(scale, rotation, translation)
}

fn place(
    node: &Node,
    world_from_node: DAffine3,
    is_shown: bool,
    exact: &Exact,
    placed: &mut Placed,
    notes: &mut Notes,
) -> Result<(), SceneProblem> {
    if let Some(mesh) = node.mesh().filter(|_| is_shown) {
        placed.meshes.push(PlacedMesh { mesh: mesh.index(), node: node.index(), world_from_object: world_from_node });
    }
    if let Some(source) = node.camera() {
        let camera = cameras::camera(&source, node, world_from_node, exact, notes)?;
        placed.cameras.push(camera);
    }
    if let Some(source) = node.light().filter(|_| is_shown) {
        let item = format!("the light of {}", label(node));
        placed.lights.push(light(&source, world_from_node, &item)?);
    }
    Ok(())
}

/// KHR_lights_punctual: lights shine along their node's -z and ignore its scale.
fn light(
    source: &gltf::khr_lights_punctual::Light,
    world_from_node: DAffine3,
    item: &str,
) -> Result<Light, SceneProblem> {
    let intensity = Vec3::from(source.color()) * source.intensity();
    let range_m = source.range().map_or(f64::INFINITY, f64::from);
    if !(intensity.is_finite() && intensity.min_element() >= 0.0) {
        return Err(SceneProblem::invalid(
            item,
            format!("has the intensity {intensity}, which is not a positive number"),
        ));
    }
    if range_m.is_nan() || range_m <= 0.0 {
        return Err(SceneProblem::invalid(item, format!("has a range of {range_m}, which is not a positive distance")));
    }
    let position = world_from_node.translation;
    let direction = (world_from_node.matrix3 * DVec3::NEG_Z).normalize_or(DVec3::NEG_Z);
    let kind = match source.kind() {
        Kind::Directional => LightKind::Directional { direction },
        Kind::Point => LightKind::Point { position, range_m },
        Kind::Spot { inner_cone_angle, outer_cone_angle } => {
            let (inner, outer) = (f64::from(inner_cone_angle), f64::from(outer_cone_angle));
            if !(inner >= 0.0 && inner <= outer && outer <= std::f64::consts::FRAC_PI_2 + 1e-6) {
                let detail =
                    format!("has cone angles of {inner} and {outer} rad; 0 <= inner <= outer <= pi/2 is needed");
                return Err(SceneProblem::invalid(item, detail));
            }
            LightKind::Spot { position, range_m, direction, cos_inner: inner.cos(), cos_outer: outer.cos() }
        }
    };
    Ok(Light { intensity, kind })
}
