//! How answers are compared with right ones.

use benches::adbench::gap;
use benches::distance::{distance, largest_distance};
use serde_json::json;

#[test]
fn distances_are_relative_down_to_the_smallest_numbers() {
    assert_eq!(distance(&json!([3.0, 4.5]), &json!([3, 4])), 0.1);
    assert_eq!(distance(&json!([2e-200]), &json!([1e-200])), 1.0);
    assert_eq!(distance(&json!([2e-310]), &json!([1e-310])), 0.0);
    assert_eq!(distance(&json!({"a": [0.0]}), &json!({"a": [1e-9]})), 1.0);
    assert_eq!(distance(&json!({"a": 1.0}), &json!({"a": 1.0})), 0.0);
    assert_eq!(largest_distance(&json!([3.0, 4.5]), &json!([3, 4])), 0.125);
}

#[test]
fn other_shapes_and_null_are_infinitely_far() {
    for (answer, right) in [
        (json!([1.0]), json!([1.0, 2.0])),
        (json!({"a": 1.0}), json!({"b": 1.0})),
        (json!([null]), json!([1.0])),
        (json!(1.0), json!([1.0])),
        (json!([1.0]), json!([0.0])),
    ] {
        assert_eq!(distance(&answer, &right), f64::INFINITY, "{answer}");
    }
}

#[test]
fn the_worst_field_is_found() {
    let reference = json!({"case": "x", "tolerance": 1e-3, "a": [1.0, -4.0], "b": {"c": 2.0}});
    let close = gap(&json!({"a": [1.0, -4.001], "b": {"c": 2.0}}), &reference);
    assert!(close.is_close() && close.field == "/a", "{close:?}");
    // The largest difference is 0.001, and the largest number is 4.
    assert!((close.error - 2.5e-4).abs() < 1e-12, "{close:?}");
    for answer in [
        json!({"a": [1.0, -4.1], "b": {"c": 2.0}}),
        json!({"a": [1.0], "b": {"c": 2.0}}),
        json!({"a": [1.0, -4.0]}),
        json!({"a": [1.0, null], "b": {"c": 2.0}}),
    ] {
        assert!(!gap(&answer, &reference).is_close(), "{answer}");
    }
    assert!(!gap(&json!({}), &json!({"tolerance": 1.0})).is_close());
}

#[test]
fn integers_must_agree_exactly() {
    let reference = json!({"tolerance": 1.0, "cols": [0, 1, 2]});
    assert!(gap(&json!({"cols": [0, 1, 2]}), &reference).is_close());
    assert!(!gap(&json!({"cols": [0, 1, 3]}), &reference).is_close());
}
