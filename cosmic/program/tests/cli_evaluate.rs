//! `cosmic evaluate` as a user meets it: what it takes, what it writes, and what it refuses.

use cosmic::case::Case;
use cosmic::design::Material;
use cosmic::record::DesignFile;
use cosmic::scene::Scene;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

use crate::program::{Told, command, cosmic_in};
use std::io::Write;
use std::process::Stdio;

/// A folder with a small robot in it: `scene.toml`, `design.json` and the same as `case.json`.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let scene = small_scene();
    fs::write(folder.path().join("scene.toml"), scene.to_toml()).unwrap();
    let case = Case::of_scene(&scene, 7).unwrap();
    design(&case)
        .write(&folder.path().join("design.json"))
        .unwrap();
    fs::write(folder.path().join("case.json"), case.to_json()).unwrap();
    folder
}

fn small_scene() -> Scene {
    let text = "[lattice]\ncolumns = 3\nrows = 2\ndrop = 0.003\n\
                [physics]\nsteps = 2048\n[schedule]\nhorizon = [2048, 2048]\n[controller]\nhidden = 4\n";
    Scene::parse("small", text).unwrap()
}

fn design(case: &Case) -> DesignFile {
    let materials = vec![Material::Void; case.z.len()];
    DesignFile::new(&case.lattice, &case.z, &materials, &case.controller)
}

/// Changes a JSON file.
fn edit(path: &Path, change: impl FnOnce(&mut Value)) {
    let mut json = serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap();
    change(&mut json);
    fs::write(path, json.to_string()).unwrap();
}

fn evaluate(folder: &TempDir, arguments: &[&str]) -> Told {
    cosmic_in(folder.path(), &[&["evaluate"], arguments].concat())
}

/// The `results` of a run that must succeed.
fn results(told: &Told) -> Value {
    assert_eq!(told.code, 0, "{}", told.error);
    let json: Value = serde_json::from_str(&told.out).unwrap();
    json["results"].clone()
}

#[test]
fn a_case_a_design_and_a_scene_are_run_alike() {
    let folder = folder();
    let by_case = evaluate(&folder, &["case.json", "--gradient"]);
    let by_design = evaluate(&folder, &["design.json", "--gradient"]);
    let mut case = results(&by_case);
    let mut design = results(&by_design);
    // A scene has its own thresholds, and multipliers of zero: as the case here.
    assert_eq!(case, design);
    let keys: Vec<_> = case["trajectory"]
        .as_object()
        .unwrap()
        .keys()
        .cloned()
        .collect();
    assert_eq!(keys, ["0", "1", "2", "2048", "3"]);
    for results in [&mut case, &mut design] {
        assert!(results["grad_l_disp"]["x0"].is_array());
        assert!(results.get("augmented_performance_constraints").is_none());
    }
    // The controller of a scene is that of seed 0, not this one.
    let scene = results(&evaluate(&folder, &["scene.toml", "--record", "5,1"]));
    assert_eq!(scene["node_mass"], case["node_mass"]);
    assert_ne!(scene["u0"], case["u0"]);
    let keys: Vec<_> = scene["trajectory"]
        .as_object()
        .unwrap()
        .keys()
        .cloned()
        .collect();
    assert_eq!(keys, ["1", "5"]);
    assert!(scene.get("grad_l_disp").is_none());
}

#[test]
fn results_go_to_a_file_where_asked() {
    let folder = folder();
    let printed = evaluate(&folder, &["case.json"]);
    let told = evaluate(&folder, &["case.json", "--out", "results.json"]);
    assert_eq!((told.code, told.out.as_str()), (0, ""), "{}", told.error);
    let written = fs::read_to_string(folder.path().join("results.json")).unwrap();
    assert_eq!(written, printed.out);
}

#[test]
fn built_in_scenes_are_run_from_their_start() {
    let folder = tempfile::tempdir().unwrap();
    let layout = results(&evaluate(&folder, &["baseline_tall", "--record", "0"]));
    let shares = layout["z_projected"].as_array().unwrap();
    assert!(
        shares
            .iter()
            .flat_map(|row| row.as_array().unwrap())
            .all(|s| s == 0.0 || s == 1.0)
    );
    let soft = results(&evaluate(&folder, &["stability", "--record", "0"]));
    assert!(soft["z_projected"][0][0].as_f64().unwrap() < 0.5);
}

