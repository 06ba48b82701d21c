//! Lattices other than the rectangular one: the triangular lattice, and lattices whose nodes and edges are in a file.

use crate::common::{Bench, scene};
use crate::program::has;
use cosmic::Registry;
use cosmic::case::Case;
use cosmic::codesign::Record;
use cosmic::lattice::Truss;
use cosmic::record::{Observer, Run, RunPlan, optimise};
use serde_json::Value;
use std::fs;
use std::ops::ControlFlow;

/// The kinds of lattices that have columns and rows.
const KINDS: [&str; 2] = ["rectangular", "triangular"];

/// A gate: two legs of crossed cells under a beam, symmetric about its middle. One payload is the middle of the beam,
/// and a second payload is at its right end. Node 0 is the left foot.
const GATE: &str = include_str!("pages/gate.json");

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
    let truss = Registry::default().read(&bench.path("tiny.toml")).unwrap();
    let of_kind = |kind| {
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
