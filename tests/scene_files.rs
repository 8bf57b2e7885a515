//! What a valid glTF file becomes.

mod tiny_files;

use defocus::scene::{Environment, LightKind, Scene, Wrap};
use glam::{DVec3, UVec2, Vec2, Vec3, dvec3};
use serde_json::{Value, json};
use tiny_files::{INDICES, NORMALS, POSITIONS, SQUARE, SQUARE_UV, TinyGltf, UVS, load, png};

fn load_with(change: impl FnOnce(&mut Value)) -> Scene {
    let mut tiny = TinyGltf::square();
    change(&mut tiny.json);
    load(&tiny)
}

fn has_note(scene: &Scene, fragment: &str) -> bool {
    scene.notes.iter().any(|note| note.contains(fragment))
}

fn emissive(json: &mut Value, factor: f64, strength: f64) {
    json["materials"][0]["emissiveFactor"] = json!([factor, 0.0, factor]);
    json["materials"][0]["extensions"]["KHR_materials_emissive_strength"] = json!({"emissiveStrength": strength});
}

#[test]
fn a_file_without_light_gets_the_default_one() {
    let scene = load_with(|_| {});
    assert_eq!(scene.lights.len(), 1);
    assert!(matches!(scene.environment, Environment::Studio { .. }));
    assert!(has_note(&scene, "a directional light and a neutral studio are added"));
    let LightKind::Directional { direction } = scene.lights[0].kind else { panic!("{:?}", scene.lights) };
    let in_view = scene.cameras[0].camera.orientation.inverse() * direction;
    assert!(in_view.x > 0.0 && in_view.y < 0.0 && in_view.z < 0.0, "not over the left shoulder: {in_view}");
    // A label that glows with radiance 1 is no lamp.
    let scene = load_with(|json| emissive(json, 1.0, 1.0));
    assert_eq!(scene.lights.len(), 1);
}

#[test]
fn self_lit_and_unlit_files_get_no_light() {
    let self_lit = load_with(|json| emissive(json, 0.5, 40.0));
    assert_eq!(self_lit.materials[0].emissive, Vec3::new(20.0, 0.0, 20.0));
    assert!(has_note(&self_lit, "emissive surfaces alone"));
    let unlit = load_with(|json| json["materials"][0]["extensions"] = json!({"KHR_materials_unlit": {}}));
    assert!(unlit.materials[0].unlit && has_note(&unlit, "every material is unlit"));
    let both = load_with(|json| {
        json["materials"][0]["extensions"] = json!({"KHR_materials_unlit": {}});
        emissive(json, 1.0, 40.0);
    });
    assert_eq!(both.materials[0].emissive, Vec3::ZERO);
    for scene in [self_lit, unlit, both] {
        assert!(scene.lights.is_empty());
        assert_eq!(scene.environment, Environment::Black);
    }
}

#[test]
fn punctual_lights_alone_light_their_file() {
    let scene = load_with(|json| {
        json["extensionsRequired"] = json!(["KHR_lights_punctual"]);
        json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
            {"type": "directional", "intensity": 3.0, "color": [1.0, 0.5, 0.25]},
            {"type": "spot", "intensity": 2.0, "range": 7.0, "spot": {"innerConeAngle": 0.25, "outerConeAngle": 0.5}},
            {"type": "point"}
        ]}});
        let light = |index: u32| json!({"KHR_lights_punctual": {"light": index}});
        let quarter_turn_about_x = [-std::f64::consts::FRAC_1_SQRT_2, 0.0, 0.0, std::f64::consts::FRAC_1_SQRT_2];
        json["nodes"] = json!([
            {"mesh": 0}, {"extensions": light(0), "rotation": quarter_turn_about_x},
            {"extensions": light(1), "translation": [1.0, 2.0, 3.0], "scale": [5.0, 5.0, 5.0]}, {"extensions": light(2)}
        ]);
        json["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
        emissive(json, 1.0, 9.0);
    });
    assert_eq!((scene.lights.len(), scene.environment), (3, Environment::Black));
    assert_eq!(scene.lights[0].intensity, Vec3::new(3.0, 1.5, 0.75));
    let LightKind::Directional { direction } = scene.lights[0].kind else { panic!("{:?}", scene.lights) };
    assert!((direction - DVec3::NEG_Y).length() < 1e-12, "{direction}");
    let LightKind::Spot { position, range_m, direction, cos_inner, cos_outer } = scene.lights[1].kind else {
        panic!("{:?}", scene.lights)
    };
    assert_eq!((position, range_m, direction), (dvec3(1.0, 2.0, 3.0), 7.0, DVec3::NEG_Z));
    assert_eq!((cos_inner, cos_outer), (0.25_f64.cos(), 0.5_f64.cos()));
    assert!(matches!(scene.lights[2].kind, LightKind::Point { range_m: f64::INFINITY, .. }));
}

