//! glTF of today: Draco, Basis Universal, the newer meshopt codec, and animations.

mod tiny_files;

use defocus::scene::gltf::{self, Animated, Moment};
use defocus::scene::{Scene, SceneError};
use glam::{DVec3, Vec3};
use serde_json::json;
use std::time::{Duration, Instant};
use tiny_files::{TinyGltf, load};

/// Every byte of a file's buffer changed, one at a time, and the buffer cut: each gives a scene or an
/// error of one line, soon. The number of errors.
fn every_byte_damaged(whole: &TinyGltf) -> usize {
    let result = |damaged: &TinyGltf| -> Result<Scene, SceneError> {
        let start = Instant::now();
        let result = gltf::load_bytes("a.glb", &damaged.glb());
        assert!(start.elapsed() < Duration::from_secs(20), "{:?}", start.elapsed());
        if let Err(error) = &result {
            assert!(!error.to_string().contains('\n'), "{error}");
        }
        result
    };
    let mut refused = 0;
    for at in 0..whole.bin.len() {
        for change in [0x01, 0x5a, 0xff] {
            let mut damaged = whole.clone();
            damaged.bin[at] ^= change;
            refused += usize::from(result(&damaged).is_err());
        }
    }
    refused
}

#[cfg(feature = "draco")]
mod draco {
    use super::*;
    use tiny_files::streams;

    #[test]
    fn decodes_to_what_was_encoded() {
        for (n, has_seam, stream) in streams::draco() {
            let scene = load(&tiny_files::draco(&stream));
            let mesh = &scene.meshes[0];
            assert_eq!(scene.triangle_count(), u64::from(2 * n * n), "{n} {has_seam}");
            // A quantum of the largest extent, 1 m in 11 bits.
            let corner_of = |p: Vec3| {
                let (x, y) = ((p.x * 4.0).round() as u32, (p.y * 4.0).round() as u32);
                let off = (p - Vec3::from(streams::corner(x, y))).abs().max_element();
                assert!(off < 1e-3, "{p} is off by {off}");
                (x, y)
            };
            let mut squares = vec![0; (n * n) as usize];
            for triangle in mesh.indices.chunks_exact(3) {
                let vertices = [0, 1, 2].map(|k| mesh.vertices[triangle[k] as usize]);
                let corners = vertices.map(|v| corner_of(v.position));
                let (left, bottom) = (corners.map(|c| c.0).into_iter().min(), corners.map(|c| c.1).into_iter().min());
                let (left, bottom) = (left.expect("three"), bottom.expect("three"));
                squares[(bottom * n + left) as usize] += 1;
                let [a, b, c] = vertices.map(|v| v.position.truncate());
                assert!((b - a).perp_dot(c - a) > 0.0, "{corners:?} is turned round");
                for (vertex, (x, y)) in vertices.iter().zip(corners) {
                    assert!((vertex.normal - Vec3::Z).length() < 0.02, "{}", vertex.normal);
                    let expected = streams::coordinates(n, x, y, has_seam && left >= n / 2);
                    let off = (vertex.uv - glam::Vec2::from(expected)).abs().max_element();
                    assert!(off < 2e-3, "{} for {expected:?} at {x}, {y}", vertex.uv);
                }
            }
            assert!(squares.iter().all(|&triangles| triangles == 2), "{squares:?}");
        }
    }

    #[test]
    fn what_is_not_compressed_stays() {
        // The fallback of a file that only uses the extension gives way to the stream; a second
        // primitive is read as it is.
        let (_, _, stream) = &streams::draco()[0];
        let mut t = tiny_files::draco(stream);
        t.json["extensionsRequired"] = json!([]);
        let plain = t.add_accessor(tiny_files::SQUARE.as_flattened(), "VEC3");
        let primitive = json!({"attributes": {"POSITION": plain}, "mode": 5});
        t.json["meshes"][0]["primitives"].as_array_mut().expect("a list").push(primitive);
        assert_eq!(load(&t).triangle_count(), 32 + 2);
    }

