//! Instructions of a piece of work, counted by valgrind's callgrind: what a busy machine cannot
//! disturb. Nothing is linked in and nothing but valgrind is needed: a program runs itself twice,
//! with one repetition and with some more, and what they differ by is the work alone, without
//! start, setup and first use of memory.

use std::io;
use std::process::Command;

/// Why nothing was counted.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CountError {
    /// Valgrind or the program cannot be started.
    #[error("cannot run {program}: {source}")]
    Start {
        /// The program.
        program: String,
        /// The system's error.
        source: io::Error,
    },
    /// It ran, and went wrong.
    #[error("valgrind stopped with {status}: {said}")]
    Failed {
        /// How it ended.
        status: String,
        /// The end of its messages.
        said: String,
    },
    /// Valgrind's messages hold no count.
    #[error("valgrind named no number of instructions; its last messages: {said}")]
    NoCount {
        /// The end of its messages.
        said: String,
    },
}

/// The version of valgrind, if it is installed.
pub fn version() -> Option<String> {
    let output = Command::new("valgrind").arg("--version").output().ok()?;
    let said = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| said.trim().to_owned())
}

/// Instructions of one of `repeats` repetitions of what this program does when it is called with
/// `arguments` and then a number of repetitions.
///
/// # Errors
/// If valgrind cannot be run, the program fails, or valgrind says no count.
pub fn instructions(arguments: &[&str], repeats: u64) -> Result<f64, CountError> {
    let once = total(arguments, 1)?;
    let more = total(arguments, 1 + repeats)?;
    Ok((more as f64 - once as f64) / repeats as f64)
}

fn total(arguments: &[&str], repeats: u64) -> Result<u64, CountError> {
    let start = |program: &str| {
        let program = program.to_owned();
        move |source| CountError::Start { program, source }
    };
    let program = std::env::current_exe().map_err(start("this program"))?;
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(program)
        .args(arguments)
        .arg(repeats.to_string())
        .output()
        .map_err(start("valgrind"))?;
    let said = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        return Err(CountError::Failed {
            status: output.status.to_string(),
            said: end(&said),
        });
    }
    collected(&said).ok_or_else(|| CountError::NoCount { said: end(&said) })
}

/// The count in callgrind's summary: `==PID== Collected : 123`.
fn collected(said: &str) -> Option<u64> {
    said.lines().rev().find_map(|line| {
        let (_, count) = line.split_once("Collected : ")?;
        count.trim().parse().ok()
    })
}

/// The last few lines.
fn end(said: &str) -> String {
    let lines: Vec<&str> = said.lines().collect();
    lines[lines.len().saturating_sub(5)..].join("; ")
}

#[cfg(test)]
mod tests {
    use super::{collected, end};

    #[test]
    fn the_count_is_the_summarys() {
        let said =
            "==7== Events    : Ir\n==7== Collected : 290837\n==7== \n==7== I   refs: 290,837";
        assert_eq!(collected(said), Some(290_837));
        assert_eq!(collected("==7== Collected : many"), None);
        assert_eq!(collected("valgrind: no such file"), None);
    }

    #[test]
    fn messages_are_cut_to_their_end() {
        assert_eq!(end("1\n2\n3\n4\n5\n6\n7"), "3; 4; 5; 6; 7");
        assert_eq!(end("alone"), "alone");
    }
}
