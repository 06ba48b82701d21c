//! The command line of ADBench and GradBench.

use std::io::{self, BufReader, BufWriter};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};

use crate::adbench::{cases, input, table};
use crate::gradbench::serve;
use crate::machine::section;
use crate::objectives::problem;

/// Differentiates what GradBench asks for, on standard input and output.
#[derive(Parser)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// Answers a Gaussian mixture of ADBench: value and gradient
    Gmm(Instance),
    /// Answers a bundle adjustment of ADBench: residuals and sparse Jacobian
    Ba(Instance),
    /// Answers a language model of ADBench: value and gradient
    Lstm(Instance),
    /// Answers hand tracking of ADBench, simple or complicated: residuals and Jacobian
    Hand(Instance),
    /// Checks and times all cases of ADBench in a folder, and prints a table
    Table {
        /// The folder of cases: `data` and `reference`
        #[arg(long, env = "ADBENCH_DIR", default_value = "tests/data/adbench")]
        cases: PathBuf,
    },
}

#[derive(Args)]
struct Instance {
    /// The data
    file: PathBuf,
    /// Where the answer goes, as JSON
    #[arg(long)]
    out: PathBuf,
    /// The folder of the hand's model [default: `model` beside the file]
    #[arg(long)]
    model: Option<PathBuf>,
}

type Outcome = Result<(), Box<dyn std::error::Error>>;

/// Runs what the command line asks for.
pub fn main() -> ExitCode {
    let outcome = match Cli::parse().command {
        Some(Command::Gmm(instance)) => answer("gmm", &instance),
        Some(Command::Ba(instance)) => answer("ba", &instance),
        Some(Command::Lstm(instance)) => answer("lstm", &instance),
        Some(Command::Hand(instance)) => answer("ht", &instance),
        Some(Command::Table { cases: folder }) => cases(&folder)
            .and_then(|cases| table(&cases))
            .map(|table| print!("{}", section("ADBench", "adbench table", &table)))
            .map_err(Into::into),
        None => tool(),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn answer(module: &str, instance: &Instance) -> Outcome {
    let beside = instance.file.with_file_name("model");
    let model = instance.model.as_deref().unwrap_or(&beside);
    let mut problem = problem(module, input(module, &instance.file, model)?)?;
    problem.derivative();
    problem.objective();
    let path = &instance.out;
    std::fs::write(path, problem.answer().to_string())
        .map_err(|error| format!("cannot write {}: {error}", path.display()).into())
}

fn tool() -> Outcome {
    /// Lines are long: whole models in one.
    const BUFFER: usize = 1 << 20;
    let lines = BufReader::with_capacity(BUFFER, io::stdin().lock());
    let replies = BufWriter::with_capacity(BUFFER, io::stdout().lock());
    Ok(serve(lines, replies)?)
}
