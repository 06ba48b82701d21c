//! The errors of the optimisers, and the checks that the optimisers share.

/// Why an optimiser or an update was refused, or why a run failed. A refused update does not change the state.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OptimiserError {
    /// An input is invalid; the message says which one and why. Examples are a slice of the wrong length, an entry that
    /// is infinite, NaN or out of bounds, a lower bound above the upper bound, and a setting outside its range.
    #[error("{0}")]
    Input(String),
    /// A function of the problem, or one of its derivatives, is infinite or NaN.
    #[error("{what} is {value} at x = {}; it must be finite", shortened(point))]
    NotFinite {
        /// The function or the derivative, for example `constraint 2` or `derivative of the objective by variable 0`.
        what: String,
        /// The value.
        value: f64,
        /// The point where the function was evaluated.
        point: Vec<f64>,
    },
    /// The input is finite, but a number that was computed from it is not.
    #[error(
        "values or derivatives are finite, but so large that the update overflows; scale them down"
    )]
    Overflow,
}

/// A point as text, without the middle of a long one.
fn shortened(point: &[f64]) -> String {
    match point {
        [first, second, .., last] if point.len() > 12 => {
            format!("[{first}, {second}, ... {last}] ({} entries)", point.len())
        }
        _ => format!("{point:?}"),
    }
}

/// Returns an error unless the condition `holds`.
pub(crate) fn require(holds: bool, message: impl FnOnce() -> String) -> Result<(), OptimiserError> {
    if holds {
        Ok(())
    } else {
        Err(OptimiserError::Input(message()))
    }
}

/// Refuses a list whose length is not `expected`.
pub(crate) fn check_length<T>(
    what: &str,
    list: &[T],
    expected: usize,
) -> Result<(), OptimiserError> {
    let found = list.len();
    require(found == expected, || {
        format!("{what}: expected {expected} entries, found {found}")
    })
}

/// Refuses a slice with an entry that is infinite or NaN.
pub(crate) fn check_finite(what: &str, slice: &[f64]) -> Result<(), OptimiserError> {
    for (index, value) in slice.iter().enumerate() {
        require(value.is_finite(), || {
            format!("{what}: entry {index} is {value}; it must be finite")
        })?;
    }
    Ok(())
}

/// Refuses a slice whose length is not `expected`, and a slice with an entry that is infinite or NaN.
pub(crate) fn check(what: &str, slice: &[f64], expected: usize) -> Result<(), OptimiserError> {
    check_length(what, slice, expected)?;
    check_finite(what, slice)
}
