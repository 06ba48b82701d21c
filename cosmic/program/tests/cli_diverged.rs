//! `cosmic evaluate` of rollouts and gradients that are no numbers: what it says, writes and keeps.

use cosmic::case::Case;
use cosmic::scene::Scene;
use serde_json::{Value, json};
use std::fs;
use tempfile::TempDir;

use crate::program::{Told, cosmic_in};

/// A folder with `case.json`, a small robot in steps that are far too long.
fn folder() -> TempDir {
    let text = "[lattice]\ncolumns = 3\nrows = 2\ndrop = 0.003\n[controller]\nhidden = 4\n\
                [physics]\nsteps = 2048\ndt = 0.5\n[schedule]\nhorizon = [2048, 2048]\n";
    let folder = tempfile::tempdir().unwrap();
    let case = Case::of_scene(&Scene::parse("small", text).unwrap(), 7).unwrap();
    fs::write(folder.path().join("case.json"), case.to_json()).unwrap();
    folder
}

fn evaluate(folder: &TempDir, arguments: &[&str]) -> Told {
    cosmic_in(folder.path(), &[&["evaluate"], arguments].concat())
}

#[test]
fn a_divergence_is_told_kept_and_seen_again() {
    let folder = folder();
    let told = evaluate(&folder, &["case.json", "--gradient"]);
    assert_eq!(told.code, 3, "{}", told.error);
    let news = told.error.lines().last().unwrap();
    assert!(news.starts_with("error: diverged in step "), "{news}");
    assert!(
        news.contains(": node ") && news.contains(" m, velocity ["),
        "{news}"
    );
    assert!(
        told.error.contains("cosmic evaluate diverged.json"),
        "{}",
        told.error
    );
    assert!(
        told.error.contains("not finite, written as null: "),
        "{}",
        told.error
    );
    assert!(told.error.contains("trajectory.2048.x"), "{}", told.error);
    let json: Value = serde_json::from_str(&told.out).unwrap();
    assert!(json["results"]["l_disp"].is_null());

    let again = evaluate(&folder, &["diverged.json"]);
    assert_eq!((again.code, again.error.lines().last().unwrap()), (3, news));
    let kept: Value =
        serde_json::from_str(&fs::read_to_string(folder.path().join("diverged.json")).unwrap())
            .unwrap();
    assert_eq!(kept["format"], "cosmic-case");
    let states = kept["results"]["trajectory"].as_object().unwrap();
    assert!(states.contains_key(&kept["steps"].to_string()) && states.len() > 1);
}

/// The exact layout of a snapped design goes along.
#[test]
fn a_diverging_layout_is_seen_again() {
    let folder = tempfile::tempdir().unwrap();
    let text = "[start]\nkind = \"layout\"\n[schedule]\nsnap_at = 0\n[physics]\ndt = 0.2\n";
    fs::write(folder.path().join("wild.toml"), text).unwrap();
    let first = evaluate(&folder, &["wild.toml"]);
    assert_eq!(first.code, 3, "{}", first.error);
    let last_line = |told: &Told| told.error.lines().last().unwrap().to_owned();
    let again = evaluate(&folder, &["diverged.json"]);
    assert_eq!((again.code, last_line(&again)), (3, last_line(&first)));
    let shares = |told: &Told| {
        let json: Value = serde_json::from_str(&told.out).unwrap();
        json["results"]["z_projected"].clone()
    };
    assert_eq!(shares(&again), shares(&first));
    assert!(
        shares(&again)
            .as_array()
            .unwrap()
            .contains(&json!([1.0, 0.0, 0.0]))
    );
}

#[test]
fn the_last_states_lie_beside_the_results() {
    let folder = folder();
    fs::create_dir(folder.path().join("sub")).unwrap();
    let told = evaluate(&folder, &["case.json", "--out", "sub/results.json"]);
    assert_eq!(told.code, 3, "{}", told.error);
    assert!(folder.path().join("sub/diverged.json").exists());
    assert!(folder.path().join("sub/results.json").exists());
    assert!(!folder.path().join("diverged.json").exists());
}

#[test]
fn results_and_last_states_keep_apart() {
    let folder = folder();
    let told = evaluate(&folder, &["case.json", "--out", "diverged.json"]);
    let says = "error: --out: diverged.json is where the last states go";
    assert!(told.code == 2 && told.error.starts_with(says), "{told:?}");
    assert!(!folder.path().join("diverged.json").exists());
    #[cfg(unix)]
    {
        // Beside a device is no place for a file.
        let told = evaluate(&folder, &["case.json", "--out", "/dev/null"]);
        assert_eq!(told.code, 3, "{}", told.error);
        assert!(folder.path().join("diverged.json").exists());
        assert!(!std::path::Path::new("/dev/diverged.json").exists());
    }
}

/// Every state is finite, and no derivative is: without damping small changes grow for ever.
#[test]
fn a_gradient_that_overflows_is_told_with_its_step() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(
        folder.path().join("wild.toml"),
        "[physics]\ndamping = 0.0\n",
    )
    .unwrap();
    assert_eq!(evaluate(&folder, &["wild.toml"]).code, 0);
    let told = evaluate(&folder, &["wild.toml", "--gradient"]);
    assert_eq!(told.code, 3, "{}", told.error);
    let says = "error: not finite: grad_augmented.z, grad_l_disp.b1, ";
    assert!(told.error.starts_with(says), "{}", told.error);
    let news = told.error.split("; the reverse sweep overflows in step ");
    let news = news.last().unwrap();
    assert!(news.contains(", first at node "), "{}", told.error);
    let step: usize = news.split(',').next().unwrap().parse().unwrap();
    // What it grows by in a few hundred steps is far from all that a float holds.
    assert!((1..8192 - 300).contains(&step), "{}", told.error);
    assert!(!folder.path().join("diverged.json").exists());
}
