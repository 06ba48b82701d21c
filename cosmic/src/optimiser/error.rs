//! Errors of optimisers, and the checks that all optimisers share.

/// Why an update was refused. The state is then as it was before.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OptimiserError {
    /// A slice of another length than the optimiser was made for, an entry that is infinite, NaN or
    /// outside its bounds, bounds that cross, or a setting outside the range in which the method
    /// works; in a sentence, with the numbers.
    #[error("{0}")]
    Input(String),
    /// Every number that came in is finite, but not what is computed from them.
    #[error("values or derivatives are so large that the update overflows")]
    Overflow,
}

/// Refuses input unless it `holds`.
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
        format!("{what}: {found} entries where {expected} are expected")
    })
}

/// Refuses a slice with an entry that is infinite or NaN.
pub(super) fn check_finite(what: &str, slice: &[f64]) -> Result<(), OptimiserError> {
    for (index, value) in slice.iter().enumerate() {
        require(value.is_finite(), || {
            format!("{what}: entry {index} is {value}, not a finite number")
        })?;
    }
    Ok(())
}

/// Refuses a slice of another length, or with an entry that is infinite or NaN.
pub(super) fn check(what: &str, slice: &[f64], expected: usize) -> Result<(), OptimiserError> {
    check_length(what, slice, expected)?;
    check_finite(what, slice)
}