/// A snapped design runs with its exact layout: a void edge is void, and not the two parts in a
/// thousand million that the softmax leaves.
#[test]
fn a_snapped_design_is_exact() {
    let folder = folder();
    let path = folder.path().join("design.json");
    edit(&path, |json| {
        let materials: Vec<u64> = (0..json["z"].as_array().unwrap().len() as u64)
            .map(|e| e % 3)
            .collect();
        let one_hot = |m: &u64| json!([u8::from(*m == 0), u8::from(*m == 1), u8::from(*m == 2)]);
        json["z"] = materials.iter().map(one_hot).collect();
        json["materials"] = json!(materials);
    });
    let design = results(&evaluate(&folder, &["design.json", "--record", "0"]));
    assert_eq!(design["z_projected"][2], json!([0.0, 0.0, 1.0]));
    assert_eq!(design["g_bin"], 0.0);
}

#[test]
fn edges_run_in_either_direction() {
    let folder = folder();
    let forward = results(&evaluate(&folder, &["case.json"]));
    edit(&folder.path().join("case.json"), |json| {
        json["edges"][3].as_array_mut().unwrap().reverse();
    });
    assert_eq!(results(&evaluate(&folder, &["case.json"])), forward);
    edit(&folder.path().join("case.json"), |json| {
        json["edges"][5] = json["edges"][3].clone()
    });
    let told = evaluate(&folder, &["case.json"]);
    assert_eq!(told.code, 2);
    assert!(
        told.error.contains("`edges[5]`: expected an edge"),
        "{}",
        told.error
    );
    assert!(
        told.error.contains("that no earlier one is"),
        "{}",
        told.error
    );
}

/// Lattices of one row and of one column are cases too.
#[test]
fn slim_lattices() {
    let shape = |columns: usize, rows: usize| {
        let mut scene = small_scene();
        (scene.lattice.columns, scene.lattice.rows) = (columns, rows);
        scene.physics.steps = 16;
        let folder = tempfile::tempdir().unwrap();
        let json = Case::of_scene(&scene, 0).unwrap().to_json();
        fs::write(folder.path().join("case.json"), json).unwrap();
        evaluate(&folder, &["case.json", "--gradient"])
    };
    for (columns, rows) in [(5, 1), (1, 4), (2, 1)] {
        let results = results(&shape(columns, rows));
        assert_eq!(
            results["node_mass"].as_array().unwrap().len(),
            columns * rows
        );
    }
}

/// Evaluates after a change of the case or the design, and looks for words in the complaint.
fn refuses(file: &str, words: &[&str], change: impl FnOnce(&mut Value)) {
    let folder = folder();
    edit(&folder.path().join(file), change);
    let told = evaluate(&folder, &[file]);
    assert_eq!((told.code, told.out.as_str()), (2, ""), "{}", told.error);
    for word in words.iter().chain(&[file]) {
        assert!(told.error.contains(word), "no {word:?} in: {}", told.error);
    }
}

#[test]
fn wrong_cases_are_refused() {
    refuses("case.json", &["unknown field `colour`"], |json| {
        json["colour"] = json!(1)
    });
    refuses("case.json", &["invalid type: string"], |json| {
        json["scene"]["dt"] = json!("fast")
    });
    refuses("case.json", &["invalid type: null"], |json| {
        json["x0"][1][0] = Value::Null
    });
    for (key, value, found) in [
        ("contact", json!(0), "integer `0`"),
        ("integrator", json!(["leapfrog"]), "sequence"),
        ("void_edges", Value::Null, "null"),
    ] {
        let says = format!("`scene.{key}`: invalid type: {found}, expected a text");
        refuses("case.json", &[&says], |json| json["scene"][key] = value);
    }
    let says = "`materials[0]`: invalid type: string \"x\", expected a whole number from 0 on";
    refuses("case.json", &[says], |json| {
        json["materials"] = json!(["x"])
    });
    refuses("case.json", &["missing field `al`"], |json| {
        json.as_object_mut().unwrap().remove("al");
    });
    refuses("case.json", &["expected 11 rows of `z`, found 1"], |json| {
        json["z"] = json!([[0, 0, 0]])
    });
    refuses(
        "case.json",
        &["`format` is \"cosmic-summary\" version 1"],
        |json| {
            json["format"] = json!("cosmic-summary");
        },
    );
    refuses(
        "case.json",
        &["expected one or more `edges`, found 0"],
        |json| {
            for key in ["edges", "l0", "z"] {
                json[key] = json!([]);
            }
        },
    );
}

