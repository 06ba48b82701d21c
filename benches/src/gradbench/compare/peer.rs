//! Another tool, as a process that speaks the protocol.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use serde_json::{Value, json};

/// What goes wrong in a comparison.
pub type Error = Box<dyn std::error::Error>;

/// A running tool. It ends when this is dropped.
pub struct Peer {
    child: Child,
    lines: Option<ChildStdin>,
    replies: BufReader<ChildStdout>,
}

/// The answer of a function, and the seconds of its fastest run.
pub struct Measured {
    /// The answer.
    pub output: Value,
    /// The seconds.
    pub least: f64,
}

impl Peer {
    /// Starts a command in a folder; its words are separated by spaces.
    ///
    /// # Errors
    /// If it cannot be started.
    pub fn start(command: &str, folder: &Path) -> Result<Self, Error> {
        let mut words = command.split_whitespace();
        let program = words.next().ok_or("the peer's command is empty")?;
        let mut child = Command::new(program)
            .args(words)
            .current_dir(folder)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| format!("cannot start '{program}': {error}"))?;
        let lines = child.stdin.take();
        let replies = child.stdout.take().ok_or("the peer has no output")?;
        Ok(Self {
            child,
            lines,
            replies: BufReader::new(replies),
        })
    }

    /// Sends a message and returns the reply.
    fn ask(&mut self, message: &Value) -> Result<Value, Error> {
        let lines = self.lines.as_mut().ok_or("the peer has no input")?;
        writeln!(lines, "{message}")?;
        lines.flush()?;
        let mut reply = String::new();
        self.replies.read_line(&mut reply)?;
        Ok(serde_json::from_str(&reply)?)
    }

    /// Whether it has an evaluation.
    ///
    /// # Errors
    /// If it does not answer.
    pub fn define(&mut self, module: &str) -> Result<bool, Error> {
        self.ask(&json!({ "id": 0, "kind": "start", "eval": module }))?;
        let reply = self.ask(&json!({ "id": 1, "kind": "define", "module": module }))?;
        Ok(reply["success"] == true)
    }

    /// Has a function run.
    ///
    /// # Errors
    /// If it does not answer, or has no answer.
    pub fn evaluate(
        &mut self,
        module: &str,
        function: &str,
        input: &Value,
    ) -> Result<Measured, Error> {
        let mut reply = self.ask(&json!({
            "id": 2, "kind": "evaluate", "module": module, "function": function, "input": input,
        }))?;
        if reply["success"] != true {
            return Err(format!("{module} {function}: {}", reply["error"]).into());
        }
        let timings = reply["timings"].as_array().cloned().unwrap_or_default();
        let runs = timings.iter().filter(|timing| timing["name"] == "evaluate");
        let least = runs
            .filter_map(|run| run["nanoseconds"].as_f64())
            .reduce(f64::min);
        Ok(Measured {
            output: reply["output"].take(),
            least: least.unwrap_or(f64::NAN) * 1e-9,
        })
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        self.lines = None;
        // It has nothing more to do; how it ends does not matter.
        let _ = self.child.wait();
    }
}
