//! Case files that are wrong: what is said about them, and the exit code.

use cosmic::Error;
use cosmic::case::Case;
use cosmic_tests::{Reference, own_reference_folder, references};
use serde_json::{Value, json};

fn some_case() -> Reference {
    references(&own_reference_folder()).remove(0)
}

/// Reads a case after a change of its JSON.
fn parse(change: impl FnOnce(&mut Value)) -> Result<Case, Error> {
    let mut json = some_case().json;
    change(&mut json);
    Case::parse("case.json", &json.to_string())
}

/// The complaint after a change of a case's JSON.
fn message(change: impl FnOnce(&mut Value)) -> String {
    let error = parse(change).expect_err("the change makes the case wrong");
    assert_eq!(error.exit_code(), 2, "{error}");
    error.to_string()
}

fn pop(list: &mut Value) {
    list.as_array_mut().expect("a list").pop();
}

#[test]
fn what_a_case_may_leave_out() {
    let case = parse(|json| {
        let map = json.as_object_mut().expect("a case is an object");
        for key in [
            "results",
            "tolerance",
            "sensitivity",
            "coverage",
            "name",
            "note",
        ] {
            map.remove(key);
        }
    })
    .unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(
        (case.observation.goal_scale, case.observation.goal_relative),
        (1.0, false)
    );
    let mut expected = vec![0, 1, 2, 3, case.physics.steps];
    expected.dedup();
    assert_eq!(case.recorded_steps(&[]).ok(), Some(expected));
}

#[test]
fn goal_scale_and_goal_relative_are_read() {
    let case = parse(|json| {
        json["scene"]["goal_scale"] = json!(0.25);
        json["scene"]["goal_relative"] = json!(true);
    })
    .unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(
        (case.observation.goal_scale, case.observation.goal_relative),
        (0.25, true)
    );
}

#[test]
fn results_are_read_for_their_steps_alone() {
    let case = parse(|json| json["results"] = json!({"anything": 1, "trajectory": {"2": null}}));
    assert_eq!(case.ok().map(|case| case.listed_steps), Some(vec![2]));
}

/// Replaces a value of a case, or adds one to an object.
fn set(json: &mut Value, pointer: &str, value: Value) {
    let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
    let parent = json.pointer_mut(parent).expect("the parent is there");
    match key.parse::<usize>() {
        Ok(index) => parent[index] = value,
        Err(_) => parent[key] = value,
    }
}

/// Values that make a case wrong: where they are, the value, and what is said about it.
const WRONG: [(&str, &str, &str); 17] = [
    ("/colour", "1", "unknown field `colour`"),
    (
        "/scene/library/colour",
        "1",
        "error: `scene.library.colour`: unknown field `colour`, expected one of ",
    ),
    ("/l0/0", "null", "invalid type: null"),
    ("/x0/1/0", "null", "invalid type: null"),
    ("/steps", "-1", "invalid value"),
    ("/projection", "\"sharp\"", "unknown variant `sharp`"),
    ("/scene/dt", "\"fast\"", "invalid type: string"),
    (
        "/scene/contact",
        "0",
        "`scene.contact`: invalid type: integer `0`, expected the name of a law",
    ),
    (
        "/scene/integrator",
        "[\"leapfrog\"]",
        "`scene.integrator`: invalid type: sequence, expected a string",
    ),
    (
        "/scene/void_edges",
        "null",
        "`scene.void_edges`: invalid type: null, expected a string",
    ),
    (
        "/materials",
        "[\"x\"]",
        "`materials[0]`: invalid type: string \"x\", expected a whole number from 0 on",
    ),
    (
        "/steps",
        "1000000000000",
        "`steps`: expected at most 10000000, found 1000000000000",
    ),
    (
        "/edges/2",
        "[1, 1]",
        "`edges[2]`: expected two different nodes",
    ),
    ("/edges/2", "[0, 999]", ", found [0, 999]"),
    (
        "/edges/2",
        "[1, 0]",
        "`edges[2]`: expected an edge that is not listed before, found [1, 0]",
    ),
    (
        "/format",
        "\"cosmic-design\"",
        "`format` is \"cosmic-design\" version 1, not \"cosmic-case\" version 1",
    ),
    ("/version", "2", "version 2"),
];

/// Settings beyond the bounds that a scene has for them, and what is allowed.
const OUT_OF_BOUNDS: [(&str, &str, &str); 7] = [
    ("substeps", "0", "a whole number from 1 to 64"),
    ("substeps", "1000000000", "a whole number from 1 to 64"),
    ("bending_radius", "-1", "a number from 0 to 1"),
    ("stiffening", "-1", "a number from 0 to 1e6"),
    ("m_eps", "-1", "a number from 1e-9 to 1000"),
    ("payload_mass", "-1", "a number from 0 to 1000"),
    ("penalisation", "0", "a whole number from 1 to 10"),
];

