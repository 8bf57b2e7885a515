//! Damaged and hostile files: each gives one clear error, none a panic.

mod tiny_files;

use defocus::image_io;
use defocus::scene::rgbd::{DepthEncoding, DepthKind};
use defocus::scene::{gltf, rgbd};
use serde_json::json;
use tiny_files::{INDICES, NORMALS, POSITIONS, TinyGltf, UVS, glb, gradient, png, png16, write};

/// Loads the bytes as a scene and checks the message.
fn expect_scene_error(case: &str, file_name: &str, bytes: &[u8], fragments: &[&str]) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = write(folder.path(), file_name, bytes);
    expect_error(case, file_name, gltf::load(&path).map(|_| ()), fragments);
}

/// Checks that there is an error, that it names the file and contains the fragments, and
/// that it is one line.
fn expect_error<E: std::fmt::Display>(case: &str, file_name: &str, result: Result<(), E>, fragments: &[&str]) {
    let message = match result {
        Ok(()) => panic!("{case}: loaded without an error"),
        Err(error) => error.to_string(),
    };
    for fragment in fragments.iter().chain([&file_name]) {
        assert!(message.contains(fragment), "{case}: no {fragment:?} in: {message}");
    }
    assert!(!message.contains('\n'), "{case}: more than one line: {message}");
}

/// Damages a valid file's JSON or buffer and expects the error.
fn damaged(case: &str, damage: impl FnOnce(&mut TinyGltf), fragments: &[&str]) {
    let mut tiny = TinyGltf::square();
    damage(&mut tiny);
    expect_scene_error(case, "damaged.glb", &tiny.glb(), fragments);
}

#[test]
fn the_undamaged_files_load() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let tiny = TinyGltf::square();
    for (name, bytes) in [("tiny.glb", tiny.glb()), ("tiny.gltf", tiny.gltf())] {
        let scene = gltf::load(&write(folder.path(), name, &bytes)).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((scene.triangle_count(), scene.name.as_str()), (2, "tiny"));
    }
}

