//! `cosmic evaluate`: the results of cases, designs and scenes.

use crate::common::Bench;
use cosmic::case::Case;
use cosmic::design::Material;
use cosmic::record::DesignFile;
use cosmic::scene::Scene;
use serde_json::{Value, json};

fn small_scene() -> Scene {
    let text = "base = \"stability\"\n[lattice]\ncolumns = 3\nrows = 2\ndrop = 0.003\n[physics]\nsteps = 2048\n\
                [schedule]\nhorizon = [2048, 2048]\n[controller]\nhidden = 4\n";
    Scene::parse("small", text).unwrap()
}

/// Makes a folder with one small robot in two forms: as `design.json` with `scene.toml`, and as `case.json`.
fn folder() -> Bench {
    let bench = Bench::default();
    let scene = small_scene();
    bench.write("scene.toml", scene.to_toml());
    let case = Case::of_scene(&scene, 7).unwrap();
    let materials = vec![Material::Void; case.design.edges()];
    let design = DesignFile::new(&case.lattice, &case.design, &materials, &case.controller);
    design.write(&bench.path("design.json")).unwrap();
    bench.write("case.json", case.to_json());
    bench
}

/// Changes a JSON file.
fn edit(folder: &Bench, file: &str, change: impl FnOnce(&mut Value)) {
    let mut json = folder.json(file);
    change(&mut json);
    folder.write(file, json.to_string());
}

/// Runs `evaluate`, asserts that it succeeds, and returns its `results`.
fn results(folder: &Bench, line: &str) -> Value {
    let told = folder.cosmic(&format!("evaluate {line}"));
    told.json()["results"].take()
}

fn steps(results: &Value) -> Vec<&String> {
    results["trajectory"].as_object().unwrap().keys().collect()
}

#[test]
fn a_case_a_design_and_a_scene_of_one_robot_give_the_same_results() {
    let folder = folder();
    let case = results(&folder, "case.json --gradient");
    // A design file has no thresholds and no multipliers. It gets the thresholds of its scene, and multipliers of zero.
    // This case has the same numbers.
    assert_eq!(case, results(&folder, "design.json --gradient"));
    assert_eq!(steps(&case), ["0", "1", "2", "2048", "3"]);
    assert!(case["grad_l_disp"]["x0"].is_array());
    assert!(case.get("augmented_performance_constraints").is_none());
    // A robot that is read from a scene gets the controller of seed 0, but this case has the controller of seed 7.
    let scene = results(&folder, "scene.toml --record 5,1");
    assert_eq!(scene["node_mass"], case["node_mass"]);
    assert_ne!(scene["u0"], case["u0"]);
    assert_eq!(steps(&scene), ["1", "5"]);
    assert!(scene.get("grad_l_disp").is_none());
}

/// A design that was snapped is simulated with its exact layout. If its mixtures came from the softmax, a void edge
/// would keep a share of 2e-9 of solid material.
#[test]
fn a_snapped_design_is_exact() {
    let folder = folder();
    edit(&folder, "design.json", |json| {
        let edges = json["z"].as_array().unwrap().len();
        let materials: Vec<usize> = (0..edges).map(|e| e % 3).collect();
        let one_hot = |&m: &usize| json!([0, 1, 2].map(|k| u8::from(k == m)));
        json["z"] = materials.iter().map(one_hot).collect();
        json["materials"] = json!(materials);
    });
    let design = results(&folder, "design.json --record 0");
    assert_eq!(design["z_projected"][2], json!([0.0, 0.0, 1.0]));
    assert_eq!(design["g_bin"], 0.0);
}

#[test]
fn edges_run_in_either_direction() {
    let folder = folder();
    let forward = results(&folder, "case.json");
    edit(&folder, "case.json", |json| {
        json["edges"][3].as_array_mut().unwrap().reverse();
    });
    assert_eq!(results(&folder, "case.json"), forward);
}

/// A case may have one row or one column.
#[test]
fn lattices_of_one_row_or_column_are_evaluated() {
    let folder = Bench::default();
    for (columns, rows) in [(5, 1), (1, 4), (2, 1)] {
        let mut scene = small_scene();
        (scene.lattice.columns, scene.lattice.rows) = (columns, rows);
        scene.physics.steps = 16;
        folder.write("case.json", Case::of_scene(&scene, 0).unwrap().to_json());
        let results = results(&folder, "case.json --gradient");
        let masses = results["node_mass"].as_array().unwrap();
        assert_eq!(masses.len(), columns * rows);
    }
}
