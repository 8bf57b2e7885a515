//! Reduces a file's JSON to what is read of it.
//!
//! glTF is extensible everywhere, and the `gltf` crate refuses a whole file for an `extras`
//! of null, an index written 1.0, or a scene without nodes. What is not read cannot be a
//! reason to refuse a file: it is taken out before the crate sees it.

use serde_json::{Map, Value, json};

/// Beyond this, doubles skip integers: such a number is no index.
const MAX_EXACT_INTEGER: f64 = 9_007_199_254_740_992.0;

/// Extensions of a texture that name another image, in the order in which they are taken
/// where there is no plain `source`.
const TEXTURE_SOURCES: [&str; 4] = ["EXT_texture_webp", "KHR_texture_basisu", "EXT_texture_avif", "MSFT_texture_dds"];

/// Makes integers of all numbers that are one: JSON knows no difference between 1 and 1.0,
/// and glTF demands that 1.0 is understood as an index.
pub(super) fn integers(value: &mut Value) {
    match value {
        Value::Number(number) if !(number.is_i64() || number.is_u64()) => {
            let float = number.as_f64().unwrap_or(f64::NAN);
            // A negative zero is a number of its own.
            let is_integer = float.fract() == 0.0 && float.abs() <= MAX_EXACT_INTEGER && !is_negative_zero(float);
            if is_integer {
                *value = json!(float as i64);
            }
        }
        Value::Array(items) => items.iter_mut().for_each(integers),
        Value::Object(fields) => fields.values_mut().for_each(integers),
        _ => {}
    }
}

fn is_negative_zero(float: f64) -> bool {
    float == 0.0 && float.is_sign_negative()
}

/// Takes out what is not read, resolves which image a texture has, and fills in what a
/// valid file may leave out.
pub(super) fn to_what_is_read(root: &mut Value) {
    keep(root, ROOT);
    each(root, "scenes", |scene| {
        keep(scene, &["name", "nodes"]);
        with_default(scene, "nodes", json!([]));
    });
    each(root, "nodes", |node| {
        keep(node, &["name", "children", "mesh", "camera", "skin", "weights", "extensions"]);
        extensions(node, &["KHR_lights_punctual"]);
    });
    each(root, "meshes", |mesh| {
        keep(mesh, &["name", "primitives", "weights"]);
        with_default(mesh, "primitives", json!([]));
        each(mesh, "primitives", |primitive| {
            keep(primitive, &["attributes", "indices", "material", "mode", "targets"]);
            with_default(primitive, "attributes", json!({}));
            each(primitive, "targets", |target| keep(target, &["POSITION", "NORMAL", "TANGENT"]));
        });
    });
    buffers(root);
    materials(root);
    textures(root);
    each(root, "skins", |skin| {
        keep(skin, &["name", "joints", "inverseBindMatrices"]);
        with_default(skin, "joints", json!([]));
    });
    if let Some(asset) = root.get_mut("asset") {
        keep(asset, &["version"]);
    }
    extensions(root, &["KHR_lights_punctual"]);
    if let Some(lights) = root.pointer_mut("/extensions/KHR_lights_punctual") {
        with_default(lights, "lights", json!([]));
        each(lights, "lights", |light| keep(light, &["name", "type", "color", "intensity", "range", "spot"]));
    }
}

const ROOT: &[&str] = &[
    "accessors",
    "asset",
    "bufferViews",
    "buffers",
    "cameras",
    "extensions",
    "extensionsRequired",
    "extensionsUsed",
    "images",
    "materials",
    "meshes",
    "nodes",
    "samplers",
    "scene",
    "scenes",
    "skins",
    "textures",
];

fn buffers(root: &mut Value) {
    each(root, "buffers", |buffer| keep(buffer, &["name", "uri", "byteLength"]));
    each(root, "bufferViews", |view| keep(view, &["name", "buffer", "byteOffset", "byteLength", "byteStride"]));
    each(root, "accessors", |accessor| {
        let kept = ["name", "bufferView", "byteOffset", "componentType", "normalized", "type", "count", "sparse"];
        keep(accessor, &kept);
        if let Some(sparse) = accessor.get_mut("sparse") {
            keep(sparse, &["count", "indices", "values"]);
            sparse.get_mut("indices").into_iter().for_each(|v| keep(v, &["bufferView", "byteOffset", "componentType"]));
            sparse.get_mut("values").into_iter().for_each(|v| keep(v, &["bufferView", "byteOffset"]));
        }
    });
}

