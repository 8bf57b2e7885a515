//! glTF files that are valid, or that every other viewer shows, each of its kind.

mod tiny_files;

use defocus::scene::{Scene, gltf};
use glam::{DVec3, Vec2, Vec3, dvec3, vec3};
use serde_json::{Value, json};
use tiny_files::{INDICES, NORMALS, POSITIONS, SQUARE, TinyGltf, UVS, glb, load, png};

fn load_with(change: impl FnOnce(&mut TinyGltf)) -> Scene {
    let mut tiny = TinyGltf::square();
    change(&mut tiny);
    load(&tiny)
}

fn has_note(scene: &Scene, fragment: &str) -> bool {
    scene.notes.iter().any(|note| note.contains(fragment))
}

/// World positions of a mesh's vertices as its first instance shows them.
fn world(scene: &Scene, instance: usize) -> Vec<DVec3> {
    let placed = &scene.instances[instance];
    let vertices = &scene.meshes[placed.mesh].vertices;
    vertices.iter().map(|v| placed.world_from_object.transform_point3(v.position.as_dvec3())).collect()
}

/// Every number with a decimal point, as some programs write all of them.
fn as_floats(value: &mut Value) {
    match value {
        Value::Number(number) => *value = json!(number.as_f64().expect("a number")),
        Value::Array(items) => items.iter_mut().for_each(as_floats),
        Value::Object(fields) => fields.values_mut().for_each(as_floats),
        _ => {}
    }
}

#[test]
fn what_is_not_read_is_no_reason_to_refuse() {
    let animated = |t: &mut TinyGltf| {
        let input = t.add_accessor(&[0.0, 1.0], "SCALAR");
        let output = t.add_accessor(&[0.0; 6], "VEC3");
        t.json["animations"] = json!([{"samplers": [{"input": input, "output": output}], "channels": [{"sampler": 0,
            "target": {"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": "/nodes/0/scale"}}}}]}]);
        t.json["extensionsRequired"] = json!(["KHR_animation_pointer"]);
    };
    type Change = Box<dyn Fn(&mut TinyGltf)>;
    let everywhere = |value: Value| -> Change {
        Box::new(move |t: &mut TinyGltf| {
            t.json["extras"] = value.clone();
            for list in ["nodes", "scenes", "meshes", "materials", "accessors", "bufferViews", "buffers"] {
                t.json[list][0]["extras"] = value.clone();
            }
            t.json["meshes"][0]["primitives"][0]["extras"] = value.clone();
            t.json["asset"]["extras"] = value.clone();
        })
    };
    let cases: [(&str, Change); 15] = [
        ("extras of null", everywhere(json!(null))),
        ("extras of a number", everywhere(json!(7))),
        ("extras of a list", everywhere(json!([1, "two", null]))),
        ("extras of text", everywhere(json!("text"))),
        ("integers written 1.0", Box::new(|t: &mut TinyGltf| as_floats(&mut t.json))),
        ("a further scene without nodes", Box::new(|t: &mut TinyGltf| t.list("scenes").push(json!({"name": "empty"})))),
        ("a texture without an image that nothing uses", Box::new(|t: &mut TinyGltf| t.json["textures"] = json!([{}]))),
        ("an animation of a pointer", Box::new(animated)),
        ("an unknown member everywhere", Box::new(|t: &mut TinyGltf| t.json["nodes"][0]["custom"] = json!({"a": [1]}))),
        (
            "an unknown extension",
            Box::new(|t: &mut TinyGltf| t.json["nodes"][0]["extensions"] = json!({"ACME_x": null})),
        ),
        (
            "a material with unread textures",
            Box::new(|t: &mut TinyGltf| {
                t.json["materials"][0]["extensions"] =
                    json!({"KHR_materials_sheen": {"sheenColorTexture": {"index": 99}}});
            }),
        ),
        (
            "filters of a sampler",
            Box::new(|t: &mut TinyGltf| t.json["samplers"] = json!([{"magFilter": 9728, "minFilter": 9985}])),
        ),
        (
            "a buffer that nothing uses",
            Box::new(|t: &mut TinyGltf| t.list("buffers").push(json!({"byteLength": 5, "uri": "absent.bin"}))),
        ),
        (
            "a mesh whose primitive has no positions",
            Box::new(|t: &mut TinyGltf| {
                t.list("meshes").push(json!({"primitives": [{"attributes": {}}]}));
                t.list("nodes").push(json!({"mesh": 1}));
                t.json["scenes"][0]["nodes"] = json!([0, 1]);
            }),
        ),
        (
            "a camera with the parameters of both types",
            Box::new(|t: &mut TinyGltf| {
                t.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1},
                "orthographic": {"xmag": 1}}]);
            }),
        ),
    ];
    for (case, change) in cases {
        let mut tiny = TinyGltf::square();
        change(&mut tiny);
        let scene = gltf::load_bytes("a.glb", &tiny.glb()).unwrap_or_else(|e| panic!("{case}: {e}"));
        assert_eq!(scene.triangle_count(), 2, "{case}");
    }
}

