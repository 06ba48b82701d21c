//! The command line: one file a command, each a struct of arguments with a `run`.

mod compare;
mod completions;
mod evaluate;
mod explain;
mod gradcheck;
mod interrupt;
mod optimize;
mod options;
mod progress;
mod report;
mod resume;
mod robustness;
mod runs;
mod scene;
mod source;
mod study;
mod sweep;
mod verify;

pub use options::{Output, RunOptions};

use clap::{Parser, Subcommand};
use cosmic::error::{Error, Result, in_shell};
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;

/// Co-design of truss-lattice robots: structure, material and neural control optimised together.
#[derive(Debug, Parser)]
#[command(name = "cosmic", version, arg_required_else_help = true)]
pub struct Cli {
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
            Command::Completions(arguments) => arguments.run(),
        }
    }
}

/// Runs the command that the process was started with; the exit code is [`Error::exit_code`]'s, or
/// 0.
pub fn run() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(request) => return refuse(&request),
    };
    exit_code(cli.command.run())
}

/// Shows help or the version (exit 0), or what is wrong with the arguments (exit 2).
fn refuse(request: &clap::Error) -> ExitCode {
    let shown = request.print();
    if request.use_stderr() {
        return ExitCode::from(2);
    }
    exit_code(written(shown))
}

/// Complains of an error; 0 where there is none.
fn exit_code(done: Result<()>) -> ExitCode {
    done.map_or_else(
        |error| {
            complain(&error);
            ExitCode::from(error.exit_code())
        },
        |()| ExitCode::SUCCESS,
    )
}

/// Reports on faults of a file begin with "error:" on their own.
fn complain(error: &Error) {
    let text = error.to_string();
    let prefix = if text.starts_with("error:") {
        ""
    } else {
        "error: "
    };
    let _ = writeln!(io::stderr(), "{prefix}{text}");
}

/// Writes to standard output.
fn print(text: &str) -> Result<()> {
    let mut out = io::stdout().lock();
    written(out.write_all(text.as_bytes()).and_then(|()| out.flush()))
}

/// What became of a text for standard output. A reader that has seen enough (`cosmic scene default
/// | head`) is no error.
fn written(text: io::Result<()>) -> Result<()> {
    match text {
        Err(source) if source.kind() != io::ErrorKind::BrokenPipe => Err(Error::Write {
            path: "standard output".into(),
            source,
        }),
        _ => Ok(()),
    }
}

/// A line on standard error.
fn note(text: &str) {
    // Nobody is left to tell if the terminal is gone.
    let _ = writeln!(io::stderr(), "{text}");
}

/// A count of things whose plural ends in s.
fn counted(count: usize, thing: &str) -> String {
    match count {
        1 => format!("1 {thing}"),
        _ => format!("{count} {thing}s"),
    }
}

/// Where the last states of a rollout that diverged are kept, and what to do with them.
fn see_again(diverged: &Path) -> String {
    let (file, word) = (diverged.display(), in_shell(diverged));
    format!("the last states are in {file}; see it again with: cosmic evaluate {word}")
}

/// Paths as JSON has them: what is no Unicode in one is replaced, as on a line of text.
fn in_json<P: AsRef<Path>>(paths: &[P]) -> Vec<String> {
    let shown = |path: &P| path.as_ref().display().to_string();
    paths.iter().map(shown).collect()
}

/// Writes a value to standard output as indented JSON.
fn print_json(value: &impl serde::Serialize) -> Result<()> {
    let source = |error: serde_json::Error| Error::Write {
        path: "standard output".into(),
        source: error.into(),
    };
    let text = serde_json::to_string_pretty(value).map_err(source)?;
    print(&(text + "\n"))
}
