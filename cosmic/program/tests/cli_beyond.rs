//! Options that go beyond the paper: robust designs, other tasks and richer physics.

use crate::common::{Bench, scene};
use crate::program::has;
use cosmic::scene::{Named, TaskKind};

/// Makes a test folder with the small scene. `physics` is added to the scene's section `[physics]`, and `more` is added
/// at the end of the scene.
fn bench(physics: &str, more: &str) -> Bench {
    Bench::with(&(scene(24, 64, physics) + more))
}

#[test]
fn a_robust_design_differs_from_the_nominal_one_and_is_reproducible() {
    let bench = bench("contact = \"coulomb\"", "[robust]\nsamples = 2\n");
    bench.run("a", "");
    bench.run("b", "--threads 3");
    assert_eq!(bench.results("a"), bench.results("b"));
    let nominal = Bench::with(&scene(24, 64, "contact = \"coulomb\""));
    nominal.run("a", "");
    assert_ne!(bench.json("a/design.json"), nominal.json("a/design.json"));
}

#[test]
fn every_task_runs_and_reports_its_loss() {
    let plain = Bench::default();
    plain.run("a", "");
    assert!(plain.json("a/summary.json")["loss_p50"].is_null());
    for (task, _) in TaskKind::ALL
        .iter()
        .filter(|(_, task)| *task != TaskKind::Far)
    {
        let bench = bench("", &format!("[objective]\ntask = \"{task}\"\n"));
        let said = bench.run("a", "");
        has(&said.out, &["\nloss "]);
        let summary = bench.json("a/summary.json");
        assert!(summary["loss_p50"].is_number());
        assert_ne!(bench.json("a/design.json"), plain.json("a/design.json"));
        // Both designs are simulated with this scene's task. Only one of them was optimised for it, so the losses
        // differ.
        let other = plain.path("a").display().to_string();
        let line = format!("robustness {other} a --scene tiny.toml --samples 8 --json");
        let both = bench.cosmic(&line).json();
        let loss = |k: usize| both["runs"][k]["loss"].as_f64().unwrap();
        assert!(loss(0) != loss(1), "{both}");
    }
}

#[test]
fn a_run_of_richer_physics_is_resumed_and_checked_like_any_other() {
    let physics = "integrator = \"leapfrog\"\nforces = [\"damper\"]";
    let bench = bench(physics, "[damper]\ntime = 1e-5\n");
    bench.run("a", "");
    bench.evaluated("a");
    bench.ok("check tiny.toml --steps 32");
}
