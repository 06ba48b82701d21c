//! Tests of the program from the outside, in one binary with a module for each command or topic.
//!
//! `cargo test -p cosmic-program --test all cli_report::` runs one module.

#[cfg(unix)]
mod background;
mod common;
#[cfg(target_os = "linux")] // the commands on the pages are those of a Linux system
mod pages;
mod program;

mod cli_at_work;
mod cli_browser;
mod cli_evaluate;
mod cli_files;
mod cli_frames;
mod cli_interrupted;
mod cli_mujoco;
mod cli_no_locks;
mod cli_own;
mod cli_registers;
mod cli_report;
mod cli_sweep;
mod cli_two;
mod cli_walk;
mod cli_workshop;
