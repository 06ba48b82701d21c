//! The command line: one file a command, each a struct of arguments with a `run`.
//!
//! The order of the modules is the architecture: each uses only those above it.

mod arguments;
mod output;
mod interrupt;
mod progress;
mod runs;
mod source;
mod optimize;
mod resume;
mod evaluate;
mod gradcheck;
mod verify;
mod explain;
mod report;
mod compare;
mod robustness;
mod study;
mod sweep;
mod scene;
mod completions;

use clap::{CommandFactory, Parser, Subcommand};
use cosmic::error::Result;
use output::{complain, written};
use std::process::ExitCode;

/// Co-design of truss-lattice robots: structure, material and neural control optimised together.
#[derive(Debug, Parser)]
#[command(name = "cosmic", version, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Optimize(optimize::Arguments),
    Resume(resume::Arguments),
    Evaluate(evaluate::Arguments),
    Gradcheck(gradcheck::Arguments),
    Verify(verify::Arguments),
    Explain(explain::Arguments),
    Report(report::Arguments),
    Compare(compare::Arguments),
    Robustness(robustness::Arguments),
    Study(study::Arguments),
    Sweep(sweep::Arguments),
    Scene(scene::Arguments),
    Completions(completions::Arguments),
}

impl Command {
    fn run(&self) -> Result<()> {
        match self {
            Command::Optimize(arguments) => arguments.run(),
            Command::Resume(arguments) => arguments.run(),
            Command::Evaluate(arguments) => arguments.run(),
            Command::Gradcheck(arguments) => arguments.run(),
            Command::Verify(arguments) => arguments.run(),
            Command::Explain(arguments) => arguments.run(),
            Command::Report(arguments) => arguments.run(),
            Command::Compare(arguments) => arguments.run(),
            Command::Robustness(arguments) => arguments.run(),
            Command::Study(arguments) => arguments.run(),
            Command::Sweep(arguments) => arguments.run(),
            Command::Scene(arguments) => arguments.run(),
            Command::Completions(arguments) => arguments.run(Cli::command()),
        }
    }
}

/// Runs the command that the process was started with. The exit code is 0, or the error's own
/// ([`cosmic::Error::exit_code`]).
pub fn run() -> ExitCode {
    match Cli::try_parse() {
        Ok(cli) => exit_code(cli.command.run()),
        Err(request) => refuse(&request),
    }
}

/// Shows help or the version (exit 0), or the mistake in the arguments (exit 2).
fn refuse(request: &clap::Error) -> ExitCode {
    let shown = request.print();
    if request.use_stderr() {
        return ExitCode::from(2);
    }
    exit_code(written(shown))
}

/// The exit code of a result. Shows the error.
fn exit_code(done: Result<()>) -> ExitCode {
    let Err(error) = done else {
        return ExitCode::SUCCESS;
    };
    complain(&error);
    ExitCode::from(error.exit_code())
}

/// The README's code, compiled and run with the documentation's.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
