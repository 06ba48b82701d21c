//! Solutions of linear equations and inverses, which are refused where the primal is singular.

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, Matrix, OMatrix, RawStorage};

use super::super::element::Element;
use crate::drivers::lu::Lu;
use crate::real::Real;

/// Solves `A X = B` for `X`, where `A` is a square matrix and `B` has as many rows. Returns `None` if the primal of `A` is
/// singular to within rounding, where nalgebra's own `solve` divides by zero.
///
/// ```
/// use nalgebra::{Matrix2, Vector2};
/// use autodiff::matrices::{Element, solve};
/// use autodiff::{Var, gradient};
///
/// let load = Vector2::new(1.0, 2.0).map(Element::<Var<f64>>::lit);
/// let of_rows = |x: &[Var<f64>]| solve(&Matrix2::from_row_slice(x).map(Element), &load);
/// // x = 1 / a for A = [[a, 0], [0, 1]].
/// let slopes = gradient(|x| of_rows(x).expect("a regular matrix")[0].0, &[2.0, 0.0, 0.0, 1.0]);
/// assert_eq!(slopes, [-0.25, -1.0, 0.0, 0.0]);
/// gradient(|x| { assert!(of_rows(x).is_none()); x[0] }, &[1.0, 2.0, 2.0, 4.0]);
/// ```
///
/// # Panics
/// If `A` is not square, or if `A` and `B` differ in their number of rows.
#[track_caller]
pub fn solve<R: Real, D: Dim, N: Dim>(
    matrix: &Matrix<Element<R>, D, D, impl RawStorage<Element<R>, D, D>>,
    right: &Matrix<Element<R>, D, N, impl RawStorage<Element<R>, D, N>>,
) -> Option<OMatrix<Element<R>, D, N>>
where
    DefaultAllocator: Allocator<D, N>,
{
    let factors = factors(matrix)?;
    let (rows, columns) = right.shape_generic();
    assert_eq!(
        matrix.nrows(),
        rows.value(),
        "solve: the matrix and the right side differ in their number of rows"
    );
    let mut solution = Vec::with_capacity(rows.value() * columns.value());
    for column in right.column_iter() {
        let first = solution.len();
        solution.extend(column.iter().map(|x| x.0));
        factors.solve(&mut solution[first..]);
    }
    let entries = solution.into_iter().map(Element);
    Some(OMatrix::from_iterator_generic(rows, columns, entries))
}

/// Returns the inverse of a square matrix, or `None` if its primal is singular to within rounding. nalgebra's own
/// `try_inverse` divides by zero where the matrix carries derivatives.
///
/// ```
/// use nalgebra::Matrix1;
/// use autodiff::matrices::{Element, inverse};
/// use autodiff::Dual;
///
/// let [two, zero] = [2.0, 0.0].map(|x| Matrix1::new(Element(Dual::<f64, 1>::variable(x, 0))));
/// assert_eq!(inverse(&two).expect("a regular matrix")[0].0.tangent, [-0.25]);
/// assert!(inverse(&zero).is_none());
/// ```
///
/// # Panics
/// If the matrix is not square.
#[track_caller]
pub fn inverse<R: Real, D: Dim>(
    matrix: &Matrix<Element<R>, D, D, impl RawStorage<Element<R>, D, D>>,
) -> Option<OMatrix<Element<R>, D, D>>
where
    DefaultAllocator: Allocator<D, D>,
{
    let (rows, columns) = matrix.shape_generic();
    solve(matrix, &OMatrix::identity_generic(rows, columns))
}

/// Returns the LU factors, or `None` if the primal is singular.
#[track_caller]
fn factors<R: Real, D: Dim>(
    matrix: &Matrix<Element<R>, D, D, impl RawStorage<Element<R>, D, D>>,
) -> Option<Lu<R>> {
    let (rows, columns) = matrix.shape();
    assert_eq!(
        rows, columns,
        "only a square matrix has an inverse, found {rows} x {columns}"
    );
    let rows = matrix
        .row_iter()
        .map(|row| row.iter().map(|x| x.0).collect());
    Lu::new(rows.collect()).ok()
}
