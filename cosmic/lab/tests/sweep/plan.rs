use cosmic::Registry;
use cosmic::scene::Scene;
use cosmic_lab::sweep::{Overrides, Plan, SWEEP, read};
use serde_json::json;
use std::fs;
use std::num::NonZeroUsize;
use std::path::Path;

const FILE: &str = r#"
seeds = 2
iterations = 30
grid.physics.friction = [0.6, 1]

[[variants]]
name = "light"
title = "On the moon"
settings.physics.gravity = 1.62

[[variants]]
name = "heavy"

[[trials]]
scene = "stability"
published = 1.9

[[trials]]
name = "own"
title = "an own scene"
scene = "scene.toml"
variants = ["heavy"]
settings.controller.hidden = 3
"#;

/// Reads a sweep's file with this text. The file `scene.toml` beside it is a scene.
fn of_file(text: &str, overrides: &Overrides) -> cosmic::Result<Plan> {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    fs::write(path("scene.toml"), "lattice.columns = 3").unwrap();
    fs::write(path("spec.toml"), text).unwrap();
    read(&[path("spec.toml")], overrides, &Registry::default())
}

fn scene(plan: &Plan, index: usize) -> Scene {
    plan.run(index, &Registry::default()).unwrap().scene
}

#[test]
fn a_file_has_a_run_for_every_variant_trial_value_and_seed() {
    let plan = of_file(FILE, &Overrides::default()).unwrap();
    let names: Vec<&str> = plan.trials.iter().map(|trial| &trial.name[..]).collect();
    let expected = [
        "light-stability+friction=0.6",
        "light-stability+friction=1",
        "heavy-stability+friction=0.6",
        "heavy-stability+friction=1",
        "heavy-own+friction=0.6",
        "heavy-own+friction=1",
    ];
    assert_eq!((names, plan.runs()), (expected.to_vec(), 12));
    let [light, own] = [1, 4].map(|k| &plan.trials[k]);
    assert_eq!(light.title, "On the moon: stability+friction=1");
    assert_eq!(own.title, "heavy: an own scene+friction=0.6");
    assert_eq!((light.published, own.published), (Some(1.9), None));
    assert_eq!(light.swept["physics.friction"], json!(1.0));
    let [light, own] = [2, 9].map(|k| scene(&plan, k));
    assert_eq!((light.physics.gravity, light.physics.friction), (1.62, 1.0));
    assert_eq!((own.lattice.columns, own.controller.hidden), (3, 3));
    assert_eq!((own.physics.friction, own.schedule.iterations), (0.6, 30));
}

#[test]
fn options_come_before_the_file() {
    let number = NonZeroUsize::new;
    let overrides = Overrides {
        set: vec![
            "physics.gravity=3,4".to_owned(),
            "controller.hidden=5".to_owned(),
        ],
        seeds: number(3),
        first_seed: Some(7),
        iterations: number(20),
    };
    let plan = of_file(FILE, &overrides).unwrap();
    assert_eq!(plan.runs(), 36);
    let last = plan.folder(Path::new("s"), 35);
    assert!(last.ends_with("runs/heavy-own+friction=1+gravity=4-9"));
    let last = scene(&plan, 35);
    assert_eq!((last.physics.gravity, last.controller.hidden), (4.0, 5));
    assert_eq!(last.schedule.iterations, 20);
}

#[test]
fn wrong_sweeps_are_refused() {
    let own = "scene = \"scene.toml\"";
    for (from, to, says) in [
        ("seeds = 2", "seeds = 0", "spec.toml:2:9"),
        ("\"heavy\"]", "\"heavi\"]", "did you mean `heavy`?"),
        ("hidden = 3", "hiden = 3", "did you mean `hidden`?"),
        (
            "[0.6, 1]",
            "0.6",
            "`grid.physics.friction` must be a list of values, not 0.6",
        ),
        ("[0.6, 1]", "[]", "a value is missing"),
        ("[0.6, 1]", "[1, 1]", "a value is repeated"),
        ("[0.6, 1]", "[0.6, -1]", "spec.toml:4:31"),
        (
            "physics.friction",
            "physics.frictoin",
            "did you mean `friction`?",
        ),
        (own, "", "missing key `scene`"),
        (own, "scene = \"nowhere.toml\"", "spec.toml:21:9"),
        (
            "\"own\"",
            "\"../own\"",
            "`heavy-../own+friction=0.6` cannot be the name of a folder",
        ),
        (
            "\"own\"",
            "\"stability\"",
            "spec.toml: two trials have the name `heavy-stability+friction=0.6`",
        ),
        (
            "seeds = 2",
            "seeds = 999999",
            "5999994 runs (trials x seeds: 6 x 999999) are too many",
        ),
    ] {
        let text = FILE.replace(from, to);
        assert_ne!(text, FILE);
        let error = of_file(&text, &Overrides::default()).unwrap_err();
        assert!(error.to_string().contains(says), "{says}: {error}");
    }
    let seeds = Overrides {
        first_seed: Some(u64::MAX),
        ..Overrides::default()
    };
    let error = of_file(FILE, &seeds).unwrap_err().to_string();
    assert!(error.contains("too many"), "{error}");
}

/// More trials and other seeds may join a sweep, but a trial cannot change.
#[test]
fn a_folder_keeps_its_trials() {
    let (folder, registry) = (tempfile::tempdir().unwrap(), Registry::default());
    let folder = folder.path().join("s");
    let keep = |names: &[&str], set: &[&str], seeds| {
        let strings = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect();
        let overrides = Overrides {
            set: strings(set),
            seeds: NonZeroUsize::new(seeds),
            ..Overrides::default()
        };
        let names: Vec<String> = strings(names);
        let plan = read(&names, &overrides, &registry).unwrap();
        plan.keep(&folder, &registry)?;
        assert_eq!(Plan::read(&folder).unwrap(), plan);
        cosmic::Result::Ok(fs::read(folder.join(SWEEP)).unwrap())
    };
    let before = keep(&["stability"], &[], 1).unwrap();
    assert_eq!(keep(&["stability"], &[], 1).unwrap(), before);
    keep(&["stability", "uniform"], &[], 3).unwrap();
    for (names, set) in [
        (&["stability"][..], &[][..]),
        (&["stability", "uniform"], &["physics.gravity=1"]),
    ] {
        let error = keep(names, set, 3).unwrap_err().to_string();
        assert!(error.contains("this folder holds another sweep"), "{error}");
    }
}
