//! The errors of the optimisers, and the checks that the optimisers share.

/// Why an optimiser or an update was refused. A refused update does not change the state.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OptimiserError {
    /// An input is invalid; the message says which one and why. Examples are a slice of the wrong length, an entry that
    /// is infinite, NaN or out of bounds, a lower bound above the upper bound, and a setting outside its range.
    #[error("{0}")]
    Input(String),
    /// The input is finite, but a number that was computed from it is not.
    #[error(
        "values or derivatives are finite, but so large that the update overflows; scale them down"
    )]
    Overflow,
}

/// Returns an error unless the condition `holds`.
pub(super) fn require(holds: bool, message: impl FnOnce() -> String) -> Result<(), OptimiserError> {
    if holds {
        Ok(())
    } else {
        Err(OptimiserError::Input(message()))
    }
}

/// Refuses a list whose length is not `expected`.
pub(super) fn check_length<T>(
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
pub(super) fn check_finite(what: &str, slice: &[f64]) -> Result<(), OptimiserError> {
    for (index, value) in slice.iter().enumerate() {
        require(value.is_finite(), || {
            format!("{what}: entry {index} is {value}; it must be finite")
        })?;
    }
    Ok(())
}

/// Refuses a slice whose length is not `expected`, and a slice with an entry that is infinite or NaN.
pub(super) fn check(what: &str, slice: &[f64], expected: usize) -> Result<(), OptimiserError> {
    check_length(what, slice, expected)?;
    check_finite(what, slice)
}
