//! The program itself: what it writes, how it fails, and that it leaves nothing behind.

#[path = "../../../tests/tiny_files/mod.rs"]
mod tiny_files;

use defocus::image::{ColorImage, DepthImage, Image};
use defocus::image_io::{read_color, write_exr};
use glam::{UVec2, uvec2};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;
use tiny_files::{TinyGltf, gradient, png, png16, write};

const SIZE: UVec2 = uvec2(64, 48);

/// A folder with a scene of two squares, one far behind the other, and with images.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::create_dir(folder.path().join("user-cache")).expect("a folder");
    let mut scene = TinyGltf::square();
    scene.list("nodes").push(json!({"mesh": 0, "translation": [-2.0, -2.0, -4.0], "scale": [5.0, 5.0, 1.0]}));
    scene.json["scenes"][0]["nodes"] = json!([0, 1]);
    scene.add_base_color_texture(&png16(8, 8, |x, y| if (x + y) % 2 == 0 { 60000 } else { 8000 }));
    scene.json["materials"][0]["extensions"] = json!({"KHR_materials_unlit": {}});
    scene.json["extensionsUsed"] = json!(["KHR_materials_unlit"]);
    write(folder.path(), "scene.glb", &scene.glb());
    scene.json["extensionsRequired"] = json!(["KHR_gaussian_splatting"]);
    scene.json["extensionsUsed"] = json!(["KHR_materials_unlit", "KHR_gaussian_splatting"]);
    write(folder.path(), "required.glb", &scene.glb());
    write(folder.path(), "color.png", &png(8, 6, [200, 100, 50]));
    write(folder.path(), "depth.png", &png16(8, 6, |x, _| 1000 + 500 * x as u16));
    write(folder.path(), "wide.png", &png16(16, 6, |_, _| 1000));
    let depth = DepthImage::from_fn(SIZE, |x, _| 1.0 + x as f32 * 0.1);
    write_exr(&folder.path().join("rgbz.exr"), &gradient(64, 48), Some(&depth), None).expect("writes");
    write_exr(&folder.path().join("rgb.exr"), &gradient(8, 6), None, None).expect("writes");
    folder
}

fn defocus(folder: &Path, args: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_defocus"));
    // Drivers keep shaders there too.
    command.current_dir(folder).args(args.split_whitespace()).env("XDG_CACHE_HOME", folder.join("user-cache"));
    command
}

fn run(folder: &Path, args: &str) -> Output {
    defocus(folder, args).output().expect("the program starts")
}

