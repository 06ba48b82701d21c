//! Child processes that can be stopped.

use std::fs::File;
use std::io::{self, Read, Seek};
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;
use tempfile::tempfile;

/// How long the program waits between two checks of a running child process.
const PAUSE: Duration = Duration::from_millis(20);

/// Runs a command to its end and returns its standard output; `None` if the command was stopped because
/// `is_stopped` returned true.
///
/// # Errors
/// Returns the reason why the command cannot be started, or the last line of its standard error if it fails.
pub fn output(
    command: &mut Command,
    is_stopped: &dyn Fn() -> bool,
) -> Result<Option<Vec<u8>>, String> {
    run(command, is_stopped).unwrap_or_else(|error| Err(error.to_string()))
}

fn run(
    command: &mut Command,
    is_stopped: &dyn Fn() -> bool,
) -> io::Result<Result<Option<Vec<u8>>, String>> {
    // Files instead of pipes: a child that fills a pipe would wait until somebody reads it.
    let (out, error) = (tempfile()?, tempfile()?);
    let command = command.stdin(Stdio::null()).stdout(out.try_clone()?);
    let mut child = command.stderr(error.try_clone()?).spawn()?;
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break status;
        }
        if is_stopped() {
            // The child may have ended by itself in the meantime.
            let _ = child.kill();
            let _ = child.wait();
            return Ok(Ok(None));
        }
        sleep(PAUSE);
    };
    Ok(match status.success() {
        true => Ok(Some(content(out)?)),
        // Ctrl-C also interrupts the child. So its failure counts as a stop, not as an error.
        false if is_stopped() => Ok(None),
        false => Err(reason(&content(error)?)),
    })
}

fn content(mut file: File) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    file.rewind()?;
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The last line of a failed child's standard error, which usually gives the reason.
pub(crate) fn reason(error: &[u8]) -> String {
    let text = String::from_utf8_lossy(error);
    let last = text.lines().rev().find(|line| !line.trim().is_empty());
    last.unwrap_or("it failed without a message").to_owned()
}
