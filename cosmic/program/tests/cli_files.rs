//! `docs/files.md` and `docs/scene.md` describe every key and every column of the files that users read and write.
//! With `EMIT=1` the tests write the generated parts of these pages.

use crate::common::Bench;
use cosmic::case::Case;
use cosmic::keys::{Key, Keyed};
use cosmic::outcome::Summary;
use cosmic::projection::Projection;
use cosmic::scene::{Scene, reference};
use cosmic::search::Record;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// A scene for a short run that goes through every phase. In a search over starts, the loss of the task decides the
/// ranks.
const SCENE: &str = "
base = 'stability'
[lattice]
columns = 3
rows = 3
[physics]
steps = 64
[schedule]
iterations = 12
attraction_from = 6
snap_at = 8
horizon = [32, 64]
horizon_over = [2, 5]
[loss]
window = 16
[objective]
task = \"climb\"
";

/// The heading of the generated part at the end of a page.
const KEYS: &str = "## Keys\n\n";
/// The end of a generated part within a page.
const END: &str = "\n<!-- end of the generated table -->";

/// Held while a page is compared or written, because tests run in parallel.
static PAGES: Mutex<()> = Mutex::new(());

/// The path of a page. It is a link to the page in `docs`, so that the crate's package contains the page too.
fn page(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests")
        .join(name)
}

/// Returns the names that the pages do not describe. A name counts as described if it is in backticks.
fn missing(names: &BTreeSet<String>) -> Vec<&String> {
    let pages = ["files.md", "scene.md"].map(|name| fs::read_to_string(page(name)).unwrap());
    let is_missing = |name: &&String| !pages.concat().contains(&format!("`{name}`"));
    names.iter().filter(is_missing).collect()
}

/// Asserts that the part of a page from a heading to [`END`], or to the end of the page, equals `text`. With `EMIT=1`,
/// writes that part instead.
#[track_caller]
fn is_fresh(name: &str, heading: &str, text: &str) {
    let _held = PAGES.lock().unwrap_or_else(PoisonError::into_inner);
    let now = fs::read_to_string(page(name)).unwrap();
    let (head, rest) = now.split_once(heading).unwrap();
    let tail = rest.find(END).map_or("", |end| &rest[end..]);
    let fresh = format!("{head}{heading}{}\n{tail}", text.trim_end());
    if std::env::var_os("EMIT").is_some() {
        fs::write(page(name), fresh).unwrap();
    } else {
        let differs = now.lines().zip(fresh.lines()).find(|(a, b)| a != b);
        assert_eq!(
            differs, None,
            "{name} is out of date: run this test with EMIT=1"
        );
        assert!(
            now == fresh,
            "{name} is out of date: run this test with EMIT=1"
        );
    }
}

/// Collects the keys in a JSON value, and the names of formats. Keys that are numbers are left out: they are the
/// numbers of steps in a trajectory.
fn of_json(value: &Value, names: &mut BTreeSet<String>) {
    match value {
        Value::Object(map) => {
            let keys = map.keys().filter(|key| key.parse::<usize>().is_err());
            names.extend(keys.cloned());
            names.extend(map.get("format").map(|f| f.as_str().unwrap().to_owned()));
            map.values().for_each(|item| of_json(item, names));
        }
        Value::Array(list) => list.iter().for_each(|item| of_json(item, names)),
        _ => {}
    }
}

/// Collects the names of files, keys and columns in a folder and in its subfolders. From a snapshot, it takes only the
/// outermost keys.
fn of_folder(folder: &Path, names: &mut BTreeSet<String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        if path.is_dir() {
            of_folder(&path, names);
            continue;
        }
        let bytes = fs::read(&path).unwrap();
        let text = String::from_utf8_lossy(&bytes);
        let json = |text: &str| serde_json::from_str::<Value>(text).unwrap();
        match name.rsplit_once('.').unwrap().1 {
            "json" if name == "snapshot.json" => {
                let file = json(&text);
                names.extend(file.as_object().unwrap().keys().cloned());
            }
            "json" => of_json(&json(&text), names),
            "jsonl" => text.lines().for_each(|line| of_json(&json(line), names)),
            "csv" => {
                let head = text.lines().next().unwrap().split(',');
                // The page has the column of an actuator, edge 3, as an example.
                let edge = |name: &str| name.starts_with("length_");
                names
                    .extend(head.map(|name| if edge(name) { "length_3" } else { name }.to_owned()));
            }
            _ => continue,
        }
        names.insert(name);
    }
}

