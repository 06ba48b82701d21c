//! Checks of the architecture of each crate. A module imports only modules that are above it in `lib.rs`. Files do not
//! import one another in a circle. No derivative is written by hand.

mod by_hand;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use cosmic_tests::{files_below, workspace};

/// The source folders of all crates whose architecture is tested.
const SOURCES: [&str; 7] = [
    "autodiff/src",
    "cosmic/optimiser/src",
    "cosmic/src",
    "cosmic/lab/src",
    "cosmic/program/src",
    "benches/src",
    "tests/src",
];

/// The path of a module or an item from the root of its crate, as a list of names.
type ItemPath = Vec<String>;

struct SourceFile {
    path: PathBuf,
    /// The code of the file without comments and without the tests at the end of the file.
    code: String,
}

/// The source files of a crate, by the path of their module.
struct SourceTree {
    files: BTreeMap<ItemPath, SourceFile>,
}

/// A path that a file's code contains, from the root of the crate.
struct Mention {
    path: ItemPath,
    /// True if the file re-exports this item with `pub use`.
    reexport: bool,
}

impl SourceTree {
    fn read(source: &str) -> Self {
        let root = workspace().join(source);
        let file = |path: PathBuf| {
            let code = without_comments_and_tests(&fs::read_to_string(&path).unwrap());
            (module_of(&path, &root), SourceFile { path, code })
        };
        let paths = files_below(&root, &["rs"]).into_iter();
        Self {
            files: paths.map(file).collect(),
        }
    }

    /// The modules that `lib.rs` declares, from top to bottom.
    fn floors(&self) -> Vec<String> {
        let declared = |line: &str| {
            let name = line.trim_start_matches("pub ").strip_prefix("mod ")?;
            Some(name.strip_suffix(';')?.to_owned())
        };
        self.files[&ItemPath::new()]
            .code
            .lines()
            .filter_map(declared)
            .collect()
    }

    /// The paths in the code of a file that lead to modules or items of the same crate.
    fn mentions(&self, module: &ItemPath) -> Vec<Mention> {
        let code = &self.files[module].code;
        let mut mentions = Vec::new();
        let mut rest = String::new();
        for statement in code.split_inclusive(';') {
            let Some((before, tree)) = split_at_use(statement) else {
                rest.push_str(statement);
                continue;
            };
            rest.push_str(before);
            let reexport = before.trim_end().ends_with("pub")
                || before.trim_end().ends_with(')') && before.contains("pub(");
            for path in leaves(tree) {
                let path = self.path_from_root(module, &path);
                mentions.extend(path.map(|path| Mention { path, reexport }));
            }
        }
        for path in paths_in(&rest) {
            let path = self.path_from_root(module, &path);
            mentions.extend(path.map(|path| Mention {
                path,
                reexport: false,
            }));
        }
        mentions
    }

    /// Resolves a path in the code of `module` to a path from the crate's root. Returns `None` for paths out of the
    /// crate.
    fn path_from_root(&self, module: &ItemPath, path: &str) -> Option<ItemPath> {
        let mut segments = path.split("::").map(str::trim).peekable();
        let mut base = module.clone();
        match *segments.peek()? {
            "crate" | "$crate" => {
                segments.next();
                base.clear();
            }
            "self" => {
                segments.next();
            }
            "super" => {
                while segments.next_if_eq(&"super").is_some() {
                    base.pop();
                }
            }
            first => {
                let child = [&base[..], &[first.to_owned()]].concat();
                if !self.files.contains_key(&child) {
                    return None;
                }
            }
        }
        base.extend(segments.map(str::to_owned));
        Some(base)
    }

    /// The module whose file defines the item at a path. If a file re-exports the item, the search continues from
    /// there.
    fn defining(&self, path: &ItemPath, reexports: &BTreeMap<ItemPath, ItemPath>) -> ItemPath {
        let mut path = path;
        // Chains of re-exports are short; the limit is needed in case they are circular.
        for _ in 0..8 {
            let Some(further) = (0..=path.len()).rev().find_map(|length| {
                // In `laws::contact::Impact`, `laws::contact` is the module, not the re-exported function.
                let is_module = length < path.len() && self.files.contains_key(&path[..length]);
                reexports.get(&path[..length]).filter(|_| !is_module)
            }) else {
                break;
            };
            path = further;
        }
        let is_file = |length: &usize| self.files.contains_key(&path[..*length]);
        let length = (0..=path.len()).rev().find(is_file).unwrap_or(0);
        path[..length].to_vec()
    }

