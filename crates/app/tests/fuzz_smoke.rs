//! The entries of the fuzz targets, fed with mutations of their seeds.

#![cfg(feature = "window")]

#[path = "../../../fuzz/entries.rs"]
mod entries;
#[path = "../../../tests/tiny_files/mod.rs"]
mod tiny_files;

use defocus_app::window::Document;
use defocus_study::stress::Random;
use serde_json::json;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::time::{Duration, Instant};
use tiny_files::compressed::compressed;
use tiny_files::{TinyGltf, gradient, png, png16};

/// Inputs of each target: the same in every run, however fast the machine is.
const INPUTS: u32 = 400;

/// How long a target is searched instead, if `DEFOCUS_FUZZ_SECONDS` says so.
fn search_time() -> Option<Duration> {
    let seconds = std::env::var("DEFOCUS_FUZZ_SECONDS").ok()?.parse().ok()?;
    Some(Duration::from_secs_f64(seconds))
}

type Entry = fn(&[u8]) -> bool;
type Seeds = Vec<(&'static str, Vec<u8>)>;

fn corpus(target: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus").join(target)
}

/// The seeds as the repository holds them; written anew where the environment says so.
fn seeds(target: &str, make: fn() -> Seeds) -> Vec<Vec<u8>> {
    let folder = corpus(target);
    if std::env::var_os("DEFOCUS_WRITE_SEEDS").is_some() {
        std::fs::create_dir_all(&folder).unwrap();
        for (name, bytes) in make() {
            std::fs::write(folder.join(name), bytes).unwrap();
        }
    }
    let mut files: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files.iter().map(|file| std::fs::read(file).unwrap()).collect()
}

fn image_with_depth(encoding: u8, color: &[u8], depth: &[u8]) -> Vec<u8> {
    let length = u16::try_from(color.len()).expect("seeds are small").to_le_bytes();
    [&[encoding][..], &length, color, depth].concat()
}

fn gltf_seeds() -> Seeds {
    let square = TinyGltf::square();
    let mut textured = square.clone();
    textured.add_base_color_texture(&png(2, 2, [200, 100, 50]));
    let mut posed = square.clone();
    let moved = posed.add_accessor([[0.5_f32, 0.0, 0.0]; 4].as_flattened(), "VEC3");
    posed.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": moved}]);
    posed.json["meshes"][0]["weights"] = json!([1.0]);
    posed.add_bytes(&[0; 16]);
    posed.list("accessors").push(json!({"bufferView": 5, "componentType": 5121, "type": "VEC4", "count": 4}));
    let weights = posed.add_accessor([[1.0_f32, 0.0, 0.0, 0.0]; 4].as_flattened(), "VEC4");
    let attributes = &mut posed.json["meshes"][0]["primitives"][0]["attributes"];
    (attributes["JOINTS_0"], attributes["WEIGHTS_0"]) = (json!(5), json!(weights));
    posed.json["skins"] = json!([{"joints": [1]}]);
    let instanced = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}});
    posed.json["nodes"] = json!([{"mesh": 0, "skin": 0}, {}, {"mesh": 0, "extensions": instanced}]);
    posed.json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    let (draco_streams, textures) = (tiny_files::streams::draco(), tiny_files::streams::ktx2());
    vec![
        ("square.glb", square.glb()),
        ("square.gltf", square.gltf()),
        ("textured.glb", textured.glb()),
        ("posed.glb", posed.glb()),
        ("triangles.glb", compressed(3, "TRIANGLES").glb()),
        ("indices.glb", compressed(3, "INDICES").glb()),
        ("animated.glb", tiny_files::animated().glb()),
        ("draco_edgebreaker.glb", tiny_files::draco(&draco_streams[0].2).glb()),
        ("draco_valence.glb", tiny_files::draco(&draco_streams[1].2).glb()),
        ("draco_sequential.glb", tiny_files::draco(&draco_streams[2].2).glb()),
        ("etc1s.glb", tiny_files::basisu(&textures[1].2).glb()),
        ("uastc.glb", tiny_files::basisu(&textures[3].2).glb()),
    ]
}

