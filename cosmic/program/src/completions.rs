//! `cosmic completions`.

use crate::Cli;
use clap::{Args, CommandFactory};
use clap_complete::Shell;
use cosmic::error::Result;

/// Print a script that completes this program's commands
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The shell to write for
    shell: Shell,
}

impl Arguments {
    pub(super) fn run(&self) -> Result<()> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut Cli::command(), "cosmic", &mut script);
        crate::print(&String::from_utf8_lossy(&script))
    }
}
