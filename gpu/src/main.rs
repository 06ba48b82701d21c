//! The program `cosmic` with GPU support, and a command more: `bench` measures how fast a GPU simulates a population.

mod bench;
mod support;

use std::process::ExitCode;

use clap::Parser;

/// Measure robot-steps per second on a GPU against the number of robots, beside the processor
#[derive(Parser)]
#[command(name = "cosmic bench")]
struct Bench {
    #[command(flatten)]
    settings: bench::Settings,
}

fn main() -> ExitCode {
    let mut arguments = std::env::args_os();
    if arguments.nth(1).is_some_and(|command| command == "bench") {
        let arguments = std::env::args_os().skip(1);
        return match bench::run(&Bench::parse_from(arguments).settings) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                eprintln!("error: {error}");
                ExitCode::from(2)
            }
        };
    }
    cosmic_program::Program::new()
        .with_gpu(support::Support)
        .run()
}