#[test]
fn bytes_behind_and_between_the_chunks() {
    let tiny = TinyGltf::square();
    let whole = tiny.glb();
    let with_length = |mut bytes: Vec<u8>| {
        let length = (bytes.len() as u32).to_le_bytes();
        bytes[8..12].copy_from_slice(&length);
        bytes
    };
    let unknown_chunk = [&4_u32.to_le_bytes()[..], b"ACME", &[1, 2, 3, 4]].concat();
    let json_alone = tiny.gltf();
    let cases = [
        ("behind the declared length", [&whole[..], b"trailing"].concat()),
        ("within the declared length", with_length([&whole[..], &[0; 5]].concat())),
        ("a third chunk", with_length([&whole[..], &unknown_chunk].concat())),
        ("zeros behind the text", [&json_alone[..], &[0; 7]].concat()),
        ("a byte order mark before the text", [&b"\xef\xbb\xbf"[..], &json_alone].concat()),
        ("a text chunk padded with zeros", glb(&[&json_alone[..], &[0, 0, 0]].concat(), &[])),
    ];
    for (case, bytes) in cases {
        let scene = gltf::load_bytes("a.glb", &bytes).unwrap_or_else(|e| panic!("{case}: {e}"));
        assert_eq!(scene.triangle_count(), 2, "{case}");
    }
}

#[test]
fn required_extensions_of_shading_are_left_out_and_those_of_geometry_are_not() {
    for name in ["KHR_materials_clearcoat", "KHR_materials_variants", "KHR_materials_dispersion", "EXT_lights_ies"] {
        let scene = load_with(|t| {
            t.json["extensionsUsed"] = json!([name]);
            t.json["extensionsRequired"] = json!([name]);
        });
        assert!(has_note(&scene, name), "{name}: {:?}", scene.notes);
    }
    for name in ["ACME_magic", "KHR_gaussian_splatting", "KHR_implicit_shapes"] {
        let mut tiny = TinyGltf::square();
        tiny.json["extensionsRequired"] = json!([name]);
        let message = gltf::load_bytes("a.glb", &tiny.glb()).expect_err(name).to_string();
        assert!(message.contains(name), "{message}");
    }
}