#[test]
fn the_author_overrides_environment_and_focus() {
    let scene = load_with(|json| {
        json["scenes"][0]["extras"] = json!({"other": 1, "defocus": {"focus_m": 1.2, "environment":
            {"zenith": [0.1, 0.2, 0.3], "horizon": [1.0, 1.0, 1.0], "ground": [0.0, 0.0, 0.0], "softbox": 4.0}}});
        emissive(json, 1.0, 40.0);
    });
    let (zenith, horizon, ground) = (Vec3::new(0.1, 0.2, 0.3), Vec3::ONE, Vec3::ZERO);
    assert_eq!(scene.environment, Environment::Studio { zenith, horizon, ground, softbox: 4.0 });
    assert_eq!((scene.focus_hint_m, scene.lights.len()), (Some(1.2), 0));
}

#[test]
fn a_camera_of_the_file_is_kept_exactly() {
    let (yfov, aspect) = (0.610_865_238_198_015_3, 4.0 / 3.0);
    let scene = load_with(|json| {
        json["cameras"] = json!([
            {"type": "orthographic", "name": "Plan", "orthographic": {"xmag": 1.0, "ymag": 1.0, "znear": 0.1, "zfar": 9.0}},
            {"type": "perspective", "name": "Eye", "perspective": {"yfov": yfov, "aspectRatio": aspect, "znear": 0.03}}
        ]);
        json["nodes"] = json!([{"mesh": 0}, {"camera": 0}, {"translation": [1e6, 0.0, 0.0], "children": [3]},
            {"camera": 1, "translation": [0.001, 2.0, 5.0], "scale": [3.0, 1.0, 2.0]}]);
        json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    });
    assert_eq!((scene.cameras.len(), scene.cameras[0].name.as_str()), (2, "Plan"));
    let (name, camera) = (&scene.cameras[1].name, scene.cameras[1].camera);
    assert_eq!((name.as_str(), camera.fov_y, camera.aspect, camera.near_m), ("Eye", yfov, Some(aspect), 0.03));
    assert_eq!(camera.position, dvec3(1_000_000.001, 2.0, 5.0));
    assert_eq!(camera.forward(), DVec3::NEG_Z);
}

#[test]
fn a_camera_under_a_mirrored_node_is_a_rotation() {
    let scene = load_with(|json| {
        json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}]);
        json["nodes"] = json!([{"mesh": 0}, {"scale": [-1.0, 1.0, 1.0], "children": [2]},
            {"camera": 0, "rotation": [0.0, 0.6, 0.0, 0.8]}]);
        json["scenes"][0]["nodes"] = json!([0, 1]);
    });
    let camera = scene.cameras[0].camera;
    // Looking along (-sin, 0, -cos) of the node's angle with x mirrored; up stays up.
    let (sin, cos) = (2.0 * 0.6 * 0.8, 0.8 * 0.8 - 0.6 * 0.6);
    assert!((camera.forward() - dvec3(sin, 0.0, -cos)).length() < 1e-12, "{}", camera.forward());
    assert!((camera.orientation * DVec3::Y - DVec3::Y).length() < 1e-12);
}

#[test]
fn framing_shows_the_whole_scene_whatever_its_size() {
    for scale in [1e-3, 1.0, 1e5] {
        let scene = load_with(|json| json["nodes"][0]["scale"] = json!([scale, 2.0 * scale, scale]));
        assert_eq!(scene.cameras[0].name, "framing");
        let camera = scene.cameras[0].camera;
        assert!((camera.fov_y.to_degrees() - 40.0).abs() < 1e-9);
        let projection = camera.projection(UVec2::new(100, 100), 0);
        let mut highest = 0.0_f64;
        for corner in SQUARE {
            let world = scene.instances[0].world_from_object.transform_point3(Vec3::from(corner).as_dvec3());
            let view = camera.view_from_world().transform_point3(world);
            let p = glam::dvec2(view.x, view.y) * projection.focal_px / -view.z;
            assert!(-view.z > camera.near_m && p.abs().max_element() < 50.0, "{corner:?} is outside at {p}");
            highest = highest.max(p.abs().max_element());
        }
        assert!(highest > 25.0, "the scene fills too little of the frame: {highest} of 50 px");
        assert!(camera.forward().z < 0.0 && camera.forward().x < 0.0 && camera.forward().y < 0.0);
    }
}

