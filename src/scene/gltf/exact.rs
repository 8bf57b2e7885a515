//! What is read from the JSON directly: poses and cameras in double precision, and
//! extensions that the `gltf` crate does not know. A scene far from the origin, or a
//! frame's aspect ratio, must not lose digits.

use serde::Deserialize;
use std::collections::BTreeMap;

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Exact {
    pub nodes: Vec<ExactNode>,
    pub cameras: Vec<ExactCamera>,
    pub scenes: Vec<ExactScene>,
    pub animations: Vec<serde::de::IgnoredAny>,
    pub buffer_views: Vec<ExactView>,
    pub materials: Vec<ExactMaterial>,
    pub meshes: Vec<ExactMesh>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct ExactNode {
    pub matrix: Option<[f64; 16]>,
    pub translation: Option<[f64; 3]>,
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
    pub extensions: NodeExtensions,
}

/// The extensions of a node that are read here.
#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct NodeExtensions {
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub instancing: Option<Instancing>,
    #[serde(rename = "KHR_node_visibility")]
    pub visibility: Option<Visibility>,
}

/// EXT_mesh_gpu_instancing: accessors by what they hold (TRANSLATION, ROTATION, SCALE, and
/// attributes of an application, which begin with `_`).
#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct Instancing {
    pub attributes: BTreeMap<String, usize>,
}

/// KHR_node_visibility: a node that is not visible hides its children too.
#[derive(Deserialize)]
pub(super) struct Visibility {
    #[serde(default = "yes")]
    pub visible: bool,
}

fn yes() -> bool {
    true
}

#[derive(Default, Deserialize)]
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

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct ExactScene {
    pub extras: Option<serde_json::Value>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct ExactView {
    pub extensions: ViewExtensions,
}

/// The extensions of a buffer view that are read here.
#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct ViewExtensions {
    #[serde(rename = "EXT_meshopt_compression")]
    pub meshopt: Option<Meshopt>,
}

/// EXT_meshopt_compression: where the encoded bytes lie, and what they decode to.
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

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct ExactMesh {
    pub primitives: Vec<ExactPrimitive>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct ExactPrimitive {
    pub extensions: PrimitiveExtensions,
}

/// The extensions of a primitive that are read here.
#[derive(Default, Deserialize)]
#[serde(default)]
#[cfg_attr(not(feature = "draco"), allow(dead_code, reason = "without the decoder nothing reads them"))]
pub(super) struct PrimitiveExtensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    pub draco: Option<Draco>,
}

/// KHR_draco_mesh_compression: the view that holds the stream, and attributes by their numbers in it.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(not(feature = "draco"), allow(dead_code, reason = "without the decoder nothing reads them"))]
pub(super) struct Draco {
    pub buffer_view: usize,
    #[serde(default)]
    pub attributes: BTreeMap<String, usize>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct ExactMaterial {
    pub extensions: MaterialExtensions,
}

/// The extensions of a material that are read here.
#[derive(Default, Deserialize)]
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
