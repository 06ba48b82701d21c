//! The protocol of GradBench (<https://github.com/gradbench/gradbench>): for each line of JSON that is read, a line of
//! JSON is written.

use std::io::{self, BufRead, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use serde::Deserialize;
use serde_json::value::RawValue;
use serde_json::{Value, json};

use crate::objectives::{Error, Work, evaluation};

/// The name by which the tool introduces itself to GradBench.
pub const TOOL: &str = "cosmic-autodiff";

/// A message from GradBench. Each message is one line.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Message<'a> {
    id: Value,
    kind: Value,
    module: Value,
    function: Value,
    #[serde(borrow)]
    input: Option<&'a RawValue>,
}

/// How often to run a function: at least a number of times, and for at least a total time.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Effort {
    min_runs: u64,
    min_seconds: f64,
}

/// Reads messages line by line and answers each of them, until the input ends.
///
/// # Errors
/// If a line cannot be read or a reply cannot be written. A line with wrong content gets a reply and does not end the
/// session.
pub fn serve(mut lines: impl BufRead, mut replies: impl Write) -> io::Result<()> {
    let mut line = Vec::new();
    while lines.read_until(b'\n', &mut line)? > 0 {
        serde_json::to_writer(&mut replies, &answer(&line))?;
        replies.write_all(b"\n")?;
        replies.flush()?;
        line.clear();
    }
    Ok(())
}

fn answer(line: &[u8]) -> Value {
    let message: Message = match serde_json::from_slice(line) {
        Ok(message) => message,
        Err(error) => return refusal(Value::Null, format!("malformed line: {error}")),
    };
    let reply = match message.kind.as_str() {
        Some("start") => Ok(json!({ "tool": TOOL })),
        Some("define") => evaluation(text(&message.module)).map(|_| json!({ "success": true })),
        Some("evaluate") => evaluate(&message),
        Some(_) => Ok(json!({})),
        None => return refusal(message.id, "malformed line: `kind` must be a string"),
    };
    match reply {
        Ok(mut reply) => {
            reply["id"] = message.id;
            reply
        }
        Err(error) => refusal(message.id, error),
    }
}

fn refusal(id: Value, error: impl ToString) -> Value {
    json!({ "id": id, "success": false, "error": error.to_string() })
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

/// Runs the function of a message. The input is checked when it is read. If the function panics nevertheless, the
/// session goes on.
fn evaluate(message: &Message) -> Result<Value, Error> {
    catch_unwind(AssertUnwindSafe(|| timed(message))).unwrap_or(Err(Error::Panicked))
}

fn timed(message: &Message) -> Result<Value, Error> {
    let prepare = evaluation(text(&message.module))?;
    let input = message
        .input
        .ok_or(Error::Shape("`input` is missing".into()))?;
    // The input of `hello` is a number, so it says nothing about repetitions.
    let effort = match input.get().starts_with('{') {
        true => serde_json::from_str(input.get())?,
        false => Effort::default(),
    };
    let start = Instant::now();
    let mut work = prepare(text(&message.function), input)?;
    let mut timings = vec![timing("prepare", start.elapsed())];
    run(&mut *work, &effort, &mut timings);
    let output = work.answer();
    if is_finite(&output) {
        Ok(json!({ "success": true, "output": output, "timings": timings }))
    } else {
        Err(Error::NotFinite)
    }
}

fn timing(name: &str, elapsed: Duration) -> Value {
    json!({ "name": name, "nanoseconds": u64::try_from(elapsed.as_nanos()).unwrap_or(u64::MAX) })
}

/// Returns whether all numbers of the output are finite. Numbers that are not finite are written as null.
fn is_finite(output: &Value) -> bool {
    match output {
        Value::Null => false,
        Value::Array(list) => list.iter().all(is_finite),
        Value::Object(fields) => fields.values().all(is_finite),
        _ => true,
    }
}

/// Repeats the work until both the minimum number of runs and the minimum total time are reached.
fn run(work: &mut dyn Work, effort: &Effort, timings: &mut Vec<Value>) {
    let (mut runs, mut seconds) = (0, 0.0);
    while runs < effort.min_runs.max(1) || seconds < effort.min_seconds {
        let start = Instant::now();
        work.run();
        let elapsed = start.elapsed();
        timings.push(timing("evaluate", elapsed));
        runs += 1;
        seconds += elapsed.as_secs_f64();
    }
}
