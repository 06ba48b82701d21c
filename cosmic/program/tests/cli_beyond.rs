//! Options beyond the paper from the command line: robust designs, other tasks, richer physics.

use crate::common::{Bench, scene};
use serde_json::Value;
use std::fs;

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
    let bench = Bench::default();
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
    for (file, begins) in [
        ("r.json", "{\"format\":\"cosmic-robustness\""),
        ("r.csv", "run,nominal,"),
    ] {
        let said = bench.cosmic(&["robustness", "a", "--samples", "2", "--out", file]);
        assert_eq!((said.code, said.out.lines().count()), (0, 2), "{said:?}");
        let text = fs::read_to_string(bench.path(file)).unwrap();
        assert!(text.starts_with(begins), "{text}");
    }
    assert_eq!(bench.cosmic(&["robustness", "a", "--mass", "1.5"]).code, 2);
    let said = bench.cosmic(&["robustness", "nowhere"]);
    assert!(said.code == 4 && said.error.contains("nowhere"), "{said:?}");
}

#[test]
fn every_task_runs_and_tells_its_loss() {
    let plain = Bench::default();
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

/// A robot that nothing moves, in time steps beyond the stable one: within eight of them vibrations
/// of a millimetre grow beyond all bounds, those of a rounding error to another millimetre.
fn house_of_cards() -> Bench {
    let physics = "dt = 0.01\ngravity = 0.0\ncontact = \"none\"\nunstable_step = \"warn\"";
    let still = "[materials]\nmax_strain = [0.0, 0.0, 0.0]\n[selection]\nperturbation = 1e-3\n";
    let scene = scene(24, 8, physics).replace("window = 16\nevery = 4", "window = 4\nevery = 2");
    Bench::with(&(scene + still))
}

#[test]
fn a_median_that_diverged_is_told_and_ends_with_3() {
    let bench = house_of_cards();
    for (run, options) in [
        ("a", &[][..]),
        ("b", &["--json"]),
        ("c", &["--starts", "2"]),
    ] {
        let said = bench.optimize(run, options);
        assert_eq!(said.code, 3, "{said:?}");
        let says = format!(
            "error: {run}: no displacement to quote: the delivered design diverges from perturbed \
             starts, though not from its own (displacement_p50 is null in summary.json)"
        );
        assert_eq!(said.error.lines().last().unwrap(), says);
        let summary = bench.json(&format!("{run}/summary.json"));
        assert!(summary["displacement_p50"].is_null());
        assert!(summary["displacement_along"].is_number());
        assert!(!said.out.is_empty());
    }
    // A finished run is left as it is.
    let said = bench.cosmic(&["resume", "a"]);
    assert_eq!(said.code, 0, "{said:?}");
    assert!(said.out.contains("displacement diverged"), "{said:?}");
    fs::remove_file(bench.path("a/summary.json")).unwrap();
    assert_eq!(bench.cosmic(&["resume", "a"]).code, 3);
}

#[test]
fn robustness_says_where_the_nominal_robot_diverges() {
    let bench = Bench::default();
    bench.run("a", &[]);
    let wild = scene(24, 64, "dt = 0.5");
    fs::write(bench.path("wild.toml"), wild).unwrap();
    let own = bench.cosmic(&["evaluate", "a"]);
    assert_eq!(own.code, 0);
    let trial = ["robustness", "a", "--samples", "8", "--scene", "wild.toml"];
    let said = bench.cosmic(&trial);
    assert_eq!(said.code, 3, "{said:?}");
    assert!(
        said.out.lines().count() == 2 && said.out.contains("diverged"),
        "{said:?}"
    );
    fs::copy(bench.path("wild.toml"), bench.path("a/scene.toml")).unwrap();
    let evaluated = bench.cosmic(&["evaluate", "a"]);
    let (_, place) = evaluated.error.rsplit_once("error: ").unwrap();
    assert!(place.starts_with("diverged in step "), "{place}");
    assert_eq!(said.error, format!("error: a: the nominal robot {place}"));
    let said = bench.cosmic(&[&trial[..], &["--json"]].concat());
    let json: Value = serde_json::from_str(&said.out).unwrap();
    assert!(said.code == 3 && json["runs"][0]["nominal"].is_null());
}