    #[test]
    fn damaged_streams_are_errors() {
        let mut refused = 0;
        for (_, _, stream) in streams::draco() {
            refused += every_byte_damaged(&tiny_files::draco(&stream));
        }
        assert!(refused > 100, "{refused}");
        let (_, _, stream) = &streams::draco()[0];
        for cut in [5, 11, 13, 40, stream.len() / 2, stream.len() - 1] {
            let error = gltf::load_bytes("a.glb", &tiny_files::draco(&stream[..cut]).glb()).expect_err("cut off");
            assert!(error.to_string().contains("Draco"), "{cut}: {error}");
        }
        // Two billion triangles in a few bytes ask for no memory.
        let mut endless = stream.clone();
        endless.splice(13..14, [0xff, 0xff, 0xff, 0xff, 0x07]);
        let error = gltf::load_bytes("a.glb", &tiny_files::draco(&endless).glb()).expect_err("too many");
        assert!(error.to_string().contains("absurd size"), "{error}");
        // What the stream does not hold, and an accessor of another shape.
        let mut missing = tiny_files::draco(stream);
        missing.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]["attributes"]["NORMAL"] =
            json!(7);
        let error = gltf::load_bytes("a.glb", &missing.glb()).expect_err("no such attribute");
        assert!(error.to_string().contains("NORMAL is 7"), "{error}");
        let mut shape = tiny_files::draco(stream);
        shape.json["accessors"][0]["type"] = json!("VEC4");
        assert!(gltf::load_bytes("a.glb", &shape.glb()).is_err());
    }
}

#[cfg(feature = "basis")]
mod basis {
    use super::*;
    use glam::UVec2;
    use tiny_files::streams;

    #[test]
    fn decodes_to_what_was_encoded() {
        for (name, has_alpha, ktx2) in streams::ktx2() {
            let scene = load(&tiny_files::basisu(&ktx2));
            assert!(!scene.notes.iter().any(|note| note.contains("cannot be read")), "{name}: {:?}", scene.notes);
            let texture = &scene.textures[0];
            assert_eq!((texture.size, texture.srgb), (UVec2::splat(8), true), "{name}");
            // Blocks of one colour: 5 bits a channel and a table of steps are within 8.
            for (i, found) in texture.rgba8.iter().enumerate() {
                let expected = streams::picture(i as u32 % 8, i as u32 / 8, has_alpha);
                let off = found.iter().zip(expected).map(|(a, b)| a.abs_diff(b)).max();
                assert!(off <= Some(8), "{name} at {i}: {found:?} for {expected:?}");
            }
        }
    }

    #[test]
    fn damaged_textures_are_grey_with_a_note() {
        let mut grey = 0;
        for (name, _, ktx2) in streams::ktx2() {
            for at in 0..ktx2.len() {
                for change in [0x01, 0x80, 0xff] {
                    let mut damaged = ktx2.clone();
                    damaged[at] ^= change;
                    // Sizes that the file cannot stand for are an error, all else is a note.
                    let scene = match gltf::load_bytes("a.glb", &tiny_files::basisu(&damaged).glb()) {
                        Ok(scene) => scene,
                        Err(error) => {
                            assert!(error.to_string().contains("absurd size"), "{name} at {at}: {error}");
                            continue;
                        }
                    };
                    assert!(scene.notes.iter().all(|note| !note.contains('\n')));
                    grey += usize::from(scene.notes.iter().any(|note| note.contains("shown grey")));
                }
            }
            for cut in [12, 40, 100, ktx2.len() - 1] {
                let scene = load(&tiny_files::basisu(&ktx2[..cut]));
                assert!(scene.notes.iter().any(|note| note.contains("shown grey")), "{name} cut at {cut}");
            }
        }
        assert!(grey > 100, "{grey}");
    }
}

mod meshopt {
    use super::*;
    use tiny_files::compressed::{add, compressed, grid};

    /// The same file with its streams of version 1, under the newer name.
    fn renewed(n: u32, level: i32) -> TinyGltf {
        let (positions, ..) = grid(n);
        let mut t = compressed(n, "TRIANGLES");
        let words: Vec<[u32; 4]> = positions.iter().map(|v| v.map(f32::to_bits)).collect();
        let bytes = ::meshopt::encode_vertex_buffer_level(&words, level, Some(1)).expect("encodes");
        assert_eq!(bytes[0], 0xa1, "a stream of version 1");
        let view = add(&mut t, &bytes, (words.len(), 16), "ATTRIBUTES", "NONE");
        t.json["accessors"][0]["bufferView"] = json!(view);
        for view in t.list("bufferViews") {
            let extensions = view.get_mut("extensions").and_then(|e| e.as_object_mut());
            if let Some(extensions) = extensions
                && let Some(source) = extensions.remove("EXT_meshopt_compression")
            {
                extensions.insert("KHR_meshopt_compression".to_owned(), source);
            }
        }
        t.json["extensionsRequired"] = json!(["KHR_meshopt_compression"]);
        t
    }

    #[test]
    fn version_1_decodes_to_what_was_encoded() {
        // Level 3 has rotated words of 32 bits; 121 vertices fill no block, 6561 many.
        for (n, level) in [(10, 0), (10, 1), (10, 2), (10, 3), (80, 2), (80, 3)] {
            let (positions, ..) = grid(n);
            let scene = load(&renewed(n, level));
            for (vertex, position) in scene.meshes[0].vertices.iter().zip(&positions) {
                assert_eq!(vertex.position.to_array(), position[..3], "{n} {level}");
            }
        }
    }

