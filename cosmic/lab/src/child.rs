//! Child processes whose output is read while they run.

use std::io::Read;
use std::process::{Child, Command, Stdio};
use std::thread::{JoinHandle, sleep, spawn};
use std::time::Duration;

/// How often a running child is checked.
const PAUSE: Duration = Duration::from_millis(20);

/// Runs a command to its end and returns its standard output. Returns `None` if the command was stopped because
/// `is_stopped` returned true.
///
/// # Errors
/// The reason why the command cannot be started, or the last line of its standard error if it fails.
pub(crate) fn output(
    command: &mut Command,
    is_stopped: &dyn Fn() -> bool,
) -> Result<Option<Vec<u8>>, String> {
    let said = |error: std::io::Error| error.to_string();
    let piped = command.stdin(Stdio::null()).stdout(Stdio::piped());
    let mut child = piped.stderr(Stdio::piped()).spawn().map_err(said)?;
    let printing = Printing::of(&mut child);
    let status = loop {
        if let Some(status) = child.try_wait().map_err(said)? {
            break status;
        }
        if is_stopped() {
            // The child may have ended by itself in the meantime.
            let _ = child.kill();
            let _ = child.wait();
            return Ok(None);
        }
        sleep(PAUSE);
    };
    let printed = printing.end();
    match status.success() {
        true => Ok(Some(printed.out)),
        // An interrupt from the keyboard reaches the child as well.
        false if is_stopped() => Ok(None),
        false => Err(printed.reason()),
    }
}

/// The output of a running child process. A pipe holds only some tens of kilobytes. A child that prints more
/// blocks until the pipe is read, so the pipes must be read before the child ends.
pub(crate) struct Printing {
    out: Reader,
    error: Reader,
}

/// A thread that reads a pipe to its end.
type Reader = Option<JoinHandle<Vec<u8>>>;

/// All that a child process printed.
pub(crate) struct Printed {
    pub(crate) out: Vec<u8>,
    error: Vec<u8>,
}

impl Printing {
    /// Starts reading the output pipes of `child`.
    pub(crate) fn of(child: &mut Child) -> Self {
        Self {
            out: child.stdout.take().map(reader),
            error: child.stderr.take().map(reader),
        }
    }

    /// Waits until both pipes are closed.
    pub(crate) fn end(self) -> Printed {
        let read = |reader: Reader| reader.and_then(|reader| reader.join().ok());
        Printed {
            out: read(self.out).unwrap_or_default(),
            error: read(self.error).unwrap_or_default(),
        }
    }
}

fn reader(mut pipe: impl Read + Send + 'static) -> JoinHandle<Vec<u8>> {
    spawn(move || {
        let mut bytes = Vec::new();
        // On an error, the bytes that were read so far are still useful.
        let _ = pipe.read_to_end(&mut bytes);
        bytes
    })
}

impl Printed {
    /// The last line on standard error, which usually gives the reason for a failure.
    pub(crate) fn reason(&self) -> String {
        let text = String::from_utf8_lossy(&self.error);
        let last = text.lines().rev().find(|line| !line.trim().is_empty());
        last.unwrap_or("it failed without a message").to_owned()
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::output;
    use std::cell::Cell;
    use std::process::Command;
    use std::time::{Duration, Instant};

    fn shell(program: &str, is_stopped: &dyn Fn() -> bool) -> Result<Option<Vec<u8>>, String> {
        output(Command::new("bash").args(["-c", program]), is_stopped)
    }

    /// Stops a program that still runs after a minute, so that the test fails instead of hanging.
    fn patience() -> impl Fn() -> bool {
        let began = Instant::now();
        move || began.elapsed() > Duration::from_secs(60)
    }

    #[test]
    fn a_program_may_print_more_than_pipes_hold() {
        let much = "head -c 3000000 /dev/zero | tr '\\0' x";
        let both = format!("{much} >&2; {much}; {much} >&2");
        let out = shell(&both, &patience()).unwrap().expect("it ends");
        assert_eq!(out, vec![b'x'; 3_000_000]);
        let fails = format!("{much}; {much} >&2; echo; echo reason >&2; exit 1");
        let error = shell(&fails, &patience()).unwrap_err();
        assert!(error.ends_with("reason"), "a long message");
    }

    #[test]
    fn a_program_is_stopped_while_it_prints() {
        let looks = Cell::new(0);
        let is_stopped = || {
            looks.set(looks.get() + 1);
            looks.get() > 3
        };
        assert_eq!(shell("while true; do echo x; done", &is_stopped), Ok(None));
        // A grandchild process may keep the pipes open.
        looks.set(0);
        assert_eq!(shell("sleep 5 & wait", &is_stopped), Ok(None));
    }
}