#[test]
fn accessors_of_zeros_and_sparse_ones() {
    // A morph target of zeros moves nothing; normals of zeros are replaced.
    let scene = load_with(|t| {
        t.list("accessors").push(json!({"componentType": 5126, "type": "VEC3", "count": 4}));
        let zeros = t.json["accessors"].as_array().expect("a list").len() - 1;
        t.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": zeros}]);
        t.json["meshes"][0]["weights"] = json!([1.0]);
        t.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(zeros);
    });
    assert_eq!(scene.meshes[0].vertices[3].position, Vec3::from(SQUARE[3]));
    assert_eq!(scene.meshes[0].vertices[3].normal, Vec3::Z);
    // Sparse over nothing: all but one vertex at the origin.
    let scene = load_with(|t| {
        t.add_bytes(&[1, 2, 3]);
        t.add_bytes(bytemuck::cast_slice(&[[1.0_f32, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 5.0]]));
        let views = t.json["bufferViews"].as_array().expect("a list").len();
        let accessor = &mut t.json["accessors"][POSITIONS];
        accessor.as_object_mut().expect("an object").remove("bufferView");
        accessor["sparse"] = json!({"count": 3, "indices": {"bufferView": views - 2, "componentType": 5121},
            "values": {"bufferView": views - 1}});
    });
    assert_eq!(scene.meshes[0].vertices[3].position, vec3(1.0, 1.0, 5.0));
}

#[test]
fn default_weights_of_the_mesh_and_of_the_node() {
    let scene = load_with(|t| {
        let right = t.add_accessor([[1.0_f32, 0.0, 0.0]; 4].as_flattened(), "VEC3");
        let up = t.add_accessor([[0.0_f32, 2.0, 0.0]; 4].as_flattened(), "VEC3");
        t.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": right}, {"POSITION": up}]);
        t.json["meshes"][0]["weights"] = json!([0.5, 0.25]);
        t.list("nodes").push(json!({"mesh": 0, "weights": [0.0, 1.0]}));
        t.json["scenes"][0]["nodes"] = json!([0, 1]);
    });
    assert_eq!(world(&scene, 0)[0], dvec3(0.5, 0.5, 0.0));
    assert_eq!(world(&scene, 1)[0], dvec3(0.0, 2.0, 0.0));
}

/// A square on two joints: its upper corners on the second.
fn skinned(t: &mut TinyGltf, second_joint: Value) {
    t.add_bytes(&[[0_u8, 0, 0, 0], [0, 0, 0, 0], [1, 0, 0, 0], [1, 0, 0, 0]].concat());
    let view = t.json["bufferViews"].as_array().expect("a list").len() - 1;
    t.list("accessors").push(json!({"bufferView": view, "componentType": 5121, "type": "VEC4", "count": 4}));
    let joints = t.json["accessors"].as_array().expect("a list").len() - 1;
    let weights = t.add_accessor([[1.0_f32, 0.0, 0.0, 0.0]; 4].as_flattened(), "VEC4");
    let identity = [1.0_f32, 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.];
    let matrices = [identity, identity].concat();
    let bind = t.add_accessor(&matrices, "VEC4");
    (t.json["accessors"][bind]["type"], t.json["accessors"][bind]["count"]) = (json!("MAT4"), json!(2));
    for (name, accessor) in [("JOINTS_0", joints), ("WEIGHTS_0", weights)] {
        t.json["meshes"][0]["primitives"][0]["attributes"][name] = json!(accessor);
    }
    t.json["skins"] = json!([{"joints": [2, 3], "inverseBindMatrices": bind}]);
    t.json["nodes"] = json!([{"children": [1], "translation": [9.0, 9.0, 9.0]},
        {"mesh": 0, "skin": 0, "translation": [5.0, 0.0, 0.0]}, {"name": "hip"}, second_joint]);
    t.json["scenes"][0]["nodes"] = json!([0, 2, 3]);
}

#[test]
fn a_skin_alone_places_its_mesh() {
    let scene = load_with(|t| skinned(t, json!({})));
    for (found, corner) in world(&scene, 0).iter().zip(SQUARE) {
        assert_eq!(*found, Vec3::from(corner).as_dvec3(), "the node's own transform counts");
    }
    // A joint that is moved, turned and mirrored takes its vertices along.
    let scene = load_with(|t| skinned(t, json!({"translation": [0.0, 3.0, 0.0], "scale": [2.0, 1.0, 1.0]})));
    assert_eq!(world(&scene, 0)[3], dvec3(2.0, 4.0, 0.0));
    assert_eq!(world(&scene, 0)[0], DVec3::ZERO);
    let mut tiny = TinyGltf::square();
    skinned(&mut tiny, json!({}));
    tiny.json["skins"][0]["joints"] = json!([2]);
    let message = gltf::load_bytes("a.glb", &tiny.glb()).expect_err("a joint that is not there").to_string();
    assert!(message.contains("JOINTS") && message.contains("only 1 joints"), "{message}");
}

