//! Measures the distance between two answers.

use serde_json::Value;

/// Returns the relative distance of an answer from the right answer in the 2-norm. It is infinite if the shapes
/// differ or a number is not finite. Absolute distances up to 1e-300 count as zero.
pub fn distance(answer: &Value, right: &Value) -> f64 {
    // The norm is computed by `hypot`, because the square of a very small or very large number may be zero or infinite.
    let norm = |numbers: &[f64]| numbers.iter().fold(0.0, |sum: f64, x| sum.hypot(*x));
    relative(answer, right, norm)
}

/// Returns the relative distance of an answer from the right answer, like [`distance`], but in the maximum norm.
pub fn largest_distance(answer: &Value, right: &Value) -> f64 {
    relative(answer, right, largest)
}

fn relative(answer: &Value, right: &Value, norm: impl Fn(&[f64]) -> f64) -> f64 {
    let (mut gaps, mut numbers) = (Vec::new(), Vec::new());
    if !pair(answer, right, &mut |a, b| {
        gaps.push(a - b);
        numbers.push(b);
    }) {
        return f64::INFINITY;
    }
    let gap = norm(&gaps);
    if gap <= 1e-300 {
        return 0.0;
    }
    let distance = gap / norm(&numbers);
    if distance.is_nan() {
        f64::INFINITY
    } else {
        distance
    }
}

/// Calls `pass` with each pair of corresponding numbers in two answers. Returns false if the shapes differ.
fn pair(answer: &Value, right: &Value, pass: &mut impl FnMut(f64, f64)) -> bool {
    match (answer, right) {
        (Value::Array(a), Value::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| pair(a, b, pass))
        }
        (Value::Object(a), Value::Object(b)) => {
            let mut known = a.iter();
            let same = |(name, a): (&String, &Value)| b.get(name).is_some_and(|b| pair(a, b, pass));
            a.len() == b.len() && known.all(same)
        }
        (Value::Number(a), Value::Number(b)) => {
            let float = |number: &serde_json::Number| number.as_f64().unwrap_or(f64::NAN);
            pass(float(a), float(b));
            true
        }
        _ => false,
    }
}

/// Returns the largest magnitude, or NaN if one of the numbers is NaN.
fn largest(numbers: &[f64]) -> f64 {
    let larger = |most: f64, number: &f64| {
        let larger = number.abs() > most || number.is_nan();
        if larger { number.abs() } else { most }
    };
    numbers.iter().fold(0.0, larger)
}
