//! `cosmic export`: the tables and the drawing. The tests of the Python package make drawings and solids from the tables.

use crate::common::{Bench, scene};
use cosmic::lattice::Lattice;
use cosmic::record::DesignFile;
use cosmic::scene::Scene;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;

/// Makes a test folder with a finished run. `lattice` replaces the keys of the scene's lattice, and `truss` is the text of
/// the file `truss.json`.
fn finished(lattice: &str, truss: &str) -> Bench {
    let bench = Bench::with(&scene(24, 64, "").replace("columns = 3\nrows = 3\n", lattice));
    bench.write("truss.json", truss);
    bench.run("run", "--quiet");
    bench
}

/// Returns the rows of a table, each with its cells by the names of their columns.
fn table(bench: &Bench, name: &str) -> Vec<BTreeMap<String, String>> {
    let text = bench.read(name);
    let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned));
    let head: Vec<String> = lines.next().unwrap().collect();
    let row = |cells| head.iter().cloned().zip(cells).collect();
    lines.map(row).collect()
}

/// Asserts that the tables describe the bars of the run. The last digit of a number is a nanometre or a microgram.
fn the_tables_are_right(bench: &Bench) {
    bench.ok("export run --csv --out made");
    let scene = Scene::read(&bench.path("run/scene.toml")).unwrap();
    let design = DesignFile::read(&bench.path("run/design.json")).unwrap();
    let lattice = Lattice::new(&scene.lattice, &scene.physics);
    let body = design.case(&scene, "design.json").unwrap().body();
    let solid = design.materials.iter().filter(|m| m.is_solid()).count();
    let bars = table(bench, "made/bars.csv");
    assert_eq!(bars.len(), solid);
    let mut mass = 0.0;
    for bar in &bars {
        let number = |name: &str| bar[name].parse::<f64>().unwrap();
        let edge = number("edge") as usize;
        let near = |a: f64, b: f64| assert!((a - b).abs() < 2e-9, "{bar:?}: {a}, not {b}");
        assert_eq!(
            ["from", "to"].map(number),
            lattice.edges[edge].map(|node| node as f64)
        );
        near(number("rest_length"), lattice.rest_length[edge]);
        let way =
            ["x", "y"].map(|axis| number(&format!("to_{axis}")) - number(&format!("from_{axis}")));
        near(way[0].hypot(way[1]), lattice.rest_length[edge]);
        near(number("stiffness"), body.stiffness[edge]);
        near(
            number("stroke"),
            body.strain[edge] * lattice.rest_length[edge],
        );
        let peaks = ["peak_tension", "peak_compression"].map(number);
        near(number("peak_force"), peaks[0].max(peaks[1]));
        mass += number("mass");
    }
    let nodes = table(bench, "made/nodes.csv");
    let extra = |node: &BTreeMap<String, String>| {
        ["node_mass", "payload"].map(|name| node[name].parse::<f64>().unwrap())
    };
    mass += nodes.iter().flat_map(extra).sum::<f64>();
    // The void edges of the body weigh 1e-8 kg/m, and nodes without bars are not in the table.
    let bare = (lattice.nodes() - nodes.len()) as f64 * scene.physics.node_mass;
    assert!((mass + bare - body.mass.iter().sum::<f64>()).abs() < 1e-6);
}

#[test]
fn tables_describe_the_bars_of_squares_and_of_triangles() {
    the_tables_are_right(&finished("columns = 6\nrows = 5\n", ""));
    let triangles = "columns = 5\nrows = 4\nkind = \"triangular\"\n";
    the_tables_are_right(&finished(triangles, ""));
}

#[test]
fn without_options_everything_is_written_into_the_run_s_folder() {
    let bench = Bench::default();
    bench.run("run", "--quiet");
    let before = bench.results("run");
    let told = bench.cosmic("export run").ok();
    let names = [
        "bars.csv",
        "nodes.csv",
        "drawing.svg",
        "robot.xml",
        "controller.json",
        "walk.py",
    ];
    let written = names.map(|name| format!("run/export/{name}"));
    assert!(told.out.lines().eq(&written), "{told:?}");
    let drawing = bench.read("run/export/drawing.svg");
    let bars = table(&bench, "run/export/bars.csv");
    assert_eq!(drawing.matches("<line id=\"bar-").count(), bars.len());
    numbers_are_plain(&bench, "run/export");
    fs::remove_dir_all(bench.path("run/export")).unwrap();
    assert_eq!(bench.results("run"), before);
    let told = bench.cosmic("export run --svg --json --out made").json();
    assert_eq!(told["written"], serde_json::json!(["made/drawing.svg"]));
    let told = bench.cosmic("export run --csv --quiet --out made").ok();
    assert_eq!((&told.out[..], &told.error[..]), ("", ""));
    // The payload is at node 0.
    let nodes = bench.read("made/nodes.csv");
    let head = "node,x,y,bars,node_mass,payload,given_node\n";
    assert!(nodes.starts_with(head), "{nodes}");
    assert!(
        nodes.contains("\n0,0,0,") && nodes.contains(",0.0001,0.03,"),
        "{nodes}"
    );
    // A run may end before the snap. Then the exported robot differs from the robot that moved.
    bench.unfinished("half", 12);
    let told = bench.cosmic("export half --csv").ok();
    assert!(told.error.contains("the design is undecided"), "{told:?}");
}

