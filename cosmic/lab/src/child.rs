//! Child processes whose output is read while they run.

use std::io::Read;
use std::process::Child;
use std::thread::{JoinHandle, spawn};

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
