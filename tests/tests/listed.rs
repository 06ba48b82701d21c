//! A file in a folder of tests that is no module of its `main.rs` would be compiled by nobody.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use cosmic_tests::{entries, workspace};

/// The folders of tests that are one binary, and how many there are at least.
fn folders() -> Vec<PathBuf> {
    let root = workspace();
    let packages = ["autodiff", "cosmic", "tests"].map(|package| root.join(package));
    let inner = entries(&root.join("cosmic"));
    let tests = (packages.into_iter().chain(inner)).map(|package| package.join("tests"));
    tests
        .filter(|tests| tests.join("main.rs").is_file())
        .collect()
}

/// The modules that lie in a folder, and those of them that its `main.rs` or the manifest names.
fn modules(tests: &Path) -> (BTreeSet<String>, BTreeSet<String>) {
    let read = |path: PathBuf| fs::read_to_string(path).expect("a source file can be read");
    let (main, manifest) = (
        read(tests.join("main.rs")),
        read(tests.join("../Cargo.toml")),
    );
    let there: BTreeSet<String> = entries(tests)
        .into_iter()
        .filter(|path| path.extension().is_some_and(|e| e == "rs") || path.join("mod.rs").is_file())
        .map(|path| {
            path.file_stem()
                .expect("a name")
                .to_string_lossy()
                .into_owned()
        })
        .filter(|name| name != "main")
        .collect();
    let is_named = |name: &&String| {
        main.lines().any(|line| line == format!("mod {name};"))
            || manifest.contains(&format!("[[test]]\nname = \"{name}\""))
    };
    let named = there.iter().filter(is_named).cloned().collect();
    (there, named)
}

#[test]
fn every_file_of_tests_is_compiled() {
    let folders = folders();
    assert!(folders.len() >= 2, "{folders:?}");
    for tests in folders {
        let (there, named) = modules(&tests);
        assert!(!there.is_empty(), "no test in {}", tests.display());
        let missing: Vec<&String> = there.difference(&named).collect();
        assert!(
            missing.is_empty(),
            "{}/main.rs: no `mod` for {missing:?}",
            tests.display()
        );
    }
}