#[test]
fn every_instance_of_a_mesh() {
    let scene = load_with(|t| {
        let places = t.add_accessor(&[1.0, 0.0, 0.0, 2.0, 0.0, 0.0, 3.0, 0.0, 0.0], "VEC3");
        let scales = t.add_accessor(&[1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 1.0, 1.0, 1.0], "VEC3");
        t.json["nodes"][0]["translation"] = json!([0.0, 10.0, 0.0]);
        t.json["nodes"][0]["extensions"] = json!({"EXT_mesh_gpu_instancing":
            {"attributes": {"TRANSLATION": places, "SCALE": scales, "_ID": 0}}});
        t.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    });
    assert_eq!((scene.instances.len(), scene.meshes.len()), (3, 1));
    assert_eq!(world(&scene, 1)[3], dvec3(4.0, 12.0, 0.0));
    assert_eq!(world(&scene, 2)[0], dvec3(3.0, 10.0, 0.0));
}

#[test]
fn two_sets_of_texture_coordinates() {
    let second = [[0.25_f32, 0.25]; 4];
    let change = |sets: [u32; 3]| {
        load_with(|t| {
            t.add_base_color_texture(&png(2, 2, [200, 100, 50]));
            let uv1 = t.add_accessor(second.as_flattened(), "VEC2");
            let attributes = &mut t.json["meshes"][0]["primitives"][0]["attributes"];
            (attributes["TEXCOORD_1"], attributes["TEXCOORD_2"]) = (json!(uv1), json!(UVS));
            let info = |set: u32| json!({"index": 0, "texCoord": set});
            t.json["materials"][0] = json!({"emissiveFactor": [1, 1, 1], "emissiveTexture": info(sets[1]),
                "pbrMetallicRoughness": {"baseColorTexture": info(sets[0]), "metallicRoughnessTexture": info(sets[2])}});
        })
    };
    let scene = change([0, 1, 0]);
    let material = &scene.materials[0];
    let second_uv = |slot: Option<defocus::scene::TextureUse>| slot.expect("a texture").second_uv;
    assert!(!second_uv(material.base_color_texture) && second_uv(material.emissive_texture));
    assert!(scene.meshes[0].vertices.iter().all(|v| v.uv1 == Vec2::splat(0.25)));
    // The emissive texture alone may use the second set, which then is the vertices' first.
    let scene = change([1, 1, 1]);
    assert!(!second_uv(scene.materials[0].emissive_texture));
    assert!(scene.meshes[0].vertices.iter().all(|v| v.uv == Vec2::splat(0.25)));
    let scene = change([0, 1, 2]);
    assert!(has_note(&scene, "third set") && scene.materials[0].emissive_texture.is_none());
    // A transform names a set of its own.
    let scene = load_with(|t| {
        t.add_base_color_texture(&png(2, 2, [200, 100, 50]));
        let uv1 = t.add_accessor(second.as_flattened(), "VEC2");
        t.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = json!(uv1);
        t.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] =
            json!({"KHR_texture_transform": {"texCoord": 1}});
    });
    assert!(scene.meshes[0].vertices.iter().all(|v| v.uv == Vec2::splat(0.25)));
}

