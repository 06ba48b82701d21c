//! Compares the answers of ADBench cases with their reference answers, within the tolerances of the references. The
//! cases run directly and through GradBench's protocol.

use std::path::{Path, PathBuf};

use benches::adbench::{cases, gap, input};
use serde_json::{Value, json};

use crate::driver::{agrees, answer, assert_close};
use crate::naive::{gradient, numbers};

/// Returns the folder named by `ADBENCH_DIR`, or else the folder of the project's own cases.
fn folder() -> PathBuf {
    std::env::var_os("ADBENCH_DIR").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/adbench"),
        PathBuf::from,
    )
}

#[test]
fn every_answer_is_the_reference() {
    let cases = cases(&folder()).unwrap_or_else(|error| panic!("{error}"));
    for case in cases {
        let mut problem = case.open().unwrap_or_else(|error| panic!("{error}"));
        problem.derivative();
        let with_derivative = problem.answer();
        problem.objective();
        // The objective and the derivative must both compute the value. The second call overwrites the answer of the
        // first.
        for found in [with_derivative, problem.answer()] {
            let gap = gap(&found, &case.reference);
            println!("{}: {gap:?}", case.name);
            assert!(gap.is_close(), "{}: {gap:?}", case.name);
        }
    }
}

/// Returns a case as an input of GradBench, and the reference answer of the case.
fn case(module: &str, name: &str) -> [Value; 2] {
    let cases = cases(&folder()).unwrap_or_else(|error| panic!("{error}"));
    let case = cases.into_iter().find(|case| case.name == name);
    let case = case.expect("the case is there");
    let model = case.file.with_file_name("model");
    let input = input(module, &case.file, &model).unwrap_or_else(|error| panic!("{error}"));
    [input, case.reference]
}

#[test]
fn lstm() {
    let [input, reference] = case("lstm", "lstm_l2_c1024");
    agrees("lstm", "objective", &input, &reference["objective"]);
    agrees("lstm", "jacobian", &input, &reference["gradient"]);
}

#[test]
fn ba() {
    let [input, reference] = case("ba", "ba_test");
    let (errors, weights) = (&reference["reproj_err"], &reference["w_err"]);
    let right = json!({
        "reproj_error": { "elements": [errors[0], errors[1]], "repeated": input["p"] },
        "w_err": { "element": weights[0], "repeated": input["p"] },
    });
    agrees("ba", "objective", &input, &right);
    let ends = |list: &[f64]| [&list[..30.min(list.len())], &list[list.len() - 1..]].concat();
    let lists = ["rows", "cols", "vals"].map(|name| numbers(&reference["jacobian"][name]));
    let [rows, cols, vals] = lists.each_ref().map(|list| ends(list));
    let right = json!({ "rows": rows, "cols": cols, "vals": vals });
    agrees("ba", "jacobian", &input, &right);
    // A single observation has two rows of fifteen entries, and a row for the weight.
    let mut single = input;
    for count in ["n", "m", "p"] {
        single[count] = json!(1);
    }
    let columns = || 0..15;
    let cols: Vec<usize> = columns().chain(columns()).chain([14]).collect();
    let right = json!({ "rows": [0, 15, 30, 31, 31], "cols": cols, "vals": vals });
    agrees("ba", "jacobian", &single, &right);
    // If the rotation vector is zero, the derivative must still agree with finite differences.
    let inputs = ["cam", "x", "w"]
        .map(|name| numbers(&single[name]))
        .concat();
    let unrotated = [&[0.0; 3], &inputs[3..]].concat();
    let at = |x: &[f64]| {
        let mut input = single.clone();
        (input["cam"], input["x"], input["w"]) = (json!(x[..11]), json!(x[11..14]), json!(x[14]));
        input
    };
    let jacobian = numbers(&answer("ba", "jacobian", &at(&unrotated))["vals"]);
    let rows = [0, 1].map(|row| {
        let element = |input: &Value| {
            answer("ba", "objective", input)["reproj_error"]["elements"][row].as_f64()
        };
        gradient(|x| element(&at(x)).expect("a number"), &unrotated)
    });
    assert_close("ba", &json!(jacobian[..30]), &json!(rows.concat()));
}

#[test]
fn ht() {
    for name in [
        "hand_test",
        "hand_complicated_test",
        "hand_complicated1_t26_c100",
    ] {
        let [mut input, reference] = case("ht", name);
        let replies = |input: &Value| ["objective", "jacobian"].map(|f| answer("ht", f, input));
        let [value, jacobian] = replies(&input);
        assert_close(name, &value, &reference["objective"]);
        assert_close(name, &jacobian, &reference["jacobian"]);
        // The answer for a mirrored hand must be the mirror image of the answer for a hand whose rotation, translation
        // and targets are mirrored.
        let reflect = |number: &mut Value| *number = json!(-number.as_f64().expect("a number"));
        input["data"]["model"]["is_mirrored"] = json!(true);
        (1..=3).for_each(|i| reflect(&mut input["theta"][i]));
        let points = input["data"]["points"]
            .as_array_mut()
            .expect("a list of points");
        points.iter_mut().for_each(|point| reflect(&mut point[0]));
        let [mirrored_value, mirrored_jacobian] = replies(&input);
        let mut values: Vec<f64> = serde_json::from_value(value).expect("numbers");
        let mut rows: Vec<Vec<f64>> = serde_json::from_value(jacobian).expect("rows of numbers");
        for (i, (value, row)) in values.iter_mut().zip(&mut rows).enumerate() {
            let theta = row.len() - 26;
            for j in 1..=3 {
                row[theta + j] *= -1.0;
            }
            if i % 3 == 0 {
                *value *= -1.0;
                row.iter_mut().for_each(|x| *x *= -1.0);
            }
        }
        assert_close(name, &mirrored_value, &json!(values));
        assert_close(name, &mirrored_jacobian, &json!(rows));
    }
}
