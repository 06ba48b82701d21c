//! Checks of the architecture of the crates. A module imports only modules that are above it in `lib.rs`. Files and
//! folders that are side by side do not import one another in a circle. No derivative is written by hand.
//!
//! The checks read paths as they are written; they do not follow re-exports.

mod by_hand;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use cosmic_tests::{files_below, workspace};

/// The source folders of all crates whose architecture is tested.
const SOURCES: [&str; 11] = [
    "autodiff/src",
    "autodiff/programs/src",
    "cosmic/optimiser/src",
    "cosmic/src",
    "cosmic/lab/src",
    "cosmic/program/src",
    "benches/src",
    "tests/src",
    "gpu/src",
    "python/src",
    "web/src",
];

/// The folders of tests. The files of each folder form one binary.
const TESTS: [&str; 8] = [
    "autodiff/tests",
    "autodiff/programs/tests",
    "cosmic/optimiser/tests",
    "cosmic/tests",
    "cosmic/lab/tests",
    "cosmic/program/tests",
    "tests/tests",
    "gpu/tests",
];

/// The code of a file without comments and without the tests at its end.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    let code = text.split("#[cfg(test)]\nmod tests").next();
    let line = |line: &str| line.split("//").next().unwrap_or_default().to_owned() + "\n";
    code.unwrap_or_default().lines().map(line).collect()
}

fn sources(source: &str) -> Vec<PathBuf> {
    files_below(&workspace().join(source), &["rs"])
}

/// The modules that a crate's `lib.rs` declares, from top to bottom.
fn floors(source: &str) -> Vec<String> {
    let declared = |line: &str| {
        let name = line.trim_start_matches("pub ").strip_prefix("mod ")?;
        Some(name.strip_suffix(';')?.to_owned())
    };
    let code = code(&workspace().join(source).join("lib.rs"));
    code.lines().filter_map(declared).collect()
}

/// The names that follow `root`, such as `crate::`, in the paths of a text: `crate::{a, b::{c, d}}` gives `a` and `b`.
fn names_after(root: &str, code: &str) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    // `super::super::` is another place than `super::`.
    let is_whole = |(at, _): &(usize, &str)| !code[..*at].ends_with("super::");
    for (at, _) in code.match_indices(root).filter(is_whole) {
        let rest = &code[at + root.len()..];
        let Some(group) = rest.strip_prefix('{') else {
            names.extend(first_word(rest));
            continue;
        };
        let (mut depth, mut begin) = (0, 0);
        for (end, c) in group.char_indices() {
            match c {
                '{' => depth += 1,
                '}' if depth > 0 => depth -= 1,
                '}' | ',' if depth == 0 => {
                    names.extend(first_word(group[begin..end].trim()));
                    begin = end + 1;
                }
                _ => {}
            }
            if c == '}' && begin == end + 1 {
                break;
            }
        }
    }
    names
}

fn first_word(path: &str) -> Option<String> {
    let word = path
        .split(|c: char| !c.is_alphanumeric() && c != '_')
        .next()?;
    (!word.is_empty()).then(|| word.to_owned())
}

/// The imports of modules that are further down in a list of modules, each as a text `file: module`.
fn upward(source: &str, floors: &[String]) -> Vec<String> {
    let root = workspace().join(source);
    let floor = |name: &str| floors.iter().position(|floor| floor == name);
    let mut wrong = Vec::new();
    for path in sources(source) {
        let inside = path.strip_prefix(&root).unwrap().with_extension("");
        let first = inside.iter().next().unwrap().to_string_lossy();
        let Some(here) = floor(&first) else { continue };
        let names = names_after("crate::", &code(&path));
        let higher = |name: &&String| floor(name).is_some_and(|there| there > here);
        let named = |name: &String| format!("{}: {name}", inside.display());
        wrong.extend(names.iter().filter(higher).map(named));
    }
    wrong
}

