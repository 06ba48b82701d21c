//! `cosmic study` as a user meets it, in little: interrupted, resumed, with more seeds.
#![cfg(unix)]

use crate::program::{Told, cosmic_in};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// A robot of 3x3 nodes under every scene.
const LITTLE: &str = "[lattice]\ncolumns = 3\nrows = 3\n[physics]\nsteps = 64\n\
    [controller]\nhidden = 4\n[volume]\nwidening_over = [4, 6]\n\
    [schedule]\niterations = 20\nattraction_from = 8\nsnap_at = 14\nhorizon = [32, 64]\n\
    [binarisation]\nthreshold_over = [1, 12]\n[loss]\nwindow = 16\nevery = 4\n";

/// The lattice as it is, for the layouts that belong to it.
const SHORT: &str = "[physics]\nsteps = 64\n[controller]\nhidden = 2\n\
    [schedule]\nhorizon = [16, 32]\n[loss]\nwindow = 16\n";

/// A folder with settings for a study in it.
struct Bench(TempDir);

impl Bench {
    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// A JSON file in the folder.
    fn json(&self, name: &str) -> serde_json::Value {
        serde_json::from_str(&fs::read_to_string(self.path(name)).unwrap()).unwrap()
    }
}

fn bench(base: &str) -> Bench {
    let bench = Bench(tempfile::tempdir().unwrap());
    fs::write(bench.path("base.toml"), base).unwrap();
    bench
}

/// A study into `NAME` with its runs in `NAME-runs`.
fn arguments<'a>(kind: &'a str, name: &'a str, runs: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let all = [
        "study",
        kind,
        "--base",
        "base.toml",
        "--out",
        name,
        "--runs",
        runs,
    ];
    [&all, more].concat()
}

fn study(bench: &Bench, kind: &str, name: &str, more: &[&str]) -> Told {
    let runs = format!("{name}-runs");
    cosmic_in(bench.0.path(), &arguments(kind, name, &runs, more))
}

fn done(bench: &Bench, kind: &str, name: &str, more: &[&str]) -> Told {
    let said = study(bench, kind, name, more);
    assert_eq!(said.code, 0, "{said:?}");
    said
}

