//! glTF 2.0 (.glb and .gltf) to [`Scene`].
//!
//! The `gltf` crate parses the JSON. Everything that it would index, unwrap or multiply
//! without looking is checked first (`validate`, `accessor`), so that a damaged or
//! hostile file gives a [`SceneError`] and never a panic.

mod accessor;
mod animation;
#[cfg(feature = "basis")]
mod basis;
mod budget;
mod cameras;
mod container;
mod coverage;
#[cfg(feature = "draco")]
mod draco;
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

pub use animation::{Animation, Moment};
pub use lighting::{Lighting, relight};

use super::error::{SceneError, SceneProblem};
use super::{Instance, Light, Material, Mesh, NamedCamera, Scene};
use crate::camera::Camera;
use budget::Budget;
use glam::{DVec3, dvec3};
use material::Finished;
use notes::Notes;
use std::path::{Path, PathBuf};

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
    Animated::open(path).map(|file| file.rest)
}

/// Loads a file as [`load`] does, as it is at a moment of an animation.
///
/// # Errors
///
/// Those of [`load`]; an animation that the file does not have.
pub fn load_at(path: &Path, moment: &Moment) -> Result<Scene, SceneError> {
    Animated::open(path)?.at(moment)
}

/// Loads the bytes of a self-contained `.glb` or `.gltf` file, whose scene is then called
/// `name`.
///
/// # Errors
///
/// Those of [`load`], with the name for the file.
pub fn load_bytes(name: &str, bytes: &[u8]) -> Result<Scene, SceneError> {
    Animated::from_bytes(name, bytes).map(|file| file.rest)
}

/// A file that is kept to be posed again and again: what does not move is loaded once.
pub struct Animated {
    document: ::gltf::Document,
    exact: exact::Exact,
    buffers: container::Buffers,
    path: PathBuf,
    rest: Scene,
    /// Which meshes of the scene at rest show what.
    loaded: mesh::Loaded,
    keys: animation::Keys,
}

impl Animated {
    /// Loads a file as [`load`] does, and keeps what posing it needs.
    ///
    /// # Errors
    ///
    /// Those of [`load`].
    pub fn open(path: &Path) -> Result<Self, SceneError> {
        let file = container::read(path).and_then(|file| Self::of(file, path));
        file.map_err(|problem| SceneError { file: path.to_owned(), problem })
    }

    /// Loads the bytes of a self-contained file as [`load_bytes`] does.
    ///
    /// # Errors
    ///
    /// Those of [`load_bytes`].
    pub fn from_bytes(name: &str, bytes: &[u8]) -> Result<Self, SceneError> {
        let path = Path::new(name);
        let file = container::parse(bytes).and_then(|file| Self::of(file, path));
        file.map_err(|problem| SceneError { file: path.to_owned(), problem })
    }

    /// The scene at rest, with its [`Scene::animations`].
    pub fn at_rest(&self) -> &Scene {
        &self.rest
    }

    /// The scene at a moment: nodes, cameras, lights, skins and morphed meshes are where they are
    /// then. Textures are those of the scene at rest.
    ///
    /// # Errors
    ///
    /// An animation that the file does not have, or one that is damaged.
    pub fn at(&self, moment: &Moment) -> Result<Scene, SceneError> {
        self.posed(moment).map_err(|problem| SceneError { file: self.path.clone(), problem })
    }

    fn of(file: container::GltfFile, path: &Path) -> Result<Self, SceneProblem> {
        let document = validate::document(file.root)?;
        #[cfg_attr(not(feature = "draco"), allow(unused_mut, reason = "only a decoder changes them"))]
        let mut buffers = container::Buffers::load(&document, &file.exact, file.blob, path)?;
        #[cfg(feature = "draco")]
        let document = draco::decode_all(document, &file.exact, &mut buffers)?;
        for accessor in document.accessors() {
            accessor::check(&accessor, &buffers)?;
        }
        let mut notes = Notes::default();
        validate::note_what_is_left_out(&document, !file.exact.animations.is_empty(), &mut notes);
        let mut budget = Budget::of(buffers.total_bytes());
        let mut placed = place(&document, &file.exact, &buffers, None, &mut budget, &mut notes)?;
        let loaded = texture::load(&document, &placed.wanted, &buffers, &mut budget, path)?;
        let mut textures = texture::keep_readable(loaded, &mut placed.materials, &mut notes);
        for (index, factors) in std::mem::take(&mut placed.to_convert) {
            specular_glossiness::apply(&mut placed.materials[index], &factors, &mut textures, &mut budget, &mut notes)?;
        }
        let name = path.file_stem().map_or_else(|| "scene".to_owned(), |stem| stem.to_string_lossy().into_owned());
        let animations = animation::list(&document, &file.exact, &buffers);
        let materials = std::mem::take(&mut placed.materials);
        let loaded = std::mem::take(&mut placed.loaded);
        let unlit = Scene { name, materials, textures, animations, ..Default::default() };
        let rest = finish(unlit, placed, &document, &file.exact, notes)?;
        let mut exact = file.exact;
        let keys = animation::Keys::of(std::mem::take(&mut exact.animations));
        Ok(Self { document, exact, buffers, path: path.to_owned(), rest, loaded, keys })
    }

