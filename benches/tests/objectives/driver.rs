//! Runs the tool through the protocol of GradBench.

use autodiff::Real;
use benches::gradbench::serve;
use serde_json::{Value, json};

/// The largest allowed relative distance of an answer from the right one, in the 2-norm. GradBench's own tolerance
/// would accept wrong derivatives. The answers of GradBench's tools agree to about 1e-12.
const TOLERANCE: f64 = 1e-7;

/// Returns the relative distance of an answer from the right answer in the 2-norm. It is infinite if the shapes differ or
/// a number is not finite. Absolute distances up to 1e-300 count as zero.
fn distance(answer: &Value, right: &Value) -> f64 {
    let (mut gaps, mut numbers) = (Vec::new(), Vec::new());
    let same_shape = pair(answer, right, &mut |a, b| {
        gaps.push(a - b);
        numbers.push(b);
    });
    let (gap, distance) = (f64::norm(&gaps), f64::norm(&gaps) / f64::norm(&numbers));
    match gap {
        _ if !same_shape => f64::INFINITY,
        ..=1e-300 => 0.0,
        _ if distance.is_nan() => f64::INFINITY,
        _ => distance,
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

#[test]
fn distances_are_relative_and_other_shapes_are_infinitely_far() {
    assert_eq!(distance(&json!([3.0, 4.5]), &json!([3, 4])), 0.1);
    assert_eq!(distance(&json!([2e-200]), &json!([1e-200])), 1.0);
    assert_eq!(distance(&json!([2e-310]), &json!([1e-310])), 0.0);
    for (answer, right) in [
        (json!([1.0]), json!([1.0, 2.0])),
        (json!({"a": 1.0}), json!({"b": 1.0})),
        (json!([null]), json!([1.0])),
        (json!([1.0]), json!([0.0])),
    ] {
        assert_eq!(distance(&answer, &right), f64::INFINITY, "{answer}");
    }
}

#[track_caller]
fn assert_close(what: &str, answer: &Value, right: &Value) {
    let distance = distance(answer, right);
    assert!(distance <= TOLERANCE, "{what} is off by {distance:e}");
}

/// Sends lines to the tool and returns its replies.
pub(crate) fn replies(lines: &[u8]) -> Vec<Value> {
    let mut replies = Vec::new();
    serve(lines, &mut replies).expect("memory can be written");
    let replies = String::from_utf8(replies).expect("replies are text");
    let parse = |line| serde_json::from_str(line).expect("a reply is JSON");
    replies.lines().map(parse).collect()
}

/// Returns a request to run a function.
pub(crate) fn request(module: &str, function: &str, input: &Value) -> Value {
    json!({ "id": 2, "kind": "evaluate", "module": module, "function": function, "input": input })
}

/// Returns the reply of the tool to a single message.
pub(crate) fn reply(message: &Value) -> Value {
    let mut replies = replies(format!("{message}\n").as_bytes());
    assert_eq!(replies.len(), 1, "a line has one reply");
    replies.remove(0)
}

/// Asserts that the tool's answer for a function is close to the right answer.
#[track_caller]
pub(crate) fn agrees(module: &str, function: &str, input: &Value, right: &Value) {
    assert_close(module, &answer(module, function, input), right);
}

/// Returns the tool's answer for a function.
pub(crate) fn answer(module: &str, function: &str, input: &Value) -> Value {
    let mut reply = reply(&request(module, function, input));
    assert_eq!(
        reply["success"], true,
        "{module} {function}: {}",
        reply["error"]
    );
    reply["output"].take()
}
