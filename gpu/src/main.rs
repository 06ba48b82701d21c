//! The program `cosmic-gpu`: lists the GPUs of this computer, and measures how fast they simulate a population.

mod bench;

use std::error::Error;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use cosmic_gpu::{Adapter, adapters};

/// Simulate populations of robots on a GPU
#[derive(Parser)]
#[command(name = "cosmic-gpu", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// List the GPUs of this computer, the one that is taken first
    Devices,
    /// Measure robot-steps per second on a GPU against the number of robots, beside the processor
    Bench(bench::Settings),
}

fn devices() {
    let found = adapters();
    if found.is_empty() {
        println!("no adapter of Vulkan, Metal or DirectX 12 was found");
    }
    for Adapter {
        name,
        device_type,
        backend,
        driver_info,
        ..
    } in found
    {
        println!("{name} ({device_type:?}, {backend:?}, {driver_info})");
    }
}

fn run(command: &Command) -> Result<(), Box<dyn Error>> {
    match command {
        Command::Devices => {
            devices();
            Ok(())
        }
        Command::Bench(settings) => bench::run(settings),
    }
}

fn main() -> ExitCode {
    match run(&Cli::parse().command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}
