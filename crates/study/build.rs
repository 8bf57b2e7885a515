//! Deflates the built-in scenes, and names the code that references are drawn by, so that those on disk outlive changes of
//! everything else. `DEFOCUS_REFERENCE_CODE` in the environment of the build overrides the
//! name: who knows that a change draws the same keeps hours of references.

use std::path::{Path, PathBuf};
use xxhash_rust::xxh3::Xxh3Default;

/// What no reference depends on in the library: the methods that are measured. All else
/// there counts, new files too.
const WITHOUT: [&str; 2] = ["src/methods", "shaders/methods"];

/// The exceptions: the methods that make references, and what of this package does.
const WITH: [&str; 6] = [
    "crates/study/src/builtin.rs",
    "crates/study/src/reference.rs",
    "crates/study/src/source.rs",
    "src/methods/accumulation.rs",
    "src/methods/pinhole.rs",
    "shaders/methods/accumulation.wgsl",
];

/// Compression level: the one that `gzip -9` has.
const DEFLATE_LEVEL: u8 = 9;

fn main() {
    // Paths are those of the workspace.
    std::env::set_current_dir("../..").expect("the package lies in crates/study of the workspace");
    deflate_scenes();
    name_reference_code();
}

/// Puts `NAME.glb.deflated` of each of `assets/scenes` into the build's folder.
fn deflate_scenes() {
    let folder = Path::new("assets/scenes");
    let out = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo names it"));
    for entry in std::fs::read_dir(folder).expect("the built-in scenes").flatten() {
        let content = std::fs::read(entry.path()).unwrap_or_else(|e| panic!("{}: {e}", entry.path().display()));
        let deflated = miniz_oxide::deflate::compress_to_vec(&content, DEFLATE_LEVEL);
        let file = out.join(format!("{}.deflated", entry.file_name().to_string_lossy()));
        std::fs::write(&file, deflated).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    }
    println!("cargo::rerun-if-changed=../../assets/scenes");
}

fn name_reference_code() {
    let mut files = vec![PathBuf::from("Cargo.lock")];
    files.extend(WITH.map(PathBuf::from));
    for folder in ["src", "shaders"] {
        collect(Path::new(folder), &mut files);
    }
    files.sort();
    let mut state = Xxh3Default::new();
    for file in &files {
        let content = std::fs::read(file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        // Lengths come first, so that one file cannot run into the next.
        for part in [file.to_string_lossy().as_bytes(), &content] {
            state.update(&(part.len() as u64).to_le_bytes());
            state.update(part);
        }
    }
    let given = std::env::var("DEFOCUS_REFERENCE_CODE").ok();
    let code = given.unwrap_or_else(|| format!("{:016x}", state.digest()));
    println!("cargo::rustc-env=DEFOCUS_REFERENCE_CODE={code}");
    println!("cargo::rerun-if-env-changed=DEFOCUS_REFERENCE_CODE");
    for watched in ["Cargo.lock", "src", "shaders"].iter().chain(&WITH) {
        println!("cargo::rerun-if-changed=../../{watched}");
    }
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    for path in entries.flatten().map(|entry| entry.path()) {
        if WITHOUT.iter().any(|without| path == Path::new(without)) {
            continue;
        }
        if path.is_dir() { collect(&path, files) } else { files.push(path) }
    }
}
