//! `cosmic study transfer`: walks of designed robots in MuJoCo.

use crate::common::Bench;
use crate::common::python::python;
use serde_json::Value;
use std::fs;

/// The page that describes all files.
pub(crate) const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/files.md");

/// Settings that give every scene of the study a robot of 3x3 nodes.
const LITTLE: &str = "[lattice]\ncolumns = 3\nrows = 3\n[physics]\nsteps = 64\n\
    [controller]\nhidden = 4\n[volume]\nwidening_over = [4, 6]\n\
    [schedule]\niterations = 20\nattraction_from = 8\nsnap_at = 14\nhorizon = [32, 64]\n\
    [binarisation]\nthreshold_over = [1, 12]\n[loss]\nwindow = 16\nevery = 4\n";

#[test]
fn a_study_of_transfer_has_its_table_and_its_figure() {
    let Some(python) = python() else { return };
    let bench = Bench::default();
    bench.write("base.toml", LITTLE);
    let python = python.display();
    let study = |more: &str| {
        let line = format!("study transfer --base base.toml --out t --runs r {more}");
        bench.cosmic(&format!("{line} --python {python}"))
    };
    let said = study("--seeds 2").ok();
    assert_eq!(said.out.lines().count(), 4, "{said:?}");
    let document = bench.read("t/transfer.md");
    for (what, count) in [
        ("\n| `incline`, 15 degrees |", 5),
        ("](transfer/transfer.svg)", 1),
        (
            "cosmic study transfer --first-seed 0 --seeds 2 --base base.toml\n",
            1,
        ),
        ("NaN", 0),
    ] {
        assert_eq!(document.matches(what).count(), count, "{what}: {document}");
    }
    // Each of the seven trials has a row for the lowest friction.
    let slippery = |line: &&str| line.split(" | ").nth(1) == Some("0.60");
    assert_eq!(document.lines().filter(slippery).count(), 7, "{document}");
    let kept = bench.json("r/runs/coulomb-1/transfer.json");
    let walks = |k: usize| kept["walks"][k].as_array().unwrap();
    assert!((0..4).all(|k| walks(k).len() == 8 && walks(k).iter().all(Value::is_number)));
    // The scene itself has Coulomb's law with this friction, so the same rollouts gave its median.
    let p50 = bench.json("r/runs/coulomb-1/summary.json")["displacement_p50"].take();
    assert_eq!(kept["own"][1], p50);
    names_are_on_the_page(&bench);
    // If a seed is added, the finished walks of the other seeds are not repeated.
    let path = "r/runs/coulomb-1/transfer.json";
    bench.write(path, bench.read(path).replace("4.0.", "3.0."));
    study("--seeds 3").ok();
    assert!(bench.read(path).contains("3.0."));
    assert_eq!(bench.lines("t/transfer.csv"), 1 + 21);
}

/// Asserts that `docs/files.md` describes every key in the files of the study and of the export.
fn names_are_on_the_page(bench: &Bench) {
    let page = fs::read_to_string(PAGE).unwrap();
    let header = bench.read("t/transfer.csv");
    let mut names: Vec<String> = header
        .lines()
        .next()
        .unwrap()
        .split(',')
        .map(str::to_owned)
        .collect();
    let run = "r/runs/stability-0";
    let files = ["transfer.json", "export/controller.json"].map(|file| format!("{run}/{file}"));
    let mut keys = |value: &Value| names.extend(value.as_object().unwrap().keys().cloned());
    files.iter().for_each(|file| keys(&bench.json(file)));
    for table in bench.json("t/transfer.json")["tables"].as_array().unwrap() {
        keys(&table["rows"][0]);
    }
    names.retain(|name| !page.contains(&format!("`{name}`")));
    assert_eq!(names, [""; 0]);
}

#[test]
fn a_study_of_transfer_without_mujoco_says_how_to_get_it() {
    let bench = Bench::default();
    for python in ["nowhere/python", "false"] {
        let told = bench.cosmic(&format!("study transfer --python {python}"));
        told.fails(
            2,
            &[
                python,
                "pip install mujoco numpy",
                "--python mujoco/bin/python",
            ],
        );
    }
    assert!(!bench.path("runs").exists());
}
