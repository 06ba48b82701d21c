//! The program `cosmic`; all of it lives in the library `cosmic_program`.

use std::process::ExitCode;

fn main() -> ExitCode {
    cosmic_program::Program::new().run()
}
