//! `cosmic completions`.

use crate::output::print;
use clap::{Args, Command};
use clap_complete::Shell;
use cosmic::error::Result;

/// Print a script that completes this program's commands
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The shell to write for
    shell: Shell,
}

impl Arguments {
    pub(super) fn run(&self, mut program: Command) -> Result<()> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut program, "cosmic", &mut script);
        print(&String::from_utf8_lossy(&script))
    }
}
