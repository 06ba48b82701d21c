//! `cosmic study` with small robots: results, interruptions, added seeds, and studies that users write.
#![cfg(unix)]

use crate::background::signal;
use crate::common::Bench;
use crate::program::{Told, has};
use cosmic::scene::Scene;
use serde_json::Value;
use std::fs;

/// Settings that give every scene a robot of 3x3 nodes.
const LITTLE: &str = "[lattice]\ncolumns = 3\nrows = 3\n[physics]\nsteps = 64\n\
    [controller]\nhidden = 4\n[volume]\nwidening_over = [4, 6]\n\
    [schedule]\niterations = 20\nattraction_from = 8\nsnap_at = 14\nhorizon = [32, 64]\n\
    [binarisation]\nthreshold_over = [1, 12]\n[loss]\nwindow = 16\nevery = 4\n";

/// Settings for short runs. They keep the lattices of the scenes, because some layouts need them.
const SHORT: &str = "[physics]\nsteps = 64\n[controller]\nhidden = 2\n\
    [schedule]\nhorizon = [16, 32]\n[loss]\nwindow = 16\n";

/// Makes a test folder with settings for a study in `base.toml`.
fn bench(base: &str) -> Bench {
    let bench = Bench::default();
    bench.write("base.toml", base);
    bench
}

/// The command line of a study that writes its results to the folder `NAME` and its runs to `NAME-runs`.
fn line(kind: &str, name: &str, more: &str) -> String {
    format!("study {kind} --base base.toml --out {name} --runs {name}-runs {more}")
}

fn study(bench: &Bench, kind: &str, name: &str, more: &str) -> Told {
    bench.cosmic(&line(kind, name, more))
}

/// Counts the lines that report the end of a run.
fn ended(said: &Told) -> usize {
    let lines = said.error.lines();
    lines.filter(|line| !line.starts_with("warning: ")).count()
}

#[test]
fn an_ablation_has_its_document_tables_and_figures() {
    let bench = bench(LITTLE);
    let said = study(&bench, "ablation", "a", "--seeds 2").ok();
    // The program printed a line for each run, and a line for each file: nine figures, a document and two tables.
    let lines = [ended(&said), said.out.lines().count()];
    assert_eq!(lines, [16, 12], "{said:?}");
    let document = bench.read("a/ablation.md");
    let command = "cosmic study ablation --first-seed 0 --seeds 2 --base base.toml";
    for (what, count) in [
        (&*format!("```sh\n{command}\n```"), 1),
        ("\n| h, all three | 1.91 |", 1),
        ("\n| Does ", 4),
        ("\n| What does ", 3),
        ("\n## Errands", 0),
        ("NaN", 0),
    ] {
        assert_eq!(document.matches(what).count(), count, "{what}: {document}");
    }
    let linked = document.matches("](ablation/").count();
    let figures = fs::read_dir(bench.path("a/ablation")).unwrap().count();
    assert_eq!((linked, figures), (9, 9));
    let json = bench.json("a/ablation.json");
    assert_eq!(json["format"], "cosmic-study");
    for row in json["tables"][0]["rows"].as_array().unwrap() {
        assert_eq!([&row["one-hot"], &row["runs"]], [2.0, 2.0], "{row}");
        assert!(row["dt/2"].is_number(), "{row}");
    }
    assert_eq!(bench.lines("a/ablation.csv"), 17);
    what_is_held_does_not_move(&bench);
}

/// Compares trials of the ablation: a trial that keeps the initial weights, or the materials of the start, must not
/// change them.
fn what_is_held_does_not_move(bench: &Bench) {
    let design = |trial: &str| bench.json(&format!("a-runs/runs/{trial}-0/design.json"));
    let [none, topology, material, all] =
        ["none", "topology", "topology-material", "all"].map(design);
    assert_eq!(none["controller"], topology["controller"]);
    assert_eq!(none["controller"], material["controller"]);
    assert_ne!(none["controller"], all["controller"]);
    let materials = |design: &Value| -> Vec<u64> {
        let materials = design["materials"].as_array().unwrap().iter();
        materials.map(|m| m.as_u64().unwrap()).collect()
    };
    let filled = materials(&none);
    assert!(!filled.contains(&0));
    let held = materials(&design("topology-control"));
    let kept = |(own, held): (&u64, &u64)| *held == 0 || held == own;
    assert!(filled.iter().zip(&held).all(kept), "{held:?}");
    assert!(held.contains(&0), "{held:?}");
    let solid = materials(&design("material-control"));
    // The volume must be at least 0.90, minus the widening of 0.03. So at least 17.4 of the 20 edges are solid.
    assert!(solid.iter().filter(|m| **m > 0).count() >= 18, "{solid:?}");
}