/// For each file and folder in `folder`, which is inside the folder `source` of a crate, the files and folders beside it that
/// it imports.
fn imports(source: &Path, folder: &Path) -> BTreeMap<String, BTreeSet<String>> {
    let module = folder.strip_prefix(source).unwrap();
    let module = module.iter().map(|part| part.to_string_lossy() + "::");
    let here = format!("crate::{}", module.collect::<String>());
    let mut all = BTreeMap::<_, BTreeSet<String>>::new();
    for path in files_below(folder, &["rs"]) {
        let inside: Vec<_> = path.strip_prefix(folder).unwrap().iter().collect();
        let name = Path::new(inside[0]).file_stem().unwrap().to_string_lossy();
        if inside.len() == 1 && ["mod", "lib", "main"].contains(&&*name) {
            continue;
        }
        let above = "super::".repeat(inside.len() - usize::from(path.ends_with("mod.rs")));
        let code = code(&path);
        let used = [&above, &here].map(|root| names_after(root, &code));
        let of_name = all.entry(name.into_owned()).or_default();
        of_name.extend(used.into_iter().flatten());
    }
    let names: BTreeSet<String> = all.keys().cloned().collect();
    for (name, used) in &mut all {
        used.retain(|other| other != name && names.contains(other));
    }
    all
}

/// The files and folders that are part of a circle of imports, or of a chain from one circle to another.
fn circles(mut imports: BTreeMap<String, BTreeSet<String>>) -> Vec<String> {
    // A file that imports no file, or that no file imports, is not in a circle. Remove such files until none is left.
    loop {
        let before = imports.len();
        let left: BTreeSet<_> = imports.keys().cloned().collect();
        imports.retain(|_, used| {
            used.retain(|file| left.contains(file));
            !used.is_empty()
        });
        let used: BTreeSet<_> = imports.values().flatten().cloned().collect();
        imports.retain(|file, _| used.contains(file));
        if imports.len() == before {
            return imports.into_keys().collect();
        }
    }
}

#[test]
fn every_module_imports_only_modules_above_it() {
    for source in SOURCES {
        assert_eq!(upward(source, &floors(source)), Vec::<String>::new());
    }
    // The check itself: with the modules in reversed order, it must find imports.
    for source in [
        "autodiff/src",
        "autodiff/programs/src",
        "cosmic/src",
        "cosmic/lab/src",
        "gpu/src",
        "python/src",
        "web/src",
    ] {
        let mut floors = floors(source);
        assert!(floors.len() > 2, "{source}: {floors:?}");
        floors.reverse();
        assert!(!upward(source, &floors).is_empty());
    }
}

#[test]
fn nothing_in_a_folder_imports_one_another_in_a_circle() {
    let mut links = 0;
    for source in SOURCES.map(|source| workspace().join(source)) {
        let files = files_below(&source, &["rs"]);
        let folders = files.iter().flat_map(|file| file.ancestors().skip(1));
        let folders: BTreeSet<_> = folders.filter(|at| at.starts_with(&source)).collect();
        for folder in folders {
            let imports = imports(&source, folder);
            links += imports.values().map(BTreeSet::len).sum::<usize>();
            assert_eq!(
                circles(imports),
                Vec::<String>::new(),
                "{}",
                folder.display()
            );
        }
    }
    assert!(links > 100, "{links} imports");
    // The check itself: a folder and a file that import each other.
    let of = |used: &str| BTreeSet::from([used.to_owned()]);
    let both = [("bars", "force"), ("force", "bars"), ("node", "force")];
    let both = both.map(|(name, used)| (name.to_owned(), of(used)));
    assert_eq!(circles(BTreeMap::from(both)), ["bars", "force"]);
}

