//! This tool beside another one: the same inputs, in turns, as a table.

mod distance;
mod peer;
mod workloads;

use std::fmt::Write as _;
use std::path::PathBuf;

use serde_json::{Value, json};

pub use distance::distance;
pub use peer::{Error, Measured, Peer};
pub use workloads::{TIMED, Workload, workloads};

use crate::machine::machine;

/// What is compared, and how long.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The command of the other tool.
    pub peer: String,
    /// GradBench's checkout, in which the command runs and which has the data.
    pub checkout: PathBuf,
    /// The evaluations, all if there are none.
    pub evaluations: Vec<String>,
    /// How often either tool has its turn at a function.
    pub turns: usize,
    /// The least seconds of a turn.
    pub seconds: f64,
}

/// Milliseconds of primal and derivative, of this tool and of the other.
type Times = [[f64; 2]; 2];

impl Comparison {
    /// Runs all, and returns the page.
    ///
    /// # Errors
    /// If a tool fails.
    pub fn page(&self) -> Result<String, Error> {
        let mut page = heading(&self.peer);
        let mut totals = String::new();
        for (module, functions) in TIMED {
            if !self.evaluations.is_empty() && !self.evaluations.iter().any(|e| e == module) {
                continue;
            }
            let (mut total, mut worst) = ([[0.0; 2]; 2], 0.0);
            for workload in workloads(module, &self.checkout.join("evals")) {
                let (times, error) = self.measure(module, functions, &workload)?;
                let name = format!("{module} {}", workload.name);
                row(&mut page, &name, error, times);
                eprintln!("{}", page.lines().last().unwrap_or_default());
                for (total, time) in total
                    .as_flattened_mut()
                    .iter_mut()
                    .zip(times.as_flattened())
                {
                    *total += time;
                }
                worst = f64::max(worst, error);
            }
            row(&mut totals, module, worst, total);
        }
        page += "\nSums over an evaluation's workloads, and the largest difference:\n\n";
        page += TITLES;
        page += &totals;
        Ok(page)
    }

    /// The times of a workload, and how far the answers are apart.
    fn measure(
        &self,
        module: &str,
        functions: [&str; 2],
        workload: &Workload,
    ) -> Result<(Times, f64), Error> {
        let mut input = workload.input.clone();
        input["min_runs"] = json!(3);
        input["min_seconds"] = json!(self.seconds);
        let own = std::env::current_exe()?;
        let mut own = Peer::start(&own.to_string_lossy(), &self.checkout)?;
        let mut other = Peer::start(&self.peer, &self.checkout)?;
        if !(own.define(module)? && other.define(module)?) {
            return Err(format!("{module} is undefined").into());
        }
        let (mut times, mut error) = ([[f64::INFINITY; 2]; 2], 0.0);
        for (which, function) in functions.into_iter().enumerate() {
            let mut outputs = [Value::Null, Value::Null];
            for _ in 0..self.turns {
                for (side, tool) in [&mut own, &mut other].into_iter().enumerate() {
                    let measured = tool.evaluate(module, function, &input)?;
                    times[side][which] = times[side][which].min(measured.least * 1e3);
                    outputs[side] = measured.output;
                }
            }
            error = f64::max(error, distance(&outputs[0], &outputs[1]));
        }
        Ok((times, error))
    }
}

/// The titles of the columns.
const TITLES: &str = "\
| workload | difference | primal | derivative | peer's primal | peer's derivative | ratio |
| --- | --- | --- | --- | --- | --- | --- |
";

fn row(page: &mut String, name: &str, error: f64, [own, other]: Times) {
    let ratio = (own[0] + own[1]) / (other[0] + other[1]);
    // Writing to a string cannot fail.
    let _ = writeln!(
        page,
        "| {name} | {error:.0e} | {:.4} | {:.4} | {:.4} | {:.4} | {ratio:.2} |",
        own[0], own[1], other[0], other[1],
    );
}

fn heading(peer: &str) -> String {
    format!(
        "\
# GradBench

This tool beside a peer: GradBench's inputs at middle sizes, milliseconds. Written by

`cargo run --release -p benches --bin gradbench -- compare --checkout GRADBENCH --peer \"{peer}\"`

Machine: {}, one thread. The tools run in turns on the same lines; each time is the least of all runs.

- *difference*: the larger of two relative distances in the 2-norm, of the primals and of the derivatives.
- *ratio*: primal and derivative together, by the peer's. Below 1 this tool is faster.
- The gradient of `ode` by GradBench's `manual` is that of the exact solution, which the steps only
  approximate: there neither its difference nor its time is comparable.

{TITLES}",
        machine(),
    )
}
