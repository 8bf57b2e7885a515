//! No file imports another that imports it, directly or through others, in any package.
//!
//! An import is a path in a `use`, and a path elsewhere that begins with `crate`, `super` or
//! `self`. A name that a module only passes on (`pub use`) belongs to the file that defines it.
//! Not counted are unit tests, which look at their own file, and `child::Name` in the code of a
//! parent: lists of all methods or commands, and the struct that the files of a module share.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Files that still stand in a circle. Entries go when a circle is cut; none is added.
const KNOWN: &[&str] = &[
    "src/methods/adaptive/highlights.rs",
    "src/methods/adaptive/mod.rs",
    "src/methods/adaptive/passes.rs",
    "src/methods/adaptive/tiles.rs",
    "src/methods/adaptive/views.rs",
];

/// Path of a module from the root of its crate; the root's is empty.
type Module = Vec<String>;

struct Source {
    file: PathBuf,
    tokens: Vec<String>,
}

/// Modules of a crate, and the names that each passes on with the paths they stand for.
struct Crate {
    sources: BTreeMap<Module, Source>,
    passed_on: BTreeMap<(Module, String), Module>,
}

#[test]
fn no_package_has_an_import_circle() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    // A published library comes without the other two.
    let packages = ["", "crates/study", "crates/app"].map(|package| root.join(package).join("src"));
    let found: BTreeSet<String> = packages
        .iter()
        .filter(|folder| folder.is_dir())
        .flat_map(|folder| circles(&read_crate(folder)))
        .flatten()
        .map(|file| file.strip_prefix(root).unwrap_or(&file).to_string_lossy().replace('\\', "/"))
        .collect();
    let known: BTreeSet<String> = KNOWN.iter().map(|file| (*file).to_owned()).collect();
    let new: Vec<_> = found.difference(&known).collect();
    assert!(new.is_empty(), "these files import each other in a circle:\n{new:#?}");
    let gone: Vec<_> = known.difference(&found).filter(|file| root.join(file).exists()).collect();
    assert!(gone.is_empty(), "these files stand in no circle any more; take them out of KNOWN:\n{gone:#?}");
}

#[test]
fn circles_are_found_and_only_those() {
    let circles_of = |files: &[(&str, &str)]| {
        let sources = files.iter().map(|(module, text)| {
            let module: Module = module.split("::").filter(|name| !name.is_empty()).map(str::to_owned).collect();
            let file = PathBuf::from(module.join("/"));
            (module, Source { file, tokens: tokens(text) })
        });
        circles(&with_names(sources.collect())).len()
    };
    let root = ("", "mod a; mod b; mod c;");
    assert_eq!(circles_of(&[root, ("a", "use crate::b::B;"), ("b", "struct B;"), ("c", "use super::{a, b::B};")]), 0);
    assert_eq!(circles_of(&[root, ("a", "use crate::b::B;"), ("b", "fn f() { super::a::g() }"), ("c", "")]), 1);
    assert_eq!(
        circles_of(&[root, ("a", "use crate::{b::{self}};"), ("b", "use super::c::*;"), ("c", "use super::a;")]),
        1
    );
    // What is passed on belongs to the file that defines it.
    let facade = ("a", "mod x; mod y; pub use x::X; pub use y::Y as Z;");
    assert_eq!(circles_of(&[("", "mod a;"), facade, ("a::x", "struct X;"), ("a::y", "use super::X;")]), 0);
    assert_eq!(circles_of(&[("", "mod a;"), facade, ("a::x", "use super::Z;"), ("a::y", "use super::X;")]), 1);
    // A parent that uses its child, which uses what the parent defines.
    let parent = ("a", "mod x; use x::X; struct A;");
    assert_eq!(circles_of(&[("", "mod a;"), parent, ("a::x", "use super::A;")]), 1);
    // Neither comments, texts nor unit tests import anything.
    let quiet = "/* use super::a::A; */ // super::a::A\n fn f() { \"crate::a::A\"; } #[cfg(test)] mod tests { use crate::a::A; }";
    assert_eq!(circles_of(&[root, ("a", "use crate::b::B;"), ("b", quiet), ("c", "")]), 0);
}

fn read_crate(folder: &Path) -> Crate {
    let mut sources = BTreeMap::new();
    read_folder(folder, &mut Vec::new(), &mut sources);
    with_names(sources)
}