#[test]
fn a_texture_that_cannot_be_read_is_grey() {
    type Case = (&'static str, fn(&mut TinyGltf));
    let broken: [Case; 5] = [
        ("does not decode", |t| t.add_base_color_texture(b"this is no image")),
        ("does not decode", |t| t.add_base_color_texture(&png(64, 64, [9, 9, 9])[..60])),
        ("absent.png", |t| {
            t.add_base_color_texture(&png(2, 2, [0; 3]));
            t.json["images"] = json!([{"uri": "absent.png"}]);
        }),
        ("neither a uri nor a bufferView", |t| {
            t.add_base_color_texture(&png(2, 2, [0; 3]));
            t.json["textures"] = json!([{}]);
        }),
        ("does not decode", |t| {
            t.add_base_color_texture(b"KTX 20, or anything else");
            t.json["materials"][0]["emissiveTexture"] = json!({"index": 0});
            t.json["materials"][0]["normalTexture"] = json!({"index": 0});
            t.json["materials"][0]["emissiveFactor"] = json!([1, 1, 1]);
        }),
    ];
    for (fragment, change) in broken {
        let scene = load_with(change);
        assert!(has_note(&scene, "shown grey") && has_note(&scene, fragment), "{:?}", scene.notes);
        let material = &scene.materials[0];
        let texture = &scene.textures[material.base_color_texture.expect("the base colour").texture];
        assert_eq!(texture.rgba8, vec![[128, 128, 128, 255]]);
        assert!(material.emissive == Vec3::ZERO && material.normal_texture.is_none());
    }
}

#[test]
fn webp_by_its_extension_and_by_content() {
    let webp = {
        let mut bytes = std::io::Cursor::new(Vec::new());
        let image = image::RgbImage::from_pixel(2, 1, image::Rgb([255, 128, 0]));
        image.write_to(&mut bytes, image::ImageFormat::WebP).expect("encodes");
        bytes.into_inner()
    };
    for texture in [json!({"extensions": {"EXT_texture_webp": {"source": 0}}}), json!({"source": 0})] {
        let scene = load_with(|t| {
            t.add_base_color_texture(&webp);
            t.json["textures"] = json!([texture]);
            t.json["extensionsRequired"] = json!(["EXT_texture_webp"]);
        });
        assert_eq!(scene.textures[0].rgba8, vec![[255, 128, 0, 255]; 2]);
    }
}

#[test]
fn cameras_of_all_nodes_by_names_of_their_own() {
    let scene = load_with(|t| {
        t.json["cameras"] = json!([{"name": "Eye", "type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}]);
        let nodes = json!([{"mesh": 0}, {"camera": 0}, {"camera": 0, "translation": [0, 0, 7]}]);
        (t.json["nodes"], t.json["scenes"][0]["nodes"]) = (nodes, json!([0, 1, 2]));
    });
    let names: Vec<&str> = scene.cameras.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["Eye", "Eye 2"]);
    assert_eq!(scene.cameras[1].camera.position, dvec3(0.0, 0.0, 7.0));
}

/// Half a frame's height away from the middle is `ymag`, at any depth of the scene.
#[test]
fn orthographic_cameras_look_with_almost_parallel_rays() {
    let scene = load_with(|t| {
        t.json["cameras"] = json!([{"name": "Plan", "type": "orthographic",
            "orthographic": {"xmag": 1.5, "ymag": 0.5, "znear": 0.0, "zfar": 10.0}}]);
        t.json["nodes"] = json!([{"mesh": 0}, {"camera": 0, "translation": [0.0, 0.0, 2.0]}]);
        t.json["scenes"][0]["nodes"] = json!([0, 1]);
    });
    let camera = scene.cameras[0].camera;
    assert_eq!((scene.cameras[0].name.as_str(), camera.aspect), ("Plan", Some(3.0)));
    assert!(has_note(&scene, "almost parallel rays"));
    let projection = camera.projection(glam::UVec2::new(300, 100), 0);
    for z in [2.0, 1.0, 0.0] {
        let view = camera.view_from_world().transform_point3(dvec3(0.75, 0.25, z));
        let px = glam::dvec2(view.x, view.y) * projection.focal_px / -view.z;
        assert!((px - glam::dvec2(75.0, 25.0)).abs().max_element() < 0.5, "{px} at z = {z}");
        assert!(-view.z >= camera.near_m - 1e-9, "cut off by the near plane");
    }
}

#[test]
fn a_hidden_node_hides_its_children() {
    let scene = load_with(|t| {
        let hidden = json!({"KHR_node_visibility": {"visible": false}});
        t.json["nodes"] = json!([{"mesh": 0}, {"children": [2], "extensions": hidden}, {"mesh": 0}]);
        t.json["scenes"][0]["nodes"] = json!([0, 1]);
    });
    assert_eq!(scene.instances.len(), 1);
}

#[test]
fn quantised_attributes() {
    let scene = load_with(|t| {
        let corners: Vec<i16> = SQUARE.iter().flat_map(|c| [c[0] as i16 * 32767, c[1] as i16 * 32767, 0, 0]).collect();
        t.add_bytes(bytemuck::cast_slice(&corners));
        t.add_bytes(&[[0_u8, 0, 127, 0]; 4].concat());
        t.add_bytes(&[[0_u8, 255, 0, 0], [255, 255, 0, 0], [0, 0, 0, 0], [255, 0, 0, 0]].concat());
        let views = t.json["bufferViews"].as_array().expect("a list").len();
        for (accessor, view, stride, kind) in
            [(POSITIONS, views - 3, 8, 5122), (NORMALS, views - 2, 4, 5120), (UVS, views - 1, 4, 5121)]
        {
            t.json["bufferViews"][view]["byteStride"] = json!(stride);
            let accessor = &mut t.json["accessors"][accessor];
            (accessor["bufferView"], accessor["componentType"]) = (json!(view), json!(kind));
            accessor["normalized"] = json!(true);
        }
        t.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    });
    let expected = TinyGltf::square();
    assert_eq!(scene.meshes[0].vertices, load(&expected).meshes[0].vertices);
}

/// Squares in any number, from an encoder that is not ours.
mod meshopt {
    use super::*;
    use tiny_files::compressed::{add, compressed, grid};

    #[test]
    fn decodes_to_what_was_encoded() {
        // 121 vertices fill no block of 256; 6561 fill many.
        for (n, mode) in [(10, "TRIANGLES"), (10, "INDICES"), (80, "TRIANGLES")] {
            let (positions, normals, indices) = grid(n);
            let scene = load(&compressed(n, mode));
            let mesh = &scene.meshes[0];
            let corner = |i: u32| mesh.vertices[i as usize].position;
            for (vertex, (position, normal)) in mesh.vertices.iter().zip(positions.iter().zip(&normals)) {
                assert_eq!(vertex.position.to_array(), position[..3], "{n} {mode}");
                let off = (vertex.normal - Vec3::from_slice(normal)).length();
                assert!(off < 2e-3, "{n} {mode}: {} for {normal:?}", vertex.normal);
            }
            // The encoder may turn a triangle's corners round, and keeps its winding.
            assert_eq!(mesh.indices.len(), indices.len());
            for (found, expected) in mesh.indices.chunks_exact(3).zip(indices.chunks_exact(3)) {
                let turns = [[0, 1, 2], [1, 2, 0], [2, 0, 1]].map(|o| o.map(|k| expected[k]));
                assert!(turns.iter().any(|turn| turn == found), "{found:?} for {expected:?} at {}", corner(found[0]));
            }
        }
    }

    #[test]
    fn filters_decode_as_the_reference_does() {
        let mut t = compressed(4, "INDICES");
        let rotations: Vec<[f32; 4]> = (0..25)
            .map(|i| {
                let half = i as f32 * 0.1;
                [half.sin() * 0.6, half.sin() * 0.8, 0.0, half.cos()]
            })
            .collect();
        let quaternions = ::meshopt::encode_filter_quat(&rotations, 14);
        let bytes = ::meshopt::encode_vertex_buffer_level(&quaternions, 2, Some(0)).expect("encodes");
        let rotation_view = add(&mut t, &bytes, (25, 8), "ATTRIBUTES", "QUATERNION");
        let places: Vec<[f32; 3]> = (0..25).map(|i| [i as f32 * 0.37, -3.0, 1e-3 * i as f32]).collect();
        let shared = ::meshopt::EncodeExpMode::SharedVector;
        let exponents = ::meshopt::encode_filter_exp::<3>(&places, 20, shared);
        let bytes = ::meshopt::encode_vertex_buffer_level(&exponents, 2, Some(0)).expect("encodes");
        let place_view = add(&mut t, &bytes, (25, 12), "ATTRIBUTES", "EXPONENTIAL");
        t.list("accessors").push(json!({"bufferView": rotation_view, "componentType": 5122, "normalized": true,
            "type": "VEC4", "count": 25}));
        t.list("accessors").push(json!({"bufferView": place_view, "componentType": 5126, "type": "VEC3", "count": 25}));
        t.json["nodes"][0]["extensions"] =
            json!({"EXT_mesh_gpu_instancing": {"attributes": {"ROTATION": 3, "TRANSLATION": 4}}});
        let scene = load(&t);
        assert_eq!(scene.instances.len(), 25);
        for (instance, (rotation, place)) in scene.instances.iter().zip(rotations.iter().zip(&places)) {
            let (_, found, translation) = instance.world_from_object.to_scale_rotation_translation();
            let expected = glam::Quat::from_array(*rotation).as_dquat();
            assert!(found.dot(expected).abs() > 1.0 - 1e-6, "{found} for {expected}");
            assert!((translation.as_vec3() - Vec3::from(*place)).abs().max_element() < 1e-4, "{translation}");
        }
    }

    #[test]
    fn damaged_streams_are_errors() {
        let whole = compressed(10, "TRIANGLES");
        let mut refused = 0;
        for at in (0..whole.bin.len()).step_by(3) {
            let mut damaged = whole.clone();
            damaged.bin[at] ^= 0x5a;
            if let Err(error) = gltf::load_bytes("a.glb", &damaged.glb()) {
                assert!(!error.to_string().contains('\n'), "{error}");
                refused += 1;
            }
        }
        assert!(refused > 0);
        // A count that the bytes cannot fill asks for no memory.
        let mut endless = whole.clone();
        for view in endless.list("bufferViews") {
            if let Some(source) = view.pointer_mut("/extensions/EXT_meshopt_compression") {
                source["count"] = json!(1_u64 << 36);
                let stride = source["byteStride"].as_u64().expect("a stride");
                view["byteLength"] = json!(stride << 36);
            }
        }
        assert!(gltf::load_bytes("a.glb", &endless.glb()).is_err());
    }
}

#[test]
fn specular_glossiness_is_converted() {
    let pair = |diffuse: Value, specular: Value| {
        load_with(|t| {
            t.add_base_color_texture(&png(2, 2, [255, 255, 255]));
            let mut extension = json!({"glossinessFactor": 0.25, "specularFactor": specular, "diffuseFactor": diffuse});
            extension["diffuseTexture"] = json!({"index": 0});
            t.json["materials"][0] = json!({"extensions": {"KHR_materials_pbrSpecularGlossiness": extension}});
        })
    };
    let plastic = pair(json!([0.5, 0.25, 0.125, 1.0]), json!([0.04, 0.04, 0.04]));
    let material = &plastic.materials[0];
    let texel = |slot: Option<defocus::scene::TextureUse>| plastic.textures[slot.expect("a texture").texture].rgba8[0];
    // 0.5, 0.25 and 0.125 linear are 188, 137 and 99 in sRGB.
    assert_eq!(texel(material.base_color_texture), [188, 137, 99, 255]);
    assert_eq!(texel(material.metallic_roughness_texture), [0, 191, 0, 255]);
    assert!(has_note(&plastic, "converted to metallic-roughness"));
    let without = load_with(|t| {
        t.json["materials"][0] = json!({"extensions": {"KHR_materials_pbrSpecularGlossiness":
            {"diffuseFactor": [0, 0, 0, 1], "specularFactor": [1.0, 0.75, 0.25], "glossinessFactor": 1.0}}});
    });
    let metal = &without.materials[0];
    assert!(metal.metallic > 0.999 && metal.roughness < 1e-6 && metal.base_color.y > 0.74, "{metal:?}");
}

/// Accessors are shared and images are flat: a file of some kilobytes must not ask for
/// gigabytes.
#[test]
fn memory_is_bounded_by_the_file() {
    let mut many = TinyGltf::square();
    let primitive = many.json["meshes"][0]["primitives"][0].clone();
    many.json["accessors"][INDICES]["count"] = json!(6);
    many.list("accessors").push(json!({"componentType": 5126, "type": "VEC3", "count": 1 << 20}));
    let zeros = many.json["accessors"].as_array().expect("a list").len() - 1;
    let mut large = primitive.clone();
    large["attributes"] = json!({"POSITION": zeros});
    many.json["meshes"][0]["primitives"] = json!(vec![large; 100]);
    let message = gltf::load_bytes("a.glb", &many.glb()).expect_err("100 million vertices").to_string();
    assert!(message.contains("vertices") && message.contains("more than the file"), "{message}");

    let mut crowd = TinyGltf::square();
    crowd.list("accessors").push(json!({"componentType": 5126, "type": "VEC3", "count": 1 << 19}));
    let extension = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 4}}});
    crowd.json["nodes"] = json!(vec![json!({"mesh": 0, "extensions": extension}); 50]);
    crowd.json["scenes"][0]["nodes"] = json!((0..50).collect::<Vec<_>>());
    let message = gltf::load_bytes("a.glb", &crowd.glb()).expect_err("25 million instances").to_string();
    assert!(message.contains("instances"), "{message}");

    let mut flat = TinyGltf::square();
    flat.add_base_color_texture(&png(2500, 2500, [1, 2, 3]));
    let view = flat.json["images"][0].clone();
    flat.json["images"] = json!(vec![view; 12]);
    flat.json["textures"] = json!((0..12).map(|i| json!({"source": i})).collect::<Vec<_>>());
    let material = |i: usize| json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": i}}});
    flat.json["materials"] = json!((0..12).map(material).collect::<Vec<_>>());
    let mut primitives = vec![primitive; 12];
    primitives.iter_mut().enumerate().for_each(|(i, p)| p["material"] = json!(i));
    flat.json["meshes"][0]["primitives"] = json!(primitives);
    let message = gltf::load_bytes("a.glb", &flat.glb()).expect_err("75 million pixels").to_string();
    assert!(message.contains("pixels"), "{message}");
}