/// Lists and their lengths.
const LISTS: [(&str, usize); 7] = [
    ("scene.goal", 2),
    ("scene.library.k", 3),
    ("scene.library.rho", 3),
    ("scene.library.a_max", 3),
    ("al.lambda", 4),
    ("al.tau", 4),
    ("al.thresholds", 4),
];

/// The complaint about a case with this value.
fn refused(pointer: &str, value: &str) -> String {
    let value = serde_json::from_str(value).expect("a JSON value");
    let text = message(|json| set(json, pointer, value));
    assert!(text.contains("case.json"), "{text}");
    text
}

#[test]
fn values_without_a_meaning_are_refused() {
    for (pointer, value, says) in WRONG {
        let text = refused(pointer, value);
        assert!(text.contains(says), "{says}: {text}");
    }
    for (key, value, allowed) in OUT_OF_BOUNDS {
        let text = refused(&format!("/scene/{key}"), value);
        let says = format!("`scene.{key}`: expected {allowed}, found {value}");
        assert!(text.contains(&says), "{says}: {text}");
    }
    for (list, len) in LISTS {
        let text = refused(&format!("/{}", list.replace('.', "/")), "[1]");
        let says = format!("expected {len} entries in `{list}`, found 1");
        assert!(text.contains(&says), "{says}: {text}");
    }
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
fn what_is_too_much_is_told() {
    let text = message(|json| {
        (json["steps"], json["scene"]["substeps"]) = (json!(1_000_000), json!(64));
    });
    let says = "`steps` times `scene.substeps`: expected at most 10000000, found 64000000";
    assert!(text.contains(says), "{text}");
    let mut json = some_case().json;
    json["results"] = json!({});
    let huge = json.to_string().replacen("\"v0\":[[", "\"v0\":[[1e400,", 1);
    let error = Case::parse("case.json", &huge).expect_err("a number out of range");
    let says = "`v0[0][0]`: number out of range: 1.7976931348623157e308 is the largest there is";
    assert!(error.to_string().contains(says), "{error}");
}

#[test]
fn sizes_that_do_not_fit_are_named_with_both() {
    for (pointer, name) in [
        ("/x0", "`x0`"),
        ("/v0", "`v0`"),
        ("/z", "`z`"),
        ("/l0", "`l0`"),
        ("/controller/w1", "`controller."),
        ("/controller/b1", "`controller."),
        ("/controller/w2", "`controller."),
        ("/controller/b2", "`controller."),
    ] {
        let text = message(|json| pop(json.pointer_mut(pointer).expect("a list")));
        assert!(text.contains(name) && text.contains("expected"), "{text}");
    }
    let text = message(|json| pop(&mut json["z"][1]));
    let says = "error: expected 3 entries in `z[1]`, found 2\n --> case.json:1:";
    assert!(text.starts_with(says), "{text}");
    let text = message(|json| pop(&mut json["controller"]["w1"][1]));
    assert!(text.contains("entries in `controller.w1[1]`"), "{text}");
}

#[test]
fn truncated_files_are_malformed_at_their_end() {
    let text = some_case().text;
    let error = Case::parse("case.json", &text[..text.len() / 2]).expect_err("half a case");
    assert_eq!(error.exit_code(), 2);
    let text = error.to_string();
    assert!(
        text.starts_with("error: ") && text.contains("\n --> case.json:1:"),
        "{text}"
    );
}

#[test]
fn missing_files_are_another_error() {
    let error = Case::read(std::path::Path::new("no/such/case.json")).expect_err("no file");
    assert_eq!(error.exit_code(), 4);
}

#[test]
fn what_is_written_reads_back_the_same() {
    for reference in references(&own_reference_folder()) {
        let mut case = reference.case();
        let again = Case::parse("written", &case.to_json());
        case.listed_steps.clear();
        assert_eq!(again.unwrap_or_else(|error| panic!("{error}")), case);
    }
}

/// All settings of a robot are written: the robot read back is the same.
#[test]
fn a_robot_written_as_a_case_is_that_robot() {
    let mut scene = cosmic::scene::Scene::paper();
    (scene.lattice.columns, scene.lattice.rows) = (3, 3);
    (scene.start.tilt, scene.physics.steps) = (0.2, 8);
    // A case is evaluated, and that never refuses.
    scene.physics.unstable_step = cosmic::scene::UnstableStep::Warn;
    scene.materials.penalisation = 3;
    scene.projection.hold_materials = 0.05;
    scene.physics.stiffening = 2.0;
    let case = Case::of_scene(&scene, 1).expect("any lattice starts so");
    let again = Case::parse("written", &case.to_json()).expect("it was just written");
    assert_eq!(again.own_design(), case.own_design());
    assert_eq!(again.body().stiffness, case.body().stiffness);
    assert_eq!(again.task().physics, case.task().physics);
}

#[test]
fn a_case_may_say_what_it_is() {
    assert!(parse(|json| json["format"] = json!("cosmic-case")).is_ok());
}
