//! Tiny valid files, built in code, for tests to read or to damage.

#![allow(dead_code, reason = "every test binary uses its own part of these helpers")]

pub mod compressed;
pub mod streams;

use base64::Engine;
use glam::Vec3;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// A glTF file in its parts: JSON and one buffer.
#[derive(Clone)]
pub struct TinyGltf {
    pub json: Value,
    pub bin: Vec<u8>,
}

/// Corners of the unit square in z = 0 in the order lower left, lower right, upper left,
/// upper right: a strip as it stands, two triangles with [`SQUARE_INDICES`].
pub const SQUARE: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
pub const SQUARE_INDICES: [u16; 6] = [0, 1, 2, 2, 1, 3];
/// v points down: the upper corners are at the image's top.
pub const SQUARE_UV: [[f32; 2]; 4] = [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0], [1.0, 0.0]];

/// Accessors of [`TinyGltf::square`].
pub const POSITIONS: usize = 0;
pub const NORMALS: usize = 1;
pub const UVS: usize = 2;
pub const INDICES: usize = 3;

impl TinyGltf {
    /// A square of two triangles with normals, coordinates, a material and one node.
    pub fn square() -> Self {
        let mut tiny = Self {
            json: json!({
                "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
                "nodes": [{"name": "Node", "mesh": 0}],
                "meshes": [{"name": "Square", "primitives": [{
                    "attributes": {"POSITION": POSITIONS, "NORMAL": NORMALS, "TEXCOORD_0": UVS},
                    "indices": INDICES, "material": 0
                }]}],
                "materials": [{"name": "Paint"}],
                "accessors": [], "bufferViews": [], "buffers": [{"byteLength": 0}]
            }),
            bin: Vec::new(),
        };
        tiny.add_accessor(SQUARE.as_flattened(), "VEC3");
        tiny.add_accessor([[0.0, 0.0, 1.0]; 4].as_flattened(), "VEC3");
        tiny.add_accessor(SQUARE_UV.as_flattened(), "VEC2");
        tiny.add_bytes(bytemuck::cast_slice(&SQUARE_INDICES));
        let view = tiny.count("bufferViews") - 1;
        tiny.list("accessors").push(json!({"bufferView": view, "componentType": 5123, "type": "SCALAR", "count": 6}));
        tiny
    }

    /// Appends floats with a buffer view and an accessor of their own; its index.
    pub fn add_accessor(&mut self, values: &[f32], kind: &str) -> usize {
        self.add_bytes(bytemuck::cast_slice(values));
        let components = match kind {
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 1,
        };
        let view = self.count("bufferViews") - 1;
        let count = values.len() / components;
        let accessor = json!({"bufferView": view, "componentType": 5126, "type": kind, "count": count,
            "min": vec![0.0; components], "max": vec![1.0; components]});
        self.list("accessors").push(accessor);
        self.count("accessors") - 1
    }

    /// Appends bytes with a buffer view of their own.
    pub fn add_bytes(&mut self, bytes: &[u8]) {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len()});
        self.bin.extend_from_slice(bytes);
        self.json["buffers"][0]["byteLength"] = json!(self.bin.len());
        self.list("bufferViews").push(view);
    }

    /// Adds an image, its texture, and makes it the material's base colour.
    pub fn add_base_color_texture(&mut self, png: &[u8]) {
        self.add_bytes(png);
        let view = self.count("bufferViews") - 1;
        self.json["images"] = json!([{"name": "Picture", "bufferView": view, "mimeType": "image/png"}]);
        self.json["textures"] = json!([{"source": 0}]);
        self.json["materials"][0]["pbrMetallicRoughness"] = json!({"baseColorTexture": {"index": 0}});
    }

    /// Overwrites bytes of the buffer at the start of an accessor's view.
    pub fn overwrite(&mut self, accessor: usize, offset: usize, bytes: &[u8]) {
        let view = self.json["accessors"][accessor]["bufferView"].as_u64().expect("a view") as usize;
        let start = self.json["bufferViews"][view]["byteOffset"].as_u64().expect("an offset") as usize + offset;
        self.bin[start..start + bytes.len()].copy_from_slice(bytes);
    }

    /// A top-level array of the JSON.
    pub fn list(&mut self, name: &str) -> &mut Vec<Value> {
        self.json[name].as_array_mut().expect("an array")
    }

    fn count(&self, name: &str) -> usize {
        self.json[name].as_array().map_or(0, Vec::len)
    }

    /// As a binary container.
    pub fn glb(&self) -> Vec<u8> {
        glb(self.json.to_string().as_bytes(), &self.bin)
    }

    /// As JSON with the buffer in a data URI.
    pub fn gltf(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        let encoded = base64::engine::general_purpose::STANDARD.encode(&self.bin);
        json["buffers"][0]["uri"] = json!(format!("data:application/octet-stream;base64,{encoded}"));
        json.to_string().into_bytes()
    }
}

