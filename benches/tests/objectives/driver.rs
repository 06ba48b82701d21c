//! The other side of the protocol.

use benches::distance::distance;
use benches::gradbench::protocol::serve;
use serde_json::{Value, json};

/// How far an answer may be from the right one, in the relative 2-norm: what GradBench accepts would pass
/// wrong derivatives, and the answers of its tools agree to about 1e-12.
pub(crate) const TOLERANCE: f64 = 1e-7;

pub(crate) fn assert_close(what: &str, answer: &Value, right: &Value) {
    let distance = distance(answer, right);
    assert!(distance <= TOLERANCE, "{what} is off by {distance:e}");
}

/// The replies to lines.
pub(crate) fn replies(lines: &str) -> Vec<Value> {
    let mut replies = Vec::new();
    serve(lines.as_bytes(), &mut replies).expect("memory can be written");
    let replies = String::from_utf8(replies).expect("replies are text");
    let parse = |line| serde_json::from_str(line).expect("a reply is JSON");
    replies.lines().map(parse).collect()
}

/// A request to run a function.
pub(crate) fn request(module: &str, function: &str, input: &Value) -> Value {
    json!({ "id": 2, "kind": "evaluate", "module": module, "function": function, "input": input })
}

/// The only reply to a message.
pub(crate) fn reply(message: &Value) -> Value {
    let mut replies = replies(&format!("{message}\n"));
    assert_eq!(replies.len(), 1, "a line has one reply");
    replies.remove(0)
}

/// The answer of a function.
pub(crate) fn answer(module: &str, function: &str, input: &Value) -> Value {
    let mut reply = reply(&request(module, function, input));
    assert_eq!(
        reply["success"], true,
        "{module} {function}: {}",
        reply["error"]
    );
    reply["output"].take()
}
