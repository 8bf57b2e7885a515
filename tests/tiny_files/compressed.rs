//! Meshes compressed by the reference encoder of EXT_meshopt_compression.

use super::TinyGltf;
use glam::vec3;
use serde_json::json;

/// A grid of squares: positions, unit vectors and indices as a mesh has them.
pub fn grid(n: u32) -> (Vec<[f32; 4]>, Vec<[f32; 4]>, Vec<u32>) {
    let corners: Vec<(u32, u32)> = (0..=n).flat_map(|y| (0..=n).map(move |x| (x, y))).collect();
    let positions = corners.iter().map(|&(x, y)| [x as f32 * 0.1, y as f32 * 0.2, ((x * y) % 7) as f32, 0.0]);
    let normal = |&(x, y): &(u32, u32)| vec3(x as f32 - 3.0, y as f32 - 4.0, 2.5 - x as f32).normalize().extend(0.0);
    let square = |x: u32, y: u32| {
        let a = y * (n + 1) + x;
        [a, a + 1, a + n + 2, a, a + n + 2, a + n + 1]
    };
    let indices = (0..n).flat_map(|y| (0..n).flat_map(move |x| square(x, y)));
    (positions.collect(), corners.iter().map(|c| normal(c).to_array()).collect(), indices.collect())
}

/// Adds a view that is stored encoded; its index.
pub fn add(t: &mut TinyGltf, encoded: &[u8], (count, stride): (usize, usize), mode: &str, filter: &str) -> usize {
    t.add_bytes(encoded);
    let own = t.list("bufferViews").pop().expect("the bytes' own view");
    t.list("bufferViews").push(json!({"buffer": 1, "byteLength": count * stride, "extensions": {
        "EXT_meshopt_compression": {"buffer": 0, "byteOffset": own["byteOffset"], "byteLength": encoded.len(),
            "byteStride": stride, "count": count, "mode": mode, "filter": filter}}}));
    if mode == "ATTRIBUTES" {
        t.list("bufferViews").last_mut().expect("it")["byteStride"] = json!(stride);
    }
    t.json["bufferViews"].as_array().expect("a list").len() - 1
}

/// A file whose mesh is the grid, compressed.
pub fn compressed(n: u32, mode: &str) -> TinyGltf {
    let (positions, normals, indices) = grid(n);
    let mut t = TinyGltf::square();
    t.list("buffers").push(json!({"byteLength": 1 << 20}));
    let words = |v: &[f32; 4]| v.map(f32::to_bits);
    let plain: Vec<[u32; 4]> = positions.iter().map(words).collect();
    let encode = |v: &[[u32; 4]]| meshopt::encode_vertex_buffer_level(v, 2, Some(0)).expect("encodes");
    let position_view = add(&mut t, &encode(&plain), (plain.len(), 16), "ATTRIBUTES", "NONE");
    let folded = meshopt::encode_filter_oct::<i16>(&normals, 12);
    let bytes = meshopt::encode_vertex_buffer_level(&folded, 2, Some(0)).expect("encodes");
    let normal_view = add(&mut t, &bytes, (folded.len(), 8), "ATTRIBUTES", "OCTAHEDRAL");
    let encoded = match mode {
        "TRIANGLES" => meshopt::encode_index_buffer(&indices, positions.len()),
        _ => meshopt::encode_index_sequence(&indices, positions.len()),
    };
    let index_view = add(&mut t, &encoded.expect("encodes"), (indices.len(), 4), mode, "NONE");
    t.json["accessors"] = json!([
        {"bufferView": position_view, "componentType": 5126, "type": "VEC3", "count": positions.len()},
        {"bufferView": normal_view, "componentType": 5122, "normalized": true, "type": "VEC3", "count": normals.len()},
        {"bufferView": index_view, "componentType": 5125, "type": "SCALAR", "count": indices.len()}]);
    t.json["meshes"][0]["primitives"] = json!([{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2}]);
    t.json["extensionsRequired"] = json!(["EXT_meshopt_compression"]);
    t
}