/// Standard output of a run that must succeed.
fn stdout(folder: &Path, args: &str) -> String {
    let output = run(folder, args);
    assert!(output.status.success(), "defocus {args}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("UTF-8")
}

fn json_of(folder: &Path, args: &str) -> Value {
    serde_json::from_str(&stdout(folder, args)).unwrap_or_else(|e| panic!("defocus {args}: {e}"))
}

fn names(folder: &Path) -> BTreeSet<String> {
    let entries = std::fs::read_dir(folder).expect("the folder is there");
    entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect()
}

fn assert_keys(value: &Value, keys: &[&str]) {
    for key in keys {
        assert!(value.get(key).is_some(), "no key '{key}' in {value:#}");
    }
}

#[test]
fn render_writes_exr_layers_and_json() {
    let folder = folder();
    let args = "render scene.glb --size 64x48 --method accumulation --samples 8 --mean-coc 3 -o out.exr --json -";
    let json = json_of(folder.path(), args);
    let keys = "adapter backend scene size method params lens coc passes gpu_ms drawn skipped peak_texture_bytes";
    assert_keys(&json, &keys.split(' ').collect::<Vec<_>>());
    assert_keys(&json["lens"], &["E", "F", "dr", "ds", "dpi", "focus_m", "K_px", "aperture"]);
    assert_keys(&json["coc"], &["mean_px", "min_signed_px", "max_signed_px"]);
    assert_eq!(json["size"], json!([64, 48]));
    assert_eq!(json["method"], "accumulation");
    assert_eq!(json["params"], json!({"samples": 8, "view_dependent": false}));
    // The pinhole image, from which the CoC is known, is drawn before and not counted.
    assert_eq!(json["drawn"], json!({"triangles": 8 * 4, "views": 8}));
    assert_keys(&json["passes"][0], &["label", "ms"]);
    // E is found in f64 from f32 depths: their mean is exact to 2^-24 of the sum.
    assert!((json["coc"]["mean_px"].as_f64().expect("a number") - 3.0).abs() < 1e-6);

    let file = exr::prelude::read_all_flat_layers_from_file(folder.path().join("out.exr")).expect("an EXR");
    let channels = &file.layer_data[0].channel_data.list;
    let found: Vec<String> = channels.iter().map(|c| c.name.to_string()).collect();
    assert_eq!(found, ["B", "C", "G", "R", "Z"]);
    let plane = |i: usize| channels[i].sample_data.values_as_f32().collect::<Vec<f32>>();
    let (c, z) = (plane(1), plane(4));
    let (k, df) = (json["lens"]["K_px"].as_f64().expect("K"), json["lens"]["focus_m"].as_f64().expect("df"));
    for (c, z) in c.iter().zip(&z) {
        let expected = k * (1.0 - df / f64::from(*z));
        // Both planes are f32: two roundings of values below 64.
        assert!((f64::from(*c) - expected).abs() < 1e-4, "C = {c} at Z = {z}, not {expected}");
    }
}

#[test]
fn what_a_method_makes_on_its_way_is_saved_with_its_scale() {
    let folder = folder();
    let said = stdout(folder.path(), "render scene.glb --size 64x48 --method adaptive --mean-coc 3 --inside in");
    let written = names(&folder.path().join("in"));
    let lines: Vec<&str> = said.lines().collect();
    assert_eq!(lines.len(), written.len() + 1, "a line for each image, and the summary: {said}");
    for (file, line) in written.iter().zip(&lines) {
        assert!(line.contains(file), "{line} does not name {file}");
    }
    let classes = written.iter().position(|name| name.contains("tile-class")).expect("adaptive has tiles");
    assert!(lines[classes].ends_with("in focus: copied; one blur; traced"), "{}", lines[classes]);
    for file in &written {
        let image = read_color(&folder.path().join("in").join(file)).expect("a PNG");
        assert!(image.size.cmpge(SIZE / 8).all(), "{file}: a texel for each tile at least, not {}", image.size);
    }
}

#[test]
fn two_eyes_see_the_scene_from_two_places() {
    let folder = folder();
    let render = |size: &str, stereo: &str, out: &str| {
        let args = format!("render scene.glb --size {size} --method pinhole --overscan 8 {stereo} -o {out} --json -");
        json_of(folder.path(), &args)
    };
    let image = |file: &str| read_color(&folder.path().join(file)).expect("it was written");
    let json = render("64x48", "--stereo parallel --ipd-mm 120", "parallel.exr");
    assert_eq!(json["size"], json!([64, 48]));
    assert_eq!(json["stereo"], json!({"layout": "parallel", "ipd_mm": 120.0, "window_m": null}));
    let labels: Vec<&str> =
        json["passes"].as_array().expect("a list").iter().filter_map(|p| p["label"].as_str()).collect();
    for eye in ["left eye/", "right eye/"] {
        assert!(labels.iter().any(|label| label.starts_with(eye)), "{labels:?}");
    }
    render("64x48", "--stereo crossed --ipd-mm 120", "crossed.exr");
    let (parallel, crossed) = (image("parallel.exr"), image("crossed.exr"));
    let half = |image: &ColorImage, x: u32| image.crop(uvec2(x, 0), uvec2(32, 48));
    assert!(half(&parallel, 0) == half(&crossed, 32) && half(&parallel, 32) == half(&crossed, 0));
    assert!(half(&parallel, 0) != half(&parallel, 32), "the eyes stand apart");
    // Without a distance both see what one eye does.
    render("64x48", "--stereo parallel --ipd-mm 0", "cyclops.exr");
    assert_eq!(render("32x48", "", "one.exr")["stereo"], Value::Null);
    assert!(half(&image("cyclops.exr"), 0) == image("one.exr"));
    render("64x48", "--stereo grey-anaglyph --ipd-mm 120 --stereo-window 5", "anaglyph.png");
    let anaglyph = image("anaglyph.png");
    assert_eq!(anaglyph.size, uvec2(64, 48));
    assert!(anaglyph.pixels.iter().all(|p| p.y == p.z) && anaglyph.pixels.iter().any(|p| (p.x - p.y).abs() > 0.05));
}

#[test]
fn compare_writes_json_images_and_a_report() {
    let folder = folder();
    let args = "compare scene.glb --size 64x48 --samples 8 --runs 2 --mean-coc 3 --methods pinhole,accumulation,mipmap \
                --set accumulation.samples=8 -o out --json -";
    let json = json_of(folder.path(), args);
    assert_keys(&json, &["adapter", "scene", "size", "lens", "reference", "results"]);
    assert_eq!(json["reference"]["method"], "accumulation");
    assert_eq!(json["reference"]["samples"], 8);
    assert!(json["reference"]["self_psnr_db"].as_f64().is_some_and(|db| db > 10.0), "{json:#}");
    let keys = "method params psnr_db psnr_defocused_db ssim flip rel_mse worst_block_psnr_db gpu_ms drawn skipped \
                peak_texture_bytes";
    for result in json["results"].as_array().expect("a list") {
        assert_keys(result, &keys.split(' ').collect::<Vec<_>>());
    }
    let [pinhole, same, mipmap] = [0, 1, 2].map(|i| &json["results"][i]);
    assert_eq!(same["identical"], true, "the reference's own method with its number of lens points");
    assert_eq!(same["psnr_db"], Value::Null);
    assert_eq!(same["flip"], 0.0);
    let db = |result: &Value, key: &str| result[key].as_f64().expect("a number");
    for result in [pinhole, mipmap] {
        assert!((10.0..80.0).contains(&db(result, "psnr_db")), "neither equal nor unrelated: {result:#}");
    }
    assert!(db(pinhole, "psnr_defocused_db") <= db(pinhole, "psnr_db"), "pixels in focus only flatter");
    assert_eq!(mipmap["gpu_ms"]["runs"], 2);
    // At least the image and its depth are there.
    assert!(mipmap["peak_texture_bytes"].as_u64().expect("a number") >= 64 * 48 * (8 + 4), "{mipmap:#}");
    assert!(db(&mipmap["gpu_ms"], "min") <= db(&mipmap["gpu_ms"], "median"));

    let files = names(&folder.path().join("out"));
    for file in ["report.html", "results.json", "reference.png", "mipmap.png", "mipmap-flip.png", "mipmap-error.png"] {
        assert!(files.contains(file), "{file} is not among {files:?}");
    }
    let html = std::fs::read_to_string(folder.path().join("out/report.html")).expect("a report");
    assert!(html.contains("data:image/png;base64,") && !html.contains("http"), "the report needs nothing but itself");

    assert!(folder.path().join("user-cache/defocus/references").is_dir());
    let again = json_of(folder.path(), args);
    for key in ["reference", "lens"] {
        assert_eq!(again[key], json[key], "the cached reference is the same");
    }
    assert_eq!(again["results"][2]["psnr_db"], mipmap["psnr_db"]);
}

#[test]
fn a_traced_reference_agrees_with_an_accumulated_one() {
    let folder = folder();
    let args = "compare scene.glb --size 64x48 --samples 64 --runs 1 --no-cache --reference raytrace --shading unlit \
                --methods pinhole,accumulation --set samples=64 --mean-coc 3 --json -";
    let json = json_of(folder.path(), args);
    let db = |i: usize| json["results"][i]["psnr_db"].as_f64().expect("a number");
    // Both take the same lens points; what differs is f16 against f32 and which side of an
    // edge a pixel's centre falls on.
    assert!(db(1) > 35.0 && db(1) > db(0) + 10.0, "{json:#}");
    assert!(!folder.path().join("user-cache/defocus").exists(), "--no-cache keeps nothing");
}

#[test]
fn an_image_with_depth_is_compared_without_a_reference() {
    let folder = folder();
    let json = json_of(folder.path(), "compare rgbz.exr --size 32x32 --runs 1 --json -");
    assert_eq!(json["size"], json!([32, 24]), "shrunk to fit, in its own aspect ratio");
    assert_eq!(json["reference"], Value::Null);
    assert!(json["results"].as_array().is_some_and(|r| r.iter().any(|m| m["method"] == "mipmap")));
    assert_eq!(json["results"][0]["psnr_db"], Value::Null);
    let not_run = json["not_run"].as_array().expect("a list");
    assert!(not_run.iter().any(|m| m["method"] == "accumulation"));

    stdout(folder.path(), "render color.png --depth depth.png --depth-scale 0.001 --focus-at 0,0 -o out.png --quiet");
    let rendered = read_color(&folder.path().join("out.png")).expect("a PNG");
    assert_eq!(rendered.size, uvec2(8, 6));
}

#[test]
fn diff_tells_equal_from_different() {
    let folder = folder();
    let same = json_of(folder.path(), "diff rgb.exr rgb.exr --json -");
    assert_eq!((&same["identical"], &same["psnr_db"], &same["flip"]), (&json!(true), &Value::Null, &json!(0.0)));
    let darker = Image::from_fn(uvec2(8, 6), |x, y| gradient(8, 6).at(x, y) * 0.5);
    write_exr(&folder.path().join("darker.exr"), &darker, None, None).expect("writes");
    let different = json_of(folder.path(), "diff darker.exr rgb.exr --json -");
    assert_eq!(different["identical"], false);
    assert!(different["psnr_db"].as_f64().is_some_and(|db| db > 0.0 && db < 40.0), "{different:#}");
}

#[test]
fn lists_are_json_too() {
    let folder = folder();
    let names = |list: &str, key: &str| -> Vec<String> {
        let json = json_of(folder.path(), &format!("{list} --json"));
        let list = json.as_array().expect("a list").iter();
        list.map(|item| item[key].as_str().expect("a name").to_owned()).collect()
    };
    let ids: Vec<_> = defocus::methods::all().iter().map(|m| m.about().id.to_owned()).collect();
    assert_eq!(names("methods", "id"), ids);
    assert!(names("scenes", "name").contains(&"cans".to_owned()));
    assert!(names("lenses", "name").contains(&"projection".to_owned()));
    assert!(!names("adapters", "name").is_empty());
    let methods = json_of(folder.path(), "methods --json");
    let mipmap = methods.as_array().expect("a list").iter().find(|m| m["id"] == "mipmap").expect("mipmap");
    assert_keys(&mipmap["params"][0], &["key", "label", "help", "default", "range", "choices"]);
}

/// Command, exit code, what the message must say.
const WRONG: &[(&str, i32, &str)] = &[
    ("render scene.glb -o out.png --focus 0.01", 1, "does not exceed the focal length"),
    ("render missing.glb -o out.png", 1, "check that the file exists"),
    ("render nosuch -o out.png", 1, "there is no scene 'nosuch'"),
    ("render required.glb -o out.png", 1, "requires the glTF extension KHR_gaussian_splatting"),
    ("render rgb.exr -o out.png", 1, "has no depth channel Z"),
    ("render color.png -o out.png", 1, "give a depth map with --depth FILE"),
    ("render color.png --depth wide.png -o out.png", 1, "give a depth map of the image's own aspect ratio"),
    ("render color.png --depth depth.png --depth-kind inverse -o out.png", 1, "give --depth-range NEAR,FAR"),
    ("render color.png --depth depth.png --depth-scale 0 -o out.png", 1, "must be a positive number"),
    ("render color.png --depth depth.png --overscan 8 -o out.png", 1, "has no overscan"),
    ("render scene.glb --depth depth.png -o out.png", 1, "is a scene, which has its own depth"),
    ("render scene.glb -o out.png --size 0x48", 1, "cannot be drawn: both sides must lie between 1 and"),
    ("render scene.glb -o out.png --size 999999x48", 1, "cannot be drawn: both sides must lie between 1 and"),
    ("render scene.glb -o out.png --method nosuch", 1, "there is no method 'nosuch'; there are: pinhole"),
    ("render scene.glb -o out.png --set nosuch=1", 1, "mipmap has no parameter 'nosuch'"),
    ("render scene.glb -o out.png --set k=banana", 1, "mipmap.k cannot be 'banana': it must be a number from"),
    ("render scene.glb -o out.png --set k", 1, "give [ID.]KEY=VALUE"),
    ("render scene.glb -o out.png --set accumulation.samples=4", 1, "not among the chosen methods"),
    ("render scene.glb -o out.png --samples 4", 1, "mipmap has no lens points"),
    ("render scene.glb -o out.png --lens nosuch", 1, "there is no lens preset 'nosuch'"),
    ("render scene.glb -o out.png --adapter nosuch", 1, "no adapter is called 'nosuch'; there are:"),
    ("render scene.glb -o out.png --camera 7", 1, "has no camera '7'; it has framing"),
    ("render scene.glb -o out.png -E -1", 1, "E (aperture diameter) is -1 mm: it must be 0 or more"),
    ("render scene.glb -o out.png --dr 0", 1, "dr (distance to the image plane) is 0 mm: it must be above 0"),
    ("render scene.glb -o out.png --mean-coc -2", 1, "give a finite number of 0 or more"),
    ("render scene.glb -o out.png --fov 180", 1, "give more than 0 and less than 180"),
    ("render scene.glb -o out.png --size 64x48 --focus-at 64,0", 1, "lies outside the image of 64x48 px"),
    ("render scene.glb -o out.jpg", 1, "give a name that ends in .png or .exr"),
    ("render scene.glb -o no/folder/out.png", 1, "there is no folder no/folder; make it first"),
    ("compare scene.glb --methods mipmap,mipmap -o out", 1, "named twice"),
    (
        "compare scene.glb --methods mipmap,pinhole --set nosuch=1 -o out",
        1,
        "no chosen method has a parameter 'nosuch'",
    ),
    ("compare scene.glb --reference nosuch -o out", 1, "there is no method 'nosuch'"),
    ("compare scene.glb -o color.png", 1, "is a file; give the name of a folder"),
    ("compare rgbz.exr --methods accumulation -o out", 1, "accumulation: it needs a scene"),
    ("compare rgbz.exr --reference accumulation -o out", 1, "has no accumulation reference"),
    ("diff rgb.exr rgbz.exr --json out.json", 1, "metrics need images of one size"),
    ("diff rgb.exr missing.png --json out.json", 1, "check that the file exists"),
    ("render rgbz.exr -o out.png --stereo parallel", 1, "--stereo needs a scene"),
    ("render scene.glb -o out.exr --stereo anaglyph", 1, "give a name that ends in .png"),
    ("render scene.glb -o out.png --stereo sideways", 2, "there is no layout 'sideways'"),
    ("render scene.glb -o out.png --stereo parallel --ipd-mm -3", 2, "give millimetres from 0 to 1000"),
    ("render scene.glb -o out.png --stereo parallel --stereo-window 0", 2, "give metres from 0.05 on"),
    ("render scene.glb -o out.png --ipd-mm 60", 2, "--stereo"),
    ("render scene.glb --inside in --stereo parallel", 2, "cannot be used with"),
    ("render scene.glb --inside in --method raytrace", 1, "raytrace has nothing --inside"),
    ("render scene.glb --inside no/in", 1, "make it first"),
    ("render scene.glb", 2, "--output"),
    ("render -o out.png", 2, "SCENE"),
    ("render scene.glb -o out.png --size banana", 2, "such as 1024x768"),
    ("render scene.glb -o out.png --samples 0", 2, "1..=65536"),
    ("render scene.glb -o out.png --aperture star", 2, "there is no kind 'star'"),
    ("render scene.glb -o out.png --tonemap sepia", 2, "there is no tone map 'sepia'"),
    ("render scene.glb -o out.png --exposure 1e9", 2, "from -64 to 64"),
    ("render scene.glb -o out.png -E 2 --mean-coc 3", 2, "cannot be used with"),
    ("render scene.glb -o out.png --focus 2 --focus-at 1,1", 2, "cannot be used with"),
    ("render scene.glb -o out.png --time 1", 1, "has no animation"),
    ("render cans -o out.png --time 1", 1, "which are for .glb and .gltf files"),
    ("render scene.glb -o out.png --nosuch", 2, "unexpected argument '--nosuch'"),
    ("compare scene.glb --cache kept --no-cache", 2, "cannot be used with"),
    ("compare scene.glb --runs 0", 2, "1..=10000"),
];

#[test]
fn wrong_options_say_what_is_wrong_and_leave_nothing() {
    let folder = folder();
    let before = names(folder.path());
    for (args, code, message) in WRONG {
        let output = run(folder.path(), args);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(*code), "defocus {args}: {said}");
        assert!(said.contains(message), "defocus {args} says\n{said}\nand not '{message}'");
        if *code == 1 {
            // Graphics drivers may add lines of their own.
            assert_eq!(said.lines().filter(|line| line.starts_with("defocus: ")).count(), 1, "{said}");
        }
        assert!(output.stdout.is_empty(), "defocus {args} prints {}", String::from_utf8_lossy(&output.stdout));
        assert_eq!(names(folder.path()), before, "defocus {args} leaves something behind");
    }
}

