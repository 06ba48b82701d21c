//! `cosmic optimize`: the run's folder, the output and the exit codes.

use crate::common::Bench;
use crate::program::has;
use cosmic::Registry;
use cosmic::record::run::read_summary;
use cosmic::record::{DesignFile, Summary, TrajectoryFile};
use serde_json::Value;

#[test]
fn a_run_writes_every_file_and_each_begins_with_its_format() {
    let bench = Bench::finished();
    let mut names: Vec<_> = bench.results("a").into_keys().collect();
    names.push("snapshot.json".to_string());
    names.sort();
    let expected = [
        "design.json",
        "designs.jsonl",
        "history.jsonl",
        "scene.toml",
        "snapshot.json",
        "summary.json",
        "trajectory.json",
    ];
    assert_eq!(names, expected);
    for name in names.iter().filter(|name| name.contains(".json")) {
        let text = bench.read(&format!("a/{name}"));
        let kind = name.split('.').next().unwrap();
        let stamp = format!("{{\"format\":\"cosmic-{kind}\",\"version\":1,");
        assert!(text.lines().all(|line| line.starts_with(&stamp)), "{name}");
    }
    let shown = bench.cosmic("scene show tiny.toml").out;
    let kept = bench.read("a/scene.toml");
    let stamp = "\nformat = \"cosmic-scene\"\nversion = 1\n";
    assert!(kept.contains(stamp) && kept.ends_with(&shown), "{kept}");
}

#[test]
fn the_history_has_a_row_per_iteration() {
    let bench = Bench::finished();
    let rows = bench.rows("a/history.jsonl");
    assert!((1..=24).eq(rows.iter().map(|row| row["iteration"].as_u64().unwrap())));
    let phases: Vec<_> = rows
        .iter()
        .map(|row| row["phase"].as_str().unwrap())
        .collect();
    assert_eq!(phases[..12], ["co_design"; 12]);
    assert_eq!(phases[12..18], ["attraction"; 6]);
    assert_eq!(phases[18], "snap");
    assert_eq!(phases[19..], ["fine_tuning"; 5]);
    let seconds: Vec<_> = rows
        .iter()
        .map(|row| row["seconds"].as_f64().unwrap())
        .collect();
    assert!(seconds.is_sorted() && seconds[0] > 0.0);
}

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
    } = read_summary(&bench.path("a"), &Registry::default()).unwrap();
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
fn optimize_prints_its_progress_and_its_result() {
    let bench = Bench::default();
    let said = bench.ok("optimize tiny.toml --seed 3");
    assert!(said.out.starts_with("run: runs/tiny-3\n"), "{}", said.out);
    let last = said.out.lines().last().unwrap();
    has(
        last,
        &["displacement ", " m (", " V 0.", " V_act 0.", " time "],
    );
    let lines: Vec<_> = said.error.lines().collect();
    let expected = [
        "robot: 3x3, 9 nodes, 20 edges; ",
        "world: gravity 4.8 m/s²; ",
        "cost: 64 steps a rollout, about ",
        "warning: a rollout lasts 0.128 s, ",
        "co-design: bars, materials and controller change together; ",
        "tiny seed 3  10/24  co design  ",
        "attraction: every bar moves towards one material; ",
        "fine-tuning: every bar has one material now, ",
        "tiny seed 3  20/24  fine tuning  ",
        "tiny seed 3  24/24  fine tuning  ",
        "next: cosmic report runs/tiny-3 ",
        "      cosmic robustness runs/tiny-3 ",
        "      cosmic optimize workshop ",
    ];
    assert_eq!(lines.len(), expected.len(), "{}", said.error);
    for (line, expected) in lines.iter().zip(expected) {
        assert!(line.starts_with(expected), "{}", said.error);
    }
    // A distance before the snap is not that of a robot that can be built.
    assert!(lines[5].contains(" m (undecided)  V "), "{}", lines[5]);
    assert!(!lines[8].contains("undecided") && lines[9].ends_with("0:00 left"));
    assert!(
        !bench
            .run(
                "parts",
                "--set parts.skeleton=tube --set physics.integrator=implicit"
            )
            .error
            .contains("workshop")
    );

    let quiet = bench.run("quiet", "--quiet");
    assert!(quiet.out.is_empty() && quiet.error.is_empty());
    let json = bench.run("json", "--json --quiet");
    assert_eq!(json.out, bench.read("json/summary.json"));
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

/// `--iterations` fits the phases into a run, so that the shortest run ends with a layout. The scene in the folder has the
/// fitted numbers, so a run by this scene is the same, and so is one cell of a sweep.
#[test]
fn a_short_run_ends_with_a_robot() {
    let bench = Bench::default();
    for iterations in [1, 2, 3, 5, 12] {
        let run = format!("short-{iterations}");
        let said = bench.run(&run, &format!("--iterations {iterations}"));
        assert!(!said.error.contains("no effect"), "{said:?}");
        let summary = bench.json(&format!("{run}/summary.json"));
        assert_eq!(summary["iterations"], iterations);
        assert_eq!(summary["stop_reason"], "finished");
        assert_eq!(summary["undecided"], false);
        assert!(summary["structure"]["pieces"].as_u64() > Some(0));
        let design = bench.json(&format!("{run}/design.json"));
        let materials = design["materials"].as_array().unwrap();
        assert!(materials.iter().any(|material| *material != 0), "{design}");
    }
    bench.ok("report short-1");
    // The numbers of the fitted schedule are in the scene of the run. Other files name the scene.
    let robot = |run: &str| {
        let mut files = bench.results(run);
        ["design.json", "trajectory.json"].map(|name| files.remove(name).expect(name))
    };
    bench.ok("optimize short-12/scene.toml --out again");
    assert!(robot("again") == robot("short-12"));
    bench.ok("sweep run tiny.toml --iterations 12 --out s");
    assert!(robot("s/runs/tiny-0") == robot("short-12"));
    // The scene's own number changes nothing.
    bench.run("whole", "");
    bench.run("own", "--iterations 24");
    assert_eq!(bench.results("own"), bench.results("whole"));
    let said = bench.optimize("many", "--iterations 100001");
    said.fails(2, &["100001 iterations", "from 1 to 1e5"]);
    assert!(!bench.path("many").exists());
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
