//! The dense matrices that drivers return.

use std::ops::Index;

/// A dense matrix, row by row in one vector: a Jacobian or a Hessian.
///
/// `m[i][j]` is an entry and `m[i]` a row. [`as_slice`](Self::as_slice) is what other crates' matrices
/// are made of: `DMatrix::from_row_slice(m.rows(), m.columns(), m.as_slice())` in nalgebra, and
/// `Array2::from_shape_vec((m.rows(), m.columns()), m.into_vec())` in ndarray.
///
/// ```
/// use autodiff::{Dense, jacobian};
///
/// let m: Dense<f64> = jacobian(|x| vec![x[0] * x[1], x[0] - x[1]], &[2.0, 3.0]);
/// assert_eq!((m.rows(), m.columns()), (2, 2));
/// assert_eq!(m, [[3.0, 2.0], [1.0, -1.0]]);
/// assert_eq!((m[0][1], &m[1]), (2.0, &[1.0, -1.0][..]));
/// assert_eq!(m.as_slice(), [3.0, 2.0, 1.0, -1.0]);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Dense<R> {
    rows: usize,
    columns: usize,
    entries: Vec<R>,
}

impl<R> Dense<R> {
    /// A matrix of these entries, row by row.
    ///
    /// # Panics
    /// If their number is not that of the places.
    pub fn new(rows: usize, columns: usize, entries: Vec<R>) -> Self {
        let places = rows * columns;
        let count = entries.len();
        assert!(
            count == places,
            "a matrix of {rows} rows and {columns} columns has {places} entries, not {count}"
        );
        Self {
            rows,
            columns,
            entries,
        }
    }

    /// A matrix of rows of one length.
    pub(crate) fn of_rows(columns: usize, rows: Vec<Vec<R>>) -> Self {
        let count = rows.len();
        Self::new(count, columns, rows.into_iter().flatten().collect())
    }

    /// How many rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// How many columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// The rows from first to last.
    pub fn iter(&self) -> impl Iterator<Item = &[R]> {
        (0..self.rows).map(|i| &self[i])
    }

    /// All entries, row by row.
    pub fn as_slice(&self) -> &[R] {
        &self.entries
    }

    /// All entries, row by row.
    pub fn into_vec(self) -> Vec<R> {
        self.entries
    }
}

impl<R> Index<usize> for Dense<R> {
    type Output = [R];
    fn index(&self, row: usize) -> &[R] {
        let rows = self.rows;
        assert!(row < rows, "there is no row {row} in a matrix of {rows}");
        &self.entries[row * self.columns..][..self.columns]
    }
}

impl<R: PartialEq, const M: usize, const N: usize> PartialEq<[[R; N]; M]> for Dense<R> {
    fn eq(&self, other: &[[R; N]; M]) -> bool {
        (self.rows, self.columns) == (M, N) && self.entries == *other.as_flattened()
    }
}

/// Row by row, as nalgebra lays out none of its own.
#[cfg(feature = "nalgebra")]
impl<R: nalgebra::Scalar> From<Dense<R>> for nalgebra::DMatrix<R> {
    fn from(matrix: Dense<R>) -> Self {
        Self::from_row_iterator(matrix.rows, matrix.columns, matrix.entries)
    }
}
