//! `cosmic optimize`: the numbers in the files of a run, its seeds and its starts.

use crate::common::Bench;
use crate::program::has;
use cosmic::record::run::read_summary;
use cosmic::record::{DesignFile, Summary, TrajectoryFile};
use serde_json::Value;

#[test]
fn the_summary_has_the_promised_keys_and_agrees_with_the_other_files() {
    let bench = Bench::default();
    bench.run("a", "--seed 7");
    let summary = bench.json("a/summary.json");
    let numbers = [
        "displacement_along",
        "displacement_p10",
        "displacement_p50",
        "displacement_p90",
        "displacement_last_p50",
        "V",
        "V_act",
        "seed",
        "seconds",
    ];
    for key in numbers {
        assert!(summary[key].is_number(), "{key}");
    }
    assert_eq!(summary["seed"], 7);
    assert_eq!(summary["cosmic_version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(summary["stop_reason"], "finished");

    let Summary {
        displacement,
        volume,
        actuator_volume,
        ..
    } = read_summary(&bench.path("a")).unwrap();
    let design = DesignFile::read(&bench.path("a/design.json")).unwrap();
    assert!(design.design().layout().is_some());
    assert_eq!(design.edges.len(), 20);
    let share = |least: u8| {
        let solid = |m: &&_| u8::from(**m) >= least;
        design.materials.iter().filter(solid).count() as f64 / 20.0
    };
    assert_eq!([volume, actuator_volume], [share(1), share(2)]);
    // After widening, the volume bounds are 0.47 to 0.53 and 0.17 to 0.25, up to rounding.
    assert!((0.47..=0.53).contains(&volume) && (0.17..=0.25 + 1e-12).contains(&actuator_volume));

    let text = bench.read("a/trajectory.json");
    let trajectory: TrajectoryFile = serde_json::from_str(&text).unwrap();
    assert_eq!(trajectory.steps, [0, 16, 32, 48, 64]);
    let moved = |k: usize| trajectory.states[4].x[0][k] - trajectory.states[0].x[0][k];
    // The summary's displacements are computed in the frame of the ground, which is shifted by 0.1 m. So numbers of
    // about 0.5 are rounded twice.
    assert!((0..2).all(|k| (moved(k) - displacement[k]).abs() < 4.0 * f64::EPSILON));
    // The folder of a run stands for the run's design.
    let by_folder = bench.cosmic("evaluate a").json();
    assert_eq!(by_folder["results"], bench.evaluated("a"));
}

#[test]
fn the_results_of_a_seed_do_not_depend_on_the_number_of_threads() {
    let bench = Bench::default();
    bench.run("a", "--threads 1");
    for threads in ["2", "5"] {
        bench.run(threads, &format!("--threads {threads}"));
        assert_eq!(bench.results("a"), bench.results(threads));
    }
    bench.run("other", "--seed 1");
    assert_ne!(bench.read("a/design.json"), bench.read("other/design.json"));
}

#[test]
fn the_robot_of_an_unfinished_run_is_undecided() {
    let bench = Bench::default();
    bench.run("whole", "");
    bench.unfinished("part", 15);
    let said = bench.ok("resume part");
    let summary = bench.json("part/summary.json");
    assert_eq!(summary["iterations"], 15);
    assert_eq!(summary["stop_reason"], "iteration_limit");
    let [whole, part] = ["whole", "part"].map(|run| bench.results(run));
    assert!(whole["history.jsonl"].starts_with(&part["history.jsonl"]));
    // The run ended before the snap, so its design is the undecided one of the last iteration.
    let volume = bench.evaluated("part")["V"].as_f64().unwrap();
    // The two volumes are means over 20 edges, which were added in different orders.
    assert!((volume - summary["V"].as_f64().unwrap()).abs() < 1e-15);

    // The design has no bars yet, so there are no counts and no loads.
    assert_eq!(summary["undecided"], true);
    for nothing in ["structure", "loads"] {
        let value = summary.get(nothing).expect("the key is there");
        assert!(value.is_null(), "{value}");
    }
    has(
        &bench.ok("export part --csv").error,
        &["the design is undecided"],
    );
    bench.ok("report part");
    let page = bench.read("part/report.html");
    let compared = bench.ok("report part whole").out;
    for text in [&said.out, &page, &compared] {
        has(text, &["undecided"]);
        for wrong in ["0 pieces", "0.00 N", "No edge is an actuator"] {
            assert!(!text.contains(wrong), "{wrong}");
        }
    }
    let decided = bench.json("whole/summary.json");
    assert_eq!(decided["undecided"], false);
    assert!(decided["structure"]["pieces"].as_u64() > Some(0));
}

#[test]
fn of_several_starts_the_best_is_kept() {
    let bench = Bench::default();
    let several = "--starts 3 --seed 2";
    bench.run("all", several);
    for threads in ["1", "7"] {
        bench.run(threads, &format!("{several} --threads {threads}"));
        assert_eq!(bench.results(threads), bench.results("all"));
    }
    let summary = bench.json("all/summary.json");
    let starts = summary["starts"].as_array().unwrap();
    assert!((2..5).eq(starts.iter().map(|start| start["seed"].as_u64().unwrap())));
    let median = |start: &Value| start["displacement_selection_p50"].as_f64().unwrap();
    let best = starts
        .iter()
        .max_by(|a, b| median(a).total_cmp(&median(b)))
        .unwrap();
    assert_eq!(summary["seed"], best["seed"]);
    let quoted = "displacement_robust_p50";
    assert_eq!(summary[quoted], best[quoted]);
    // The robot is chosen by its median over some perturbed starts. The published median is over other perturbed
    // starts.
    assert_ne!(best[quoted], best["displacement_selection_p50"]);
    let seed = best["seed"].to_string();
    bench.run("alone", &format!("--seed {seed}"));
    let [all, alone] = ["all", "alone"].map(|run| bench.results(run));
    for (name, bytes) in alone {
        assert_eq!(all[&format!("starts/{seed}/{name}")], bytes, "{name}");
        assert!(all[&name] == bytes || name == "summary.json");
    }
    let too_many = bench.optimize("no", &format!("--starts 2 --seed {}", u64::MAX));
    too_many.fails(2, &[]);
    let too_many = bench.optimize("no", "--starts 99999999999");
    too_many.fails(2, &["at most 1000000"]);
    assert!(!bench.path("no").exists());
}