/// What a scene of its own would be refused for, with the same bounds.
#[test]
fn cases_without_a_meaning_are_refused() {
    for (key, value, allowed) in [
        ("substeps", json!(0), "a whole number from 1 to 64"),
        (
            "substeps",
            json!(1_000_000_000),
            "a whole number from 1 to 64",
        ),
        ("bending_radius", json!(-1), "a number from 0 to 1"),
        ("stiffening", json!(-1), "a number from 0 to 1e6"),
        ("m_eps", json!(-1), "a number from 1e-9 to 1000"),
        ("payload_mass", json!(-1), "a number from 0 to 1000"),
    ] {
        let says = format!("`scene.{key}`: expected {allowed}, found {value}");
        refuses("case.json", &[&says], |json| json["scene"][key] = value);
    }
    let long = "`steps` times `scene.substeps`: expected at most 10000000, found 64000000";
    refuses("case.json", &[long], |json| {
        (json["steps"], json["scene"]["substeps"]) = (json!(1_000_000), json!(64));
    });
}

#[test]
fn arrays_of_another_length_are_named() {
    refuses(
        "case.json",
        &["expected 2 entries in `scene.goal`, found 3"],
        |json| json["scene"]["goal"] = json!([1, 2, 3]),
    );
    for key in ["k", "rho", "a_max"] {
        let says = format!("expected 3 entries in `scene.library.{key}`, found 4");
        refuses("case.json", &[&says], |json| {
            json["scene"]["library"][key] = json!([1, 2, 3, 4])
        });
    }
    for key in ["lambda", "tau", "thresholds"] {
        let says = format!("expected 4 entries in `al.{key}`, found 3");
        refuses("case.json", &[&says], |json| {
            json["al"][key] = json!([1, 2, 3])
        });
    }
}

#[test]
fn wrong_designs_are_refused() {
    let design = "design.json";
    refuses(design, &["3 is no material"], |json| {
        json["materials"][0] = json!(3)
    });
    refuses(design, &["invalid type: null, expected a number"], |json| {
        json["z"][0][1] = Value::Null
    });
    refuses(design, &["unknown field `colour`"], |json| {
        json["colour"] = json!(1)
    });
    refuses(design, &["version 9"], |json| json["version"] = json!(9));
    refuses(
        design,
        &["`edges[1]`: expected [0, 3], as in the scene's lattice, found [0, 2]"],
        |json| {
            json["edges"][1] = json!([0, 2]);
        },
    );
    refuses(
        design,
        &["expected 11 entries in `materials`, found 1"],
        |json| json["materials"] = json!([0]),
    );
    refuses(
        design,
        &["expected 4 entries in `controller.b1`, found 1"],
        |json| {
            json["controller"]["b1"] = json!([0.0]);
        },
    );
}

#[test]
fn a_design_for_another_lattice_is_refused() {
    let folder = folder();
    let scene = small_scene()
        .to_toml()
        .replace("columns = 3", "columns = 4");
    fs::write(folder.path().join("scene.toml"), scene).unwrap();
    let told = evaluate(&folder, &["design.json"]);
    assert_eq!(told.code, 2);
    let says = "error: expected 16 `edges`, found 11\n --> design.json:";
    assert!(told.error.starts_with(says), "{}", told.error);
}

/// NaN is not JSON; a half-written file ends in the middle.
#[test]
fn files_that_are_no_json_are_refused_with_their_place() {
    for file in ["design.json", "case.json"] {
        let folder = folder();
        let path = folder.path().join(file);
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, &text[..text.len() / 2]).unwrap();
        let told = evaluate(&folder, &[file]);
        assert_eq!(told.code, 2);
        assert!(
            told.error.contains(&format!("{file}:1:{}", text.len() / 2)),
            "{}",
            told.error
        );
        assert!(told.error.contains("EOF while parsing"), "{}", told.error);

        fs::write(&path, text.replacen("\"b1\":[0.0", "\"b1\":[NaN", 1)).unwrap();
        let told = evaluate(&folder, &[file]);
        assert!(
            told.code == 2 && told.error.contains("expected value"),
            "{}",
            told.error
        );
    }
}