#[test]
fn without_an_adapter_it_says_what_to_install() {
    let folder = folder();
    let mut command = defocus(folder.path(), "render scene.glb -o out.png");
    // Vulkan alone, and no driver for it.
    command
        .env("WGPU_BACKEND", "vulkan")
        .env("VK_ICD_FILENAMES", "/nonexistent")
        .env("VK_DRIVER_FILES", "/nonexistent");
    let output = command.output().expect("the program starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("no graphics adapter was found: install a Vulkan driver"), "{said}");
    assert!(!folder.path().join("out.png").exists());
}

#[cfg(unix)]
#[test]
fn an_interruption_leaves_nothing() {
    use std::time::{Duration, Instant};
    let folder = folder();
    let before = names(folder.path());
    // Views enough for many minutes, so that it cannot be done before it is interrupted.
    let args = "compare scene.glb --size 512x384 --samples 65536 --runs 1 --quiet -o out --json out.json";
    let mut child = defocus(folder.path(), args).spawn().expect("the program starts");
    std::thread::sleep(Duration::from_secs(2));
    assert!(child.try_wait().expect("a child").is_none(), "it is still at work");
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill is there");
    assert!(killed.success());
    let since = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().expect("a child") {
            break status;
        }
        if since.elapsed() > Duration::from_secs(60) {
            child.kill().expect("it can be killed");
            panic!("it does not stop when interrupted");
        }
        std::thread::sleep(Duration::from_millis(50));
    };
    assert_eq!(status.code(), Some(130));
    assert_eq!(names(folder.path()), before);
}

