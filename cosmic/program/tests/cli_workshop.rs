//! `cosmic export`: the tables and the drawing. The tests of the Python package make drawings and solids from the tables.

use crate::common::{Bench, scene};
use cosmic::Registry;
use cosmic::design::Material;
use cosmic::lattice::Lattice;
use cosmic::outcome::DesignFile;
use cosmic::world::Span;
use serde_json::Value;
use std::collections::BTreeMap;

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
    let scene = Registry::default()
        .read(&bench.path("run/scene.toml"))
        .unwrap();
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
        let axes = ["x", "y", "z"].into_iter().take(lattice.dimension.count());
        let ends = ["from", "to"].map(|end| axes.clone().map(move |axis| format!("{end}_{axis}")));
        for (end, columns) in ends.into_iter().enumerate() {
            let place = lattice.places[lattice.edges[edge][end]] * lattice.spacing;
            for (column, place) in columns.zip(lattice.dimension.list(place)) {
                near(number(&column), place);
            }
        }
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
    let parts = table(bench, "made/parts.csv");
    let number = |part: &BTreeMap<String, String>, name: &str| part[name].parse::<f64>().unwrap();
    let all = parts
        .iter()
        .map(|part| number(part, "number") * number(part, "mass"));
    // Masses of bars and of parts are rounded to a microgram.
    assert!((all.sum::<f64>() - mass).abs() < 1e-7, "{parts:?}");
    // Joints name edges too, and nodes have numbers of their own.
    let sawn = |edge: &str| {
        let mut sawn = parts.iter().filter(|part| !part["length"].is_empty());
        sawn.find(|part| part["places"].split(' ').any(|place| place == edge))
    };
    for bar in &bars {
        assert_eq!(
            sawn(&bar["edge"]).unwrap()["length"],
            bar["rest_length"],
            "{bar:?}"
        );
    }
}

/// The set points of a period are those of the robot in open loop.
#[test]
fn the_set_points_repeat_what_the_robot_does_in_open_loop() {
    // A period has 100 steps, as many as the table has rows.
    let omega = std::f64::consts::TAU / 0.1;
    let bench = Bench::with(&scene(24, 64, ""));
    bench.ok(&format!(
        "optimize tiny.toml --quiet --out run --set controller.omega={omega} --set physics.dt=0.001"
    ));
    bench.ok("export run --csv");
    let scene = Registry::default()
        .read(&bench.path("run/scene.toml"))
        .unwrap();
    let design = DesignFile::read(&bench.path("run/design.json")).unwrap();
    let mut case = design.case(&scene, "design.json").unwrap();
    // The activations of a row are those of the step that begins then.
    let ends: Vec<usize> = (1..=101).collect();
    case.scene.physics.steps = ends.len();
    let span = Span {
        open_loop: Some(case.start.clone()),
        metered: true,
        ..Span::from_start(ends)
    };
    // Where the robot is does not matter without feedback.
    let mut far = case.start.clone();
    far.x.iter_mut().for_each(|x| *x = *x * 2.0);
    let walk = (case.world()).run_one(&case.robot().from(&far), &span);
    let efforts = walk.efforts.unwrap().of_states;
    let rows = table(&bench, "run/export/drive.csv");
    assert_eq!(rows.len(), 101);
    let (mut moved, mut actuators) = (0.0_f64, 0);
    for (edge, rest) in case.lattice.rest_length.iter().enumerate() {
        let Some(first) = rows[0].get(&format!("length_{edge}")) else {
            continue;
        };
        actuators += 1;
        for (row, effort) in rows.iter().zip(&efforts) {
            let length = row[&format!("length_{edge}")].parse::<f64>().unwrap();
            let strain = effort.activation[edge] * case.body().strain[edge];
            // Lengths are rounded to a nanometre.
            assert!((length - rest * (1.0 + strain)).abs() < 1e-9, "{row:?}");
            moved = moved.max((length - first.parse::<f64>().unwrap()).abs());
        }
    }
    assert_eq!(
        actuators,
        design
            .materials
            .iter()
            .filter(|m| **m == Material::Actuator)
            .count()
    );
    assert!(moved > 1e-3, "{moved}");
}

