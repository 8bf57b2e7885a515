//! The tests that `script/test` leaves out without `--all` exist: a name that is misspelt or that was
//! changed would let a long test in again, and nobody would be told.

use std::collections::BTreeSet;
use std::path::Path;

/// The words in `text` between `before` and `after`.
fn between<'a>(text: &'a str, before: &'a str, after: char) -> impl Iterator<Item = &'a str> {
    text.split(before).skip(1).filter_map(move |rest| rest.split(after).next())
}

/// Names of all functions in the files of a folder and below.
fn collect_functions(folder: &Path, names: &mut BTreeSet<String>) {
    for path in std::fs::read_dir(folder).expect("a folder of tests").flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            collect_functions(&path, names);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = std::fs::read_to_string(&path).expect("a readable source");
            names.extend(between(&text, "fn ", '(').map(str::to_owned));
            // Those that a macro makes by name.
            names.extend(text.lines().filter_map(|line| line.trim().split_once(':')).map(|(name, _)| name.to_owned()));
        }
    }
}

#[test]
fn tests_that_are_left_out_exist() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (profiles, packages) = (root.join(".config/nextest.toml"), ["tests", "crates/study/tests", "crates/app/tests"]);
    // A published library comes without the profiles and the other packages.
    if !profiles.exists() {
        return;
    }
    let profiles = std::fs::read_to_string(profiles).expect("a readable file");
    let mut functions = BTreeSet::new();
    packages.iter().for_each(|package| collect_functions(&root.join(package), &mut functions));
    let named: Vec<&str> = between(&profiles, "test(=", ')').collect();
    assert!(named.len() > 50, "the profile names {} tests", named.len());
    let unknown: Vec<_> = named.iter().filter(|name| !functions.contains(name.rsplit("::").next().unwrap())).collect();
    assert!(unknown.is_empty(), "these tests are left out and do not exist: {unknown:#?}");
    for binary in between(&profiles, "binary(", ')') {
        let exists = packages.iter().any(|package| {
            let folder = root.join(package);
            folder.join(format!("{binary}.rs")).exists() || folder.join(binary).join("main.rs").exists()
        });
        assert!(exists, "there is no test file {binary}");
    }
}
