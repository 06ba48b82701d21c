//! Reproduces every reference case in the same way as `cosmic evaluate --gradient`. States, losses, measures and
//! gradients agree with the file within its tolerances.

use cosmic::lattice::Lattice;
use cosmic::scene::edges;
use cosmic_tests::{
    Reference, numbers, own_reference_folder, reference_folder, reference_subfolder, references,
    workspace,
};
use serde_json::Value;

/// The name of the tolerance for a result. `path` consists of the keys under which the file has the result.
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

/// Compares all results in `expected`, a part of the file, and returns how many were compared.
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
    assert_reproduced(&references(&reference_folder()));
}

/// The cases in space. The reader takes their edges from the file, so their order is compared too.
#[test]
fn every_case_in_space_is_reproduced() {
    let cases = references(&reference_subfolder("space"));
    assert!(cases.len() >= 4, "{} cases", cases.len());
    assert_reproduced(&cases);
    for reference in &cases {
        let case = reference.case();
        let laid_out = Lattice::new(&case.scene.lattice, &case.scene.physics);
        assert_eq!(case.lattice.edges, laid_out.edges, "{}", reference.name());
    }
}

/// The cases of the implicit step, which an independent program has computed.
#[test]
fn implicit_steps_are_reproduced() {
    assert_reproduced(&references(&workspace().join("tests/data/implicit")));
}

fn assert_reproduced(references: &[Reference]) {
    for reference in references {
        let results = reference.case().evaluate(true, &[]);
        let results = results.unwrap_or_else(|error| panic!("{error}"));
        let got: Value = serde_json::from_str(&results.to_json()).expect("results are JSON");
        let expected = &reference.json["results"];
        let fields = compare(reference, &[], &got["results"], expected);
        println!("{}: {fields} fields", reference.name());
        assert!(fields > 20, "{} lists almost nothing", reference.name());
    }
}

/// Edges of regular lattices have the same order in files and in the program. The reader takes the edges from the file,
/// so only this test checks the order.
#[test]
fn edges_are_laid_out_in_the_order_of_the_files() {
    for reference in references(&own_reference_folder()) {
        let case = reference.case();
        let expected = edges(case.scene.lattice.columns, case.scene.lattice.rows);
        assert_eq!(case.lattice.edges, expected, "{}", reference.name());
    }
}
