//! Options that go beyond the paper: robust designs, other tasks and richer physics.

use crate::common::{Bench, scene};
use crate::program::has;
use cosmic::scene::{Named, TaskKind};
use serde_json::Value;
use std::fs;

/// Makes a test folder with the small scene. `physics` is added to the scene's section `[physics]`, and `more` is added
/// at the end of the scene.
fn bench(physics: &str, more: &str) -> Bench {
    Bench::with(&(scene(24, 64, physics) + more))
}

/// Runs `cosmic robustness` and returns its JSON.
fn robustness(bench: &Bench, line: &str) -> Value {
    bench.cosmic(&format!("robustness --json {line}")).json()
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
fn robustness_compares_runs_under_the_same_random_draws() {
    let bench = Bench::finished();
    bench.run("b", "--seed 1");
    let both = robustness(&bench, "a b --samples 8");
    let runs = both["runs"].as_array().unwrap();
    let (least, p50) = (&runs[0]["least"], &runs[0]["p50"]);
    assert!(least.as_f64().unwrap() < p50.as_f64().unwrap());
    let along = &bench.json("a/summary.json")["displacement_along"];
    assert_eq!(runs[0]["nominal"], *along);
    // The results of run `b` are the same without run `a`.
    let second = robustness(&bench, "b --samples 8");
    assert_eq!(second["runs"][0], runs[1]);
    let other = robustness(&bench, "a b --samples 8 --seed 1");
    assert_ne!(other["runs"][0]["p50"], *p50);
    let exact = robustness(&bench, "a --samples 8 --start 0 --stiffness 0 --mass 0");
    let exact = &exact["runs"][0];
    assert_eq!(exact["least"], exact["nominal"]);
    let table = bench.ok("robustness a b");
    assert_eq!(table.out.lines().count(), 3);
    bench.fails("robustness a --mass 1.5", 2, &[]);
    bench.fails("robustness nowhere", 4, &["nowhere"]);
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
        let both = robustness(&bench, &format!("{other} a --scene tiny.toml --samples 8"));
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

/// A scene for a robot that stays at rest although its time step is unstable. In eight steps, perturbations of a
/// millimetre grow until the rollout diverges, but rounding errors grow only to a millimetre. So rollouts from
/// perturbed starts diverge, and the rollout from the exact start does not.
fn house_of_cards() -> Bench {
    let physics = "dt = 0.01\ngravity = 0.0\ncontact = \"none\"\nunstable_step = \"warn\"";
    let still = "[materials]\nmax_strain = [0.0, 0.0, 0.0]\n";
    let scene = scene(24, 8, physics).replace("window = 16\nevery = 4", "window = 4\nevery = 2");
    Bench::with(&(scene + still))
}

#[test]
fn a_run_whose_median_diverged_says_so_and_exits_with_3() {
    let bench = house_of_cards();
    for (run, options) in [("a", ""), ("b", "--json"), ("c", "--starts 2")] {
        let said = bench.optimize(run, options);
        said.fails(3, &[]);
        let says = format!(
            "error: {run}: there is no median displacement: the final robot walks as designed, but robots that vary a \
             little diverge (displacement_robust_p50 is null in summary.json)"
        );
        assert_eq!(said.error.lines().last().unwrap(), says);
        let summary = bench.json(&format!("{run}/summary.json"));
        assert!(summary["displacement_robust_p50"].is_null());
        assert!(summary["displacement_along"].is_number());
        assert!(!said.out.is_empty());
    }
    // The run is finished, so `resume` leaves it as it is.
    let said = bench.ok("resume a");
    has(&said.out, &["displacement diverged"]);
    bench.remove("a/summary.json");
    bench.fails("resume a", 3, &[]);
}

#[test]
fn robustness_says_where_the_nominal_robot_diverges() {
    let bench = Bench::finished();
    let wild = scene(24, 64, "dt = 0.5");
    bench.write("wild.toml", wild);
    bench.ok("evaluate a");
    let trial = "robustness a --samples 8 --scene wild.toml";
    let said = bench.cosmic(trial);
    said.fails(3, &[]);
    assert_eq!(said.out.lines().count(), 2, "{said:?}");
    has(&said.out, &["diverged"]);
    fs::create_dir(bench.path("w")).unwrap();
    fs::copy(bench.path("a/design.json"), bench.path("w/design.json")).unwrap();
    bench.write("w/scene.toml", bench.cosmic("scene show wild.toml").out);
    let evaluated = bench.cosmic("evaluate w");
    let (_, place) = evaluated.error.rsplit_once("error: ").unwrap();
    assert!(place.starts_with("diverged in step "), "{place}");
    assert_eq!(said.error, format!("error: a: the nominal robot {place}"));
    let said = bench.cosmic(&format!("{trial} --json"));
    let json: Value = serde_json::from_str(&said.out).unwrap();
    assert!(said.code == 3 && json["runs"][0]["nominal"].is_null());
}

/// If there are too many bars to count floppy modes, the program says so.
#[test]
fn floppy_modes_that_are_not_counted_are_reported_as_such() {
    let bench = Bench::finished();
    let counted = bench.json("a/summary.json")["structure"]["floppy_modes"].as_u64();
    let counted = format!("\"floppy_modes\":{}", counted.expect("a number"));
    let text = bench.read("a/summary.json");
    has(&text, &[&counted]);
    bench.write(
        "a/summary.json",
        text.replace(&counted, "\"floppy_modes\":null"),
    );
    let told = bench.ok("resume a").out;
    let says = "floppy modes not counted (more than 2000 bars)";
    has(&told, &[says]);
    bench.ok("report a a");
}