#[test]
fn containers() {
    let whole = TinyGltf::square().glb();
    let with = |at: usize, bytes: &[u8]| {
        let mut copy = whole.clone();
        copy[at..at + bytes.len()].copy_from_slice(bytes);
        copy
    };
    let case = |case: &str, bytes: &[u8], fragments: &[&str]| expect_scene_error(case, "file.glb", bytes, fragments);
    case("empty", b"", &["not a glTF 2.0 file", "empty"]);
    case("a PNG", &png(2, 2, [1, 2, 3]), &["not a glTF 2.0 file", "export"]);
    case("header cut off", &whole[..9], &["damaged binary glTF", "9 bytes"]);
    case("cut off in the JSON", &whole[..100], &["truncated", "100 of"]);
    case("cut off in the buffer", &whole[..whole.len() - 8], &["truncated"]);
    case("declared length below the header's", &with(8, &3_u32.to_le_bytes()), &["declared length 3"]);
    case("version 1", &with(4, &1_u32.to_le_bytes()), &["unsupported version"]);
    case("JSON chunk beyond the file", &with(12, &u32::MAX.to_le_bytes()), &["JSON chunk length"]);
    case("unknown first chunk", &with(16, b"ABCD"), &["unknown chunk type"]);
    case("first chunk is binary", &with(16, b"BIN\0"), &["damaged binary glTF"]);
    case("no JSON inside", &glb(b"{\"asset\": ", b""), &["no valid JSON"]);
    case("JSON nested without end", &glb(&[b'['; 100_000], b""), &["no valid JSON", "recursion"]);
    case("glTF 1.0", &glb(br#"{"asset":{"version":"1.0"}}"#, b""), &["version is \"1.0\"", "version 2.0"]);
    case("no asset", &glb(b"{}", b""), &["no asset.version"]);
    case("JSON of another shape", &glb(br#"{"asset":{"version":"2.0"},"nodes":7}"#, b""), &["glTF schema"]);
    let mut without_bin = TinyGltf::square().json;
    without_bin["buffers"][0]["uri"] = json!("data:text/plain,hello");
    case("data URI without base64", without_bin.to_string().as_bytes(), &["buffers[0]", "not base64"]);
    without_bin["buffers"][0]["uri"] = json!("data:application/octet-stream;base64,@@@@");
    case("damaged base64", without_bin.to_string().as_bytes(), &["buffers[0]", "damaged base64"]);
    without_bin["buffers"][0]["uri"] = json!("missing%20file.bin");
    case(
        "missing external buffer",
        without_bin.to_string().as_bytes(),
        &["buffers[0]", "missing file.bin", "cannot read"],
    );
    without_bin["buffers"][0]["uri"] = json!("%ff%fe.bin");
    case("uri that is not text", without_bin.to_string().as_bytes(), &["buffers[0]", "percent-encoding"]);
    without_bin["buffers"][0]["uri"] = json!("https://example.com/a.bin");
    case("uri on the network", without_bin.to_string().as_bytes(), &["only files beside the scene"]);
    without_bin["buffers"][0].as_object_mut().expect("an object").remove("uri");
    case("buffer without data", without_bin.to_string().as_bytes(), &["buffers[0]", "no uri"]);
}

#[test]
fn missing_scene_file_and_folder() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let absent = folder.path().join("absent.glb");
    expect_error(
        "absent",
        "absent.glb",
        gltf::load(&absent).map(|_| ()),
        &["cannot read", "check that the file exists"],
    );
    let name = folder.path().file_name().expect("a name").to_string_lossy().into_owned();
    expect_error("a folder", &name, gltf::load(folder.path()).map(|_| ()), &["not a regular file"]);
}

#[test]
fn extents() {
    let accessors = "accessors";
    damaged(
        "buffer shorter than declared",
        |t| t.json["buffers"][0]["byteLength"] = json!(1 << 20),
        &["buffers[0]", "1048576 bytes", "truncated"],
    );
    damaged(
        "view beyond its buffer",
        |t| t.json["bufferViews"][0]["byteLength"] = json!(5000),
        &["bufferViews[0]", "5000 bytes"],
    );
    damaged(
        "view offset that overflows",
        |t| t.json["bufferViews"][0]["byteOffset"] = json!(u64::MAX),
        &["bufferViews[0]", "absurd size"],
    );
    damaged(
        "accessor beyond its view",
        |t| t.json[accessors][POSITIONS]["count"] = json!(5),
        &["accessors[0]", "60 bytes", "bufferViews[0]"],
    );
    damaged(
        "accessor offset beyond",
        |t| t.json[accessors][POSITIONS]["byteOffset"] = json!(8),
        &["accessors[0]", "56 bytes"],
    );
    damaged(
        "accessor offset that overflows",
        |t| t.json[accessors][NORMALS]["byteOffset"] = json!(u64::MAX - 3),
        &["accessors[1]", "absurd size"],
    );
    damaged(
        "count that overflows",
        |t| t.json[accessors][POSITIONS]["count"] = json!(u64::MAX / 8),
        &["accessors[0]", "absurd size"],
    );
    damaged(
        "name in the message",
        |t| {
            t.json[accessors][UVS]["name"] = json!("Coordinates");
            t.json[accessors][UVS]["count"] = json!(99);
        },
        &["accessors[2] \"Coordinates\""],
    );
    damaged(
        "stride below the element",
        |t| t.json["bufferViews"][0]["byteStride"] = json!(4),
        &["accessors[0]", "byteStride 4"],
    );
    damaged(
        "stride out of range",
        |t| t.json["bufferViews"][0]["byteStride"] = json!(1),
        &["bufferViews[0].byteStride"],
    );
    damaged("negative count", |t| t.json[accessors][0]["count"] = json!(-4), &["glTF schema"]);
    damaged(
        "unknown component type",
        |t| t.json[accessors][0]["componentType"] = json!(5124),
        &["accessors[0].componentType", "does not allow"],
    );
    damaged(
        "positions of two components",
        |t| t.json[accessors][POSITIONS]["type"] = json!("VEC2"),
        &["accessors[0]", "3 are needed"],
    );
    damaged("float indices", |t| t.json[accessors][INDICES]["componentType"] = json!(5126), &["accessors[3]"]);
    damaged(
        "no positions left",
        |t| t.json[accessors][POSITIONS]["count"] = json!(0),
        &["meshes[0] \"Square\", primitive 0"],
    );
    damaged(
        "fewer normals than positions",
        |t| t.json[accessors][NORMALS]["count"] = json!(3),
        &["attribute NORMAL", "3 elements for 4 vertices"],
    );
    // Without a view, all positions are zero: valid, and nothing to draw.
    damaged(
        "positions of zeros",
        |t| {
            t.json[accessors][0].as_object_mut().expect("an object").remove("bufferView");
            t.json[accessors][0]["count"] = json!(1_u64 << 40);
        },
        &["accessors[0]", "absurd size"],
    );
}

#[test]
fn sparse_accessors() {
    let sparse = |count: u64, index: u16| {
        move |t: &mut TinyGltf| {
            t.add_bytes(&index.to_le_bytes());
            t.add_bytes(bytemuck::cast_slice(&[9.0_f32, 9.0, 9.0]));
            let views = t.json["bufferViews"].as_array().expect("an array").len();
            t.json["accessors"][POSITIONS]["sparse"] = json!({
                "count": count,
                "indices": {"bufferView": views - 2, "componentType": 5123},
                "values": {"bufferView": views - 1}
            });
        }
    };
    damaged("sparse index beyond the accessor", sparse(1, 4), &["accessors[0].sparse", "index 4", "only 4 elements"]);
    damaged("sparse count beyond its views", sparse(1 << 40, 0), &["accessors[0].sparse", "bytes"]);
    damaged("sparse count that overflows", sparse(u64::MAX, 0), &["accessors[0].sparse", "absurd size"]);
    let endless = |t: &mut TinyGltf| {
        sparse(1, 0)(t);
        t.json["accessors"][POSITIONS].as_object_mut().expect("an object").remove("bufferView");
        t.json["accessors"][POSITIONS]["count"] = json!(1_u64 << 40);
    };
    damaged("zeros without end", endless, &["accessors[0]", "absurd size", "without data"]);
    let mut valid = TinyGltf::square();
    sparse(1, 3)(&mut valid);
    let vertices = &tiny_files::load(&valid).meshes[0].vertices;
    assert_eq!(vertices[3].position, glam::Vec3::splat(9.0));
    assert_eq!(vertices[2].position, glam::Vec3::Y);
}

#[test]
fn references_and_values() {
    let primitive =
        |t: &mut TinyGltf, key: &str, value: serde_json::Value| t.json["meshes"][0]["primitives"][0][key] = value;
    damaged(
        "POSITION beyond the accessors",
        |t| primitive(t, "attributes", json!({"POSITION": 77})),
        &["meshes[0].primitives[0].attributes.POSITION"],
    );
    damaged("no POSITION", |t| primitive(t, "attributes", json!({"NORMAL": 1})), &["no triangles to draw"]);
    damaged(
        "indices beyond the accessors",
        |t| primitive(t, "indices", json!(77)),
        &["meshes[0].primitives[0].indices"],
    );
    damaged("material beyond the materials", |t| primitive(t, "material", json!(9)), &["primitives[0].material"]);
    damaged("unknown mode", |t| primitive(t, "mode", json!(42)), &["primitives[0].mode"]);
    damaged(
        "vertex index out of range",
        |t| t.overwrite(INDICES, 4, &4_u16.to_le_bytes()),
        &["Square", "accessors[3]", "index 4", "only 4 vertices"],
    );
    damaged(
        "NaN position",
        |t| t.overwrite(POSITIONS, 12, &f32::NAN.to_le_bytes()),
        &["Square", "POSITION of vertex 1", "not a finite number"],
    );
    damaged(
        "infinite position",
        |t| t.overwrite(POSITIONS, 0, &f32::INFINITY.to_le_bytes()),
        &["POSITION of vertex 0"],
    );
    damaged("NaN texture coordinate", |t| t.overwrite(UVS, 0, &f32::NAN.to_le_bytes()), &["TEXCOORD_0 of vertex 0"]);
    damaged("buffer of a view missing", |t| t.json["bufferViews"][2]["buffer"] = json!(3), &["bufferViews[2].buffer"]);
    damaged("scene missing", |t| t.json["scene"] = json!(5), &["scene", "not in the file"]);
    damaged("mesh missing", |t| t.json["nodes"][0]["mesh"] = json!(5), &["nodes[0].mesh"]);
    damaged(
        "base colour too large",
        |t| t.json["materials"][0]["emissiveFactor"] = json!([1e300, 0.0, 0.0]),
        &["damaged.glb"],
    );
}

#[test]
fn hierarchies() {
    damaged(
        "its own child",
        |t| t.json["nodes"][0]["children"] = json!([0]),
        &["nodes[0] \"Node\"", "its own ancestor", "must be a tree"],
    );
    damaged(
        "a cycle of two",
        |t| t.json["nodes"] = json!([{"children": [1], "mesh": 0}, {"children": [0]}]),
        &["nodes[0]", "ancestor"],
    );
    damaged(
        "two parents",
        |t| t.json["nodes"] = json!([{"children": [1, 1]}, {"mesh": 0}]),
        &["nodes[1]", "two parents"],
    );
    damaged(
        "too deep",
        |t| {
            let chain = (0..5000).map(|i| json!({"children": [i + 1]})).chain([json!({"mesh": 0})]);
            t.json["nodes"] = chain.collect();
        },
        &["deeper than 1024 levels"],
    );
    damaged(
        "transforms that overflow",
        |t| {
            let chain =
                (0..30).map(|i| json!({"children": [i + 1], "scale": [1e30, 1e30, 1e30]})).chain([json!({"mesh": 0})]);
            t.json["nodes"] = chain.collect();
        },
        &["transform of nodes[", "not a finite number"],
    );
}

#[test]
fn extensions_images_and_nothing_at_all() {
    damaged(
        "unsupported required extension",
        |t| t.json["extensionsRequired"] = json!(["KHR_gaussian_splatting"]),
        &["KHR_gaussian_splatting", "not supported", "export"],
    );
    damaged("unknown required extension", |t| t.json["extensionsRequired"] = json!(["ACME_magic"]), &["ACME_magic"]);
    damaged(
        "texture without its image",
        |t| {
            t.add_base_color_texture(&png(2, 2, [0; 3]));
            t.json["textures"] = json!([{"source": 4}]);
        },
        &["textures[0].source"],
    );
    damaged("no nodes", |t| t.json["scenes"] = json!([{"nodes": []}]), &["no triangles to draw", "export a scene"]);
    damaged("lines alone", |t| t.json["meshes"][0]["primitives"][0]["mode"] = json!(1), &["no triangles to draw"]);
    damaged(
        "one degenerate triangle",
        |t| t.overwrite(INDICES, 0, bytemuck::cast_slice(&[1_u16; 6])),
        &["no triangles to draw"],
    );
    let camera = |key: &'static str, value: f64| {
        move |t: &mut TinyGltf| {
            t.json["cameras"] =
                json!([{"name": "Eye", "type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}]);
            t.json["cameras"][0]["perspective"][key] = json!(value);
            t.json["nodes"][0]["camera"] = json!(0);
        }
    };
    damaged("camera without a field of view", camera("yfov", 0.0), &["cameras[0] \"Eye\"", "yfov of 0 rad"]);
    damaged("camera that sees too much", camera("yfov", 4.0), &["yfov of 4 rad"]);
    damaged("camera with its near plane behind", camera("znear", -1.0), &["znear of -1"]);
    damaged("camera without a width", camera("aspectRatio", 0.0), &["aspectRatio"]);
    let light = |light: serde_json::Value| {
        move |t: &mut TinyGltf| {
            t.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [light]}});
            t.json["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
        }
    };
    damaged("negative light", light(json!({"type": "point", "intensity": -1.0})), &["light of nodes[0]", "intensity"]);
    damaged(
        "cone inside out",
        light(json!({"type": "spot", "spot": {"innerConeAngle": 1.0, "outerConeAngle": 0.5}})),
        &["cone angles"],
    );
    damaged(
        "author's hints of another shape",
        |t| t.json["scenes"][0]["extras"] = json!({"defocus": {"focus_m": "far"}}),
        &["extras.defocus", "not understood"],
    );
    damaged(
        "author's focus behind the camera",
        |t| t.json["scenes"][0]["extras"] = json!({"defocus": {"focus_m": -1.0}}),
        &["focus_m", "positive distance"],
    );
}

/// Every prefix and many single-byte changes of a valid file: an error or a scene, never a
/// panic, never unbounded memory.
#[test]
fn cut_anywhere_and_changed_anywhere() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let whole = {
        let mut tiny = TinyGltf::square();
        tiny.add_base_color_texture(&png(2, 2, [200, 100, 50]));
        tiny.glb()
    };
    for length in 0..whole.len() {
        let path = write(folder.path(), "cut.glb", &whole[..length]);
        assert!(gltf::load(&path).is_err(), "a file cut to {length} of {} bytes loaded", whole.len());
    }
    for at in 0..whole.len() {
        for change in [0x01, 0x10] {
            let mut copy = whole.clone();
            copy[at] ^= change;
            let path = write(folder.path(), "changed.glb", &copy);
            if let Ok(scene) = gltf::load(&path) {
                assert!(scene.meshes.iter().all(|m| m.indices.iter().all(|&i| (i as usize) < m.vertices.len())));
                assert!(!scene.cameras.is_empty());
            }
        }
    }
}

fn expect_rgbd_error(
    case: &str,
    color: (&str, &[u8]),
    depth: Option<(&str, &[u8])>,
    encoding: DepthEncoding,
    fragments: &[&str],
) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let color_path = write(folder.path(), color.0, color.1);
    let depth_path = depth.map(|(name, bytes)| write(folder.path(), name, bytes));
    let result = rgbd::load(&color_path, depth_path.as_deref(), &encoding, 0.8).map(|_| ());
    expect_error(case, depth.map_or(color.0, |(name, _)| name), result, fragments);
}

/// The bytes of a small EXR, with or without depth.
fn exr(depth_m: Option<f32>) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.exr");
    let color = gradient(8, 6);
    let depth = depth_m.map(|depth_m| defocus::image::Image::filled(color.size, depth_m));
    image_io::write_exr(&path, &color, depth.as_ref(), None).expect("is written");
    std::fs::read(path).expect("was written")
}