#[test]
fn runs_that_diverge_are_reported_and_counted() {
    let unstable = "steps = 64\ndt = 1.0\nunstable_step = \"warn\"";
    let bench = bench(&LITTLE.replace("steps = 64", unstable));
    study(&bench, "ablation", "a", "--seeds 1").ok();
    let document = bench.read("a/ablation.md");
    for (what, count) in [("unknown: runs diverged", 8), ("NaN", 0), ("inf ", 0)] {
        assert_eq!(document.matches(what).count(), count, "{what}: {document}");
    }
    let json = bench.json("a/ablation.json");
    for row in json["tables"][0]["rows"].as_array().unwrap() {
        assert_eq!([&row["diverged"], &row["one-hot"]], [1.0, 0.0], "{row}");
        assert!(row["median"].is_null(), "{row}");
    }
}

#[test]
fn threads_and_interruptions_change_nothing() {
    let bench = bench(&LITTLE.replace("steps = 64", "steps = 256"));
    study(&bench, "ablation", "whole", "--seeds 2 --threads 1").ok();
    let cut = line("ablation", "cut", "--seeds 2 --threads 2");
    let child = bench.start(&cut);
    bench.await_lines("cut-runs/runs/topology-0/history.jsonl", 0);
    signal(&child, "TERM");
    let told = Told::of(child.wait_with_output().unwrap());
    told.fails(
        75,
        &["of 16 runs done; repeat the same command to continue\n"],
    );
    // The folder was checked before the first run and is still empty.
    assert_eq!(fs::read_dir(bench.path("cut")).unwrap().count(), 0);
    let said = bench.ok(&cut);
    assert!(ended(&said) < 16, "{said:?}");
    assert_eq!(bench.results("cut"), bench.results("whole"));
}

#[test]
fn more_seeds_join_and_other_scenes_do_not() {
    let bench = Bench::default();
    bench.write("grounds.toml", OWN);
    let grounds = |name: &str, more: &str| {
        let line = format!("study grounds.toml --out {name} --runs {name}-runs {more}");
        bench.cosmic(&line)
    };
    grounds("a", "--iterations 2 --seeds 1 --first-seed 1").ok();
    has(
        &bench.read("a/grounds.md"),
        &["undecided: one seed gives no standard error"],
    );
    let said = grounds("a", "--iterations 2").ok();
    assert_eq!(ended(&said), 4, "{said:?}");
    grounds("b", "--iterations 2").ok();
    assert_eq!(bench.results("a"), bench.results("b"));
    let says = [
        "iterations=2 in the existing results",
        "another folder with --out",
    ];
    grounds("a", "").fails(2, &says);
    let refused = |base: &str, says: &str| {
        bench.write("base.toml", base);
        study(&bench, "findings", "c", "").fails(2, &[says]);
    };
    refused("[physics]\nsteps = 0", "base.toml:2:9");
    // These settings are valid by themselves, but do not fit the scenes of the study.
    let says = "error: the settings of base.toml do not fit those of the study: the three-legged";
    refused("[lattice]\ncolumns = 2\n", says);
    assert!(!bench.path("c-runs").exists());
}

