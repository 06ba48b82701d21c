//! Sparse Jacobians: columns that share no row are computed together.
//!
//! Two columns without entries in a common row can share a forward direction: each row of the result
//! then belongs to one of them. Once the columns are coloured so that any two with a common row
//! differ, the whole Jacobian takes as many directions as there are colours (A. R. Curtis, M. J. D.
//! Powell and J. K. Reid, "On the estimation of sparse Jacobian matrices", IMA Journal of Applied
//! Mathematics 13, 1974). A tridiagonal one of any size takes three.

use super::jacobian::{VectorFunction, jacobian};
use super::seed::{CHUNK, seeded_along};
use crate::dual::Dual;
use crate::real::Real;

/// Which entries of a Jacobian may differ from zero, and a colouring of its columns.
///
/// Make it once for a function and use it for every point.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern {
    /// Where each row's entries begin in `columns`, and the end.
    starts: Vec<usize>,
    /// The columns of all entries, row by row.
    columns: Vec<usize>,
    color_of_column: Vec<usize>,
    colors: usize,
}

impl Pattern {
    /// A pattern with this number of columns, from the columns of each row's entries, ascending.
    ///
    /// # Panics
    /// If a row's columns are out of range or do not ascend.
    pub fn new(columns: usize, rows: &[Vec<usize>]) -> Self {
        let mut starts = vec![0];
        for (i, row) in rows.iter().enumerate() {
            let ascends = row.windows(2).all(|pair| pair[0] < pair[1]);
            let fits = row.last().is_none_or(|&last| last < columns);
            assert!(
                ascends && fits,
                "row {i} of a pattern: its columns must ascend below {columns}"
            );
            starts.push(starts[i] + row.len());
        }
        let color_of_column = colored(columns, rows);
        let colors = color_of_column.iter().max().map_or(0, |last| last + 1);
        Self {
            starts,
            columns: rows.concat(),
            color_of_column,
            colors,
        }
    }

    /// A square pattern with the main diagonal, `below` diagonals under it and `above` over it.
    pub fn banded(size: usize, below: usize, above: usize) -> Self {
        let row = |i: usize| {
            (i.saturating_sub(below)..i.saturating_add(above).saturating_add(1).min(size)).collect()
        };
        Self::new(size, &(0..size).map(row).collect::<Vec<_>>())
    }

    /// Dense blocks along the diagonal, of shapes `[rows, columns]`.
    pub fn blocks(shapes: &[[usize; 2]]) -> Self {
        let (mut rows, mut first) = (Vec::new(), 0);
        for &[height, width] in shapes {
            let row: Vec<usize> = (first..first + width).collect();
            rows.extend(std::iter::repeat_n(row, height));
            first += width;
        }
        Self::new(first, &rows)
    }

    /// The entries that are not zero at `x`, by one dense Jacobian.
    ///
    /// It serves other points only if no entry vanishes just here: take an `x` without zeros and equal
    /// numbers, on the side of every kink on which the pattern will be used. Where the sparse Jacobian is itself
    /// differentiated, entries whose terms cancel everywhere belong to the pattern too, and are not
    /// found by values: use [`Pattern::new`].
    pub fn probed(function: &impl VectorFunction, x: &[f64]) -> Self {
        let filled = |row: Vec<f64>| (0..x.len()).filter(|&j| row[j] != 0.0).collect();
        let rows: Vec<Vec<usize>> = jacobian(function, x).into_iter().map(filled).collect();
        Self::new(x.len(), &rows)
    }

    /// How many rows.
    pub fn rows(&self) -> usize {
        self.starts.len() - 1
    }

    /// How many columns.
    pub fn columns(&self) -> usize {
        self.color_of_column.len()
    }

    /// The columns of the entries in row `i`.
    ///
    /// # Panics
    /// If there is no such row.
    pub fn row(&self, i: usize) -> &[usize] {
        &self.columns[self.starts[i]..self.starts[i + 1]]
    }

    /// How many entries.
    pub fn entries(&self) -> usize {
        self.columns.len()
    }

    /// How many forward directions a Jacobian takes.
    pub fn colors(&self) -> usize {
        self.colors
    }

    /// The dense matrix, row by row, of entries in the order of the pattern.
    ///
    /// # Panics
    /// If there is not one number per entry.
    pub fn to_dense<R: Real>(&self, entries: &[R]) -> Vec<Vec<R>> {
        assert_eq!(
            entries.len(),
            self.entries(),
            "one number per entry of the pattern is needed"
        );
        let row = |i: usize| {
            let mut row = vec![R::zero(); self.columns()];
            for (&j, &entry) in self.row(i).iter().zip(&entries[self.starts[i]..]) {
                row[j] = entry;
            }
            row
        };
        (0..self.rows()).map(row).collect()
    }