fn read_folder(folder: &Path, module: &mut Module, sources: &mut BTreeMap<Module, Source>) {
    for entry in std::fs::read_dir(folder).expect("a folder of sources") {
        let path = entry.expect("an entry of it").path();
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() {
            module.push(stem);
            read_folder(&path, module, sources);
            module.pop();
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let mut own = module.clone();
            // A program beside a library is a second root; both share the modules' names.
            match stem.as_str() {
                "mod" | "lib" => {}
                "main" if folder.join("lib.rs").exists() => own.push("main".into()),
                "main" => {}
                _ => own.push(stem),
            }
            let text = std::fs::read_to_string(&path).expect("a readable source");
            sources.insert(own, Source { file: path, tokens: tokens(&text) });
        }
    }
}

/// The words and marks of a source without comments, texts and the unit tests at its end; `::`
/// is one mark.
fn tokens(text: &str) -> Vec<String> {
    let text =
        text.find("#[cfg(test)]\nmod ").or_else(|| text.find("#[cfg(test)] mod ")).map_or(text, |end| &text[..end]);
    let chars: Vec<char> = text.chars().collect();
    let at = |i: usize| chars.get(i).copied().unwrap_or('\0');
    let (mut tokens, mut i) = (Vec::new(), 0);
    while i < chars.len() {
        let c = chars[i];
        if c == '/' && at(i + 1) == '/' {
            while i < chars.len() && chars[i] != '\n' {
                i += 1;
            }
        } else if c == '/' && at(i + 1) == '*' {
            i += 2;
            while i < chars.len() && !(chars[i] == '*' && at(i + 1) == '/') {
                i += 1;
            }
            i += 2;
        } else if c == '"' {
            i += 1;
            while i < chars.len() && chars[i] != '"' {
                i += if chars[i] == '\\' { 2 } else { 1 };
            }
            i += 1;
        } else if c == '\'' && (at(i + 2) == '\'' || at(i + 1) == '\\') {
            i += if at(i + 1) == '\\' { 3 } else { 2 };
            while i < chars.len() && chars[i] != '\'' {
                i += 1;
            }
            i += 1;
        } else if c == 'r' && at(i + 1) == '"' {
            i += 2;
            while i < chars.len() && chars[i] != '"' {
                i += 1;
            }
            i += 1;
        } else if c == 'r' && at(i + 1) == '#' && at(i + 2) == '"' {
            i += 3;
            while i < chars.len() && !(chars[i] == '"' && at(i + 1) == '#') {
                i += 1;
            }
            i += 2;
        } else if c.is_alphanumeric() || c == '_' {
            let start = i;
            while at(i).is_alphanumeric() || at(i) == '_' {
                i += 1;
            }
            tokens.push(chars[start..i].iter().collect());
        } else if c == ':' && at(i + 1) == ':' {
            tokens.push("::".into());
            i += 2;
        } else {
            if !c.is_whitespace() {
                tokens.push(c.into());
            }
            i += 1;
        }
    }
    tokens
}

/// The paths of a `use` from its first word on, each with the name it brings; returns the
/// place after it.
fn use_tree(tokens: &[String], mut i: usize, prefix: &[String], paths: &mut Vec<(Module, String)>) -> usize {
    let mut path = prefix.to_vec();
    while let Some(token) = tokens.get(i).map(String::as_str) {
        match token {
            "::" => i += 1,
            "{" => {
                i += 1;
                while tokens.get(i).is_some_and(|token| token != "}" && token != ";") {
                    i = use_tree(tokens, i, &path, paths);
                    if tokens.get(i).is_some_and(|token| token == ",") {
                        i += 1;
                    }
                }
                return i + 1;
            }
            "," | ";" | "}" => break,
            "as" => {
                paths.push((path, tokens.get(i + 1).cloned().unwrap_or_default()));
                return i + 2;
            }
            "self" if !path.is_empty() => i += 1,
            word => {
                path.push(word.to_owned());
                i += 1;
            }
        }
    }
    let name = path.last().cloned().unwrap_or_default();
    paths.push((path, name));
    i
}