fn materials(root: &mut Value) {
    each(root, "materials", |material| {
        specular_glossiness_textures(material);
        keep(
            material,
            &[
                "name",
                "pbrMetallicRoughness",
                "normalTexture",
                "occlusionTexture",
                "emissiveTexture",
                "emissiveFactor",
                "alphaMode",
                "alphaCutoff",
                "doubleSided",
                "extensions",
            ],
        );
        let read = ["KHR_materials_unlit", "KHR_materials_emissive_strength", "KHR_materials_transmission"];
        extensions(material, &read);
        for slot in ["normalTexture", "occlusionTexture", "emissiveTexture"] {
            material.get_mut(slot).into_iter().for_each(texture_info);
        }
        if let Some(transmission) = material.pointer_mut("/extensions/KHR_materials_transmission") {
            keep(transmission, &["transmissionFactor"]);
        }
        if let Some(pbr) = material.get_mut("pbrMetallicRoughness") {
            let factors = ["baseColorFactor", "metallicFactor", "roughnessFactor"];
            let textures = ["baseColorTexture", "metallicRoughnessTexture"];
            keep(pbr, &[&factors[..], &textures].concat());
            textures.iter().filter_map(|slot| pbr.get_mut(*slot).map(texture_info)).for_each(drop);
        }
    });
}

/// KHR_materials_pbrSpecularGlossiness: its textures take the places of those that they are
/// converted to, once they are decoded.
fn specular_glossiness_textures(material: &mut Value) {
    let Some(found) = material.pointer("/extensions/KHR_materials_pbrSpecularGlossiness") else { return };
    let slots = [("diffuseTexture", "baseColorTexture"), ("specularGlossinessTexture", "metallicRoughnessTexture")];
    let moved = slots.iter().filter_map(|(from, to)| Some(((*to).to_owned(), found.get(from)?.clone())));
    let pbr: Map<String, Value> = moved.collect();
    if let Value::Object(fields) = material {
        fields.insert("pbrMetallicRoughness".to_owned(), Value::Object(pbr));
    }
}

fn texture_info(info: &mut Value) {
    keep(info, &["index", "texCoord", "scale", "strength", "extensions"]);
    extensions(info, &["KHR_texture_transform"]);
    if let Some(transform) = info.pointer_mut("/extensions/KHR_texture_transform") {
        keep(transform, &["offset", "rotation", "scale", "texCoord"]);
    }
}

/// Gives every texture an image: its own, one that an extension names, or an image without
/// data, which is drawn grey where anything uses it.
fn textures(root: &mut Value) {
    each(root, "samplers", |sampler| keep(sampler, &["wrapS", "wrapT"]));
    each(root, "images", |image| keep(image, &["name", "uri", "bufferView"]));
    let count = root.get("images").and_then(Value::as_array).map_or(0, Vec::len);
    let mut lacking = false;
    each(root, "textures", |texture| {
        let from_extension =
            TEXTURE_SOURCES.iter().find_map(|name| texture.get("extensions")?.get(name)?.get("source"));
        let source = texture.get("source").or(from_extension).cloned();
        lacking |= source.is_none();
        keep(texture, &["name", "sampler"]);
        with_default(texture, "source", source.unwrap_or_else(|| json!(count)));
    });
    if lacking && let Value::Object(fields) = root {
        let images = fields.entry("images").or_insert_with(|| json!([]));
        images.as_array_mut().into_iter().for_each(|images| images.push(json!({"name": "missing image"})));
    }
}

/// Leaves every camera the parameters of its type.
pub(super) fn cameras(root: &mut Value) {
    each(root, "cameras", camera);
}

fn camera(camera: &mut Value) {
    let own: &[&str] = match camera.get("type").and_then(Value::as_str) {
        Some("perspective") => &["name", "type", "perspective"],
        Some("orthographic") => &["name", "type", "orthographic"],
        _ => &["name", "type", "perspective", "orthographic"],
    };
    keep(camera, own);
    camera.get_mut("perspective").into_iter().for_each(|c| keep(c, &["aspectRatio", "yfov", "znear"]));
    camera.get_mut("orthographic").into_iter().for_each(|c| keep(c, &["xmag", "ymag", "znear", "zfar"]));
}

/// Drops all fields but these of an object.
fn keep(value: &mut Value, fields: &[&str]) {
    if let Value::Object(object) = value {
        object.retain(|name, _| fields.contains(&name.as_str()));
    }
}

/// Drops all extensions but these of an object.
fn extensions(value: &mut Value, names: &[&str]) {
    value.get_mut("extensions").into_iter().for_each(|extensions| keep(extensions, names));
}

/// Sets a field that an object lacks.
fn with_default(value: &mut Value, field: &str, default: Value) {
    if let Value::Object(object) = value {
        object.entry(field).or_insert(default);
    }
}

/// Changes every element of an array that an object may have.
fn each(value: &mut Value, list: &str, change: impl FnMut(&mut Value)) {
    value.get_mut(list).and_then(Value::as_array_mut).into_iter().flatten().for_each(change);
}
