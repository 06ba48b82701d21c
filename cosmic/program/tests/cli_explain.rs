//! `cosmic explain` as a user meets it.

use cosmic::case::Case;
use cosmic::scene::{Scene, VoidEdges};
use serde_json::Value;
use std::fs;

use crate::program::cosmic_in;

#[test]
fn a_rollout_is_stated_with_its_stable_step() {
    let folder = tempfile::tempdir().unwrap();
    let told = cosmic_in(folder.path(), &["explain"]);
    assert_eq!(told.code, 0, "{}", told.error);
    assert!(told.out.starts_with("stability\n"), "{}", told.out);
    for words in [
        "36 nodes, 110 edges",
        "8192 of 0.002 s",
        "infinite friction",
        "stable step",
    ] {
        assert!(told.out.contains(words), "no {words:?} in {}", told.out);
    }
    let told = cosmic_in(folder.path(), &["explain", "coulomb", "--json"]);
    let json: Value = serde_json::from_str(&told.out).unwrap();
    let rollout = &json["rollout"];
    assert_eq!(
        (&rollout["contact"], rollout["friction"].as_f64()),
        (&"coulomb".into(), Some(2.5))
    );
    let plan = json["plan"].as_array().unwrap();
    let term = |name: &str| plan.iter().find(|t| t["term"] == name).unwrap();
    assert_eq!(term("Coulomb friction")["kept"], true);
    assert_eq!(term("bending of bars")["kept"], false);
    let limit = |key: &str| rollout["stable_dt"][key].as_f64().unwrap();
    // The scenes are stable with room to spare, and a bound is on the safe side.
    assert!(limit("bound") > 0.002 && limit("bound") <= limit("exact"));
    assert!(json.get("measured").is_none());
}

#[test]
fn a_step_is_measured() {
    let folder = tempfile::tempdir().unwrap();
    let text = "[lattice]\ncolumns = 3\nrows = 2\n[controller]\nhidden = 4\n";
    fs::write(folder.path().join("small.toml"), text).unwrap();
    let told = cosmic_in(
        folder.path(),
        &["explain", "small.toml", "--measure", "--json"],
    );
    assert_eq!(told.code, 0, "{}", told.error);
    let json: Value = serde_json::from_str(&told.out).unwrap();
    let measured = &json["measured"];
    assert_eq!(measured["steps"], 4096);
    assert!(measured["two_matvecs"].as_f64().unwrap() > 0.0);
    for set in ["", "f32_", "one_hot_", "one_hot_f32_", "eight_starts_"] {
        let time = |key: &str| measured[format!("{set}{key}")].as_f64().unwrap();
        let rollout = time("rollout");
        assert!(rollout > 0.0, "{set}");
        for key in ["value_and_design_gradient", "value_and_controller_gradient"] {
            assert!(time(key) > rollout, "{set}{key}");
        }
    }
    let errors = measured["f32_gradient_errors"].as_array().unwrap();
    let steps: Vec<_> = errors.iter().map(|e| e["steps"].as_u64()).collect();
    assert_eq!(steps, [Some(2048), Some(4096)]);
    // Two computations that round differently; how far apart depends on the motion's chaos.
    assert!(errors.iter().all(|e| e["design"].as_f64() > Some(0.0)));
    assert_eq!(
        measured["peak_memory_bytes"].is_u64(),
        cfg!(target_os = "linux")
    );
}

#[test]
fn a_case_without_steps_is_measured_by_one() {
    let folder = tempfile::tempdir().unwrap();
    let scene = Scene::default();
    let mut case = Case::of_scene(&scene, 0).unwrap();
    case.physics.steps = 0;
    fs::write(folder.path().join("still.json"), case.to_json()).unwrap();
    let arguments = ["explain", "still.json", "--measure", "--json"];
    let told = cosmic_in(folder.path(), &arguments);
    assert_eq!(told.code, 0, "{}", told.error);
    let json: Value = serde_json::from_str(&told.out).unwrap();
    assert_eq!(json["measured"]["steps"], 1);
}

#[test]
fn void_edges_are_accounted_for() {
    let folder = tempfile::tempdir().unwrap();
    let mut scene = Scene::load("baseline_tall").unwrap();
    scene.physics.void_edges = VoidEdges::Drop;
    fs::write(folder.path().join("dropped.toml"), scene.to_toml()).unwrap();
    let explain = |source: &str| {
        let told = cosmic_in(folder.path(), &["explain", source, "--json"]);
        serde_json::from_str::<Value>(&told.out).unwrap()
    };
    for (source, is_dropped) in [("baseline_tall", false), ("dropped.toml", true)] {
        let json = explain(source);
        let plan = json["plan"].as_array().unwrap();
        let term = plan.iter().find(|t| t["term"] == "void edges").unwrap();
        assert_eq!(term["kept"], !is_dropped);
        let why = format!(
            "physics.void_edges is {:?}",
            if is_dropped { "drop" } else { "keep" }
        );
        assert!(term["why"].as_str().unwrap().contains(&why), "{term}");
        let voids = &json["void_edges"];
        assert_eq!(voids["dropped"], is_dropped);
        let number = |key: &str| voids[key].as_f64().unwrap();
        assert!(number("edges") > 40.0 && number("registers_without") <= number("registers"));
        // Eight edges at a node at most, of 1e-7 N/m each.
        assert!(number("force") > 0.0 && number("force") <= 8.0e-7 * (1.0 + 1e-12));
        assert!(voids["body"]["displacement"].as_f64() > Some(0.0));
        assert!(voids["saving"].is_null());
    }
    assert!(explain("stability").get("void_edges").is_none());
    let told = cosmic_in(folder.path(), &["explain", "dropped.toml"]);
    assert!(
        told.out.contains("void edges pull a node with"),
        "{}",
        told.out
    );
    let text = scene.to_toml().replace("\"drop\"", "\"dropped\"");
    fs::write(folder.path().join("wrong.toml"), text).unwrap();
    let told = cosmic_in(folder.path(), &["explain", "wrong.toml"]);
    assert!(
        told.code == 2 && told.error.contains("\"keep\" or \"drop\""),
        "{told:?}"
    );
}

#[test]
fn bad_input_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let told = cosmic_in(folder.path(), &["explain", "stabilty"]);
    assert!(
        told.code == 4 && told.error.contains("did you mean `stability`?"),
        "{told:?}"
    );
    let told = cosmic_in(folder.path(), &["explain", "stability", "--frob"]);
    assert!(told.code == 2 && told.error.contains("--frob"), "{told:?}");
}
