//! Runs the program `cosmic` in the way a user does.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

/// The output and the exit code of the program.
#[derive(Debug)]
pub(crate) struct Told {
    /// Standard output of the program.
    pub(crate) out: String,
    /// Standard error.
    pub(crate) error: String,
    /// The exit code.
    pub(crate) code: i32,
}

impl Told {
    /// Takes the output of a finished process.
    pub(crate) fn of(output: Output) -> Self {
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        Self {
            out: text(output.stdout),
            error: text(output.stderr),
            code: output.status.code().unwrap(),
        }
    }

    /// Asserts that the command succeeded. Returns its output.
    #[track_caller]
    pub(crate) fn ok(self) -> Self {
        assert_eq!(self.code, 0, "{self:?}");
        self
    }

    /// Asserts that the command succeeded. Returns the JSON that it printed.
    #[track_caller]
    pub(crate) fn json(self) -> Value {
        serde_json::from_str(&self.ok().out).unwrap()
    }

    /// Asserts that the command failed with exit code `code`, and that its error contains all of `words`.
    #[track_caller]
    pub(crate) fn fails(&self, code: i32, words: &[&str]) {
        assert_eq!(self.code, code, "{self:?}");
        has(&self.error, words);
    }
}

/// Asserts that a text contains all words.
#[track_caller]
pub(crate) fn has(text: &str, words: &[&str]) {
    for word in words {
        assert!(text.contains(word), "no {word:?} in: {text}");
    }
}

/// The command `cosmic` with the arguments in `line`. It is not started yet.
pub(crate) fn command(line: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cosmic"));
    // The program is called by its name, and not by Cargo, which runs the tests.
    command.env_remove("CARGO_MANIFEST_DIR");
    #[cfg(unix)]
    std::os::unix::process::CommandExt::arg0(&mut command, "cosmic");
    command.args(line.split_whitespace());
    command
}

/// Runs `cosmic` in a folder with the arguments in `line`.
pub(crate) fn cosmic_in(folder: &Path, line: &str) -> Told {
    Told::of(command(line).current_dir(folder).output().unwrap())
}
