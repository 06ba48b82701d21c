//! Sparse Jacobians: columns that share no row are computed together.
//!
//! Two columns whose entries stand in different rows can move at once: each row of the result then
//! belongs to one of them. Colouring the columns so that any two with a common row differ, a whole
//! Jacobian takes as many forward directions as there are colours (Curtis, Powell and Reid 1974).
//! A tridiagonal one takes three, of whatever size.

use crate::drivers::{CHUNK, VectorFunction, jacobian};
use crate::forward::Dual;
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
    /// A pattern of so many columns from the columns of each row's entries, ascending.
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

    /// A square pattern of so many diagonals below and above the main one.
    pub fn banded(size: usize, below: usize, above: usize) -> Self {
        let row = |i: usize| {
            (i.saturating_sub(below)..i.saturating_add(above).saturating_add(1).min(size)).collect()
        };
        Self::new(size, &(0..size).map(row).collect::<Vec<_>>())
    }

    /// Dense blocks of `[rows, columns]` along the diagonal.
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
    /// A pattern for other points only if no entry vanishes just here: take `x` without zeros and
    /// coincidences, on the branch of every kink that will be used. Where the sparse Jacobian is itself
    /// differentiated, entries whose terms cancel everywhere belong to the pattern too: write it out.
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

    /// The columns of a row's entries.
    pub fn row(&self, i: usize) -> &[usize] {
        &self.columns[self.starts[i]..self.starts[i + 1]]
    }

    /// How many entries.
    pub fn entries(&self) -> usize {
        self.columns.len()
    }

    /// How many directions a Jacobian takes.
    pub fn colors(&self) -> usize {
        self.colors
    }

    /// The matrix of these entries, zeros included.
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

    /// `x`, whose columns of colour `first` and the next few each move along a direction.
    pub(crate) fn seeded<R: Real>(&self, x: &[R], first: usize) -> Vec<Dual<R, CHUNK>> {
        assert_eq!(
            x.len(),
            self.columns(),
            "a sparse Jacobian needs one argument per column of its pattern"
        );
        let seed = |(&value, &color)| {
            if (first..first + CHUNK).contains(&color) {
                Dual::variable(value, color - first)
            } else {
                Dual::constant(value)
            }
        };
        x.iter().zip(&self.color_of_column).map(seed).collect()
    }

    /// Takes the entries of these colours out of the values of [`seeded`](Self::seeded) arguments.
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

/// The smallest colour for each column that no earlier one with a common row has. In this order
/// banded and block patterns get the fewest possible.
fn colored(columns: usize, rows: &[Vec<usize>]) -> Vec<usize> {
    let mut rows_of_column = vec![Vec::new(); columns];
    for (i, row) in rows.iter().enumerate() {
        for &j in row {
            rows_of_column[j].push(i);
        }
    }
    let mut color_of_column = vec![usize::MAX; columns];
    // The column that a colour was last found unfit for.
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
/// pattern leaves out. That is noticed only where no other argument of the same colour covers it:
/// hold a new pattern against [`jacobian`] once. On a tape an entry of a row stands in the pattern even
/// where it is zero, by terms that cancel: its derivative need not be.
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
