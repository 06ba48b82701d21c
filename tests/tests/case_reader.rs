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

/// What is said after a change of a case's JSON.
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

#[test]
fn unknown_keys_are_named() {
    assert!(message(|json| json["colour"] = json!(1)).contains("unknown field `colour`"));
    let text = message(|json| json["scene"]["library"]["colour"] = json!(1));
    let says = "error: `scene.library.colour`: unknown field `colour`, expected one of ";
    assert!(
        text.starts_with(says) && text.contains("\n --> case.json:1:"),
        "{text}"
    );
}

#[test]
fn missing_keys_and_wrong_types_are_named() {
    let text = message(|json| {
        json["scene"]
            .as_object_mut()
            .expect("an object")
            .remove("dt");
    });
    assert!(text.contains("missing field `dt`"));
    assert!(message(|json| json["l0"][0] = Value::Null).contains("invalid type: null"));
    assert!(message(|json| json["steps"] = json!(-1)).contains("invalid value"));
    assert!(
        message(|json| json["projection"] = json!("sharp")).contains("unknown variant `sharp`")
    );
}

#[test]
fn sizes_that_do_not_fit_are_named_with_both() {
    let lengths = ["x0", "v0", "z", "l0"];
    for key in lengths {
        let text = message(|json| pop(&mut json[key]));
        assert!(
            text.contains(&format!("`{key}`")) && text.contains("expected"),
            "{text}"
        );
    }
    for key in ["w1", "b1", "w2", "b2"] {
        let text = message(|json| pop(&mut json["controller"][key]));
        assert!(
            text.contains("`controller.") && text.contains("expected"),
            "{text}"
        );
    }
    let text = message(|json| pop(&mut json["z"][1]));
    let says = "error: expected 3 entries in `z[1]`, found 2\n --> case.json:1:";
    assert!(text.starts_with(says), "{text}");
    let text = message(|json| pop(&mut json["controller"]["w1"][1]));
    assert!(text.contains("entries in `controller.w1[1]`"), "{text}");
}

#[test]
fn an_edge_joins_two_nodes_that_exist() {
    for edge in [[1, 1], [0, 999]] {
        let text = message(|json| json["edges"][2] = json!(edge));
        let found = format!(", found {edge:?}");
        assert!(
            text.contains("`edges[2]`: expected two different nodes") && text.contains(&found),
            "{text}"
        );
    }
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
        let mut case = Case::parse(&reference.name(), &reference.text)
            .unwrap_or_else(|error| panic!("{error}"));
        let again = Case::parse("written", &case.to_json());
        case.listed_steps.clear();
        assert_eq!(again.unwrap_or_else(|error| panic!("{error}")), case);
    }
}

/// Whatever a robot is made with is written: what is read back is the same robot.
#[test]
fn a_robot_written_as_a_case_is_that_robot() {
    let mut scene = cosmic::scene::Scene::default();
    (scene.lattice.columns, scene.lattice.rows) = (3, 3);
    (scene.start.tilt, scene.physics.steps) = (0.2, 8);
    // A case is evaluated, and that never refuses.
    scene.physics.unstable_step = cosmic::scene::UnstableStep::Warn;
    scene.materials.penalisation = 3;
    scene.projection.hold_materials = 0.05;
    scene.physics.stiffening = 2.0;
    let case = Case::of_scene(&scene, 1).expect("any lattice starts so");
    let again = Case::parse("written", &case.to_json()).expect("it was just written");
    assert_eq!(again.own_mixture(), case.own_mixture());
    assert_eq!(again.body().stiffness, case.body().stiffness);
    assert_eq!(again.task().physics, case.task().physics);
    // Numbers without a meaning are as wrong here as in a scene.
    let text = message(|json| json["scene"]["penalisation"] = json!(0));
    let says = "`scene.penalisation`: expected a whole number from 1 to 10, found 0";
    assert!(text.contains(says), "{text}");
}

#[test]
fn a_case_may_say_what_it_is() {
    assert!(parse(|json| json["format"] = json!("cosmic-case")).is_ok());
    let text = message(|json| json["format"] = json!("cosmic-design"));
    assert!(
        text.contains("\"cosmic-design\" version 1, not \"cosmic-case\" version 1"),
        "{text}"
    );
    assert!(message(|json| json["version"] = json!(2)).contains("version 2"));
}

#[test]
fn an_edge_stands_once() {
    let text = message(|json| json["edges"][2] = json!([1, 0]));
    assert!(
        text.contains("`edges[2]`: expected an edge that no earlier one is, found [1, 0]"),
        "{text}"
    );
}

#[test]
fn a_rollout_has_an_end() {
    let text = message(|json| json["steps"] = json!(1_000_000_000_000_u64));
    assert!(
        text.contains("`steps`: expected at most 10000000, found 1000000000000"),
        "{text}"
    );
}