/// Every file of the results, wall times and the study's folders taken out.
fn results(bench: &Bench, name: &str) -> BTreeMap<String, String> {
    let mut files = BTreeMap::new();
    collect(&bench.path(name), "", &mut files);
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

fn collect(folder: &Path, prefix: &str, files: &mut BTreeMap<String, String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = format!("{prefix}{}", path.file_name().unwrap().to_str().unwrap());
        if path.is_dir() {
            collect(&path, &format!("{name}/"), files);
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        let timeless = match name.rsplit_once('.').unwrap().1 {
            "csv" => without_column(&text, ",", "seconds"),
            "md" => without_column(&text, " | ", "s"),
            "json" => without_key(&text),
            _ => text,
        };
        files.insert(name, timeless);
    }
}

/// A text whose tables lack the column of a name.
fn without_column(text: &str, separator: &str, name: &str) -> String {
    let mut at = None;
    let cut = |line: &str| {
        let mut cells: Vec<&str> = line.split(separator).collect();
        if let Some(column) = cells.iter().position(|cell| *cell == name) {
            at = Some(column);
        }
        match at {
            Some(column) if column < cells.len() => {
                cells.remove(column);
            }
            _ => {}
        }
        cells.join(separator) + "\n"
    };
    text.lines().map(cut).collect()
}

fn without_key(text: &str) -> String {
    let mut parts = text.split("\"seconds\":");
    let first = parts.next().unwrap().to_owned();
    let number = |c: char| c.is_ascii_digit() || ".e-+".contains(c);
    parts.fold(first, |text, part| text + part.trim_start_matches(number))
}

#[test]
fn an_ablation_has_its_document_tables_and_figures() {
    let bench = bench(LITTLE);
    let said = done(&bench, "ablation", "a", &["--seeds", "2"]);
    // A line a run, and a line a file: ten figures, a document, two tables.
    let lines = [ended(&said), said.out.lines().count()];
    assert_eq!(lines, [16, 13], "{said:?}");
    let document = fs::read_to_string(bench.path("a/ablation.md")).unwrap();
    assert!(document.contains("over 2 seeds, 0 to 1."), "{document}");
    let command =
        "```sh\ncosmic study ablation --seeds 2 --base base.toml --out a --runs a-runs\n```";
    assert!(document.contains(command), "{document}");
    for (what, count) in [
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
        assert_eq!(
            (&row["one_hot"], row["runs"].as_array().unwrap().len()),
            (&2.into(), 2)
        );
        let check = &row["runs"][0]["check"];
        assert!(check["half_step"][1].is_number(), "{row}");
    }
    let table = fs::read_to_string(bench.path("a/ablation.csv")).unwrap();
    assert_eq!(table.lines().count(), 17);
}

/// What is not designed stays: the controller at its first weights, the materials as they were.
#[test]
fn what_an_ablation_holds_does_not_move() {
    let bench = bench(LITTLE);
    done(&bench, "ablation", "a", &["--seeds", "1"]);
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
    assert!(
        filled.iter().zip(&held).all(kept) && held.contains(&0),
        "{held:?}"
    );
    let solid = materials(&design("material-control"));
    // 0.90 of 20 edges, less the widening of 0.03: 17.4.
    assert!(solid.iter().filter(|m| **m > 0).count() >= 18, "{solid:?}");
}

#[test]
fn runs_that_diverge_are_told_and_counted() {
    let unstable = "steps = 64\ndt = 1.0\nunstable_step = \"warn\"";
    let bench = bench(&LITTLE.replace("steps = 64", unstable));
    done(&bench, "ablation", "a", &["--seeds", "1"]);
    let document = fs::read_to_string(bench.path("a/ablation.md")).unwrap();
    let said = document.matches("0, 0 of 1, 1 diverged").count();
    assert!(
        said == 8 && !document.contains("NaN") && !document.contains("inf "),
        "{document}"
    );
    assert_eq!(
        document
            .matches("not to be said: some median diverged")
            .count(),
        2
    );
}

#[test]
fn threads_and_interruptions_change_nothing() {
    let bench = bench(&LITTLE.replace("steps = 64", "steps = 1024"));
    let seeds = ["--seeds", "2"];
    done(
        &bench,
        "ablation",
        "whole",
        &[&seeds[..], &["--threads", "1"]].concat(),
    );
    let child = Command::new(env!("CARGO_BIN_EXE_cosmic"))
        .args(arguments(
            "ablation",
            "cut",
            "cut-runs",
            &[&seeds[..], &["--threads", "2"]].concat(),
        ))
        .current_dir(bench.path(""))
        .stderr(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let began = Instant::now();
    while !bench
        .path("cut-runs/runs/topology-0/history.jsonl")
        .exists()
    {
        // No machine is so slow: something is wrong.
        assert!(began.elapsed() < Duration::from_secs(300));
        thread::sleep(Duration::from_millis(1));
    }
    let id = child.id().to_string();
    let killed = Command::new("kill").args(["-s", "TERM", &id]).status();
    assert!(killed.unwrap().success());
    let output = child.wait_with_output().unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(75), "{error}");
    assert!(
        error.contains("of 16 runs done; the same command goes on\n"),
        "{error}"
    );
    // The folder was tried out before the first run; nothing is in it yet.
    assert_eq!(fs::read_dir(bench.path("cut")).unwrap().count(), 0);
    let said = done(
        &bench,
        "ablation",
        "cut",
        &[&seeds[..], &["--threads", "2"]].concat(),
    );
    assert!(ended(&said) < 16, "{said:?}");
    assert_eq!(results(&bench, "cut"), results(&bench, "whole"));
}

#[test]
fn more_seeds_join_and_other_scenes_do_not() {
    let bench = bench(SHORT);
    let little = ["--iterations", "2", "--seeds"];
    let of = |name: &str, more: &[&str]| done(&bench, "findings", name, &[&little, more].concat());
    of("a", &["1", "--first-seed", "1"]);
    let alone = fs::read_to_string(bench.path("a/findings.md")).unwrap();
    let undecided = "undecided: one seed's change has no error";
    assert_eq!(alone.matches(undecided).count(), 15, "{alone}");
    let said = of("a", &["2"]);
    assert_eq!(ended(&said), 19, "{said:?}");
    of("b", &["2"]);
    assert_eq!(results(&bench, "a"), results(&bench, "b"));
    let document = fs::read_to_string(bench.path("a/findings.md")).unwrap();
    assert_eq!(document.matches("\n- **").count(), 16, "{document}");
    let said = study(&bench, "findings", "a", &["--seeds", "2"]);
    assert!(
        said.code == 2 && said.error.contains("another folder by --runs"),
        "{said:?}"
    );
    fs::write(bench.path("base.toml"), "[physics]\nsteps = 0").unwrap();
    let said = study(&bench, "findings", "c", &[]);
    assert!(
        said.code == 2 && said.error.contains("base.toml:2:9"),
        "{said:?}"
    );
    // Right by itself, but not under the study's scenes.
    fs::write(bench.path("base.toml"), "[lattice]\ncolumns = 2\n").unwrap();
    let said = study(&bench, "findings", "c", &[]);
    let says = "error: the settings of base.toml do not go with the study's: the three-legged";
    assert!(said.code == 2 && said.error.contains(says), "{said:?}");
    // Nor with what a study does with designs.
    fs::write(bench.path("base.toml"), "[physics]\nsteps = 600000\n").unwrap();
    let said = study(&bench, "findings", "c", &[]);
    let says = "half the time step and twice the steps";
    assert!(said.code == 2 && said.error.contains(says), "{said:?}");
    assert!(!bench.path("c-runs").exists());
}

/// Results go beside the runs, and replace none but those that they repeat.
#[test]
fn results_of_other_settings_are_not_replaced() {
    let bench = bench(SHORT);
    let study = |more: &str| {
        let command = "study ablation --base base.toml --threads 2 --quiet";
        let arguments = command.split(' ').chain(more.split(' '));
        cosmic_in(bench.0.path(), &arguments.collect::<Vec<_>>())
    };
    let said = study("--seeds 2 --iterations 2");
    assert_eq!((said.code, &said.error[..]), (0, ""), "{said:?}");
    let results = bench.path("runs/study-ablation/ablation.json");
    let before = fs::read(&results).unwrap();
    assert!(!bench.path("docs").exists());
    let refused = |more: &str, says: &str| {
        let said = study(more);
        assert!(said.code == 2 && said.error.contains(says), "{said:?}");
        assert!(said.error.contains("another folder by --out"), "{said:?}");
        assert_eq!(fs::read(&results).unwrap(), before);
    };
    refused(
        "--seeds 1 --iterations 2",
        "seeds: 0 to 1 in the results there, 0 to 0 in this study",
    );
    let out = "--out runs/study-ablation --runs other --seeds 2 --iterations";
    refused(&format!("{out} 3"), "iterations: 2 in");
    fs::write(
        bench.path("base.toml"),
        SHORT.replace("hidden = 2", "hidden = 3"),
    )
    .unwrap();
    refused(
        &format!("{out} 2"),
        "controller.hidden: 2 in the results there, 3 in",
    );
    assert!(!bench.path("other").exists());
}

#[test]
fn the_paper_s_study_has_two_tables_beside_the_paper_s_numbers() {
    let bench = bench(SHORT);
    done(&bench, "paper", "p", &["--seeds", "1", "--iterations", "2"]);
    let document = fs::read_to_string(bench.path("p/paper.md")).unwrap();
    let little = "**Every run was stopped after 2 iterations: a study in little.**";
    assert!(document.contains(little), "{document}");
    // In both tables.
    for line in ["| b, stability heuristic | 1.90 |", "| 5x5 nodes | 1.10 |"] {
        assert_eq!(document.matches(line).count(), 2, "{line}: {document}");
    }
    let (default, strict) = document.split_once("## Strictly by the paper").unwrap();
    assert!(
        default.contains("- A: `loss.kind`, the loss is"),
        "{default}"
    );
    assert!(
        strict.contains("Departures from the paper: none."),
        "{strict}"
    );
    let pictures = document.matches(".svg)").count();
    assert_eq!(
        fs::read_dir(bench.path("p/paper")).unwrap().count(),
        pictures
    );
    let runs = bench.json("p/paper.json")["rows"].as_array().unwrap().len();
    assert_eq!(runs, 16);
}
