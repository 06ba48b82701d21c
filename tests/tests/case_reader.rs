//! The reader of case files: which keys may be absent, and the errors for wrong files.

use cosmic::case::Case;
use cosmic::geometry::Dimension;
use cosmic::lattice::Truss;
use cosmic::scene::Scene;
use cosmic::{Error, Registry};
use cosmic_tests::{Reference, own_reference_folder, references};
use serde_json::{Value, json};

fn some_case() -> Reference {
    references(&own_reference_folder()).remove(0)
}

/// Changes the JSON of a valid case, then reads it as a case.
fn parse(change: impl FnOnce(&mut Value)) -> Result<Case, Error> {
    let mut json = some_case().json;
    change(&mut json);
    Case::parse("case.json", &json.to_string())
}

/// Changes the JSON of a valid case, which must make it invalid, and returns the message of the error.
fn message(change: impl FnOnce(&mut Value)) -> String {
    let error = parse(change).expect_err("the change makes the case wrong");
    assert_eq!(error.exit_code(), 2, "{error}");
    error.to_string()
}

#[test]
fn some_keys_may_be_absent() {
    let case = parse(|json| {
        let map = json.as_object_mut().expect("a case is an object");
        let may_be_absent = "results tolerance sensitivity coverage name note";
        map.retain(|key, _| may_be_absent.split(' ').all(|absent| absent != key));
    });
    let case = case.unwrap_or_else(|error| panic!("{error}"));
    let seen = &case.scene.controller;
    assert_eq!((seen.goal_scale, seen.goal_relative), (1.0, false));
    let mut expected = vec![0, 1, 2, 3, case.scene.physics.steps];
    expected.dedup();
    assert_eq!(case.recorded_steps(&[]).ok(), Some(expected));
}

#[test]
fn some_keys_are_read_if_they_are_there() {
    let case = parse(|json| {
        json["scene"]["goal_scale"] = json!(0.25);
        json["scene"]["goal_relative"] = json!(true);
        json["format"] = json!("cosmic-case");
        // Of the section `results`, only the step numbers are read.
        json["results"] = json!({"anything": 1, "trajectory": {"2": null}});
    });
    let case = case.unwrap_or_else(|error| panic!("{error}"));
    let seen = &case.scene.controller;
    assert_eq!((seen.goal_scale, seen.goal_relative), (0.25, true));
    assert_eq!(case.listed_steps, [2]);
}

/// The keys of version 1 that no reference case has are read too.
#[test]
fn every_key_of_version_1_is_read() {
    let keys = json!({
        "kind": "triangular", "depth": 4, "body_diagonals": true, "payload": 2, "dimension": 2,
        "profile": [[0.5, 0.0], [0.75, 0.02]], "integrator": "implicit", "substeps": 3, "passes": 4,
        "contact": {"coulomb": {}}, "forces": ["damper", {"stops": {"at": 0.25}}], "void_edges": "drop", "speed_bound": 7.5,
        "goals": "fixed", "penalisation": 3,
        "parts": {"skeleton": "tube", "joint": null, "outer": 0.007}, "hold_materials": 0.5, "one_piece": true,
        "body": "mass",
    });
    let read = parse(|json| {
        let scene = json["scene"].as_object_mut().expect("an object");
        scene.extend(keys.as_object().expect("an object").clone());
    });
    let read = read.unwrap_or_else(|error| panic!("{error}")).scene;
    let as_in_a_scene = r#"
        lattice = {kind = "triangular", depth = 4, body_diagonals = true, payload = 2}
        ground = {profile = "points", points = [[0.5, 0.0], [0.75, 0.02]]}
        physics.integrator = "implicit"
        physics.substeps = 3
        physics.contact = "coulomb"
        physics.forces = ["damper", "stops"]
        physics.void_edges = "drop"
        physics.speed_bound = 7.5
        stops.at = 0.25
        controller.goals = "fixed"
        materials.penalisation = 3
        parts = {skeleton = "tube", joint = "off", outer = 0.007}
        projection.hold_materials = 0.5
        design.one_piece = true
        objective.body = "mass""#;
    // The other keys are those of the reference case.
    let mut expected = read.clone();
    expected.physics.passes = 4;
    let expected = expected.with("expected", as_in_a_scene).expect("a scene");
    assert_eq!(read, expected);
}

/// Sets a value in the JSON of a case. The key may be new.
fn set(json: &mut Value, pointer: &str, value: Value) {
    let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
    let parent = json.pointer_mut(parent).expect("the parent is there");
    match key.parse::<usize>() {
        Ok(index) => parent[index] = value,
        Err(_) => parent[key] = value,
    }
}

/// Each value in `wrong_cases.txt` is refused, and the message has the words that the file lists for it.
#[test]
fn values_without_a_meaning_are_refused() {
    let (_, rows) = include_str!("wrong_cases.txt")
        .split_once("\n\n")
        .expect("a head");
    let lines: Vec<&str> = rows.lines().collect();
    let (pairs, rest) = lines.as_chunks::<2>();
    assert!(pairs.len() > 30 && rest.is_empty());
    for [wrong, words] in pairs {
        let (pointer, value) = wrong.split_once(" = ").expect("a pointer and a value");
        let value = serde_json::from_str(value).expect("a JSON value");
        let text = message(|json| set(json, pointer, value));
        let words = words.strip_prefix("! ").expect("words of the message");
        assert!(
            text.contains(words) && text.contains("case.json"),
            "{wrong}: {text}"
        );
    }
}