fn image_depth_seeds() -> Seeds {
    let color = png(6, 4, [10, 200, 90]);
    let depth = png16(6, 4, |x, y| (100 * x + y + 1) as u16);
    let folder = tempfile::tempdir().unwrap();
    let exr = folder.path().join("both.exr");
    let size = glam::UVec2::new(6, 4);
    let z = defocus::image::Image::from_fn(size, |x, y| 1.0 + (x * y) as f32);
    defocus::image_io::write_exr(&exr, &gradient(6, 4), Some(&z), None).unwrap();
    let exr = std::fs::read(exr).unwrap();
    let floats: Vec<f32> = (0..24).map(|i| 1.0 + i as f32).collect();
    let pfm = [&b"Pf\n6 4\n-1.0\n"[..], bytemuck::cast_slice(&floats)].concat();
    let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (4, 6), }\n";
    let length = (header.len() as u16).to_le_bytes();
    let npy = [&b"\x93NUMPY\x01\0"[..], &length, header.as_bytes(), bytemuck::cast_slice(&floats)].concat();
    let mut tiff = std::io::Cursor::new(Vec::new());
    let mut encoder = tiff::encoder::TiffEncoder::new(&mut tiff).unwrap();
    encoder.write_image::<tiff::encoder::colortype::Gray32Float>(6, 4, &floats).unwrap();
    let tiff = tiff.into_inner();
    let mut webp = std::io::Cursor::new(Vec::new());
    let grey = image::RgbImage::from_pixel(6, 4, image::Rgb([90, 90, 90]));
    grey.write_to(&mut webp, image::ImageFormat::WebP).unwrap();
    let webp = webp.into_inner();
    vec![
        ("metres", image_with_depth(0, &color, &depth)),
        ("inverse", image_with_depth(1, &color, &depth)),
        ("device_with_unknown", image_with_depth(0x82, &color, &depth)),
        ("exr_with_depth", image_with_depth(3, &exr, &[])),
        ("exr_twice", image_with_depth(3, &exr, &exr)),
        ("pfm", image_with_depth(4, &webp, &pfm)),
        ("npy", image_with_depth(5, &color, &npy)),
        ("tiff", image_with_depth(6, &color, &tiff)),
        ("jpeg_with_depth", image_with_depth(0, &jpeg_with_depth(&depth), &[])),
        ("half_size", image_with_depth(7, &color, &png16(3, 2, |x, y| (9 + x + y) as u16))),
    ]
}

/// A JPEG whose XMP holds a depth map, in one segment.
fn jpeg_with_depth(depth: &[u8]) -> Vec<u8> {
    let grey = image::GrayImage::from_pixel(6, 4, image::Luma([90]));
    let mut jpeg = std::io::Cursor::new(Vec::new());
    grey.write_to(&mut jpeg, image::ImageFormat::Jpeg).unwrap();
    let jpeg = jpeg.into_inner();
    let data = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, depth);
    let xmp = format!(
        "http://ns.adobe.com/xap/1.0/\0<r GDepth:Format='RangeInverse' GDepth:Near='1' GDepth:Far='9' GDepth:Data='{data}'/>"
    );
    let segment = [&[0xff, 0xe1][..], &(xmp.len() as u16 + 2).to_be_bytes(), xmp.as_bytes()].concat();
    [&jpeg[..2], &segment, &jpeg[2..]].concat()
}

fn presets_seeds() -> Seeds {
    vec![("presets.ron", include_bytes!("../../../assets/presets.ron").to_vec())]
}

fn state_seeds() -> Seeds {
    let default = Document::default();
    let mut changed = Document { scene: "atrium".into(), ..default.clone() };
    changed.lens.aperture = defocus::aperture::Aperture::polygon(5);
    let folder = tempfile::tempdir().unwrap();
    let saved = |document: &Document| {
        let file = folder.path().join("state.ron");
        defocus_app::window::write_state(&file, document).unwrap();
        std::fs::read(file).unwrap()
    };
    vec![("default.ron", saved(&default)), ("changed.ron", saved(&changed))]
}

