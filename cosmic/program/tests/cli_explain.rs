//! `cosmic explain`.

use crate::common::Bench;
use crate::program::has;
use cosmic::case::Case;
use cosmic::scene::{Scene, VoidEdges};

#[test]
fn explain_shows_a_rollout_and_its_stable_step() {
    let bench = Bench::default();
    assert!(bench.ok("explain").out.starts_with("earth\n"));
    let told = bench.ok("explain stability");
    assert!(told.out.starts_with("stability\n"), "{}", told.out);
    let words = [
        "36 nodes, 110 edges",
        "8192 of 0.002 s",
        "infinite friction",
        "stable step",
    ];
    has(&told.out, &words);
    let json = bench.cosmic("explain coulomb --json").json();
    let rollout = &json["rollout"];
    assert_eq!(rollout["contact"], "coulomb");
    assert_eq!(rollout["friction"], 2.5);
    let plan = json["plan"].as_array().unwrap();
    let term = |name: &str| plan.iter().find(|t| t["term"] == name).unwrap();
    assert_eq!(term("Coulomb friction")["kept"], true);
    assert_eq!(term("profile of the ground")["kept"], false);
    let limit = |key: &str| rollout["stable_dt"][key].as_f64().unwrap();
    // The scenes are stable with a margin, and the limit `bound` is no larger than the limit `exact`.
    assert!(limit("bound") > 0.002 && limit("bound") <= limit("exact"));
    assert!(json.get("measured").is_none());
}

#[test]
fn measure_times_a_step() {
    let text = "base = \"stability\"\n[lattice]\ncolumns = 3\nrows = 2\n[controller]\nhidden = 4\n";
    let json = Bench::with(text)
        .cosmic("explain tiny.toml --measure --json")
        .json();
    let measured = &json["measured"];
    assert_eq!(measured["steps"], 4096);
    let time = |key: &str| measured[key].as_f64().unwrap();
    assert!(time("two_matvecs") > 0.0 && time("rollout") > 0.0);
    for key in ["value_and_design_gradient", "value_and_controller_gradient"] {
        assert!(time(key) > time("rollout"), "{key}");
    }
    let memory = &measured["peak_memory_bytes"];
    assert_eq!(memory.is_u64(), cfg!(target_os = "linux"));
}

#[test]
fn a_case_without_steps_is_measured_over_one_step() {
    let bench = Bench::default();
    let mut case = Case::of_scene(&bench.plan().scene, 0).unwrap();
    case.physics.steps = 0;
    bench.write("still.json", case.to_json());
    let json = bench.cosmic("explain still.json --measure --json").json();
    assert_eq!(json["measured"]["steps"], 1);
}

#[test]
fn explain_says_whether_void_edges_are_kept() {
    let bench = Bench::default();
    let mut scene = Scene::load("baseline_tall").unwrap();
    scene.physics.void_edges = VoidEdges::Drop;
    bench.write("dropped.toml", scene.to_toml());
    let explain = |source: &str| bench.cosmic(&format!("explain {source} --json")).json();
    for (source, is_dropped) in [("baseline_tall", false), ("dropped.toml", true)] {
        let json = explain(source);
        let plan = json["plan"].as_array().unwrap();
        let term = plan.iter().find(|t| t["term"] == "void edges").unwrap();
        assert_eq!(term["kept"], !is_dropped);
        let setting = if is_dropped { "drop" } else { "keep" };
        let why = format!("physics.void_edges is {setting:?}");
        assert!(term["why"].as_str().unwrap().contains(&why), "{term}");
    }
    let wrong = scene.to_toml().replace("\"drop\"", "\"dropped\"");
    bench.write("wrong.toml", wrong);
    let told = bench.cosmic("explain wrong.toml");
    told.fails(2, &["\"keep\" or \"drop\""]);
}