/// A case of a robot in space whose scene does not say so is refused, with the key to set. A truss in a case needs no key: the
/// numbers of its nodes say it.
#[test]
fn a_case_in_space_says_so_or_is_a_truss() {
    let written = |settings: &str| -> Value {
        let text = format!(
            "base = 'cube'\nlattice.columns = 3\ncontroller.hidden = 2\nphysics.steps = 4\n{settings}"
        );
        let case = Case::of_scene(&Scene::parse("cube", &text).unwrap(), 1).unwrap();
        serde_json::from_str(&case.to_json()).unwrap()
    };
    let read = |json: &Value| Case::parse("case.json", &json.to_string());
    let says = |json: &Value, words: &str| {
        let error = read(json).unwrap_err();
        assert_eq!(error.exit_code(), 2);
        assert!(error.to_string().contains(words), "{error}");
    };
    let case = written("");
    assert_eq!(read(&case).unwrap().lattice.dimension, Dimension::Space);
    let mut planar = case.clone();
    planar["scene"]["lattice"]["kind"] = json!("rectangular");
    planar["scene"]["lattice"]["mirror"] = json!(false);
    planar["scene"]["lattice"]["rows"] = json!(9);
    says(
        &planar,
        "`x0` has 3 numbers for each point, but the lattice of `scene` needs 2; a lattice in space has the `kind` \"cubic\"",
    );
    // In version 1 a robot in space may also say its dimension.
    let mut reference = references(&own_reference_folder().join("space"))
        .remove(0)
        .json;
    assert_eq!(
        read(&reference).unwrap().lattice.dimension,
        Dimension::Space
    );
    assert_eq!(reference["scene"]["dimension"].take(), json!(3));
    says(&reference, "`scene.dimension`: found null, expected 2 or 3");
    // One point with two numbers.
    let mut mixed = case.clone();
    mixed["v0"][5] = json!([0.0, 0.0]);
    says(&mixed, "expected 3 numbers for every point, found 2");
    let mut rough = case.clone();
    rough["scene"]["ground"]["profile"] = json!("points");
    rough["scene"]["ground"]["points"] = json!([[0.0, 0.0], [0.5, 0.1]]);
    says(
        &rough,
        "`scene.ground.profile`: the ground of a robot in space is a plane",
    );
    let mut beside = some_case().json;
    beside["scene"]["goal"] = json!([1.0, 0.5, 0.1]);
    says(
        &beside,
        "`scene.goal`: a planar robot cannot reach a goal beside its plane",
    );

    let truss = r#"{"format": "cosmic-truss", "version": 1,
        "nodes": [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]],
        "edges": [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]}"#;
    let truss = Truss::parse("truss.json", truss).unwrap();
    let registry = Registry::default().with_lattice("pyramid", truss);
    let scene = registry
        .parse("own", "base = 'earth'\nlattice.file = 'pyramid'")
        .unwrap();
    let own = Case::of_scene(&scene, 1).unwrap();
    let json: Value = serde_json::from_str(&own.to_json()).unwrap();
    let again = read(&json).unwrap();
    assert_eq!(again.lattice.dimension, Dimension::Space);
    assert_eq!(again.start, own.start);
}

#[test]
fn missing_keys_are_named() {
    let without = |object: &str, key: &str| {
        message(|json| {
            let object = json.pointer_mut(object).expect("an object");
            object.as_object_mut().expect("an object").remove(key);
        })
    };
    assert!(without("/scene", "dt").contains("missing field `dt`"));
    assert!(without("", "al").contains("missing field `al`"));
    let text = message(|json| {
        for key in ["edges", "l0", "z"] {
            json[key] = json!([]);
        }
    });
    assert!(
        text.contains("expected one or more `edges`, found 0"),
        "{text}"
    );
}

#[test]
fn numbers_that_are_too_large_are_refused() {
    let text = message(|json| {
        (json["steps"], json["scene"]["substeps"]) = (json!(1_000_000), json!(64));
    });
    let says = "`steps` times the substeps: expected at most 10000000, found 64000000";
    assert!(text.contains(says), "{text}");
    let mut json = some_case().json;
    json["results"] = json!({});
    let huge = json.to_string().replacen("\"v0\":[[", "\"v0\":[[1e400,", 1);
    let error = Case::parse("case.json", &huge).expect_err("a number out of range");
    let says = "`v0[0][0]`: number out of range: the largest number is 1.7976931348623157e308";
    assert!(error.to_string().contains(says), "{error}");
}

#[test]
fn truncated_files_are_malformed_at_their_end_and_missing_ones_are_another_error() {
    let text = some_case().text;
    let error = Case::parse("case.json", &text[..text.len() / 2]).expect_err("half a case");
    let text = error.to_string();
    assert!(
        error.exit_code() == 2 && text.contains("\n --> case.json:1:"),
        "{text}"
    );
    let error = Case::read(std::path::Path::new("no/such/case.json")).expect_err("no file");
    assert_eq!(error.exit_code(), 4);
}

/// A robot that is written as a case and read back is the same, because a case file has all settings of a robot.
#[test]
fn a_robot_written_as_a_case_reads_back_the_same() {
    let paper = Scene::paper();
    let parts =
        "parts = {skeleton = 'rod', outer = 0.002, joint = 5e3, actuator = 'device', stroke = 0.1}";
    let mut scene = paper.with("parts", parts).expect("parts that can be made");
    (scene.lattice.columns, scene.lattice.rows) = (3, 3);
    (scene.start.tilt, scene.physics.steps) = (0.2, 8);
    scene.materials.penalisation = 3;
    scene.projection.hold_materials = 0.05;
    let case = Case::of_scene(&scene, 1).expect("any lattice starts so");
    let again = Case::parse("written", &case.to_json()).expect("it was just written");
    assert_eq!(again.own_design(), case.own_design());
    assert_eq!(again.body().stiffness, case.body().stiffness);
    assert_eq!(again.body().mass, case.body().mass);
    assert_eq!(again, case);
}
