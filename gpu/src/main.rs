//! The program `cosmic-gpu`: lists the devices, and measures how fast they simulate a population.

mod bench;

use std::error::Error;

use clap::{Parser, Subcommand};

/// Populations of robots on a GPU
#[derive(Parser)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// List the adapters of this machine, the one that is taken first
    Devices,
    /// Measure robot-steps per second against the number of robots, beside the processor
    Bench(bench::Settings),
}

fn main() -> Result<(), Box<dyn Error>> {
    match Arguments::parse().command {
        Command::Devices => {
            let adapters = cosmic_gpu::adapters();
            if adapters.is_empty() {
                println!("no adapter of Vulkan, Metal or DirectX 12 was found");
            }
            for adapter in adapters {
                println!(
                    "{} ({:?}, {:?}, {})",
                    adapter.name, adapter.device_type, adapter.backend, adapter.driver_info
                );
            }
            Ok(())
        }
        Command::Bench(settings) => bench::run(&settings),
    }
}
