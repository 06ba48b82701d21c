//! GradBench's tool: answers the lines of its protocol on standard input. With `compare` it is set beside
//! another tool.

use std::io::{self, BufReader, BufWriter};
use std::path::PathBuf;
use std::process::ExitCode;

use benches::gradbench::compare::Comparison;
use benches::gradbench::protocol::serve;
use clap::{Args, Parser, Subcommand};

/// Differentiates what GradBench asks for, on standard input and output.
#[derive(Parser)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// Runs this tool and another one in turns, and writes a table.
    Compare(CompareArguments),
}

#[derive(Args)]
struct CompareArguments {
    /// The other tool's command, its words separated by spaces.
    #[arg(long)]
    peer: String,
    /// GradBench's checkout.
    #[arg(long)]
    checkout: PathBuf,
    /// Only these evaluations.
    #[arg(long)]
    only: Vec<String>,
    /// How often either tool has its turn at a function.
    #[arg(long, default_value_t = 3)]
    turns: usize,
    /// The least seconds of a turn.
    #[arg(long, default_value_t = 0.1)]
    seconds: f64,
    /// Where the page goes.
    #[arg(long, default_value = "docs/gradbench.md")]
    out: PathBuf,
}

fn main() -> ExitCode {
    let outcome = match Cli::parse().command {
        Some(Command::Compare(arguments)) => compare(arguments),
        None => tool(),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("gradbench: {error}");
            ExitCode::FAILURE
        }
    }
}

type Outcome = Result<(), Box<dyn std::error::Error>>;

fn tool() -> Outcome {
    /// Lines are long: whole models in one.
    const BUFFER: usize = 1 << 20;
    let lines = BufReader::with_capacity(BUFFER, io::stdin().lock());
    let replies = BufWriter::with_capacity(BUFFER, io::stdout().lock());
    Ok(serve(lines, replies)?)
}

fn compare(arguments: CompareArguments) -> Outcome {
    let comparison = Comparison {
        peer: arguments.peer,
        checkout: arguments.checkout,
        evaluations: arguments.only,
        turns: arguments.turns,
        seconds: arguments.seconds,
    };
    let page = comparison.page()?;
    print!("{page}");
    std::fs::write(arguments.out, page)?;
    Ok(())
}