/// Signed area of a mesh seen from +z.
fn area_z(scene: &Scene) -> f32 {
    let mesh = &scene.meshes[0];
    let position = |i: &u32| mesh.vertices[*i as usize].position;
    let triangles = mesh.indices.as_chunks::<3>().0.iter();
    triangles.map(|[a, b, c]| 0.5 * (position(b) - position(a)).cross(position(c) - position(a)).z).sum()
}

#[test]
fn strips_fans_and_all_index_types_give_the_same_square() {
    let mut cases = Vec::new();
    let with_indices = |indices: &[u8], component: u32, count: usize, mode: u32| {
        let mut tiny = TinyGltf::square();
        tiny.add_bytes(indices);
        let view = tiny.json["bufferViews"].as_array().expect("an array").len() - 1;
        tiny.json["accessors"][INDICES] =
            json!({"bufferView": view, "componentType": component, "type": "SCALAR", "count": count});
        tiny.json["meshes"][0]["primitives"][0]["mode"] = json!(mode);
        load(&tiny)
    };
    cases.push(("list, u8", with_indices(&[0, 1, 2, 2, 1, 3], 5121, 6, 4)));
    cases.push(("list, u32", with_indices(bytemuck::cast_slice(&[0_u32, 1, 2, 2, 1, 3]), 5125, 6, 4)));
    cases.push(("strip, u8", with_indices(&[0, 1, 2, 3], 5121, 4, 5)));
    cases.push(("fan, u16", with_indices(bytemuck::cast_slice(&[0_u16, 1, 3, 2]), 5123, 4, 6)));
    let strip_with_a_bridge = [0, 1, 2, 2, 2, 1, 3];
    cases.push(("strip with degenerate triangles", with_indices(&strip_with_a_bridge, 5121, 7, 5)));
    cases.push((
        "strip without indices",
        load_with(|json| {
            json["meshes"][0]["primitives"][0].as_object_mut().expect("an object").remove("indices");
            json["meshes"][0]["primitives"][0]["mode"] = json!(5);
        }),
    ));
    for (case, scene) in cases {
        assert_eq!(scene.triangle_count(), 2, "{case}");
        assert!((area_z(&scene) - 1.0).abs() < 1e-6, "{case}: area {}", area_z(&scene));
    }
}

#[test]
fn instances_share_a_mesh_and_mirrored_ones_stay_mirrored() {
    let scene = load_with(|json| {
        json["nodes"] = json!([
            {"mesh": 0, "translation": [1.0, 0.0, 0.0]},
            {"matrix": [-2.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 5.0, 6.0, 7.0, 1.0], "children": [2]},
            {"mesh": 0, "translation": [1.0, 0.0, 0.0], "rotation": [0.0, 0.0, 0.0, 1.0005]}
        ]);
        json["scenes"][0]["nodes"] = json!([0, 1]);
    });
    assert_eq!((scene.meshes.len(), scene.instances.len(), scene.triangle_count()), (1, 2, 4));
    let mirrored = scene.instances[1].world_from_object;
    assert!((mirrored.matrix3.determinant() + 2.0).abs() < 1e-12, "{mirrored}");
    assert!((mirrored.transform_point3(DVec3::X) - dvec3(1.0, 6.0, 7.0)).length() < 1e-12);
}

#[test]
fn absent_normals_are_flat_and_zero_normals_are_repaired() {
    let flat = load_with(|json| {
        json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().expect("an object").remove("NORMAL");
    });
    assert_eq!(flat.meshes[0].vertices.len(), 6);
    assert!(flat.meshes[0].vertices.iter().all(|v| v.normal == Vec3::Z));
    let mut tiny = TinyGltf::square();
    tiny.overwrite(NORMALS, 0, bytemuck::cast_slice(&[0.0_f32, 0.0, 0.0, f32::NAN, 0.0, 0.0, 0.0, 3.0, 4.0]));
    let repaired = load(&tiny);
    let normals: Vec<Vec3> = repaired.meshes[0].vertices.iter().map(|v| v.normal).collect();
    assert_eq!(&normals[..2], &[Vec3::Z, Vec3::Z]);
    assert!((normals[2] - Vec3::new(0.0, 0.6, 0.8)).length() < 1e-6);
    assert!(has_note(&repaired, "normals of length zero"));
}

fn with_texture(change: impl FnOnce(&mut Value)) -> Scene {
    let mut tiny = TinyGltf::square();
    tiny.add_base_color_texture(&png(2, 1, [255, 128, 0]));
    change(&mut tiny.json);
    load(&tiny)
}

