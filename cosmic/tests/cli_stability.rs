//! `cosmic verify --stability` as a user meets it.

mod common;

use common::Bench;
use std::fs;

#[test]
fn the_sweep_is_written_and_judged() {
    let bench = Bench::new(24, 64);
    let said = bench.cosmic(&["verify", &bench.scene, "--stability", "--out", "v"]);
    assert_eq!(said.code, 0, "{said:?}");
    for word in [
        "Robots at the extremes",
        "random lattices",
        "the guard",
        "0 failed",
    ] {
        assert!(said.out.contains(word), "no {word:?} in {}", said.out);
    }
    let tables = ["stable_steps", "extremes", "bound", "guard"];
    let json = bench.json("v/verify.json");
    assert_eq!(json["format"], "cosmic-verification");
    let section = &json["sections"][0];
    for (name, table) in tables.iter().zip(section["tables"].as_array().unwrap()) {
        assert_eq!(table["name"], *name);
        let rows = table["rows"].as_array().unwrap().len();
        let csv = fs::read_to_string(bench.path(&format!("v/{name}.csv"))).unwrap();
        assert_eq!(csv.lines().count(), rows + 1);
    }
    let rows = section["tables"][1]["rows"].as_array().unwrap();
    for group in [
        "scene",
        "stiffness",
        "mass",
        "ratio",
        "damping",
        "integrator",
        "time step",
        "friction",
        "layout",
        "controller",
        "coincidence",
        "lattice",
    ] {
        assert!(rows.iter().any(|row| row["extreme"] == group), "no {group}");
    }
    // What is expected to be unstable is called so, and only that.
    for row in rows {
        assert_eq!(
            row["expected"] == "unstable",
            row["said"] == "unstable",
            "{row}"
        );
        assert_eq!(
            (&row["verdict"], &row["standing"] != "failed"),
            (&"ok".into(), true)
        );
    }
    assert!(
        fs::read_to_string(bench.path("v/verify.html"))
            .unwrap()
            .contains("<table")
    );
}
