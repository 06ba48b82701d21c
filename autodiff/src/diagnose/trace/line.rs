//! The line of the operation that is replayed, for code that replays recordings.

use std::cell::RefCell;
use std::panic::Location;

use crate::restored::Restored;

/// A line of source code; `None` if it is unknown.
pub type Line = Option<&'static Location<'static>>;

thread_local! {
    static LINE: RefCell<Line> = const { RefCell::new(None) };
}

/// Returns the line of the recorded operation that is replayed on this thread, or `None` outside of replays.
pub(super) fn line() -> Line {
    LINE.with_borrow(|line| *line)
}

/// Call this before an operation is replayed.
#[inline]
pub fn begin_line(line: Line) {
    LINE.set(line);
}

/// Call this at the start of a replay. When the result is dropped, there is no line.
pub fn replaying() -> Restored<Line> {
    Restored::set(&LINE, None)
}