/// A truss with odd angles and lengths and with nodes without a bar. In this file the first payload is node 4, so this
/// node becomes node 0 of the robot. The second one weighs twice as much.
const TRUSS: &str = r#"{"format": "cosmic-truss", "version": 1,
    "nodes": [[0, 0], [0.13, 0], [0.26, 0], [0.05, 0.12], [0.19, 0.11], [0.31, 0.14], [0.4, 0.01]],
    "edges": [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [1, 4], [2, 4], [3, 4], [0, 4], [2, 5], [4, 5],
              [5, 6], [2, 6], [2, 3]], "keep": [0, 1, 2],
    "payload": [{"node": 4, "mass": 0.01}, {"node": 2, "mass": 0.02}]}"#;

#[test]
fn nodes_also_have_the_numbers_of_the_truss_file() {
    let lattice = "file = \"truss.json\"\n";
    let bench = Bench::with(&scene(24, 64, "").replace("columns = 3\nrows = 3\n", lattice));
    bench.write("truss.json", TRUSS);
    bench.run("run", "--quiet");
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

/// A robot in space has a coordinate across, and a drawing with three views of every bar.
#[test]
fn robots_in_space_have_three_coordinates_and_three_views() {
    let cubes = "kind = \"cubic\"\ncolumns = 3\ndepth = 2\nrows = 2\n";
    let bench = Bench::with(&scene(24, 64, "").replace("columns = 3\nrows = 3\n", cubes));
    bench.run("run", "--quiet");
    the_tables_are_right(&bench);
    let rows = table(&bench, "made/nodes.csv");
    let place = |row: &BTreeMap<String, String>| {
        ["x", "y", "z"].map(|axis| row[axis].parse::<f64>().unwrap())
    };
    for (k, sizes) in [[0.0, 0.1, 0.2].as_slice(), &[0.0, 0.1], &[0.0, 0.1]]
        .iter()
        .enumerate()
    {
        for row in &rows {
            assert!(
                sizes.iter().any(|size| (size - place(row)[k]).abs() < 1e-9),
                "{row:?}"
            );
        }
    }
    bench.ok("export run --svg --out made");
    let (drawing, bars) = (
        bench.read("made/drawing.svg"),
        table(&bench, "made/bars.csv"),
    );
    // Returns the two ends of a bar in a view, in metres.
    let line = |view: &str, edge: &str| {
        let line = drawing
            .split(&format!("<line id=\"{view}-{edge}\" "))
            .nth(1)
            .unwrap();
        let numbers: Vec<f64> = line
            .split('"')
            .skip(1)
            .step_by(2)
            .take(4)
            .map(|x| x.parse::<f64>().unwrap() / 1e3)
            .collect();
        [[numbers[0], numbers[1]], [numbers[2], numbers[3]]]
    };
    for bar in &bars {
        let way = ["x", "y", "z"].map(|axis| {
            let [from, to] =
                ["from", "to"].map(|end| bar[&format!("{end}_{axis}")].parse::<f64>().unwrap());
            to - from
        });
        for (view, right, up) in [("bar", 0, 2), ("above", 0, 1), ("front", 1, 2)] {
            let [from, to] = line(view, &bar["edge"]);
            assert!(
                (to[0] - from[0] - way[right]).abs() < 1e-8,
                "{view}: {bar:?}"
            );
            assert!((from[1] - to[1] - way[up]).abs() < 1e-8, "{view}: {bar:?}");
        }
    }
    // The views do not overlap.
    let size = |attribute: &str| {
        let text = drawing.split(&format!(" {attribute}=\"")).nth(1).unwrap();
        text.split('m').next().unwrap().parse::<f64>().unwrap() / 1e3
    };
    let of = |view: &str, axis: usize| -> Vec<f64> {
        let ends = bars.iter().flat_map(|bar| line(view, &bar["edge"]));
        ends.map(|end| end[axis]).collect()
    };
    let least = |numbers: Vec<f64>| numbers.into_iter().fold(f64::INFINITY, f64::min);
    let most = |numbers: Vec<f64>| numbers.into_iter().fold(0.0, f64::max);
    assert!(
        most(of("above", 1)) < least(of("bar", 1)) && most(of("bar", 0)) < least(of("front", 0))
    );
    assert!(most(of("front", 0)) < size("width") && most(of("bar", 1)) < size("height"));
}