/// A lamp among things that do not shine does not put out their light; the user chooses.
#[test]
fn one_small_emitter_leaves_the_rest_lit() {
    let with_lamp = |size: f64| {
        load_with(|t| {
            t.list("materials").push(json!({"emissiveFactor": [1, 1, 1],
                "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 40.0}}}));
            let mut lamp = t.json["meshes"][0].clone();
            lamp["primitives"][0]["material"] = json!(1);
            t.list("meshes").push(lamp);
            t.list("nodes").push(json!({"mesh": 1, "scale": [size, size, 1.0], "translation": [0.0, 0.0, 1.0]}));
            t.json["scenes"][0]["nodes"] = json!([0, 1]);
        })
    };
    let small = with_lamp(0.1);
    assert_eq!(small.lights.len(), 1);
    assert!(small.environment != defocus::scene::Environment::Black && has_note(&small, "light nothing else"));
    let large = with_lamp(2.0);
    assert!(large.lights.is_empty() && has_note(&large, "emissive surfaces alone"));

    let mut chosen = small.clone();
    gltf::relight(&mut chosen, gltf::Lighting::File);
    assert!(chosen.lights.is_empty() && chosen.environment == defocus::scene::Environment::Black);
    let mut chosen = large.clone();
    gltf::relight(&mut chosen, gltf::Lighting::Studio);
    gltf::relight(&mut chosen, gltf::Lighting::Studio);
    assert_eq!((chosen.lights.len(), chosen.environment), (1, small.environment));
}
