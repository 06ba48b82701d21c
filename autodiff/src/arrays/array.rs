//! Handles to arrays and matrices, and where their numbers lie.

use std::ops::Range;

/// A handle to an array of a [`Program`](crate::Program).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Array {
    pub(crate) id: usize,
    /// True for a parameter, false for an array in the row of each step.
    pub(crate) parameter: bool,
    /// Where it begins there.
    pub(crate) start: usize,
    /// How many numbers it takes there, over all starts.
    pub(crate) len: usize,
    pub(crate) starts: usize,
}

impl Array {
    /// How many numbers the array holds.
    pub fn len(self) -> usize {
        self.len / self.starts
    }

    /// True if the array holds no numbers, as one along the edges of a graph without edges.
    pub fn is_empty(self) -> bool {
        self.len == 0
    }

    /// Where it lies, among the parameters or in the row.
    #[inline(always)]
    pub(crate) fn range(self) -> Range<usize> {
        self.start..self.start + self.len
    }
}

/// A handle to a matrix parameter of a [`Program`](crate::Program).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Matrix {
    pub(crate) parameter: usize,
    pub(crate) rows: usize,
    pub(crate) columns: usize,
}

impl Matrix {
    /// How many numbers the matrix holds.
    pub(crate) fn len(self) -> usize {
        self.rows.checked_mul(self.columns).expect(TOO_LONG)
    }
}

/// The declared shape of a parameter.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Parameter {
    Array(Array),
    Matrix(Matrix),
    /// By its index among the controls.
    Control(usize),
}

/// The sum of places in a row. Unchecked reads rely on it: it must not wrap around.
pub(crate) fn checked_sum(a: usize, b: usize) -> usize {
    a.checked_add(b)
        .filter(|&sum| sum <= isize::MAX as usize)
        .expect(TOO_LONG)
}

pub(crate) const TOO_LONG: &str = "the arrays of a program are longer than any memory";

/// Every item `times` times, one after the other.
pub(crate) fn repeated<T: Copy>(items: &[T], times: usize) -> Vec<T> {
    let each = items
        .iter()
        .flat_map(|&item| std::iter::repeat_n(item, times));
    each.collect()
}
