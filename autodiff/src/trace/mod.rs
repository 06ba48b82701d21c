//! Where did the NaN come from? [`Traced`] numbers know.
//!
//! Run the function that returns NaN, or whose gradient does, once more on traced numbers:
//! [`first_non_finite`] names the operation that first produced what reaches the result, with its
//! operands and its line. An infinity that a [`select`](crate::Real::select) leaves aside is not
//! blamed. Other modes pay nothing for this.
//!
//! Where the function itself takes a derivative, by [`gradient_of`](crate::gradient_of) say, the line
//! found is in this crate: trace the inner function alone.

mod traced;

use std::cell::RefCell;
use std::fmt;
use std::panic::Location;

use crate::real::{Mask, Real};

pub use traced::Traced;

/// The origin of a value or partial that is infinite or NaN.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct NonFinite {
    /// What was computed.
    pub operation: &'static str,
    /// Its number among all operations, from 1 on; 0 for an argument of the function.
    pub number: usize,
    /// The step of a [`Rollout`](crate::Rollout), where one was running.
    pub step: Option<usize>,
    /// The line of the operation; for an argument, of the call to [`first_non_finite`].
    pub place: &'static Location<'static>,
    /// Operands, value and partials, as text.
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

/// The trace that runs on this thread.
#[derive(Default)]
struct Trace {
    operations: usize,
    step: Option<usize>,
    found: Vec<NonFinite>,
}

thread_local! {
    static RUNNING: RefCell<Option<Trace>> = const { RefCell::new(None) };
}

/// Puts the outer trace back, also when the function panics.
struct Outer(Option<Trace>);

impl Drop for Outer {
    fn drop(&mut self) {
        RUNNING.replace(self.0.take());
    }
}

/// A place in `Trace::found`.
type Origin = u32;

/// The origin of numbers with nothing to blame. The largest, so that the minimum of several origins is
/// the first operation to blame.
const CLEAN: Origin = Origin::MAX;

/// The step that a rollout is at.
fn step() -> Option<usize> {
    RUNNING.with_borrow(|trace| trace.as_ref()?.step)
}

fn set_step(step: Option<usize>) {
    RUNNING.with_borrow_mut(|trace| {
        if let Some(trace) = trace {
            trace.step = step;
        }
    });
}

/// Counts an operation.
fn count() {
    RUNNING.with_borrow_mut(|trace| {
        if let Some(trace) = trace {
            trace.operations += 1;
        }
    });
}

/// Notes an origin; outside of a trace, nothing.
fn note(operation: &'static str, place: &'static Location<'static>, numbers: String) -> Origin {
    RUNNING.with_borrow_mut(|trace| {
        let Some(trace) = trace else { return CLEAN };
        trace.found.push(NonFinite {
            operation,
            number: trace.operations,
            step: trace.step,
            place,
            numbers,
        });
        trace.found.len() as Origin - 1
    })
}

/// The first operation whose value or partial is infinite or NaN and reaches a result of
/// `function` at `x`, or the first argument that is so itself.
///
/// A partial is blamed even if it is multiplied by zero later: whether the gradient survives that
/// depends on the mode, see the table in [`real`](crate::real).
///
/// ```
/// use autodiff::Real;
/// use autodiff::trace::first_non_finite;
///
/// fn distance<R: Real>(x: &[R]) -> R {
///     let squared = R::dot(x, x);
///     squared.sqrt()
/// }
///
/// assert_eq!(first_non_finite(&[3.0, 4.0], |x| vec![distance(x)]), None);
/// let found = first_non_finite(&[0.0, 0.0], |x| vec![distance(x)]).expect("a kink at 0");
/// assert_eq!((found.operation, found.number), ("sqrt", 3));
/// assert_eq!(found.numbers, "of 0.0: value 0.0, partial inf");
/// ```
#[track_caller]
pub fn first_non_finite<R: Real>(
    x: &[R],
    function: impl FnOnce(&[Traced<R>]) -> Vec<Traced<R>>,
) -> Option<NonFinite> {
    let place = Location::caller();
    let _outer = Outer(RUNNING.replace(Some(Trace::default())));
    let argument = |(i, &value): (usize, &R)| {
        let origin = if value.finite().all() {
            CLEAN
        } else {
            note("argument", place, format!("x[{i}] is {value:?}"))
        };
        Traced::variable(value, origin)
    };
    let arguments: Vec<_> = x.iter().enumerate().map(argument).collect();
    let results = function(&arguments);
    let origin = results.iter().map(|y| y.origin).min()?;
    let trace = RUNNING.take()?;
    trace.found.into_iter().nth(origin as usize)
}
