//! What an optimiser refuses, and the checks that all of them share.

/// Why an update was refused. The state is then as it was before.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OptimiserError {
    /// A slice has another length than the optimiser was made for.
    #[error("{what}: {found} entries where {expected} are expected")]
    Length {
        /// Which slice.
        what: &'static str,
        /// The length that fits.
        expected: usize,
        /// The length that came.
        found: usize,
    },
    /// An entry is infinite or NaN.
    #[error("{what}: entry {index} is {value}, not a finite number")]
    NotFinite {
        /// Which slice.
        what: &'static str,
        /// Where in it.
        index: usize,
        /// What stands there.
        value: f64,
    },
    /// A setting lies outside the range in which the method works.
    #[error("{name} is {value}, but must be {allowed}")]
    Setting {
        /// The setting.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The range, in words.
        allowed: &'static str,
    },
    /// A lower bound lies above its upper bound.
    #[error("variable {index}: the lower bound {lower} lies above the upper bound {upper}")]
    Bounds {
        /// The variable.
        index: usize,
        /// Its lower bound.
        lower: f64,
        /// Its upper bound.
        upper: f64,
    },
    /// Every number that came in is finite, but not what is computed from them.
    #[error("values or derivatives are so large that the update overflows")]
    Overflow,
    /// The point to move from violates the bounds.
    #[error("variable {index} is {value}, outside its bounds {lower} to {upper}")]
    OutsideBounds {
        /// The variable.
        index: usize,
        /// Its value.
        value: f64,
        /// Its lower bound.
        lower: f64,
        /// Its upper bound.
        upper: f64,
    },
}

/// Refuses a slice whose length is not `expected`.
pub(super) fn check_length(
    what: &'static str,
    slice: &[f64],
    expected: usize,
) -> Result<(), OptimiserError> {
    let found = slice.len();
    if found == expected {
        return Ok(());
    }
    Err(OptimiserError::Length {
        what,
        expected,
        found,
    })
}

/// Refuses a slice with an entry that is infinite or NaN.
pub(super) fn check_finite(what: &'static str, slice: &[f64]) -> Result<(), OptimiserError> {
    match slice.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(index) => Err(OptimiserError::NotFinite {
            what,
            index,
            value: slice[index],
        }),
    }
}

/// Refuses a slice of another length, or with an entry that is infinite or NaN.
pub(super) fn check(
    what: &'static str,
    slice: &[f64],
    expected: usize,
) -> Result<(), OptimiserError> {
    check_length(what, slice, expected)?;
    check_finite(what, slice)
}

/// Refuses a setting outside its range.
pub(super) fn check_setting(
    name: &'static str,
    value: f64,
    holds: bool,
    allowed: &'static str,
) -> Result<(), OptimiserError> {
    if holds {
        return Ok(());
    }
    Err(OptimiserError::Setting {
        name,
        value,
        allowed,
    })
}