    fn posed(&self, moment: &Moment) -> Result<Scene, SceneProblem> {
        let mut notes = Notes::default();
        validate::note_what_is_left_out(&self.document, false, &mut notes);
        let mut exact = self.exact.clone();
        let known = &self.rest.animations;
        animation::pose(moment, &self.document, &mut exact.nodes, (&self.keys, known), &self.buffers, &mut notes)?;
        let mut budget = Budget::of(self.buffers.total_bytes());
        let known = Some(mesh::Known { loaded: &self.loaded, meshes: &self.rest.meshes });
        let placed = place(&self.document, &exact, &self.buffers, known, &mut budget, &mut notes)?;
        let rest = &self.rest;
        let (name, animations) = (rest.name.clone(), rest.animations.clone());
        let (materials, textures) = (rest.materials.clone(), rest.textures.clone());
        let unlit = Scene { name, materials, textures, animations, ..Default::default() };
        let mut scene = finish(unlit, placed, &self.document, &exact, notes)?;
        // What is said of textures and materials is as true as at rest.
        let of_rest = self.rest.notes.iter().filter(|note| !note.starts_with(validate::AT_REST));
        let missing: Vec<String> = of_rest.filter(|note| !scene.notes.contains(note)).cloned().collect();
        scene.notes.extend(missing);
        Ok(scene)
    }
}

/// What the nodes of a scene place, with the materials that it wants.
struct PlacedScene {
    meshes: Vec<Mesh>,
    instances: Vec<Instance>,
    cameras: Vec<NamedCamera>,
    lights: Vec<Light>,
    materials: Vec<Material>,
    wanted: Vec<material::TextureKey>,
    to_convert: Vec<(usize, exact::SpecularGlossiness)>,
    loaded: mesh::Loaded,
}

/// Loads meshes where the nodes put them. Materials are numbered in the order of their first use,
/// which no pose changes.
fn place(
    document: &::gltf::Document,
    exact: &exact::Exact,
    buffers: &container::Buffers,
    known: Option<mesh::Known<'_>>,
    budget: &mut Budget,
    notes: &mut Notes,
) -> Result<PlacedScene, SceneProblem> {
    let placed = nodes::walk(document, exact, notes)?;
    let mut materials = material::Materials::new(document, exact);
    let mut source = mesh::Source { document, exact, buffers, materials: &mut materials, budget, notes, known };
    let (meshes, instances, loaded) = source.load_placed(&placed)?;
    let Finished { materials, textures: wanted, to_convert } = materials.finish(notes);
    let nodes::Placed { cameras, lights, .. } = placed;
    Ok(PlacedScene { meshes, instances, cameras, lights, materials, wanted, to_convert, loaded })
}

/// Adds what is placed, a camera where there is none, and light.
fn finish(
    scene: Scene,
    placed: PlacedScene,
    document: &::gltf::Document,
    exact: &exact::Exact,
    mut notes: Notes,
) -> Result<Scene, SceneProblem> {
    let PlacedScene { meshes, instances, cameras, lights, .. } = placed;
    let mut scene = Scene { meshes, instances, cameras, ..scene };
    if scene.triangle_count() == 0 {
        let detail = format!("{} meshes, {} nodes", document.meshes().len(), document.nodes().len());
        return Err(SceneProblem::NoGeometry { detail });
    }
    coverage::settle(&mut scene, &mut notes);
    frame_if_without_camera(&mut scene, &mut notes)?;
    let hints = lighting::author_hints(document, exact)?;
    lighting::light(&mut scene, lights, hints.is_some(), &mut notes);
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