/// Paths that a source names, each with the name it passes on, if it does.
fn paths(tokens: &[String]) -> Vec<(Module, Option<String>)> {
    let (mut found, mut i) = (Vec::new(), 0);
    while i < tokens.len() {
        let before = if i > 0 { tokens[i - 1].as_str() } else { "" };
        match tokens[i].as_str() {
            "use" => {
                let passes_on = before == "pub" || before == ")";
                let mut paths = Vec::new();
                i = use_tree(tokens, i + 1, &[], &mut paths);
                found.extend(paths.into_iter().map(|(path, name)| (path, passes_on.then_some(name))));
            }
            // Not those of a visibility: `pub(super)`, `pub(in crate::window)`.
            "crate" | "super" | "self" if before != "in" && tokens.get(i + 1).is_some_and(|next| next == "::") => {
                let mut path = vec![tokens[i].clone()];
                i += 1;
                while tokens.get(i).is_some_and(|mark| mark == "::") && i + 1 < tokens.len() {
                    path.push(tokens[i + 1].clone());
                    i += 2;
                }
                found.push((path, None));
            }
            _ => i += 1,
        }
    }
    found
}

/// A path as one from the root of the crate; `None` for those of other crates.
fn absolute(sources: &BTreeMap<Module, Source>, from: &Module, path: &[String]) -> Option<Module> {
    let mut base = from.clone();
    let mut rest = path;
    match path.first()?.as_str() {
        "crate" => {
            base.clear();
            rest = &path[1..];
        }
        "self" => rest = &path[1..],
        "super" => {
            while rest.first().is_some_and(|word| word == "super") {
                base.pop();
                rest = &rest[1..];
            }
        }
        child => {
            base.push(child.to_owned());
            return sources.contains_key(&base).then(|| [from.as_slice(), path].concat());
        }
    }
    Some([base.as_slice(), rest].concat())
}

fn with_names(sources: BTreeMap<Module, Source>) -> Crate {
    let mut passed_on = BTreeMap::new();
    for (module, source) in &sources {
        for (path, name) in paths(&source.tokens) {
            if let (Some(name), Some(path)) = (name, absolute(&sources, module, &path)) {
                passed_on.insert((module.clone(), name), path);
            }
        }
    }
    Crate { sources, passed_on }
}

impl Crate {
    /// The module that a path leads to: the one that defines the name behind it.
    fn defining(&self, path: &[String], depth: u32) -> Option<Module> {
        let mut module = Module::new();
        for (place, name) in path.iter().enumerate() {
            let child = [module.as_slice(), std::slice::from_ref(name)].concat();
            if self.sources.contains_key(&child) {
                module = child;
                continue;
            }
            let passed_on = self.passed_on.get(&(module.clone(), name.clone()));
            return match passed_on.filter(|_| depth < 8) {
                Some(target) => self.defining(&[target.as_slice(), &path[place + 1..]].concat(), depth + 1),
                None => Some(module),
            };
        }
        Some(module)
    }
}

/// Groups of files that all reach each other by their imports.
fn circles(all: &Crate) -> Vec<Vec<PathBuf>> {
    let modules: Vec<&Module> = all.sources.keys().collect();
    let place = |module: &Module| modules.iter().position(|other| *other == module);
    let mut reaches = vec![vec![false; modules.len()]; modules.len()];
    for (from, (module, source)) in all.sources.iter().enumerate() {
        for (path, passed_on) in paths(&source.tokens) {
            let target = absolute(&all.sources, module, &path).and_then(|path| all.defining(&path, 0));
            // A module named alone is no import of what stands in it.
            if let Some(to) = target.as_ref().and_then(place).filter(|to| *to != from && passed_on.is_none()) {
                reaches[from][to] = true;
            }
        }
    }
    for through in 0..modules.len() {
        for from in 0..modules.len() {
            if reaches[from][through] {
                let further = reaches[through].clone();
                reaches[from].iter_mut().zip(further).for_each(|(reached, also)| *reached |= also);
            }
        }
    }
    let mut found: Vec<Vec<PathBuf>> = Vec::new();
    let mut seen = BTreeSet::new();
    for (from, reached) in reaches.iter().enumerate() {
        if reached[from] && seen.insert(from) {
            let group: Vec<usize> =
                (0..modules.len()).filter(|to| *to == from || (reached[*to] && reaches[*to][from])).collect();
            seen.extend(&group);
            found.push(group.iter().map(|at| all.sources[modules[*at]].file.clone()).collect());
        }
    }
    found
}