/// By default, results are written to the folder of the runs. Existing results are replaced only if they have the same
/// settings.
#[test]
fn results_of_other_settings_are_not_replaced() {
    let bench = bench(SHORT);
    let command = "study ablation --base base.toml --threads 2 --quiet";
    let study = |more: &str| bench.cosmic(&format!("{command} {more}"));
    assert_eq!(study("--seeds 2 --iterations 2").ok().error, "");
    let results = "runs/study-ablation/ablation.json";
    let before = bench.read(results);
    assert!(!bench.path("docs").exists());
    let refused = |more: &str, says: &str| {
        study(more).fails(2, &[says, "another folder with --out"]);
        assert_eq!(bench.read(results), before);
    };
    refused(
        "--seeds 1 --iterations 2",
        "seeds: 0 to 1 in the existing results, but 0 to 0 in this study",
    );
    let out = "--out runs/study-ablation --runs other --seeds 2 --iterations";
    refused(
        &format!("{out} 3"),
        "none: iterations=2 in the existing results, but iterations=3 in",
    );
    bench.write("base.toml", SHORT.replace("hidden = 2", "hidden = 3"));
    let says = "none: controller.hidden=2 in the existing results, but controller.hidden=3 in";
    refused(&format!("{out} 2"), says);
    assert!(!bench.path("other").exists());
}

#[test]
fn the_paper_s_study_has_two_tables_beside_the_paper_s_numbers() {
    let bench = bench(SHORT);
    study(&bench, "paper", "p", "--seeds 1 --iterations 2").ok();
    let document = bench.read("p/paper.md");
    // Both tables contain each of these lines.
    for line in ["| b, stability heuristic | 1.90 |", "| 5x5 nodes | 1.10 |"] {
        assert_eq!(document.matches(line).count(), 2, "{line}: {document}");
    }
    let (default, strict) = document
        .split_once("## Strictly by the paper")
        .expect("both");
    assert!(default.contains("## By default") && strict.contains("| A | loss.kind | the loss is"));
    assert_eq!(document.matches(" | none |\n").count(), 8, "{document}");
    let pictures = fs::read_dir(bench.path("p/paper")).unwrap().count();
    assert_eq!(document.matches(".svg)").count(), pictures);
}

/// Plans a study. Returns its trials, each with its name and its scene.
fn planned(bench: &Bench, study: &str) -> Vec<(String, Scene)> {
    // The command `true` plays the part of a Python that has MuJoCo.
    let line = format!("study {study} --plan {study} --python true");
    bench.ok(&line);
    let plan = bench.json(&format!("{study}/plan.json"));
    let scene = |planned: &Value| {
        let [name, text] = ["name", "scene"].map(|key| planned[key].as_str().unwrap());
        (name.to_owned(), Scene::parse(name, text).unwrap())
    };
    plan["scenes"]
        .as_array()
        .unwrap()
        .iter()
        .map(scene)
        .collect()
}

/// All trials of a study differ. In particular, the eight trials of the ablation cover all combinations. Planning also
/// checks that every trial can start.
#[test]
fn all_trials_differ() {
    let bench = Bench::default();
    for study in ["paper", "ablation", "findings", "transfer"] {
        let trials = planned(&bench, study);
        for (k, (name, scene)) in trials.iter().enumerate() {
            let same = |(_, other): &(String, Scene)| other == scene;
            assert!(!trials[..k].iter().any(same), "{name}");
            if let Some(builtin) = name.strip_prefix("default-") {
                assert_eq!(*scene, Scene::load(builtin).unwrap());
            }
        }
    }
}

/// A study as a user may write it: two scenes and two kinds of friction, compared with published numbers.
const OWN: &str = "title = 'Two grounds'
seeds = 2
[[variants]]
name = 'firm'
[[variants]]
name = 'slippery'
settings.physics = { contact = 'coulomb', friction = 0.6 }
[[trials]]
name = 'light'
scene = 'tiny.toml'
paper = 1.0
[[trials]]
name = 'heavy'
scene = 'tiny.toml'
settings.physics.gravity = 9.81
[[questions]]
ask = 'What does friction change?'
from = ['slippery-light', 'slippery-heavy']
to = ['firm-light', 'firm-heavy']
";

