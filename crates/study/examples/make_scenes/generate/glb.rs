//! Writes a stage as binary glTF 2.0.

use super::shape::Corner;
use super::stage::{Camera, LightKind, Material, Stage, facing};
use glam::{Mat4, Vec3};
use serde_json::{Value, json};

/// Steps of a position and of a texture coordinate or normal. Rounding to them keeps the
/// last bits, in which mathematical libraries differ, out of the files.
const POSITION_STEPS_PER_M: f32 = 65536.0;
const UNIT_STEPS: f32 = 16384.0;

#[derive(Default)]
struct Writer {
    binary: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

/// The bytes of the file.
pub fn write(stage: &Stage) -> Vec<u8> {
    let mut out = Writer::default();
    let meshes: Vec<Value> = stage.meshes.iter().map(|(shape, material)| out.mesh(shape, *material)).collect();
    let images: Vec<Value> = stage
        .textures
        .iter()
        .map(|t| {
            let mime = if t.jpeg.is_some() { "image/jpeg" } else { "image/png" };
            json!({ "bufferView": out.view(&t.canvas.encode(t.jpeg), None), "mimeType": mime })
        })
        .collect();
    let textures: Vec<Value> = (0..images.len()).map(|i| json!({ "source": i, "sampler": 0 })).collect();
    let nodes = nodes(stage);
    let document = json!({
        "asset": { "version": "2.0", "generator": "defocus make_scenes" },
        "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_emissive_strength"],
        "extensions": { "KHR_lights_punctual": { "lights": stage.lights.iter().map(light).collect::<Vec<_>>() } },
        "scene": 0,
        "scenes": [{
            "nodes": (0..nodes.len()).collect::<Vec<_>>(),
            "extras": { "defocus": {
                "environment": {
                    "zenith": stage.sky.zenith.to_array(),
                    "horizon": stage.sky.horizon.to_array(),
                    "ground": stage.sky.ground.to_array(),
                    "softbox": stage.sky.softbox,
                },
                "focus_m": stage.focus_m,
            }},
        }],
        "nodes": nodes,
        "cameras": stage.cameras.iter().map(camera).collect::<Vec<_>>(),
        "meshes": meshes,
        "materials": stage.materials.iter().map(material).collect::<Vec<_>>(),
        "samplers": [{ "magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497 }],
        "textures": textures,
        "images": images,
        "accessors": out.accessors,
        "bufferViews": out.views,
        "buffers": [{ "byteLength": out.binary.len() }],
    });
    let Value::Object(mut members) = document else { unreachable!("the literal above is an object") };
    // glTF forbids empty arrays.
    members.retain(|_, value| value.as_array().is_none_or(|a| !a.is_empty()));
    container(members.into(), out.binary)
}

fn container(document: Value, mut binary: Vec<u8>) -> Vec<u8> {
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);
    let total = 12 + 8 + text.len() + 8 + binary.len();
    let mut file = Vec::with_capacity(total);
    file.extend(b"glTF");
    file.extend(2u32.to_le_bytes());
    file.extend((total as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &binary)] {
        file.extend((chunk.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
    }
    file
}

fn nodes(stage: &Stage) -> Vec<Value> {
    let placed = |&(mesh, m): &(usize, Mat4)| match m == Mat4::IDENTITY {
        true => json!({ "mesh": mesh }),
        false => json!({ "mesh": mesh, "matrix": matrix(m) }),
    };
    let cameras = stage
        .cameras
        .iter()
        .enumerate()
        .map(|(i, c)| json!({ "name": c.name, "camera": i, "matrix": matrix(c.pose()) }));
    let lights = stage.lights.iter().enumerate().map(|(i, l)| {
        let pose = match l.kind {
            LightKind::Directional { direction, .. } => facing(direction),
            LightKind::Point { position, .. } => Mat4::from_translation(position),
        };
        json!({ "matrix": matrix(pose), "extensions": { "KHR_lights_punctual": { "light": i } } })
    });
    stage.nodes.iter().map(placed).chain(cameras).chain(lights).collect()
}

fn matrix(m: Mat4) -> Vec<f32> {
    m.to_cols_array().iter().map(|&v| round(v, POSITION_STEPS_PER_M)).collect()
}

fn camera(c: &Camera) -> Value {
    json!({ "name": c.name, "type": "perspective", "perspective": {
        "aspectRatio": 4.0 / 3.0, "yfov": c.fov_y_degrees.to_radians(), "znear": c.near_m,
    }})
}

fn light(l: &super::stage::Light) -> Value {
    let intensity = l.intensity.max_element().max(1e-6);
    let kind = if matches!(l.kind, LightKind::Point { .. }) { "point" } else { "directional" };
    json!({ "type": kind, "color": (l.intensity / intensity).to_array(), "intensity": intensity })
}

fn material(m: &Material) -> Value {
    let mut pbr = json!({
        "baseColorFactor": m.color.extend(m.blended.unwrap_or(1.0)).to_array(),
        "metallicFactor": m.metallic,
        "roughnessFactor": m.roughness,
    });
    if let Some(texture) = m.texture {
        pbr["baseColorTexture"] = json!({ "index": texture });
    }
    let mut value = json!({ "name": m.name, "pbrMetallicRoughness": pbr });
    if m.double_sided {
        value["doubleSided"] = true.into();
    }
    if m.cut {
        value["alphaMode"] = "MASK".into();
    }
    if m.blended.is_some() {
        value["alphaMode"] = "BLEND".into();
    }
    if m.transmission > 0.0 {
        value["extensions"] = json!({ "KHR_materials_transmission": { "transmissionFactor": m.transmission } });
    }
    let strength = m.emissive.max_element();
    if strength > 0.0 {
        value["emissiveFactor"] = json!((m.emissive / strength.max(1.0)).to_array());
        value["extensions"] = json!({ "KHR_materials_emissive_strength": { "emissiveStrength": strength.max(1.0) } });
    }
    if let Some(texture) = m.emissive_texture {
        value["emissiveTexture"] = json!({ "index": texture });
    }
    value
}

impl Writer {
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let mut view = json!({ "buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.binary.extend_from_slice(bytes);
        self.views.push(view);
        self.views.len() - 1
    }

    fn accessor(&mut self, bytes: &[u8], target: u32, accessor: Value) -> usize {
        let mut accessor = accessor;
        accessor["bufferView"] = self.view(bytes, Some(target)).into();
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn mesh(&mut self, shape: &super::shape::Shape, material: usize) -> Value {
        const VERTICES: u32 = 34962;
        const INDICES: u32 = 34963;
        const FLOAT: u32 = 5126;
        let (corners, count) = (&shape.corners, shape.corners.len());
        let floats = |f: &dyn Fn(&Corner) -> Vec<f32>| -> Vec<u8> {
            corners.iter().flat_map(f).flat_map(f32::to_le_bytes).collect()
        };
        let place = |c: &Corner| c.position.to_array().map(|v| round(v, POSITION_STEPS_PER_M));
        let lo = corners.iter().fold(Vec3::INFINITY, |lo, c| lo.min(Vec3::from(place(c))));
        let hi = corners.iter().fold(Vec3::NEG_INFINITY, |hi, c| hi.max(Vec3::from(place(c))));
        let position = self.accessor(
            &floats(&|c| place(c).to_vec()),
            VERTICES,
            json!({ "componentType": FLOAT, "count": count, "type": "VEC3", "min": lo.to_array(), "max": hi.to_array() }),
        );
        let normal = self.accessor(
            &floats(&|c| c.normal.to_array().map(|v| round(v, UNIT_STEPS)).to_vec()),
            VERTICES,
            json!({ "componentType": FLOAT, "count": count, "type": "VEC3" }),
        );
        let uv = self.accessor(
            &floats(&|c| c.uv.to_array().map(|v| round(v, UNIT_STEPS)).to_vec()),
            VERTICES,
            json!({ "componentType": FLOAT, "count": count, "type": "VEC2" }),
        );
        let tints: Vec<u8> = corners
            .iter()
            .flat_map(|c| (c.tint.clamp(Vec3::ZERO, Vec3::ONE) * 255.0).round().extend(255.0).to_array())
            .map(|v| v as u8)
            .collect();
        let color = self.accessor(
            &tints,
            VERTICES,
            json!({ "componentType": 5121, "normalized": true, "count": count, "type": "VEC4" }),
        );
        let (bytes, kind): (Vec<u8>, u32) = match count <= 65535 {
            true => (shape.indices.iter().flat_map(|&i| (i as u16).to_le_bytes()).collect(), 5123),
            false => (shape.indices.iter().flat_map(|&i| i.to_le_bytes()).collect(), 5125),
        };
        let indices = self.accessor(
            &bytes,
            INDICES,
            json!({ "componentType": kind, "count": shape.indices.len(), "type": "SCALAR" }),
        );
        json!({ "primitives": [{
            "attributes": { "POSITION": position, "NORMAL": normal, "TEXCOORD_0": uv, "COLOR_0": color },
            "indices": indices,
            "material": material,
        }]})
    }
}

/// To the nearest multiple of `1 / steps`, without negative zero.
fn round(v: f32, steps: f32) -> f32 {
    (v * steps).round() / steps + 0.0
}
