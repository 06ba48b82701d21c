//! Determinants whose derivatives are right at singular matrices too.

use nalgebra::{Dim, Matrix, RawStorage};

use super::super::element::Element;
use super::super::number::decided;
use crate::math::rounding;
use crate::real::Real;

/// Returns the determinant of a square matrix. Its derivatives are right at every matrix, whatever its rank: they are
/// cofactors, and cofactors of cofactors. nalgebra's own `determinant` is right up to 3 x 3. From 4 x 4 on, and from
/// 2 x 2 on by `lu()` or `full_piv_lu()`, its derivatives are wrong at singular matrices.
///
/// ```
/// use nalgebra::Matrix2;
/// use autodiff::matrices::{Element, determinant};
/// use autodiff::{Var, gradient};
///
/// // The matrix [[0, 1], [0, 2]] is singular. Its cofactors are 2, 0, -1 and 0.
/// let of_rows = |x: &[Var<f64>]| determinant(&Matrix2::from_row_slice(x).map(Element)).0;
/// assert_eq!(gradient(of_rows, &[0.0, 1.0, 0.0, 2.0]), [2.0, 0.0, -1.0, 0.0]);
/// ```
///
/// # Panics
/// If the matrix is not square, or if it is larger than 3 x 3 and SIMD lanes disagree about the largest entry.
#[track_caller]
pub fn determinant<R: Real, M: Dim, N: Dim>(
    matrix: &Matrix<Element<R>, M, N, impl RawStorage<Element<R>, M, N>>,
) -> Element<R> {
    let Eliminated { pivots, rest, sign } = Eliminated::of(matrix);
    let rest = without_division(&rest) * R::lit(sign);
    Element(pivots.into_iter().fold(rest, |product, p| product * p))
}

/// Returns the natural logarithm of the absolute value of the [`determinant`]. It is finite even where the determinant
/// itself overflows. At a singular matrix it is minus infinity or, because of rounding, a large negative number. Its slopes
/// are infinite, very large or NaN there.
///
/// ```
/// use nalgebra::DMatrix;
/// use autodiff::matrices::{Element, log_determinant};
///
/// let large = DMatrix::from_diagonal_element(9, 9, Element(1e100));
/// assert!((log_determinant(&large).0 / 1e100_f64.ln() - 9.0).abs() < 1e-14);
/// ```
///
/// # Panics
/// Like [`determinant`].
#[track_caller]
pub fn log_determinant<R: Real, M: Dim, N: Dim>(
    matrix: &Matrix<Element<R>, M, N, impl RawStorage<Element<R>, M, N>>,
) -> Element<R> {
    let Eliminated { pivots, rest, .. } = Eliminated::of(matrix);
    let zero = R::zero();
    let mut unit = zero;
    for entry in rest.iter().flatten() {
        unit = entry.detach().abs().max(unit);
    }
    // With entries of at most 1, the product neither overflows nor underflows.
    let scales = zero.less(unit) & unit.finite();
    let unit = R::select(scales, unit, R::one());
    let scaled: Vec<Vec<R>> = rest
        .iter()
        .map(|row| row.iter().map(|&x| x / unit).collect())
        .collect();
    let of_rest = unit.ln() * R::lit(rest.len() as f64) + ln_of_size(without_division(&scaled));
    Element(
        pivots
            .into_iter()
            .fold(of_rest, |sum, p| sum + ln_of_size(p)),
    )
}

/// Returns `ln |x|`. The slope at 0 is infinite, while `abs` would make it 0.
fn ln_of_size<R: Real>(x: R) -> R {
    (x * R::select(x.less(0.0), R::lit(-1.0), R::one())).ln()
}

/// A matrix after some steps of elimination. Its determinant is the product of the pivots and of the determinant of the
/// rest, with a sign.
struct Eliminated<R> {
    pivots: Vec<R>,
    rest: Vec<Vec<R>>,
    sign: f64,
}

