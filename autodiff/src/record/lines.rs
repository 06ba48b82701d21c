//! The line of the operation that is replayed, so that [`trace`](crate::trace) can report it.

use std::cell::RefCell;
use std::panic::Location;

use crate::restored::Restored;

/// A line of source code; `None` if it is unknown.
pub(crate) type Line = Option<&'static Location<'static>>;

thread_local! {
    static LINE: RefCell<Line> = const { RefCell::new(None) };
}

/// Returns the line of the recorded operation that is replayed on this thread, or `None` outside of replays.
pub(crate) fn line() -> Line {
    LINE.with_borrow(|line| *line)
}

/// Call this before an operation is replayed.
pub(super) fn begin_line(line: Line) {
    LINE.set(line);
}

/// Call this at the start of a replay. When the result is dropped, there is no line.
pub(super) fn replaying() -> Restored<Line> {
    Restored::set(&LINE, None)
}