/// What is approximated is said on standard error and in the JSON, and light of another
/// scale is metered unless an exposure is named.
#[test]
fn notes_and_metering_are_said() {
    let folder = folder();
    let mut bright = TinyGltf::square();
    bright.json["materials"][0]["alphaMode"] = json!("BLEND");
    bright.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([1, 1, 1, 0.9]);
    bright.json["extensions"] =
        json!({"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": 6830.0}]}});
    bright.list("nodes").push(json!({"extensions": {"KHR_lights_punctual": {"light": 0}}}));
    bright.json["scenes"][0]["nodes"] = json!([0, 1]);
    write(folder.path(), "bright.glb", &bright.glb());
    let args = "render bright.glb --size 64x48 --method pinhole -o out.png --json out.json";
    let output = run(folder.path(), args);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        output.status.success() && said.contains("defocus: note: what blended and transmissive materials cover"),
        "{said}"
    );
    assert!(said.contains("EV, metered from the pinhole image"), "{said}");
    let text = std::fs::read_to_string(folder.path().join("out.json")).expect("written");
    let json: Value = serde_json::from_str(&text).expect("JSON");
    let notes: Vec<&str> = json["notes"].as_array().expect("notes").iter().filter_map(Value::as_str).collect();
    assert!(notes.iter().any(|n| n.contains("blended")) && notes.iter().any(|n| n.contains("metered")), "{notes:?}");
    let shown = read_color(&folder.path().join("out.png")).expect("a picture");
    let middle = shown.at(32, 24).x;
    assert!((0.05..0.6).contains(&middle), "{middle} is no picture that can be looked at");
    let quiet = run(folder.path(), &format!("{args} --exposure 0 --quiet"));
    assert!(quiet.stderr.is_empty(), "{}", String::from_utf8_lossy(&quiet.stderr));
    assert_eq!(read_color(&folder.path().join("out.png")).expect("a picture").at(32, 24).x, 1.0);
}