/// Asserts that numbers in the files are easy to read: no exponents, and no rounding noise in the last digits.
fn numbers_are_plain(bench: &Bench, folder: &str) {
    for (name, most) in [("bars.csv", 9), ("nodes.csv", 9), ("drawing.svg", 6)] {
        let text = bench.read(&format!("{folder}/{name}"));
        let is_part = |c: char| c.is_ascii_alphanumeric() || ".+-".contains(c);
        let words = text.split(|c| !is_part(c));
        let numbers = words.filter(|word| word.parse::<f64>().is_ok());
        let mut count = 0;
        for number in numbers {
            assert!(!number.contains(['e', 'E']), "{name}: {number}");
            let decimals = number.split_once('.').map_or(0, |(_, end)| end.len());
            assert!(decimals <= most, "{name}: {number}");
            count += 1;
        }
        assert!(count > 10, "{name}");
    }
}

/// Parts have a section, a mass and a stiffness that follow from the length of the bar.
#[test]
fn a_bar_that_is_a_part_has_its_section() {
    let parts = "[parts]\nskeleton = \"tube\"\nactuator = \"device\"\nactuator_mass = 0.02\nstroke = 0.2\n\
                 end_mass = 0.001\n";
    let bench = Bench::with(&(scene(24, 64, "integrator = \"implicit\"") + parts));
    bench.run("run", "--quiet --allow-unstable");
    let told = bench.cosmic("export run").ok();
    assert!(
        told.error.contains("--mujoco was left out") && told.error.contains("--rigid"),
        "{told:?}"
    );
    let kinds: Vec<[String; 4]> = table(&bench, "run/export/bars.csv")
        .iter()
        .map(|bar| ["material", "part", "outer", "inner"].map(|name| bar[name].clone()))
        .collect();
    let tube = ["skeleton", "tube", "0.006", "0.004"].map(str::to_owned);
    let device = ["actuator", "device", "", ""].map(str::to_owned);
    assert!(
        kinds.contains(&tube) && kinds.contains(&device),
        "{kinds:?}"
    );
    assert!(kinds.iter().all(|kind| [&tube, &device].contains(&kind)));
}

/// A truss with odd angles and lengths and with nodes without a bar. In this file the payload is node 4, so this node
/// becomes node 0 of the robot.
const TRUSS: &str = r#"{"format": "cosmic-truss", "version": 1,
    "nodes": [[0, 0], [0.13, 0], [0.26, 0], [0.05, 0.12], [0.19, 0.11], [0.31, 0.14], [0.4, 0.01]],
    "edges": [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [1, 4], [2, 4], [3, 4], [0, 4], [2, 5], [4, 5],
              [5, 6], [2, 6], [2, 3]], "payload": 4, "keep": [0, 1, 2]}"#;

#[test]
fn nodes_also_have_the_numbers_of_the_truss_file() {
    let bench = finished("file = \"truss.json\"\n", TRUSS);
    the_tables_are_right(&bench);
    let given: Value = serde_json::from_str(TRUSS).unwrap();
    let mut has_moved = false;
    for row in table(&bench, "made/nodes.csv") {
        let place = &given["nodes"][row["given_node"].parse::<usize>().unwrap()];
        // The robot's origin is the lower left corner of the truss. Here this is also the origin of the truss file.
        for (k, cell) in ["x", "y"].iter().map(|axis| &row[*axis]).enumerate() {
            let off = cell.parse::<f64>().unwrap() - place[k].as_f64().unwrap();
            // Rounding: positions are stored in units of the lattice spacing and written to 1e-9 m.
            assert!(off.abs() < 1e-9, "{row:?}: {place}");
        }
        has_moved |= row["node"] != row["given_node"];
    }
    assert!(has_moved);
}

#[test]
fn an_impossible_export_is_refused() {
    let bench = Bench::default();
    bench.run("run", "--quiet");
    for (line, code, says) in [
        ("export nowhere", 4, "nowhere"),
        ("export stability --csv", 2, "this command needs a run"),
        ("export run --set physics.gravity=3", 2, "--set works only"),
        (
            "export run --csv --out tiny.toml",
            4,
            "cannot write tiny.toml",
        ),
    ] {
        bench.cosmic(line).fails(code, &[says]);
        assert!(!bench.path("run/export").exists(), "{line}");
    }
    // A kind that was asked for and cannot be made is an error. The other kinds are written all the same.
    let rough = scene(24, 64, "") + "[ground]\nprofile = \"rough\"\n";
    let bench = Bench::with(&rough);
    bench.run("run", "--quiet");
    let told = bench.cosmic("export run --csv --mujoco");
    let says = ["error: --mujoco: ", "(its files were not written)"];
    told.fails(2, &says);
    assert_eq!(told.out, "run/export/bars.csv\nrun/export/nodes.csv\n");
}
