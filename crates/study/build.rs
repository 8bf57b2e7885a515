//! Names the code that references are drawn by, so that those on disk outlive changes of
//! everything else. `DEFOCUS_REFERENCE_CODE` in the environment of the build overrides the
//! name: who knows that a change draws the same keeps hours of references.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

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

fn main() {
    // Paths are those of the workspace.
    std::env::set_current_dir("../..").expect("the package lies in crates/study of the workspace");
    let mut files = vec![PathBuf::from("Cargo.lock")];
    files.extend(WITH.map(PathBuf::from));
    for folder in ["src", "shaders"] {
        collect(Path::new(folder), &mut files);
    }
    files.sort();
    let mut state = DefaultHasher::new();
    for file in &files {
        let content = std::fs::read(file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        (file, content).hash(&mut state);
    }
    let given = std::env::var("DEFOCUS_REFERENCE_CODE").ok();
    let code = given.unwrap_or_else(|| format!("{:016x}", state.finish()));
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
