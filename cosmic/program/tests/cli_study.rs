//! `cosmic study` as a user meets it, in little: interrupted, resumed, with more seeds.
#![cfg(unix)]

use crate::background::signal;
use crate::common::Bench;
use crate::program::Told;
use std::collections::BTreeMap;
use std::fs;

/// A robot of 3x3 nodes under every scene.
const LITTLE: &str = "[lattice]\ncolumns = 3\nrows = 3\n[physics]\nsteps = 64\n\
    [controller]\nhidden = 4\n[volume]\nwidening_over = [4, 6]\n\
    [schedule]\niterations = 20\nattraction_from = 8\nsnap_at = 14\nhorizon = [32, 64]\n\
    [binarisation]\nthreshold_over = [1, 12]\n[loss]\nwindow = 16\nevery = 4\n";

/// The lattice as it is, for the layouts that belong to it.
const SHORT: &str = "[physics]\nsteps = 64\n[controller]\nhidden = 2\n\
    [schedule]\nhorizon = [16, 32]\n[loss]\nwindow = 16\n";

/// A folder with settings for a study in `base.toml`.
fn bench(base: &str) -> Bench {
    let bench = Bench::default();
    bench.write("base.toml", base);
    bench
}

/// A study into `NAME` with its runs in `NAME-runs`.
fn line(kind: &str, name: &str, more: &str) -> String {
    format!("study {kind} --base base.toml --out {name} --runs {name}-runs {more}")
}

fn study(bench: &Bench, kind: &str, name: &str, more: &str) -> Told {
    bench.cosmic(&line(kind, name, more))
}

/// The results, the study's folders taken out.
fn results(bench: &Bench, name: &str) -> BTreeMap<String, String> {
    let mut files = bench.results(name);
    let folders = format!(" --out {name} --runs {name}-runs");
    for text in files.values_mut() {
        *text = text.replace(&folders, "");
    }
    files
}

/// Lines of runs that ended.
fn ended(said: &Told) -> usize {
    let lines = said.error.lines();
    lines.filter(|line| !line.starts_with("warning: ")).count()
}

#[test]
fn an_ablation_has_its_document_tables_and_figures() {
    let bench = bench(LITTLE);
    let said = study(&bench, "ablation", "a", "--seeds 2").ok();
    // A line a run, and a line a file: ten figures, a document, two tables.
    let lines = [ended(&said), said.out.lines().count()];
    assert_eq!(lines, [16, 13], "{said:?}");
    let document = bench.read("a/ablation.md");
    assert!(document.contains("over 2 seeds, 0 to 1."), "{document}");
    let command = "cosmic study ablation --seeds 2 --base base.toml --out a --runs a-runs";
    for (what, count) in [
        (&*format!("```sh\n{command}\n```"), 1),
        ("\n| h, all three | yes | yes | yes | 1.91 |", 1),
        ("\n- **", 6),
    ] {
        assert_eq!(document.matches(what).count(), count, "{what}: {document}");
    }
    let linked = document.matches("](ablation/").count();
    let figures = fs::read_dir(bench.path("a/ablation")).unwrap().count();
    assert_eq!((linked, figures), (10, 10));
    let json = bench.json("a/ablation.json");
    assert_eq!(json["format"], "cosmic-study");
    for row in json["rows"].as_array().unwrap() {
        assert_eq!(row["one_hot"], 2);
        assert_eq!(row["runs"].as_array().unwrap().len(), 2);
        let check = &row["runs"][0]["check"];
        assert!(check["half_step"][1].is_number(), "{row}");
    }
    assert_eq!(bench.lines("a/ablation.csv"), 17);
    what_is_held_does_not_move(&bench);
}

