//! Makes the built-in scenes: `cargo run --example make_scenes [--check | --forest] [NAME..]`.
//!
//! Writes `assets/scenes/NAME.glb` for every name given (all without one); with `--check`
//! compares instead, and fails where a file is not what this program makes. `--forest`
//! writes `assets/images/forest.png` and its depth map instead.

mod generate;
mod picture;

use anyhow::{Context, Result, ensure};
use std::path::Path;

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets");
    if arguments.iter().any(|a| a == "--forest") {
        return picture::write(&assets.join("images"));
    }
    let check = arguments.iter().any(|a| a == "--check");
    let named: Vec<&str> = arguments.iter().map(String::as_str).filter(|&a| a != "--check").collect();
    let names = if named.is_empty() { generate::NAMES.to_vec() } else { named };
    let folder = assets.join("scenes");
    std::fs::create_dir_all(&folder).with_context(|| format!("creating {}", folder.display()))?;
    for name in names {
        let mut stage = generate::unlit(name)
            .with_context(|| format!("there is no scene {name:?}: choose from {}", generate::NAMES.join(", ")))?;
        generate::bake::bake(&mut stage);
        let file = generate::glb::write(&stage);
        let path = folder.join(format!("{name}.glb"));
        if check {
            let stored = std::fs::read(&path).with_context(|| format!("reading {}", path.display()))?;
            ensure!(stored == file, "{} differs from what this program makes: run it without --check", path.display());
        } else {
            std::fs::write(&path, &file).with_context(|| format!("writing {}", path.display()))?;
        }
        println!("{name}: {} triangles, {} kB", stage.triangles(), file.len() / 1000);
    }
    Ok(())
}
