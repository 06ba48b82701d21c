//! `cosmic evaluate`: inputs, outputs and errors.

use crate::common::Bench;
use crate::program::{Told, command};
use cosmic::case::Case;
use cosmic::design::Material;
use cosmic::record::DesignFile;
use cosmic::scene::Scene;
use serde_json::{Value, json};
use std::fs;
use std::io::Write;
use std::process::Stdio;

fn small_scene(physics: &str) -> Scene {
    let text = format!(
        "base = \"stability\"\n[lattice]\ncolumns = 3\nrows = 2\ndrop = 0.003\n[physics]\nsteps = 2048\n{physics}\n\
         [schedule]\nhorizon = [2048, 2048]\n[controller]\nhidden = 4\n"
    );
    Scene::parse("small", &text).unwrap()
}

/// Makes a folder with one small robot in two forms: as `design.json` with `scene.toml`, and as `case.json`. `physics`
/// is added to the scene's section `[physics]`.
pub(crate) fn folder(physics: &str) -> Bench {
    let bench = Bench::default();
    let scene = small_scene(physics);
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

pub(crate) fn evaluate(folder: &Bench, line: &str) -> Told {
    folder.cosmic(&format!("evaluate {line}"))
}

/// Runs `evaluate`, asserts that it succeeds, and returns its `results`.
fn results(folder: &Bench, line: &str) -> Value {
    evaluate(folder, line).json()["results"].take()
}

fn steps(results: &Value) -> Vec<&String> {
    results["trajectory"].as_object().unwrap().keys().collect()
}

#[test]
fn a_case_a_design_and_a_scene_of_one_robot_give_the_same_results() {
    let folder = folder("");
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

#[test]
fn out_writes_the_results_to_a_file() {
    let folder = folder("");
    let printed = evaluate(&folder, "case.json");
    let told = evaluate(&folder, "case.json --out results.json").ok();
    assert_eq!(told.out, "");
    assert_eq!(folder.read("results.json"), printed.out);
}

#[test]
fn built_in_scenes_are_run_from_their_start() {
    let folder = Bench::default();
    let layout = results(&folder, "baseline_tall --record 0");
    let rows = layout["z_projected"].as_array().unwrap().iter();
    let mut shares = rows.flat_map(|row| row.as_array().unwrap());
    assert!(shares.all(|s| s == 0.0 || s == 1.0));
    let soft = results(&folder, "stability --record 0");
    assert!(soft["z_projected"][0][0].as_f64().unwrap() < 0.5);
}

/// A design that was snapped is simulated with its exact layout. If its mixtures came from the softmax, a void edge
/// would keep a share of 2e-9 of solid material.
#[test]
fn a_snapped_design_is_exact() {
    let folder = folder("");
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
    let folder = folder("");
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
        let mut scene = small_scene("");
        (scene.lattice.columns, scene.lattice.rows) = (columns, rows);
        scene.physics.steps = 16;
        folder.write("case.json", Case::of_scene(&scene, 0).unwrap().to_json());
        let results = results(&folder, "case.json --gradient");
        let masses = results["node_mass"].as_array().unwrap();
        assert_eq!(masses.len(), columns * rows);
    }
}

/// More errors are tested with the reader of cases.
#[test]
fn wrong_cases_and_designs_are_refused() {
    let folder = folder("");
    for (file, key, value, says) in [
        (
            "case.json",
            "/z",
            json!([[0, 0, 0]]),
            "expected 11 rows of `z`, found 1",
        ),
        (
            "design.json",
            "/materials/0",
            json!(3),
            "3 is not a material",
        ),
        (
            "design.json",
            "/z/0/1",
            Value::Null,
            "invalid type: null, expected a number",
        ),
        ("design.json", "/version", json!(9), "version 9"),
        (
            "design.json",
            "/edges/1",
            json!([0, 2]),
            "`edges[1]`: [0, 2] is not an edge of the scene's lattice",
        ),
        (
            "design.json",
            "/materials",
            json!([0]),
            "expected 11 entries in `materials`, found 1",
        ),
        (
            "design.json",
            "/controller",
            json!({ "colour": [1] }),
            "unknown block `controller.colour`; expected `w1`, `b1`, `w2`, `b2`",
        ),
        (
            "design.json",
            "/controller/b1",
            json!([0.0]),
            "expected 4 entries in `controller.b1`, found 1",
        ),
    ] {
        let right = folder.read(file);
        edit(&folder, file, |json| {
            *json.pointer_mut(key).unwrap() = value
        });
        let told = evaluate(&folder, file);
        told.fails(2, &[says, file]);
        assert_eq!(told.out, "");
        folder.write(file, right);
    }
    let wider = small_scene("").to_toml();
    folder.write("scene.toml", wider.replace("columns = 3", "columns = 4"));
    let says = "error: expected 16 `edges`, found 11\n --> design.json:";
    evaluate(&folder, "design.json").fails(2, &[says]);
    edit(&folder, "design.json", |json| json["colour"] = json!(1));
    evaluate(&folder, "design.json").fails(2, &["unknown field `colour`"]);
}

/// Three things do not matter: a byte order mark, the name of the file, and another key whose value is the name of a
/// format.
#[test]
fn a_case_is_recognised_by_its_content() {
    let folder = folder("");
    edit(&folder, "case.json", |json| {
        json["name"] = json!("cosmic-design");
    });
    let text = folder.read("case.json");
    let plain = evaluate(&folder, "case.json").ok().out;
    for name in ["case.json", "case"] {
        folder.write(name, format!("\u{feff}{text}"));
        assert_eq!(evaluate(&folder, name).ok().out, plain);
    }
}

#[test]
fn missing_and_unwritable_files_exit_with_4() {
    let folder = folder("");
    // A folder stands for the design in it.
    fs::create_dir(folder.path("empty")).unwrap();
    fs::remove_file(folder.path("scene.toml")).unwrap();
    for (line, says) in [
        ("no/such.json", "cannot read no/such.json"),
        ("stabilty", "did you mean `stability`?"),
        (
            "empty",
            "cannot read empty: it is not the folder of a run, because it has no design.json",
        ),
        ("design.json", "cannot read scene.toml"),
        (
            "case.json --out no/such/folder/results.json",
            "cannot write no/such/folder/results.json",
        ),
    ] {
        evaluate(&folder, line).fails(4, &[says]);
    }
    let told = folder.cosmic("check stabilty");
    told.fails(4, &["did you mean `stability`?"]);
    assert_eq!(told.out, "");
}

/// Runs `cosmic` with piped input.
#[cfg(unix)]
fn piped(line: &str, bytes: &[u8]) -> Told {
    let mut command = command(line);
    let [input, out, error] = [(); 3].map(|()| Stdio::piped());
    let child = command.stdin(input).stdout(out).stderr(error).spawn();
    let mut child = child.unwrap();
    child.stdin.take().unwrap().write_all(bytes).unwrap();
    Told::of(child.wait_with_output().unwrap())
}

/// A pipe can be read only once, and its name says nothing about its content.
#[cfg(unix)]
#[test]
fn scenes_and_cases_come_through_pipes() {
    let folder = folder("");
    for name in ["scene.toml", "case.json"] {
        let piped = piped("evaluate /dev/stdin", folder.read(name).as_bytes());
        assert_eq!(piped.out, evaluate(&folder, name).out);
    }
    piped("check /dev/stdin", b"[physics]\nsteps = -1\n").fails(2, &[]);
}

#[test]
fn steps_beyond_the_rollout_are_refused() {
    let folder = folder("");
    let says = "step 2049 cannot be recorded: the rollout has only 2048 steps";
    evaluate(&folder, "case.json --record 1,2049").fails(2, &[says]);
    evaluate(&folder, "case.json --record -1").fails(2, &[]);
    edit(&folder, "case.json", |case| {
        case["results"] = json!({ "trajectory": { "2049": null } });
    });
    let says = "error: `results.trajectory` has step 2049, but the rollout has only 2048 steps";
    evaluate(&folder, "case.json").fails(2, &[says]);
}