/// A file whose mesh is a Draco stream of positions, normals and coordinates, numbered from 0.
pub fn draco(stream: &[u8]) -> TinyGltf {
    let mut t = TinyGltf::square();
    t.add_bytes(stream);
    let view = t.count("bufferViews") - 1;
    t.json["accessors"] = json!([
        {"componentType": 5126, "type": "VEC3", "count": 25},
        {"componentType": 5126, "type": "VEC3", "count": 25},
        {"componentType": 5126, "type": "VEC2", "count": 25},
        {"componentType": 5125, "type": "SCALAR", "count": 96}]);
    let attributes = json!({"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2});
    t.json["meshes"][0]["primitives"] = json!([{"attributes": attributes, "indices": 3, "material": 0,
        "extensions": {"KHR_draco_mesh_compression": {"bufferView": view, "attributes": attributes}}}]);
    (t.json["extensionsUsed"], t.json["extensionsRequired"]) =
        (json!(["KHR_draco_mesh_compression"]), json!(["KHR_draco_mesh_compression"]));
    // The coordinates are read where a texture wants them.
    t.add_base_color_texture(&png(2, 2, [9, 9, 9]));
    t
}

/// A file whose base colour is a KTX 2.0 texture.
pub fn basisu(ktx2: &[u8]) -> TinyGltf {
    let mut t = TinyGltf::square();
    t.add_base_color_texture(ktx2);
    t.json["images"][0]["mimeType"] = json!("image/ktx2");
    t.json["textures"] = json!([{"extensions": {"KHR_texture_basisu": {"source": 0}}}]);
    (t.json["extensionsUsed"], t.json["extensionsRequired"]) =
        (json!(["KHR_texture_basisu"]), json!(["KHR_texture_basisu"]));
    t
}

/// A square that moves, turns, grows and changes its shape, in an animation called "Way" of 2 s with
/// a key each second, and a camera that goes along in one called "Flight".
pub fn animated() -> TinyGltf {
    let mut t = TinyGltf::square();
    let deltas = t.add_accessor([[0.0_f32, 0.0, 1.0]; 4].as_flattened(), "VEC3");
    t.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": deltas}]);
    let times = t.add_accessor(&[0.0, 1.0, 2.0], "SCALAR");
    let places = t.add_accessor(&[0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 2.0, 4.0, 0.0], "VEC3");
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let turns = t.add_accessor(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, half, 0.0, 0.0, 1.0, 0.0], "VEC4");
    let sizes = t.add_accessor(&[1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 5.0, 5.0, 5.0], "VEC3");
    // In-tangent, value and out-tangent of each key.
    let weights = t.add_accessor(&[0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.5, 0.0], "SCALAR");
    t.json["nodes"] = json!([{"name": "Node", "mesh": 0}, {"camera": 0}]);
    t.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}]);
    t.json["scenes"][0]["nodes"] = json!([0, 1]);
    let channel =
        |sampler: usize, node: usize, path: &str| json!({"sampler": sampler, "target": {"node": node, "path": path}});
    t.json["animations"] = json!([
        {"name": "Way", "samplers": [
            {"input": times, "output": places, "interpolation": "LINEAR"},
            {"input": times, "output": turns},
            {"input": times, "output": sizes, "interpolation": "STEP"},
            {"input": times, "output": weights, "interpolation": "CUBICSPLINE"}],
         "channels": [channel(0, 0, "translation"), channel(1, 0, "rotation"), channel(2, 0, "scale"), channel(3, 0, "weights")]},
        {"name": "Flight", "samplers": [{"input": times, "output": places}], "channels": [channel(0, 1, "translation")]}]);
    t
}

/// Three squares of two colours, one behind the other, with a texture each: depths to blur.
pub fn squares() -> TinyGltf {
    let mut tiny = TinyGltf::square();
    tiny.add_base_color_texture(&png(4, 4, [200, 90, 40]));
    let behind = [
        json!({"mesh": 0, "translation": [-2.0, -2.0, -4.0], "scale": [5.0, 5.0, 1.0]}),
        json!({"mesh": 0, "translation": [0.7, 0.2, -1.5]}),
    ];
    tiny.list("nodes").extend(behind);
    tiny.json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    tiny
}

/// A binary container around JSON and a buffer.
pub fn glb(json: &[u8], bin: &[u8]) -> Vec<u8> {
    let chunk = |kind: &[u8; 4], bytes: &[u8], padding: u8| {
        let mut padded = bytes.to_vec();
        padded.resize(bytes.len().next_multiple_of(4), padding);
        [&(padded.len() as u32).to_le_bytes()[..], kind, &padded].concat()
    };
    let chunks = [chunk(b"JSON", json, b' '), chunk(b"BIN\0", bin, 0)].concat();
    [b"glTF", &2_u32.to_le_bytes()[..], &(12 + chunks.len() as u32).to_le_bytes(), &chunks].concat()
}

/// A PNG of one colour.
pub fn png(width: u32, height: u32, rgb: [u8; 3]) -> Vec<u8> {
    let image = image::RgbImage::from_pixel(width, height, image::Rgb(rgb));
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).expect("encodes");
    bytes.into_inner()
}

/// A 16-bit grey PNG.
pub fn png16(width: u32, height: u32, value: impl Fn(u32, u32) -> u16) -> Vec<u8> {
    let image = image::ImageBuffer::from_fn(width, height, |x, y| image::Luma([value(x, y)]));
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::DynamicImage::ImageLuma16(image).write_to(&mut bytes, image::ImageFormat::Png).expect("encodes");
    bytes.into_inner()
}

/// Writes bytes into a folder; the file's path.
pub fn write(folder: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, bytes).expect("the temporary folder can be written");
    path
}

/// Loads a glTF file that must load.
pub fn load(tiny: &TinyGltf) -> defocus::scene::Scene {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = write(folder.path(), "tiny.glb", &tiny.glb());
    defocus::scene::gltf::load(&path).unwrap_or_else(|e| panic!("{e}"))
}

/// A smooth colour image whose values exceed 1.
pub fn gradient(width: u32, height: u32) -> defocus::image::ColorImage {
    defocus::image::Image::from_fn(glam::UVec2::new(width, height), |x, y| {
        Vec3::new(x as f32 * 0.25, y as f32 * 0.125, 40.0 - x as f32)
    })
}