    /// `x` with the columns of the [`CHUNK`] colours from `first` on moving, each colour along a
    /// direction of its own.
    pub(crate) fn seeded<R: Real>(&self, x: &[R], first: usize) -> Vec<Dual<R, CHUNK>> {
        assert_eq!(
            x.len(),
            self.columns(),
            "a sparse Jacobian needs one argument per column of its pattern"
        );
        seeded_along(x, self.color_of_column.iter().copied(), first)
    }

    /// Writes the entries of these colours, from the values at [`seeded`](Self::seeded) arguments.
    pub(crate) fn decompress<R: Real>(
        &self,
        y: &[Dual<R, CHUNK>],
        first: usize,
        entries: &mut [R],
    ) {
        assert_eq!(
            y.len(),
            self.rows(),
            "a sparse Jacobian needs one value per row of its pattern"
        );
        for (i, y) in y.iter().enumerate() {
            let mut rest = y.tangent;
            for place in self.starts[i]..self.starts[i + 1] {
                let color = self.color_of_column[self.columns[place]];
                if (first..first + CHUNK).contains(&color) {
                    entries[place] = std::mem::replace(&mut rest[color - first], R::zero());
                }
            }
            assert!(
                rest.iter().all(R::is_zero),
                "value {i} depends on an argument that its row of the pattern leaves out"
            );
        }
    }
}

/// Greedy colouring from the first column to the last: each takes the smallest colour that no earlier
/// column with a common row has. For banded and block patterns that is optimal.
fn colored(columns: usize, rows: &[Vec<usize>]) -> Vec<usize> {
    let mut rows_of_column = vec![Vec::new(); columns];
    for (i, row) in rows.iter().enumerate() {
        for &j in row {
            rows_of_column[j].push(i);
        }
    }
    let mut color_of_column = vec![usize::MAX; columns];
    // For each colour the column that it was last found unfit for: never cleared between columns.
    let mut unfit_for = vec![usize::MAX; columns];
    for j in 0..columns {
        let neighbours = rows_of_column[j].iter().flat_map(|&i| &rows[i]);
        for &neighbour in neighbours.filter(|&&neighbour| neighbour < j) {
            unfit_for[color_of_column[neighbour]] = j;
        }
        let fit = unfit_for.iter().position(|&column| column != j);
        color_of_column[j] = fit.expect("fewer earlier columns than colours");
    }
    color_of_column
}

/// The entries of a sparse Jacobian in the order of its pattern, row by row: one forward direction
/// per colour.
///
/// ```
/// use autodiff::sparse::{Pattern, sparse_jacobian};
/// use autodiff::{Real, VectorFunction};
///
/// /// Each value by its neighbours: a chain.
/// struct Chain;
/// impl VectorFunction for Chain {
///     fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
///         let at = |i: usize| x.get(i).copied().unwrap_or(R::zero());
///         (0..x.len()).map(|i| at(i).powi(2) - at(i.wrapping_sub(1)) * at(i + 1)).collect()
///     }
/// }
///
/// let pattern = Pattern::banded(1000, 1, 1);
/// assert_eq!(pattern.colors(), 3);
/// let x: Vec<f64> = (0..1000).map(f64::from).collect();
/// let entries = sparse_jacobian(&Chain, &x, &pattern);
/// assert_eq!(entries.len(), 2998);
/// assert_eq!(entries[2..5], [-2.0, 2.0, 0.0]); // row 1: by x[0], x[1], x[2]
/// ```
///
/// # Panics
/// If lengths differ from the pattern's, or if a value turns out to depend on an argument that the
/// pattern leaves out. That is noticed only where the row has no entry of the same colour, to which it
/// would be added: compare a new pattern with [`jacobian`] once. Under an outer tape an entry counts as
/// a dependence even where its terms cancel to zero, because their derivatives need not cancel.
pub fn sparse_jacobian<R: Real>(
    function: &impl VectorFunction,
    x: &[R],
    pattern: &Pattern,
) -> Vec<R> {
    let mut entries = vec![R::zero(); pattern.entries()];
    for first in (0..pattern.colors()).step_by(CHUNK) {
        let y = function.eval(&pattern.seeded(x, first));
        pattern.decompress(&y, first, &mut entries);
    }
    entries
}
