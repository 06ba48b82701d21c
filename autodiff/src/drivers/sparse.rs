//! Computes sparse Jacobians: columns that have no row in common are computed together.
//!
//! Two columns without entries in a common row can share a forward direction, because each entry of the result then
//! belongs to only one of them. So the columns are coloured such that columns with a common row have different colours.
//! The whole Jacobian then takes one forward direction for each colour (A. R. Curtis, M. J. D. Powell and J. K. Reid,
//! "On the estimation of sparse Jacobian matrices", IMA Journal of Applied Mathematics 13, 1974). A tridiagonal
//! Jacobian of any size takes three directions.

use super::dense::Dense;
use super::gradient::gradient;
use super::jacobian::vjp;
use super::seed::CHUNK;
pub use super::undecided::Undecided;
use crate::constant::printed;
use crate::dual::Dual;
use crate::math::rounding::epsilon;
use crate::real::{Mask, Real};
use crate::reverse::{Var, keep_tape, recorded};

/// The sparsity pattern of a Jacobian, with a colouring of its columns.
///
/// Create it once for a function and use it at every point. The pattern, together with the list of entries, is a matrix
/// in the compressed sparse row format (CSR).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern {
    /// For each row, the index in `columns` at which the row begins. The last number is the number of all entries.
    starts: Vec<usize>,
    /// The columns of all entries, row by row.
    columns: Vec<usize>,
    color_of_column: Vec<usize>,
    colors: usize,
}