/// The ray tracer, which shares nothing with the rasteriser but the loaded scene, shows a
/// skin, instances, weights and a second set of texture coordinates alike.
#[test]
fn poses_instances_and_second_coordinates_agree_with_the_ray_tracer() {
    let folder = folder();
    let mut scene = TinyGltf::square();
    scene.add_base_color_texture(&png16(4, 4, |x, y| 9000 + 14000 * ((x + y) % 4) as u16));
    let uv1 = scene.add_accessor(&[0.2, 0.9, 0.8, 0.7, 0.1, 0.3, 0.9, 0.2], "VEC2");
    scene.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = json!(uv1);
    scene.json["materials"][0]["emissiveTexture"] = json!({"index": 0, "texCoord": 1});
    scene.json["materials"][0]["emissiveFactor"] = json!([0.5, 0.2, 0.1]);
    scene.json["materials"][0]["doubleSided"] = json!(true);
    let places = scene.add_accessor(&[-1.2, 0.0, -1.0, 0.3, 0.4, -2.5, 1.1, -0.6, -4.0], "VEC3");
    let up = scene.add_accessor([[0.0_f32, 0.3, 0.2]; 4].as_flattened(), "VEC3");
    scene.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": up}]);
    scene.add_bytes(&[0; 16]);
    let view = scene.list("bufferViews").len() - 1;
    scene.list("accessors").push(json!({"bufferView": view, "componentType": 5121, "type": "VEC4", "count": 4}));
    let joints = scene.list("accessors").len() - 1;
    let weights = scene.add_accessor([[1.0_f32, 0.0, 0.0, 0.0]; 4].as_flattened(), "VEC4");
    let mut skinned = scene.json["meshes"][0].clone();
    (skinned["primitives"][0]["attributes"]["JOINTS_0"], skinned["primitives"][0]["attributes"]["WEIGHTS_0"]) =
        (json!(joints), json!(weights));
    scene.list("meshes").push(skinned);
    scene.json["skins"] = json!([{"joints": [2]}]);
    let instanced = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places}}});
    scene.json["nodes"] = json!([{"mesh": 0, "weights": [1.0], "extensions": instanced},
        {"mesh": 1, "skin": 0, "translation": [9.0, 9.0, 9.0]},
        {"translation": [-0.5, -1.0, 0.0], "scale": [-1.0, 1.0, 1.0], "rotation": [0.0, 0.3, 0.0, 0.9]},
        {"camera": 0, "translation": [0.0, 0.0, 3.0]}]);
    scene.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.9, "znear": 0.1}}]);
    scene.json["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
    write(folder.path(), "posed.glb", &scene.glb());
    // The tracer reads textures without mipmaps, and so does a comparison with it.
    let compared = "compare posed.glb --size 64x48 --focus 3 --mean-coc 2 --methods accumulation --reference raytrace \
                    --samples 64 --set accumulation.samples=64 --runs 1 --no-cache --json -";
    let json = json_of(folder.path(), compared);
    let psnr = json["results"][0]["psnr_db"].as_f64().expect("a number");
    assert!(psnr > 40.0, "{psnr} dB");
}

