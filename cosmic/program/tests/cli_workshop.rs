//! `cosmic export` for the workshop. To check the files, Python packages read them back.

use crate::common::python::python;
use crate::common::{Bench, scene};
use crate::program::Told;
use cosmic::lattice::Lattice;
use cosmic::record::DesignFile;
use cosmic::scene::Scene;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Computes the values that the export of a run must contain. They are computed from the files of the run.
fn expected(bench: &Bench, sizes: Value) -> Value {
    let scene = Scene::read(&bench.path("run/scene.toml")).unwrap();
    let design = DesignFile::read(&bench.path("run/design.json")).unwrap();
    let lattice = Lattice::new(&scene.lattice, &scene.physics);
    let case = design.case(&scene, "design.json").unwrap();
    let (body, weights) = (case.body(), &case.controller);
    let bar = |(edge, material): (usize, _)| {
        let material = ["", "skeleton", "actuator"][material as usize];
        let (nodes, rest_length) = (lattice.edges[edge], lattice.rest_length[edge]);
        let bar = json!({ "nodes": nodes, "material": material, "rest_length": rest_length });
        (edge.to_string(), bar)
    };
    let solid = design.materials.iter().copied().enumerate();
    let solid = solid.filter(|(_, material)| material.is_solid());
    let payload: f64 = (lattice.payload.iter())
        .map(|payload| payload.mass.unwrap_or(scene.physics.payload_mass))
        .sum();
    let nodes = lattice.nodes() as f64 * scene.physics.node_mass;
    let asked = &scene.controller;
    json!({
        "nodes": lattice.nodes(),
        "bars": solid.map(bar).collect::<serde_json::Map<_, _>>(),
        "bar_mass": body.mass.iter().sum::<f64>() - nodes - payload,
        "max_strain": scene.materials.max_strain[2],
        "density": scene.materials.density,
        "trajectory": every_step(bench, scene.physics.steps, scene.physics.dt),
        "sizes": sizes,
        "robot": {
            "edges": lattice.edges, "rest_length": lattice.rest_length,
            "stiffness": body.stiffness, "strain": body.strain,
            "w1": weights.block("w1"), "b1": weights.block("b1"),
            "w2": weights.block("w2"), "b2": weights.block("b2"),
            "clocks": asked.clocks, "omega": asked.omega, "goal": asked.goal,
            "goal_scale": asked.goal_scale, "offset_scale": asked.offset_scale,
            "velocity_scale": asked.velocity_scale,
        },
    })
}

/// Writes a trajectory of the run that has the state after every step, because peak forces are taken over all steps.
/// Returns its path.
fn every_step(bench: &Bench, last: usize, dt: f64) -> PathBuf {
    let steps: Vec<String> = (0..=last).map(|step| step.to_string()).collect();
    let record = steps.join(",");
    (bench.cosmic(&format!("evaluate run --record {record} --out states.json"))).ok();
    let results = bench.json("states.json");
    let state = |step: &String| results["results"]["trajectory"][step].clone();
    let states: Vec<Value> = steps.iter().map(state).collect();
    let steps: Vec<usize> = (0..=last).collect();
    let all = json!({ "dt": dt, "steps": steps, "states": states });
    bench.write("every.json", all.to_string());
    bench.path("every.json")
}

/// Exports the run of a test folder, reads the files back in Python, and compares them with the expected values.
fn read_back(bench: &Bench, options: &str, sizes: Value) {
    let line = format!("export run --csv --svg --dxf --stl --out made {options}");
    bench.cosmic(&line).ok();
    bench.write("expected.json", expected(bench, sizes).to_string());
    let Some(python) = python() else { return };
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/workshop/read_back.py");
    let mut command = Command::new(python);
    command.arg(script).args(["made", "expected.json"]);
    let read = command.current_dir(bench.path("")).output();
    println!("{}", Told::of(read.unwrap()).ok().out);
}

fn defaults() -> Value {
    json!({ "width": 12.0, "hole": 4.0, "gap": 1.0, "radius": 3.0 })
}

/// Makes a test folder with a finished run. `lattice` replaces the keys of the scene's lattice, `truss` is the text of
/// the file `truss.json`, and `volume` is added to the section `[volume]`.
fn finished(lattice: &str, truss: &str, volume: &str) -> Bench {
    let scene = scene(24, 64, "").replace("columns = 3\nrows = 3\n", lattice);
    let bench = Bench::with(&scene.replace("[volume]\n", &format!("[volume]\n{volume}")));
    bench.write("truss.json", truss);
    bench.run("run", "--quiet");
    bench
}

