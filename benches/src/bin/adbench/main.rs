//! ADBench's problems from the command line: answers for any file, and the table of times.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use benches::adbench::measure::Effort;
use benches::adbench::{Kind, cases, open, table};
use clap::{Args, Parser, Subcommand};

/// Objective and derivative of ADBench's problems.
#[derive(Parser)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// A Gaussian mixture: value and gradient.
    Gmm(Instance),
    /// Bundle adjustment: residuals and sparse Jacobian.
    Ba(Instance),
    /// A language model: value and gradient.
    Lstm(Instance),
    /// Hand tracking, simple or complicated: residuals and Jacobian.
    Hand(Instance),
    /// Checks and times all cases of a folder, and writes the table.
    Table(TableArguments),
}

#[derive(Args)]
struct Instance {
    /// The data.
    file: PathBuf,
    /// Where the answer goes, as JSON.
    #[arg(long)]
    out: PathBuf,
    /// The folder of the hand's model, which the other problems have no use for [default: `model`
    /// beside the file].
    #[arg(long)]
    model: Option<PathBuf>,
}

#[derive(Args)]
struct TableArguments {
    /// The folder of cases: `data` and `reference`.
    #[arg(long, env = "ADBENCH_DIR", default_value = "tests/data/adbench")]
    cases: PathBuf,
    /// Where the page goes.
    #[arg(long, default_value = "docs/adbench.md")]
    out: PathBuf,
    /// The least seconds of a sample.
    #[arg(long, default_value_t = 0.5)]
    least: f64,
    /// The seconds after which no sample is begun.
    #[arg(long, default_value_t = 10.0)]
    limit: f64,
}

fn main() -> ExitCode {
    let result = match Cli::parse().command {
        Command::Gmm(instance) => answer(Kind::Gmm, &instance),
        Command::Ba(instance) => answer(Kind::Ba, &instance),
        Command::Lstm(instance) => answer(Kind::Lstm, &instance),
        Command::Hand(instance) => answer(Kind::Hand, &instance),
        Command::Table(options) => write_table(&options),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("adbench: {error}");
            ExitCode::FAILURE
        }
    }
}

type Outcome = Result<(), Box<dyn std::error::Error>>;

fn answer(kind: Kind, instance: &Instance) -> Outcome {
    let mut problem = open(kind, &instance.file, instance.model.as_deref())?;
    problem.derivative();
    problem.objective();
    write(&instance.out, &problem.answer().to_string())
}

fn write_table(options: &TableArguments) -> Outcome {
    let seconds = |value: f64, name: &str| {
        Duration::try_from_secs_f64(value).map_err(|error| format!("--{name}: {error}"))
    };
    let effort = Effort {
        least: seconds(options.least, "least")?,
        limit: seconds(options.limit, "limit")?,
    };
    let page = table::page(&cases(&options.cases)?, effort)?;
    print!("{page}");
    write(&options.out, &page)
}

fn write(path: &Path, text: &str) -> Outcome {
    std::fs::write(path, text)
        .map_err(|error| format!("cannot write {}: {error}", path.display()))?;
    Ok(())
}
