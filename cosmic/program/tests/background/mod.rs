//! Runs the program in the background and sends it signals.

use crate::common::Bench;
use crate::program::command;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

impl Bench {
    /// Starts the program in the test folder and returns the process.
    pub(crate) fn start(&self, line: &str) -> Child {
        let mut command = command(line);
        command.stderr(Stdio::piped()).stdout(Stdio::piped());
        command.current_dir(self.path("")).spawn().unwrap()
    }

    /// Waits until a file has at least `wanted` lines.
    pub(crate) fn await_lines(&self, name: &str, wanted: usize) {
        let began = Instant::now();
        while !self.path(name).exists() || self.lines(name) < wanted {
            // Even a slow machine needs less time than this.
            assert!(began.elapsed() < Duration::from_secs(300), "no {name}");
            thread::sleep(Duration::from_millis(1));
        }
    }
}

/// Sends a signal to a process.
pub(crate) fn signal(child: &Child, name: &str) {
    let id = child.id().to_string();
    let sent = Command::new("kill").args(["-s", name, &id]).status();
    assert!(sent.unwrap().success());
}
