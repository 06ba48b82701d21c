//! `cosmic verify` as a user meets it.

use serde_json::Value;
use std::fs;

use crate::program::cosmic_in;

const SMALL: &str = "[lattice]\ncolumns = 2\nrows = 2\n\
                     [physics]\nsteps = 64\nintegrator = \"leapfrog\"\nsubsteps = 2\n\
                     [schedule]\nhorizon = [32, 64]\n[loss]\nwindow = 16\nevery = 4\n\
                     [controller]\nhidden = 2\n";

/// Before minutes of work, not after.
#[test]
fn a_folder_that_cannot_be_is_refused_first() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("small.toml"), SMALL).unwrap();
    let told = cosmic_in(
        folder.path(),
        &["verify", "small.toml", "--out", "small.toml"],
    );
    assert!(
        told.code == 4 && told.out.is_empty() && told.error.contains("cannot write small.toml"),
        "{told:?}"
    );
}

#[test]
fn a_scene_is_verified_into_a_folder() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("small.toml"), SMALL).unwrap();
    let told = cosmic_in(
        folder.path(),
        &["verify", "small.toml", "--out", "new/sheet", "--json"],
    );
    assert_eq!(told.code, 0, "{}", told.error);
    let sheet = folder.path().join("new/sheet");
    let read = |name: &str| fs::read_to_string(sheet.join(name)).unwrap();

    let json: Value = serde_json::from_str(&read("verify.json")).unwrap();
    assert_eq!(
        (&json["format"], &json["version"]),
        (&"cosmic-verification".into(), &1.into())
    );
    let said: Value = serde_json::from_str(&told.out).unwrap();
    assert_eq!(said["sections"], json["sections"]);
    let sections = json["sections"].as_array().unwrap();
    let titles: Vec<_> = sections
        .iter()
        .map(|s| s["title"].as_str().unwrap())
        .collect();
    assert_eq!(
        titles,
        ["Accuracy of trajectories", "Gradients", "Stability"]
    );

    // The scene's own integrator is a row, and marked as what the scene asks for.
    let rows = sections[0]["tables"][0]["rows"].as_array().unwrap();
    let marked: Vec<_> = rows
        .iter()
        .filter(|row| row["standing"] == "default")
        .collect();
    assert_eq!(marked.len(), 1);
    assert_eq!(marked[0]["method"], "leapfrog x2");
    assert_eq!(
        (&marked[0]["dt_s"], &marked[0]["precision"]),
        (&0.002.into(), &"f64".into())
    );

    // As many lines as rows, below the heading; every figure is there and on the page.
    assert_eq!(read("accuracy.csv").lines().count(), rows.len() + 1);
    let page = read("verify.html");
    for figure in ["work_precision.svg", "gradient_error.svg"] {
        assert!(page.contains(&read(figure)), "{figure}");
    }
    assert!(
        !page.contains("http://")
            || page.matches("http://").count()
                == page.matches("http://www.w3.org/2000/svg").count()
    );
    let written: Vec<&str> = told.error.lines().collect();
    for (k, line) in written.iter().enumerate() {
        assert!(folder.path().join(line).is_file(), "{line}");
        assert!(!written[..k].contains(line), "{line} twice");
    }
}

#[test]
fn one_part_is_enough_and_its_failures_are_an_exit_code() {
    let folder = tempfile::tempdir().unwrap();
    let stiff = format!("{SMALL}[materials]\nstiffness = [1e6, 1e6, 1e6]\n");
    fs::write(folder.path().join("stiff.toml"), stiff).unwrap();
    let told = cosmic_in(folder.path(), &["verify", "stiff.toml", "--stability"]);
    assert_eq!(told.code, 1, "{told:?}");
    assert!(
        told.error.contains("error: 1 of ") && told.error.contains(" checks failed: the scene's"),
        "{}",
        told.error
    );
    assert!(told.out.contains("STABILITY") && !told.out.contains("GRADIENTS"));
    let told = cosmic_in(folder.path(), &["verify", "stabilty"]);
    assert_eq!(told.code, 4, "{told:?}");
}
