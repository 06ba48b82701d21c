//! Options beyond the paper from the command line: robust designs, other tasks, richer physics.

mod common;

use common::{Bench, scene};
use serde_json::Value;

/// The small scene with more sections.
fn bench(physics: &str, more: &str) -> Bench {
    Bench::with(&(scene(24, 64, physics) + more))
}

/// `cosmic robustness` as JSON.
fn robustness(bench: &Bench, arguments: &[&str]) -> Value {
    let said = bench.cosmic(&[&["robustness", "--json"], arguments].concat());
    assert_eq!(said.code, 0, "{said:?}");
    serde_json::from_str(&said.out).unwrap()
}

#[test]
fn a_robust_design_is_another_one_and_repeats() {
    let bench = bench("contact = \"coulomb\"", "[robust]\nsamples = 2\n");
    bench.run("a", &[]);
    bench.run("b", &["--threads", "3"]);
    assert_eq!(bench.results("a"), bench.results("b"));
    let departures = bench.json("a/summary.json")["departures"].to_string();
    assert!(departures.contains("robust.samples"), "{departures}");
    let nominal = Bench::with(&scene(24, 64, "contact = \"coulomb\""));
    nominal.run("a", &[]);
    assert_ne!(bench.json("a/design.json"), nominal.json("a/design.json"));
}

#[test]
fn robustness_lays_runs_beside_one_another_in_the_same_worlds() {
    let bench = Bench::new(24, 64);
    bench.run("a", &[]);
    bench.run("b", &["--seed", "1"]);
    let all = ["a", "b", "--samples", "8"];
    let both = robustness(&bench, &all);
    let runs = both["runs"].as_array().unwrap();
    let (least, p50) = (&runs[0]["least"], &runs[0]["p50"]);
    assert!(least.as_f64().unwrap() < p50.as_f64().unwrap());
    assert_eq!(
        runs[0]["nominal"],
        bench.json("a/summary.json")["displacement_along"]
    );
    // The second run's row does not depend on the first.
    assert_eq!(
        robustness(&bench, &["b", "--samples", "8"])["runs"][0],
        runs[1]
    );
    let other = robustness(&bench, &[&all[..], &["--seed", "1"]].concat());
    assert_ne!(other["runs"][0]["p50"], *p50);
    let exact = ["--start", "0", "--stiffness", "0", "--mass", "0"];
    let exact = &robustness(&bench, &[&all[..], &exact].concat())["runs"][0];
    assert_eq!(exact["least"], exact["nominal"]);
    let table = bench.cosmic(&["robustness", "a", "b"]);
    assert_eq!((table.code, table.out.lines().count()), (0, 3));
    assert_eq!(bench.cosmic(&["robustness", "a", "--mass", "1.5"]).code, 2);
    let said = bench.cosmic(&["robustness", "nowhere"]);
    assert!(said.code == 4 && said.error.contains("nowhere"), "{said:?}");
}

#[test]
fn every_task_runs_and_tells_its_loss() {
    let plain = Bench::new(24, 64);
    plain.run("a", &[]);
    assert!(plain.json("a/summary.json")["loss_p50"].is_null());
    for task in ["reach", "climb", "back", "economy"] {
        let bench = bench("", &format!("[objective]\ntask = \"{task}\"\n"));
        let said = bench.run("a", &[]);
        assert!(said.out.contains("\nloss "), "{}", said.out);
        let summary = bench.json("a/summary.json");
        assert!(summary["loss_p50"].is_number());
        assert!(summary["departures"].to_string().contains("objective.task"));
        assert_ne!(bench.json("a/design.json"), plain.json("a/design.json"));
        // The plain design at this task.
        let other = plain.path("a");
        let runs = [other.to_str().unwrap(), "a", "--scene", &bench.scene];
        let both = robustness(&bench, &[&runs[..], &["--samples", "8"]].concat());
        let loss = |k: usize| both["runs"][k]["loss"].as_f64().unwrap();
        assert!(loss(0) != loss(1), "{both}");
    }
}

#[test]
fn a_run_of_richer_physics_is_resumed_and_checked_like_any_other() {
    let physics = "bending_radius = 0.02\nstiffening = 500.0";
    let bench = bench(physics, "");
    bench.run("a", &[]);
    let said = bench.cosmic(&["evaluate", "a/design.json"]);
    let evaluated: Value = serde_json::from_str(&said.out).unwrap();
    let summary = bench.json("a/summary.json");
    assert_eq!(
        evaluated["results"]["displacement"],
        summary["displacement_along"]
    );
    let said = bench.cosmic(&["explain", &bench.scene]);
    assert!(said.out.contains("bars in line resist bending"), "{said:?}");
    let said = bench.cosmic(&["gradcheck", &bench.scene, "--steps", "32"]);
    assert_eq!(said.code, 0, "{said:?}");
}
