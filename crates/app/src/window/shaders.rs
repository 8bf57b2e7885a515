//! Shaders read again when they are saved, while the program runs from its source tree: a
//! broken one is told, and the last good one goes on.

use super::App;
use super::watch::Watched;
use defocus::gpu::{Gpu, Module, Precision, ShaderError};
use eframe::egui::Context;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Where the shaders lay when the program was built.
const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shaders");

/// The watch over the shaders, while there is one.
pub struct Reload {
    folder: PathBuf,
    watched: Watched,
    /// The shaders as the running program knows them.
    known: HashMap<String, Module>,
    active: bool,
}

impl Reload {
    /// Of the shaders in `folder`; those of the source tree without it. Not active.
    pub fn of(folder: Option<PathBuf>) -> Self {
        let folder = folder.unwrap_or_else(|| FOLDER.into());
        Self { folder, watched: Watched::default(), known: HashMap::new(), active: false }
    }

    /// Starts or stops watching; an error in words if there is nothing to watch.
    pub fn set_active(&mut self, active: bool, ctx: &Context) -> Result<(), String> {
        if active == self.active {
            return Ok(());
        }
        self.active = active;
        self.watched.stop();
        if !active {
            return Ok(());
        }
        let folder = &self.folder;
        let mut files = Vec::new();
        collect(folder, &mut files);
        if files.is_empty() {
            return Err(format!("there are no shaders in {}: run the program from its source tree", folder.display()));
        }
        self.known.clear();
        for file in &files {
            let name = name_of(folder, file);
            if let Ok(module) = std::fs::read_to_string(file).map_err(drop).and_then(|s| parse(&name, &s).map_err(drop))
            {
                self.known.insert(name, module);
            }
        }
        self.watched.watch(files, ctx);
        Ok(())
    }

    /// Replaces what was saved since the last call: names of the replaced shaders, and
    /// why others were not.
    pub fn replace_saved(&mut self, gpu: &Gpu) -> Vec<Result<(String, String), String>> {
        let saved = self.watched.take();
        saved.iter().map(|file| self.replace(gpu, &name_of(&self.folder, file), file)).collect()
    }

    /// Replaces one shader by what a file holds.
    fn replace(&mut self, gpu: &Gpu, name: &str, file: &Path) -> Result<(String, String), String> {
        if name.starts_with("lib/") {
            return Err(format!("{name} is part of several shaders: save those that import it after a new build"));
        }
        let source = std::fs::read_to_string(file).map_err(|e| format!("{}: {e}", file.display()))?;
        let module = parse(name, &source).map_err(|e| e.to_string())?;
        if let Some(known) = self.known.get(name) {
            module.check_stands_in_for(known).map_err(|e| e.to_string())?;
        }
        gpu.replace_shader(name, &source).map_err(|e| e.to_string())?;
        Ok((name.to_owned(), source))
    }
}

fn parse(name: &str, source: &str) -> Result<Module, ShaderError> {
    Module::parse(name, source, Precision::Half)
}

/// As [`defocus::gpu::Shader::name`].
fn name_of(folder: &Path, file: &Path) -> String {
    let path = file.strip_prefix(folder).unwrap_or(file).with_extension("");
    path.components().map(|c| c.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|e| e == "wgsl") {
            files.push(path);
        }
    }
}

impl App {
    /// Follows the preference, and shows what saved shaders make of the pictures.
    pub(super) fn reload_shaders(&mut self, ctx: &Context) {
        if let Err(error) = self.reload.set_active(self.preferences.reload_shaders, ctx) {
            self.preferences.reload_shaders = false;
            self.messages.error(ctx, &error);
        }
        for outcome in self.reload.replace_saved(self.engine.gpu()) {
            match outcome {
                Ok((name, source)) => {
                    self.engine.take_shader(&name, &source);
                    if let Some(right) = self.eyes.right() {
                        right.take_shader(&name, &source);
                    }
                    self.messages.note(ctx, &format!("Shader {name} was read again."));
                }
                Err(error) => self.messages.error(ctx, &error),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "@group(0) @binding(0) var<storage, read_write> sums: array<u32>;
        @compute @workgroup_size(1) fn add() { sums[0] = 1u; }";

    #[test]
    fn a_shader_may_change_inside_but_not_in_what_it_binds() {
        let known = parse("x", GOOD).expect("the shader is valid");
        let inside = parse("x", &GOOD.replace("1u;", "2u;")).expect("the shader is valid");
        assert!(inside.check_stands_in_for(&known).is_ok());
        let renamed = parse("x", &GOOD.replace("sums", "totals")).expect("the shader is valid");
        assert!(renamed.check_stands_in_for(&known).unwrap_err().message.contains("build it again"));
        let gone = parse("x", &GOOD.replace("add", "sum")).expect("the shader is valid");
        assert!(gone.check_stands_in_for(&known).unwrap_err().message.contains("entry point add"));
    }

    #[test]
    fn names_are_those_of_the_embedded_shaders() {
        let folder = Path::new(FOLDER);
        assert_eq!(name_of(folder, &folder.join("methods/mipmap.wgsl")), "methods/mipmap");
    }
}