impl Pattern {
    /// Creates a pattern with the given number of columns. Each row lists the columns of its entries in ascending
    /// order.
    ///
    /// # Panics
    /// If a row's columns are out of range or do not ascend.
    #[track_caller]
    pub fn new(columns: usize, rows: &[Vec<usize>]) -> Self {
        let mut starts = vec![0];
        for (i, row) in rows.iter().enumerate() {
            let ascends = row.windows(2).all(|pair| pair[0] < pair[1]);
            let fits = row.last().is_none_or(|&last| last < columns);
            assert!(
                ascends && fits,
                "row {i} of a pattern: its columns must ascend and be less than {columns}"
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

    /// Creates the pattern of a square band matrix: the main diagonal, `below` diagonals below it and `above` diagonals
    /// above it.
    pub fn banded(size: usize, below: usize, above: usize) -> Self {
        let row = |i: usize| {
            (i.saturating_sub(below)..i.saturating_add(above).saturating_add(1).min(size)).collect()
        };
        Self::new(size, &(0..size).map(row).collect::<Vec<_>>())
    }

    /// Creates a pattern of dense blocks along the diagonal. Each block has a shape `[rows, columns]`.
    pub fn blocks(shapes: &[[usize; 2]]) -> Self {
        let (mut rows, mut first) = (Vec::new(), 0);
        for &[height, width] in shapes {
            let row: Vec<usize> = (first..first + width).collect();
            rows.extend(std::iter::repeat_n(row, height));
            first += width;
        }
        Self::new(first, &rows)
    }

    /// Returns the pattern of a function's Jacobian, which it reads off a recording at `x`. A value has an entry for
    /// every argument that its operations use, even if the derivative is zero. Of a choice by `select`, `max`, `min` or
    /// `clamp`, both operands count.
    ///
    /// So the pattern is right at every point, unless the function branches on values in another way, such as an `if` or
    /// a loop on [`primal`](Real::primal). Then it is right where the function takes the same branches as at `x`.
    ///
    /// Entries of operands that are rarely chosen may cost more [colours](Self::colors), and thus more directions. If
    /// you know which operands are chosen at all your points, list their entries alone, by [`new`](Self::new).
    ///
    /// ```
    /// use autodiff::Real;
    /// use autodiff::sparse::Pattern;
    ///
    /// let pattern = Pattern::traced(|x| vec![x[0] * x[2], x[1].max(x[2])], &[0.0, 5.0, 0.0]);
    /// assert_eq!(pattern, Pattern::new(3, &[vec![0, 2], vec![1, 2]]));
    /// ```
    #[track_caller]
    pub fn traced(
        function: impl FnOnce(&[Var<Undecided>]) -> Vec<Var<Undecided>>,
        x: &[f64],
    ) -> Self {
        let (tape, y) = recorded(function, &Undecided::lits(x));
        let rows = tape.dependence(&y);
        keep_tape(tape);
        Self::new(x.len(), &rows)
    }

    /// Returns the pattern of the function's Hessian, which it reads off a recording of the gradient at `x`. See
    /// [`traced`](Self::traced).
    #[track_caller]
    pub fn traced_hessian(
        function: impl FnOnce(&[Var<Var<Undecided>>]) -> Var<Var<Undecided>>,
        x: &[f64],
    ) -> Self {
        // The cotangent of the function's value is another variable. If it were a constant, so would be the zero that an
        // operand gets which is not chosen here, and a sweep stops at a constant zero.
        let slopes = |x: &[Var<Undecided>]| {
            let (cotangent, x) = x.split_last().expect("the cotangent");
            vjp(|x| vec![function(x)], x, &[*cotangent]).1
        };
        let traced = Self::traced(slopes, &[x, &[1.0]].concat());
        let row = |i| {
            let columns = traced.row(i).iter().copied();
            columns.filter(|&j| j < x.len()).collect()
        };
        let rows: Vec<_> = (0..traced.rows()).map(row).collect();
        Self::new(x.len(), &rows)
    }

    /// The number of rows.
    pub fn rows(&self) -> usize {
        self.starts.len() - 1
    }

    /// The number of columns.
    pub fn columns(&self) -> usize {
        self.color_of_column.len()
    }

    /// The columns of the entries in row `i`.
    ///
    /// # Panics
    /// If there is no such row.
    #[track_caller]
    pub fn row(&self, i: usize) -> &[usize] {
        &self.columns[self.starts[i]..self.starts[i + 1]]
    }

    /// The row pointers of CSR: for each row the index of its first entry, and at the end the number of all entries.
    /// [`sparse_jacobian`] returns the entries themselves.
    pub fn row_starts(&self) -> &[usize] {
        &self.starts
    }

    /// The column indices of CSR: the column of each entry, row by row.
    pub fn column_indices(&self) -> &[usize] {
        &self.columns
    }

    /// The number of entries.
    pub fn entries(&self) -> usize {
        self.columns.len()
    }

    /// The number of colours. A Jacobian takes one forward direction for each colour.
    pub fn colors(&self) -> usize {
        self.colors
    }

    /// Returns the dense matrix with the given entries, which are in the order of the pattern.
    ///
    /// # Panics
    /// If there is not one number per entry.
    #[track_caller]
    pub fn to_dense<R: Real>(&self, entries: &[R]) -> Dense<R> {
        assert_eq!(
            entries.len(),
            self.entries(),
            "`to_dense` needs one number for each entry of the pattern"
        );
        let mut dense = vec![R::zero(); self.rows() * self.columns()];
        for i in 0..self.rows() {
            for place in self.starts[i]..self.starts[i + 1] {
                dense[i * self.columns() + self.columns[place]] = entries[place];
            }
        }
        Dense::new(self.rows(), self.columns(), dense)
    }

    /// The number of forward directions that a Jacobian takes: one for each colour, and the test direction.
    pub(crate) fn directions(&self) -> usize {
        self.colors + 1
    }

    /// The index of the test direction among the [`CHUNK`] directions that begin with direction `first`; `None` if it
    /// is not among them. The test direction comes after the directions of all colours.
    fn test_slot(&self, first: usize) -> Option<usize> {
        let slot = self.colors.checked_sub(first);
        slot.filter(|&slot| slot < CHUNK)
    }

    /// # Panics
    /// If there is not one argument per column. The drivers call this before their first pass, so that the message names
    /// the line of their caller: a closure does not pass it on.
    #[track_caller]
    pub(crate) fn check_arguments(&self, arguments: usize) {
        assert_eq!(
            arguments,
            self.columns(),
            "a sparse Jacobian needs one argument per column of its pattern"
        );
    }

    /// Returns `x` as dual numbers with tangents along the [`CHUNK`] directions that begin with direction `first`.
    pub(crate) fn along_directions<R: Real>(&self, x: &[R], first: usize) -> Vec<Dual<R, CHUNK>> {
        let (chunk, test) = (first..first + CHUNK, self.test_slot(first));
        let seed = |(j, &value): (usize, &R)| {
            let mut dual = Dual::constant(value);
            let color = self.color_of_column[j];
            if chunk.contains(&color) {
                dual.tangent[color - first] = R::one();
            }
            if let Some(slot) = test {
                dual.tangent[slot] = R::lit(test_direction(j));
            }
            dual
        };
        x.iter().enumerate().map(seed).collect()
    }

    /// Returns the entries of the Jacobian. Each item of `passes` is the function's values at the arguments that
    /// [`along_directions`](Self::along_directions) returned for that pass.
    #[track_caller]
    pub(crate) fn decompressed<R: Real>(
        &self,
        passes: &mut dyn Iterator<Item = Vec<Dual<R, CHUNK>>>,
    ) -> Vec<R> {
        let mut entries = vec![R::zero(); self.entries()];
        for (pass, y) in passes.enumerate() {
            self.decompress(pass * CHUNK, &y, &mut entries);
        }
        entries
    }

    /// Writes the entries of the colours from `first` on, which one pass has computed.
    #[track_caller]
    fn decompress<R: Real>(&self, first: usize, y: &[Dual<R, CHUNK>], entries: &mut [R]) {
        assert_eq!(
            y.len(),
            self.rows(),
            "a sparse Jacobian needs one value per row of its pattern"
        );
        for (i, y) in y.iter().enumerate() {
            self.decompress_row(i, y, first, entries);
        }
        // All entries are known here, because the test direction belongs to the last pass.
        if let Some(slot) = self.test_slot(first) {
            self.test(y.iter().map(|y| y.tangent[slot]), entries);
        }
    }

    /// Writes the entries of row `i` whose colours belong to this pass.
    #[track_caller]
    fn decompress_row<R: Real>(
        &self,
        i: usize,
        y: &Dual<R, CHUNK>,
        first: usize,
        entries: &mut [R],
    ) {
        let mut rest = y.tangent;
        if let Some(slot) = self.test_slot(first) {
            rest[slot] = R::zero();
        }
        for place in self.starts[i]..self.starts[i + 1] {
            let color = self.color_of_column[self.columns[place]];
            if (first..first + CHUNK).contains(&color) {
                entries[place] = std::mem::replace(&mut rest[color - first], R::zero());
            }
        }
        assert!(
            rest.iter().all(R::is_zero),
            "value {i} depends on an argument that its row of the pattern leaves out; add its column to the row"
        );
    }

    /// Panics if the pattern lacks an entry. For each value, the derivative along the test direction must agree with
    /// the derivative that follows from the entries.
    #[track_caller]
    fn test<R: Real>(&self, along: impl Iterator<Item = R>, entries: &[R]) {
        // Where terms cancel inside the function, rounding errors are larger than an epsilon. A missing entry is about
        // as large as the other entries.
        let share = epsilon::<R>().cbrt();
        let largest = entries
            .iter()
            .fold(R::zero(), |m, e| m.max(e.detach().abs()));
        for (i, along) in along.enumerate() {
            let (mut sum, mut size) = (R::zero(), largest * epsilon::<R>());
            for place in self.starts[i]..self.starts[i + 1] {
                let term = entries[place].detach() * R::lit(test_direction(self.columns[place]));
                sum += term;
                size += term.abs();
            }
            let off = (along.detach() - sum).abs();
            let wrong = (share * size).less(off) & off.finite();
            assert!(
                !wrong.any(),
                "value {i} depends on an argument that its row of the pattern leaves out: along a test \
                 direction its derivative is {}, but the entries of the pattern give {}",
                printed(along),
                printed(sum)
            );
        }
    }
}

/// Returns entry `j` of the test direction. The entries are numbers between 1 and 2 without a regular pattern.
fn test_direction(j: usize) -> f64 {
    1.0 + ((j + 1) as f64 * 0.618033988749895).fract()
}

/// Colours the columns greedily, from the first to the last. Each column gets the smallest colour that no earlier
/// column in one of its rows has. For banded and block patterns the number of colours is the smallest possible.
fn colored(columns: usize, rows: &[Vec<usize>]) -> Vec<usize> {
    let mut rows_of_column = vec![Vec::new(); columns];
    for (i, row) in rows.iter().enumerate() {
        for &j in row {
            rows_of_column[j].push(i);
        }
    }
    let mut color_of_column = vec![usize::MAX; columns];
    // For each colour, the last column that could not get this colour. No reset is needed, because the columns differ.
    let mut unfit_for = vec![usize::MAX; columns];
    for j in 0..columns {
        let neighbours = rows_of_column[j].iter().flat_map(|&i| &rows[i]);
        for &neighbour in neighbours.filter(|&&neighbour| neighbour < j) {
            unfit_for[color_of_column[neighbour]] = j;
        }
        let fit = unfit_for.iter().position(|&column| column != j);
        color_of_column[j] =
            fit.expect("a colour is free, because there are fewer earlier columns than colours");
    }
    color_of_column
}

/// Returns the entries of a sparse Jacobian in the order of its pattern, row by row. It takes one forward direction for
/// each colour, and one more as a test.
///
/// ```
/// use autodiff::Real;
/// use autodiff::sparse::{Pattern, sparse_jacobian};
///
/// /// A chain: each value depends on its neighbours.
/// fn chain<R: Real>(x: &[R]) -> Vec<R> {
///     let at = |i: usize| x.get(i).copied().unwrap_or(R::zero());
///     (0..x.len()).map(|i| at(i).powi(2) - at(i.wrapping_sub(1)) * at(i + 1)).collect()
/// }
///
/// let pattern = Pattern::banded(1000, 1, 1);
/// assert_eq!(pattern.colors(), 3);
/// let x: Vec<f64> = (0..1000).map(f64::from).collect();
/// let entries = sparse_jacobian(chain, &x, &pattern);
/// assert_eq!(entries.len(), 2998);
/// assert_eq!(entries[2..5], [-2.0, 2.0, 0.0]); // row 1: by x[0], x[1], x[2]
/// ```
///
/// # Panics
/// If the lengths of `x` or of the values do not match the pattern, or if a value depends on an argument that the
/// pattern leaves out. To find such an argument, the derivative along a test direction is compared with the entries. A
/// missing entry that is smaller than about 1e-5 of its row may not be noticed. If `x` belongs to an outer tape, the
/// pattern must also have the entries whose terms cancel to zero, because their derivatives may not cancel.
#[track_caller]
pub fn sparse_jacobian<R: Real>(
    function: impl Fn(&[Dual<R, CHUNK>]) -> Vec<Dual<R, CHUNK>>,
    x: &[R],
    pattern: &Pattern,
) -> Vec<R> {
    pattern.check_arguments(x.len());
    let passes = (0..pattern.directions()).step_by(CHUNK);
    pattern.decompressed(&mut passes.map(|first| function(&pattern.along_directions(x, first))))
}

/// Returns the entries of a sparse Hessian in the order of its pattern, row by row. It is the [`sparse_jacobian`] of
/// the gradient, so it uses forward mode over reverse mode.
///
/// ```
/// use autodiff::Real;
/// use autodiff::sparse::{Pattern, sparse_hessian};
///
/// /// The energy of a chain of springs.
/// fn chain<R: Real>(x: &[R]) -> R {
///     x.windows(2).map(|x| (x[1] - x[0] - R::one()).powi(2)).sum()
/// }
///
/// let x: Vec<f64> = (0..1000).map(f64::from).collect();
/// let pattern = Pattern::traced_hessian(chain, &x);
/// assert_eq!(pattern, Pattern::banded(1000, 1, 1));
/// assert_eq!(sparse_hessian(chain, &x, &pattern)[2..5], [-2.0, 4.0, -2.0]);
/// ```
///
/// # Panics
/// Like [`sparse_jacobian`].
#[track_caller]
pub fn sparse_hessian<R: Real>(
    function: impl Fn(&[Var<Dual<R, CHUNK>>]) -> Var<Dual<R, CHUNK>>,
    x: &[R],
    pattern: &Pattern,
) -> Vec<R> {
    pattern.check_arguments(x.len());
    let mut entries = vec![R::zero(); pattern.entries()];
    for first in (0..pattern.directions()).step_by(CHUNK) {
        let slopes = gradient(&function, &pattern.along_directions(x, first));
        pattern.decompress(first, &slopes, &mut entries);
    }
    entries
}
