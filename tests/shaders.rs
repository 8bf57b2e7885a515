//! Every shader under `shaders/` parses, validates and resolves its imports, without a GPU.

use defocus::gpu::{Module, Precision};
use std::path::{Path, PathBuf};

fn shaders(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("shaders/ is part of the repository").flatten() {
        let path = entry.path();
        if path.is_dir() {
            shaders(&path, found);
        } else if path.extension().is_some_and(|e| e == "wgsl") {
            found.push(path);
        }
    }
}

#[test]
fn all_shaders_are_valid_in_both_precisions() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
    let mut found = Vec::new();
    shaders(&root, &mut found);
    assert!(found.len() >= 5, "only {found:?}");
    for path in found {
        let name = path.strip_prefix(&root).unwrap().with_extension("");
        let source = std::fs::read_to_string(&path).unwrap();
        for precision in [Precision::Half, Precision::Full] {
            let module = Module::parse(&name.to_string_lossy(), &source, precision).unwrap_or_else(|e| panic!("{e}"));
            let is_library = name.starts_with("lib");
            assert_eq!(
                module.entry_points().count() == 0,
                is_library,
                "{}: libraries have no entry points",
                name.display()
            );
        }
    }
}

#[test]
fn an_unknown_import_is_named() {
    let error = Module::parse("x", "#import nothing\n", Precision::Half).unwrap_err();
    assert!(error.message.contains("nothing") && error.message.contains("lens"), "{error}");
}

#[test]
fn a_broken_shader_names_the_line() {
    let error = Module::parse("x", "fn f() -> f32 {\n    return nothing;\n}\n", Precision::Half).unwrap_err();
    assert!(error.message.contains("wgsl:2"), "{error}");
}