    #[test]
    fn colours_decode_as_the_reference_does() {
        let colors: Vec<[f32; 4]> =
            (0..25).map(|i| [i as f32 / 24.0, 1.0 - i as f32 / 24.0, (i % 5) as f32 / 4.0, 0.5]).collect();
        let mut t = compressed(4, "INDICES");
        let encoded = ::meshopt::encode_filter_color::<u8>(&colors, 8);
        let bytes = ::meshopt::encode_vertex_buffer_level(&encoded, 2, Some(1)).expect("encodes");
        let short = add(&mut t, &bytes, (25, 4), "ATTRIBUTES", "COLOR");
        let encoded = ::meshopt::encode_filter_color::<u16>(&colors, 16);
        let bytes = ::meshopt::encode_vertex_buffer_level(&encoded, 2, Some(1)).expect("encodes");
        let long = add(&mut t, &bytes, (25, 8), "ATTRIBUTES", "COLOR");
        for (view, kind, quantum) in [(short, 5121, 1.5 / 127.0), (long, 5123, 1.5 / 32767.0)] {
            let mut t = t.clone();
            t.list("accessors").push(
                json!({"bufferView": view, "componentType": kind, "normalized": true, "type": "VEC4", "count": 25}),
            );
            t.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(3);
            let scene = load(&t);
            for (vertex, color) in scene.meshes[0].vertices.iter().zip(&colors) {
                let off = (vertex.color - glam::Vec4::from(*color)).abs().max_element();
                assert!(off < quantum, "{} for {color:?}", vertex.color);
            }
        }
    }

    #[test]
    fn damaged_streams_of_version_1_are_errors() {
        assert!(every_byte_damaged(&renewed(4, 3)) > 0);
    }
}

mod animations {
    use super::*;

    fn at(animation: Option<&str>, time_s: f64) -> Moment {
        Moment { animation: animation.map(str::to_owned), time_s }
    }

    /// The square's corner, its opposite one and the camera at a moment.
    fn seen(file: &Animated, moment: &Moment) -> (DVec3, DVec3, DVec3) {
        let scene = file.at(moment).unwrap_or_else(|e| panic!("{e}"));
        let instance = &scene.instances[0];
        let vertices = &scene.meshes[instance.mesh].vertices;
        let place = |i: usize| instance.world_from_object.transform_point3(vertices[i].position.as_dvec3());
        (place(0), place(3), scene.cameras[0].camera.position)
    }

    #[test]
    fn every_property_by_every_interpolation() {
        let file = Animated::from_bytes("a.glb", &tiny_files::animated().glb()).unwrap_or_else(|e| panic!("{e}"));
        let listed = &file.at_rest().animations;
        assert_eq!(
            listed.iter().map(|a| (a.name.as_str(), a.duration_s)).collect::<Vec<_>>(),
            [("Way", 2.0), ("Flight", 2.0)]
        );
        let (sin, cos) = (45.0_f64.to_radians().sin(), 45.0_f64.to_radians().cos());
        // A cubic spline with an out-tangent of 1 from 0 to 1: t^3 - 2 t^2 + t + 3 t^2 - 2 t^3.
        let half = 0.125 - 0.5 + 0.5 + 0.75 - 0.25;
        let cases = [
            // Time, the corner (0, 0), the corner (1, 1).
            (-1.0, DVec3::ZERO, DVec3::new(1.0, 1.0, 0.0)),
            (0.5, DVec3::new(1.0, 0.0, half), DVec3::new(1.0 + cos - sin, sin + cos, half)),
            (1.0, DVec3::new(2.0, 0.0, 2.0), DVec3::new(2.0 - 2.0, 2.0, 2.0)),
            (2.0, DVec3::new(2.0, 4.0, 2.5), DVec3::new(2.0 - 5.0, 4.0 - 5.0, 2.5)),
            (99.0, DVec3::new(2.0, 4.0, 2.5), DVec3::new(2.0 - 5.0, 4.0 - 5.0, 2.5)),
        ];
        // Between 0 and 1 s a quarter turn: half of it at 0.5 s is 45 degrees.
        for (time_s, first, last) in cases {
            let (found_first, found_last, camera) = seen(&file, &at(None, time_s));
            assert!((found_first - first).length() < 1e-5, "{time_s}: {found_first} for {first}");
            assert!((found_last - last).length() < 1e-5, "{time_s}: {found_last} for {last}");
            assert_eq!(camera, DVec3::ZERO);
        }
        for name in ["Flight", "1"] {
            let (corner, _, camera) = seen(&file, &at(Some(name), 0.25));
            assert_eq!((corner, camera), (DVec3::ZERO, DVec3::new(0.5, 0.0, 0.0)), "{name}");
        }
    }

