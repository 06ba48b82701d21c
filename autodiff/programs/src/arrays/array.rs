//! Handles to arrays and matrices. They say where in memory the numbers are.

use std::ops::Range;

/// A handle to an array of a [`Program`](crate::Program).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Array {
    pub(crate) id: usize,
    /// True if the array is a parameter; false if it is in a step's row (the memory for all arrays of a step).
    pub(crate) parameter: bool,
    /// The index of the first number: among the parameters, or in the row.
    pub(crate) start: usize,
    /// How many numbers the array has in total, for all starts (initial states) of a batch.
    pub(crate) len: usize,
    pub(crate) starts: usize,
}

impl Array {
    /// The length of the array: how many numbers it has for each start (initial state) of a batch.
    #[track_caller]
    pub fn len(self) -> usize {
        self.len / self.starts
    }

    /// The index of the first number: among the parameters, or in the row.
    #[doc(hidden)]
    pub fn start(self) -> usize {
        self.start
    }

    /// Whether the array is a parameter.
    #[doc(hidden)]
    pub fn is_parameter(self) -> bool {
        self.parameter
    }

    /// Whether the array holds no numbers.
    pub fn is_empty(self) -> bool {
        self.len == 0
    }

    /// The range of the array's indices: among the parameters, or in the row.
    #[doc(hidden)]
    #[inline(always)]
    pub fn range(self) -> Range<usize> {
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
    /// The index among the parameters.
    #[doc(hidden)]
    pub fn parameter(self) -> usize {
        self.parameter
    }

    /// The numbers of rows and columns.
    #[doc(hidden)]
    pub fn shape(self) -> [usize; 2] {
        [self.rows, self.columns]
    }

    /// The number of entries.
    #[track_caller]
    pub(crate) fn len(self) -> usize {
        self.rows.checked_mul(self.columns).expect(TOO_LONG)
    }
}

/// The declared shape of a parameter.
#[allow(missing_docs)] // Only `cosmic-gpu` reads it.
#[derive(Clone, Copy, Debug)]
pub enum Parameter {
    Array(Array),
    Matrix(Matrix),
    /// A control, given by its index in `Program::controls`.
    Control(usize),
}

/// Adds two positions in a step's row. Panics on overflow, because loads without bounds checks rely on the sum.
#[track_caller]
pub(crate) fn checked_sum(a: usize, b: usize) -> usize {
    a.checked_add(b)
        .filter(|&sum| sum <= isize::MAX as usize)
        .expect(TOO_LONG)
}

pub(crate) const TOO_LONG: &str =
    "the arrays of the program are too long: their total length overflows";

/// Repeats every item `times` times.
pub(crate) fn repeated<T: Copy>(items: &[T], times: usize) -> Vec<T> {
    let each = items
        .iter()
        .flat_map(|&item| std::iter::repeat_n(item, times));
    each.collect()
}