#[test]
fn generated_tangents_follow_the_image() {
    let normal_map = |transform: Value| {
        with_texture(|json| {
            json["materials"][0]["normalTexture"] =
                json!({"index": 0, "scale": 0.5, "extensions": {"KHR_texture_transform": transform}});
        })
    };
    for vertex in &normal_map(json!({})).meshes[0].vertices {
        // u runs along +x, and the image's top is at +y: cross(z, x) = +y.
        assert!((vertex.tangent.truncate() - Vec3::X).length() < 1e-6 && vertex.tangent.w == 1.0, "{}", vertex.tangent);
    }
    for vertex in &normal_map(json!({"scale": [-1.0, 1.0]})).meshes[0].vertices {
        assert!(
            (vertex.tangent.truncate() + Vec3::X).length() < 1e-6 && vertex.tangent.w == -1.0,
            "{}",
            vertex.tangent
        );
    }
    assert!(has_note(&normal_map(json!({})), "tangents for normal maps are generated"));
}

#[test]
fn texture_transforms_are_those_of_the_extension() {
    let rows = |transform: Value| {
        let scene = with_texture(|json| {
            json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] =
                json!({"KHR_texture_transform": transform});
        });
        let used = scene.materials[0].base_color_texture.expect("a texture");
        move |u: f32, v: f32| Vec2::new(used.u_row.dot(Vec3::new(u, v, 1.0)), used.v_row.dot(Vec3::new(u, v, 1.0)))
    };
    let identity = rows(json!({}));
    assert_eq!(identity(0.3, 0.7), Vec2::new(0.3, 0.7));
    // The extension's own example: "only the lower left quadrant, rotated clockwise 90
    // degrees"; the image's left edge is u = 0, its lower edge v = 1.
    let quadrant = rows(json!({"offset": [0.0, 1.0], "rotation": std::f64::consts::FRAC_PI_2, "scale": [0.5, 0.5]}));
    for (uv, expected) in
        [((0.0, 0.0), (0.0, 1.0)), ((1.0, 0.0), (0.0, 0.5)), ((0.0, 1.0), (0.5, 1.0)), ((1.0, 1.0), (0.5, 0.5))]
    {
        let found = quadrant(uv.0, uv.1);
        assert!((found - Vec2::from(expected)).length() < 1e-6, "{uv:?} goes to {found}");
    }
    let flipped = rows(json!({"offset": [0.0, 1.0], "scale": [1.0, -1.0]}));
    assert_eq!(flipped(0.25, 0.25), Vec2::new(0.25, 0.75));
}

#[test]
fn one_image_as_colour_and_as_data_makes_two_textures() {
    let scene = with_texture(|json| {
        json["textures"] = json!([{"source": 0, "sampler": 0}, {"source": 0, "sampler": 0}]);
        json["samplers"] = json!([{"wrapS": 33071, "wrapT": 33648}]);
        json["materials"][0]["pbrMetallicRoughness"]["metallicRoughnessTexture"] = json!({"index": 1});
        json["materials"][0]["emissiveTexture"] = json!({"index": 1});
    });
    let material = &scene.materials[0];
    let index = |used: Option<defocus::scene::TextureUse>| used.expect("a texture").texture;
    assert_eq!(scene.textures.len(), 2);
    assert_eq!(index(material.base_color_texture), index(material.emissive_texture));
    let (color, data) = (
        &scene.textures[index(material.base_color_texture)],
        &scene.textures[index(material.metallic_roughness_texture)],
    );
    assert!(color.srgb && !data.srgb);
    assert_eq!((color.wrap, color.size), ([Wrap::Clamp, Wrap::Mirror], UVec2::new(2, 1)));
    assert_eq!(color.rgba8, vec![[255, 128, 0, 255]; 2]);
    let plain = with_texture(|_| {});
    assert_eq!(plain.textures[0].wrap, [Wrap::Repeat; 2]);
}