#[test]
fn images_with_depth() {
    let metres = DepthEncoding::METRES;
    let color_png = png(8, 6, [10, 20, 30]);
    let color = ("c.png", &color_png[..]);
    let (whole, colour_only) = (exr(Some(2.0)), exr(None));
    expect_rgbd_error("no depth beside a PNG", color, None, metres, &["no depth of its own", "--depth"]);
    expect_rgbd_error(
        "EXR without Z",
        ("c.exr", &colour_only),
        None,
        metres,
        &["depth channel Z", "B, G, R", "--depth"],
    );
    expect_rgbd_error(
        "EXR with colour as depth",
        color,
        Some(("d.exr", &colour_only)),
        metres,
        &["depth channel Z", "single channel"],
    );
    expect_rgbd_error(
        "another size",
        color,
        Some(("d.png", &png16(8, 16, |_, _| 9))),
        metres,
        &["8, 16", "8, 6", "own aspect ratio"],
    );
    expect_rgbd_error("depth that does not decode", color, Some(("d.png", b"no image")), metres, &["does not decode"]);
    expect_rgbd_error(
        "depth cut off",
        color,
        Some(("d.png", &png16(8, 6, |x, y| (x * y) as u16)[..50])),
        metres,
        &["does not decode"],
    );
    expect_rgbd_error("EXR cut off", color, Some(("d.exr", &whole[..whole.len() / 2])), metres, &["does not decode"]);
    expect_rgbd_error("EXR header cut off", color, Some(("d.exr", &whole[..6])), metres, &["does not decode"]);
    let mut deep = whole.clone();
    deep[5] |= 0x08;
    expect_rgbd_error("deep EXR", color, Some(("d.exr", &deep)), metres, &["deep data", "flatten"]);
    let mut huge = whole.clone();
    let window = huge.windows(11).position(|w| w == b"dataWindow\0").expect("a data window");
    let corner = window + 11 + 6 + 4 + 8;
    huge[corner..corner + 8].copy_from_slice(bytemuck::cast_slice(&[0x00ff_ffff_i32, 0x00ff_ffff]));
    expect_rgbd_error("EXR of absurd size", color, Some(("d.exr", &huge)), metres, &["16777216 x 16777216"]);
    let ones = png16(8, 6, |_, _| 1);
    let unknown = DepthEncoding { unknown: Some(1.0), ..metres };
    expect_rgbd_error(
        "nothing measured",
        color,
        Some(("d.png", &ones)),
        unknown,
        &["not one pixel", "--depth-unknown"],
    );
    expect_rgbd_error("NaN alone", ("c.exr", &exr(Some(f32::NAN))), None, metres, &["not one pixel", "depth"]);
    for per_unit in [0.0, f64::NAN] {
        let encoding = DepthEncoding { kind: DepthKind::Metres { per_unit }, ..metres };
        expect_rgbd_error("scale", color, Some(("d.png", &ones)), encoding, &["depth scale", "--depth-scale"]);
    }
    let reversed = DepthEncoding { kind: DepthKind::Device { near_m: 9.0, far_m: 1.0 }, ..metres };
    expect_rgbd_error("range", color, Some(("d.png", &ones)), reversed, &["0 < near < far", "--depth-range"]);
    let device = DepthEncoding { kind: DepthKind::Device { near_m: 1.0, far_m: 9.0 }, ..metres };
    expect_rgbd_error("metres called device", ("c.exr", &whole), None, device, &["value 2", "outside 0 to 1"]);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = write(folder.path(), "c.exr", &whole);
    for fov_y in [0.0, 4.0, f64::NAN] {
        let message = rgbd::load(&path, None, &metres, fov_y).map(|_| ()).expect_err("an impossible view").to_string();
        assert!(message.contains("--fov"), "{message}");
    }
    assert!(rgbd::load(&path, None, &metres, 0.8).is_ok());
}

/// Every prefix of a valid EXR is an error or an image, never a panic.
#[test]
fn an_exr_cut_or_changed_anywhere_never_panics() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let whole = exr(Some(2.0));
    for at in 0..whole.len() {
        let cut = write(folder.path(), "cut.exr", &whole[..at]);
        assert!(image_io::read_color(&cut).is_err(), "an EXR cut to {at} bytes was read");
        let mut copy = whole.clone();
        copy[at] ^= 0x40;
        let changed = write(folder.path(), "changed.exr", &copy);
        if let Ok(image) = image_io::read_color(&changed) {
            assert_eq!(image.pixels.len(), (image.size.x * image.size.y) as usize);
        }
    }
}
