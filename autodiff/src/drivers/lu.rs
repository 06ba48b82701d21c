//! Factors small dense matrices over any [`Real`] into LU.

use crate::math::rounding::epsilon;
use crate::real::{Mask, Real};

/// The LU factors of a square matrix, computed with scaled partial pivoting: pivots are compared after division by the
/// largest entry of their row. A pivot counts as zero if it is negligible compared with the largest scaled entry of its
/// column. So it does not depend on the units of equations and unknowns whether a matrix counts as singular.
///
/// Rows are exchanged by `select`, because each SIMD lane may need other exchanges. Pivots of duals are compared by
/// their primals.
pub(crate) struct Lu<R: Real> {
    /// The upper factor `U`. Below its diagonal are the entries of the lower factor `L`, whose diagonal consists of
    /// ones and is not stored.
    rows: Vec<Vec<R>>,
    /// The exchanges of rows, in order, as `(k, i, mask)`: rows `k` and `i` were exchanged in those lanes where the
    /// mask is true.
    exchanges: Vec<(usize, usize, R::Mask)>,
}

impl<R: Real> Lu<R> {
    /// Factors the matrix with the given rows. The error is the index of the first column that depends linearly on earlier
    /// columns, to within rounding.
    pub(crate) fn new(mut rows: Vec<Vec<R>>) -> Result<Self, usize> {
        let n = rows.len();
        let largest = |numbers: &[R]| {
            let sizes = numbers.iter().map(|x| x.detach().abs());
            sizes.fold(R::zero(), |largest, size| largest.max(size))
        };
        // A row of zeros gets the scale 1.
        let row_scale = |row: &Vec<R>| {
            let (size, zero) = (largest(row), R::zero());
            R::select(zero.less(size), size, R::one())
        };
        let mut row_scales: Vec<R> = rows.iter().map(row_scale).collect();
        let negligible = |k: usize| {
            let shares = rows.iter().zip(&row_scales);
            let shares = shares.map(|(row, &scale)| row[k] / scale);
            largest(&shares.collect::<Vec<R>>()) * epsilon::<R>() * R::lit(n as f64)
        };
        let negligible: Vec<R> = (0..n).map(negligible).collect();
        let mut exchanges = Vec::with_capacity(n * n / 2);
        for k in 0..n {
            // The largest pivot moves to row `k`, one comparison at a time, because each lane may choose a different
            // row.
            for i in k + 1..n {
                // Quotients are compared, because products across rows could leave the range of floats.
                let [here, there] = [k, i].map(|i| rows[i][k].detach().abs() / row_scales[i]);
                let mask = here.less(there);
                exchange(&mut rows, k, i, mask);
                swap(&mut row_scales, k, i, mask);
                exchanges.push((k, i, mask));
            }
            // A pivot of NaN also counts as zero.
            if !(row_scales[k] * negligible[k]).less(rows[k][k].abs()).all() {
                return Err(k);
            }
            for i in k + 1..n {
                let factor = rows[i][k] / rows[k][k];
                rows[i][k] = factor;
                for j in k + 1..n {
                    let eliminated = factor * rows[k][j];
                    rows[i][j] -= eliminated;
                }
            }
        }
        Ok(Self { rows, exchanges })
    }

    /// Solves `A x = b` in place.
    pub(crate) fn solve(&self, b: &mut [R]) {
        for &(k, i, mask) in &self.exchanges {
            swap(b, k, i, mask);
        }
        let n = b.len();
        for i in 0..n {
            b[i] -= R::dot(&self.rows[i][..i], &b[..i]);
        }
        for i in (0..n).rev() {
            b[i] -= R::dot(&self.rows[i][i + 1..], &b[i + 1..]);
            b[i] /= self.rows[i][i];
        }
    }

    /// Solves `A^T x = b` in place.
    pub(crate) fn solve_transposed(&self, b: &mut [R]) {
        let n = b.len();
        for i in 0..n {
            b[i] /= self.rows[i][i];
            for j in i + 1..n {
                let known = self.rows[i][j] * b[i];
                b[j] -= known;
            }
        }
        for i in (0..n).rev() {
            for j in 0..i {
                let known = self.rows[i][j] * b[i];
                b[j] -= known;
            }
        }
        for &(k, i, mask) in self.exchanges.iter().rev() {
            swap(b, k, i, mask);
        }
    }
}

fn exchange<R: Real>(rows: &mut [Vec<R>], k: usize, i: usize, mask: R::Mask) {
    let (above, below) = rows.split_at_mut(i);
    for (a, b) in above[k].iter_mut().zip(&mut below[0]) {
        (*a, *b) = (R::select(mask, *b, *a), R::select(mask, *a, *b));
    }
}

fn swap<R: Real>(b: &mut [R], k: usize, i: usize, mask: R::Mask) {
    (b[k], b[i]) = (R::select(mask, b[i], b[k]), R::select(mask, b[k], b[i]));
}
