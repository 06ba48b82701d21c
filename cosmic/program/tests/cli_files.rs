//! `docs/files.md` and `docs/scene.md` have every key and every column of the files that users read and write.

use crate::common::Bench;
use cosmic::case::Case;
use cosmic::projection::Projection;
use cosmic::scene::{Scene, reference};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// A run of seconds with every phase, for a task that is ranked by its loss.
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
[search]
rungs = [4, 12, 12]
keep = [0.5, 0.5, 0.5]
window = 4
";

/// A link to a page of `docs`, so that the page is in the package too.
fn page(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests")
        .join(name)
}

/// Names that the page does not have as words of code.
fn missing(names: &BTreeSet<String>) -> Vec<&String> {
    let pages = ["files.md", "scene.md"].map(|name| fs::read_to_string(page(name)).unwrap());
    let is_missing = |name: &&String| !pages.concat().contains(&format!("`{name}`"));
    names.iter().filter(is_missing).collect()
}

/// The keys of a value and of all in it, and what it says that it is. Numbers of steps, the keys of
/// a trajectory, are no names.
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

/// The names in all data of a folder and of those below, and the files' own. What is in a snapshot
/// is the program's affair.
fn of_folder(folder: &Path, names: &mut BTreeSet<String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        if path.is_dir() {
            if name != "claims" {
                of_folder(&path, names);
            }
            continue;
        }
        // Solids are no text, and have no names in them.
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
            "csv" => names.extend(text.lines().next().unwrap().split(',').map(str::to_owned)),
            _ => continue,
        }
        names.insert(name);
    }
}

#[test]
fn what_runs_and_sweeps_write_is_on_the_page() {
    let bench = Bench::with(SCENE);
    bench.write("base.toml", SCENE.replace("base = 'stability'\n", ""));
    for command in [
        "optimize tiny.toml --starts 2 --search halving --out runs/halved",
        "optimize --from runs/halved --out runs/on",
        "export runs/on --csv --svg --dxf --stl",
        "sweep plan tiny.toml --seeds 1 --out runs/s",
        "sweep run runs/s --index all",
        "sweep merge runs/s",
        "study ablation --base base.toml --seeds 1 --iterations 2 --out runs/out --runs runs/study",
    ] {
        bench.cosmic(command).ok();
    }
    let mut names = BTreeSet::new();
    of_folder(&bench.path("runs"), &mut names);
    let rare = "bars.csv solid.csv start.json search.json check.json dropped_at entered loss_p50 merit_horizon";
    for name in rare.split(' ') {
        assert!(names.contains(name), "no file of these runs has {name}");
    }
    assert_eq!(missing(&names), [""; 0]);
}

#[test]
fn results_of_a_case_are_on_the_page() {
    let scene = Scene::parse("tiny", SCENE).unwrap();
    let mut case = Case::of_scene(&scene, 0).unwrap();
    case.projection = Projection::Stability;
    let results = case.evaluate(true, &[]).unwrap().to_json();
    let mut names = BTreeSet::new();
    of_json(&serde_json::from_str(&results).unwrap(), &mut names);
    assert!(names.contains("grad_augmented_performance_constraints"));
    assert_eq!(missing(&names), [""; 0]);
}

/// The reader of cases says what it knows where it meets something else.
#[test]
fn every_key_that_a_case_may_have_is_on_the_page() {
    let mut names = BTreeSet::new();
    for text in [
        r#"{"?": 0}"#,
        r#"{"scene": {"?": 0}}"#,
        r#"{"scene": {"library": {"?": 0}}}"#,
        r#"{"scene": {"contact": "?"}}"#,
        r#"{"scene": {"integrator": "?"}}"#,
        r#"{"scene": {"void_edges": "?"}}"#,
        r#"{"projection": "?"}"#,
        r#"{"al": {"?": 0}}"#,
    ] {
        let says = Case::parse("case", text).unwrap_err().to_string();
        let (_, known) = says.split_once("`?`, expected ").expect(&says);
        names.extend(known.split('`').skip(1).step_by(2).map(str::to_owned));
    }
    for name in ["l0", "goal_scale", "thresholds", "coulomb", "note"] {
        assert!(names.contains(name), "{name} is not known");
    }
    assert_eq!(missing(&names), [""; 0]);
}

/// The tables of the scene's keys are those that the declarations give. `EMIT=1` writes them again.
#[test]
fn the_keys_of_a_scene_are_on_the_page() {
    const BEFORE: &str = "## Keys\n\n";
    let page = page("scene.md");
    let page_now = fs::read_to_string(&page).unwrap();
    let (head, _) = page_now.split_once(BEFORE).unwrap();
    let fresh = format!("{head}{BEFORE}{}\n", reference().trim_end());
    if std::env::var_os("EMIT").is_some() {
        fs::write(page, fresh).unwrap();
    } else {
        let differs = page_now.lines().zip(fresh.lines()).find(|(a, b)| a != b);
        assert_eq!(differs, None, "EMIT=1 writes the tables again");
        assert!(page_now == fresh, "EMIT=1 writes the tables again");
    }
}
