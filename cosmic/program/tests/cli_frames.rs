//! The script in `docs/extending.md` that makes truss files from the files of other programs.

use crate::common::Bench;
use cosmic::lattice::Truss;
use std::fs;
use std::io::{self, Write};
use std::path::Path;
use std::process::Command;

/// The script on the page.
fn script() -> String {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/extending.md");
    let page = fs::read_to_string(page).unwrap();
    let (_, script) = page.split_once("saved as `truss.py`").unwrap();
    let (_, script) = script.split_once("```python\n").unwrap();
    script.split_once("```").unwrap().0.to_owned()
}

/// A tetrahedron, once by its bars and once by its faces.
const BARS: &str = "# a frame\nv 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nl 1 2\nl 2 3\nl 1 3\nl 1 4\nl 4 2\nl 3 4\n";
const FACES: &str =
    "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nvn 0 0 1\nf 1//1 2//1 3//1\nf 1 2 4\nf 2 3 4\n";
/// A triangle in the plane, by the ends of its bars.
const ENDS: &str = "x0,y0,x1,y1\n0,0,0.1,0\n0.1, 0, 5e-2, 0.1\n0.0,-0.0,0.05,0.1\n";

#[test]
fn the_script_makes_truss_files() {
    let bench = Bench::default();
    bench.write("truss.py", script());
    let tetrahedron = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
    for (name, frame, nodes, edges) in [
        ("bars.obj", BARS, 4, &tetrahedron[..]),
        ("faces.obj", FACES, 4, &tetrahedron[..]),
        ("ends.csv", ENDS, 3, &[[0, 1], [0, 2], [1, 2]][..]),
    ] {
        bench.write(name, frame);
        let mut python = Command::new("python3");
        let python = python.args(["truss.py", name]).current_dir(bench.path(""));
        let Ok(made) = python.output() else {
            let says = b"SKIPPED: no python3: the script in docs/extending.md is not run\n";
            // Written directly, because the test harness hides what passing tests print.
            return io::stderr().write_all(says).unwrap();
        };
        assert!(made.status.success(), "{made:?}");
        bench.write("made.json", made.stdout);
        let truss = Truss::read(&bench.path("made.json")).unwrap();
        let ends = truss.edges.iter();
        // The program may renumber the nodes.
        let number = |node: usize| truss.given_number(node);
        let mut ends: Vec<[usize; 2]> = ends.map(|ends| ends.map(number)).collect();
        ends.iter_mut().for_each(|ends| ends.sort_unstable());
        ends.sort_unstable();
        assert_eq!((truss.nodes.len(), &ends[..]), (nodes, edges), "{name}");
        bench.ok("scene check tiny.toml --set lattice.file=made.json");
    }
}
