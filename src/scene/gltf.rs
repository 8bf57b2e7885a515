//! glTF 2.0 (.glb and .gltf) to [`Scene`].
//!
//! The `gltf` crate parses the JSON. Everything that it would index, unwrap or multiply
//! without looking is checked first (`validate`, `accessor`), so that a damaged or
//! hostile file gives a [`SceneError`] and never a panic.

mod accessor;
mod budget;
mod cameras;
mod container;
mod coverage;
mod exact;
mod extensions;
mod geometry;
mod instancing;
mod lighting;
mod material;
mod mesh;
mod meshopt;
mod nodes;
mod notes;
mod pose;
mod reduce;
mod specular_glossiness;
mod texture;
mod validate;

pub use lighting::{Lighting, relight};

use super::error::{SceneError, SceneProblem};
use super::{NamedCamera, Scene};
use crate::camera::Camera;
use budget::Budget;
use glam::{DVec3, dvec3};
use material::Finished;
use notes::Notes;
use std::path::Path;

/// Vertical field of view of the camera made for a file without one, degrees.
const FRAMING_FOV_Y_DEG: f64 = 40.0;

/// Loads a `.glb` or `.gltf` file.
///
/// The scene drawn is the file's default one, or its first, as it is at rest: morph targets
/// with the file's weights, skins with the nodes' own transforms, animations not played.
/// What is approximated or left out is listed in [`Scene::notes`].
///
/// # Errors
///
/// A [`SceneError`] that names the file, the item in it and the remedy.
pub fn load(path: &Path) -> Result<Scene, SceneError> {
    let scene = container::read(path).and_then(|file| load_file(file, path));
    scene.map_err(|problem| SceneError { file: path.to_owned(), problem })
}

/// Loads the bytes of a self-contained `.glb` or `.gltf` file, whose scene is then called
/// `name`.
///
/// # Errors
///
/// Those of [`load`], with the name for the file.
pub fn load_bytes(name: &str, bytes: &[u8]) -> Result<Scene, SceneError> {
    let path = Path::new(name);
    let scene = container::parse(bytes).and_then(|file| load_file(file, path));
    scene.map_err(|problem| SceneError { file: path.to_owned(), problem })
}

fn load_file(file: container::GltfFile, path: &Path) -> Result<Scene, SceneProblem> {
    let document = validate::document(file.root)?;
    let buffers = container::Buffers::load(&document, &file.exact, file.blob, path)?;
    for accessor in document.accessors() {
        accessor::check(&accessor, &buffers)?;
    }

    let mut notes = Notes::default();
    validate::note_what_is_left_out(&document, file.exact.animations.len(), &mut notes);
    let placed = nodes::walk(&document, &file.exact, &mut notes)?;
    let mut materials = material::Materials::new(&document, &file.exact);
    let mut budget = Budget::of(buffers.total_bytes());
    let mut source = mesh::Source {
        document: &document,
        exact: &file.exact,
        buffers: &buffers,
        materials: &mut materials,
        budget: &mut budget,
        notes: &mut notes,
    };
    let (meshes, instances) = source.load_placed(&placed)?;
    let Finished { mut materials, textures, to_convert } = materials.finish(&mut notes);
    let loaded = texture::load(&document, &textures, &buffers, &mut budget, path)?;
    let mut textures = texture::keep_readable(loaded, &mut materials, &mut notes);
    for (index, factors) in to_convert {
        specular_glossiness::apply(&mut materials[index], &factors, &mut textures, &mut budget, &mut notes)?;
    }

    let name = path.file_stem().map_or_else(|| "scene".to_owned(), |stem| stem.to_string_lossy().into_owned());
    let mut scene =
        Scene { name, meshes, instances, materials, textures, cameras: placed.cameras, ..Default::default() };
    if scene.triangle_count() == 0 {
        let detail = format!("{} meshes, {} nodes", document.meshes().len(), document.nodes().len());
        return Err(SceneProblem::NoGeometry { detail });
    }
    coverage::settle(&mut scene, &mut notes);
    frame_if_without_camera(&mut scene, &mut notes)?;
    let hints = lighting::author_hints(&document, &file.exact)?;
    lighting::light(&mut scene, placed.lights, hints.is_some(), &mut notes);
    lighting::apply(hints, &mut scene, &mut notes);
    scene.notes = notes.into_sentences();
    Ok(scene)
}

/// Gives a scene without a camera one that looks at its bounds.
fn frame_if_without_camera(scene: &mut Scene, notes: &mut Notes) -> Result<(), SceneProblem> {
    let (lo, hi) = scene.bounds_m().unwrap_or_default();
    if !(lo.is_finite() && hi.is_finite() && (hi - lo).length().is_finite()) {
        let detail = format!("{lo} to {hi}");
        return Err(SceneProblem::NotFinite { item: "the extent of the scene".to_owned(), detail });
    }
    if scene.cameras.is_empty() {
        notes.add("the file has no camera: \"framing\" looks at its bounds", "");
        scene.cameras.push(NamedCamera { name: "framing".to_owned(), camera: framing_camera(lo, hi) });
    }
    Ok(())
}

/// A camera in front, to the right and above, that sees the whole box in a frame at least
/// as wide as it is high.
///
/// The sphere around the box touches the frame's edge at `radius / sin(fov/2)`.
fn framing_camera(lo: DVec3, hi: DVec3) -> Camera {
    let centre = (lo + hi) * 0.5;
    // A single point has no size: any positive radius shows it.
    let radius_m = ((hi - lo).length() * 0.5).max(1e-6);
    let fov_y = FRAMING_FOV_Y_DEG.to_radians();
    let distance_m = radius_m / (fov_y * 0.5).sin();
    let eye = centre + dvec3(0.55, 0.35, 1.0).normalize() * distance_m;
    // A hundredth of the distance is well in front of the sphere, and reversed depth
    // keeps its precision however near the plane is.
    Camera::look_at(eye, centre, fov_y, distance_m * 0.01)
}