impl<R: Real> Eliminated<R> {
    /// Each pivot is the largest entry that is left. So first derivatives of the rest never exceed 1, and nothing
    /// cancels in second derivatives of the product. A pivot of 0 has no quotient, and a small one loses the digits of
    /// third derivatives. Therefore elimination ends at the last three rows, or where the rest is rounding noise.
    #[track_caller]
    fn of<M: Dim, N: Dim>(
        matrix: &Matrix<Element<R>, M, N, impl RawStorage<Element<R>, M, N>>,
    ) -> Self {
        let (n, columns) = matrix.shape();
        assert!(
            n == columns,
            "the determinant needs a square matrix, found {n} x {columns}"
        );
        let rows = matrix
            .row_iter()
            .map(|row| row.iter().map(|x| x.0).collect());
        let mut this = Self {
            pivots: Vec::new(),
            rest: rows.collect(),
            sign: 1.0,
        };
        let mut noise = R::zero();
        while this.rest.len() > 3 {
            let (row, column) = this.largest();
            let size = this.rest[row][column].detach().abs();
            if this.pivots.is_empty() {
                noise = size * rounding::epsilon::<R>() * R::lit(n as f64);
            }
            if decided::<R>(size.less_equal(noise)) {
                break;
            }
            this.eliminate(row, column);
        }
        this
    }

    /// Returns the row and the column of the largest entry of the rest.
    fn largest(&self) -> (usize, usize) {
        let (mut at, mut largest) = ((0, 0), R::zero());
        for (i, row) in self.rest.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                let size = entry.detach().abs();
                if decided::<R>(largest.less(size)) {
                    (at, largest) = ((i, j), size);
                }
            }
        }
        at
    }

    fn eliminate(&mut self, row: usize, column: usize) {
        // Moving the pivot to the top left takes `row + column` exchanges of neighbours.
        if (row + column) % 2 == 1 {
            self.sign = -self.sign;
        }
        let mut of_pivot = self.rest.remove(row);
        let pivot = of_pivot.remove(column);
        for row in &mut self.rest {
            let factor = row.remove(column) / pivot;
            for (entry, &above) in row.iter_mut().zip(&of_pivot) {
                *entry -= factor * above;
            }
        }
        self.pivots.push(pivot);
    }
}

/// Returns the determinant without a division, so that every derivative exists: as a sum of products, or by S. J.
/// Berkowitz, "On computing the determinant in small parallel time using a small number of processors", Information
/// Processing Letters 18, 1984.
fn without_division<R: Real>(a: &[Vec<R>]) -> R {
    let of_two = |j: usize, k: usize| a[1][j] * a[2][k] - a[1][k] * a[2][j];
    match a.len() {
        0 => R::one(),
        1 => a[0][0],
        2 => a[0][0] * a[1][1] - a[0][1] * a[1][0],
        3 => a[0][0] * of_two(1, 2) - a[0][1] * of_two(0, 2) + a[0][2] * of_two(0, 1),
        size => {
            let last = characteristic_polynomial(a)[size];
            if size % 2 == 0 { last } else { -last }
        }
    }
}

/// Returns the coefficients of the characteristic polynomial, from the highest power down. Those of a leading submatrix
/// with one more row follow from those of the submatrix before.
fn characteristic_polynomial<R: Real>(a: &[Vec<R>]) -> Vec<R> {
    let mut polynomial = vec![R::one()];
    for (r, row) in a.iter().enumerate() {
        let mut factors = vec![R::one(), -row[r]];
        let mut column: Vec<R> = a[..r].iter().map(|row| row[r]).collect();
        for _ in 0..r {
            factors.push(-R::dot(&row[..r], &column));
            column = a[..r]
                .iter()
                .map(|row| R::dot(&row[..r], &column))
                .collect();
        }
        let coefficient = |i: usize| {
            let terms = (0..=i.min(r)).map(|j| factors[i - j] * polynomial[j]);
            terms.fold(R::zero(), |sum, term| sum + term)
        };
        polynomial = (0..r + 2).map(coefficient).collect();
    }
    polynomial
}
