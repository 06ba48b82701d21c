//! The command line of the programs `adbench` and `gradbench`.

use std::io::{self, BufReader, BufWriter};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};

use crate::adbench::{cases, input, table};
use crate::gradbench::serve;
use crate::machine::section;
use crate::objectives::problem;

/// Benchmarks of `autodiff`: without a command, answers GradBench requests on standard input and output.
#[derive(Parser)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// Solve a Gaussian mixture of ADBench: value and gradient
    Gmm(Instance),
    /// Solve a bundle adjustment of ADBench: residuals and sparse Jacobian
    Ba(Instance),
    /// Solve a language model of ADBench: value and gradient
    Lstm(Instance),
    /// Solve hand tracking of ADBench, simple or complicated: residuals and Jacobian
    Hand(Instance),
    /// Check and time all ADBench cases in a folder, and print a table
    Table {
        /// The folder of cases, with the subfolders `data` and `reference`
        #[arg(long, env = "ADBENCH_DIR", default_value = "tests/data/adbench")]
        cases: PathBuf,
    },
}

#[derive(Args)]
struct Instance {
    /// The data file
    file: PathBuf,
    /// The JSON file to write the answer to
    #[arg(long)]
    out: PathBuf,
    /// The folder of the hand's model [default: `model` beside the file]
    #[arg(long)]
    model: Option<PathBuf>,
}

type Outcome = Result<(), Box<dyn std::error::Error>>;

/// Runs the command given on the command line.
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
    /// The size of the input buffer in bytes. It is large, because one line may contain a whole model.
    const BUFFER: usize = 1 << 20;
    let lines = BufReader::with_capacity(BUFFER, io::stdin().lock());
    let replies = BufWriter::with_capacity(BUFFER, io::stdout().lock());
    Ok(serve(lines, replies)?)
}
