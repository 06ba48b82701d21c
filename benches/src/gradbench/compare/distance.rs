//! How far two answers are apart.

use serde_json::Value;

/// A distance below this is none.
const NONE: f64 = 1e-300;

/// The distance of an answer from the right one in the 2-norm, by the norm of the right one; infinite
/// where the shapes differ or a number is not finite.
pub fn distance(answer: &Value, right: &Value) -> f64 {
    let mut pairs = Vec::new();
    if !pair(answer, right, &mut pairs) {
        return f64::INFINITY;
    }
    let gap = norm(pairs.iter().map(|[a, b]| a - b));
    if gap <= NONE {
        return 0.0;
    }
    let distance = gap / norm(pairs.iter().map(|[_, b]| *b));
    if distance.is_nan() {
        f64::INFINITY
    } else {
        distance
    }
}

/// Lists the numbers of two answers side by side; false where the shapes differ.
fn pair(answer: &Value, right: &Value, pairs: &mut Vec<[f64; 2]>) -> bool {
    match (answer, right) {
        (Value::Array(a), Value::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| pair(a, b, pairs))
        }
        (Value::Object(a), Value::Object(b)) => {
            let mut known = a.iter();
            a.len() == b.len()
                && known.all(|(name, a)| b.get(name).is_some_and(|b| pair(a, b, pairs)))
        }
        (Value::Number(a), Value::Number(b)) => {
            pairs.push([a, b].map(|number| number.as_f64().unwrap_or(f64::NAN)));
            true
        }
        _ => false,
    }
}

/// The 2-norm, by the largest magnitude, whose square may be too small or too large a number.
fn norm(numbers: impl Iterator<Item = f64> + Clone) -> f64 {
    let mut largest = 0.0;
    for number in numbers.clone() {
        if number.is_nan() {
            return f64::NAN;
        }
        largest = f64::max(largest, number.abs());
    }
    if largest == 0.0 {
        return 0.0;
    }
    let squares = numbers.map(|number| (number / largest).powi(2));
    largest * squares.sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::distance;
    use serde_json::json;

    #[test]
    fn distances_are_relative_down_to_the_smallest_numbers() {
        assert_eq!(distance(&json!([3.0, 4.5]), &json!([3, 4])), 0.1);
        assert_eq!(distance(&json!([2e-200]), &json!([1e-200])), 1.0);
        assert_eq!(distance(&json!([2e-310]), &json!([1e-310])), 0.0);
        assert_eq!(distance(&json!({"a": [0.0]}), &json!({"a": [1e-9]})), 1.0);
        assert_eq!(distance(&json!({"a": 1.0}), &json!({"a": 1.0})), 0.0);
    }

    #[test]
    fn other_shapes_and_numbers_that_are_none_are_infinitely_far() {
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
}
