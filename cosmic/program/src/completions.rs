//! `cosmic completions`.

use crate::output::print;
use clap::{Args, Command};
use clap_complete::Shell;
use cosmic::error::Result;

/// Print a completion script for a shell
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The shell
    shell: Shell,
}

impl Arguments {
    pub(super) fn run(&self, mut program: Command) -> Result<()> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut program, "cosmic", &mut script);
        print(&String::from_utf8_lossy(&script))
    }
}
