//! The dense matrix type that drivers return.

use std::ops::Index;

/// A dense matrix, such as a Jacobian or a Hessian. Its entries are stored row by row in one vector.
///
/// `m[i][j]` is an entry and `m[i]` a row. To convert it to a matrix of another crate, write
/// `DMatrix::from_row_slice(m.rows(), m.columns(), m.as_slice())` in nalgebra, `Array2::from_shape_vec((m.rows(),
/// m.columns()), m.into_vec())` in ndarray.
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
    /// Creates a matrix from its entries, row by row.
    ///
    /// # Panics
    /// If `entries` does not have `rows * columns` entries.
    #[track_caller]
    pub fn new(rows: usize, columns: usize, entries: Vec<R>) -> Self {
        let places = rows * columns;
        let count = entries.len();
        assert!(
            count == places,
            "a matrix of {rows} rows and {columns} columns needs {places} entries, found {count}"
        );
        Self {
            rows,
            columns,
            entries,
        }
    }

    /// Creates a matrix from rows of equal length.
    #[cfg(feature = "rayon")]
    #[track_caller]
    pub(crate) fn of_rows(columns: usize, rows: Vec<Vec<R>>) -> Self {
        let count = rows.len();
        Self::new(count, columns, rows.into_iter().flatten().collect())
    }

    /// The number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The number of columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// The rows from first to last.
    pub fn iter(&self) -> impl Iterator<Item = &[R]> {
        (0..self.rows).map(|i| &self[i])
    }

    /// Returns all entries, row by row.
    pub fn as_slice(&self) -> &[R] {
        &self.entries
    }

    /// Returns all entries, row by row.
    pub fn into_vec(self) -> Vec<R> {
        self.entries
    }
}

impl<R> Index<usize> for Dense<R> {
    type Output = [R];
    #[track_caller]
    fn index(&self, row: usize) -> &[R] {
        let rows = self.rows;
        assert!(
            row < rows,
            "row {row} is out of range: the matrix has {rows} rows"
        );
        &self.entries[row * self.columns..][..self.columns]
    }
}

impl<R: PartialEq, const M: usize, const N: usize> PartialEq<[[R; N]; M]> for Dense<R> {
    fn eq(&self, other: &[[R; N]; M]) -> bool {
        (self.rows, self.columns) == (M, N) && self.entries == *other.as_flattened()
    }
}

/// Copies the entries, because nalgebra stores matrices by columns.
#[cfg(feature = "nalgebra")]
impl<R: nalgebra::Scalar> From<Dense<R>> for nalgebra::DMatrix<R> {
    fn from(matrix: Dense<R>) -> Self {
        Self::from_row_iterator(matrix.rows, matrix.columns, matrix.entries)
    }
}