#[test]
fn the_page_describes_all_files_of_runs_and_sweeps() {
    let bench = Bench::with(SCENE);
    for command in [
        "optimize tiny.toml --starts 2 --out runs/several",
        "optimize --from runs/several --out runs/on",
        "export runs/on --csv --svg",
        "sweep run tiny.toml --out runs/s",
    ] {
        bench.ok(command);
    }
    let mut names = BTreeSet::new();
    of_folder(&bench.path("runs"), &mut names);
    let rare = "bars.csv start.json entered loss_p50 merit_horizon";
    for name in rare.split(' ') {
        assert!(names.contains(name), "no file of these runs has {name}");
    }
    assert_eq!(missing(&names), [""; 0]);
}

#[test]
fn the_page_describes_the_results_of_a_case() {
    let scene = Scene::parse("tiny", SCENE).unwrap();
    let mut case = Case::of_scene(&scene, 0).unwrap();
    case.projection = Projection::Stability;
    let results = case.evaluate(true, &[]).unwrap().to_json();
    let mut names = BTreeSet::new();
    of_json(&serde_json::from_str(&results).unwrap(), &mut names);
    assert!(names.contains("grad_augmented_performance_constraints"));
    assert_eq!(missing(&names), [""; 0]);
}

/// The reader of cases lists all known keys in its errors, which is where this test gets the keys from. The sections of a
/// scene are on their own page, but not the numbers that only cases have.
#[test]
fn the_page_describes_every_key_of_a_case() {
    let mut scene = Scene::parse("tiny", SCENE).unwrap();
    let whole = Case::of_scene(&scene, 0).unwrap().to_json();
    // The `scene` of version 1 is converted when the rest of the case is read, which must be complete.
    let of_version_1 = |scene: Value| {
        let mut case: Value = serde_json::from_str(&whole).unwrap();
        (case["version"], case["scene"]) = (1.into(), scene);
        case.to_string()
    };
    let mut names = BTreeSet::new();
    for text in [
        r#"{"?": 0}"#,
        r#"{"projection": "?"}"#,
        r#"{"al": {"?": 0}}"#,
        &of_version_1(json!({"?": 0})),
        &of_version_1(json!({"library": {"?": 0}})),
    ] {
        let says = Case::parse("case", text).unwrap_err().to_string();
        let (_, known) = says.split_once("`?`, expected ").expect(&says);
        names.extend(known.split('`').skip(1).step_by(2).map(str::to_owned));
    }
    scene.of_sections(|_, settings| {
        let fields = settings.fields_of_cases().into_iter();
        let fields = fields.filter(|field| field.of_cases);
        names.extend(fields.map(|field| field.key.to_owned()));
    });
    for name in [
        "l0",
        "goal_scale",
        "thresholds",
        "a_max",
        "note",
        "beta_stability",
    ] {
        assert!(names.contains(name), "{name} is not known");
    }
    assert_eq!(missing(&names), [""; 0]);
}

#[test]
fn the_keys_of_a_scene_are_on_the_page() {
    is_fresh("scene.md", KEYS, &reference());
}

/// The rows of a table of keys. The rows of an object's keys follow the row of the object, once for all objects that
/// have the same keys.
fn rows(of: &str, keys: &[Key]) -> String {
    let row = |(k, key): (usize, &Key)| {
        let Key {
            name,
            kind,
            unit,
            doc,
            parts,
            ..
        } = key;
        let has_same = |other: &&Key| !parts.is_empty() && other.parts == *parts;
        let (also, parts) = match keys[..k].iter().find(has_same) {
            Some(other) => (
                format!(" It has the keys of `{}`.", other.name),
                String::new(),
            ),
            None => (String::new(), rows(&format!("{of}`{name}`: "), parts)),
        };
        format!("| {of}`{name}` | {kind} | {unit} | {doc}{also} |\n{parts}")
    };
    keys.iter().enumerate().map(row).collect()
}

#[test]
fn the_keys_of_files_are_on_the_page() {
    for (file, keys) in [
        ("summary.json", Summary::keys()),
        ("history.jsonl", Record::keys()),
    ] {
        let heading = format!("<!-- keys of {file} -->\n\n");
        let head = "| key | type | unit | meaning |\n| --- | --- | --- | --- |\n";
        is_fresh("files.md", &heading, &(head.to_owned() + &rows("", &keys)));
    }
}