/// As some editors write it, and whatever words it is described with.
#[test]
fn a_case_is_told_by_what_it_holds() {
    let folder = folder();
    let path = folder.path().join("case.json");
    edit(&path, |json| json["name"] = json!("cosmic-design"));
    let text = fs::read_to_string(&path).unwrap();
    let plain = evaluate(&folder, &["case.json"]);
    assert_eq!(plain.code, 0, "{}", plain.error);
    for name in ["case.json", "case"] {
        fs::write(folder.path().join(name), format!("\u{feff}{text}")).unwrap();
        let told = evaluate(&folder, &[name]);
        assert_eq!(
            (told.code, told.out),
            (0, plain.out.clone()),
            "{}",
            told.error
        );
    }
    fs::write(
        &path,
        format!(
            "\u{feff}{}",
            text.replacen("\"v0\":[", "\"v0\":[[1e400,0],", 1)
        ),
    )
    .unwrap();
    let told = evaluate(&folder, &["case.json"]);
    let says = "`v0[0][0]`: number out of range: 1.7976931348623157e308 is the largest there is";
    assert!(
        told.code == 2 && told.error.contains(says),
        "{}",
        told.error
    );
}

#[test]
fn missing_and_unwritable_files_exit_with_4() {
    let folder = folder();
    let missing = |name: &str| {
        let told = evaluate(&folder, &[name]);
        assert_eq!(told.code, 4, "{}", told.error);
        told.error
    };
    assert!(missing("no/such.json").contains("cannot read no/such.json"));
    assert!(missing("stabilty").contains("did you mean `stability`?"));
    // A folder stands for the design in it.
    fs::create_dir(folder.path().join("empty")).unwrap();
    assert!(missing("empty").contains("cannot read empty/design.json"));
    let told = evaluate(
        &folder,
        &["case.json", "--out", "no/such/folder/results.json"],
    );
    assert_eq!(told.code, 4);
    assert!(
        told.error
            .contains("cannot write no/such/folder/results.json"),
        "{}",
        told.error
    );
    fs::remove_file(folder.path().join("scene.toml")).unwrap();
    assert!(missing("design.json").contains("cannot read scene.toml"));
}

/// `cosmic` with those arguments, and something piped into it.
#[cfg(unix)]
fn piped(arguments: &[&str], bytes: &[u8]) -> std::process::Output {
    let mut command = command(arguments);
    command
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    child.stdin.take().unwrap().write_all(bytes).unwrap();
    child.wait_with_output().unwrap()
}

/// A pipe is read once and has its own contents, whatever it is called.
#[cfg(unix)]
#[test]
fn scenes_and_cases_come_through_pipes() {
    let folder = folder();
    for name in ["scene.toml", "case.json"] {
        let bytes = fs::read(folder.path().join(name)).unwrap();
        let piped = piped(&["evaluate", "/dev/stdin"], &bytes);
        let printed = evaluate(&folder, &[name]);
        assert_eq!(String::from_utf8(piped.stdout).unwrap(), printed.out);
    }
    let wrong = piped(&["gradcheck", "/dev/stdin"], b"[physics]\nsteps = -1\n");
    assert_eq!(wrong.status.code(), Some(2), "{wrong:?}");
}

#[test]
fn steps_that_there_are_not_are_refused() {
    let folder = folder();
    edit(&folder.path().join("case.json"), |case| {
        case["results"] = json!({ "trajectory": { "2049": null } });
    });
    let told = evaluate(&folder, &["case.json"]);
    let says = "error: `results.trajectory` has step 2049, and the rollout 2048 steps";
    assert!(told.code == 2 && told.error.contains(says), "{told:?}");
    edit(&folder.path().join("case.json"), |case| {
        case["results"] = json!({});
    });
    let told = evaluate(&folder, &["case.json", "--record", "1,2049"]);
    assert_eq!(told.code, 2);
    assert!(
        told.error
            .contains("step 2049 is asked for, and the rollout has 2048 steps")
    );
    assert_eq!(evaluate(&folder, &["case.json", "--record", "-1"]).code, 2);
}
