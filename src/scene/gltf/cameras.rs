//! The file's cameras.

use super::super::NamedCamera;
use super::super::error::SceneProblem;
use super::exact::{Exact, ExactOrthographic, ExactPerspective};
use super::notes::Notes;
use crate::camera::Camera;
use ::gltf::Node;
use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3};

/// Distance of an orthographic camera's stand-in over half the height that it sees. At a
/// thousandth, what lies as deep as the frame is high changes its size by a thousandth,
/// half a pixel in 1024, while single precision still tells depths of a millionth of it.
const ORTHOGRAPHIC_DISTANCE: f64 = 1000.0;

/// A node's camera with its name.
pub(super) fn camera(
    source: &gltf::Camera,
    node: &Node,
    world_from_node: DAffine3,
    exact: &Exact,
    notes: &mut Notes,
) -> Result<NamedCamera, SceneProblem> {
    let index = source.index();
    let name = source.name().or(node.name()).map_or_else(|| format!("camera {index}"), str::to_owned);
    let item = format!("cameras[{index}] {name:?}");
    let of_file = &exact.cameras[index];
    let camera = match (&of_file.orthographic, &of_file.perspective) {
        (Some(orthographic), _) if of_file.kind == "orthographic" => {
            let camera = from_afar(*orthographic, world_from_node, &item)?;
            let distance_m = orthographic.ymag.abs() * ORTHOGRAPHIC_DISTANCE;
            let topic =
                "orthographic cameras look with almost parallel rays from far away, and distances count from there";
            notes.add(topic, format!("{name} ({distance_m:.6} m behind its place)"));
            camera
        }
        (_, Some(perspective)) => perspective_camera(*perspective, world_from_node, &item)?,
        _ => return Err(SceneProblem::invalid(item, "has no parameters of its type")),
    };
    Ok(NamedCamera { name, camera })
}

/// Numbers the cameras of one name: several nodes may place the same camera.
pub(super) fn tell_apart(cameras: &mut [NamedCamera]) {
    for i in 1..cameras.len() {
        let (before, rest) = cameras.split_at_mut(i);
        let taken = |name: &str| before.iter().any(|other| other.name == name);
        let name = &mut rest[0].name;
        if taken(name) {
            let numbered = (2..).map(|n| format!("{name} {n}")).find(|candidate| !taken(candidate));
            *name = numbered.unwrap_or_default();
        }
    }
}

/// A camera with the file's own field of view and aspect ratio.
fn perspective_camera(source: ExactPerspective, world_from_node: DAffine3, item: &str) -> Result<Camera, SceneProblem> {
    let ExactPerspective { yfov, znear, aspect_ratio } = source;
    let invalid = |detail: String| Err(SceneProblem::invalid(item, detail));
    if !(yfov > 0.0 && yfov < std::f64::consts::PI) {
        return invalid(format!("has a yfov of {yfov} rad, which is not between 0 and pi"));
    }
    if !(znear > 0.0 && znear.is_finite()) {
        return invalid(format!("has a znear of {znear}, which is not a positive distance"));
    }
    if aspect_ratio.is_some_and(|aspect| !(aspect > 0.0 && aspect.is_finite())) {
        return invalid(format!("has an aspectRatio of {aspect_ratio:?}, which is not a positive number"));
    }
    Ok(Camera {
        position: world_from_node.translation,
        orientation: orientation(world_from_node, item)?,
        fov_y: yfov,
        aspect: aspect_ratio,
        near_m: znear,
        frame_centre_slope: DVec2::ZERO,
    })
}

/// An orthographic view as one from so far behind its place that rays are almost parallel:
/// a lens that blurs needs rays that meet.
fn from_afar(source: ExactOrthographic, world_from_node: DAffine3, item: &str) -> Result<Camera, SceneProblem> {
    let ExactOrthographic { xmag, ymag, znear } = source;
    // Some exporters write mirrored axes as negative magnifications; the frame is the same.
    let (width, height) = (xmag.abs(), ymag.abs());
    let finite = [width, height].iter().all(|mag| *mag > 0.0 && mag.is_finite());
    if !(finite && znear >= 0.0 && znear.is_finite()) {
        let detail = format!("has xmag {xmag}, ymag {ymag} and znear {znear}, which show nothing");
        return Err(SceneProblem::invalid(item, detail));
    }
    let distance_m = height * ORTHOGRAPHIC_DISTANCE;
    let orientation = orientation(world_from_node, item)?;
    Ok(Camera {
        position: world_from_node.translation + orientation * DVec3::Z * distance_m,
        orientation,
        fov_y: 2.0 * ORTHOGRAPHIC_DISTANCE.recip().atan(),
        aspect: Some(width / height),
        near_m: distance_m + znear,
        frame_centre_slope: DVec2::ZERO,
    })
}

/// The node's rotation. Its scale moves its children but does not stretch what a camera
/// sees (glTF 2.0, section 3.10.2).
fn orientation(world_from_node: DAffine3, item: &str) -> Result<DQuat, SceneProblem> {
    let axes = world_from_node.matrix3;
    let back = axes.z_axis.normalize_or_zero();
    let right = (axes.x_axis - back * axes.x_axis.dot(back)).normalize_or_zero();
    if back == DVec3::ZERO || right == DVec3::ZERO {
        return Err(SceneProblem::invalid(item, "is on a node whose scale is zero"));
    }
    // A mirrored node would give a left-handed frame: its up axis is kept, its right turns.
    let up = back.cross(right) * if axes.determinant() < 0.0 { -1.0 } else { 1.0 };
    let rotation = DMat3::from_cols(up.cross(back), up, back);
    Ok(DQuat::from_mat3(&rotation).normalize())
}
