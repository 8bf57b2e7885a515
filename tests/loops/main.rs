//! No loop of an embedded shader is endless: they run without the counters that naga puts
//! into every loop (`embedded_module` in `src/gpu/kernel.rs`), and an endless loop hangs a
//! GPU. Proved from naga's intermediate form of each shader, without a GPU.
//!
//! A loop counts as proved if it is left as soon as one of its conditions fails, and that
//! condition is one of
//!
//! - `i < n` or `i <= n` (or the mirror image), where `i` is an integer that changes in one place that every
//!   round passes, by a positive constant (or doubles, from a positive constant on), and `n`
//!   has a **bound**: it follows from constants, uniforms, sizes of textures and buffers and
//!   the invocation's place, by arithmetic; what is read from textures or buffers counts only
//!   cut by `min` or `clamp`;
//! - `bits != 0`, where every round clears the lowest bit: `bits &= bits - 1`.
//!
//! Uniforms and sizes are the program's own and far below the end of their types.

mod bound;
mod proof;

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

/// Loops of a shader, and what is wrong with those that are not proved.
fn unproved(name: &str, source: &str) -> (usize, Vec<String>) {
    let module = Module::parse(name, source, Precision::Half).unwrap_or_else(|e| panic!("{e}"));
    proof::unproved(module.naga().0, &module.source)
}

#[test]
fn every_loop_of_every_shader_ends() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
    let mut found = Vec::new();
    shaders(&root, &mut found);
    let (mut loops, mut endless) = (0, Vec::new());
    for path in found {
        let name = path.strip_prefix(&root).unwrap().with_extension("").to_string_lossy().into_owned();
        let (count, wrong) = unproved(&name, &std::fs::read_to_string(&path).unwrap());
        loops += count;
        endless.extend(wrong.into_iter().map(|w| format!("{name}: {w}")));
    }
    assert!(loops > 50, "only {loops} loops were found");
    assert!(endless.is_empty(), "{}", endless.join("\n"));
}

/// A compute shader with `body`, which may read uniform `n`, storage `data` and texture `t`.
fn shader_with(body: &str) -> String {
    format!(
        "@group(0) @binding(0) var<uniform> n: vec4u;\n\
         @group(0) @binding(1) var<storage, read_write> data: array<u32>;\n\
         @group(0) @binding(2) var t: texture_2d<f32>;\n\
         fn upto(last: u32) -> u32 {{ var s = 0u; for (var i = 0u; i < last; i++) {{ s += i; }} return s; }}\n\
         @compute @workgroup_size(1) fn main(@builtin(global_invocation_id) id: vec3u) {{ {body} }}"
    )
}

#[test]
fn good_loops_are_proved() {
    for body in [
        "for (var i = 0u; i < 4u; i++) { data[i] = 1u; }",
        "for (var i = id.x; i <= n.x; i += 8u) { data[i] = 1u; }",
        "for (var i = 0u; i < textureDimensions(t).x && data[0] > 0u; i++) { data[i] = 1u; }",
        "for (var i = 1u; i < n.y; i *= 2u) { data[i] = 1u; }",
        "let k = min(data[0], n.x); for (var i = 0u; i < k; i++) { if data[i] == 3u { continue; } data[i] = 1u; }",
        "var bits = data[0]; while bits != 0u { let b = firstTrailingBit(bits); bits &= bits - 1u; data[b] = 1u; }",
        "data[0] = upto(n.z);",
        "var k = n.x; if id.x > 3u { k = 7u; } for (var i = 0u; k > i; i++) { data[i] = 1u; }",
    ] {
        assert_eq!(unproved("good", &shader_with(body)).1, Vec::<String>::new(), "{body}");
    }
}

#[test]
fn loops_that_may_be_endless_are_found() {
    for body in [
        "loop { data[0] += 1u; }",
        "for (var x = 0.0; x < f32(n.x); x += 1.0) { data[0] += 1u; }",
        "while data[0] != 0u { data[1] += 1u; }",
        "for (var i = 0u; i < data[0]; i++) { data[i] = 1u; }",
        "for (var i = 0u; i < 8u; i += data[0]) { data[i] = 1u; }",
        "for (var i = 0u; i < 8u; i++) { if data[i] == 0u { i -= 1u; } }",
        "for (var i = 0u; i < 8u; i += 0u) { data[i] = 1u; }",
        "for (var i = 0u; i < u32(textureLoad(t, vec2u(0u), 0).r); i++) { data[i] = 1u; }",
        "for (var i = 0u; i < 8u || data[0] == 0u; i++) { data[i] = 1u; }",
        "for (var i = 0u; i < 8u; i *= 2u) { data[i] = 1u; }",
        "var bits = data[0]; while bits != 0u { if data[1] == 0u { continue; } bits &= bits - 1u; }",
        "data[0] = upto(data[1]);",
        "var k = n.x; if id.x > 3u { k = data[7]; } for (var i = 0u; i < k; i++) { data[i] = 1u; }",
        "var i = 0u; while i < 8u { if data[i] > 0u { i += 1u; } }",
    ] {
        assert_eq!(unproved("bad", &shader_with(body)).1.len(), 1, "{body}");
    }
}