/// A file is drawn as it is at the time that is asked for, and the notes say so.
#[test]
fn a_time_poses_the_scene() {
    let folder = folder();
    let mut scene = tiny_files::animated();
    scene.json["nodes"][1]["translation"] = json!([0.5, 0.5, 4.0]);
    scene.json["materials"][0]["doubleSided"] = json!(true);
    write(folder.path(), "animated.glb", &scene.glb());
    let covered = |options: &str| {
        let args = format!("render animated.glb --size 64x48 --method pinhole -o out.exr --json out.json {options}");
        stdout(folder.path(), &args);
        let text = std::fs::read_to_string(folder.path().join("out.json")).expect("written");
        let depth = defocus::image_io::read_scalars(&folder.path().join("out.exr"), Some("Z")).expect("a depth layer");
        let near = depth.values.pixels.iter().filter(|depth| depth.is_finite()).count();
        (near, text)
    };
    let (at_rest, rest_notes) = covered("");
    let (at_1_s, notes) = covered("--time 1 --animation Way");
    // At 1 s the square is twice as large, and nearer by 2 m.
    assert!(at_1_s > 2 * at_rest, "{at_rest} pixels at rest, {at_1_s} at 1 s");
    assert!(rest_notes.contains("rest pose") && notes.contains("at 1 s of its animation"), "{notes}");
}