/// Numbers that break arithmetic, as text and as bytes.
const WORDS: &[&[u8]] = &[
    b"-1",
    b"0",
    b"1e39",
    b"-1e-320",
    b"NaN",
    b"inf",
    b"4294967295",
    b"18446744073709551616",
    b"null",
    b"[]",
    b"{}",
    b"\"\"",
    b"()",
    b"\xff\xff\xff\xff",
    b"\0\0\0\0",
    b"\0\0\xc0\x7f",
    b"\0\0\x80\xff",
    b"\xff\xff\xff\x7f",
];

/// One to four changes of a seed.
fn mutated(random: &mut Random, seeds: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = seeds[random.index(seeds.len())].clone();
    for _ in 0..1 + random.index(4) {
        let at = random.index(bytes.len() + 1);
        match random.index(7) {
            0 if at < bytes.len() => bytes[at] ^= 1 << random.index(8),
            1 if at < bytes.len() => bytes[at] = random.bits() as u8,
            2 => bytes.truncate(at),
            3 => {
                let end = (at + 1 + random.index(16)).min(bytes.len());
                bytes.drain(at.min(end)..end);
            }
            4 => {
                let other = &seeds[random.index(seeds.len())];
                let from = random.index(other.len() + 1);
                let to = (from + random.index(64)).min(other.len());
                bytes.splice(at..at, other[from..to].iter().copied());
            }
            5 => {
                let word = WORDS[random.index(WORDS.len())];
                let end = (at + word.len()).min(bytes.len());
                bytes.splice(at..end, word.iter().copied());
            }
            // A number in text by another one.
            _ => {
                if let Some(start) = (at..bytes.len()).find(|i| bytes[*i].is_ascii_digit()) {
                    let length = bytes[start..].iter().take_while(|b| b.is_ascii_digit() || **b == b'.').count();
                    let word = WORDS[random.index(WORDS.len())];
                    bytes.splice(start..start + length, word.iter().copied());
                }
            }
        }
    }
    bytes
}

/// Feeds mutations; a panic is reported with the input's number and file.
fn smoke(target: &str, entry: Entry, make: fn() -> Seeds) {
    let seeds = seeds(target, make);
    assert!(!seeds.is_empty(), "fuzz/corpus/{target} is empty");
    for (index, seed) in seeds.iter().enumerate() {
        assert!(entry(seed), "seed {index} of {target} is not accepted");
    }
    let mut random = Random::new(1);
    let start = Instant::now();
    let (mut inputs, mut accepted) = (0, 0);
    let search_time = search_time();
    while search_time.map_or(inputs < INPUTS, |time| start.elapsed() < time) {
        let input = mutated(&mut random, &seeds);
        match catch_unwind(AssertUnwindSafe(|| entry(&input))) {
            Ok(good) => accepted += u32::from(good),
            Err(_) => {
                let file = std::env::temp_dir().join(format!("defocus-fuzz-{target}"));
                std::fs::write(&file, &input).unwrap();
                panic!("{target}: input {inputs} is not handled; it is in {}", file.display());
            }
        }
        inputs += 1;
    }
    eprintln!("{target}: {inputs} inputs, {accepted} accepted");
    // Mutations that are all refused, or all accepted, would test nothing.
    assert!(accepted > 0 && accepted < inputs, "{target}: {accepted} of {inputs} accepted");
}

#[test]
fn scenes_from_mutated_files() {
    smoke("gltf", entries::gltf, gltf_seeds);
}

#[test]
fn images_with_depth_from_mutated_files() {
    smoke("image_depth", entries::image_depth, image_depth_seeds);
}

#[test]
fn presets_from_mutated_text() {
    smoke("presets", entries::presets, presets_seeds);
}

#[test]
fn states_from_mutated_text() {
    smoke("state", entries::state, state_seeds);
}

/// Found by a mutated state: what a file calls a method can hold line breaks.
#[test]
fn names_with_line_breaks_are_quoted_on_one_line() {
    let messages = [
        defocus::methods::by_id("mip\n  map").err().map(|e| e.to_string()),
        "disc\n:2".parse::<defocus::aperture::Aperture>().err().map(|e| e.to_string()),
        defocus::presets::preset("eye\n").err().map(|e| e.to_string()),
    ];
    for message in messages {
        let message = message.expect("no such name is known");
        assert!(!message.contains('\n') && message.contains("\\n"), "{message}");
    }
}
