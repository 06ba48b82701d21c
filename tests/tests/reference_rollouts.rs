//! Every reference case, run as `cosmic evaluate --gradient` runs it: states, losses, measures and
//! gradients within the file's own tolerances.

use cosmic_tests::{Reference, numbers, reference_folder, references};
use serde_json::Value;

/// The kind of tolerance for a result, by the key that leads to it.
fn tolerance(path: &[&str]) -> &'static str {
    match path {
        ["trajectory", step, _] if step.parse::<usize>().is_ok_and(|n| n <= 3) => "early",
        ["trajectory", ..] | ["l_disp" | "displacement"] => "forward",
        [augmented] if augmented.starts_with("augmented") => "forward",
        [gradient, "z"] if gradient.starts_with("grad_") => "gradient_z",
        [gradient, _] if gradient.starts_with("grad_") => "gradient",
        _ => "algebraic",
    }
}

/// Compares everything that the file lists, and returns how many fields that was.
fn compare(reference: &Reference, path: &[&str], got: &Value, expected: &Value) -> usize {
    if let Value::Object(fields) = expected {
        let field = |(key, expected): (&String, &Value)| {
            compare(
                reference,
                &[path, &[key.as_str()]].concat(),
                &got[key],
                expected,
            )
        };
        return fields.iter().map(field).sum();
    }
    let name = path.join(".");
    assert!(!got.is_null(), "{}: {name} is missing", reference.name());
    let [got, expected] = [got, expected].map(numbers);
    reference.check(&name, tolerance(path), [&got, &expected]);
    1
}

#[test]
fn every_case_is_reproduced() {
    for reference in references(&reference_folder()) {
        let results = reference.case().evaluate(true, &[]);
        let results = results.unwrap_or_else(|error| panic!("{error}"));
        let got: Value = serde_json::from_str(&results.to_json()).expect("results are JSON");
        let expected = &reference.json["results"];
        let fields = compare(&reference, &[], &got["results"], expected);
        println!("{}: {fields} fields", reference.name());
        assert!(fields > 20, "{} lists next to nothing", reference.name());
    }
}
