//! Tests of the program from the outside, in one binary with a module for each command or topic.
//!
//! `cargo test -p cosmic-program --test all cli_report::` runs one module.

#[cfg(unix)]
mod background;
mod common;
mod program;

mod cli_at_work;
mod cli_beyond;
mod cli_broken;
mod cli_browser;
mod cli_check;
mod cli_clock;
mod cli_diverged;
mod cli_evaluate;
mod cli_files;
mod cli_interrupted;
mod cli_kept;
mod cli_lattice;
mod cli_laws;
mod cli_misread;
mod cli_mujoco;
mod cli_optimize;
mod cli_own;
mod cli_refused;
mod cli_reliable;
mod cli_report;
mod cli_scene;
mod cli_set;
mod cli_sweep;
mod cli_two;
mod cli_walk;
mod cli_workshop;