#[test]
fn a_study_of_the_user_is_a_file() {
    let bench = Bench::default();
    bench.write("grounds.toml", OWN);
    let said = bench.ok("study grounds.toml --quiet");
    assert_eq!(said.out, "");
    let folder = "runs/study-grounds";
    assert_eq!(bench.lines(&format!("{folder}/grounds.csv")), 1 + 8);
    let document = bench.read(&format!("{folder}/grounds.md"));
    has(
        &document,
        &[
            "# Two grounds\n",
            "| slippery-heavy | – |",
            "| What does friction change? |",
        ],
    );
    // If a trial is added, the runs of the other trials are kept.
    let more = "[[trials]]\nname = 'jelly'\nscene = 'tiny.toml'\nsettings.physics.damping = 60.0\n";
    bench.write("grounds.toml", format!("{OWN}{more}"));
    let said = bench.ok("study grounds.toml");
    assert_eq!(ended(&said), 4, "{said:?}");
    bench.write("grounds.toml", OWN.replace("9.81", "3.7"));
    let says = "heavy: physics.gravity=9.81 in the existing results, but physics.gravity=3.7 in";
    bench.fails("study grounds.toml", 2, &[says]);
}

/// Trials whose goals are given, trials with a fixed goal, and a run that diverges.
const TOLD: &str = "[[trials]]
scene = 'tiny.toml'
[[trials]]
scene = 'goals.toml'
[[trials]]
name = 'wild'
scene = 'goals.toml'
settings.physics.speed_bound = 1e-3
";

#[test]
fn robots_with_given_goals_are_sent_on_errands() {
    let bench = Bench::default();
    let lattice = "lattice = { columns = 3, rows = 2, payload = 1 }";
    let goals = format!("base = 'errand'\n{lattice}\nphysics.steps = 64\n");
    bench.write("goals.toml", goals);
    bench.write("told.toml", TOLD);
    bench.ok("study told.toml --seeds 1 --iterations 1");
    let results = "runs/study-told/told";
    has(
        &bench.read(&format!("{results}.md")),
        &["\n## Errands\n", "\n| wild | a push | – | –"],
    );
    let csv = bench.read(&format!("{results}.csv"));
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    let [head, tiny, goals, wild] = &rows[..] else {
        panic!("{csv}")
    };
    let first = head.iter().position(|name| *name == "errand_p50").unwrap();
    assert!(
        tiny[first..]
            .iter()
            .chain(&wild[first..])
            .all(|cell| cell.is_empty())
    );
    // The table of a single seed has the numbers of its run: six for each disturbance.
    let json = bench.json(&format!("{results}.json"));
    let mut tables = json["tables"].as_array().unwrap().iter();
    let table = tables.find(|table| table["table"] == "errands").unwrap();
    let shown = table["rows"].as_array().unwrap();
    assert_eq!(shown.len(), 8);
    for (row, cells) in shown.iter().zip(goals[first..].chunks(6)) {
        assert_eq!(row["trial"], "goals");
        let columns = "median;75 %;ahead;behind;open loop;open loop, 75 %";
        for (column, cell) in columns.split(';').zip(cells) {
            assert_eq!(row[column].as_f64(), cell.parse().ok(), "{row}");
        }
    }
    let run = |trial: &str| format!("runs/study-told/runs/{trial}-0/errands.json");
    assert!(!bench.path(&run("tiny")).exists());
    are_quantiles(&goals[first..], &bench.json(&run("goals")));
}

/// Asserts that the numbers in the row of a run are quantiles of its errands.
fn are_quantiles(row: &[&str], errands: &Value) {
    let disturbances = ["undisturbed", "pushed", "rough", "lost"];
    for (disturbance, cells) in disturbances.iter().zip(row.chunks(6)) {
        let [closed, open] = ["closed", "open"].map(|loops| &errands[disturbance][loops]);
        let expected = [
            quantile(closed, |_| true, 0.5),
            quantile(closed, |_| true, 0.75),
            quantile(closed, |errand| errand["ahead"] == true, 0.5),
            quantile(closed, |errand| errand["ahead"] == false, 0.5),
            quantile(open, |_| true, 0.5),
            quantile(open, |_| true, 0.75),
        ];
        for (cell, expected) in cells.iter().zip(expected) {
            let found: f64 = cell.parse().unwrap();
            // Numbers of about 1 after a few operations.
            assert!(
                (found - expected).abs() < 1e-14,
                "{found} is not {expected}"
            );
        }
    }
}

