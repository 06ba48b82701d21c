//! GradBench's protocol: a line of JSON in, a line of JSON out.

use std::io::{self, BufRead, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;

use super::{Refusal, Work, evaluation};

/// The name that the tool gives itself.
pub const TOOL: &str = "cosmic-autodiff";

/// A line of the evaluation's.
#[derive(Deserialize)]
struct Message<'a> {
    #[serde(borrow)]
    id: &'a RawValue,
    kind: String,
    module: Option<String>,
    function: Option<String>,
    #[serde(borrow)]
    input: Option<&'a RawValue>,
}

/// All that is read of a line which is no message.
#[derive(Deserialize)]
struct Identified<'a> {
    #[serde(borrow)]
    id: &'a RawValue,
}

/// How often a function is run.
#[derive(Deserialize)]
#[serde(default)]
struct Effort {
    min_runs: u64,
    min_seconds: f64,
}

impl Default for Effort {
    fn default() -> Self {
        Self {
            min_runs: 1,
            min_seconds: 0.0,
        }
    }
}

/// The answer to a line.
#[derive(Default, Serialize)]
struct Reply<'a> {
    id: Option<&'a RawValue>,
    #[serde(skip_serializing_if = "Option::is_none")]
    tool: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    success: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    output: Option<Box<RawValue>>,
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

fn answer(line: &[u8]) -> Reply<'_> {
    let message: Message = match serde_json::from_slice(line) {
        Ok(message) => message,
        Err(error) => {
            let identified = serde_json::from_slice(line).ok();
            let id = identified.map(|Identified { id }| id);
            return Reply {
                id,
                ..refused(format!("the line is no message: {error}"))
            };
        }
    };
    let reply = match message.kind.as_str() {
        "start" => Reply {
            tool: Some(TOOL),
            ..Reply::default()
        },
        "define" => define(&message),
        "evaluate" => evaluate(&message),
        _ => Reply::default(),
    };
    Reply {
        id: Some(message.id),
        ..reply
    }
}

fn refused<'a>(error: String) -> Reply<'a> {
    Reply {
        success: Some(false),
        error: Some(error),
        ..Reply::default()
    }
}

fn define<'a>(message: &Message<'_>) -> Reply<'a> {
    let module = message.module.as_deref().unwrap_or_default();
    if evaluation(module).is_none() {
        return refused(format!("there is no module '{module}'"));
    }
    Reply {
        success: Some(true),
        ..Reply::default()
    }
}

/// Runs a function. That a panic does not end the session is a safeguard: inputs are checked when
/// they are read.
fn evaluate<'a>(message: &Message<'_>) -> Reply<'a> {
    let timed = catch_unwind(AssertUnwindSafe(|| timed(message)));
    match timed {
        Ok(Ok((output, timings))) => Reply {
            success: Some(true),
            output: Some(output),
            timings,
            ..Reply::default()
        },
        Ok(Err(refusal)) => refused(refusal.to_string()),
        Err(_) => refused("the function panicked".into()),
    }
}

fn timed(message: &Message<'_>) -> Result<(Box<RawValue>, Vec<Timing>), Refusal> {
    let module = message.module.as_deref().unwrap_or_default();
    let function = message.function.as_deref().unwrap_or_default();
    let missing = |what: &str| Refusal::Shape(what.to_owned());
    let prepare = evaluation(module).ok_or_else(|| missing("there is no such module"))?;
    let input = message.input.ok_or_else(|| missing("it is missing"))?;
    let effort = effort(input)?;
    let start = Instant::now();
    let mut work = prepare(function, input)?;
    let mut timings = vec![Timing::new("prepare", start.elapsed())];
    run(&mut *work, &effort, &mut timings);
    let output = work.answer()?;
    // What is not finite is written so; no answer has it otherwise.
    if output.contains("null") {
        return Err(Refusal::NotFinite);
    }
    Ok((RawValue::from_string(output)?, timings))
}

/// The effort that an input asks for. The numbers of `hello` ask for none.
fn effort(input: &RawValue) -> Result<Effort, Refusal> {
    if input.get().starts_with('{') {
        Ok(serde_json::from_str(input.get())?)
    } else {
        Ok(Effort::default())
    }
}

/// Runs until there are runs enough, and together they have taken long enough.
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