    #[test]
    fn a_scene_says_what_moment_it_shows() {
        let file = Animated::from_bytes("a.glb", &tiny_files::animated().glb()).unwrap_or_else(|e| panic!("{e}"));
        let has = |scene: &Scene, part: &str| scene.notes.iter().any(|note| note.contains(part));
        assert!(has(file.at_rest(), "the rest pose is shown"));
        let posed = file.at(&at(Some("Way"), 0.5)).unwrap_or_else(|e| panic!("{e}"));
        assert!(has(&posed, "at 0.5 s") && has(&posed, "Way (2 s)") && !has(&posed, "rest pose"), "{:?}", posed.notes);
        assert_eq!(posed.materials.len(), file.at_rest().materials.len());
    }

    #[test]
    fn joints_and_instances_move_with_their_nodes() {
        let mut t = tiny_files::animated();
        t.add_bytes(&[0; 16]);
        let view = t.list("bufferViews").len() - 1;
        t.list("accessors").push(json!({"bufferView": view, "componentType": 5121, "type": "VEC4", "count": 4}));
        let joints = t.list("accessors").len() - 1;
        let weights = t.add_accessor([[1.0_f32, 0.0, 0.0, 0.0]; 4].as_flattened(), "VEC4");
        let attributes = &mut t.json["meshes"][0]["primitives"][0]["attributes"];
        (attributes["JOINTS_0"], attributes["WEIGHTS_0"]) = (json!(joints), json!(weights));
        t.json["skins"] = json!([{"joints": [0]}]);
        t.json["nodes"] = json!([{}, {"mesh": 0, "skin": 0, "translation": [9.0, 9.0, 9.0]}]);
        t.json["animations"].as_array_mut().expect("a list").truncate(1);
        // The morph weights are the joint's no more.
        t.json["animations"][0]["channels"].as_array_mut().expect("a list").truncate(3);
        let file = Animated::from_bytes("a.glb", &t.glb()).unwrap_or_else(|e| panic!("{e}"));
        let scene = file.at(&at(None, 1.0)).unwrap_or_else(|e| panic!("{e}"));
        let instance = &scene.instances[0];
        let corner = scene.meshes[instance.mesh].vertices[3].position.as_dvec3();
        let found = instance.world_from_object.transform_point3(corner);
        assert!((found - DVec3::new(0.0, 2.0, 0.0)).length() < 1e-5, "{found}");
    }

    #[test]
    fn what_cannot_be_shown_is_an_error() {
        let open = |t: &TinyGltf| Animated::from_bytes("a.glb", &t.glb()).unwrap_or_else(|e| panic!("{e}"));
        let whole = tiny_files::animated();
        let error = |t: &TinyGltf, moment: &Moment| open(t).at(moment).expect_err("cannot be shown").to_string();
        let unknown = error(&whole, &at(Some("Walk"), 0.0));
        assert!(unknown.contains("'Walk'") && unknown.contains("Way, Flight"), "{unknown}");
        assert!(error(&whole, &at(None, f64::NAN)).contains("not a finite number"));
        let none = error(&TinyGltf::square(), &at(None, 0.0));
        assert!(none.contains("no animation"), "{none}");
        for (path, value) in [
            ("/animations/0/channels/0/sampler", json!(9)),
            ("/animations/0/channels/0/target/node", json!(9)),
            ("/animations/0/samplers/0/output", json!(99)),
            ("/animations/0/samplers/0/output", json!(2)),
            ("/animations/0/samplers/0/interpolation", json!("CUBICSPLINE")),
            ("/animations/0/samplers", json!("none")),
        ] {
            let mut damaged = whole.clone();
            *damaged.json.pointer_mut(path).expect("it is there") = value;
            // At rest the file is as good as ever.
            let message = error(&damaged, &at(Some("Way"), 0.5));
            assert!(!message.contains('\n'), "{path}: {message}");
        }
        // Keys that are no numbers or not in order still give a scene or one sentence.
        let mut t = whole.clone();
        let times = t.json["animations"][0]["samplers"][0]["input"].as_u64().expect("an index") as usize;
        for bytes in [f32::NAN.to_le_bytes(), f32::INFINITY.to_le_bytes(), (-5.0_f32).to_le_bytes()] {
            t.overwrite(times, 4, &bytes);
            let file = open(&t);
            for time_s in [-1.0, 0.0, 0.7, 1.0, 3.0] {
                if let Err(error) = file.at(&at(None, time_s)) {
                    assert!(!error.to_string().contains('\n'), "{error}");
                }
            }
        }
    }
}
