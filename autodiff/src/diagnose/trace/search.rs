//! The search for the operation where an infinity or NaN comes from.

use std::panic::Location;

use super::origin::{CLEAN, NonFinite, RUNNING, Trace, note};
use super::traced::Traced;
use crate::constant::printed;
use crate::real::{Mask, Real};
use crate::restored::Restored;

/// Returns the first operation whose value or partial is infinite or NaN and reaches a result of `function`
/// at `x`. If an argument itself is infinite or NaN, returns the first such argument.
///
/// The place is the line of your code that calls the operation. Inside functions of other crates, such as nalgebra's
/// `norm` or the standard library's `Iterator::sum`, it is a line of that crate.
///
/// A partial is reported even if it is multiplied by zero later. Whether the gradient survives that depends
/// on the mode; see the table in [`real`](crate::real).
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
/// assert_eq!(first_non_finite(|x| vec![distance(x)], &[3.0, 4.0]), None);
/// let found = first_non_finite(|x| vec![distance(x)], &[0.0, 0.0]).expect("a kink at 0");
/// assert_eq!((found.operation, found.number), ("sqrt", 3));
/// assert_eq!(found.numbers, "of 0.0: value 0.0, partial inf");
/// ```
#[track_caller]
pub fn first_non_finite<R: Real>(
    function: impl FnOnce(&[Traced<R>]) -> Vec<Traced<R>>,
    x: &[R],
) -> Option<NonFinite> {
    let place = Location::caller();
    let _outer = Restored::set(&RUNNING, Some(Trace::default()));
    let argument = |(i, &value): (usize, &R)| {
        let origin = if value.finite().all() {
            CLEAN
        } else {
            note("argument", place, format!("x[{i}] is {}", printed(value)))
        };
        Traced::variable(value, origin)
    };
    let arguments: Vec<_> = x.iter().enumerate().map(argument).collect();
    let results = function(&arguments);
    let origin = results.iter().map(|y| y.origin).min()?;
    let trace = RUNNING.take()?;
    trace.found.into_iter().nth(origin as usize)
}
