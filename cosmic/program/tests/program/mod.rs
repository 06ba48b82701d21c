//! Running the program as a user does.

use std::path::Path;
use std::process::Command;

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

/// `cosmic` with those arguments, not yet started.
pub(crate) fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cosmic"));
    command.args(arguments);
    command
}

/// Runs `cosmic` with those arguments in that folder.
pub(crate) fn cosmic_in(folder: &Path, arguments: &[&str]) -> Told {
    let output = command(arguments).current_dir(folder).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    Told {
        out: text(output.stdout),
        error: text(output.stderr),
        code: output.status.code().unwrap(),
    }
}

/// Standard output, standard error and exit code of `cosmic` with those arguments.
pub(crate) fn cosmic(arguments: &[&str]) -> (String, String, i32) {
    let told = cosmic_in(Path::new("."), arguments);
    (told.out, told.error, told.code)
}