/// Parts that are not designed stay: the controller at its first weights, the materials of the start.
fn what_is_held_does_not_move(bench: &Bench) {
    let design = |trial: &str| bench.json(&format!("a-runs/runs/{trial}-0/design.json"));
    let [none, topology, material, all] =
        ["none", "topology", "topology-material", "all"].map(design);
    assert_eq!(none["controller"], topology["controller"]);
    assert_eq!(none["controller"], material["controller"]);
    assert_ne!(none["controller"], all["controller"]);
    let materials = |design: &serde_json::Value| -> Vec<u64> {
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
    // 0.90 of 20 edges, less the widening of 0.03: 17.4.
    assert!(solid.iter().filter(|m| **m > 0).count() >= 18, "{solid:?}");
}

#[test]
fn runs_that_diverge_are_told_and_counted() {
    let unstable = "steps = 64\ndt = 1.0\nunstable_step = \"warn\"";
    let bench = bench(&LITTLE.replace("steps = 64", unstable));
    study(&bench, "ablation", "a", "--seeds 1").ok();
    let document = bench.read("a/ablation.md");
    for (what, count) in [
        ("0, 0 of 1, 1 diverged", 8),
        ("not to be said: some median diverged", 2),
        ("NaN", 0),
        ("inf ", 0),
    ] {
        assert_eq!(document.matches(what).count(), count, "{what}: {document}");
    }
}

#[test]
fn threads_and_interruptions_change_nothing() {
    let bench = bench(&LITTLE.replace("steps = 64", "steps = 1024"));
    study(&bench, "ablation", "whole", "--seeds 2 --threads 1").ok();
    let cut = line("ablation", "cut", "--seeds 2 --threads 2");
    let child = bench.start(&cut);
    bench.await_lines("cut-runs/runs/topology-0/history.jsonl", 0);
    signal(&child, "TERM");
    let told = Told::of(child.wait_with_output().unwrap());
    told.fails(75, &["of 16 runs done; the same command goes on\n"]);
    // The folder was tried out before the first run; nothing is in it yet.
    assert_eq!(fs::read_dir(bench.path("cut")).unwrap().count(), 0);
    let said = bench.cosmic(&cut).ok();
    assert!(ended(&said) < 16, "{said:?}");
    assert_eq!(results(&bench, "cut"), results(&bench, "whole"));
}

#[test]
fn more_seeds_join_and_other_scenes_do_not() {
    let bench = bench(SHORT);
    let of = |name: &str, seeds: &str| {
        let more = format!("--iterations 2 --seeds {seeds}");
        study(&bench, "findings", name, &more).ok()
    };
    of("a", "1 --first-seed 1");
    let alone = bench.read("a/findings.md");
    let undecided = "undecided: one seed's change has no error";
    assert_eq!(alone.matches(undecided).count(), 20, "{alone}");
    let said = of("a", "2");
    assert_eq!(ended(&said), 24, "{said:?}");
    of("b", "2");
    assert_eq!(results(&bench, "a"), results(&bench, "b"));
    let document = bench.read("a/findings.md");
    assert_eq!(document.matches("\n- **").count(), 21, "{document}");
    let said = study(&bench, "findings", "a", "--seeds 2");
    said.fails(2, &["another folder by --runs"]);
    let refused = |base: &str, says: &str| {
        bench.write("base.toml", base);
        study(&bench, "findings", "c", "").fails(2, &[says]);
    };
    refused("[physics]\nsteps = 0", "base.toml:2:9");
    // Right by itself, but not under the study's scenes.
    let says = "error: the settings of base.toml do not go with the study's: the three-legged";
    refused("[lattice]\ncolumns = 2\n", says);
    // A study also runs designs with twice the steps.
    let says = "half the time step and twice the steps";
    refused("[physics]\nsteps = 600000\n", says);
    assert!(!bench.path("c-runs").exists());
}

/// Results go beside the runs, and replace none but those that they repeat.
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
        study(more).fails(2, &[says, "another folder by --out"]);
        assert_eq!(bench.read(results), before);
    };
    refused(
        "--seeds 1 --iterations 2",
        "seeds: 0 to 1 in the results there, 0 to 0 in this study",
    );
    let out = "--out runs/study-ablation --runs other --seeds 2 --iterations";
    refused(&format!("{out} 3"), "iterations: 2 in");
    bench.write("base.toml", SHORT.replace("hidden = 2", "hidden = 3"));
    let says = "controller.hidden: 2 in the results there, 3 in";
    refused(&format!("{out} 2"), says);
    assert!(!bench.path("other").exists());
}

#[test]
fn the_paper_s_study_has_two_tables_beside_the_paper_s_numbers() {
    let bench = bench(SHORT);
    study(&bench, "paper", "p", "--seeds 1 --iterations 2").ok();
    let document = bench.read("p/paper.md");
    let little = "**Every run was stopped after 2 iterations: a study in little.**";
    assert!(document.contains(little), "{document}");
    // In both tables.
    for line in ["| b, stability heuristic | 1.90 |", "| 5x5 nodes | 1.10 |"] {
        assert_eq!(document.matches(line).count(), 2, "{line}: {document}");
    }
    let (default, strict) = document.split_once("## Strictly by the paper").unwrap();
    assert!(default.contains("- A: `loss.kind`, the loss is"));
    assert!(strict.contains("Departures from the paper: none."));
    let pictures = fs::read_dir(bench.path("p/paper")).unwrap().count();
    assert_eq!(document.matches(".svg)").count(), pictures);
    let runs = bench.json("p/paper.json")["rows"].as_array().unwrap().len();
    assert_eq!(runs, 16);
}

/// A study that is planned, done by processes of `sweep run`, and written is the study in one go.
#[test]
fn processes_do_the_runs_of_a_planned_study() {
    let bench = bench(LITTLE);
    let options = "--base base.toml --seeds 1 --iterations 8";
    let said = bench
        .cosmic(&format!("study ablation {options} --plan cut-runs"))
        .ok();
    assert_eq!(said.out, "cut-runs: 8 runs\n");
    let mut at_work = Vec::new();
    for index in [
        "6", "auto", "3-4", "auto", "7", "auto", "1,5", "auto", "auto",
    ] {
        at_work.push(bench.start(&format!("sweep run cut-runs --threads 1 --index {index}")));
        if at_work.len() == 3 {
            for child in at_work.drain(..) {
                let output = child.wait_with_output().unwrap();
                // Another process may be at work on the run.
                assert!(matches!(output.status.code(), Some(0 | 2)), "{output:?}");
            }
        }
    }
    assert_eq!(
        bench.cosmic("sweep status cut-runs --json").json()["left"],
        ""
    );
    // Every run was measured when it ended, so that writing simulates nothing.
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
    assert_eq!(results(&bench, "cut"), results(&bench, "whole"));
    let other = "study ablation --base base.toml --seeds 1 --iterations 9 --plan cut-runs";
    let says = "cut-runs: the runs there are of other scenes or another number of iterations";
    bench.cosmic(other).fails(2, &[says]);
}
