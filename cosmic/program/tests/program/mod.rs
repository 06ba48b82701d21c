//! Running the program as a user does.

use assert_cmd::Command;
use std::path::Path;

/// What the program said.
#[derive(Debug)]
pub(crate) struct Told {
    /// Standard output.
    pub(crate) out: String,
    /// Standard error.
    pub(crate) error: String,
    /// The exit code.
    pub(crate) code: i32,
}

/// Runs `cosmic` with those arguments in that folder.
pub(crate) fn cosmic_in(folder: &Path, arguments: &[&str]) -> Told {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cosmic"));
    let output = command
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    Told {
        out: text(output.stdout),
        error: text(output.stderr),
        code: output.status.code().unwrap(),
    }
}
