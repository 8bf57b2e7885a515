//! What is read from the JSON directly: poses and cameras in double precision, and
//! extensions that the `gltf` crate does not know. A scene far from the origin, or a
//! frame's aspect ratio, must not lose digits.

use serde::Deserialize;
use std::collections::BTreeMap;

#[derive(Clone, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Exact {
    pub nodes: Vec<ExactNode>,
    pub cameras: Vec<ExactCamera>,
    pub scenes: Vec<ExactScene>,
    /// Read only when one is shown: what is damaged in them is no reason to refuse a scene at rest.
    pub animations: Vec<serde_json::Value>,
    pub buffer_views: Vec<ExactView>,
    pub materials: Vec<ExactMaterial>,
    pub meshes: Vec<ExactMesh>,
}

#[derive(Clone, Default, Deserialize)]
#[serde(default)]
pub(super) struct ExactNode {
    pub matrix: Option<[f64; 16]>,
    pub translation: Option<[f64; 3]>,
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
    pub mesh: Option<usize>,
    /// Of an animation; those at rest are read by the `gltf` crate.
    #[serde(skip)]
    pub weights: Option<Vec<f32>>,
    pub extensions: NodeExtensions,
}

#[derive(Clone, Default, Deserialize)]
#[serde(default)]
pub(super) struct ExactAnimation {
    pub name: Option<String>,
    pub channels: Vec<Channel>,
    pub samplers: Vec<Sampler>,
}

/// What a sampler moves.
#[derive(Clone, Default, Deserialize)]
#[serde(default)]
pub(super) struct Channel {
    pub sampler: usize,
    pub target: Target,
}

#[derive(Clone, Default, Deserialize)]
#[serde(default)]
pub(super) struct Target {
    pub node: Option<usize>,
    pub path: String,
}

/// Keys: an accessor of times, seconds, and one of values.
#[derive(Clone, Deserialize)]
pub(super) struct Sampler {
    pub input: usize,
    pub output: usize,
    #[serde(default)]
    pub interpolation: String,
}

/// The extensions of a node that are read here.
#[derive(Clone, Default, Deserialize)]
#[serde(default)]
pub(super) struct NodeExtensions {
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub instancing: Option<Instancing>,
    #[serde(rename = "KHR_node_visibility")]
    pub visibility: Option<Visibility>,
}

/// EXT_mesh_gpu_instancing: accessors by what they hold (TRANSLATION, ROTATION, SCALE, and
/// attributes of an application, which begin with `_`).
#[derive(Clone, Default, Deserialize)]
#[serde(default)]
pub(super) struct Instancing {
    pub attributes: BTreeMap<String, usize>,
}

/// KHR_node_visibility: a node that is not visible hides its children too.
#[derive(Clone, Deserialize)]
pub(super) struct Visibility {
    #[serde(default = "yes")]
    pub visible: bool,
}

fn yes() -> bool {
    true
}

#[derive(Clone, Default, Deserialize)]
#[serde(default)]
pub(super) struct ExactCamera {
    #[serde(rename = "type")]
    pub kind: String,
    pub perspective: Option<ExactPerspective>,
    pub orthographic: Option<ExactOrthographic>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct ExactPerspective {
    pub yfov: f64,
    pub znear: f64,
    pub aspect_ratio: Option<f64>,
}

/// Half the width and height that are seen, and the near plane; scene units.
#[derive(Clone, Copy, Deserialize)]
pub(super) struct ExactOrthographic {
    pub xmag: f64,
    pub ymag: f64,
    pub znear: f64,
}

#[derive(Clone, Default, Deserialize)]
#[serde(default)]
pub(super) struct ExactScene {
    pub extras: Option<serde_json::Value>,
}

#[derive(Clone, Default, Deserialize)]
#[serde(default)]
pub(super) struct ExactView {
    pub extensions: ViewExtensions,
}

/// The extensions of a buffer view that are read here.
#[derive(Clone, Default, Deserialize)]
#[serde(default)]
pub(super) struct ViewExtensions {
    #[serde(rename = "EXT_meshopt_compression")]
    ext_meshopt: Option<Meshopt>,
    #[serde(rename = "KHR_meshopt_compression")]
    khr_meshopt: Option<Meshopt>,
}

impl ViewExtensions {
    /// The compressed data of the view; those of the ratified extension where it has both.
    pub(super) fn meshopt(&self) -> Option<&Meshopt> {
        self.khr_meshopt.as_ref().or(self.ext_meshopt.as_ref())
    }
}

/// EXT_meshopt_compression and KHR_meshopt_compression: where the encoded bytes lie, and what they decode to.
#[derive(Clone, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Meshopt {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub byte_length: usize,
    pub byte_stride: usize,
    pub count: usize,
    pub mode: String,
    #[serde(default)]
    pub filter: String,
}

#[derive(Clone, Default, Deserialize)]
#[serde(default)]
pub(super) struct ExactMesh {
    pub primitives: Vec<ExactPrimitive>,
}

#[derive(Clone, Default, Deserialize)]
#[serde(default)]
pub(super) struct ExactPrimitive {
    pub extensions: PrimitiveExtensions,
}

/// The extensions of a primitive that are read here.
#[derive(Clone, Default, Deserialize)]
#[serde(default)]
#[cfg_attr(not(feature = "draco"), allow(dead_code, reason = "without the decoder nothing reads them"))]
pub(super) struct PrimitiveExtensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    pub draco: Option<Draco>,
}

/// KHR_draco_mesh_compression: the view that holds the stream, and attributes by their numbers in it.
#[derive(Clone, Deserialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(not(feature = "draco"), allow(dead_code, reason = "without the decoder nothing reads them"))]
pub(super) struct Draco {
    pub buffer_view: usize,
    #[serde(default)]
    pub attributes: BTreeMap<String, usize>,
}

#[derive(Clone, Default, Deserialize)]
#[serde(default)]
pub(super) struct ExactMaterial {
    pub extensions: MaterialExtensions,
}

/// The extensions of a material that are read here.
#[derive(Clone, Default, Deserialize)]
#[serde(default)]
pub(super) struct MaterialExtensions {
    #[serde(rename = "KHR_materials_pbrSpecularGlossiness")]
    pub specular_glossiness: Option<SpecularGlossiness>,
}

/// KHR_materials_pbrSpecularGlossiness, without its textures.
#[derive(Clone, Copy, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct SpecularGlossiness {
    pub diffuse_factor: [f32; 4],
    pub specular_factor: [f32; 3],
    pub glossiness_factor: f32,
}

impl Default for SpecularGlossiness {
    fn default() -> Self {
        Self { diffuse_factor: [1.0; 4], specular_factor: [1.0; 3], glossiness_factor: 1.0 }
    }
}