#[test]
fn a_profile_says_where_the_time_goes() {
    let folder = folder();
    let args = "profile scene.glb --methods preblur,multiview --size 64x48 --coc 6 --while camera --runs 1 \
                --seconds 1 --quiet --json -";
    let json = json_of(folder.path(), args);
    assert_eq!(json["while"], "camera");
    let methods = json["methods"].as_array().expect("a list");
    let ids: Vec<_> = methods.iter().map(|m| m["method"].as_str().expect("an id")).collect();
    assert_eq!(ids, ["preblur", "multiview"]);
    for method in methods {
        let id = &method["method"];
        for key in ["gpu_ms", "copy_ratio", "back_to_back_ms", "record_ms"] {
            assert!(method[key].as_f64().is_some_and(|ms| ms > 0.0), "{id}: {key} is {}", method[key]);
        }
        for key in ["passes", "dispatches", "scene_draws", "triangles", "peak_bytes"] {
            assert!(method[key].as_u64().is_some_and(|count| count > 0), "{id}: {key} is {}", method[key]);
        }
        assert!(method["indirect_dispatches"].as_u64() <= method["dispatches"].as_u64(), "{method}");
        let passes = method["pass_times"].as_array().expect("a list");
        assert!(passes.iter().all(|pass| pass["label"].is_string() && pass["ms"].is_f64()), "{passes:?}");
        let ms: Vec<_> = passes.iter().filter_map(|pass| pass["ms"].as_f64()).collect();
        assert!(!ms.is_empty() && ms.is_sorted_by(|a, b| a >= b), "{id}: the most expensive first: {ms:?}");
    }
    assert_eq!(methods[1]["mean_coc_px"], 6.0);
    // Branches need no grid that the GPU decides.
    let json = json_of(folder.path(), &args.replace("--quiet", "--quiet --schedule branches"));
    assert_eq!(json["methods"][1]["indirect_dispatches"], 0);
    let failed = run(folder.path(), "profile scene.glb --schedule rows");
    let message = String::from_utf8_lossy(&failed.stderr).into_owned();
    assert!(!failed.status.success() && message.contains("lists, branches"), "{message}");
}

