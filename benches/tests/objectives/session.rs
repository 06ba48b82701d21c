//! Tests the protocol: each kind of line must get the right reply.

use std::io::Write;
use std::process::{Command, Stdio};

use benches::objectives::EVALUATIONS;
use serde_json::{Value, json};

use crate::draw::Draw;
use crate::driver::{replies, reply, request};

#[test]
fn every_kind_of_line_has_its_reply() {
    let start = reply(&json!({ "id": 7, "kind": "start", "eval": "llsq", "config": { "n": 1 } }));
    assert_eq!(start["id"], 7);
    assert!(start["tool"].is_string());
    for (module, _) in EVALUATIONS {
        let define = reply(&json!({ "id": 1, "kind": "define", "module": module }));
        assert_eq!(define, json!({ "id": 1, "success": true }));
    }
    let unknown = reply(&json!({ "id": 1, "kind": "define", "module": "nonesuch" }));
    assert_eq!(unknown["success"], false);
    let analysis = json!({ "id": 3, "kind": "analysis", "of": 2, "valid": false, "error": "no" });
    assert_eq!(reply(&analysis), json!({ "id": 3 }));
    assert_eq!(
        reply(&json!({ "id": "x", "kind": "nonesuch" })),
        json!({ "id": "x" })
    );
}

#[test]
fn malformed_lines_are_refused_and_the_session_goes_on() {
    let good = request("hello", "square", &json!(3)).to_string();
    let lines = [
        &b"\xff\xfe"[..],
        b"",
        b"\"text\"",
        b"{\"id\":5}",
        b"{\"id\":6,\"kind\":3}",
        b"{\"id\":7,\"kind\":\"evaluate\"}",
        good.as_bytes(),
    ];
    let replies = replies(&lines.join(&b'\n'));
    let ids = [
        json!(null),
        json!(null),
        json!(null),
        json!(5),
        json!(6),
        json!(7),
    ];
    assert_eq!(replies.len(), ids.len() + 1);
    for (reply, id) in replies.iter().zip(&ids) {
        assert_eq!((&reply["id"], &reply["success"]), (id, &json!(false)));
        assert!(reply["error"].is_string(), "{reply}");
    }
    assert_eq!(replies[6]["output"], 9.0);
}

#[test]
fn inputs_that_do_not_fit_are_refused() {
    let mut ragged = Draw(1).kmeans(2, 5, 3);
    ragged["points"][1] = json!([1.0]);
    let mut short = Draw(1).gmm(2, 2, 3);
    short["l"] = json!([[], []]);
    let mut few = Draw(1).lstm(1, 3);
    few["state"] = json!([[1.0]]);
    let ba = |n: usize| json!({ "n": n, "m": 1, "p": 1, "cam": vec![0.1; 11], "x": [1, 2, 3], "w": 1, "feat": [0, 0] });
    for (module, function, input) in [
        ("hello", "nonesuch", json!(1.0)),
        ("hello", "square", json!("one")),
        ("nonesuch", "square", json!(1.0)),
        ("llsq", "primal", json!({ "x": [1.0] })),
        ("llsq", "primal", json!({ "x": [1.0], "n": 1 })),
        ("lse", "gradient", json!({ "x": [] })),
        ("det", "gradient", json!({ "A": [1.0, 2.0], "ell": 2 })),
        ("ode", "primal", json!({ "x": [1.0], "s": 0 })),
        ("kmeans", "dir", ragged),
        ("gmm", "objective", short),
        ("lstm", "jacobian", few),
        ("ba", "jacobian", ba(0)),
        ("ba", "jacobian", ba(usize::MAX)),
        ("saddle", "rr", json!({ "start": [1.0] })),
        ("particle", "rr", json!({})),
    ] {
        let reply = reply(&request(module, function, &input));
        assert_eq!(reply["success"], false, "{module} {function}");
        assert!(
            reply["error"].is_string() && reply["output"].is_null(),
            "{module} {function}"
        );
    }
}

#[test]
fn an_answer_that_is_not_finite_is_refused() {
    let huge = json!({ "x": [1e200, 1e200], "n": 3 });
    let reply = reply(&request("llsq", "primal", &huge));
    assert_eq!(reply["success"], false);
}

fn evaluations(reply: &Value) -> Vec<u64> {
    let timings = reply["timings"].as_array().expect("there are timings");
    let runs = timings.iter().filter(|timing| timing["name"] == "evaluate");
    runs.map(|run| run["nanoseconds"].as_u64().expect("whole nanoseconds"))
        .collect()
}

#[test]
fn functions_run_as_often_and_as_long_as_asked() {
    let mut input = Draw(1).llsq(16, 4);
    let runs = |input: &Value| evaluations(&reply(&request("llsq", "gradient", input)));
    assert_eq!(runs(&input).len(), 1);
    input["min_runs"] = json!(5);
    assert_eq!(runs(&input).len(), 5);
    input["min_seconds"] = json!(0.01);
    let runs = runs(&input);
    assert!(runs.len() > 5 && runs.iter().sum::<u64>() >= 10_000_000);
}

#[test]
fn lines_may_be_long() {
    let input = json!({ "x": Draw(1).uniforms(100_000) });
    let reply = reply(&request("lse", "gradient", &input));
    assert_eq!(reply["output"].as_array().map(Vec::len), Some(100_000));
}

#[test]
fn the_program_answers_and_ends_with_its_input() {
    let mut tool = Command::new(env!("CARGO_BIN_EXE_gradbench"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("the tool starts");
    let lines = format!(
        "{}\nnot JSON\n{}\n",
        json!({ "id": 0, "kind": "start", "eval": "hello" }),
        request("hello", "double", &json!(4.0))
    );
    let mut stdin = tool.stdin.take().expect("the tool has an input");
    stdin
        .write_all(lines.as_bytes())
        .expect("the tool reads its input");
    drop(stdin);
    let output = tool.wait_with_output().expect("the tool ends");
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).expect("replies are text");
    let replies: Vec<Value> = text
        .lines()
        .map(|line| serde_json::from_str(line).expect("a reply is JSON"))
        .collect();
    assert_eq!(replies.len(), 3);
    assert_eq!(replies[2]["output"], 8.0);
}