/// Only the world runs recorded steps of robots: everything else calls its verb.
#[test]
fn only_the_world_runs_recorded_steps() {
    let rooms = SOURCES.into_iter().filter(|source| {
        let parts = ["cosmic", "gpu", "python", "web"];
        parts.iter().any(|part| source.starts_with(part))
    });
    let runs = |path: &PathBuf| names_after("autodiff_programs::", &code(path)).contains("Rollout");
    let running: Vec<PathBuf> = rooms.flat_map(sources).filter(runs).collect();
    let (world, others): (Vec<_>, Vec<_>) = (running.into_iter())
        .partition(|path| path.starts_with(workspace().join("cosmic/src/world")));
    assert!(!world.is_empty());
    assert_eq!(others, Vec::<PathBuf>::new());
}

/// Every source file is declared as a module; otherwise it would not be compiled.
#[test]
fn every_file_is_declared() {
    let mut lost = Vec::new();
    for path in SOURCES.into_iter().chain(TESTS).flat_map(sources) {
        let folder = path.parent().unwrap();
        let name = match path.ends_with("mod.rs") {
            true => folder.file_name().unwrap(),
            false => path.file_stem().unwrap(),
        };
        let name = name.to_string_lossy();
        // Roots of crates and binaries; `number_types.rs` is a binary of its own.
        let is_root = ["main", "lib", "number_types"].contains(&&*name);
        let is_binary = folder.ends_with("bin");
        // The root of a test binary may declare the modules of all folders.
        let texts = path.ancestors().skip(1).take(3).flat_map(|folder| {
            let inside = ["mod.rs", "lib.rs", "main.rs"].map(|file| folder.join(file));
            inside.into_iter().chain([folder.with_extension("rs")])
        });
        let declares = |file: PathBuf| {
            let declared = [format!("mod {name};"), format!("path = \"{name}.rs\"")];
            let text = fs::read_to_string(file).unwrap_or_default();
            declared.iter().any(|line| text.contains(line))
        };
        if !is_root && !is_binary && !texts.into_iter().any(declares) {
            lost.push(path.display().to_string());
        }
    }
    assert_eq!(lost, Vec::<String>::new());
}

/// Unit tests compare the instruction sets of the machine, because only they can choose one, or show what only private
/// functions do. Other libraries than `autodiff` and `autodiff_programs` have `test = false`, so their unit tests would not run.
#[test]
fn tests_are_in_the_folders_of_tests() {
    let allowed = [
        "math/tests.rs",
        "reverse/index.rs",
        "simd/tests.rs",
        "simd/doubted.rs",
        "steps/tests.rs",
    ];
    let files = SOURCES.into_iter().flat_map(sources);
    for path in files.filter(|path| !allowed.iter().any(|file| path.ends_with(file))) {
        let text = fs::read_to_string(&path).unwrap();
        let file = path.display();
        assert!(
            !text.contains("#[test]"),
            "{file}: move its unit test to `tests`"
        );
    }
}

/// Every test that the table of bugs of other tools names exists.
#[test]
fn reports_about_other_tools_have_their_tests() {
    let page = fs::read_to_string(workspace().join("CONTRIBUTING.md")).unwrap();
    let section = page.split("## Bugs of other tools").nth(1).unwrap();
    let table = section.split("\n## ").next().unwrap();
    let rows: Vec<&str> = table.lines().filter(|line| line.contains("::")).collect();
    assert!(rows.len() > 10, "{} rows", rows.len());
    for row in rows {
        let named = row.rsplit('`').nth(1).unwrap();
        let (module, test) = named.split_once("::").unwrap();
        let file = match module.strip_suffix(".py") {
            Some(_) => workspace().join(module),
            None => ["autodiff/tests", "autodiff/programs/tests"]
                .map(|folder| workspace().join(format!("{folder}/{module}.rs")))
                .into_iter()
                .find(|file| file.exists())
                .expect("a file of tests"),
        };
        let code = fs::read_to_string(file).unwrap();
        let is_test = ["fn ", "def "]
            .iter()
            .any(|word| code.contains(&format!("{word}{test}(")));
        assert!(is_test, "{named}: no such test");
    }
}