#[test]
fn a_camera_is_given_by_focal_length_f_number_and_field_of_view() {
    let folder = folder();
    let folder = folder.path();
    let json = json_of(folder, "render scene.glb --size 64x48 -F 50 --f-number 2 --fov 40 --focus 2 --json -");
    let lens = &json["lens"];
    let number = |key: &str| lens[key].as_f64().expect("a number");
    assert!((number("E") - 25.0).abs() < 1e-9, "E = F/N: {lens}");
    // 1/F = 1/df + 1/dr.
    assert!((number("dr") - 50.0 / (1.0 - 50.0 / 2000.0)).abs() < 1e-6, "{lens}");
    // At infinity the CoC is E / df of the image plane's distance, px.
    let focal_px = 24.0 / 20f64.to_radians().tan();
    assert!((number("K_px") - focal_px * 0.025 / 2.0).abs() < 1e-6, "{lens}");
    for wrong in ["--f-number 2", "-F 50 --f-number 0", "-F 50 --f-number 2 -E 10", "-F 50 --f-number 2 --focus 0.04"] {
        let output = run(folder, &format!("render scene.glb --size 64x48 {wrong} --json -"));
        assert!(!output.status.success(), "{wrong}");
    }
}

#[test]
fn methods_are_given_what_the_input_leaves_of_the_light() {
    let folder = folder();
    let folder = folder.path();
    let picture = |input: &str| {
        let args =
            format!("render rgbz.exr --method pinhole --input {input} --quiet -o {}.exr", input.replace(':', "-"));
        stdout(folder, &args);
        read_color(&folder.join(format!("{}.exr", input.replace(':', "-")))).expect("it was written")
    };
    let (all, cut) = (picture("hdr"), picture("clamped:0.25"));
    assert!(
        all.pixels
            .iter()
            .zip(&cut.pixels)
            .all(|(all, cut)| (all.min(glam::Vec3::splat(0.25)) - *cut).abs().max_element() < 1e-3)
    );
    assert!(cut.pixels.iter().any(|c| c.max_element() > 0.2) && all.pixels.iter().any(|c| c.max_element() > 0.3));
    let json = json_of(
        folder,
        "compare scene.glb --size 32x24 --samples 4 --methods splat --runs 1 --input reinhard:0.72 --json -",
    );
    assert!(json["notes"].to_string().contains("input: reinhard:0.72"), "{}", json["notes"]);
    let output = run(
        folder,
        "compare scene.glb --size 32x24 --samples 4 --methods splat --input reinhard --tonemap reinhard --json -",
    );
    assert!(!output.status.success(), "tones are mapped once");
}
