//! `cosmic evaluate`: the results of cases, designs and scenes.

use crate::common::Bench;
use cosmic::case::Case;
use cosmic::design::Material;
use cosmic::outcome::DesignFile;
use cosmic::scene::Scene;
use serde_json::Value;

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
