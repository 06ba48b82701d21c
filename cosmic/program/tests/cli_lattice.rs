//! Lattices other than the rectangular one: the triangular lattice, and lattices whose nodes and edges are in a file.

use crate::common::{Bench, scene};
use crate::program::{Told, has};
use cosmic::Registry;
use cosmic::case::Case;
use cosmic::codesign::Record;
use cosmic::lattice::Truss;
use cosmic::record::{Observer, Run, RunPlan, optimise};
use cosmic::scene::Scene;
use serde_json::Value;
use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::Command;

/// The kinds of lattices that have columns and rows. Each has two numbers of edges: with 4 x 3 nodes and with 3 x 3
/// nodes.
const KINDS: [(&str, usize, usize); 2] = [("rectangular", 29, 20), ("triangular", 23, 16)];

/// A gate: two legs of crossed cells under a beam, symmetric about its middle. One payload is the middle of the beam,
/// and a second payload is at its right end. Node 0 is the left foot.
const GATE: &str = r#"{
  "format": "cosmic-truss", "version": 1,
  "nodes": [[0.1, 0.0], [0.2, 0.0], [0.5, 0.0], [0.6, 0.0],
            [0.1, 0.12], [0.2, 0.1], [0.35, 0.13], [0.5, 0.1], [0.6, 0.12],
            [0.1, 0.2], [0.35, 0.22], [0.6, 0.2]],
  "edges": [[0, 1], [0, 4], [1, 5], [0, 5], [1, 4], [4, 5],
            [2, 3], [3, 8], [2, 7], [3, 7], [2, 8], [7, 8],
            [4, 9], [5, 9], [5, 6], [6, 10], [9, 10], [6, 9],
            [8, 11], [7, 11], [6, 7], [10, 11], [6, 11], [5, 10], [7, 10]],
  "payload": [{"node": 10}, {"node": 11, "mass": 0.005}],
  "keep": [16, 21, 14],
  "forbid": [0, 6],
  "tie": [[1, 7], [8, 2], [3, 9], [16, 21], [19, 4, 10]]
}"#;

/// The small scene of the other tests with the lattice [`GATE`].
fn of_gate(iterations: usize) -> String {
    scene(iterations, 64, "").replace("columns = 3\nrows = 3\n", "file = \"shapes/gate.json\"\n")
}

fn bench() -> Bench {
    let bench = Bench::with(&of_gate(24));
    fs::create_dir(bench.path("shapes")).unwrap();
    bench.write("shapes/gate.json", GATE);
    bench
}

/// Stops a run after the given number of iterations.
struct StopsAfter(usize);