#[test]
fn a_robot_of_squares_is_read_back_by_other_programs() {
    let bench = finished("columns = 6\nrows = 5\n", "", "");
    read_back(&bench, "", defaults());
    // The strips are so wide that two parallel diagonals, which are 70.7 mm apart, need two layers.
    let sizes = json!({ "width": 60.0, "hole": 20.5, "gap": 15.0, "radius": 2.0 });
    let options = "--width 60 --hole 20.5 --gap 15 --radius 2 --thickness 5";
    read_back(&bench, options, sizes);
}

#[test]
fn a_robot_of_triangles_is_read_back_by_other_programs() {
    let bench = finished("columns = 5\nrows = 4\nkind = \"triangular\"\n", "", "");
    read_back(&bench, "", defaults());
}

/// A truss with odd angles and lengths and with nodes without a bar. One of its bars is always solid and lies across a
/// node.
const TRUSS: &str = r#"{"format": "cosmic-truss", "version": 1,
    "nodes": [[0, 0], [0.13, 0], [0.26, 0], [0.05, 0.12], [0.19, 0.11], [0.31, 0.14], [0.4, 0.01]],
    "edges": [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [1, 4], [2, 4], [3, 4], [0, 4], [2, 5], [4, 5],
              [5, 6], [2, 6], [2, 3]], "keep": [0, 1, 2]}"#;

#[test]
fn a_truss_with_a_bar_across_a_node_is_read_back_by_other_programs() {
    let bench = finished("file = \"truss.json\"\n", TRUSS, "");
    read_back(&bench, "", defaults());
}

#[test]
fn only_the_requested_files_are_written_by_default_into_the_run_s_folder() {
    let bench = Bench::default();
    bench.run("run", "--quiet");
    let before = bench.results("run");
    let told = bench.cosmic("export run --csv --svg").ok();
    let names = ["bars.csv", "nodes.csv", "pattern.svg"];
    let written = names.map(|name| format!("run/export/{name}"));
    assert!(told.out.lines().eq(&written), "{told:?}");
    let entries = fs::read_dir(bench.path("run/export")).unwrap().count();
    assert_eq!(entries, 3);
    for name in names {
        bench.remove(&format!("run/export/{name}"));
    }
    fs::remove_dir(bench.path("run/export")).unwrap();
    assert_eq!(bench.results("run"), before);
    let told = bench.cosmic("export run --stl --json --out made").json();
    assert_eq!(told["written"].as_array().unwrap().len(), 4);
    assert!(bench.path("made/robot.stl").exists() && !bench.path("run/export").exists());
    let told = bench.cosmic("export run --csv --quiet --out made").ok();
    assert_eq!((&told.out[..], &told.error[..]), ("", ""));
    // The payload is at node 0.
    let nodes = bench.read("made/nodes.csv");
    let head = "node,x,y,bars,node_mass,payload,lowest_layer,highest_layer,pin,given_node\n";
    assert!(nodes.starts_with(head), "{nodes}");
    assert!(
        nodes.contains("\n0,0,0,") && nodes.contains(",0.0001,0.03,"),
        "{nodes}"
    );
    numbers_are_plain(&bench);
    // A run may end before the snap. Then the exported robot differs from the robot that moved.
    bench.unfinished("half", 12);
    let told = bench.cosmic("export half --csv").ok();
    assert!(told.error.contains("the design is undecided"), "{told:?}");
}

/// Asserts that numbers in the files are easy to read: no exponents, and no rounding noise in the last digits.
fn numbers_are_plain(bench: &Bench) {
    bench
        .cosmic("export run --csv --svg --dxf --stl --out made")
        .ok();
    for (name, most) in [
        ("bars.csv", 9),
        ("nodes.csv", 9),
        ("solid.csv", 15),
        ("pattern.svg", 6),
        ("pattern.dxf", 6),
    ] {
        let text = bench.read(&format!("made/{name}"));
        let is_part = |c: char| c.is_ascii_alphanumeric() || ".+-".contains(c);
        let words = text.split(|c| !is_part(c));
        let numbers = words.filter(|word| word.parse::<f64>().is_ok());
        let mut count = 0;
        for number in numbers {
            assert!(!number.contains(['e', 'E']), "{name}: {number}");
            let decimals = number
                .split_once('.')
                .map_or(0, |(_, decimals)| decimals.len());
            assert!(decimals <= most, "{name}: {number}");
            count += 1;
        }
        assert!(count > 10, "{name}");
    }
}

