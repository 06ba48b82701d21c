//! GradBench's protocol: a line of JSON in, a line of JSON out.

use std::io::{self, BufRead, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use serde_json::Value;
use serde_json::value::RawValue;

use crate::objectives::{Error, Work, evaluation};

/// The name that the tool gives itself.
pub const TOOL: &str = "cosmic-autodiff";

/// A line of the evaluation.
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

/// How often a function is run.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Effort {
    min_runs: u64,
    min_seconds: f64,
}

/// The answer to a line.
#[derive(Default, Serialize)]
struct Reply {
    id: Value,
    #[serde(skip_serializing_if = "Option::is_none")]
    tool: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    success: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    output: Option<Value>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    timings: Vec<Timing>,
}

/// How long a part of the work took.
#[derive(Serialize)]
struct Timing {
    name: &'static str,
    nanoseconds: u64,
}

impl Timing {
    fn new(name: &'static str, elapsed: Duration) -> Self {
        let nanoseconds = u64::try_from(elapsed.as_nanos()).unwrap_or(u64::MAX);
        Self { name, nanoseconds }
    }
}

impl Reply {
    fn success() -> Self {
        Self {
            success: Some(true),
            ..Self::default()
        }
    }

    fn refusal(error: impl ToString) -> Self {
        Self {
            success: Some(false),
            error: Some(error.to_string()),
            ..Self::default()
        }
    }
}

/// Answers every line until there are no more.
///
/// # Errors
/// If a line cannot be read or a reply cannot be written; what a line says never ends the session.
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

fn answer(line: &[u8]) -> Reply {
    let message: Message = match serde_json::from_slice(line) {
        Ok(message) => message,
        Err(error) => return Reply::refusal(format!("malformed line: {error}")),
    };
    let reply = match message.kind.as_str() {
        Some("start") => Reply {
            tool: Some(TOOL),
            ..Reply::default()
        },
        Some("define") => match evaluation(text(&message.module)) {
            Ok(_) => Reply::success(),
            Err(error) => Reply::refusal(error),
        },
        Some("evaluate") => evaluate(&message),
        Some(_) => Reply::default(),
        None => Reply::refusal("malformed line: `kind` must be a string"),
    };
    Reply {
        id: message.id,
        ..reply
    }
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

/// Runs a function. That a panic does not end the session is a safeguard: inputs are checked when
/// they are read.
fn evaluate(message: &Message) -> Reply {
    match catch_unwind(AssertUnwindSafe(|| timed(message))) {
        Ok(Ok((output, timings))) => Reply {
            output: Some(output),
            timings,
            ..Reply::success()
        },
        Ok(Err(error)) => Reply::refusal(error),
        Err(_) => Reply::refusal("the function panicked"),
    }
}

fn timed(message: &Message) -> Result<(Value, Vec<Timing>), Error> {
    let prepare = evaluation(text(&message.module))?;
    let input = message.input.ok_or(Error::Shape("it is missing".into()))?;
    // The input of `hello` is a number, which has no room for an effort.
    let effort = match input.get().starts_with('{') {
        true => serde_json::from_str(input.get())?,
        false => Effort::default(),
    };
    let start = Instant::now();
    let mut work = prepare(text(&message.function), input)?;
    let mut timings = vec![Timing::new("prepare", start.elapsed())];
    run(&mut *work, &effort, &mut timings);
    let output = work.answer();
    if is_finite(&output) {
        Ok((output, timings))
    } else {
        Err(Error::NotFinite)
    }
}

/// Numbers that are not finite are null.
fn is_finite(output: &Value) -> bool {
    match output {
        Value::Null => false,
        Value::Array(list) => list.iter().all(is_finite),
        Value::Object(fields) => fields.values().all(is_finite),
        _ => true,
    }
}

/// Runs until there are enough runs that together have taken long enough.
fn run(work: &mut dyn Work, effort: &Effort, timings: &mut Vec<Timing>) {
    let (mut runs, mut seconds) = (0, 0.0);
    while runs < effort.min_runs.max(1) || seconds < effort.min_seconds {
        let start = Instant::now();
        work.run();
        let elapsed = start.elapsed();
        timings.push(Timing::new("evaluate", elapsed));
        runs += 1;
        seconds += elapsed.as_secs_f64();
    }
}