impl Observer for StopsAfter {
    fn iteration(&mut self, _: &Run, record: &Record) -> ControlFlow<()> {
        if record.iteration == self.0 {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }
}

fn assert_rules_hold(design: &Value) {
    let materials = |edge: usize| design["materials"][edge].as_u64().unwrap();
    for kept in [16, 21, 14] {
        assert!(materials(kept) > 0, "edge {kept} is void");
    }
    for forbidden in [0, 6] {
        assert_eq!(materials(forbidden), 0, "edge {forbidden}");
    }
    for [a, b] in [[1, 7], [2, 8], [3, 9], [16, 21], [4, 10], [4, 19]] {
        assert_eq!(design["z"][a], design["z"][b], "edges {a} and {b}");
        assert_eq!(materials(a), materials(b));
    }
}

/// The rules of the lattice hold before and after the edges get their final materials, for several seeds, and with
/// tight volume bounds.
#[test]
fn a_delivered_design_obeys_the_rules_of_its_lattice() {
    let bench = bench();
    for seed in 0..3 {
        for iterations in [8, 24] {
            let run = format!("{seed}-{iterations}");
            bench.run(&run, &format!("--seed {seed} --iterations {iterations}"));
            let design = bench.json(&format!("{run}/design.json"));
            assert_eq!(design["edges"].as_array().unwrap().len(), 25);
            assert_rules_hold(&design);
        }
    }
    // As far as the rules allow, half of the edges are void: 12 or 13 of 25, plus or minus a pair of tied edges.
    let summary = bench.json("0-24/summary.json");
    let volume = summary["V"].as_f64().unwrap();
    assert!((0.4..0.6).contains(&volume), "{volume}");
    // Under tight bounds, the snap changes the materials of some edges; then other layouts are tried and polished.
    bench.run(
        "few",
        "--set volume.solid=[0.3,0.3] --set schedule.polish_trials=40",
    );
    assert_rules_hold(&bench.json("few/design.json"));
    for start in ["uniform", "filled"] {
        bench.run(
            start,
            &format!("--set start.kind={start} --set start.tilt=0.1"),
        );
        assert_rules_hold(&bench.json(&format!("{start}/design.json")));
    }
    let layout = "--set start.kind=layout --set start.layout=filled --set schedule.snap_at=0";
    bench.run("layout", layout);
    assert_rules_hold(&bench.json("layout/design.json"));
    let legs = bench.optimize("b", "--set start.kind=three_legged");
    legs.fails(2, &["6x6 nodes, not", "gate.json"]);
}

/// A run on a truss file can be resumed after its folder was moved, because the folder contains a copy of the file.
#[test]
fn a_run_on_a_truss_file_resumes_in_another_folder() {
    let bench = bench();
    bench.run("whole", "");
    let plan = bench.plan();
    let stopped = optimise(&bench.path("a"), &plan, &mut StopsAfter(11));
    assert_eq!(stopped.unwrap_err().exit_code(), 75);
    fs::create_dir(bench.path("elsewhere")).unwrap();
    fs::rename(bench.path("a"), bench.path("elsewhere/b")).unwrap();
    bench.remove("shapes/gate.json");
    bench.ok("resume elsewhere/b");
    assert_eq!(bench.results("elsewhere/b"), bench.results("whole"));
    let scene = bench.read("elsewhere/b/scene.toml");
    has(&scene, &["\nfile = \"truss.json\"\n"]);
    let copy = Truss::read(&bench.path("elsewhere/b/truss.json")).unwrap();
    assert_eq!(copy, Truss::parse("gate", GATE).unwrap());
    bench.evaluated("elsewhere/b");
    let report = bench.ok("report elsewhere/b");
    has(&report.out, &["report.html"]);
    let checked = bench.ok("check elsewhere/b --steps 32");
    has(&checked.out, &["truss.json, 12 nodes, 25 edges"]);
    bench.ok("optimize --from elsewhere/b --out c");
    assert_rules_hold(&bench.json("c/design.json"));
    // The payload is node 0 of the robot, whatever number it has in the truss file.
    let design = bench.json("c/design.json");
    assert_eq!(design["edges"][15], serde_json::json!([6, 0]));
}

#[test]
fn a_sweep_and_a_search_contain_a_copy_of_their_lattice() {
    let bench = bench();
    bench.ok("sweep run tiny.toml --seeds 2 --iterations 2 --out s --index 0");
    bench.run("starts", "--starts 2 --iterations 2");
    bench.remove("shapes/gate.json");
    has(&bench.read("s/sweep.json"), &["\"truss\":"]);
    bench.ok("report s/runs/tiny-0");
    assert!(bench.path("starts/truss.json").exists());
    bench.ok("report starts");
}

/// The gradients agree with finite differences and with forward mode, for tied edges and for every kind of lattice.
#[test]
fn gradients_on_other_lattices_agree_with_differences() {
    let bench = bench();
    bench.ok("check tiny.toml --steps 24");
    for (kind, edges, _) in KINDS {
        let sized = format!(
            "--set lattice.kind={kind} --set lattice.columns=4 --set lattice.rows=3 --set controller.hidden=4 --set \
             physics.steps=64"
        );
        let said = bench.ok(&format!("check stability --steps 24 {sized}"));
        let expected = format!("4x3, 12 nodes, {edges} edges");
        has(&said.out, &[&expected]);
    }
}

#[test]
fn every_kind_of_lattice_goes_through_all_phases() {
    for (kind, _, edges) in KINDS {
        let of_kind = scene(24, 64, "").replace("columns", &format!("kind = \"{kind}\"\ncolumns"));
        let bench = Bench::with(&of_kind);
        bench.run("a", "");
        let design = bench.json("a/design.json");
        assert_eq!(design["edges"].as_array().unwrap().len(), edges);
        bench.ok("report a");
        assert!(!bench.path("a/truss.json").exists());
    }
}

/// An error in a truss file shows its place. If the file is missing, the exit code is 4.
#[test]
fn an_invalid_truss_file_is_refused_with_the_place_of_the_error() {
    let bench = bench();
    let refused = |from: &str, to: &str, words: &[&str]| {
        has(GATE, &[from]);
        bench.write("shapes/gate.json", GATE.replacen(from, to, 1));
        bench.optimize("b", "").fails(2, words);
        assert!(!bench.path("b").exists());
    };
    refused(
        "[0, 4], [1, 5]",
        "[0, 4], [4, 0]",
        &["`edges[2]`: [4, 0] is given twice", "gate.json:6:29"],
    );
    refused(
        "\"forbid\"",
        "\"forbidden\"",
        &["unknown field `forbidden`", "gate.json:12:13"],
    );
    refused(
        "\"keep\": [16, 21, 14]",
        "\"keep\": [16, 21, 14, 2, 4, 5, 8, 10, 11, 12, 13, 15, 17, 18, 19, 20]",
        &[
            "keeps a share of 0.640 of its edges",
            "volume.solid and lattice.file",
        ],
    );
    bench.write(
        "shapes/gate.json",
        GATE.replace("[0.2, 0.0]", "[0.2, -0.01]"),
    );
    let kind = bench.optimize("b", "--set lattice.kind=triangular");
    kind.fails(2, &["a truss has no kind", "lattice.kind and lattice.file"]);
    let doubted = bench.cosmic("scene check tiny.toml");
    let text = [&*doubted.out, &*doubted.error].concat();
    has(&text, &["nodes of the truss start below the ground"]);
    bench.remove("shapes/gate.json");
    bench
        .optimize("b", "")
        .fails(4, &["shapes/gate.json", "lattice.file"]);
    fs::create_dir(bench.path("shapes/gate.json")).unwrap();
    bench.optimize("b", "").fails(4, &["not a file"]);
    bench.fails("scene check tiny.toml", 4, &["not a file"]);
}

/// `optimize --from` refuses a design that violates the rules of the lattice.
#[test]
fn a_design_that_violates_the_rules_cannot_be_a_start() {
    let bench = bench();
    bench.run("a", "");
    let mut design = bench.json("a/design.json");
    let against = |edge: usize, material: usize, words: &[&str]| {
        let mut other = design.clone();
        let mut z = [0.0; 3];
        z[material] = 1.0;
        other["z"][edge] = serde_json::json!(z);
        other["materials"][edge] = material.into();
        bench.write("other.json", other.to_string());
        bench.fails("optimize tiny.toml --from other.json --out b", 2, words);
    };
    against(
        0,
        1,
        &["edge 0 is solid, but the lattice requires it to be void"],
    );
    against(
        14,
        0,
        &["edge 14 is void, but the lattice requires it to be solid"],
    );
    let material = design["materials"][7].as_u64().unwrap() as usize;
    against(1, (material + 1) % 3, &["edges 1 and 7 are tied"]);
    design["edges"][3] = serde_json::json!([7, 1]);
    bench.write("other.json", design.to_string());
    bench.fails(
        "optimize tiny.toml --from other.json --out b",
        2,
        &["`edges[3]`"],
    );
}

/// Only this program knows the lattice, but every program can resume the run, because the run's folder contains a copy
/// of the lattice.
#[test]
fn a_lattice_of_a_program_is_copied_into_its_runs() {
    let registry = Registry::default().with_lattice("gate", Truss::parse("gate", GATE).unwrap());
    let bench = Bench::with(&of_gate(24).replace("shapes/gate.json", "gate"));
    let scene = registry.read(&bench.path("tiny.toml")).unwrap();
    assert_eq!(scene.lattice.name(), "gate");
    let plan = RunPlan::new("tiny", scene, 0);
    let stopped = optimise(&bench.path("a"), &plan, &mut StopsAfter(11));
    assert_eq!(stopped.unwrap_err().exit_code(), 75);
    bench.ok("resume a");
    bench.ok("report a");
    assert_rules_hold(&bench.json("a/design.json"));
    // The program `cosmic` does not have this lattice.
    bench.optimize("b", "").fails(4, &["gate"]);
}

/// A case contains everything that a rollout and its gradients need, including the rules of the edges.
#[test]
fn a_case_of_any_lattice_reads_back_to_the_same_results() {
    let bench = bench();
    let truss = Scene::read(&bench.path("tiny.toml")).unwrap();
    let of_kind = |(kind, ..): (&str, usize, usize)| {
        let kind = format!("lattice.kind={kind}");
        truss.set(&["lattice.file=off", &kind]).unwrap()
    };
    for scene in KINDS.map(of_kind).into_iter().chain([truss.clone()]) {
        let scene = scene.set(&["projection.hold_materials=0.05"]).unwrap();
        let case = Case::of_scene(&scene, 3).unwrap();
        let json = case.to_json();
        let read = Case::parse("case.json", &json).unwrap();
        assert_eq!(read.to_json(), json);
        let results = |case: &Case| case.evaluate(true, &[]).unwrap().to_json();
        // A failed `assert_eq!` would print too many numbers.
        assert!(results(&read) == results(&case), "{}", scene.lattice.name());
        let wrong = json.replace("\"forbid\":[0,6]", "\"forbid\":[0,60]");
        if wrong != json {
            let says = Case::parse("case.json", &wrong).unwrap_err().to_string();
            has(&says, &["expected an edge below 25, found 60"]);
        }
    }
}

/// The example `ring` builds its lattice in code. The program `cosmic` can read its runs.
#[test]
fn runs_of_the_example_ring_are_read_by_cosmic() {
    let folder = Path::new(env!("CARGO_BIN_EXE_cosmic")).parent().unwrap();
    let ring = folder.join("examples/ring");
    let bench = Bench::default();
    let run = |line: &str| {
        let mut command = Command::new(&ring);
        let command = command.current_dir(bench.path("")).args(line.split(' '));
        Told::of(command.output().unwrap()).ok()
    };
    let checked = run("check --steps 16 --set physics.steps=64");
    has(&checked.out, &["negative control"]);
    let short = "--set physics.steps=64 --set schedule.horizon=[32,32] --set loss.window=16";
    run(&format!("optimize --iterations 8 --out a --quiet {short}"));
    run("resume a");
    run("report a");
    let design = bench.json("a/design.json");
    let outer = (0..12).map(|k| design["materials"][4 * k].as_u64());
    assert!(
        outer.into_iter().all(|material| material > Some(0)),
        "{design}"
    );
    bench.ok("evaluate a/design.json --gradient --out results.json");
    bench.ok("report a");
}
