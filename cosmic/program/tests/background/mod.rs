//! Running the program in the background.

use crate::common::Bench;
use std::process::{Child, Command, Stdio};

/// The program at work in the folder of a test.
pub(crate) fn start(bench: &Bench, arguments: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_cosmic"))
        .args(arguments)
        .current_dir(bench.path(""))
        .stderr(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap()
}
