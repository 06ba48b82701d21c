//! `cosmic verify --stability` as a user meets it.

use crate::program::cosmic_in;
use serde_json::Value;
use std::fs;

#[test]
fn the_sweep_is_written_and_judged() {
    let folder = tempfile::tempdir().unwrap();
    let text = "[lattice]\ncolumns = 2\nrows = 2\n[controller]\nhidden = 2\n";
    fs::write(folder.path().join("tiny.toml"), text).unwrap();
    let verify = ["verify", "tiny.toml", "--stability", "--out", "v"];
    let told = cosmic_in(folder.path(), &verify);
    let out = told.out;
    assert_eq!(told.code, 0, "{out}");
    for word in [
        "Robots at the extremes",
        "random lattices",
        "the guard",
        "0 failed",
    ] {
        assert!(out.contains(word), "no {word:?} in {out}");
    }
    let tables = ["stable_steps", "extremes", "bound", "guard"];
    let read = |name: &str| fs::read_to_string(folder.path().join("v").join(name)).unwrap();
    let json: Value = serde_json::from_str(&read("verify.json")).unwrap();
    assert_eq!(json["format"], "cosmic-verification");
    let section = &json["sections"][0];
    for (name, table) in tables.iter().zip(section["tables"].as_array().unwrap()) {
        assert_eq!(table["name"], *name);
        let rows = table["rows"].as_array().unwrap().len();
        assert_eq!(read(&format!("{name}.csv")).lines().count(), rows + 1);
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
    assert!(read("verify.html").contains("<table"));
}
