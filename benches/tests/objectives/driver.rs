//! Runs the tool through the protocol of GradBench.

use benches::distance::distance;
use benches::gradbench::serve;
use serde_json::{Value, json};

/// The largest allowed relative distance of an answer from the right one, in the 2-norm. GradBench's own tolerance
/// would accept wrong derivatives. The answers of GradBench's tools agree to about 1e-12.
const TOLERANCE: f64 = 1e-7;

#[track_caller]
pub(crate) fn assert_close(what: &str, answer: &Value, right: &Value) {
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