#[test]
fn texture_coordinates_colours_and_quantised_positions() {
    let mut tiny = TinyGltf::square();
    tiny.add_base_color_texture(&png(1, 1, [9, 9, 9]));
    let second = tiny.add_accessor(&[0.5; 8], "VEC2");
    let colors = tiny.add_accessor([[0.1, 0.2, 0.3]; 4].as_flattened(), "VEC3");
    tiny.add_bytes(bytemuck::cast_slice(&[[0_u16, 0, 0, 7], [65535, 0, 0, 7], [0, 65535, 0, 7], [65535, 65535, 0, 7]]));
    let view = tiny.json["bufferViews"].as_array().expect("an array").len() - 1;
    tiny.json["bufferViews"][view]["byteStride"] = json!(8);
    tiny.json["accessors"][POSITIONS] =
        json!({"bufferView": view, "componentType": 5123, "normalized": true, "type": "VEC3", "count": 4});
    tiny.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let attributes = json!({"POSITION": POSITIONS, "NORMAL": NORMALS, "TEXCOORD_0": UVS, "TEXCOORD_1": second, "COLOR_0": colors, "_BATCH": UVS});
    tiny.json["meshes"][0]["primitives"][0]["attributes"] = attributes;
    tiny.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = json!(1);
    tiny.json["materials"][0]["emissiveTexture"] = json!({"index": 0});
    let scene = load(&tiny);
    for (vertex, corner) in scene.meshes[0].vertices.iter().zip(SQUARE) {
        assert_eq!((vertex.position, vertex.uv), (Vec3::from(corner), Vec2::splat(0.5)));
        assert_eq!(vertex.color, glam::Vec4::new(0.1, 0.2, 0.3, 1.0));
    }
    assert!(scene.materials[0].emissive_texture.is_some_and(|slot| slot.second_uv));
    assert!(scene.meshes[0].vertices.iter().zip(SQUARE_UV).all(|(v, uv)| v.uv1 == Vec2::from(uv)));
}

#[test]
fn alpha_modes_and_approximations_are_noted() {
    let alpha = |mode: &str| {
        load_with(|json| {
            json["materials"][0]["alphaMode"] = json!(mode);
            json["materials"][0]["doubleSided"] = json!(true);
            json["materials"][0]["extensions"] = json!({"KHR_materials_transmission": {"transmissionFactor": 0.9}});
            json["extensionsUsed"] = json!(["KHR_materials_specular", "KHR_materials_transmission", "ACME_magic"]);
            if mode == "MASK" {
                json["materials"][0]["alphaCutoff"] = json!(0.25);
            }
        })
    };
    for (mode, cutoff) in [("OPAQUE", None), ("MASK", Some(0.25)), ("BLEND", None)] {
        let scene = alpha(mode);
        assert_eq!((scene.materials[0].alpha_cutoff, scene.materials[0].double_sided), (cutoff, true));
        // The square's colour covers all: a file that calls it blended changes nothing.
        assert!(!scene.materials[0].blended && scene.materials[0].transmission == 0.9);
        assert!(has_note(&scene, "what blended and transmissive materials cover is mixed"), "{:?}", scene.notes);
        assert!(has_note(&scene, "light passes transmissive materials without being bent"), "{:?}", scene.notes);
        assert!(
            has_note(&scene, "extensions that are ignored: KHR_materials_specular, ACME_magic"),
            "{:?}",
            scene.notes
        );
    }
}

/// Generated tangents against those of a real file whose author baked its normal maps.
#[test]
fn generated_tangents_agree_with_a_baker() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes/flight_helmet.glb");
    let Ok(bytes) = std::fs::read(&path) else {
        eprintln!("{} is absent: nothing to compare with", path.display());
        return;
    };
    let truth = defocus::scene::gltf::load(&path).unwrap_or_else(|e| panic!("{e}"));
    // The attribute is renamed in place, so that the loader no longer knows it.
    let mut renamed = bytes;
    let places: Vec<usize> =
        renamed.windows(9).enumerate().filter(|(_, w)| *w == b"\"TANGENT\"").map(|(i, _)| i).collect();
    places.iter().for_each(|&i| renamed[i + 1..i + 8].copy_from_slice(b"_ANGENT"));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let generated = defocus::scene::gltf::load(&tiny_files::write(folder.path(), "renamed.glb", &renamed))
        .unwrap_or_else(|e| panic!("{e}"));
    assert!(!places.is_empty() && has_note(&generated, "are generated"));
    let pairs = truth.meshes.iter().zip(&generated.meshes).flat_map(|(a, b)| a.vertices.iter().zip(&b.vertices));
    let (mut all, mut close, mut same_sign) = (0_usize, 0_usize, 0_usize);
    for (a, b) in pairs {
        all += 1;
        close += usize::from(a.tangent.truncate().dot(b.tangent.truncate()) > 0.9);
        same_sign += usize::from(a.tangent.w == b.tangent.w);
    }
    eprintln!("{all} vertices: {close} within 26 degrees, {same_sign} of the same handedness");
    // Other weights turn tangents where a mesh is strongly curved, but neither their
    // general direction nor the handedness.
    assert!(close as f64 > 0.95 * all as f64 && same_sign as f64 > 0.98 * all as f64);
}
