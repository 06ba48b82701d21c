//! Counts the instructions of a piece of work with valgrind's callgrind. Other load on the machine does not change the
//! count. A program runs itself twice, with one repetition and with more. The difference of the two counts contains
//! only the work itself, without the start of the program, the setup and the first use of memory.

use std::process::Command;

/// Returns the version of valgrind, or `None` if it is not installed.
pub(crate) fn version() -> Option<String> {
    let output = Command::new("valgrind").arg("--version").output().ok()?;
    let version = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| version.trim().to_owned())
}

/// Returns the number of instructions of one repetition. Calls the program with `arguments`, followed by the number of
/// repetitions.
///
/// # Errors
/// If valgrind or the program fails, or valgrind prints no count.
pub(crate) fn instructions(arguments: &[&str], repeats: u64) -> Result<f64, String> {
    let once = total(arguments, 1)?;
    let more = total(arguments, 1 + repeats)?;
    Ok((more - once) / repeats as f64)
}

fn total(arguments: &[&str], repeats: u64) -> Result<f64, String> {
    let program = std::env::current_exe().map_err(|error| error.to_string())?;
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(program)
        .args(arguments)
        .arg(repeats.to_string())
        .output()
        .map_err(|error| format!("cannot run valgrind: {error}"))?;
    let messages = String::from_utf8_lossy(&output.stderr);
    // The summary is `==PID== Collected : 123`.
    let count = messages.rsplit_once("Collected : ").map(|(_, rest)| rest);
    let count = count.and_then(|rest| rest.lines().next()?.trim().parse().ok());
    let failed = || {
        format!(
            "valgrind printed no count of instructions ({}): {messages}",
            output.status
        )
    };
    count.filter(|_| output.status.success()).ok_or_else(failed)
}