    /// For each file, the files that it imports.
    fn imports(&self) -> BTreeMap<ItemPath, BTreeSet<ItemPath>> {
        let mentions: BTreeMap<_, _> = self
            .files
            .keys()
            .map(|module| (module, self.mentions(module)))
            .collect();
        let mut reexports = BTreeMap::new();
        for (module, mentions) in &mentions {
            for mention in mentions.iter().filter(|mention| mention.reexport) {
                let name = mention.path.last().expect("a path has a name").clone();
                let here = [&module[..], &[name]].concat();
                if here != mention.path {
                    reexports.insert(here, mention.path.clone());
                }
            }
        }
        let of_file = |(module, mentions): (&ItemPath, Vec<Mention>)| {
            let used = mentions.iter().filter(|mention| !mention.reexport);
            let mut used: BTreeSet<_> = used
                .map(|mention| self.defining(&mention.path, &reexports))
                .collect();
            used.remove(module);
            (module.clone(), used)
        };
        mentions.into_iter().map(of_file).collect()
    }

    /// The files that are part of a circle of imports, with their imports. If a chain of imports leads from one circle
    /// to another, the files of the chain are included.
    fn circles(&self) -> Vec<String> {
        let mut imports = self.imports();
        // A file that imports no file, or that no file imports, is not in a circle. Remove such files until only files
        // in circles or between circles remain.
        loop {
            let before = imports.len();
            let left: BTreeSet<_> = imports.keys().cloned().collect();
            imports.retain(|_, used| {
                used.retain(|module| left.contains(module));
                !used.is_empty()
            });
            let used: BTreeSet<_> = imports.values().flatten().cloned().collect();
            imports.retain(|module, _| used.contains(module));
            if imports.len() == before {
                let name = |(module, used): (&ItemPath, &BTreeSet<ItemPath>)| {
                    let used: Vec<_> = used.iter().map(|module| module.join("::")).collect();
                    let path = self.files[module].path.display();
                    format!("{path} imports {}", used.join(", "))
                };
                return imports.iter().map(name).collect();
            }
        }
    }

    /// The imports of modules that are further down in `lib.rs`, each as a text `file: path`.
    fn upward(&self, floors: &[String]) -> Vec<String> {
        let floor = |module: &ItemPath| {
            let name = module.first()?;
            floors.iter().position(|floor| floor == name)
        };
        let mut wrong = Vec::new();
        for module in self.files.keys() {
            for mention in self.mentions(module) {
                if let (Some(here), Some(there)) = (floor(module), floor(&mention.path))
                    && there > here
                {
                    let file = self.files[module].path.display();
                    wrong.push(format!("{file}: {}", mention.path.join("::")));
                }
            }
        }
        wrong
    }
}

/// The module path of a file: both `a/b.rs` and `a/b/mod.rs` are `a::b`.
fn module_of(path: &Path, root: &Path) -> ItemPath {
    let inside = path.strip_prefix(root).unwrap().with_extension("");
    let mut module: ItemPath = inside
        .iter()
        .map(|part| part.to_string_lossy().into_owned())
        .collect();
    if module
        .last()
        .is_some_and(|name| ["mod", "lib", "main"].contains(&name.as_str()))
    {
        module.pop();
    }
    module
}

fn without_comments_and_tests(text: &str) -> String {
    let code = text
        .split("#[cfg(test)]\nmod tests")
        .next()
        .unwrap_or_default();
    let line = |line: &str| line.split("//").next().unwrap_or_default().to_owned() + "\n";
    code.lines().map(line).collect()
}

/// Splits a statement into the parts before and after `use `, without the semicolon. Returns `None` for a statement
/// that is not an import.
fn split_at_use(statement: &str) -> Option<(&str, &str)> {
    let begins_word =
        |at: &usize| !statement[..*at].ends_with(|c: char| c.is_alphanumeric() || c == '_');
    let at = statement
        .match_indices("use ")
        .map(|(at, _)| at)
        .find(begins_word)?;
    let tree = statement[at + "use ".len()..].strip_suffix(';')?;
    Some((&statement[..at], tree))
}

/// The paths in a tree of imports, one by one: `a::{b, c::d}` gives `a::b` and `a::c::d`.
fn leaves(tree: &str) -> Vec<String> {
    let tree = tree.trim();
    let Some((stem, branches)) = tree.split_once('{') else {
        let path = tree.split(" as ").next().unwrap_or_default();
        return vec![path.trim_end_matches("::*").to_owned()];
    };
    let branches = branches.trim_end().strip_suffix('}').unwrap_or(branches);
    let (mut paths, mut depth, mut begin) = (Vec::new(), 0, 0);
    for (at, c) in branches.char_indices().chain([(branches.len(), ',')]) {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                let branch = branches[begin..at].trim();
                if !branch.is_empty() {
                    paths.extend(leaves(branch).iter().map(|path| format!("{stem}{path}")));
                }
                begin = at + 1;
            }
            _ => {}
        }
    }
    // `a::{self, b}` names `a`.
    paths
        .iter()
        .map(|path| path.trim_end_matches("::self").to_owned())
        .collect()
}

/// All paths in code, such as `super::a` or `child::b`. A path consists of words that are joined by `::`.
fn paths_in(code: &str) -> Vec<String> {
    let in_path = |c: char| c.is_alphanumeric() || c == '_' || c == ':' || c == '$';
    let words = code
        .split(|c: char| !in_path(c))
        .filter(|word| word.contains("::"));
    words
        .map(|word| word.trim_matches(':').to_owned())
        .filter(|word| word.contains("::") && !word.starts_with(':'))
        .collect()
}