/// A quantile of the ratios of the errands that count, from `errands.json`.
fn quantile(sequences: &Value, counts: fn(&Value) -> bool, q: f64) -> f64 {
    let sequences = sequences.as_array().unwrap().iter();
    let errands = sequences.flat_map(|sequence| sequence.as_array().unwrap());
    let errands = errands.filter(|errand| counts(errand));
    let mut ratios: Vec<f64> = errands.map(|e| e["ratio"].as_f64().unwrap()).collect();
    ratios.sort_by(f64::total_cmp);
    let at = q * (ratios.len() - 1) as f64;
    let [below, above] = [at.floor(), at.ceil()].map(|k| ratios[k as usize]);
    below + at.fract() * (above - below)
}

#[test]
fn a_malformed_file_of_a_study_is_refused_with_the_line_and_what_is_allowed() {
    let bench = Bench::default();
    for (from, to, says) in [
        (
            "seeds",
            "seds",
            ["unknown key `seds`", "grounds.toml:2:1", "`seeds`"],
        ),
        (
            "= 2",
            "= 0",
            [
                "invalid value",
                "grounds.toml:2:9",
                "a whole number from 1 on",
            ],
        ),
        (
            "'slippery-light'",
            "'slipery-light'",
            [
                "`questions[0].from[0]` is unknown",
                "grounds.toml:18:9",
                "`slippery-light`",
            ],
        ),
        (
            "gravity",
            "gravty",
            ["unknown key `gravty`", "grounds.toml:15:18", "`gravity`"],
        ),
        (
            "0.6",
            "-1",
            [
                "`physics.friction` is out of range: -1",
                "grounds.toml:7:",
                "allowed",
            ],
        ),
        (
            "seeds = 2",
            "mujoco = [9.0]",
            ["out of range: 9.0", "grounds.toml:2:11", "at most 5"],
        ),
        (
            "'tiny.toml'",
            "'tin.toml'",
            ["cannot read tin.toml", "", ""],
        ),
    ] {
        bench.write("grounds.toml", OWN.replacen(from, to, 1));
        let told = bench.cosmic("study grounds.toml");
        let code = if says[1].is_empty() { 4 } else { 2 };
        told.fails(code, &says);
    }
    bench.write("grounds.toml", OWN);
    let says = "only built-in scenes can have a base, but `tiny.toml` is not a built-in scene";
    bench.write("base.toml", "");
    let told = bench.cosmic("study grounds.toml --base base.toml");
    told.fails(2, &[says]);
}

/// If several processes of `sweep run` do the runs of a planned study, its results equal those of one process.
#[test]
fn processes_do_the_runs_of_a_planned_study() {
    let bench = bench(LITTLE);
    let options = "--base base.toml --seeds 1 --iterations 8";
    let said = bench.ok(&format!("study ablation {options} --plan cut-runs"));
    assert_eq!(said.out, "cut-runs: 8 runs\n");
    let mut at_work = Vec::new();
    for index in [
        "6", "auto", "3-4", "auto", "7", "auto", "1,5", "auto", "auto",
    ] {
        at_work.push(bench.start(&format!("sweep run cut-runs --threads 1 --index {index}")));
        if at_work.len() == 3 {
            for child in at_work.drain(..) {
                let output = child.wait_with_output().unwrap();
                // The run may be refused, because another process may be doing it.
                assert!(matches!(output.status.code(), Some(0 | 2)), "{output:?}");
            }
        }
    }
    assert_eq!(
        bench.cosmic("sweep status cut-runs --json").json()["left"],
        ""
    );
    // Every run was measured when it ended, so writing the results does not simulate.
    let checks: Vec<_> = fs::read_dir(bench.path("cut-runs/runs")).unwrap().collect();
    let is_measured = |run: &fs::DirEntry| run.path().join("check.json").exists();
    assert_eq!(
        checks
            .iter()
            .filter(|run| is_measured(run.as_ref().unwrap()))
            .count(),
        8
    );
    let said = study(&bench, "ablation", "cut", "--seeds 1 --iterations 8").ok();
    assert_eq!(ended(&said), 0, "{said:?}");
    study(&bench, "ablation", "whole", "--seeds 1 --iterations 8").ok();
    assert_eq!(bench.results("cut"), bench.results("whole"));
    let other = "study ablation --base base.toml --seeds 1 --iterations 9 --plan cut-runs";
    let says =
        "cut-runs: the runs in this folder have other scenes or another number of iterations";
    bench.fails(other, 2, &[says]);
}
