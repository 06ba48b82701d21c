//! The state of a running trace: a count of the operations, and the origins of infinities and NaN that were found.

use std::cell::RefCell;
use std::fmt;
use std::panic::Location;

use super::line::line;
use super::step::step;

/// Where an infinity or NaN comes from: the operation whose value or partial is infinite or NaN.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct NonFinite {
    /// The name of the operation.
    pub operation: &'static str,
    /// The number of the operation, counted from 1; 0 for an argument of the function.
    pub number: usize,
    /// The step in which the operation ran, if it ran in a `Rollout` of `autodiff_programs`.
    pub step: Option<usize>,
    /// The line of the operation in the source code. For an argument, the line of the call to
    /// [`first_non_finite`](super::first_non_finite).
    pub place: &'static Location<'static>,
    /// The operands, the value and the partials of the operation, as text.
    pub numbers: String,
}

impl fmt::Display for NonFinite {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (number, operation, place) = (self.number, self.operation, self.place);
        write!(formatter, "operation {number}, {operation}, at {place}")?;
        if let Some(step) = self.step {
            write!(formatter, ", in step {step}")?;
        }
        write!(formatter, ": {}", self.numbers)
    }
}

/// The trace that is running on this thread, if any.
#[derive(Default)]
pub(super) struct Trace {
    operations: usize,
    pub(super) found: Vec<NonFinite>,
}

thread_local! {
    pub(super) static RUNNING: RefCell<Option<Trace>> = const { RefCell::new(None) };
}

/// The origin of a number, as an index into `Trace::found`.
pub(super) type Origin = u32;

/// The origin of a number to which no infinity or NaN contributed. It is the largest index, so that the minimum over
/// several numbers is the index of the first operation to report.
pub(super) const CLEAN: Origin = Origin::MAX;

/// Counts one more operation of the running trace.
pub(super) fn count() {
    RUNNING.with_borrow_mut(|trace| {
        if let Some(trace) = trace {
            trace.operations += 1;
        }
    });
}

/// Records an origin of an infinity or NaN. Does nothing outside a trace. The place of a recorded operation is the line
/// that was recorded.
pub(super) fn note(
    operation: &'static str,
    place: &'static Location<'static>,
    numbers: String,
) -> Origin {
    RUNNING.with_borrow_mut(|trace| {
        let Some(trace) = trace else { return CLEAN };
        trace.found.push(NonFinite {
            operation,
            number: trace.operations,
            step: step(),
            place: line().unwrap_or(place),
            numbers,
        });
        trace.found.len() as Origin - 1
    })
}

/// How many origins the running trace has found.
pub(super) fn noted() -> usize {
    RUNNING.with_borrow(|trace| trace.as_ref().map_or(0, |trace| trace.found.len()))
}

/// Gives the place of the caller to the origins from number `first` on whose place is in this crate, or in the folder of
/// a fused function's crate, unless that is empty.
pub(super) fn name_callers(first: usize, caller: &'static Location<'static>, folder: &str) {
    // The folder of this crate's source files, as the compiler writes it.
    let own = &file!()[..file!().len() - "diagnose/trace/origin.rs".len()];
    let is_inside = |place: &Location| {
        let file = place.file();
        file.starts_with(own) || !folder.is_empty() && file.starts_with(folder)
    };
    RUNNING.with_borrow_mut(|trace| {
        let found = trace.iter_mut().flat_map(|trace| &mut trace.found[first..]);
        for origin in found.filter(|origin| is_inside(origin.place)) {
            origin.place = caller;
        }
    });
}
