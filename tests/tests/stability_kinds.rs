//! Every stability file is of a kind that some test knows, and every kind is there.

use cosmic_tests::{reference_subfolder, references};
use serde_json::Value;

/// A list of a file, a key that only cases of one kind have, and the tests of that kind.
const KINDS: [(&str, &str, &str); 14] = [
    ("cases", "eigenvalues", "stability_vibration"),
    ("cases", "rest", "stability_vibration"),
    ("cases", "omega_bound_edge", "stability_vibration"),
    ("cases", "window_means_over_E0", "stability_energy"),
    ("linear", "invariant", "stability_energy"),
    ("cases", "terminal_velocity_discrete", "stability_contact"),
    ("cases", "first_touches_step_tau", "stability_contact"),
    ("cases", "slid_down", "stability_contact"),
    ("braking", "stops_at_step", "stability_contact"),
    ("cases", "exact_dx_dH_infinite", "stability_contact"),
    ("cases", "x_100000", "stability_rest"),
    ("cases", "jacobian_dp_dz", "stability_projection"),
    ("cases", "dtanh", "stability_elementary"),
    ("cases", "tangent_dF_dd", "stability_elementary"),
];

/// The kind of a case.
fn kind(list: &str, case: &Value) -> Option<&'static str> {
    let of = |(of, key, _): &&(&str, &str, &str)| *of == list && case.get(key).is_some();
    KINDS.iter().find(of).map(|(_, key, _)| *key)
}

#[test]
fn every_case_is_of_a_known_kind_and_every_kind_has_cases() {
    let mut seen = Vec::new();
    for reference in references(&reference_subfolder("stability")) {
        for list in ["cases", "linear", "braking"] {
            for case in reference.json[list].as_array().into_iter().flatten() {
                let kind = kind(list, case);
                let name = reference.name();
                seen.push(kind.unwrap_or_else(|| panic!("{name}: no test knows {case}")));
            }
        }
        assert!(
            reference.json["cases"].is_array(),
            "{}: no `cases`",
            reference.name()
        );
    }
    for (_, key, _) in KINDS {
        assert!(seen.contains(&key), "no stability case with `{key}`");
    }
}

/// The tests named above are there.
#[test]
fn every_kind_has_its_test() {
    for (_, key, file) in KINDS {
        let path = format!("{}/tests/{file}.rs", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(
            text.contains(&format!("\"{key}\"")),
            "{path} has no test of `{key}`"
        );
    }
}