/// In the truss file the payload is node 4, so this node becomes node 0 of the robot.
#[test]
fn nodes_also_have_the_numbers_of_the_truss_file() {
    let truss = TRUSS.replace("\"keep\":", "\"payload\": 4, \"keep\":");
    let bench = finished("file = \"truss.json\"\n", &truss, "");
    bench.cosmic("export run --csv").ok();
    let given: Value = serde_json::from_str(&truss).unwrap();
    let nodes = bench.read("run/export/nodes.csv");
    let mut has_moved = false;
    for row in nodes.lines().skip(1) {
        let cells: Vec<&str> = row.split(',').collect();
        let (own, file) = (cells[0], cells[cells.len() - 1]);
        let place = &given["nodes"][file.parse::<usize>().unwrap()];
        // The robot's origin is the lower left corner of the truss. Here this is also the origin of the truss file.
        for (k, cell) in cells[1..3].iter().enumerate() {
            let off = cell.parse::<f64>().unwrap() - place[k].as_f64().unwrap();
            // Rounding: positions are stored in units of the lattice spacing and written to 1e-9 m.
            assert!(off.abs() < 1e-9, "{row}: {place}");
        }
        has_moved |= own != file;
    }
    assert!(has_moved && nodes.contains("\n0,0.19,0.11,"), "{nodes}");
}

#[test]
fn a_kind_that_cannot_be_made_does_not_stop_the_other_kinds() {
    let bench = Bench::default();
    bench.run("run", "--quiet");
    let told = bench.cosmic("export run --csv --svg --dxf --stl --mujoco --radius 30");
    told.fails(
        2,
        &[
            "error: --stl: cannot export: ",
            "choose a smaller radius than 30 mm (its files were not written)",
        ],
    );
    let names = told
        .out
        .lines()
        .map(|line| line.rsplit('/').next().unwrap());
    let names: Vec<&str> = names.collect();
    let workshop = ["bars.csv", "nodes.csv", "pattern.svg", "pattern.dxf"];
    assert!(
        names.starts_with(&workshop) && names.contains(&"robot.xml"),
        "{told:?}"
    );
    assert!(!bench.path("run/export/robot.stl").exists());
    let told = bench.cosmic("export run --csv --svg --dxf --hole 12 --out other");
    told.fails(
        2,
        &[
            "error: --svg: cannot export: the hole",
            "error: --dxf: cannot export: the hole",
        ],
    );
    assert_eq!(told.out, "other/bars.csv\nother/nodes.csv\n");
}

#[test]
fn an_impossible_export_is_refused_before_anything_is_written() {
    let bench = Bench::default();
    bench.run("run", "--quiet");
    let allowed = "expected a number of millimetres from 0.001 to 1000000";
    for (line, code, says) in [
        ("export run", 2, "--csv|--svg|--dxf|--stl"),
        ("export nowhere --csv", 4, "nowhere"),
        ("export run --svg --width 0", 2, allowed),
        ("export run --svg --width -3", 2, allowed),
        ("export run --svg --width nan", 2, allowed),
        (
            "export run --svg --width 12,5",
            2,
            "to 1000000; use a decimal point: 12.5",
        ),
        (
            "export run --svg --dxf --hole 12",
            2,
            "the hole is 12 mm wide, but must be narrower",
        ),
        (
            "export run --dxf --hole 110 --width 150",
            2,
            "needs at least 130 mm for its holes",
        ),
        (
            "export run --stl --radius 30",
            2,
            "choose a smaller radius than 30 mm",
        ),
        (
            "export run --csv --out tiny.toml",
            4,
            "cannot write tiny.toml",
        ),
    ] {
        bench.cosmic(line).fails(code, &[says]);
        assert!(!bench.path("run/export").exists(), "{line}");
    }
    // A material without mass has a cross-section of zero, so its bars cannot be solids.
    let massless = "[materials]\ndensity = [1e-8, 0.0, 0.1]\n";
    let bench = Bench::with(&(scene(24, 64, "node_mass = 0.01") + massless));
    bench.run("run", "--quiet");
    let told = bench.cosmic("export run --stl");
    told.fails(
        2,
        &["the line density of skeleton is 0 (materials.density)"],
    );
    bench.cosmic("export run --dxf").ok();
}

/// Each of two bars lies across a node of the other. So the pin at that node would go through the bar.
#[test]
fn a_robot_that_cannot_be_stacked_from_plates_is_refused_but_has_tables() {
    let truss = r#"{"format": "cosmic-truss", "version": 1,
        "nodes": [[0, 0], [0.1, 0], [0.2, 0], [0.3, 0], [0.15, 0.1]],
        "edges": [[0, 2], [1, 3], [0, 1], [1, 2], [2, 3], [0, 4], [1, 4], [2, 4], [3, 4]],
        "keep": [0, 1, 2, 3, 4]}"#;
    let solid = "solid = [0.6, 0.9]\n";
    let bench = finished("file = \"truss.json\"\n", truss, solid);
    for kind in ["--svg", "--dxf"] {
        let told = bench.cosmic(&format!("export run {kind}"));
        told.fails(2, &["lies across node", "whose pin would go through it"]);
    }
    bench
        .cosmic("export run --stl")
        .fails(2, &["would go through the joint"]);
    bench.cosmic("export run --csv").ok();
    let bars = bench.read("run/export/bars.csv");
    assert!(bars.lines().nth(1).unwrap().contains(",,"), "{bars}");
}
