//! The order of `pub mod` in `cosmic/src/lib.rs` is the architecture: no module imports one below.

use std::fs;
use std::path::{Path, PathBuf};

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../cosmic/src")
}

/// The modules from top to bottom.
fn floors() -> Vec<String> {
    let text = fs::read_to_string(source().join("lib.rs")).expect("the crate has a root");
    let name = |line: &str| Some(line.strip_prefix("pub mod ")?.strip_suffix(';')?.to_owned());
    text.lines().filter_map(name).collect()
}

/// Every source file of a module.
fn files(module: &str) -> Vec<PathBuf> {
    let mut found = vec![source().join(format!("{module}.rs"))];
    let mut folders = vec![source().join(module)];
    while let Some(folder) = folders.pop() {
        let Ok(entries) = fs::read_dir(&folder) else {
            continue;
        };
        for path in entries.map(|entry| entry.expect("a folder can be listed").path()) {
            if path.is_dir() {
                folders.push(path);
            } else {
                found.push(path);
            }
        }
    }
    found.retain(|path| path.is_file());
    found
}

/// The modules that a line names by `crate::module`, in an import or anywhere else.
fn named(line: &str) -> impl Iterator<Item = &str> {
    let code = line.split("//").next().unwrap_or_default();
    code.split("crate::").skip(1).map(|rest| {
        let end = rest.find(|c: char| c != '_' && !c.is_alphanumeric());
        &rest[..end.unwrap_or(rest.len())]
    })
}

/// Imports of modules further down, as `file: line`.
fn upward(floors: &[String]) -> Vec<String> {
    let mut wrong = Vec::new();
    for (floor, module) in floors.iter().enumerate() {
        for path in files(module) {
            let text = fs::read_to_string(&path).expect("a source file can be read");
            let below = |name: &str| floors[floor + 1..].iter().any(|module| module == name);
            let lines = text.lines().filter(|line| named(line).any(below));
            wrong.extend(lines.map(|line| format!("{}: {}", path.display(), line.trim())));
        }
    }
    wrong
}

#[test]
fn every_module_imports_only_modules_above_it() {
    let floors = floors();
    assert!(
        floors.len() > 5,
        "lib.rs lists its modules as `pub mod name;`: {floors:?}"
    );
    assert!(floors.iter().all(|module| !files(module).is_empty()));
    assert_eq!(upward(&floors), Vec::<String>::new());
}

/// The same list upside down must fail, or the test above sees nothing.
#[test]
fn the_test_sees_upward_imports() {
    let mut floors = floors();
    floors.reverse();
    assert!(!upward(&floors).is_empty());
}

/// `use crate::{a, b}` would hide the second module from the lines above.
#[test]
fn imports_name_one_module_each() {
    for module in floors() {
        for path in files(&module) {
            let text = fs::read_to_string(&path).expect("a source file can be read");
            assert!(
                !text.contains("crate::{"),
                "{}: one `use crate::` a module",
                path.display()
            );
        }
    }
}

/// Lines of the crate's code that hold any of the words, as `file: line`.
fn lines_with(words: &[&str]) -> Vec<String> {
    let code = |text: &str| {
        text.split("#[cfg(test)]")
            .next()
            .unwrap_or_default()
            .to_owned()
    };
    let in_file = |path: PathBuf| {
        let text = code(&fs::read_to_string(&path).expect("a source file can be read"));
        let holds = |line: &&str| words.iter().any(|word| line.contains(word));
        let named = |line: &str| format!("{}: {}", path.display(), line.trim());
        text.lines().filter(holds).map(named).collect::<Vec<_>>()
    };
    floors()
        .iter()
        .flat_map(|module| files(module))
        .flat_map(in_file)
        .collect()
}

/// Derivatives come from the engine: the crate states one straight-through and no other rule, and
/// the only adjoints of kernels are those emitted from recordings.
#[test]
fn nothing_is_differentiated_by_hand() {
    let rules = lines_with(&[
        "Fused for",
        "Rule for",
        "custom::apply",
        ".straight_through(",
    ]);
    assert!(
        matches!(&rules[..], [one] if one.contains("projection.rs") && one.contains("soft")),
        "{rules:#?}"
    );
    let adjoints = lines_with(&["fn vjp"]);
    assert!(!adjoints.is_empty(), "the kernels have adjoints");
    assert!(
        adjoints.iter().all(|line| line.contains("adjoints.rs")),
        "{adjoints:#?}"
    );
}