#[test]
fn every_module_imports_only_modules_above_it() {
    for source in SOURCES {
        let tree = SourceTree::read(source);
        assert!(!tree.files.is_empty());
        assert_eq!(tree.upward(&tree.floors()), Vec::<String>::new());
    }
    let floors = SourceTree::read("cosmic/src").floors();
    assert!(
        floors.len() > 5,
        "lib.rs lists its modules as `pub mod name;`: {floors:?}"
    );
}

/// Tests the test above: with the modules in reversed order, it must find imports of modules that are further down.
#[test]
fn upward_imports_are_found() {
    for source in ["autodiff/src", "cosmic/src", "cosmic/lab/src"] {
        let tree = SourceTree::read(source);
        let mut floors = tree.floors();
        floors.reverse();
        assert!(!tree.upward(&floors).is_empty());
    }
}

/// The folders of tests. The files of each folder form one binary.
const TESTS: [&str; 6] = [
    "autodiff/tests",
    "cosmic/optimiser/tests",
    "cosmic/tests",
    "cosmic/lab/tests",
    "cosmic/program/tests",
    "tests/tests",
];

/// Every test file is declared as a module; otherwise it would not be compiled.
#[test]
fn every_file_is_declared() {
    let mut lost = Vec::new();
    for source in SOURCES.into_iter().chain(TESTS) {
        let tree = SourceTree::read(source);
        for (module, SourceFile { path, .. }) in &tree.files {
            // These files are roots of binaries or crates, which no module declares; `number_types.rs` is a binary of
            // its own.
            let roots = ["main.rs", "lib.rs", "number_types.rs"];
            let is_root = roots.iter().any(|root| path.ends_with(root));
            let Some((name, parent)) = module.split_last().filter(|_| !is_root) else {
                continue;
            };
            // The root of a test binary may declare the modules of all folders.
            let main = fs::read_to_string(workspace().join(source).join("main.rs")).ok();
            let folders = path.ancestors().skip(1).take(2);
            let texts = folders.flat_map(|folder| {
                let own = parent
                    .last()
                    .map(|name| folder.join(name).with_extension("rs"));
                let roots = ["mod.rs", "lib.rs", "main.rs"].map(|file| folder.join(file));
                roots
                    .into_iter()
                    .chain(own)
                    .filter_map(|file| fs::read_to_string(file).ok())
            });
            let declares = |text: String| text.contains(&format!("mod {name};"));
            if !texts.chain(main).any(declares) {
                lost.push(path.display().to_string());
            }
        }
    }
    assert_eq!(lost, Vec::<String>::new());
}

/// The libraries other than `autodiff` have `test = false`, so a unit test in `src` would not run.
#[test]
fn tests_are_in_the_folders_of_tests() {
    let sources = SOURCES
        .into_iter()
        .filter(|source| *source != "autodiff/src");
    for path in sources.flat_map(|source| files_below(&workspace().join(source), &["rs"])) {
        let text = fs::read_to_string(&path).unwrap();
        let file = path.display();
        assert!(
            !text.contains("#[test]"),
            "{file}: move its unit test to `tests`"
        );
    }
}

#[test]
fn no_files_import_one_another_in_a_circle() {
    for source in SOURCES {
        assert_eq!(SourceTree::read(source).circles(), Vec::<String>::new());
    }
}

/// Tests the search for circles of imports: it finds circles through a re-export, and does not report files beside a
/// circle.
#[test]
fn circles_are_found() {
    let file = |module: &str, code: &str| {
        let module = module.split("::").filter(|name| !name.is_empty());
        let path = PathBuf::from("file");
        let code = without_comments_and_tests(code);
        (
            module.map(str::to_owned).collect(),
            SourceFile { path, code },
        )
    };
    let tree = |of_a: &str| SourceTree {
        files: BTreeMap::from([
            file(
                "",
                "pub mod a;\npub mod b;\npub use b::deep::{self, Item};\n",
            ),
            file("a", of_a),
            file("b", "pub mod deep;\n"),
            file(
                "b::deep",
                "use crate::a::Other; // crate::b\nstruct Item;\n",
            ),
        ]),
    };
    for circle in [
        "use crate::Item;\n",
        "use crate::b::{deep::Item};\n",
        "fn f() { super::b::deep::f() }\n",
    ] {
        let found = tree(circle).circles();
        assert!(found.len() == 2, "{circle}: {found:?}");
    }
    for none in [
        "struct Other;\n",
        "pub use crate::Item;\n",
        "#[cfg(test)]\nmod tests { use crate::Item; }\n",
    ] {
        assert_eq!(tree(none).circles(), Vec::<String>::new());
    }
    assert_eq!(
        tree("").upward(&["a".into(), "b".into()]),
        Vec::<String>::new()
    );
    assert_eq!(
        tree("").upward(&["b".into(), "a".into()]),
        ["file: a::Other"]
    );
}
