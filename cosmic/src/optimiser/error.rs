//! Errors of optimisers, and the checks that they share.

/// Why an update was refused. The state has not changed then.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OptimiserError {
    /// Invalid input, described in a sentence: a slice of the wrong length, an entry that is infinite, NaN or out of
    /// bounds, bounds that cross, or a setting outside the range of the method.
    #[error("{0}")]
    Input(String),
    /// The input is finite, but a computed number is not.
    #[error("values or derivatives are so large that the update overflows")]
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

/// Refuses a slice of another length, or with an entry that is infinite or NaN.
pub(super) fn check(what: &str, slice: &[f64], expected: usize) -> Result<(), OptimiserError> {
    check_length(what, slice, expected)?;
    check_finite(what, slice)
}
