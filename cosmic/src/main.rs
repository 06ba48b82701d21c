//! The program `cosmic`; all of it lives in [`cosmic::cli`].

use std::process::ExitCode;

fn main() -> ExitCode {
    cosmic::cli::run()
}
